"""Files of instruments as text tables: text as it is, .xlsx, .mat and .tdms by a process apart.

The libraries that parse binary files may crash on a damaged one, or take all memory. So this module
is also run as a program, `python -m fascicle.records.formats KIND`, within limits of memory and
time. It reads the file from its input and writes JSON: texts of the tables between tabs by name, or
an error.
"""

import fnmatch
import io
import itertools
import json
import os
import subprocess
import sys
from collections.abc import Collection, Iterable, Iterator
from typing import Any

import numpy as np

from ..core.errors import require
from .headers import MissingMetadataError
from .tables import has_readings


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
_LIBRARIES = {"xlsx": "openpyxl", "tdms": "nptdms", "mat": "scipy"}
_TIME = 60  # s of a reader: a million cells of a sheet take ten
_MEMORY = 2**30  # bytes
_MAX_ERROR = 200  # characters of a library's message
_MAX_CELLS = 5_000_000  # of a file: their text is some 100 MB
_MAX_ROWS = 2**20  # of a sheet, Excel's own limit: a cell far below makes as many empty rows


def table_texts(raw: bytes, source: str, table: str | None = None) -> dict[str, bytes]:
    """Text of a file's tables by name; a text file is one without name.

    `table`: name of the sheet, matrix or group, or a pattern such as `"*"` for all with readings;
    default: the one with readings. `ValueError` for a file that can't be read, naming `source`.
    """
    beginning = raw[:64].lstrip().lower()
    for start, remedy in _REMEDIES.items():
        if beginning.startswith(start.lower()):
            raise ValueError(f"{source}: {remedy}.")
    signs = {b"PK\3\4": "xlsx", b"TDSm": "tdms", b"MATLAB": "mat"}
    kind = next((kind for sign, kind in signs.items() if raw.startswith(sign)), "")
    if not kind and source.lower().endswith(".mat") and b"\0" in raw:
        kind = "mat"
    if not kind and table is None:
        return {"": raw}
    if not kind:
        rule = f"no table `{table}`: a text file holds one, leave the name out"
        raise ValueError(f"{source}: {rule}.")
    tables = _read_apart(kind, raw, source)
    names = [name for name in tables if table is not None and name.lower() == table.lower()]
    if not names:
        pattern = "*" if table is None else table.lower()
        fits = [name for name in tables if fnmatch.fnmatchcase(name.lower(), pattern)]
        if not fits and table is not None:
            listed = ", ".join(f"`{name}`" for name in tables) or "none"
            raise ValueError(f"{source}: no table `{table}`: there are {listed}.")
        names = [name for name in fits if has_readings(tables[name], source)]
    if not names:
        raise ValueError(f"{source}: no table of numbers in it: export the readings as CSV.")
    if len(names) > 1 and table is None:
        listed = ", ".join(f"`{name}`" for name in names)
        longest = max(names, key=lambda name: tables[name].count(b"\n"))  # others hold results
        choices = (("table", "", longest, ""), ("table", "", "*", " for all, if of one muscle"))
        rule = f"several tables, {listed}: choose one with "
        raise MissingMetadataError(f"{source}: {rule}", *choices)
    return {name: tables[name] for name in names}


def _read_apart(kind: str, raw: bytes, source: str) -> dict[str, bytes]:
    """Texts of a binary file's tables by name, from a process that may crash."""
    require(_LIBRARIES[kind])
    # -P: nothing is imported from the working folder, which may be that of a downloaded file
    command = [sys.executable, "-P", "-m", f"{__package__}.formats", kind]
    # a thread of OpenBLAS takes memory that counts
    paths = os.pathsep.join(filter(None, sys.path))
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": paths}
    answer: dict[str, Any] = {"error": "its reader crashed"}
    try:
        done = subprocess.run(  # noqa: S603 of this package
            command, input=raw, capture_output=True, timeout=_TIME, env=environment, check=False
        )
        answer = json.loads(done.stdout) if done.returncode == 0 else answer
    except subprocess.TimeoutExpired:
        answer = {"error": f"it takes longer than {_TIME} s"}
    if "error" in answer:
        again = "save it again with save(…, '-v7')" if kind == "mat" else "save it again"
        fault = f"can't be read as .{kind}: {answer['error'][:_MAX_ERROR]}"
        raise ValueError(f"{source}: {fault}: {again}, or export its readings as CSV.")
    return {name: text.encode() for name, text in answer["tables"].items()}


def _read_sheets(raw: bytes) -> dict[str, str]:
    """Tables of an .xlsx file by sheet."""
    from openpyxl import load_workbook

    def texts(cells: tuple[Any, ...], has_percent: set[int]) -> Iterator[str]:
        """Texts of a row; below a text with %, numbers that Excel shows in % as they are shown."""
        for column, cell in enumerate(cells):
            value = cell.value
            if isinstance(value, str) and "%" in value:
                has_percent.add(column)
            elif isinstance(value, int | float) and column in has_percent:
                value = value * 100 if "%" in cell.number_format else value
            yield "" if value is None else " ".join(str(value).split()).replace('"', "")

    tables, count = {}, 0
    for sheet in load_workbook(io.BytesIO(raw), data_only=True, read_only=True).worksheets:
        sheet.reset_dimensions()  # programs write wrong ones
        lines, has_percent = [], set[int]()
        for number, row in enumerate(sheet.iter_rows(), 1):
            count += len(row)
            if number > _MAX_ROWS or count > _MAX_CELLS:
                limits = f"{_MAX_CELLS} cells or {_MAX_ROWS} rows"
                raise ValueError(f"sheet `{sheet.title}` has more than {limits}")
            lines.append("\t".join(texts(row, has_percent)))
        tables[sheet.title] = "\n".join(lines) + "\n"
    return tables


def _read_groups(raw: bytes) -> dict[str, str]:
    """Tables of a .tdms file by group, and by rate where its channels have several."""
    from nptdms import TdmsFile

    frames: dict[str, dict[str, np.ndarray]] = {}
    for group in TdmsFile.read(io.BytesIO(raw)).groups():
        steps = {channel.properties.get("wf_increment") for channel in group.channels()}
        is_one = len(steps - {None}) <= 1
        for channel in group.channels():
            step, offset = map(channel.properties.get, ("wf_increment", "wf_start_offset"))
            # rows of channels at several rates are of different times
            name = group.name if is_one or not step else f"{group.name}, every {step:g} s"
            columns = frames.setdefault(name, {})
            if step and len(channel):
                times = (offset or 0) + step * np.arange(len(channel))
                columns.setdefault("time [s]", times)
            unit = channel.properties.get("unit_string") or channel.properties.get("Unit")
            columns[f"{channel.name} [{unit}]" if unit else channel.name] = np.asarray(channel[:])
    return {name: _text(columns.values(), columns) for name, columns in frames.items()}


def _read_variables(raw: bytes) -> dict[str, str]:
    """Tables of a .mat file: each matrix, and its vectors together, numbers in all rows."""
    from scipy.io import loadmat

    content = loadmat(io.BytesIO(raw), squeeze_me=True)
    arrays = {key: np.asarray(value) for key, value in content.items() if key[:2] != "__"}
    numbers = {key: value for key, value in arrays.items() if value.dtype.kind in "fiub"}
    if sum(value.size for value in numbers.values()) > _MAX_CELLS:
        raise ValueError(f"more than {_MAX_CELLS} numbers")
    tables = {key: _text(value.T) for key, value in numbers.items() if value.ndim == 2}
    columns = {key: value for key, value in numbers.items() if value.ndim < 2}
    sizes = {value.size for value in columns.values() if value.ndim}
    if len(sizes) > 1:
        ends = f"{min(sizes)} to {max(sizes)}"
        raise ValueError(f"vectors of {ends} numbers, of one length they are a table")
    if sizes:
        vectors = np.broadcast_arrays(*columns.values())
        tables["variables"] = _text(vectors, columns)
    if not tables and len(numbers) < len(arrays):
        nested = ", ".join(f"`{key}`" for key in sorted(arrays.keys() - numbers.keys()))
        raise ValueError(f"{nested} is no vector of numbers, save each column as one")
    return tables


def _text(columns: Iterable[np.ndarray], names: Collection[str] = ()) -> str:
    """Columns as text between tabs, below their names, the shorter ones with blank cells."""
    columns = list(columns)
    if sum(values.size for values in columns) > _MAX_CELLS:
        raise ValueError(f"more than {_MAX_CELLS} numbers")
    columns = [values.astype(str) if values.dtype.kind == "M" else values for values in columns]
    cells = itertools.zip_longest(*(map(str, values.tolist()) for values in columns), fillvalue="")
    header = ["\t".join(names)] if names else []
    return "\n".join([*header, *map("\t".join, cells), ""])


def main() -> None:
    """Read a file of the kind that the command names, and write its tables."""
    try:
        import resource

        # a crash leaves no file
        for kind, limit in ((resource.RLIMIT_DATA, _MEMORY), (resource.RLIMIT_CORE, 0)):
            resource.setrlimit(kind, (limit, limit))
    except ImportError:  # Windows
        pass
    readers = {"xlsx": _read_sheets, "tdms": _read_groups, "mat": _read_variables}
    try:
        answer = {"tables": readers[sys.argv[1]](sys.stdin.buffer.read())}
    except MemoryError:
        answer = {"error": f"it needs more than {_MEMORY / 2**30:g} GB of memory"}
    except Exception as error:  # noqa: BLE001 of several libraries
        answer = {"error": " ".join(str(error).split()).rstrip(".") or type(error).__name__}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    main()
