"""Text tables as instruments write them: the layout first, then the readings by pandas.

The layout is that of the longest block of rows of numbers: the sign between its cells, the header
above it, a row of units beside that, and how its numbers are written. Any encoding and line ends;
remarks after `#` or `%`; titles above the header; headers that are repeated between blocks.
"""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.errors import require
from ..core.findings import Finding
from .headers import (
    EXAMPLE_NAMES,
    NUMBER,
    ROLES,
    SIGNALS,
    MissingMetadataError,
    differ,
    is_known,
    is_unit,
    read_header,
    score,
    strip_brackets,
)
from .record import warning


if TYPE_CHECKING:
    import pandas as pd

MAX_ROWS = 5_000_000  # an hour at a kilohertz
_LONGEST_LINE = 100_000  # characters: what is longer is no header
_SAMPLE_ROWS = 500  # that show how numbers are written: a sweep reaches all of its sizes in them
_HEAD_LINES = 200  # lines in which the header may stand: a data logger writes some sixty above it
_HEADER_REACH = 6  # lines above the readings in which their header may stand
_MAX_COLUMNS = 1000  # more take long to search, and no bench has them
_MAX_LOSS = 0.5  # of the rows: a record of less than half of them is another one
_MIN_BLOCK = 3  # rows of numbers: fewer may be lines of a preamble
_DELIMITERS = ("\t", ";", "|", ",", " ", "  ")  # the first that parts a table is taken
_HOLES = {"", "nan", "inf", "infinity", "na", "n/a", "null", "none", "#n/a",
          "#div/0!", "#num!", "#value!", "#ref!", "nan(ind)", "1.#qnan", "1.#ind", "1.#inf",
          "ol", "ovl", "overload", "overflow", "overrange", "over", "err", "error"}  # fmt: skip
_SPECIMEN = re.compile(r"(?:specimen|sample|probe|prüfling)\W*\d+", re.IGNORECASE)
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"[+-]?\d*\.\d+", re.ASCII)
# thousands with a sign, and a tail of decimals behind the other one
_GROUPED = re.compile(
    r"[+-]?\d{1,3}(?P<sign>[.,])\d{3}(?:(?P=sign)\d{3})*(?P<tail>[.,]\d+)?", re.ASCII
)
_CLOCK = re.compile(r"(?:\d\d?:)?\d\d:\d\d(?:\.\d+)?")
_DAY = 86_400.0  # s


@dataclass(frozen=True)
class NumberFormat:
    """How a table writes numbers: the sign before decimals, `decimal`; whether the other one stands
    between thousands, `grouped`; and signs that may be either, `unclear`, as in `2.000` beside 950.
    """

    decimal: str = "."
    grouped: bool = False
    unclear: str = ""

    def values(self, cells: "pd.Series") -> np.ndarray:
        """Finite value of each cell, NaN for other texts."""
        import pandas as pd

        is_unclear = [self.is_unclear(cell) for cell in cells.astype(str)] if self.unclear else []
        if not pd.api.types.is_numeric_dtype(cells):
            if self.grouped:
                sign = "." if self.decimal == "," else ","
                cells = cells.str.replace(rf"(?<=\d)\{sign}(?=\d{{3}}(?!\d))", "", regex=True)
            cells = cells.str.replace(",", ".") if self.decimal == "," else cells
        values = np.array(pd.to_numeric(cells, errors="coerce"), dtype=float)
        values[np.flatnonzero(is_unclear)] = np.nan
        return np.where(np.isfinite(values), values, np.nan)

    def is_unclear(self, cell: str) -> bool:
        """True for a cell with a sign that may part decimals or thousands."""
        return _may_be_thousands(cell) and any(sign in cell for sign in self.unclear)


class _Layout(NamedTuple):
    """Delimiter, indices among the first lines of header, units and readings, cells of a row."""

    delimiter: str
    header: int | None
    units: int | None
    start: int
    width: int


@dataclass(frozen=True)
class Table:
    """A file with its header read, and its cells still as text.

    - `source`: the file's name in errors.
    - `header`: the columns' names; `line`: their line.
    - `units`: from a row of units, or empty.
    - `remarks`: lines after `#` above the header; `titles`: other lines above it.
    - `body`: the lines of the rows; `first`: the number of the first of them.
    - `delimiter`: the sign between cells; `numbers`: the format of numbers.
    - `row_width`: cells of a row between blanks, where a missing cell leaves no sign; else 0.
    """

    source: str
    header: tuple[str, ...]
    line: int
    units: tuple[str, ...]
    remarks: tuple[str, ...]
    titles: tuple[str, ...]
    body: list[str]
    first: int
    delimiter: str
    numbers: NumberFormat
    row_width: int

    @property
    def where(self) -> str:
        """File and line of the header, for messages."""
        return f"{self.source}, line {self.line}"

    def place(self, header: str) -> str:
        """File, line of the header and name of a column, for messages."""
        return f"{self.where}, column `{header}`"

    def cell_error(self, line: int, column: int, rule: str) -> ValueError:
        """The error for a cell that breaks a `rule`."""
        return ValueError(f"{self.source}, line {line}, column `{self.header[column]}`: {rule}")

    def stated_unit(self, index: int, *dimensions: str) -> str:
        """Unit of a column: of the row of units, or else of its name, best of the `dimensions`."""
        units = [strip_brackets(self.units[index])]
        units = units if units[0] else [unit for _, unit in read_header(self.header[index])]
        return next((unit for unit in units if unit and is_unit(unit, *dimensions)), units[0])

    def read(
        self, numbers: Iterable[int], rows: tuple[int, int] | None = None, *, sparse: bool = False
    ) -> tuple["pd.DataFrame", list[Finding]]:
        """Cells of the readings by column and line, columns `numbers` as finite floats; findings.

        Rows with holes in these are left out. `rows`: first and last, from 1; default: all of one
        specimen. `sparse`: most rows may have holes. Raises a `ValueError` for the first bad cell,
        and for a loss of more than half of the rows.
        """
        first, last = rows or (1, MAX_ROWS)
        frame = self._frame.iloc[first - 1 : last].copy()
        # below rows that begin with a number, a word begins those of a mean and the like
        begins = frame[0].astype(str).tolist()
        start = next((i for i, text in enumerate(begins) if is_number(text or "0")), len(begins))
        is_word = [text[:1].isalpha() and not _is_hole(text) for text in begins]
        words = np.array(is_word, dtype=bool) & (np.arange(len(begins)) > start)
        values = {i: self.numbers.values(frame[i]) for i in numbers}
        has_extra = (frame.iloc[:, len(self.header) :] != "").any(axis=1).to_numpy()
        is_finite = np.isfinite([*values.values(), np.zeros(len(frame))]).all(axis=0)
        is_reading = is_finite & ~has_extra & ~words
        word_lines, holes = list[int](), list[int]()
        for row in np.flatnonzero(~is_reading):
            line, cells = int(frame.index[row]), [str(cell) for cell in frame.iloc[row]]
            bad = [i for i, x in values.items() if np.isnan(x[row]) and not _is_hole(cells[i])]
            if words[row] or (bad and not any(is_number(cells[i]) for i in values)):
                self._check_header(cells[: len(self.header)], line, int(row) + 1)
                if _SPECIMEN.fullmatch(cells[0]) and rows is None:
                    before = f"{self.source}, line {line}: another specimen: read the first with "
                    raise MissingMetadataError(before, ("rows", "", f"1:{row}", ", or all with 1:"))
                word_lines.append(line)
            elif has_extra[row]:
                width, count = len(self.header), len(_trim(cells))
                rule = f"{count} cells, where the header has {width}: quote or drop the odd ones"
                remedy = "or part columns by semicolons if decimals stand after commas"
                raise ValueError(f"{self.source}, line {line}: {rule}, {remedy}.")
            elif bad:
                raise self._number_error(line, cells[bad[0]], bad[0])
            else:
                holes.append(line)
        count = int(is_reading.sum())
        if not count:
            rows_text = f"{len(self._frame)} rows below line {self.line}"
            raise ValueError(f"{self.source}: no readings: no numbers in {rows_text}.")
        if not sparse and len(holes) > _MAX_LOSS * (count + len(holes)):
            rule = f"{len(holes)} of {count + len(holes)} rows have holes"
            remedy = "fill or delete them, resample channels to one rate, or choose other columns"
            raise ValueError(f"{self.source}, line {holes[0]}: {rule}: {remedy}.")
        found = [
            warning(f"rows_{kind}", count=len(lines), line=lines[0])
            for kind, lines in (("with_holes", holes), ("of_words", word_lines))
            if lines
        ]
        for i, x in values.items():
            frame[i] = x
        return frame[is_reading], found

    @cached_property
    def _frame(self) -> "pd.DataFrame":
        """Cells of the rows, without blank lines, remarks and headers, by line of the file."""
        require("pandas")
        import pandas as pd

        delimiter = self.delimiter
        indices = [i for i, line in enumerate(self.body)
                   if line.strip() and not (line[0] in " \t#%/" and is_remark(line))]  # fmt: skip
        lines = [self.body[i] for i in indices]
        if self.row_width:
            blanks = re.compile(f"[ \t]{{{len(delimiter)},}}")
            lines, delimiter = [blanks.sub("\t", line.strip()) for line in lines], "\t"
            # which cell is missing between blanks is unknown
            holes = "\t".join("?" * self.row_width)
            lines = [holes if line.count("\t") + 1 < self.row_width and not line[0].isalpha()
                     else line for line in lines]  # fmt: skip
        width = 1 + max((line.count(delimiter) for line in lines), default=0)
        if width > _MAX_COLUMNS:
            raise ValueError(f"{self.source}: more than {_MAX_COLUMNS} cells in a row.")
        columns = range(max(width, len(self.header)))
        if not lines:
            return pd.DataFrame({i: pd.Series(dtype=object) for i in columns})
        # numbers with signs that have two meanings are examined as text
        is_text = self.numbers.grouped or self.numbers.unclear
        try:
            frame = pd.read_csv(
                io.StringIO("\n".join(lines)), sep=delimiter, header=None, names=columns,
                dtype=str if is_text else None, decimal=self.numbers.decimal, na_filter=False,
                low_memory=False, skip_blank_lines=False, skipinitialspace=True,
            )  # fmt: skip
        except pd.errors.ParserError as error:
            text = " ".join(str(error).split()).rstrip(".")
            raise ValueError(f"{self.source}: no rows of a table: {text}.") from None
        if len(frame) < len(lines):
            rule = "a quote in it has no end in its line: close or drop it"
            raise ValueError(f"{self.source}: {rule}.")
        for i in columns:
            if not pd.api.types.is_numeric_dtype(frame[i]) or frame[i].dtype == bool:
                frame[i] = frame[i].fillna("").astype(str).str.strip()
        frame.index = pd.Index(self.first + np.array(indices))
        is_row = (frame != "").any(axis=1)
        for names in (self.header, self.units):
            is_row &= ~(frame.iloc[:, : len(names)] == list(names)).all(axis=1)
        return frame.loc[is_row]

    def _check_header(self, row: Sequence[str], line: int, count: int) -> None:
        """Refuse a `row` of names or units, the `count`-th, that differ from the header's."""
        units = self.units if any(self.units) else [read_header(x)[0][1] for x in self.header]
        if len(set(filter(is_known, row))) > 1:
            is_other = any(map(differ, row, self.header))
        else:
            row = _without_label(row) or row
            pairs = zip(map(strip_brackets, row), map(strip_brackets, units), strict=False)
            is_other = _are_units(row) and any(a != b for a, b in pairs if a)
        if is_other:
            before = f"{self.source}, line {line}: another header than in line {self.line}: split"
            choice = ("rows", "", f"1:{count - 1}", ", for those above it")
            raise MissingMetadataError(f"{before} the file there, or give ", choice)

    def _number_error(self, line: int, text: str, column: int) -> ValueError:
        """The error for a cell that holds no number."""
        if self.numbers.is_unclear(text):
            before = self.cell_error(line, column, f"{text!r} has decimals or thousands: give ")
            sign, opposite = (".", ",") if "." in text else (",", ".")
            choices = [("decimal", "", opposite, f" if it is {text.replace(sign, '')}")]
            if self.numbers.decimal in self.numbers.unclear:  # else decimals have the other sign
                choices.insert(0, ("decimal", "", sign, f" if it is {text.replace(sign, '.')}"))
            return MissingMetadataError(str(before), *choices)
        excerpt = text if len(text) <= 30 else text[:27] + "…"
        rule = f"{excerpt!r} is no finite number"
        remedy = "write it alone, with decimals after a point, or empty the cell"
        return self.cell_error(line, column, f"{rule}: {remedy}.")


def open_table(
    raw: bytes,
    source: str,
    header_line: int | None = None,
    names: Sequence[str] = (),
    decimal: str | None = None,
) -> Table:
    """Read the header of a table from the `raw` bytes of a text file; its cells stay text.

    `header_line`: of the header, from 1, `decimal`: the sign before decimals; default: inferred.
    `names`: of the columns of a table without header. `ValueError` for anything but a table.
    """
    lines = decode(raw, source).replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head, remarks = _first_lines(lines, source)
    if not head:
        raise ValueError(f"{source}: empty: it needs a header and at least one row below it.")
    header_indices = {number: i for i, (number, _) in enumerate(head)}
    if header_line is not None and header_line not in header_indices:
        rule = f"name one of the first {_HEAD_LINES} lines that is neither blank nor a remark"
        raise ValueError(f"{source}, line {header_line}: no header can stand there: {rule}.")
    layout = _find_layout([text for _, text in head], header_indices.get(header_line or 0))
    cells = [split_cells(text, layout.delimiter) for _, text in head]
    if layout.header is not None:
        line, text = head[layout.header]
        header = split_cells(text, layout.delimiter, trim=False)
        last, titles = max(layout.header, layout.units or 0), head[: layout.header]
    else:
        line, last, titles = head[layout.start][0], layout.start - 1, head[: layout.start]
        header = _headless(remarks if last < 0 else [], names, layout, f"{source}, line {line}")
    if header and "->" in header[0]:
        rule = "remove the clock of the serial monitor before each line, or switch it off"
        raise ValueError(f"{source}, line {line}: {rule}.")
    first = head[last + 1][0] if last + 1 < len(head) else len(lines) + 1
    body = lines[first - 1 :]
    if len(body) > MAX_ROWS:
        rule = f"more than {MAX_ROWS} rows: keep every tenth, or split the file"
        raise ValueError(f"{source}: {rule}.")
    step = max(len(body) // _SAMPLE_ROWS, 1)
    sample = [split_cells(text, layout.delimiter) for text in body[::step] if not is_remark(text)]
    numbers = _detect_format(sample, layout.delimiter, decimal)
    units = (*_unit_row(cells, layout), *[""] * len(header))[: len(header)]
    row_width = layout.width if layout.delimiter in (" ", "  ") else 0
    return Table(
        source, tuple(header), line, units, tuple(remarks), tuple(printable(t) for _, t in titles),
        body, first, layout.delimiter, numbers, row_width,
    )  # fmt: skip


def has_readings(raw: bytes, source: str) -> bool:
    """True for text that holds a table with rows of numbers."""
    head, _ = _first_lines(raw.decode().split("\n"), source)
    return bool(head) and _find_layout([text for _, text in head], None).width > 1


def _headless(
    remarks: Sequence[str], names: Sequence[str], layout: _Layout, where: str
) -> list[str]:
    """Names of the columns of a table without header: those given, or a remark as NumPy's."""
    width = layout.width
    if len(names) > width:
        rule = f"{len(names)} columns were named, but it has {width}"
        raise ValueError(f"{where}: {rule}: name each in its place, `-` for one to skip.")
    if names:
        return [*names, *[""] * (width - len(names))]
    rows = [split_cells(text, layout.delimiter) for text in ["", "", *remarks][-2:]]
    rows = [cells if len(cells) == width and not any(map(is_number, cells)) else []
            for cells in rows]  # fmt: skip
    if all(rows) and _are_units(rows[1]):
        return [f"{name} [{unit}]" for name, unit in zip(*rows, strict=True)]
    if rows[1]:  # the last remark has the names
        return rows[1]
    rule = f"no header, but numbers in {width} columns: name the columns in order, as in "
    after = f"; `-` skips a column; the names are {', '.join(ROLES)}"
    raise MissingMetadataError(f"{where}: {rule}", ("columns", "", EXAMPLE_NAMES, after))


def _first_lines(lines: Sequence[str], source: str) -> tuple[list[tuple[int, str]], list[str]]:
    """The first lines with text by number, and the remarks above them."""
    head: list[tuple[int, str]] = []
    remarks: list[str] = []
    for number, text in enumerate(lines, 1):
        if len(head) == _HEAD_LINES or (head and len(text) > _LONGEST_LINE):
            break  # a long line below doesn't concern the header
        if len(text) > _LONGEST_LINE:
            raise ValueError(f"{source}, line {number}: too long for a table's header.")
        if max(len(text.split(sign)) for sign in ("\t", ";", "|", ",", None)) > _MAX_COLUMNS:
            rule = f"more than {_MAX_COLUMNS} columns: keep those of the muscle"
            raise ValueError(f"{source}, line {number}: {rule}.")
        if is_remark(text):
            remarks += [text.strip().lstrip("#%/").strip()] * (not head)
        elif head and text.count('"') % 2 and head[-1][1].count('"') % 2:
            head[-1] = head[-1][0], f"{head[-1][1]} {text}"  # a name over two lines, in quotes
        elif text.strip():
            head.append((number, text))
    return head, remarks


def _find_layout(lines: Sequence[str], header_index: int | None) -> _Layout:
    """Delimiter, header and units of a table; `header_index`: of the header, if it is known.

    Its readings are the longest block of lines with two numbers or more; the header is the line
    above them with as many cells, units may stand between. Without readings it is the first line.
    """
    headless: list[tuple[float, _Layout]] = []
    first_row = 0 if header_index is None else header_index + 1
    for delimiter in _DELIMITERS:
        cells = [split_cells(text, delimiter) for text in lines]
        counts = [sum(map(is_number, row)) for row in cells]
        is_row = [count > 1 and i >= first_row for i, count in enumerate(counts)]
        edges = np.flatnonzero(np.diff([False, *is_row, False])).tolist()
        blocks: list[tuple[int, _Layout]] = []
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            widths = [len(row) for row in cells[start:end]]
            width, size = max(set(widths), key=widths.count), end - start
            header, units = _header_above(cells, start, width, delimiter, header_index)
            if blocks:
                # odd lines, or a header that is printed again, part readings
                former_size, last = blocks[-1]
                names = None if header is None else cells[header]
                is_again = last.header is not None and names in (None, cells[last.header])
                is_again |= last.header is None and (names is None or former_size >= _MIN_BLOCK)
                if is_again and (width, counts[start]) == (last.width, counts[last.start]):
                    blocks[-1] = former_size + size, last
                    continue
            blocks.append((size, _Layout(delimiter, header, units, start, width)))
        if blocks:
            size, layout = max(blocks, key=lambda block: (block[1].header is not None, block[0]))
            if layout.header is not None:
                return layout
            rows = cells[layout.start : layout.start + size]
            is_numbers = [is_number(cell) for row in rows for cell in row if cell]
            headless.append((float(np.mean(is_numbers)), layout))
    if headless:  # of several delimiters the one that leaves numbers
        return max(headless, key=lambda pair: pair[0])[1]
    first = header_index or 0
    delimiter = max(("\t", ";", ","), key=lambda sign: len(split_cells(lines[first], sign)))
    below = split_cells(lines[first + 1], delimiter) if len(lines) > first + 1 else []
    return _Layout(delimiter, first, first + 1 if _are_units(below) else None, len(lines), 0)


def _header_above(
    cells: Sequence[list[str]], start: int, width: int, delimiter: str, header_index: int | None
) -> tuple[int | None, int | None]:
    """Indices of the header above the readings from `start` on, and of a row of units."""
    headers, units = [], None
    for i in range(start - 1, max(start - 1 - _HEADER_REACH, -1), -1):
        row = cells[i]
        if any(map(is_number, row)) or not any(sign.isalpha() for sign in "".join(row)):
            continue
        if units is None and i != header_index and _are_units(row):
            units = i
        elif len(row) >= width or (delimiter == "," and 2 < len(row) < width <= 2 * len(row)):
            headers.append(i)
        else:
            break
    if header_index is not None:
        return header_index, units if units is not None and units > header_index else None
    if not headers:
        return units, None
    return max(headers, key=lambda i: (sum(map(is_known, cells[i])), i)), units


def _unit_row(cells: Sequence[list[str]], layout: _Layout) -> list[str]:
    """Units below the header, or of a line above it that begins with such as Y_Unit_Label."""
    if layout.units is not None:
        return cells[layout.units]
    header = cells[layout.header or 0]
    if _are_units(header):  # the columns have no other names
        return header
    for row in filter(None, map(_without_label, cells[: layout.header or 0])):
        # LabVIEW names no unit of the time, which may be left out
        return row if not header[0] or score(header[0], "", "time") else row[1:]
    return []


def _without_label(row: Sequence[str]) -> list[str]:
    """A row of units with its first cell, such as Y_Unit_Label, blank; empty for another row."""
    is_labeled = bool(row) and re.search(r"unit|einheit", row[0], re.IGNORECASE)
    return ["", *row[1:]] if is_labeled and _are_units(row[1:]) else []


def _are_units(cells: Sequence[str]) -> bool:
    """True for cells of which at least half are units, and none is a number."""
    written = [cell for cell in cells if cell]
    units = sum(is_unit(cell) or strip_brackets(cell).lower() in SIGNALS for cell in written)
    # 1 is a unit of strain, and a reading
    return 2 * units >= max(len(written), 1) and not any(map(is_number, written))


def decode(raw: bytes, source: str) -> str:
    """Text of a file in any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return raw.decode("utf-16", errors="replace")
    for first, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if raw[first:8:2] == b"\0\0\0\0":
            return raw.decode(encoding, errors="replace")
    raw = raw.rstrip(b"\0")  # of a logger that reserves its file
    if b"\0" in raw[:_LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    try:
        return raw.decode("utf-8-sig").replace("\u2212", "-")  # the minus of typesetters
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def is_remark(line: str) -> bool:
    """True for a line after a remark's sign; units in a row may begin with one, too: `%,N`."""
    return line.lstrip().startswith(("#", "%", "//")) and not (
        len(cells := re.split(r"[\t,;|]", line)) > 1 and all(map(is_unit, cells))
    )


def printable(cell: str) -> str:
    """A header as messages show it, on one line."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in cell).split())


def split_cells(line: str, delimiter: str, *, trim: bool = True) -> list[str]:
    """Stripped cells of a line; `trim`: without blank ones at its end."""
    if delimiter == " ":
        cells = [a or b for a, b in _BLANK_CELLS.findall(line)]
    elif delimiter == "  ":
        cells = re.split(r"[ \t]{2,}", line.strip())
    else:
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:
            cells = line.split(delimiter)
    cells = [printable(cell) for cell in cells]
    return _trim(cells) if trim else cells


def _trim(cells: list[str]) -> list[str]:
    """Cells without blank ones at their end."""
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_hole(cell: str) -> bool:
    return cell.lower().lstrip("+-?*.") in _HOLES


def is_number(cell: str) -> bool:
    """True for a number of any format, also with signs between thousands."""
    return bool(NUMBER.fullmatch(cell) or _GROUPED.fullmatch(cell))


def _detect_format(rows: Sequence[list[str]], delimiter: str, decimal: str | None) -> NumberFormat:
    """Format of the numbers in `rows` of cells; `decimal`: the sign before decimals, if known."""
    if decimal is not None:
        return NumberFormat(decimal, grouped=True)
    cells = [cell for row in rows for cell in row]
    matches = [match for match in map(_GROUPED.fullmatch, cells) if match]
    tails = {match["tail"][0] for match in matches if match["tail"]}
    if len(tails) == 1:
        return NumberFormat(tails.pop(), grouped=True)
    # decimals that can't be thousands make the meaning of others clear
    clear = [cell for cell in cells if not _may_be_thousands(cell)]
    points, commas = (any(map(kind.fullmatch, clear)) for kind in (_POINT, _COMMA))
    if not points and not commas and _has_integers_beside_thousands(rows):
        return NumberFormat(unclear=".,")
    has_points, has_commas = (any(map(kind.fullmatch, cells)) for kind in (_POINT, _COMMA))
    if not has_commas or (delimiter == "," and has_points):
        return NumberFormat(".")
    if points and not commas:
        return NumberFormat(".", unclear=",")
    unclear = ("" if points else ".") + ("," if delimiter == "," and not commas else "")
    return NumberFormat(",", unclear=unclear)


def _may_be_thousands(cell: str) -> bool:
    """True for digits with one sign before each three of them: `2.000`, but not `0.500`."""
    match = _GROUPED.fullmatch(cell)
    return match is not None and not match["tail"] and cell.lstrip("+-")[0] != "0"


def _has_integers_beside_thousands(rows: Sequence[list[str]]) -> bool:
    """True for `1.010` beside `950`: three decimals would be `950.000`."""
    columns = (filter(is_number, column) for column in zip_longest(*rows, fillvalue=""))
    grouped = [list(map(_may_be_thousands, column)) for column in columns]
    mixed = [column for column in grouped if any(column) and not all(column)]
    return bool(mixed) or (sum(map(bool, grouped)) > 1 == sum(map(any, grouped)))


def read_seconds(cells: Iterable[object], numbers: NumberFormat) -> np.ndarray | None:
    """Times: numbers in their column's unit; clock times, with or without date, from the first [s];
    `None` for other texts, and where day and month of a date may be swapped.
    """
    import pandas as pd

    cells = pd.Series(cells)
    values = numbers.values(cells)
    if np.isfinite(values).all():
        return values
    # of a second: 10:11:12:500 and 10:11:12,5
    texts = cells.astype(str).str.replace(r"(:\d\d),(\d)", r"\1.\2", regex=True)
    texts = texts.str.replace(r"(\d\d:\d\d:\d\d):", r"\1.", regex=True)
    if all(map(_CLOCK.fullmatch, texts)):
        if any(text.count(":") == 1 and "." not in text for text in texts):
            return None  # 10:11 may be minutes or hours
        clocks = texts.where(texts.str.count(":") == 2, "00:" + texts)
        seconds = pd.to_timedelta(clocks).dt.total_seconds().to_numpy()
        seconds = seconds + _DAY * np.cumsum(np.diff(seconds, prepend=seconds[0]) < -_DAY / 2)
        return np.round(seconds - seconds[0], 6)  # finer than clocks are
    # a year stands first, and dots part day and month in this order; slashes leave it open
    orders = {True} if texts.str.match(r"\d\d?\.").all() else {True, False}
    orders = {False} if texts.str.match(r"\d{4}").all() else orders
    answers = []
    for day_first in orders:
        try:
            dates = pd.to_datetime(texts, format="mixed", dayfirst=day_first, utc=True)
        except (ValueError, OverflowError):
            continue
        answers.append(np.round((dates - dates.iloc[0]).dt.total_seconds().to_numpy(), 6))
    is_clear = bool(answers) and np.array_equal(answers[0], answers[-1])
    return answers[0] if is_clear else None
