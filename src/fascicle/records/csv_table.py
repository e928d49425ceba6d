"""Text tables as instruments write them: header, units, remarks, and columns as numbers.

Commas, semicolons or tabs; a byte order mark, Windows' line ends, decimal commas; remarks after
`#`; titles above the header, and a row of units below it.

pandas reads a regular table. A table with gaps, remarks between its rows or a bad cell is read
again row by row, to skip empty rows and to name the line of a bad cell.
"""

import csv
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .units import is_unit


if TYPE_CHECKING:
    import pandas as pd

MAX_ROWS = 20_000_000  # five hours at a kilohertz
_LONGEST_LINE = 100_000  # bytes: what is longer is no header
_LONGEST_NAME = 100  # characters of a column's name
_HEADER_LINES = 60  # lines in which the header may stand
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0\u202f]\d{3})+(?:[.,]\d+)?", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_NO_VALUE = {"nan", "inf", "infinity", "na", "n/a", "null", "none"}


@dataclass(frozen=True)
class Cells:
    """Columns of a table, by index in the header.

    - `numbers`: as the file writes them.
    - `texts`: as categories.
    - `lines`: the file's line of each row.
    """

    numbers: dict[int, np.ndarray]
    texts: dict[int, "pd.Categorical"]
    lines: np.ndarray


@dataclass(frozen=True)
class Table:
    """A file with its header read, and its cells still as text.

    - `source`: the file's name in errors.
    - `header`: the columns' names; `line`: their line.
    - `units`: from a row of units below the header, or empty.
    - `remarks`: lines after `#` above the header; `titles`: other lines above it.
    - `delimiter`, `decimal`: the signs between cells and in numbers.
    - `body`: the rows; `first`: the line of the first one.
    """

    source: str
    header: tuple[str, ...]
    line: int
    units: tuple[str, ...]
    remarks: tuple[str, ...]
    delimiter: str
    decimal: str
    body: bytes
    first: int
    titles: tuple[str, ...] = ()

    @property
    def where(self) -> str:
        """File and line of the header, for messages."""
        return f"{self.source}, line {self.line}"

    def read(self, numbers: Sequence[int], texts: Sequence[int]) -> Cells:
        """Read the columns with indices `numbers` as finite floats, those in `texts` as text.

        Raises a `ValueError` with line and column for the first bad cell.
        """
        cells = self._read_regular(numbers, texts) or self._read_rows(numbers, texts)
        if not cells.lines.size:
            raise ValueError(f"{self.source}: no readings below the header in line {self.line}.")
        return cells

    def cell_error(self, line: int, column: int, rule: str) -> ValueError:
        """The error for a cell that breaks a `rule`."""
        return ValueError(f"{self.source}, line {line}, column `{self.header[column]}`: {rule}")

    def _read_regular(self, numbers: Sequence[int], texts: Sequence[int]) -> Cells | None:
        """All rows read by pandas, or `None` if they aren't regular."""
        import pandas as pd

        body, width = self.body.rstrip(), len(self.header)
        rows = body.count(b"\n") + 1
        # pandas fills short rows: regular rows have this many delimiters in all
        regular = body.count(self.delimiter.encode()) == rows * (width - 1)
        if not regular or b"#" in body or not body:
            return None
        kinds: Any = dict.fromkeys(range(width + 1), "category")
        kinds |= dict.fromkeys(numbers, "float64")
        try:
            frame = pd.read_csv(
                io.BytesIO(body + b"\n"), header=None, names=range(width + 1), dtype=kinds,
                sep=self.delimiter, decimal=self.decimal, na_filter=False, index_col=False,
                skip_blank_lines=False, skipinitialspace=True, float_precision=_precision(),
            )  # fmt: skip
        except (ValueError, OverflowError):
            return None
        # a row with a cell too many fills the last column
        if len(frame) != rows or any(map(str, frame[width].cat.categories)):
            return None
        if not np.isfinite(frame[list(numbers)].to_numpy()).all():
            return None
        return Cells(
            {i: frame[i].to_numpy() for i in numbers},
            {i: frame[i].cat.rename_categories(str).array for i in texts},
            np.arange(self.first, self.first + rows),
        )

    def _read_rows(self, numbers: Sequence[int], texts: Sequence[int]) -> Cells:
        import pandas as pd

        columns: dict[int, list[Any]] = {i: [] for i in (*numbers, *texts)}
        lines = []
        text = io.StringIO(self.body.decode(), newline="")
        uncommented = ("\n" if line.lstrip().startswith("#") else line for line in text)
        rows = csv.reader(uncommented, delimiter=self.delimiter, skipinitialspace=True)
        try:
            for row in rows:
                line = self.first + rows.line_num - 1
                if not any(cell.strip() for cell in row):
                    continue
                if (count := len(row)) != (width := len(self.header)):
                    remedy = "quote or drop the odd ones"
                    if self.delimiter == "," and width < count <= 2 * width:
                        remedy = (
                            "if its decimals stand after commas, part the columns by semicolons"
                        )
                    cells = f"{count} cell{'' if count == 1 else 's'}"
                    message = f"{cells}, where the header has {width}: {remedy}."
                    raise ValueError(f"{self.source}, line {line}: {message}")
                lines.append(line)
                for i in numbers:
                    columns[i].append(self._number(row[i], line, i))
                for i in texts:
                    columns[i].append(row[i].strip())
        except csv.Error as error:
            line = self.first + rows.line_num - 1
            raise ValueError(f"{self.source}, line {line}: no row of a table: {error}.") from None
        return Cells(
            {i: np.array(columns[i], dtype=float) for i in numbers},
            {i: pd.Categorical(columns[i]) for i in texts},
            np.array(lines, dtype=int),
        )

    def _number(self, cell: str, line: int, column: int) -> float:
        text = cell.strip()
        if not text:
            raise self.cell_error(line, column, "no value: fill the hole, or drop the line.")
        if _NUMBER.fullmatch(text) and ("," not in text or self.decimal == ","):
            value = float(text.replace(",", "."))
            if math.isfinite(value):
                return value
        if text.lower().lstrip("+-") in _NO_VALUE:
            raise self.cell_error(line, column, f"{text} is no reading: drop the line.")
        excerpt = text if len(text) <= 30 else text[:27] + "…"
        hint = ": write the decimals after a point" if _DECIMAL_COMMA.fullmatch(text) else ""
        if _THOUSANDS.fullmatch(text):
            hint = ": write it without signs between thousands"
        raise self.cell_error(line, column, f"{excerpt!r} is no finite number{hint}.")


def open_table(raw: bytes, source: str, header_line: int | None = None) -> Table:
    """Read the header of a table from the `raw` bytes of a file; its cells stay text.

    `source` names the file in errors; `header_line` is the header's line, counted from 1;
    default: it is inferred. Raises a `ValueError` for anything but a table.
    """
    raw = _to_utf8(raw, source)
    lines, remarks = _first_lines(raw, source)
    if not lines:
        raise ValueError(f"{source}: empty: it needs a header and at least one row below it.")
    if header_line is None:
        titles = _count_titles([text for text, _, _ in lines])
    else:
        titles = next((i for i, line in enumerate(lines) if line[2] == header_line), -1)
        if titles < 0:
            raise ValueError(
                f"{source}, line {header_line}: no header can stand there: name one of the first"
                f" {_HEADER_LINES} lines that is neither blank nor a remark."
            )
    header, top, line = lines[titles]
    row, row_end, row_line = lines[titles + 1] if len(lines) > titles + 1 else ("", len(raw), 0)
    delimiter = _find_delimiter(header, row)
    names = tuple(_printable(cell) for cell in _split(header, delimiter))
    if any(len(name) > _LONGEST_NAME for name in names):
        raise ValueError(
            f"{source}, line {line}: a column's name is longer than {_LONGEST_NAME}"
            " characters: write # before lines above the header."
        )
    if any(_NUMBER.fullmatch(name) for name in names):
        raise ValueError(
            f"{source}, line {line}: no header, but numbers: name the columns in the first"
            " line, such as pressure [kPa],length [mm],force [N]."
        )
    below = [cell.strip() for cell in _split(row, delimiter)] if row.strip() else []
    units, first = ("",) * len(names), line + 1
    if len(below) == len(names) and _are_units(below):
        units, top, first = tuple(below), row_end, row_line + 1
    body = raw[top:]
    if body.count(b"\n") > MAX_ROWS:
        raise ValueError(
            f"{source}: more than {MAX_ROWS} rows: keep every tenth, or split the file."
        )
    sample = _split(body[:2000].decode(errors="ignore").replace("\n", delimiter), delimiter)
    comma = delimiter != "," and any(_DECIMAL_COMMA.fullmatch(cell.strip()) for cell in sample)
    return Table(
        source, names, line, units, tuple(remarks), delimiter, "," if comma else ".", body, first,
        tuple(_printable(text) for text, _, _ in lines[:titles]),
    )  # fmt: skip


def _first_lines(raw: bytes, source: str) -> tuple[list[tuple[str, int, int]], list[str]]:
    """The first lines that are neither blank nor remarks, each with the next one's position and its
    own number; and the remarks above the first.
    """
    lines: list[tuple[str, int, int]] = []
    remarks: list[str] = []
    top = number = 0
    while top < len(raw) and len(lines) < _HEADER_LINES:
        end = raw.find(b"\n", top)
        number += 1
        if end - top > _LONGEST_LINE:
            if lines:
                break  # a long line below doesn't concern the header
            raise ValueError(f"{source}, line {number}: too long for a table's header.")
        text, top = raw[top:end].decode().rstrip("\r"), end + 1
        if text.lstrip().startswith("#"):
            remarks += [text.strip().lstrip("#").strip()] * (not lines)
        elif text.strip():
            lines.append((text, top, number))
    return lines, remarks


def _count_titles(lines: Sequence[str]) -> int:
    """Number of lines above the header: titles, as instruments write them.

    The header is the first line that has as many cells as the numbers below it, in two cells or
    more, and is no number itself; units may stand between. Without such a line it is the first.
    """
    for index, header in enumerate(lines[:-1]):
        delimiter = _find_delimiter(header, lines[index + 1])
        names = _split(header, delimiter)
        rows = [_split(line, delimiter) for line in lines[index + 1 : index + 3]]
        if _are_units([cell.strip() for cell in rows[0]]) and len(rows) > 1:
            rows = rows[1:]
        numbers = sum(bool(_NUMBER.fullmatch(cell.strip())) for cell in rows[0])
        if any(_NUMBER.fullmatch(name.strip()) for name in names):
            continue
        if len(names) == len(rows[0]) > 1 and numbers > 1:
            return index
        # commas as decimal signs and as delimiters: refused where the rows are read
        if delimiter == "," and 2 < len(names) < numbers == len(rows[0]) <= 2 * len(names):
            return index
    return 0


def _to_utf8(raw: bytes, source: str) -> bytes:
    """`raw` as UTF-8 with plain line ends, from any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        raw = raw.decode("utf-16", errors="replace").encode()
    raw = raw.removeprefix(b"\xef\xbb\xbf")
    if b"\0" in raw[:_LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    if not raw.isascii():
        try:
            raw.decode()
        except UnicodeDecodeError:
            raw = raw.decode("latin-1").encode()  # of older Windows programs
    if b"\n" not in raw:
        raw = raw.replace(b"\r", b"\n")
    return raw if raw.endswith(b"\n") else raw + b"\n"


def _find_delimiter(header: str, row: str) -> str:
    """The sign that parts header and row into equally many cells, more than one."""
    for sign in ("\t", ";", ","):
        cells = len(_split(header, sign))
        if cells > 1 and cells == len(_split(row, sign)):
            return sign
    return max(("\t", ";", ","), key=lambda sign: len(_split(header, sign)))


def _printable(cell: str) -> str:
    """A header as messages show it, on one line."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in cell).split())


def _are_units(cells: Sequence[str]) -> bool:
    written = [cell for cell in cells if cell]
    # 1 is a unit of strain, and a reading
    return bool(written) and all(is_unit(c) and not _NUMBER.fullmatch(c) for c in written)


def _split(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return line.split(delimiter)


def _precision() -> Any:
    """Option of pandas to read a decimal as the nearest float; the default from 3.1 on."""
    import pandas as pd

    version = tuple(map(int, re.findall(r"\d+", pd.__version__)[:2]))
    return "round_trip" if version < (3, 1) else None
