"""Where a constructor's arguments stand in a file.

The laws refuse what can't be, and say which argument it was given for. A `Place` turns that into
the file's error: path, key, value as written, rule.
"""

import contextlib
from collections.abc import Iterator
from typing import Any

from ..core.errors import InvalidInputError
from ..muscle.laws import LAWS
from ..muscle.materials import MooneyRivlin
from .faults import line, value


# where an argument of a constructor stands, if not under its own name
_KEYS: dict[str, dict[str, tuple[str, ...]]] = {
    "muscle": {
        "transition_rate": ("collapse", "transition_rate"),
        **{one.name: ("material", one.name) for one in MooneyRivlin.constants()},
    },
    **{kind: {kind: ("law",)} for kind in LAWS},
    "tuning": {
        "pressures": ("pressure",),
        "hinge_stiffness_slope": ("hinge_stiffness_factor", "slope"),
    },
    "bundle": {"motor_units": ("motor_unit",), "pressures": ("supply_pressure",)},
    "motor_unit": {},
    "task": {},
    "design": {"drawings": ("muscle",), "most_units": ()},
    "catalog": {"catalog": ()},
    "prices": {},
    "objectives": {"objectives": ()},
    "limits": {"objectives": ()},
    # a plant's parts are tables of the file, what `rest` is asked for stands in its [run]
    "scenario": {
        **{name: ("run", name) for name in ("pressures", "position", "law", "volume")},
        "units": ("spool",),
    },
    "moved": {"position": ("load",), "pressures": ("run", "pressures")},
    "part": {"gas": ("medium",), "liquid": ("medium",)},
    "schedule": {},
}


class Place:
    """A section of a file, which an error in it names."""

    def __init__(self, source: str, data: Any, path: tuple[Any, ...], kind: str):
        """**Arguments:**

        - `source`: the file's path, or what stands for it [-].
        - `data`: the whole file's data [-].
        - `path`: the keys that lead to the section [-].
        - `kind`: what the section describes [-]: a key of `_KEYS`.
        """
        self.source, self.data, self.path, self.kind = source, data, path, kind

    def inner(self, *keys: Any, kind: str) -> "Place":
        """The place at `keys` [-] below this one, of another `kind` [-]."""
        return Place(self.source, self.data, self.path + keys, kind)

    def refuse(self, keys: tuple[Any, ...], rule: str) -> ValueError:
        """The error [-] for the value at `keys` [-] below this place, which breaks `rule` [-]."""
        path = self.path + keys
        written = value(self.data, path)
        named = [part for part in path if part != ""]  # a lone muscle's name is empty
        return ValueError(line(self.source, named, rule, written))

    @contextlib.contextmanager
    def naming(self) -> Iterator[None]:
        """Name this place in a `ValueError` raised inside, or in a file's that it names."""
        try:
            yield
        except (ValueError, OSError) as error:
            name = error.argument if isinstance(error, InvalidInputError) else ""
            keys = _KEYS[self.kind].get(name, (name,) if name else ())
            raise self.refuse(keys, str(error)) from None
