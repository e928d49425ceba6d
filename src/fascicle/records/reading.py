"""From a dynamometer's file, and the sidecar beside it, to a checked `Record`."""

import glob
import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import to_si
from ..io.input_file import read_bytes
from ..units import parse, pretty
from .columns import MissingMetadataError, check_roles, choose_columns, split_names
from .formats import unpack
from .headers import DIMENSIONS, ROLES
from .record import DOWN, UNKNOWN, UP, Record, Source, join
from .sidecar import CONSTANTS, ZEROS, Sidecar, Signs, read_sidecar, sidecar_beside
from .tables import MAX_ROWS, Table, TableColumns, open_table
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
_REMARK = re.compile(r"(\w+)\s*[:=]\s*(.*)")  # key: text, or key = text
_SI_UNITS = {"pressure": "Pa", "force": "N", "length": "m", "displacement": "m", "strain": "-"}
_PATTERN_NAMES = (*CONSTANTS, "rest_length")


def load(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: Mapping[str, str] | Sequence[str] | str | None = None,
    units: Mapping[str, str] | None = None,
    rest_length: Any = None,
    clipped_at_zero: bool | None = None,
    header: int | None = None,
    sidecar: str | os.PathLike[str] | None = None,
    constants: Mapping[str, Any] | None = None,
    name_pattern: str | None = None,
    zeros: Mapping[str, Any] | None = None,
    signs: Mapping[str, str] | None = None,
    atmosphere: Any = None,
    rows: str | None = None,
    table: str | None = None,
) -> Record:
    """Read a dynamometer's file, or several of one muscle as one record.

    An argument overrules the TOML file beside the table, and that overrules the table.

    **Arguments:**

    - `path`: the file (text, .xlsx, .mat or .tdms), or several of one muscle; patterns such as
      `"runs/*.csv"` stand for all files that fit.
    - `columns`: headers of columns that aren't recognized, by role: pressure, force, strain,
      length, displacement, time, branch, clipped. Or all columns in their order, such as
      `"force[N],pressure[kPa],-,length[mm]"`, with `-` for one to skip: for files without header.
    - `units`: units of columns whose header has none, by role.
    - `rest_length`: reference length of the strains [m]; lengths and displacements need it.
    - `clipped_at_zero`: true if forces of exactly zero are clipped readings.
    - `header`: line of the columns' names, counted from 1; default: it is inferred.
    - `sidecar`: the TOML file; default: the one of the table's name, if there is one.
    - `constants`: pressure, force, strain, length or displacement of all readings [SI].
    - `name_pattern`: constants in the file's name, such as `"{length}cm_{pressure}kPa"`.
    - `zeros`: readings of pressure, force and displacement at zero, or at rest [SI].
    - `signs`: directions by role: "pushing positive", "extension positive" and their opposites.
    - `atmosphere`: to subtract from absolute pressures [Pa].
    - `rows`: first and last row to read, such as `"40:200"` or `"40:"`, from 1 below the header.
    - `table`: sheet, structure or group of a file with several.

    **Returns:** the record.

    **Raises:** `OSError` if a file can't be read; `ValueError`, in one line with file, line and
    column, for contents that aren't valid.
    """
    options: dict[str, Any] = {
        "columns": columns, "units": units, "rest_length": rest_length,
        "clipped_at_zero": clipped_at_zero, "header": header, "constants": constants,
        "zeros": zeros, "signs": signs, "atmosphere": atmosphere, "rows": rows, "table": table,
    }  # fmt: skip
    records = []
    for file in find_files(path):
        raw = read_bytes(file, LARGEST_FILE, "record", ": keep every tenth row, or split it.")
        if sidecar is None:
            info, notes = sidecar_beside(file)
        else:
            info, notes = read_sidecar(sidecar), (f"{Path(sidecar).name} read with it",)
        if name_pattern is not None:
            changes = _read_name(file, name_pattern)
            info = info.model_copy(update=changes)
            notes += (f"its name gives {_list_values(changes)}",)
        records.append(_read_record(raw, str(file), file.name, _overrule(info, **options), notes))
    return records[0] if len(records) == 1 else join(records)


def loads(text: str, source: str = "<text>", **options: Any) -> Record:
    """Read a dynamometer's table from text.

    **Arguments:**

    - `text`: the table.
    - `source`: its name in errors.
    - `options`: of `load`, but for `sidecar` and `name_pattern`.

    **Returns:** the record.

    **Raises:** `ValueError` as `load`.
    """
    return _read_record(text.encode(), source, source, _overrule(Sidecar(), **options), ())


def find_files(path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[Path]:
    """Files of a path or several, with patterns such as `"runs/*.csv"` replaced by what fits them.

    **Raises:** `FileNotFoundError` for a pattern that fits no file.
    """
    paths = [path] if isinstance(path, str | os.PathLike) else list(path)
    if not paths:
        raise InvalidInputError("path", "must name at least one file", None, shown="none")
    files: list[Path] = []
    for text in map(str, paths):
        if not glob.has_magic(text) or "\0" in text or os.path.lexists(text):
            files.append(Path(text))
            continue
        # a pattern may fit the sidecars, too
        names = sorted(glob.glob(text, recursive=True))  # noqa: PTH207 absolute patterns, too
        names = [name for name in names if not name.endswith(".toml")]
        if not names:
            raise FileNotFoundError(f"{text}: no file fits this pattern.")
        files += map(Path, names)
    return list(dict.fromkeys(files))


def _overrule(info: Sidecar, **options: Any) -> Sidecar:
    """The sidecar's information, overruled by the caller's arguments of `load`."""
    changes: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    if unexpected := set(changes) - set(Sidecar.model_fields) - {"constants", "zeros"}:
        raise TypeError(f"unexpected arguments: {', '.join(sorted(unexpected))}")
    if not isinstance(columns := changes.get("columns", {}), Mapping):
        changes["names"], changes["columns"] = split_names(columns), {}
    roles = {"columns": ROLES, "units": ROLES, "signs": tuple(Signs.model_fields),
             "constants": CONSTANTS, "zeros": ZEROS}  # fmt: skip
    for argument, choices in roles.items():
        check_roles(changes.get(argument, {}), argument, choices)
    for argument in ("columns", "units"):
        changes[argument] = {**getattr(info, argument), **changes.get(argument, {})}
    if signs := changes.pop("signs", {}):
        full = {role: _direction(role, text) for role, text in signs.items()}
        changes["signs"] = info.signs.model_copy(update=full)
    quantities = {role: (role, value) for role, value in changes.pop("constants", {}).items()}
    for role, value in changes.pop("zeros", {}).items():
        quantities[f"{role}_at_rest"] = role, value
    for name, role in (("rest_length", "length"), ("atmosphere", "pressure")):
        if name in changes:
            quantities[name] = role, changes[name]
    for name, (role, value) in quantities.items():
        # a constant's name alone would be that of the muscle's size
        label = f"constant {name}" if name == role else name
        number = parse(value, _dimension(role), label) if isinstance(value, str) else value
        number = float(to_si(number, role, _SI_UNITS[role]))
        if not np.isfinite(number) or (name == "rest_length" and number <= 0):
            rule = f"must be {'positive and ' if name == 'rest_length' else ''}finite"
            raise InvalidInputError(name, rule, number, shown=f"{number} {_SI_UNITS[role]}")
        changes[name] = number
    return info.model_copy(update=changes)


def _direction(role: str, text: str) -> str:
    """A direction in full: "pushing" is "pushing positive"."""
    choices = get_args(get_args(Signs.model_fields[role].annotation)[0])
    direction = f"{text.removesuffix('positive').strip()} positive"
    if direction not in choices:
        raise InvalidInputError("signs", f"of {role} must be {' or '.join(choices)}", text)
    return direction


def _read_name(path: Path, pattern: str) -> dict[str, float]:
    """Constants [SI] that the file's name holds where the `pattern` has their names in braces.

    The unit stands after the braces, or in them: `{length}cm`, `{pressure:kPa}`.
    """
    # text, and after each piece of it a name, its unit in the braces, and the unit behind them
    *pieces, end = re.split(r"\{(\w+)(?::([^}]*))?\}(?=([^\W\d_]*%?))", pattern)
    expression, fields = "", []
    for text, name, inside, behind in zip(*(pieces[i::4] for i in range(4)), strict=True):
        expression += _wildcard_expression(text) + r"([+-]?\d+(?:[.,]\d+)?)"
        fields.append((name, inside or behind))
        if name not in _PATTERN_NAMES:
            hint, rule = f"choose of {', '.join(_PATTERN_NAMES)}", f"has the unknown name {name!r}"
            raise InvalidInputError("name_pattern", rule, name, f"{hint}; * is other text", "")
    if not fields:
        hint = 'write such as "{length}cm_{pressure}kPa"'
        raise InvalidInputError("name_pattern", "has no name in braces", pattern, hint)
    match = re.search(expression + _wildcard_expression(end), path.stem)
    if match is None:
        raise ValueError(f"{path}: the file's name doesn't fit the pattern {pattern!r}.")
    values = {}
    for (name, unit), text in zip(fields, match.groups(), strict=True):
        values[name] = parse(f"{text.replace(',', '.')} {unit}", _dimension(name), name)
    return values


def _wildcard_expression(text: str) -> str:
    return re.escape(text).replace(r"\*", ".*").replace(r"\?", ".")


def _list_values(values: Mapping[str, float]) -> str:
    return ", ".join(f"{role} {pretty(value, _dimension(role))}" for role, value in values.items())


def _dimension(role: str) -> str:
    return "length" if role == "rest_length" else DIMENSIONS.get(role, role)


def _read_record(
    raw: bytes, source: str, name: str, info: Sidecar, notes: tuple[str, ...]
) -> Record:
    text = unpack(raw, source, info.table)
    table = open_table(text, source, info.header, info.names)
    constants = info.constants
    columns, column_notes = choose_columns(
        table, info.columns, info.units, constants,
        names=info.names, atmosphere=info.atmosphere is not None,
    )  # fmt: skip
    columns = {role: column for role, column in columns.items() if role not in constants}
    header_lines = (*table.remarks, *table.titles)
    remarks = [(match[1].lower(), match[2]) for match in map(_REMARK.match, header_lines) if match]
    rest_length, rest_notes = _rest_length(table, info, dict(remarks))
    cells, misread = _read_cells(table, columns, info)
    for column in misread:
        del columns[column.role]
        note = f"column `{column.header}` not read as {column.role}: it holds something else"
        column_notes = (*(text for text in column_notes if text != column.note()), note)
    raws = {r: cells.numbers[c.index] for r, c in columns.items() if r not in _TEXT_ROLES}
    if constants:
        raws |= {role: np.full(len(cells.lines), value) for role, value in constants.items()}
        columns |= {role: Column(role, -1, role, _SI_UNITS[role]) for role in constants}
        rest_notes += (f"all readings at {_list_values(constants)}",)
    position = columns[next(role for role in POSITIONS if role in columns)]
    if rest_length is None and position.role != "strain":
        before = (
            f"{table.where}, column `{position.header}`: a {position.role} needs the rest length:"
            " give "
        )
        toml = f"{Path(name).stem or 'its'}.toml"
        after = f', or write rest_length = "300 mm" in {toml} beside it'
        raise MissingMetadataError(before, ("rest_length", "", "", after))

    def cell_error(row: int, column: Column, rule: str) -> ValueError:
        if column.index < 0:
            return ValueError(f"{source}: constant {column.role}: {rule}")
        return table.cell_error(cells.lines[row], column.index, rule)

    force = to_si_units(raws["force"], columns["force"].factor) - (info.force_at_rest or 0.0)
    force = force * (info.signs.sign("force") or 1)
    atmosphere = info.atmosphere if columns["pressure"].absolute else None
    zero = (info.pressure_at_rest or 0.0) + (atmosphere or 0.0)
    pressure, warnings = check_pressures(
        columns["pressure"], raws["pressure"], force, zero, cell_error
    )
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
        *notes, *_title_note(table), *column_notes, *cells.notes, *rest_notes, *strain_notes,
        *clip_notes, *warnings, *(" ".join(text.split()) for text in [*texts, *info.notes]),
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
) -> tuple[TableColumns, list[Column]]:
    """The columns' cells, and inferred optional columns that hold something else."""
    named = set(columns) if info.names else {*info.columns, *info.units}
    texts = [columns[role].index for role in _TEXT_ROLES if role in columns]
    numbers = [c.index for role, c in columns.items() if role not in {*_TEXT_ROLES, "time"}]
    rows, misread = _row_range(info.rows), []
    time = columns.get("time")
    cells = table.read(numbers, texts, None if time is None else time.index, rows)
    if time is not None and time.index not in cells.numbers:
        if "time" in named:  # the error of its first bad cell
            cells = table.read([*numbers, time.index], texts, None, rows)
        else:
            misread.append(time)
    if (branch := columns.get("branch")) is not None and "branch" not in named:
        is_branch = {text.lower() for text in cells.texts[branch.index]} <= set(_BRANCHES)
        misread += [] if is_branch else [branch]
    return cells, misread


def _row_range(text: str | None) -> tuple[int, int]:
    """First and last row of a range such as "40:200", "40:" or ":200"."""
    if text is None:
        return 1, MAX_ROWS
    match = re.fullmatch(r"\s*(\d*)\s*:\s*(\d*)\s*", text, re.ASCII)
    first, last = (int(match[1] or 1), int(match[2] or MAX_ROWS)) if match else (0, 0)
    if not 1 <= first <= last:
        rule = "must be the first and the last row, from 1, with a colon"
        raise InvalidInputError("rows", rule, text, 'write such as "40:" or "40:200"')
    return first, last


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
    column: Column, raw: np.ndarray, rest_length: float, info: Sidecar, cell_error: CellError
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Contraction, from a column of strains, displacements or lengths."""
    values = to_si_units(raw, column.factor)
    sign = info.signs.sign(column.role) or info.signs.sign("strain") or column.sign
    if column.role == "strain":
        strain = values * sign
    elif column.role == "displacement":
        strain = (values - (info.displacement_at_rest or 0.0)) * sign / rest_length
        is_known = info.signs.sign(column.role) or info.signs.sign("strain") or column.sign < 0
        if not is_known and np.min(strain) < _STRETCHED and np.max(strain) < -_STRETCHED:
            message = str(cell_error(int(np.argmin(strain)), column, ""))
            raise MissingMetadataError(
                f"{message}all displacements stretch the muscle: if they grow with it, give ",
                ("signs", "displacement", "extension positive", ", else contraction positive"),
            )
    else:
        wrong = np.flatnonzero(values <= 0)
        if wrong.size:
            rule = f"{raw[wrong[0]]:g} is no length of a muscle"
            if raw[wrong[0]] == 0 and column.index >= 0:
                before = cell_error(int(wrong[0]), column, f"{rule}: if it counts from rest, give ")
                choice = ("columns", "displacement", column.header, "")
                raise MissingMetadataError(str(before), choice)
            raise cell_error(int(wrong[0]), column, f"{rule}.")
        strain = (rest_length - values) / rest_length
    check_strains(column, raw, strain, cell_error)
    notes, longest = (), float(np.min(strain))
    if longest < _STRETCHED:
        count = int(np.count_nonzero(strain < _STRETCHED))
        notes = (f"{count} readings stretched beyond rest, down to {longest:.3g}",)
    return strain + 0.0, notes  # without negative zeros


def _censored(
    table: Table, cells: TableColumns, column: Column | None, force: np.ndarray, info: Sidecar
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
    table: Table, cells: TableColumns, column: Column, meanings: Mapping[str, int], rule: str
) -> np.ndarray:
    """Meaning of the text in each cell of a column; the error for an unknown one says `rule`."""
    values = []
    for line, text in zip(cells.lines, cells.texts[column.index], strict=True):
        if (value := meanings.get(text.lower())) is None:
            raise table.cell_error(line, column.index, f"{text!r} isn't known: write {rule}.")
        values.append(value)
    return np.array(values)
