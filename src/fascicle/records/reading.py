"""From a dynamometer's file, and the TOML file beside it, to a checked `Record`.

The TOML file, or `sidecar`, holds what the table's header can't:

```toml
rest_length = "300 mm"
clipped_at_zero = true                # readings of exactly zero are clipped
displacement_at_rest = "12.5 mm"      # the displacement's reading at the rest length
source = "who measured it, and when"
notes = ["what was measured, and how"]
synthetic = false

[columns]                             # a header that isn't recognized
force = "Load cell 2"

[units]                               # a unit that no header has
force = "N"

[signs]
force = "pushing positive"            # or "pulling positive"
strain = "extension positive"         # or "contraction positive"; displacement likewise
```
"""

import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, StrictBool, StrictStr, ValidationError

from ..core.errors import InvalidInputError
from ..core.validation import to_si
from ..io.input_file import read_bytes
from ..io.toml import parse_toml
from ..table_model import Quantity, TableModel, validation_message
from ..units import parse, pretty
from .columns import OPTIONAL, MissingMetadataError, check_roles, choose_columns
from .csv_table import Cells, Table, open_table
from .record import DOWN, UNKNOWN, UP, Record, Source, join
from .units import (
    POSITIONS,
    CellError,
    Column,
    check_forces,
    check_pressures,
    check_strains,
    to_si_units,
)


LARGEST_FILE = 1_000_000_000  # bytes
_MAX_SIDECAR_SIZE = 1_000_000  # bytes
_STRETCHED = -1e-3  # strain: a gauge's zero is off by that much

_BRANCHES = {
    **dict.fromkeys(
        ("1", "+1", "1.0", "up", "inflating", "inflation", "inflate", "contracting",
         "contraction", "shortening", "loading", "forward"), UP),
    **dict.fromkeys(
        ("-1", "−1", "-1.0", "down", "deflating", "deflation", "deflate", "extending",
         "extension", "lengthening", "unloading", "backward", "return"), DOWN),
    **dict.fromkeys(("0", "0.0", "", "-", "unknown"), UNKNOWN),
}  # fmt: skip
_FLAGS = {
    **dict.fromkeys(("1", "1.0", "true", "yes", "y", "x", "clipped", "censored"), True),
    **dict.fromkeys(("0", "0.0", "false", "no", "n", "", "-", "ok"), False),
}
_TEXT_ROLES = ("branch", "clipped")
_NUMBER = re.compile(r"[+−-]?\d+(?:\.\d*)?", re.ASCII)
_REMARK = re.compile(r"(\w+)\s*[:=]\s*(.*)")  # key: text, or key = text
_NEGATIVE = ("pushing positive", "extension positive")


def _check_roles(table: dict[str, str], info: Any) -> dict[str, str]:
    check_roles(table, str(info.field_name))
    return table


Contraction = Literal["contraction positive", "extension positive"]
Notes = Annotated[
    list[StrictStr], BeforeValidator(lambda note: [note] if isinstance(note, str) else note)
]
TextsByRole = Annotated[dict[str, StrictStr], AfterValidator(_check_roles)]


class Signs(TableModel):
    """`[signs]`: the direction in which the file counts."""

    force: Literal["pulling positive", "pushing positive"] | None = None
    strain: Contraction | None = None
    displacement: Contraction | None = None

    def sign(self, role: str) -> int | None:
        """1 or −1 for a role, or `None`."""
        direction = getattr(self, role, None)
        return None if direction is None else -1 if direction in _NEGATIVE else 1


class Sidecar(TableModel):
    """Information about a table that its header doesn't hold.

    - `rest_length`: reference length of the strains [m].
    - `displacement_at_rest`: the displacement's reading there [m].
    - `clipped_at_zero`: true if forces of exactly zero are clipped readings.
    - `columns`, `units`: headers and units by role.
    - `signs`: directions of force, strain and displacement.
    - `synthetic`: true for readings of a model.
    - `source`, `notes`: remarks.
    """

    rest_length: Annotated[float, Quantity("length"), Field(gt=0)] | None = None
    displacement_at_rest: Annotated[float, Quantity("length")] | None = None
    clipped_at_zero: StrictBool | None = None
    columns: TextsByRole = Field(default_factory=dict)
    units: TextsByRole = Field(default_factory=dict)
    signs: Signs = Signs()
    synthetic: StrictBool = False
    source: StrictStr | None = None
    notes: Notes = Field(default_factory=list)


def load(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rest_length: Any = None,
    clipped_at_zero: bool | None = None,
    header: int | None = None,
    sidecar: str | os.PathLike[str] | None = None,
) -> Record:
    """Read a dynamometer's file.

    An argument overrules the TOML file beside the table, and that overrules the table.

    **Arguments:**

    - `path`: the CSV file, or several of one muscle.
    - `columns`: headers of columns that aren't recognized, by role: pressure, force, strain,
      length, displacement, time, branch, clipped.
    - `units`: units of columns whose header has none, by role.
    - `rest_length`: reference length of the strains [m]; lengths and displacements need it.
    - `clipped_at_zero`: true if forces of exactly zero are clipped readings.
    - `header`: line of the columns' names, counted from 1; default: it is inferred.
    - `sidecar`: the TOML file; default: the one of the table's name, if there is one.

    **Returns:** the record.

    **Raises:** `OSError` if a file can't be read; `ValueError`, in one line with file, line and
    column, for contents that aren't valid.
    """
    if not isinstance(path, str | os.PathLike):
        if not path:
            raise InvalidInputError("path", "must name at least one file", None, shown="none")
        options: Any = {
            "columns": columns, "units": units, "rest_length": rest_length,
            "clipped_at_zero": clipped_at_zero, "header": header, "sidecar": sidecar,
        }  # fmt: skip
        return join([load(file, **options) for file in path])
    path = Path(path)
    raw = read_bytes(path, LARGEST_FILE, "record", ": keep every tenth row, or split it.")
    if sidecar is None:
        info, notes = _sidecar_beside(path)
    else:
        info, notes = read_sidecar(sidecar), (f"{Path(sidecar).name} read with it",)
    info = _overrule(info, columns, units, rest_length, clipped_at_zero)
    return _read_record(raw, str(path), path.name, info, notes, header)


def loads(text: str, source: str = "<text>", **options: Any) -> Record:
    """Read a dynamometer's table from text.

    **Arguments:**

    - `text`: the table.
    - `source`: its name in errors.
    - `options`: `columns`, `units`, `rest_length`, `clipped_at_zero`, `header` of `load`.

    **Returns:** the record.

    **Raises:** `ValueError` as `load`.
    """
    header = options.pop("header", None)
    return _read_record(text.encode(), source, source, _overrule(Sidecar(), **options), (), header)


def read_sidecar(path: str | os.PathLike[str]) -> Sidecar:
    """Read a sidecar file; `ValueError` names file and key of an invalid value."""
    return _validate_sidecar(_sidecar_tables(Path(path)), str(path))


def _sidecar_beside(path: Path) -> tuple[Sidecar, tuple[str, ...]]:
    """The sidecar of a table's own name, empty if there is none, and a note of it."""
    toml = path.with_suffix(".toml")
    if toml == path or not toml.is_file():
        return Sidecar(), ()
    data = _sidecar_tables(toml)
    if {"muscle", "bundle"} & set(data):
        # a calibrated muscle's file may have its record's name
        return Sidecar(), (f"{toml.name} beside it not read: it describes a muscle",)
    return _validate_sidecar(data, str(toml)), (f"{toml.name} beside it read",)


def _sidecar_tables(path: Path) -> dict[str, Any]:
    raw = read_bytes(path, _MAX_SIDECAR_SIZE, "record's TOML")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; this one is TOML in UTF-8.") from None
    return parse_toml(text, str(path))


def _validate_sidecar(data: dict[str, Any], source: str) -> Sidecar:
    try:
        return Sidecar.model_validate(data)
    except ValidationError as error:
        raise ValueError(validation_message(error, source, data, Sidecar)) from None


def _overrule(
    info: Sidecar,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rest_length: Any = None,
    clipped_at_zero: bool | None = None,
) -> Sidecar:
    """The sidecar's information, overruled by the caller's."""
    for argument, mapping in (("columns", columns or {}), ("units", units or {})):
        check_roles(mapping, argument)
    changes: dict[str, Any] = {
        "columns": {**info.columns, **(columns or {})},
        "units": {**info.units, **(units or {})},
    }
    rest_length = to_si(rest_length, "rest_length", "m")
    if rest_length is not None:
        if not (np.isfinite(rest_length) and rest_length > 0):
            rule, text = "must be positive and finite", f"{rest_length} m"
            raise InvalidInputError("rest_length", rule, rest_length, shown=text)
        changes["rest_length"] = float(rest_length)
    if clipped_at_zero is not None:
        changes["clipped_at_zero"] = clipped_at_zero
    return info.model_copy(update=changes)


def _read_record(
    raw: bytes, source: str, name: str, info: Sidecar, notes: tuple[str, ...], header: int | None
) -> Record:
    table = open_table(raw, source, header)
    columns, column_notes = choose_columns(table, info.columns, info.units)
    header_lines = (*table.remarks, *table.titles)
    remarks = [(match[1].lower(), match[2]) for match in map(_REMARK.match, header_lines) if match]
    rest_length, rest_notes = _rest_length(table, info, dict(remarks))
    position = columns[next(role for role in POSITIONS if role in columns)]
    if rest_length is None and position.role != "strain":
        where = f"{table.where}, column `{position.header}`"
        before = f"{where}: a {position.role} needs the rest length: give "
        toml = f"{Path(name).stem or 'its'}.toml"
        after = f', or write rest_length = "300 mm" in {toml} beside it.'
        raise MissingMetadataError(before, "rest_length", after=after)
    cells, misread = _read_cells(table, columns, info)
    for column in misread:
        del columns[column.role]
        note = f"column `{column.header}` not read as {column.role}: it holds something else"
        column_notes = (*(text for text in column_notes if text != column.note()), note)

    def cell_error(row: int, column: Column, rule: str) -> ValueError:
        return table.cell_error(int(cells.lines[row]), column.index, rule)

    raws = {
        role: cells.numbers[column.index]
        for role, column in columns.items()
        if role not in _TEXT_ROLES
    }
    force = to_si_units(raws["force"], columns["force"].factor) * (info.signs.sign("force") or 1)
    pressure, warnings = check_pressures(columns["pressure"], raws["pressure"], force, cell_error)
    top = float(np.max(pressure))
    warnings += check_forces(columns["force"], raws["force"], force, top, cell_error)
    strain, strain_notes = _strain(
        position, raws[position.role], rest_length or np.nan, info, cell_error
    )
    censored, clip_notes = _censored(table, cells, columns.get("clipped"), force, info)
    branch = np.full(force.size, UNKNOWN, dtype=np.int8)
    if "branch" in columns:
        branch = _meanings(table, cells, columns["branch"], _BRANCHES, "up or down")
    time = None
    if "time" in columns:
        time = to_si_units(raws["time"], columns["time"].factor)
        back = np.flatnonzero(np.diff(time) < 0)
        if back.size:
            warnings += (f"time goes back in line {cells.lines[back[0] + 1]}",)
    texts = [] if info.source is None else [f"source: {info.source}"]
    all_notes = (
        *notes, *_title_note(table), *column_notes, *rest_notes, *strain_notes, *clip_notes,
        *warnings, *(" ".join(text.split()) for text in [*texts, *info.notes]),
        *(f"{key}: {text}" for key, text in remarks if key in {"source", "note"}),
    )  # fmt: skip
    return Record(
        pressure, strain, force, censored, branch.astype(np.int8), time, rest_length,
        synthetic=info.synthetic or _is_synthetic(header_lines),
        sources=(Source(name, hashlib.sha256(raw).hexdigest()),),
        notes=tuple(f"{name}: {note}" for note in all_notes),
    )  # fmt: skip


def _read_cells(
    table: Table, columns: Mapping[str, Column], info: Sidecar
) -> tuple[Cells, list[Column]]:
    """The columns' cells, and inferred optional columns that hold something else."""

    def read(roles: Sequence[str]) -> Cells:
        texts = [columns[role].index for role in roles if role in _TEXT_ROLES]
        return table.read([columns[r].index for r in roles if r not in _TEXT_ROLES], texts)

    named = {*info.columns, *info.units}
    inferred = [role for role in OPTIONAL if role in columns and role not in named]
    misread = []
    if "branch" in inferred:
        column = columns["branch"]
        texts = read(["branch"]).texts[column.index].categories
        # numbers other than those of branches count the sweeps
        if all(map(_NUMBER.fullmatch, texts)) and not set(texts) <= set(_BRANCHES):
            misread.append(column)
    roles = [role for role, column in columns.items() if column not in misread]
    try:
        return read(roles), misread
    except ValueError:
        if "time" not in inferred:
            raise
    misread.append(columns["time"])
    return read([role for role in roles if role != "time"]), misread


def _title_note(table: Table) -> tuple[str, ...]:
    """A note of the lines above the header, if there are any."""
    if not table.titles:
        return ()
    lines = "; ".join(line if len(line) <= 60 else f"{line[:57]}…" for line in table.titles[:3])
    count = f" and {len(table.titles) - 3} more" if len(table.titles) > 3 else ""
    return (f"lines above the header not read as data: {lines}{count}",)


def _is_synthetic(remarks: Sequence[str]) -> bool:
    """True if a remark begins with "synthetic" and doesn't deny it."""
    texts = [text.lower() for text in remarks if text.lower().startswith("synthetic")]
    return any(
        text.removeprefix("synthetic").strip(" :=.") not in {"false", "no", "0"} for text in texts
    )


def _rest_length(
    table: Table, info: Sidecar, remarks: Mapping[str, str]
) -> tuple[float | None, tuple[str, ...]]:
    if info.rest_length is not None or "rest_length" not in remarks:
        return info.rest_length, ()
    try:
        length = parse(remarks["rest_length"].strip('" '), "length", "rest_length")
    except ValueError as error:
        raise ValueError(f"{table.source}: in its remarks, {error}") from None
    if length <= 0:
        raise ValueError(f"{table.source}: in its remarks, `rest_length` must be positive.")
    return length, (f"rest length {pretty(length, 'length')} read from its remarks",)


def _strain(
    column: Column, raw: np.ndarray, rest: float, info: Sidecar, cell_error: CellError
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Contraction, from a column of strains, displacements or lengths."""
    values = to_si_units(raw, column.factor)
    sign = info.signs.sign(column.role) or info.signs.sign("strain") or column.sign
    if column.role == "strain":
        strain = values * sign
    elif column.role == "displacement":
        strain = (values - (info.displacement_at_rest or 0.0)) * sign / rest
    else:
        wrong = np.flatnonzero(values <= 0)
        if wrong.size:
            rule = f"{raw[wrong[0]]:g} is no length of a muscle"
            if raw[wrong[0]] == 0:
                option = f'columns {{"displacement": "{column.header}"}}'
                rule += f": if it counts from rest, give {option}"
            raise cell_error(int(wrong[0]), column, f"{rule}.")
        strain = (rest - values) / rest
    check_strains(column, raw, strain, cell_error)
    notes, longest = (), float(np.min(strain))
    if longest < _STRETCHED:
        count = int(np.count_nonzero(strain < _STRETCHED))
        notes = (f"{count} readings stretched beyond rest, down to {longest:.3g}",)
    return strain + 0.0, notes  # without negative zeros


def _censored(
    table: Table, cells: Cells, column: Column | None, force: np.ndarray, info: Sidecar
) -> tuple[np.ndarray, tuple[str, ...]]:
    censored = np.zeros(force.size, dtype=bool)
    if column is not None:
        censored = _meanings(table, cells, column, _FLAGS, "0 or 1").astype(bool)
    if info.clipped_at_zero:
        censored = censored | (force == 0)
    count, zeros = int(np.count_nonzero(censored)), int(np.count_nonzero(force == 0))
    if count:
        return censored, (f"{count} of {force.size} readings clipped",)
    if zeros > 2 and column is None and info.clipped_at_zero is None:
        hint = "if the gauge can't push, give clipped_at_zero = true"
        return censored, (f"{zeros} forces are exactly 0: {hint}",)
    return censored, ()


def _meanings(
    table: Table, cells: Cells, column: Column, meanings: Mapping[str, int], rule: str
) -> np.ndarray:
    """The meaning of the text in each cell of a column."""
    texts = cells.texts[column.index]
    values = [meanings.get(text.strip().lower()) for text in texts.categories]
    if None in values:
        code = values.index(None)
        line = int(cells.lines[int(np.argmax(texts.codes == code))])
        rule = f"{texts.categories[code]!r} isn't known: write {rule}."
        raise table.cell_error(line, column.index, rule)
    return np.array(values, dtype=int)[texts.codes]
