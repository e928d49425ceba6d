"""Tables of binary files, .xlsx, .mat and .tdms, read in a process of its own.

The libraries that parse these files may crash on a damaged one, or take all memory. So this module
is run as a program, `python -m fascicle.records.binary_tables KIND`, within limits of memory and
time. It reads the file from its input and writes JSON: texts of the tables between tabs by name, or
an error.
"""

import io
import json
import sys
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from typing import Any

import numpy as np


MEMORY = 2**30  # bytes
MAX_CELLS = 5_000_000  # of a file: their text is some 100 MB
_MAX_ROWS = 2**20  # of a sheet, Excel's own limit: a cell far below makes as many empty rows


def read_sheets(raw: bytes) -> dict[str, str]:
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
            if number > _MAX_ROWS or count > MAX_CELLS:
                raise ValueError(f"sheet `{sheet.title}` has more than {MAX_CELLS} cells or"
                                 f" {_MAX_ROWS} rows")  # fmt: skip
            lines.append("\t".join(texts(row, has_percent)))
        tables[sheet.title] = "\n".join(lines) + "\n"
    return tables


def read_groups(raw: bytes) -> dict[str, str]:
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
    return {name: _text(columns) for name, columns in frames.items()}


def read_variables(raw: bytes) -> dict[str, str]:
    """Tables of a .mat file: its vectors together, and each of its matrices, by name.

    A number beside vectors holds for each of their rows.
    """
    from scipy.io import loadmat

    content = loadmat(io.BytesIO(raw), squeeze_me=True)
    arrays = {key: np.asarray(value) for key, value in content.items() if key[:2] != "__"}
    numbers = {key: value for key, value in arrays.items() if value.dtype.kind in "fiub"}
    if sum(value.size for value in numbers.values()) > MAX_CELLS:
        raise ValueError(f"more than {MAX_CELLS} numbers")
    tables = {
        key: _text(dict(enumerate(value.T)), header=False)
        for key, value in numbers.items()
        if value.ndim == 2
    }
    columns = {key: value for key, value in numbers.items() if value.ndim < 2}
    sizes = {value.size for value in columns.values() if value.ndim}
    if len(sizes) > 1:
        raise ValueError(f"vectors of {min(sizes)} to {max(sizes)} numbers, of one length they are"
                         " a table")  # fmt: skip
    if sizes:
        size = sizes.pop()
        frame = {key: np.broadcast_to(value, size) for key, value in columns.items()}
        tables["variables"] = _text(frame)
    if not tables and len(numbers) < len(arrays):
        nested = ", ".join(f"`{key}`" for key in sorted(arrays.keys() - numbers.keys()))
        raise ValueError(f"{nested} is no vector of numbers, save each column as one")
    return tables


READERS = {"xlsx": read_sheets, "tdms": read_groups, "mat": read_variables}


def _text(
    columns: Mapping[str, np.ndarray] | Mapping[int, np.ndarray], *, header: bool = True
) -> str:
    """Columns by name as text between tabs, the shorter ones with blank cells."""
    if sum(values.size for values in columns.values()) > MAX_CELLS:
        raise ValueError(f"more than {MAX_CELLS} numbers")
    cells = [
        map(str, (x.astype(str) if x.dtype.kind == "M" else x).tolist()) for x in columns.values()
    ]
    lines = map("\t".join, zip_longest(*cells, fillvalue=""))
    return "\n".join([*(["\t".join(map(str, columns))] if header else []), *lines, ""])


def _limit_resources() -> None:
    """Limit the memory of this process, and let a crash leave no file, where the system can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for kind, limit in ((resource.RLIMIT_DATA, MEMORY), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(kind, (limit, limit))


def main() -> None:
    """Read a file of the kind that the command names."""
    _limit_resources()
    try:
        answer = {"tables": READERS[sys.argv[1]](sys.stdin.buffer.read())}
    except MemoryError:
        answer = {"error": f"it needs more than {MEMORY / 2**30:g} GB of memory"}
    except Exception as error:  # noqa: BLE001 of several libraries
        answer = {"error": " ".join(str(error).split()).rstrip(".") or type(error).__name__}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    main()
