"""From a dynamometer's file, and the sidecar beside it, to a checked `Record`."""

import glob
import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import to_si
from ..io.input_file import read_bytes
from ..units import parse, pretty
from .formats import table_texts
from .headers import (
    CONSTANTS,
    ROLES,
    Column,
    MissingMetadataError,
    check_roles,
    choose_columns,
    dimension_of,
    is_unit,
    read_name,
    read_scale,
    score,
    si_unit,
    split_names,
    unit_factor,
)
from .joint import read_arm_table
from .published import from_json
from .quantities import (
    BRANCHES,
    Readings,
    check_atmosphere,
    check_pull,
    read_branch,
    read_censored,
    read_force,
    read_joint,
    read_pressure,
    read_strain,
    read_time,
)
from .record import Record, Source, join
from .sidecar import ZEROS, Sidecar, Signs, read_sidecar, sidecar_beside
from .tables import MAX_ROWS, Table, TableColumns, open_table, read_seconds


LARGEST_FILE = 1_000_000_000  # bytes
_TEXT_ROLES = ("branch", "clipped")
_REMARK = re.compile(r"(\w+)\s*[:=]\s*(.*)")  # key: text, or key = text


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
    moment_arm: Any = None,
    rows: str | None = None,
    scales: Mapping[str, str] | None = None,
    resample: Any = None,
    table: str | None = None,
    decimal: str | None = None,
    default_length: float | None = None,
) -> Record:
    """Read a dynamometer's file, or several of one muscle as one record.

    An argument overrules the TOML file beside the table, and that overrules the table.

    **Arguments:**

    - `path`: the file (text, .xlsx, .mat, .tdms, or .json as `write` makes it), or several of one
      muscle; patterns such as `"runs/*.csv"` stand for all files that fit.
    - `columns`: headers of columns that aren't recognized, by role: pressure, force, torque,
      strain, length, displacement, angle, moment_arm, time, branch, clipped. Or all columns in
      their order, such as `"force[N],pressure[kPa],-,length[mm]"`, with `-` for one to skip: for
      files without header.
    - `units`: units of columns whose header has none, by role.
    - `rest_length`: reference length of the strains [m]; lengths and displacements need it.
    - `clipped_at_zero`: true if forces of exactly zero are clipped readings.
    - `header`: line of the columns' names, counted from 1; default: it is inferred.
    - `sidecar`: the TOML file; default: the one of the table's name, if there is one.
    - `constants`: pressure, force, strain, length, displacement, torque or angle of all readings
      [SI].
    - `name_pattern`: constants in the name of the file or of its table, such as
      `"{length}cm_{pressure}kPa"`.
    - `zeros`: readings of pressure, force, torque and displacement at zero, or at rest, and the
      angle at the rest length [SI].
    - `signs`: directions by role: "pushing positive", "extension positive" and their opposites.
    - `atmosphere`: to subtract from absolute pressures [Pa].
    - `moment_arm`: of the muscle about the joint whose torque was measured [m]; or a table
      `{"angle": …, "arm": …}` [rad], [m], between whose angles it is linear.
    - `rows`: first and last row to read, such as `"40:200"` or `"40:"`, from 1 below the header.
    - `scales`: quantities of gauges' signals by role, such as `{"pressure": "1.475bar/V"}`; their
      zeros may be signals, too: `zeros={"pressure": "0.2V"}`.
    - `resample`: step of one clock on which channels with clocks of their own are interpolated [s].
    - `table`: sheet, matrix or group of a file with several, or a pattern such as `"*"`: all
      tables that fit it are one record.
    - `decimal`: sign before decimals, "." or ","; the other one may part thousands. Default: it is
      inferred.
    - `default_length`: rest length where no file names one [m], such as the muscle's; a doubt says
      so. Default: lengths and displacements are refused then.

    **Returns:** the record.

    **Raises:** `OSError` if a file can't be read; `ValueError`, in one line with file, line and
    column, for contents that aren't valid.
    """
    options: dict[str, Any] = {
        "columns": columns, "units": units, "rest_length": rest_length,
        "clipped_at_zero": clipped_at_zero, "header": header, "constants": constants,
        "zeros": zeros, "signs": signs, "atmosphere": atmosphere, "moment_arm": moment_arm,
        "rows": rows, "scales": scales, "resample": resample, "table": table, "decimal": decimal,
    }  # fmt: skip
    records = []
    for file in find_files(path):
        raw = read_bytes(file, LARGEST_FILE, "record", ": keep every tenth row, or split it.")
        if sidecar is None:
            info, notes = sidecar_beside(file)
        else:
            info, notes = read_sidecar(sidecar), (f"{Path(sidecar).name} read with it",)
        records += _read_tables(raw, file, info, options, notes, name_pattern, default_length)
    return _with_length(records[0] if len(records) == 1 else join(records), default_length)


def loads(
    text: str | bytes,
    source: str = "<text>",
    *,
    default_length: float | None = None,
    **options: Any,
) -> Record:
    """Read a dynamometer's table from text, or from the bytes of a file.

    **Arguments:**

    - `text`: the table.
    - `source`: its name in errors.
    - `default_length`: as of `load` [m].
    - `options`: of `load`, but for `sidecar` and `name_pattern`.

    **Returns:** the record.

    **Raises:** `ValueError` as `load`.
    """
    raw = text.encode() if isinstance(text, str) else text
    length = default_length
    records = _read_tables(raw, Path(source), Sidecar(), options, (), default_length=length)
    return _with_length(records[0] if len(records) == 1 else join(records), length)


def _with_length(record: Record, length: float | None) -> Record:
    """A record with the rest `length` [m] where no file named one, and a doubt of it."""
    if length is None or record.rest_length is not None:
        return record
    note = f"no rest length given: strains refer to the muscle's length, {pretty(length, 'length')}"
    return replace(record, rest_length=length, notes=(*record.notes, note),
                   doubts=(note, *record.doubts))  # fmt: skip


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
    roles = {"columns": ROLES, "units": ROLES, "scales": ROLES, "signs": tuple(Signs.model_fields),
             "constants": CONSTANTS, "zeros": ZEROS}  # fmt: skip
    for argument, choices in roles.items():
        check_roles(changes.get(argument, {}), argument, choices)
    scales = {role: read_scale(text, role) for role, text in changes.get("scales", {}).items()}
    changes["scales"] = info.scales | scales
    for argument in ("columns", "units"):
        changes[argument] = {**getattr(info, argument), **changes.get(argument, {})}
    if signs := changes.pop("signs", {}):
        full = {role: _direction(role, text) for role, text in signs.items()}
        changes["signs"] = info.signs.model_copy(update=full)
    quantities = {role: (role, value) for role, value in changes.pop("constants", {}).items()}
    for role, value in changes.pop("zeros", {}).items():
        scale = changes["scales"].get(role)
        quantities[f"{role}_at_rest"] = role, scale.zero(value) if scale else value
    sizes = (("rest_length", "length"), ("atmosphere", "pressure"), ("resample", "time"))
    for name, role in sizes:
        if name in changes:
            quantities[name] = role, changes[name]
    if isinstance(arm := changes.get("moment_arm"), Mapping):
        changes["moment_arm"] = read_arm_table(arm)
    elif arm is not None:
        quantities["moment_arm"] = "moment_arm", arm
    for name, (role, value) in quantities.items():
        number = float(to_si(value, name, si_unit(role)))
        is_size = name in ("rest_length", "moment_arm", "resample")
        if not np.isfinite(number) or (is_size and number <= 0):
            rule = f"must be {'positive and ' if is_size else ''}finite"
            raise InvalidInputError(name, rule, number, shown=f"{number} {si_unit(role)}")
        changes[name] = number
    return info.model_copy(update=changes)


def _direction(role: str, text: str) -> str:
    """A direction in full: "pushing" is "pushing positive"."""
    choices = get_args(get_args(Signs.model_fields[role].annotation)[0])
    direction = f"{text.removesuffix('positive').strip()} positive"
    if direction not in choices:
        raise InvalidInputError("signs", f"of {role} must be {' or '.join(choices)}", text)
    return direction


def _list_values(values: Mapping[str, float]) -> str:
    return ", ".join(
        f"{role} {pretty(value, dimension_of(role))}" for role, value in values.items()
    )


def _read_tables(
    raw: bytes,
    path: Path,
    info: Sidecar,
    options: Mapping[str, Any],
    notes: tuple[str, ...],
    name_pattern: str | None = None,
    default_length: float | None = None,
) -> list[Record]:
    """Record of each selected table in a file's `raw` bytes; `info` of it, overruled by the
    `name_pattern` and the `options`; `default_length` [m] of lengths without a rest length.
    """
    is_published = re.match(rb"\s*(\{|\[\s*[\[{])", raw) is not None
    selected = options.get("table") or info.table
    texts = {"": raw} if is_published else table_texts(raw, str(path), selected)
    records = []
    for table, text in texts.items():
        table_info, table_notes = info, notes
        if name_pattern is not None:
            changes = read_name(path, name_pattern, table)
            table_info = info.model_copy(update=changes)
            table_notes += (f"its name gives {_list_values(changes)}",)
        table_info = _overrule(table_info, **options)
        # a name of other bytes than UTF-8 has halves of characters, which no file can hold
        name = path.name.encode("utf-8", "replace").decode()
        label = f", {table}" if len(texts) > 1 else ""
        source = f"{path}{label}"
        if is_published:
            records.append(_read_published(raw, source, table_info))
            continue
        record = _read_record(text, source, path, table_info, default_length)
        notes_of_record = (*table_notes, *record.notes)
        records.append(replace(
            record,
            sources=(Source(f"{name}{label}", hashlib.sha256(raw).hexdigest()),),
            notes=tuple(f"{name}{label}: {note}" for note in notes_of_record),
            doubts=tuple(f"{name}{label}: {note}" for note in record.doubts),
        ))  # fmt: skip
    return records


def _read_record(
    text: bytes, source: str, path: Path, info: Sidecar, default_length: float | None
) -> Record:
    """Record of a table's text; `source`: its name in errors, `path`: of its file;
    `default_length` [m]: of lengths without a rest length.
    """
    table = open_table(text, source, info.header, info.names, decimal=info.decimal)
    header_lines = (*table.remarks, *table.titles)
    remarks = [(match[1].lower(), match[2]) for match in map(_REMARK.match, header_lines) if match]
    rest_length, rest_notes = _rest_length(table, info, dict(remarks))
    readings, column_notes, column_doubts = _read_numbers(table, info)
    position = readings.position
    needs_length = rest_length is None and position.role != "strain"
    if needs_length and default_length is None:
        before = (
            f"{table.where}, column `{position.header}`: a {position.role} needs the rest length:"
            " give "
        )
        toml = f"{path.stem or 'its'}.toml"
        after = f', or write rest_length = "300 mm" in {toml} beside it'
        raise MissingMetadataError(before, ("rest_length", "", "", after))
    joint = read_joint(readings, info)
    if joint is not None:
        readings = readings.only(joint.used)
    force = read_force(readings, joint, info)
    pressure, warnings = read_pressure(readings, force, info)
    length = rest_length or default_length or np.nan
    try:
        strain, strain_notes = read_strain(readings, joint, length, pressure, force, info)
    except MissingMetadataError:
        raise
    except ValueError as error:
        if not needs_length:
            raise
        raise ValueError(
            f"{error} Contractions were taken over the muscle's length, {pretty(length, 'length')}:"
            " give the record's rest length if it differs."
        ) from None
    check_pull(readings, strain, pressure, force, info)
    warnings += check_atmosphere(readings, strain, pressure, force)
    censored, clip_notes = read_censored(readings, force, info)
    time, time_notes, time_doubts = read_time(readings)
    texts = [] if info.source is None else [f"source: {info.source}"]
    joint_notes = joint.notes if joint else ()
    doubts = (*column_doubts, *joint_notes, *strain_notes, *clip_notes, *warnings, *time_doubts)
    notes = (
        *column_notes, *rest_notes, *time_notes, *doubts,
        *(" ".join(text.split()) for text in [*texts, *info.notes]),
        *(f"{key}: {text}" for key, text in remarks if key in {"source", "note"}),
    )  # fmt: skip
    record = Record(
        pressure, strain, force, censored, read_branch(readings), time, rest_length,
        joint.arm if joint else readings.si("moment_arm"),
        synthetic=info.synthetic or _is_synthetic(header_lines),
        notes=notes, doubts=doubts, zeroed=_zeroed_channels(info),
    )  # fmt: skip
    return _with_length(record, default_length) if needs_length else record


def _zeroed_channels(info: Sidecar) -> tuple[str, ...]:
    """Channels whose reading at zero, or at rest, was given."""
    zeros = {
        "force": (info.force_at_rest, info.torque_at_rest),
        "pressure": (info.pressure_at_rest,),
        "displacement": (info.displacement_at_rest,),
    }
    return tuple(name for name, values in zeros.items() if any(x is not None for x in values))


def _read_published(raw: bytes, source: str, info: Sidecar) -> Record:
    """Record of a JSON file, which states everything but perhaps its rest length."""
    record = from_json(raw, source)
    if info.model_copy(update={"rest_length": None}) != Sidecar():
        rule = "a published record states its columns, units and notes: leave out options and TOML."
        raise ValueError(f"{source}: {rule}")
    if info.rest_length is None:
        return record
    if record.rest_length not in (None, info.rest_length):
        raise ValueError(
            f"{source}: its rest length is {record.rest_length} m, not {info.rest_length} m."
        )
    return replace(record, rest_length=info.rest_length)


def _read_numbers(table: Table, info: Sidecar) -> tuple[Readings, tuple[str, ...], tuple[str, ...]]:
    """Numbers of the columns and constants of a `table`, notes and doubts."""
    constants = info.constants
    constant_roles = constants.keys() | ({"moment_arm"} if info.arm_table else set())
    columns, unread = choose_columns(
        table, info.columns, info.units, constant_roles, names=info.names, scales=info.scales,
        atmosphere=info.atmosphere is not None,
    )  # fmt: skip
    columns = {role: column for role, column in columns.items() if role not in constant_roles}
    notes = [*(column.note() for column in columns.values()), *unread]
    doubts = [f"unit {info.units[role]!r} of {role} not used: there is no such column"
              for role in info.units.keys() - columns.keys()]  # fmt: skip
    if info.resample is not None:
        columns, cells = _resample(table, columns, info)
        notes.append(f"channels interpolated on one clock, every {info.resample:g} s")
    else:
        cells, misread = _read_cells(table, columns, info)
        for column in misread:
            del columns[column.role]
            doubts.append(
                f"column `{column.header}` not read as {column.role}: it holds something else"
            )
    texts = {role: np.array(cells.texts[columns[role].index], dtype=object)
             for role in _TEXT_ROLES if role in columns}  # fmt: skip
    raws = {role: cells.numbers[c.index] for role, c in columns.items() if role not in texts}
    if constants:
        raws |= {role: np.full(cells.lines.size, value) for role, value in constants.items()}
        columns |= {role: Column(role, -1, role, si_unit(role)) for role in constants}
        notes.append(f"all readings at {_list_values(constants)}")
    readings = Readings(table, columns, raws, texts, cells.lines)
    return readings, tuple(notes), (*doubts, *cells.notes)


def _read_cells(
    table: Table, columns: Mapping[str, Column], info: Sidecar
) -> tuple[TableColumns, list[Column]]:
    """The columns' cells, and the columns of time and branch, inferred from the header, whose cells
    are no times or branches.
    """
    named = set(columns) if info.names else {*info.columns, *info.units}
    texts = [columns[role].index for role in _TEXT_ROLES if role in columns]
    numbers = [c.index for role, c in columns.items() if role not in {*_TEXT_ROLES, "time"}]
    rows, misread = _row_range(info.rows), []
    time = columns.get("time")
    if time is None or "time" not in named:
        _check_clocks(table, sorted(set(_clocks(table, numbers).values())), rows)
    cells = table.read(numbers, texts, None if time is None else time.index, rows)
    if time is not None and time.index not in cells.numbers:
        if "time" in named:  # the error of its first bad cell
            cells = table.read([*numbers, time.index], texts, None, rows)
        else:
            misread.append(time)
    if (branch := columns.get("branch")) is not None and "branch" not in named:
        is_branch = {text.lower() for text in cells.texts[branch.index]} <= set(BRANCHES)
        misread += [] if is_branch else [branch]
    return cells, misread


def _clocks(table: Table, columns: Sequence[int]) -> dict[int, int]:
    """Index of the column of time that stands before each of the `columns` of numbers, else of the
    first one; empty for a table without times.
    """
    times = [i for i, name in enumerate(table.header)
             if name and score(name, table.units[i], "time") > 1 and i not in columns]  # fmt: skip
    return {i: max([times[0], *(time for time in times if time < i)]) for i in columns if times}


def _check_clocks(table: Table, clocks: Sequence[int], rows: tuple[int, int] | None) -> None:
    """Refuse channels that were read at different times: by more than half a step in a row."""
    if len(clocks) < 2:
        return
    texts = table.read([], clocks, None, rows).texts
    complete = [cells for cells in zip(*(texts[i] for i in clocks), strict=True) if all(cells)]
    columns = zip(clocks, zip(*complete, strict=True), strict=False)
    times = {i: read_seconds(cells, table.numbers) for i, cells in columns}
    seconds = [values for values in times.values() if values is not None]
    if len(seconds) < 2:
        return
    names = [table.header[i] for i, values in times.items() if values is not None]
    first = seconds[0]
    step = float(np.median(np.abs(np.diff(first)))) if first.size > 1 else 0.0
    for name, times_of_name in zip(names[1:], seconds[1:], strict=True):
        # clocks of one name count from one time
        shift = 0.0 if name == names[0] else times_of_name[0] - first[0]
        difference = float(np.max(np.abs(times_of_name - first - shift)))
        if difference > step / 2:
            before = (
                f"{table.where}: the channels have clocks of their own, in one row up to"
                f" {difference:.3g} apart: to interpolate them on one clock, give "
            )
            choices = [("resample", "", f"{step:g} s", ", or another step")]
            if len(set(names)) == len(names):
                after = " or another of them, if a row was read at one time"
                choices.append(("columns", "time", names[0], after))
            raise MissingMetadataError(before, *choices)


def _resample(
    table: Table, columns: Mapping[str, Column], info: Sidecar
) -> tuple[dict[str, Column], TableColumns]:
    """The columns of numbers, each read with its own clock and interpolated on one clock."""
    step, rows = info.resample or 0.0, _row_range(info.rows)
    numbers = [c.index for role, c in columns.items() if role not in {*_TEXT_ROLES, "time"}]
    clocks = _clocks(table, numbers)
    channels: dict[int, TableColumns] = {}
    for index in numbers:
        if index not in clocks:
            raise ValueError(f"{table.where}: no column of time, by which to resample.")
        channels[index] = table.read([index], [], clocks[index], rows, sparse=True)
    times: dict[int, np.ndarray] = {}
    for index, channel in channels.items():
        clock = clocks[index]
        unit = table.stated_unit(clock, "time")
        factor = unit_factor(unit, "time") if is_unit(unit, ("time",)) else 1.0
        if clock not in channel.numbers or np.any(np.diff(channel.numbers[clock]) <= 0):
            raise ValueError(f"{table.where}, column `{table.header[clock]}`: no rising times.")
        times[index] = factor * channel.numbers[clock]
    start, end = max(x[0] for x in times.values()), min(x[-1] for x in times.values())
    # the end itself, where the steps reach it but for rounding
    count = int((end - start) / step * (1 + 1e-12)) + 1 if end > start else 0
    if not 2 <= count <= MAX_ROWS:
        rule = f"must give 2 to {MAX_ROWS} readings over the {end - start:.6g} s that all have"
        raise InvalidInputError("resample", rule, step, shown=f"{step:g} s")
    grid = start + step * np.arange(count)
    first = numbers[0]
    nearest = np.minimum(np.searchsorted(times[first], grid), times[first].size - 1)
    values = {i: np.interp(grid, times[i], channels[i].numbers[i]) for i in numbers}
    time = Column("time", -1, "time", "s")
    resampled = {role: column for role, column in columns.items() if column.index in values}
    cells = TableColumns(values | {-1: grid}, {}, channels[first].lines[nearest], ())
    return resampled | {"time": time}, cells


def _row_range(text: str | None) -> tuple[int, int] | None:
    """First and last row of a range such as "40:200", "40:" or ":200"; `None` without one."""
    if text is None:
        return None
    match = re.fullmatch(r"\s*(\d*)\s*:\s*(\d*)\s*", text, re.ASCII)
    first, last = (int(match[1] or 1), int(match[2] or MAX_ROWS)) if match else (0, 0)
    if not 1 <= first <= last:
        rule = "must be the first and the last row, from 1, with a colon"
        raise InvalidInputError("rows", rule, text, 'write such as "40:" or "40:200"')
    return first, last


def _is_synthetic(remarks: Sequence[str]) -> bool:
    """True if a remark begins with "synthetic" and doesn't deny it."""
    texts = [text.lower() for text in remarks if text.lower().startswith("synthetic")]
    return any(
        text.removeprefix("synthetic").strip(" :=.") not in {"false", "no", "0"} for text in texts
    )


def _rest_length(
    table: Table, info: Sidecar, remarks: Mapping[str, str]
) -> tuple[float | None, tuple[str, ...]]:
    """Rest length [m], of the sidecar or else of the `remarks`, or `None`; and a note."""
    if info.rest_length is not None or "rest_length" not in remarks:
        return info.rest_length, ()
    try:
        length = parse(remarks["rest_length"].strip('" '), "length", "rest_length")
    except ValueError as error:
        raise ValueError(f"{table.source}: in its remarks, {error}") from None
    if length <= 0:
        raise ValueError(f"{table.source}: in its remarks, `rest_length` must be positive.")
    return length, (f"rest length {pretty(length, 'length')} read from the file's comments",)
