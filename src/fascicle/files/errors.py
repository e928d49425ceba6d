"""Errors of a file in one line: path, key, the value as written, the rule.

The laws refuse invalid arguments by the argument's name. A `FileLocation` turns that into the
file's error, with the key of the argument.
"""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from ..core.errors import InvalidInputError
from ..muscle.laws import LAWS
from ..muscle.materials import MooneyRivlin
from ..table_model import location_message, validation_message, value_at


# keys of a constructor's arguments, where they differ from the arguments' names
_KEYS: dict[str, dict[str, tuple[str, ...]]] = {
    "muscle": {
        "transition_rate": ("collapse", "transition_rate"),
        **{constant.name: ("material", constant.name) for constant in MooneyRivlin.constants()},
    },
    **{kind: {kind: ("law",)} for kind in LAWS},
    "tuning": {
        "pressures": ("pressure",),
        "hinge_stiffness_slope": ("hinge_stiffness_factor", "slope"),
    },
    "bundle": {"motor_units": ("motor_unit",), "pressures": ("supply_pressure",)},
    "design": {"drawings": ("muscle",), "most_units": ()},
    "catalog": {"catalog": ()},
    "objectives": {"objectives": ()},
    "limits": {"objectives": ()},
    # a plant's parts are tables of the file, its initial state stands in [run]
    "scenario": {
        **{name: ("run", name) for name in ("pressures", "position", "law", "volume")},
        "units": ("spool",),
    },
    "motion": {"position": ("load",), "pressures": ("run", "pressures")},
    "part": {"gas": ("medium",), "liquid": ("medium",)},
}
# tables that only a file of a kind has, and its command; scenarios may hold a muscle, too
_KINDS = {
    "scenario": (("load", "supply", "run", "schedule"), "`fascicle simulate` runs it"),
    "task": (("task", "design"), "`fascicle design` takes it"),
    "muscle or bundle": (
        ("muscle", "bundle"), "`fascicle force` and `fascicle bundle` take it",
    ),
}  # fmt: skip


class FileLocation:
    """A section of a file, for errors about it.

    - `source`: the file's path.
    - `data`: all tables of the file.
    - `keys`: the keys that lead to the section.
    - `kind`: of the section: a key of `_KEYS`, or another word.
    """

    def __init__(self, source: str, data: Any, keys: tuple[Any, ...] = (), kind: str = ""):
        self.source, self.data, self.keys, self.kind = source, data, keys, kind

    def child(self, *keys: Any, kind: str = "") -> "FileLocation":
        """The location at `keys` below this one."""
        return FileLocation(self.source, self.data, self.keys + keys, kind)

    def error(self, keys: tuple[Any, ...], rule: str) -> ValueError:
        """The error for the value at `keys` below this location, which breaks a `rule`."""
        path = self.keys + keys
        value = value_at(self.data, path)
        # a single muscle has the empty name
        return ValueError(location_message(self.source, [k for k in path if k != ""], rule, value))

    @contextlib.contextmanager
    def error_context(self) -> Iterator[None]:
        """Name this location in an error raised inside, or in that of a file that it names."""
        try:
            yield
        except (ValueError, OSError) as error:
            name = error.argument if isinstance(error, InvalidInputError) else ""
            keys = _KEYS.get(self.kind, {}).get(name, (name,) if name else ())
            raise self.error(keys, str(error)) from None


def validate(model: type[BaseModel], data: Any, source: str) -> Any:
    """The file's tables as a `model`; `ValueError` in one line if they don't fit."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ValueError(validation_message(error, source, data, model)) from None


def check_kind(data: Mapping[str, Any], kind: str, source: str) -> None:
    """Refuse a file with tables of another kind than "muscle or bundle", "scenario" or "task"."""
    if kind != "muscle or bundle" and any(key in data for key in _KINDS[kind][0]):
        return
    for actual, (keys, command) in _KINDS.items():
        key = next((key for key in keys if key in data), None)
        if actual != kind and key is not None:
            rule = f"a {actual}, not a {kind}: {command}."
            raise ValueError(location_message(source, [key], rule))
