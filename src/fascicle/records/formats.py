"""Spreadsheets and binary files of instruments as text tables: .xlsx, .mat, .tdms.

openpyxl, SciPy and npTDMS parse; here their columns get names and units. A file with several tables
(sheets, matrices, groups) is refused unless some are named or only one has readings.
"""

import fnmatch
import io
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.errors import require
from .headers import MissingMetadataError
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
_COMPRESSED = 15  # type of a compressed element of a .mat file


def table_texts(raw: bytes, source: str, table: str | None = None) -> dict[str, bytes]:
    """Text of a file's table, or of several, by name; a text file is one without name.

    **Arguments:**

    - `raw`: the file's bytes; `source`: its name in errors.
    - `table`: name of the sheet, matrix or group, or a pattern such as `"*"` for all with
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
        tables = _variables(raw, source)
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


def _variables(raw: bytes, source: str) -> dict[str, bytes]:
    """Tab-separated text of the vectors in a .mat file, or of each of its matrices, by name.

    A number beside vectors holds for each of their rows; structures and cells are refused.
    """
    import pandas as pd
    from scipy.io import loadmat

    remedy = ": save it with save(…, '-v7'), or export its readings as CSV."
    with _refusal(f"{source}: can't be read as .mat", remedy):
        content = loadmat(io.BytesIO(raw), squeeze_me=True)
    arrays = {key: np.asarray(value) for key, value in content.items() if key[:2] != "__"}
    numbers = {key: value for key, value in arrays.items() if value.dtype.kind in "fiub"}
    tables = {
        key: _tabbed_text(pd.DataFrame(value), header=False)
        for key, value in numbers.items()
        if value.ndim == 2
    }
    columns = {key: value for key, value in numbers.items() if value.ndim < 2}
    sizes = {value.size for value in columns.values() if value.ndim}
    if len(sizes) > 1:
        rule = f"vectors of {min(sizes)} to {max(sizes)} numbers: save those of one length"
        raise ValueError(f"{source}: {rule}.")
    if sizes:
        size = sizes.pop()
        frame = pd.DataFrame({key: np.broadcast_to(x, size) for key, x in columns.items()})
        tables["variables"] = _tabbed_text(frame)
    if not tables and len(numbers) < len(arrays):
        nested = ", ".join(f"`{key}`" for key in arrays.keys() - numbers.keys())
        rule = f"no vectors of numbers, but {nested}: save each column as a vector of its own"
        raise ValueError(f"{source}: {rule}.")
    return tables


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
