"""From a dynamometer's file, and the sidecar beside it, to a checked `Record`."""

import glob
import hashlib
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.findings import Finding
from ..io.input_file import read_bytes
from .formats import table_texts
from .headers import (
    Column,
    MissingMetadataError,
    choose_columns,
    is_unit,
    read_name,
    score,
    si_unit,
    unit_factor,
)
from .published import from_json
from .quantities import BRANCHES, Readings, is_flag_of_ways
from .record import Record, Source, join, note, warning
from .sidecar import Sidecar, read_sidecar, sidecar_beside
from .tables import MAX_ROWS, Table, open_table, read_seconds


LARGEST_FILE = 1_000_000_000  # bytes
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
      their order, with `-` for one to skip: `"force[N],pressure[kPa],-,length[mm]"`.
    - `units`: units of columns whose header has none, by role.
    - `rest_length`: reference length of the strains [m]; lengths and displacements need it.
    - `clipped_at_zero`: true if forces of exactly zero are clipped readings.
    - `header`: line of the columns' names, from 1; default: inferred.
    - `sidecar`: the TOML file; default: the one of the table's name, if there is one.
    - `constants`: values that all readings share, by role [SI].
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
    - `table`: sheet, matrix or group of a file with several, or a pattern such as `"*"` for all.
    - `decimal`: sign before decimals, "." or ","; the other may part thousands; default: inferred.
    - `default_length`: rest length where no file names one [m], such as the muscle's, with a
      warning; default: lengths and displacements are refused then.

    **Returns:** the record.

    **Raises:** `OSError` if a file can't be read; `ValueError`, in one line with file, line and
    column, for contents that aren't valid.
    """
    options = {
        "columns": columns, "units": units, "rest_length": rest_length,
        "clipped_at_zero": clipped_at_zero, "header": header, "constants": constants,
        "zeros": zeros, "signs": signs, "atmosphere": atmosphere, "moment_arm": moment_arm,
        "rows": rows, "scales": scales, "resample": resample, "table": table, "decimal": decimal,
    }  # fmt: skip
    records = []
    for file in _find_files(path):
        raw = read_bytes(file, LARGEST_FILE, "record", ": keep every tenth row, or split it.")
        if sidecar is None:
            info, found = sidecar_beside(file)
        else:
            info, found = read_sidecar(sidecar), [note("sidecar", sidecar=Path(sidecar).name)]
        records += _read_tables(raw, file, info, options, found, name_pattern, default_length)
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
    - `default_length`, `options`: of `load` [SI], but for `sidecar` and `name_pattern`.

    **Returns:** the record.

    **Raises:** `ValueError` as `load`.
    """
    raw, length = text.encode() if isinstance(text, str) else text, default_length
    records = _read_tables(raw, Path(source), Sidecar(), options, default_length=length)
    return _with_length(records[0] if len(records) == 1 else join(records), length)


def _with_length(record: Record, length: float | None) -> Record:
    """A record with the rest `length` [m] where no file named one, and a warning of it."""
    if length is None or record.rest_length is not None:
        return record
    finding = warning("default_length", length=length)
    return replace(record, rest_length=length, findings=(finding, *record.findings))


def _find_files(path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[Path]:
    """Files of a path or several, with patterns such as `"runs/*.csv"` replaced by what fits."""
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


def _read_tables(
    raw: bytes,
    path: Path,
    info: Sidecar,
    options: Mapping[str, Any],
    findings: Sequence[Finding] = (),
    name_pattern: str | None = None,
    default_length: float | None = None,
) -> list[Record]:
    """Record of each selected table in a file's bytes; `info`: of its sidecar."""
    is_published = re.match(rb"\s*(\{|\[\s*[\[{])", raw) is not None
    selected = options.get("table") or info.table
    texts = {"": raw} if is_published else table_texts(raw, str(path), selected)
    records = []
    for table, text in texts.items():
        table_info, found = info, [*findings]
        if name_pattern is not None:
            changes = read_name(path, name_pattern, table)
            table_info = info.model_copy(update=changes)
            found.append(note("name", values=changes))
        table_info = table_info.overruled(options)
        label = f", {table}" if len(texts) > 1 else ""
        source = f"{path}{label}"
        if is_published:
            records.append(_read_published(raw, source, table_info))
            continue
        record = _read_record(text, source, path, table_info, default_length)
        # a name of other bytes than UTF-8 has halves of characters, which no file can hold
        name = path.name.encode("utf-8", "replace").decode() + label
        records.append(replace(
            record,
            sources=(Source(name, hashlib.sha256(raw).hexdigest()),),
            notes=tuple(f"{name}: {text}" for text in record.notes),
            findings=tuple(replace(x, data={"file": name, **x.data})
                           for x in (*found, *record.findings)),
        ))  # fmt: skip
    return records


def _read_published(raw: bytes, source: str, info: Sidecar) -> Record:
    """Record of a JSON file, which states everything but perhaps its rest length."""
    record, length = from_json(raw, source), info.rest_length
    if info.model_copy(update={"rest_length": None}) != Sidecar():
        rule = "a published record states its columns, units and notes: leave out options and TOML."
        raise ValueError(f"{source}: {rule}")
    if length is not None and record.rest_length not in (None, length):
        raise ValueError(f"{source}: its rest length is {record.rest_length} m, not {length} m.")
    return record if length is None else replace(record, rest_length=length)


def _read_record(
    text: bytes, source: str, path: Path, info: Sidecar, default_length: float | None
) -> Record:
    """Record of a table's text; `source`: its name in errors, `path`: of its file."""
    table = open_table(text, source, info.header, info.names, info.decimal)
    header_lines = (*table.remarks, *table.titles)
    remarks = [(match[1].lower(), match[2]) for match in map(_REMARK.match, header_lines) if match]
    readings = _read_columns(table, info)
    rest_length, written = info.rest_length, dict(remarks).get("rest_length")
    if rest_length is None and written is not None:
        try:
            rest_length = info.overruled({"rest_length": written.strip('" ')}).rest_length
        except ValueError as error:
            raise ValueError(f"{source}: in its remarks, {error}") from None
        readings.findings.append(note("rest_length", length=rest_length))
    position = readings.position
    needs_length = rest_length is None and position.role != "strain"
    if needs_length and default_length is None:
        rule = f"a {position.role} needs the rest length: give "
        toml = f"{path.stem or 'its'}.toml"
        after = f', or write rest_length = "300 mm" in {toml} beside it'
        choice = ("rest_length", "", "", after)
        raise MissingMetadataError(f"{table.place(position.header)}: {rule}", choice)
    readings.convert(rest_length or default_length or np.nan)
    synthetic = [text.lower() for text in header_lines if text.lower().startswith("synthetic")]
    denials = ("false", "no", "0")
    zeros = {
        "force": (info.force_at_rest, info.torque_at_rest),
        "pressure": (info.pressure_at_rest,),
        "displacement": (info.displacement_at_rest,),
    }
    texts = [*([] if info.source is None else [f"source: {info.source}"]), *info.notes]
    texts += [f"{key}: {text}" for key, text in remarks if key in {"source", "note"}]
    record = Record(
        readings.pressure, readings.strain, readings.force, readings.read_censored(),
        readings.read_branch(), readings.read_time(), rest_length,
        readings.si("moment_arm") if "moment_arm" in readings.columns else None,
        synthetic=info.synthetic
        or any(text[9:].strip(" :=.") not in denials for text in synthetic),
        notes=tuple(" ".join(text.split()) for text in texts),
        findings=tuple(readings.findings),
        zeroed=tuple(name for name, values in zeros.items() if set(values) != {None}),
    )  # fmt: skip
    return _with_length(record, default_length) if needs_length else record


def _read_columns(table: Table, info: Sidecar) -> Readings:
    """Cells of the columns and constants of a `table`."""
    import pandas as pd

    columns, findings = choose_columns(table, info)
    unused = sorted(info.units.keys() - columns.keys())
    findings += [warning("unused_unit", unit=info.units[role], role=role) for role in unused]
    readings = Readings(table, columns, pd.DataFrame(), info, findings)
    rows = _row_range(info.rows)
    if info.resample is None:
        _read_cells(readings, rows)
    else:
        _read_resampled(readings, rows, info.resample)
    for role, value in info.constants.items():
        readings.cells[role], columns[role] = value, Column(role, -1, role, si_unit(role))
    if info.constants:
        findings.append(note("constants", values=info.constants))
    return readings


def _read_cells(readings: Readings, rows: tuple[int, int] | None) -> None:
    """Read the cells of the columns; drop a time or branch that the header only seems to name."""
    import pandas as pd

    table, columns, info = readings.table, readings.columns, readings.info
    named = set(columns) if info.names else {*info.columns, *info.units}
    numbers, time = [column.index for column in _numeric(columns).values()], columns.get("time")
    if time is None or "time" not in named:
        _check_clocks(table, sorted(set(_clocks(table, numbers).values())), rows)
    frame, left_out = table.read(numbers, rows)
    if time is not None:
        seconds = read_seconds(frame[time.index], table.numbers)
        if seconds is None and "time" in named:  # the error of its first bad cell
            frame, left_out = table.read([*numbers, time.index], rows)
        elif seconds is not None:
            frame[time.index] = seconds
    cells = {role: frame[column.index] for role, column in columns.items()}
    for role in columns.keys() & {"branch", "clipped"}:
        cells[role] = cells[role].astype(str).str.lower()
    readings.cells = pd.DataFrame(cells)
    is_misread = {
        "time": time is not None and cells["time"].dtype != float,
        "branch": "branch" in columns
        and (not {*cells["branch"]} <= {*BRANCHES} or is_flag_of_ways(cells["branch"])),
    }
    for role, is_other in is_misread.items():
        if is_other and role not in named:
            column = columns.pop(role).header
            readings.findings.append(warning("misread_column", column=column, role=role))
    readings.findings += left_out


def _numeric(columns: Mapping[str, Column]) -> dict[str, Column]:
    """Columns of quantities, but for the time."""
    return {r: column for r, column in columns.items() if r not in ("branch", "clipped", "time")}


def _clocks(table: Table, columns: Sequence[int]) -> dict[int, int]:
    """Index of the column of time before each of the `columns`, else of the first; or empty."""
    times = [i for i, name in enumerate(table.header)
             if name and score(name, table.units[i], "time") > 1 and i not in columns]  # fmt: skip
    return {i: max([times[0], *(time for time in times if time < i)]) for i in columns if times}


def _check_clocks(table: Table, clocks: list[int], rows: tuple[int, int] | None) -> None:
    """Refuse channels that were read at different times: by more than half a step in a row."""
    if len(clocks) < 2:
        return
    frame = table.read([], rows)[0][clocks]
    frame = frame[(frame != "").all(axis=1)]
    read = {i: read_seconds(frame[i], table.numbers) for i in clocks if len(frame)}
    times = [(table.header[i], seconds) for i, seconds in read.items() if seconds is not None]
    if len(times) < 2:
        return
    first_name, first = times[0]
    step = float(np.median(np.abs(np.diff(first)))) if len(frame) > 1 else 0.0
    for name, seconds in times[1:]:
        # clocks of one name count from one time
        shift = 0.0 if name == first_name else seconds[0] - first[0]
        difference = float(np.max(np.abs(seconds - first - shift)))
        if difference > step / 2:
            rule = f"the channels have clocks of their own, in one row up to {difference:.3g} apart"
            choices = [("resample", "", f"{step:g} s", ", or another step")]
            if len({name for name, _ in times}) == len(times):
                after = " or another of them, if a row was read at one time"
                choices.append(("columns", "time", first_name, after))
            remedy = "to interpolate them on one clock, give "
            raise MissingMetadataError(f"{table.where}: {rule}: {remedy}", *choices)


def _read_resampled(readings: Readings, rows: tuple[int, int] | None, step: float) -> None:
    """Fill `readings`, interpolated to one clock of `step` [s]; `rows`: first and last to read."""
    import pandas as pd

    table, numbers = readings.table, _numeric(readings.columns)
    clocks = _clocks(table, [column.index for column in numbers.values()])
    frames, times = list[pd.DataFrame](), list[np.ndarray]()
    for column in numbers.values():
        if column.index not in clocks:
            raise ValueError(f"{table.where}: no column of time, by which to resample.")
        clock = clocks[column.index]
        frame, _ = table.read([column.index], rows, sparse=True)
        unit, seconds = table.stated_unit(clock, "time"), read_seconds(frame[clock], table.numbers)
        if seconds is None or np.any(np.diff(seconds) <= 0):
            raise ValueError(f"{table.place(table.header[clock])}: no rising times.")
        frames.append(frame)
        times.append(seconds * (unit_factor(unit, "time") if is_unit(unit, "time") else 1.0))
    start, end = max(t[0] for t in times), min(t[-1] for t in times)
    # the end itself, where the steps reach it but for rounding
    count = int((end - start) / step * (1 + 1e-12)) + 1 if end > start else 0
    if not 2 <= count <= MAX_ROWS:
        rule = f"must give 2 to {MAX_ROWS} readings over the {end - start:.6g} s that all have"
        raise InvalidInputError("resample", rule, step, shown=f"{step:g} s")
    grid = start + step * np.arange(count)
    nearest = np.minimum(np.searchsorted(times[0], grid), times[0].size - 1)
    readings.cells = pd.DataFrame({"time": grid}, index=frames[0].index[nearest])
    for (role, column), t, frame in zip(numbers.items(), times, frames, strict=True):
        readings.cells[role] = np.interp(grid, t, frame[column.index])
    readings.columns.clear()
    readings.columns.update(numbers, time=Column("time", -1, "time", "s"))
    readings.findings.append(note("resampled", step=step))


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
