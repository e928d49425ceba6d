"""A text table as instruments write them: what its header says, and its cells as numbers.

Commas, semicolons or tabs; a byte order mark, Windows' line ends, decimal commas; remarks
after `#`; a row of units below the header.

Where every line of a block holds as many cells as the header and quotes hide no delimiter, pandas
reads the block in one go. Any other block, and any that pandas can't turn into finite numbers,
is read cell by cell: that says what is wrong, and in which line.
"""

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .spelling import is_unit


MAX_ROWS = 20_000_000  # five hours at a kilohertz
_BLOCK = 1 << 24  # bytes read at once: bounds what is needed besides the columns
_LONGEST_LINE = 100_000
_LONGEST_NAME = 100  # characters of a column's header
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0\u202f]\d{3})+(?:[.,]\d+)?", re.ASCII)
_PEEKED = 60  # lines in which the header is looked for
_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)


@dataclass(frozen=True)
class Cells:
    """Columns that were read.

    - `numbers`: by place in the header [-], as the file writes them.
    - `words`: by place: which of the distinct words, and these [-].
    - `lines`: the line of the file that each row stands in [-].
    """

    numbers: dict[int, np.ndarray]
    words: dict[int, tuple[np.ndarray, list[str]]]
    lines: np.ndarray


@dataclass(frozen=True)
class Table:
    """A file whose header has been read, and whose cells have not yet.

    - `source`: what to call the file [-].
    - `header`: the columns' names as written; `line`: where they stand [-].
    - `units`: those of a row of their own below it, or nothing [-].
    - `remarks`: the lines after `#` above the header [-].
    - `delimiter`, `decimal`: the signs that it is written with [-].
    - `body`: the rows, and `first`, the line of the first one [-].
    - `titles`: lines above the header that aren't remarks [-].
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

    def read(self, numbers: Sequence[int], words: Sequence[int]) -> Cells:
        """The columns at places `numbers` and `words` of the header.

        **Arguments:**

        - `numbers`: columns that hold a finite number in each row [-].
        - `words`: columns that may hold any word [-].

        **Returns:** the columns [-].

        **Raises:** `ValueError`, in one line with file, line and column, for the first cell
        that is wrong.
        """
        blocks, first = [], self.first
        for block in _blocks(self.body):
            # an irregular block is read slowly, and says what is wrong with it
            read = self._quickly(block, first, numbers, words)
            blocks.append(read or self._carefully(block, first, numbers, words))
            first += block.count(b"\n")
        lines = np.concatenate([block.lines for block in blocks]) if blocks else np.zeros(0, int)
        if not lines.size:
            raise ValueError(f"{self.source}: no readings below the header in line {self.line}.")
        return Cells(
            {i: np.concatenate([block.numbers[i] for block in blocks]) for i in numbers},
            {i: _one_alphabet([block.words[i] for block in blocks]) for i in words},
            lines,
        )

    def fault(self, line: int, column: int, rule: str) -> ValueError:
        """The error that the cell in `line` and `column` [-] breaks `rule` [-]."""
        return ValueError(f"{self.source}, line {line}, column `{self.header[column]}`: {rule}")

    def _quickly(
        self, block: bytes, first: int, numbers: Sequence[int], words: Sequence[int]
    ) -> Cells | None:
        rows = _rows(block, self.delimiter, len(self.header))
        if rows is None:
            return None
        import pandas as pd

        kinds: Any = dict.fromkeys(numbers, "float64") | dict.fromkeys(words, "category")
        try:
            frame = pd.read_csv(
                io.BytesIO(block), header=None, sep=self.delimiter, decimal=self.decimal,
                usecols=sorted(kinds), dtype=kinds, na_filter=False, engine="c",
                skip_blank_lines=False, skipinitialspace=True, encoding="utf-8",
                **_exactly(pd.__version__),
            )  # fmt: skip
        except (ValueError, OverflowError):
            return None
        columns = {i: frame[i].to_numpy() for i in numbers}
        if len(frame) != rows or not all(np.isfinite(column).all() for column in columns.values()):
            return None
        codes = {
            i: (frame[i].cat.codes.to_numpy(), [str(word) for word in frame[i].cat.categories])
            for i in words
        }
        return Cells(columns, codes, np.arange(first, first + rows))

    def _carefully(
        self, block: bytes, first: int, numbers: Sequence[int], words: Sequence[int]
    ) -> Cells:
        columns: dict[int, list[float]] = {i: [] for i in numbers}
        codes: dict[int, list[int]] = {i: [] for i in words}
        alphabets: dict[int, dict[str, int]] = {i: {} for i in words}
        lines = []
        rows = csv.reader(_uncommented(block), delimiter=self.delimiter, skipinitialspace=True)
        try:
            for row in rows:
                line = first + rows.line_num - 1
                if not any(cell.strip() for cell in row):
                    continue
                if len(row) != len(self.header):
                    raise ValueError(
                        f"{self.source}, line {line}: {_counted(len(row))}, where the header has"
                        f" {len(self.header)}: {self._uneven(len(row))}."
                    )
                lines.append(line)
                for i in numbers:
                    columns[i].append(self._number(row[i], line, i))
                for i in words:
                    codes[i].append(alphabets[i].setdefault(row[i].strip(), len(alphabets[i])))
        except csv.Error as error:
            line = first + rows.line_num - 1
            raise ValueError(f"{self.source}, line {line}: no row of a table: {error}.") from None
        return Cells(
            {i: np.array(column, dtype=float) for i, column in columns.items()},
            {i: (np.array(codes[i], dtype=int), list(alphabets[i])) for i in words},
            np.array(lines, dtype=int),
        )

    def _uneven(self, cells: int) -> str:
        """What to do about a row of so many `cells` [-]."""
        if self.delimiter == "," and len(self.header) < cells <= 2 * len(self.header):
            return "if its decimals stand after commas, part the columns by semicolons"
        return "quote or drop the odd ones"

    def _number(self, cell: str, line: int, column: int) -> float:
        text = cell.strip()
        if not text:
            raise self.fault(line, column, "no value: fill the hole, or drop the line.")
        if _NUMBER.fullmatch(text) and ("," not in text or self.decimal == ","):
            value = float(text.replace(",", "."))
            if math.isfinite(value):
                return value
        if text.lower().lstrip("+-") in {"nan", "inf", "infinity", "na", "n/a", "null", "none"}:
            raise self.fault(line, column, f"{text} is no reading: drop the line.")
        shown = text if len(text) <= 30 else text[:27] + "…"
        hint = ": write the decimals after a point" if _DECIMAL_COMMA.fullmatch(text) else ""
        if _THOUSANDS.fullmatch(text):
            hint = ": write it without signs between thousands"
        raise self.fault(line, column, f"{shown!r} is no finite number{hint}.")


def open_table(raw: bytes, source: str, header_at: int | None = None) -> Table:
    """Read the header of a table.

    **Arguments:**

    - `raw`: the file's bytes [-].
    - `source`: what to call it in an error [-].
    - `header_at`: the line it stands in [-], counted from 1; left out, it is looked for.

    **Returns:** the table, its cells still unread [-].

    **Raises:** `ValueError`, in one line, for what is no table.
    """
    raw = _utf8(raw, source)
    lines, remarks = _opening(raw, source)
    if not lines:
        raise ValueError(f"{source}: empty: it needs a header and at least one row below it.")
    if header_at is None:
        titles = _titles([text for text, _, _ in lines])
    else:
        titles = next((i for i, line in enumerate(lines) if line[2] == header_at), -1)
        if titles < 0:
            raise ValueError(
                f"{source}, line {header_at}: no header can stand there: name one of the first"
                f" {_PEEKED} lines that is neither blank nor a remark."
            )
    header, top, header_line = lines[titles]
    after = lines[titles + 1] if len(lines) > titles + 1 else ("", len(raw), header_line + 1)
    peek, _, line = after
    delimiter = _delimiter(header, peek)
    names = tuple(_shown(cell) for cell in _split(header, delimiter))
    if any(len(name) > _LONGEST_NAME for name in names):
        raise ValueError(
            f"{source}, line {header_line}: a column's name is longer than {_LONGEST_NAME}"
            " characters: write # before lines above the header."
        )
    if any(_NUMBER.fullmatch(name) for name in names):
        raise ValueError(
            f"{source}, line {header_line}: no header, but numbers: name the columns in the first"
            " line, such as pressure [kPa],length [mm],force [N]."
        )
    below = [cell.strip() for cell in _split(peek, delimiter)] if peek.strip() else []
    units, first = ("",) * len(names), header_line + 1
    if len(below) == len(names) and _are_units(below):
        units, top, first = tuple(below), after[1], line + 1
    body = raw[top:]
    if body.count(b"\n") > MAX_ROWS:
        raise ValueError(
            f"{source}: more than {MAX_ROWS} rows: keep every tenth, or split the file."
        )
    sample = _split(body[:2000].decode(errors="ignore").replace("\n", delimiter), delimiter)
    comma = delimiter != "," and any(_DECIMAL_COMMA.fullmatch(cell.strip()) for cell in sample)
    return Table(
        source, names, header_line, units, tuple(remarks), delimiter, "," if comma else ".", body,
        first, tuple(_shown(text) for text, _, _ in lines[:titles]),
    )  # fmt: skip


def _opening(raw: bytes, source: str) -> tuple[list[tuple[str, int, int]], list[str]]:
    """The first lines that are neither blank nor remarks: text, where the next begins, number; and
    the remarks above the first.
    """
    lines: list[tuple[str, int, int]] = []
    remarks: list[str] = []
    top = number = 0
    while top < len(raw) and len(lines) < _PEEKED:
        try:
            (text, top), number = _line(raw, top, source, number + 1), number + 1
        except ValueError:
            if lines:
                break  # a long line below says nothing of the header
            raise
        if text.lstrip().startswith("#"):
            remarks += [text.strip().lstrip("#").strip()] * (not lines)
        elif text.strip():
            lines.append((text, top, number))
    return lines, remarks


def _titles(lines: Sequence[str]) -> int:
    """How many lines stand above the header: titles, as instruments write them.

    The header is the first line that has as many cells as the numbers below it, in two cells or
    more, and is no number itself; units may stand between. Where there is none such, it is the
    first line.
    """
    for place, header in enumerate(lines[:-1]):
        delimiter = _delimiter(header, lines[place + 1])
        names = _split(header, delimiter)
        rows = [_split(line, delimiter) for line in lines[place + 1 : place + 3]]
        if _are_units([cell.strip() for cell in rows[0]]) and len(rows) > 1:
            rows = rows[1:]
        numbers = sum(bool(_NUMBER.fullmatch(cell.strip())) for cell in rows[0])
        words = not any(_NUMBER.fullmatch(name.strip()) for name in names)
        if len(names) == len(rows[0]) > 1 and numbers > 1 and words:
            return place
        # decimals after commas, and commas between columns: told so where the rows are read
        split = delimiter == "," and 2 < len(names) < numbers == len(rows[0]) <= 2 * len(names)
        if split and words:
            return place
    return 0


def _utf8(raw: bytes, source: str) -> bytes:
    """`raw` as UTF-8 with plain line ends, whatever the instrument wrote."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        raw = raw.decode("utf-16", errors="replace").encode()
    raw = raw.removeprefix(b"\xef\xbb\xbf")
    if b"\0" in raw[:_LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    if not raw.isascii():
        try:
            raw.decode()
        except UnicodeDecodeError:
            raw = raw.decode("latin-1").encode()  # older Windows programs
    if b"\n" not in raw:
        raw = raw.replace(b"\r", b"\n")
    return raw if raw.endswith(b"\n") else raw + b"\n"


def _line(raw: bytes, start: int, source: str, line: int) -> tuple[str, int]:
    end = raw.find(b"\n", start)
    if end - start > _LONGEST_LINE:
        raise ValueError(f"{source}, line {line}: too long for a table's header.")
    return raw[start:end].decode().rstrip("\r"), end + 1


def _delimiter(header: str, row: str) -> str:
    """The sign that parts header and row into as many cells, more than one."""
    for sign in ("\t", ";", ","):
        cells = len(_split(header, sign))
        if cells > 1 and cells == len(_split(row, sign)):
            return sign
    return max(("\t", ";", ","), key=lambda sign: len(_split(header, sign)))


def _shown(cell: str) -> str:
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


def _blocks(body: bytes) -> Iterator[bytes]:
    start = 0
    while start < len(body):
        end = body.rfind(b"\n", start, start + _BLOCK) + 1
        if end == 0:
            end = body.find(b"\n", start) + 1
        yield body[start:end]
        start = end


def _rows(block: bytes, delimiter: str, cells: int) -> int | None:
    """How many rows there are, if each has `cells` cells and quotes hide no sign."""
    if b"#" in block:
        return None
    signs = np.frombuffer(block, dtype=np.uint8)
    ends = np.flatnonzero(signs == ord("\n"))
    marks = np.flatnonzero(signs == ord(delimiter))
    if cells < 2 or marks.size != ends.size * (cells - 1):
        return None
    marks = marks.reshape(ends.size, cells - 1)
    if b'"' in block:
        quoted = np.cumsum(signs == ord('"'), dtype=np.int32) % 2
        if quoted[marks].any() or quoted[ends].any():
            return None
    inside = np.all(marks[:, -1] < ends) and np.all(marks[1:, 0] > ends[:-1])
    return ends.size if inside else None


def _exactly(version: str) -> Any:
    """What makes pandas read a decimal as the nearest float; from 3.1 on it always does."""
    older = tuple(map(int, re.findall(r"\d+", version)[:2])) < (3, 1)
    return {"float_precision": "round_trip"} if older else {}


def _uncommented(block: bytes) -> Iterator[str]:
    for line in io.StringIO(block.decode(), newline=""):
        yield "\n" if line.lstrip().startswith("#") else line


def _one_alphabet(blocks: list[tuple[np.ndarray, list[str]]]) -> tuple[np.ndarray, list[str]]:
    alphabet: dict[str, int] = {}
    codes = []
    for places, words in blocks:
        known = np.array([alphabet.setdefault(w.strip(), len(alphabet)) for w in words], dtype=int)
        codes.append(known[places] if known.size else places.astype(int))
    return np.concatenate(codes), list(alphabet)


def _counted(cells: int) -> str:
    return f"{cells} cell{'' if cells == 1 else 's'}"
