"""Spreadsheets and binary files of instruments as text tables: .xlsx, .mat, .tdms.

openpyxl, SciPy and npTDMS parse; here their columns get names and units. A file with several tables
(sheets, structures, groups) is refused unless some are named or only one has readings.
"""

import fnmatch
import io
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.errors import require
from .headers import ROLES, MissingMetadataError
from .tables import has_readings


if TYPE_CHECKING:
    import pandas as pd
    from openpyxl.cell import Cell, MergedCell

# first bytes of files that can't be read, and what to do
_REMEDIES = {
    b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1": "an Excel file of before 2007: save it as .xlsx or CSV",
    b"\x89HDF\r\n\x1a\n": "an HDF5 file; if MATLAB wrote it, save it with save(…, '-v7')",
    b"\x1f\x8b": "a compressed file: unpack it, or export its readings as CSV",
    b"%PDF": "a PDF: export the readings as CSV",
    **dict.fromkeys(
        (b"<html", b"<!doctype", b"<table", b"<?xml"), "a web page or XML: save it as .xlsx or CSV"
    ),
}
_MAX_CELLS = 20_000_000  # of a sheet: a cell at its far corner makes 17 thousand million
_CHANNEL_DATA = ("data", "values", "value", "y")  # keys of a structure that is one channel
_COMPRESSED = 15  # type of a compressed element of a .mat file
_LABELS = ("colheaders", "names", "labels", "columns", "header", "headers", "channels")


def table_texts(raw: bytes, source: str, table: str | None = None) -> dict[str, bytes]:
    """Text of a file's table, or of several, by name; a text file is one without name.

    **Arguments:**

    - `raw`: the file's bytes; `source`: its name in errors.
    - `table`: name of the sheet, structure or group, or a pattern such as `"*"` for all with
      readings that it fits; default: the one with readings.

    **Raises:** `ValueError` for a file that can't be read; `MissingExtraError` if its library isn't
    installed.
    """
    beginning = raw[:64].lstrip().lower()
    for start, remedy in _REMEDIES.items():
        if beginning.startswith(start.lower()):
            raise ValueError(f"{source}: {remedy}.")
    if raw.startswith(b"PK\3\4"):
        tables = _sheets(raw, source)
    elif raw.startswith(b"TDSm"):
        tables = _groups(raw, source)
    elif raw.startswith(b"MATLAB") or (source.lower().endswith(".mat") and b"\0" in raw):
        tables = _structures(raw, source)
    elif table is not None:
        raise ValueError(
            f"{source}: no table `{table}`: a text file holds one, leave the name out."
        )
    else:
        return {"": raw}
    names = [name for name in tables if table is not None and name.lower() == table.lower()]
    if not names:
        pattern = "*" if table is None else table.lower()
        fits = [name for name in tables if fnmatch.fnmatchcase(name.lower(), pattern)]
        if not fits and table is not None:
            listed = ", ".join(f"`{name}`" for name in tables) or "none"
            raise ValueError(f"{source}: no table `{table}`: there are {listed}.")
        names = [name for name in fits if has_readings(tables[name])]
    if not names:
        raise ValueError(f"{source}: no table of numbers in it: export the readings as CSV.")
    if len(names) > 1 and table is None:
        listed = ", ".join(f"`{name}`" for name in names)
        before = f"{source}: several tables, {listed}: choose one with "
        longest = max(names, key=lambda name: tables[name].count(b"\n"))  # others hold results
        several = ("table", "", "*", " for all, if of one muscle")
        raise MissingMetadataError(before, ("table", "", longest, ""), several)
    return {name: tables[name] for name in names}


def unpacked_size(raw: bytes, limit: int) -> int:
    """Size of what an .xlsx or .mat file holds compressed [bytes], counted up to a `limit`."""
    if raw.startswith(b"PK\3\4"):
        try:
            return sum(entry.file_size for entry in zipfile.ZipFile(io.BytesIO(raw)).infolist())
        except zipfile.BadZipFile:
            return len(raw)
    total, start = len(raw), 128  # bytes of the header of a .mat file
    is_little, is_binary = raw[126:128] == b"IM", b"\0" in raw[:128]
    while is_binary and start + 8 <= len(raw) and total <= limit:
        kind, size = struct.unpack_from("<II" if is_little else ">II", raw, start)
        if kind == _COMPRESSED:
            content = zlib.decompressobj()
            try:
                total += len(content.decompress(raw[start + 8 : start + 8 + size], limit + 1))
            except zlib.error:
                return total
        start += 8 + size
    return total


def _sheets(raw: bytes, source: str) -> dict[str, bytes]:
    """Tab-separated text of each sheet of an .xlsx file, by name."""
    require("openpyxl")
    from openpyxl import load_workbook

    def texts(column: Sequence["Cell | MergedCell"]) -> list[str]:
        """Texts of a column's cells; below a text with %, those that Excel shows in % as shown."""
        has_percent, cells = False, []
        for cell in column:
            value = cell.value
            has_percent = has_percent or (isinstance(value, str) and "%" in value)
            if isinstance(value, int | float) and "%" in cell.number_format and has_percent:
                value *= 100
            cells.append("" if value is None else " ".join(str(value).split()).replace('"', ""))
        return cells

    with _refusal(f"{source}: can't be read as .xlsx", ": save it as .xlsx or CSV."):
        book = load_workbook(io.BytesIO(raw), data_only=True)
    for sheet in book.worksheets:
        if sheet.max_row * sheet.max_column > _MAX_CELLS:
            size = f"{sheet.max_row} rows and {sheet.max_column} columns"
            remedy = "delete the empty ones, or export the readings as CSV"
            raise ValueError(f"{source}: sheet `{sheet.title}` has {size}: {remedy}.")
        for area in list(sheet.merged_cells.ranges):
            value = sheet.cell(area.min_row, area.min_col).value
            if isinstance(value, int | float) and area.min_row < area.max_row:
                sheet.unmerge_cells(area.coord)
                for row in range(area.min_row, area.max_row + 1):
                    sheet.cell(row, area.min_col, value)
    return {
        sheet.title: "".join(
            "\t".join(row) + "\n" for row in zip(*map(texts, sheet.iter_cols()), strict=True)
        ).encode()
        for sheet in book.worksheets
    }


def _groups(raw: bytes, source: str) -> dict[str, bytes]:
    """Tab-separated text of each group of a .tdms file, by name."""
    require("nptdms")
    import pandas as pd
    from nptdms import TdmsFile

    with _refusal(f"{source}: can't be read as .tdms"):
        file = TdmsFile.read(io.BytesIO(raw))
    tables: dict[str, dict[str, pd.Series]] = {}
    for group in file.groups():
        steps = {channel.properties.get("wf_increment") for channel in group.channels()}
        is_one = len(steps - {None}) <= 1
        for channel in group.channels():
            step, offset = map(channel.properties.get, ("wf_increment", "wf_start_offset"))
            # rows of channels at several rates are of different times
            name = group.name if is_one or not step else f"{group.name}, every {step:g} s"
            columns = tables.setdefault(name, {})
            if step and len(channel):
                times = (offset or 0) + step * np.arange(len(channel))
                columns.setdefault("time [s]", pd.Series(times))
            unit = channel.properties.get("unit_string") or channel.properties.get("Unit")
            columns[_header(channel.name, unit)] = pd.Series(channel[:])
    return {name: _tabbed_text(pd.DataFrame(columns)) for name, columns in tables.items()}


def _structures(raw: bytes, source: str) -> dict[str, bytes]:
    """Tab-separated text of each structure with columns in a .mat file, by name."""
    from scipy.io import loadmat

    remedy = ": save it with save(…, '-v7'), or export its readings as CSV."
    with _refusal(f"{source}: can't be read as .mat", remedy):
        content = loadmat(io.BytesIO(raw), simplify_cells=True)
    tables: dict[str, bytes] = {}
    _visit({k: v for k, v in content.items() if not k.startswith("__")}, ("variables",), tables)
    return tables


def _visit(
    content: Mapping[str, Any],
    path: tuple[str, ...],
    tables: dict[str, bytes],
    units: Mapping[str, Any] = {},
) -> None:
    """Add the tables of a structure, and of those in it, to the `tables`; `path`: names of the
    structures around it and of itself, `units`: by name, of the one around it.
    """
    import pandas as pd

    def add(frame: pd.DataFrame, *label: str, header: bool = True) -> None:
        names = (*path, *label)
        name = ".".join(names[1:]) if names[-1] in tables else names[-1]
        tables[name] = _tabbed_text(frame, header=header)

    by_name = {key.lower(): value for key, value in content.items()}
    units = next((by_name[k] for k in ("units", "unit") if isinstance(by_name.get(k), dict)), units)
    labels = next((by_name[key] for key in _LABELS if key in by_name), None)
    columns: dict[str, np.ndarray] = {}
    for label, entry in _entries(content):
        unit, data = units.get(label), entry
        if isinstance(entry, dict):
            channel = {key.lower(): value for key, value in entry.items()}
            data = next((channel[key] for key in _CHANNEL_DATA if key in channel), 0)
            if np.ndim(data) != 1 or np.asarray(data).dtype.kind not in "fiu":
                _visit(entry, (*path, label), tables, units)
                continue
            unit = channel.get("unit", channel.get("units", unit))
        values = np.asarray(data)
        values = values.astype(int) if values.dtype.kind == "b" else values
        is_number = values.dtype.kind in "fiu"
        if (values.ndim == 1 and values.size > 1) or (values.ndim == 0 and is_number):
            columns[_header(label, unit)] = values
        elif values.ndim == 2 and is_number:
            has_labels = labels is not None and np.shape(labels) == values.shape[1:]
            if not has_labels and values.shape[0] <= len(ROLES) < values.shape[1]:
                values = values.T  # a row of each quantity
            frame = pd.DataFrame(values, columns=labels if has_labels else None)
            add(frame, label, header=has_labels)
    sizes = [values.size for values in columns.values() if values.ndim]
    if sizes:
        size = max(set(sizes), key=lambda n: (sizes.count(n), n))
        # a number beside columns holds for each of their rows
        add(pd.DataFrame({
            key: np.broadcast_to(values, size)
            for key, values in columns.items()
            if values.ndim == 0 or values.size == size
        }))  # fmt: skip


def _entries(content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Entries of a structure, those of an array of structures one by one, or as columns if each
    is a reading.
    """
    import pandas as pd

    for key, value in content.items():
        is_structures = isinstance(value, list | np.ndarray) and np.size(value) > 0
        is_structures = is_structures and all(isinstance(x, dict) for x in value)
        if is_structures and all(np.isscalar(x) for reading in value for x in reading.values()):
            yield key, pd.DataFrame(list(value)).to_dict("series")
        elif isinstance(value, list | np.ndarray) and any(isinstance(x, dict) for x in value):
            for i, channel in enumerate(value):
                yield str(channel.get("Name", channel.get("name", f"{key}({i + 1})"))), channel
        else:
            yield key, value


def _header(name: str, unit: Any) -> str:
    return f"{name} [{unit}]" if isinstance(unit, str) and unit else name


def _tabbed_text(frame: "pd.DataFrame", *, header: bool = True) -> bytes:
    return frame.to_csv(sep="\t", index=False, header=header).encode()


@contextmanager
def _refusal(before: str, after: str = "") -> Iterator[None]:
    """Turn any error of a library into one line between the texts `before` and `after`."""
    try:
        yield
    except Exception as error:  # noqa: BLE001 of several libraries
        line = " ".join(str(error).split()).rstrip(".")
        raise ValueError(f"{before}: {line}{after}") from None
