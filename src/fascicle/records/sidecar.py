"""The small TOML file beside a table: what its header can't say.

```toml
rest_length = "300 mm"
clipped_at_zero = true                # readings of exactly zero are clipped
displacement_at_rest = "12.5 mm"      # what the displacement reads at the rest length
source = "who measured it, and when"
notes = ["what was measured, and how"]
synthetic = false

[columns]                             # where a header isn't recognized
force = "Load cell 2"

[units]                               # where a header has none
force = "N"

[signs]
force = "pushing positive"            # or "pulling positive"
strain = "extension positive"         # or "contraction positive"; displacement likewise
```
"""

import difflib
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..io.input_file import read_bytes
from ..io.toml import parse_toml
from ..units import parse
from .columns import check_roles


_LARGEST = 1_000_000  # bytes
_SIGNS = {
    "force": {"pulling positive": 1, "pushing positive": -1},
    "strain": {"contraction positive": 1, "extension positive": -1},
    "displacement": {"contraction positive": 1, "extension positive": -1},
}


@dataclass(frozen=True)
class Sidecar:
    """What such a file says; all of it may be left out.

    - `rest_length`: the length that strains refer to [m].
    - `displacement_at_rest`: the reading there [m].
    - `clipped_at_zero`: whether forces of exactly zero are clipped [-].
    - `columns`, `units`: headers and units by role [-].
    - `signs`: 1 or −1 by role [-].
    - `synthetic`: whether a model made the data [-].
    - `notes`: its remarks, source included [-].
    """

    rest_length: float | None = None
    displacement_at_rest: float | None = None
    clipped_at_zero: bool | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    signs: Mapping[str, int] = field(default_factory=dict)
    synthetic: bool = False
    notes: tuple[str, ...] = ()


_KEYS = ("rest_length", "displacement_at_rest", "clipped_at_zero", "columns", "units", "signs",
         "synthetic", "source", "notes")  # fmt: skip


def beside(path: Path) -> tuple[Sidecar, tuple[str, ...]]:
    """What the TOML of the same name says, if there is one.

    **Arguments:** `path`: the table's [-].

    **Returns:** it, and what to note of it [-].

    **Raises:** as `read`.
    """
    toml = path.with_suffix(".toml")
    if toml == path or not toml.is_file():
        return Sidecar(), ()
    data = _parsed(toml)
    if {"muscle", "bundle"} & set(data):
        # a calibrated muscle may well stand beside its data, under the same name
        return Sidecar(), (f"{toml.name} beside it not read: it describes a muscle",)
    return _checked(data, str(toml)), (f"{toml.name} beside it read",)


def read(path: str | os.PathLike[str]) -> Sidecar:
    """What the TOML at `path` says.

    **Arguments:** `path`: the file [-].

    **Returns:** what it says [-].

    **Raises:** `OSError` where it can't be read; `ValueError`, in one line with file and key,
    where it says what can't be.
    """
    return _checked(_parsed(Path(path)), str(path))


def _parsed(path: Path) -> dict[str, Any]:
    raw = read_bytes(path, _LARGEST, "record's TOML")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; this one is TOML in UTF-8.") from None
    return parse_toml(text, str(path))


def _checked(data: dict[str, Any], source: str) -> Sidecar:
    for key in data:
        _known(key, _KEYS, f"{source}: {key}")
    lengths = {
        key: _length(data[key], f"{source}: {key}")
        for key in ("rest_length", "displacement_at_rest")
        if key in data
    }
    if lengths.get("rest_length", 1) <= 0:
        raise ValueError(f"{source}: rest_length = {data['rest_length']!r}: must be positive.")
    for key in ("clipped_at_zero", "synthetic"):
        if not isinstance(data.get(key, False), bool):
            raise ValueError(f"{source}: {key} = {data[key]!r}: must be true or false.")
    parse_toml = {
        key: _strings(data.get(key, {}), f"{source}: {key}") for key in ("columns", "units")
    }
    signs = {}
    for role, said in _strings(data.get("signs", {}), f"{source}: signs").items():
        _known(role, _SIGNS, f"{source}: signs.{role}")
        _known(said, _SIGNS[role], f"{source}: signs.{role} = {said!r}")
        signs[role] = _SIGNS[role][said]
    try:
        for key, table in parse_toml.items():
            check_roles(table, key)
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None
    return Sidecar(
        rest_length=lengths.get("rest_length"),
        displacement_at_rest=lengths.get("displacement_at_rest"),
        columns=parse_toml["columns"], units=parse_toml["units"], signs=signs,
        clipped_at_zero=data.get("clipped_at_zero"),
        synthetic=data.get("synthetic", False), notes=_notes(data, source),
    )  # fmt: skip


def _known(name: str, choices: Iterable[str], where: str) -> None:
    known = list(choices)
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
        hint = f'did you mean "{near[0]}"?' if near else f"choose one of {', '.join(known)}."
        raise ValueError(f"{where}: unknown, {hint}")


def _length(value: Any, where: str) -> float:
    try:
        return parse(value, "length", where.rpartition(" ")[2])
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _strings(value: Any, where: str) -> dict[str, str]:
    if not isinstance(value, dict) or not all(isinstance(text, str) for text in value.values()):
        raise ValueError(f'{where}: must be a table of names in quotes, such as force = "N".')
    return value


def _notes(data: dict[str, Any], source: str) -> tuple[str, ...]:
    notes = data.get("notes", [])
    notes = [notes] if isinstance(notes, str) else notes
    said = [data["source"]] if "source" in data else []
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in [*notes, *said]):
        raise ValueError(f"{source}: source and notes must be texts in quotes.")
    return tuple(" ".join(text.split()) for text in [*(f"source: {s}" for s in said), *notes])
