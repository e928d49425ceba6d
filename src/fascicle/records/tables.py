"""Text tables as instruments write them: the layout first, then the readings by pandas.

The layout is that of the longest block of rows of numbers: the sign between its cells, the header
above it, a row of units beside that, and how its numbers are written. Any encoding and line ends;
remarks after `#` or `%`; titles above the header; headers that are repeated between blocks.
"""

import csv
import datetime as dt
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress, zip_longest
from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError, require
from .headers import (
    LONGEST_NAME,
    NUMBER,
    ROLES,
    SIGNALS,
    MissingMetadataError,
    TableHeader,
    differ,
    is_known,
    is_unit,
    read_header,
    score,
    strip_brackets,
)


MAX_ROWS = 5_000_000  # an hour at a kilohertz
_LONGEST_LINE = 100_000  # characters: what is longer is no header
_SAMPLE_ROWS = 500  # that show how numbers are written: a sweep reaches all of its sizes in them
_HEAD_LINES = 200  # lines in which the header may stand: a data logger writes some sixty above it
_HEADER_REACH = 6  # lines above the readings in which their header may stand
_MAX_COLUMNS = 1000  # more take long to search, and no bench has them
_MAX_LOSS = 0.5  # of the rows: a record of less than half of them is another one
_MIN_BLOCK = 3  # rows of numbers: fewer may be lines of a preamble
_DELIMITERS = ("\t", ";", "|", ",", " ", "  ")  # the first that parts a table is taken
_REMARK = ("#", "%", "//")
_HOLES = {"", "nan", "inf", "infinity", "na", "n/a", "null", "none", "#n/a",
          "#div/0!", "#num!", "#value!", "#ref!", "nan(ind)", "1.#qnan", "1.#ind", "1.#inf",
          "ol", "ovl", "overload", "overflow", "overrange", "over", "err", "error"}  # fmt: skip
_LEFT_OUT = {"holes": "with holes", "words": "of words"}
_SPECIMEN = re.compile(r"(?:specimen|sample|probe|prüfling)\W*\d+", re.IGNORECASE)
_EXAMPLE = "force[N],pressure[kPa],-,length[mm]"  # columns in their order
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')
_FORTRAN = str.maketrans("dD", "ee", " ")  # exponents of double precision
_COMMA = re.compile(r"(?:[+-] *)?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"(?:[+-] *)?\d*\.\d+", re.ASCII)
_WITH_UNIT = re.compile(rf"{NUMBER.pattern}\s*[^\W\d_]+", re.ASCII)
# with signs between thousands, and a tail of decimals
_GROUPED = re.compile(
    r"[+-]?\d{1,3}(?P<sign>[.,' \u00a0\u202f])\d{3}(?:(?P=sign)\d{3})*(?P<tail>[.,]\d+)?", re.ASCII
)
_CLOCK = re.compile(
    r"(?:(\S*\d)[\sT]+)?"
    r"(?:(\d\d?):)?(\d\d):(\d\d(?:[.,:]\d+)?)\s*(?:([AaPp])[Mm]|Z|[+-]\d\d:?\d\d)?"
)
_DATE = re.compile(r"(\d+)([-./])(\d+)\2(\d+)")


@dataclass(frozen=True)
class NumberFormat:
    """How a table writes numbers.

    - `decimal`: the sign before decimals, a point or a comma.
    - `grouped`: the other sign stands between thousands.
    - `unclear`: signs of which that isn't known: `2.000` beside decimal commas, or beside 950, is
      2 or 2000.
    """

    decimal: str = "."
    grouped: bool = False
    unclear: str = ""

    def values(self, cells: Sequence[str]) -> np.ndarray:
        """Finite value of each cell, NaN for other texts."""
        import pandas as pd

        texts = [cell.replace(",", ".") for cell in cells] if self.decimal == "," else cells
        series = pd.Series(texts, dtype=object)
        values = np.array(pd.to_numeric(series, errors="coerce"), dtype=float)
        # these, and cells with a point that may be of thousands, are read one by one
        doubtful = ~np.isfinite(values)
        if self.decimal == "," or "." in self.unclear:
            doubtful |= np.array(["." in cell for cell in cells], dtype=bool)
        for row in np.flatnonzero(doubtful).tolist():
            value = self.value(cells[row])
            values[row] = math.nan if value is None else value
        return values

    def plain(self, cell: str) -> str:
        """A number without signs between thousands, and other cells as they are."""
        match = _GROUPED.fullmatch(cell)
        if match is None or match["sign"] == self.decimal:
            return cell
        if match["tail"]:
            is_grouped = match["tail"][0] == self.decimal
        else:
            is_grouped = self.grouped or match["sign"] not in ".,"
        return cell.replace(match["sign"], "") if is_grouped else cell

    def value(self, cell: str) -> float | None:
        """Finite value of a `cell`, or `None`."""
        if not cell or self._unclear_sign(cell):
            return None
        plain = self.plain(cell)
        plain = plain.replace(",", ".") if self.decimal == "," else plain
        # Python's own numbers, such as 1_000 and nan, are none here
        if not NUMBER.fullmatch(plain) or "," in plain:
            return None
        value = float(plain.translate(_FORTRAN))
        return value if math.isfinite(value) else None

    def meanings(self, cell: str) -> list[tuple[str, str]]:
        """Decimal sign and condition of each way to read an unclear `cell`; empty for others."""
        if not (sign := self._unclear_sign(cell)):
            return []
        opposite = "," if sign == "." else "."
        decimals, thousands = cell.replace(sign, "."), cell.replace(sign, "")
        if self.decimal not in self.unclear:  # clear decimals have the other sign
            after = f" if it is {thousands}, else write {decimals} with {opposite!r}"
            return [(opposite, after)]
        return [(sign, f" if it is {decimals}"), (opposite, f" if it is {thousands}")]

    def rule(self, cell: str) -> str:
        """Reason why a `cell` has no value, with what to do."""
        excerpt = cell if len(cell) <= 30 else cell[:27] + "…"
        hint = ": correct it, or empty the cell to leave out its row"
        if _COMMA.fullmatch(cell):
            hint = ": write the decimals after a point"
        if _GROUPED.fullmatch(cell):
            hint = ": write it without signs between thousands"
        elif _WITH_UNIT.fullmatch(cell):
            hint = ": write the number alone, in the unit of its column"
        return f"{excerpt!r} is no finite number{hint}"

    def _unclear_sign(self, cell: str) -> str:
        """The sign in a `cell` of which the meaning isn't known; empty without one."""
        signs = [sign for sign in self.unclear if sign in cell]
        return signs[0] if signs and _may_be_thousands(cell) else ""


class TableColumns(NamedTuple):
    """A table's columns, `numbers` and `texts`, each keyed by its position in the header.

    - `numbers`: as the file writes them; clock times in seconds.
    - `texts`: as the file writes them.
    - `lines`: the file's line of each row.
    - `notes`: on rows that were left out.
    """

    numbers: dict[int, np.ndarray]
    texts: dict[int, list[str]]
    lines: np.ndarray
    notes: tuple[str, ...]


class _Layout(NamedTuple):
    """Delimiter of a table, and indices among its first lines: of header, units and readings.

    `header`: `None` for a table that begins with numbers; `width`: cells of a row, 0 without rows.
    """

    delimiter: str
    header: int | None
    units: int | None
    start: int
    width: int


class _Rows(NamedTuple):
    """Rows of a table that are neither blank, remarks nor its header.

    - `columns`: cells of each column, blank where a row is shorter; `extra`: of further cells.
    - `lines`: the file's line of each row.
    - `short`: mask of rows between blanks with a cell too few.
    """

    columns: list[list[str]]
    extra: list[list[str]]
    lines: np.ndarray
    short: np.ndarray


@dataclass(frozen=True)
class Table(TableHeader):
    """A file with its header read, and its cells still as text.

    - `delimiter`: the sign between cells; `numbers`: the format of numbers.
    - `first`: the number of the body's first line.
    - `row_width`: cells of a row between blanks, where a missing cell leaves no sign; else 0.
    """

    delimiter: str
    numbers: NumberFormat
    first: int
    row_width: int

    def cell_error(self, line: int, column: int, rule: str) -> ValueError:
        """The error for a cell that breaks a `rule`."""
        return ValueError(f"{self.source}, line {line}, column `{self.header[column]}`: {rule}")

    def read(
        self,
        numbers: Sequence[int],
        texts: Sequence[int],
        time: int | None = None,
        rows: tuple[int, int] | None = None,
        block: int | None = None,
    ) -> TableColumns:
        """Read the columns with indices `numbers` as finite floats, those in `texts` as text.

        Rows with holes in `numbers` are left out. The column `time`, of numbers or clock times, is
        missing in the result if it holds something else. `rows`: first and last row, from 1;
        default: all rows, unless they are of several specimens. Blank cells of the column `block`
        take the number above them if its numbers stand in the first row of each of several blocks.
        Raises a `ValueError` with line and column for the first bad cell, and for a loss of more
        than half of the rows.
        """
        notes = []
        found = self._rows()
        if block is not None and _begins_blocks(found.columns[block]):
            found.columns[block] = _fill_down(found.columns[block])
            notes.append(f"column `{self.header[block]}`: blank cells take the pressure above them")
        first, last = rows or (1, MAX_ROWS)
        total = len(found.lines)
        chosen = np.arange(first - 1, min(last, total))
        values = {i: self.numbers.values(found.columns[i][first - 1 : last]) for i in numbers}
        finite = np.array([np.isfinite(values[i]) for i in numbers], dtype=bool).reshape(
            len(numbers), chosen.size
        )
        kept, left_out, ends = self._select_rows(found, chosen, finite, numbers)
        if ends and rows is None:
            before = f"{self.source}: {len(ends) + 1} specimens in one file: read the first with "
            raise MissingMetadataError(before, ("rows", "", f"1:{ends[0]}", ", or all with 1:"))
        count = int(kept.sum())
        if not count:
            raise self._empty_error(numbers, left_out, chosen.size)
        self._check_loss(left_out, count)
        notes = [
            f"{len(rows)} {'row' if len(rows) == 1 else 'rows'} {_LEFT_OUT[kind]} left out, the"
            f" first in line {rows[0][0]}"
            for kind, rows in left_out.items()
            if rows
        ] + notes  # fmt: skip
        chosen = chosen[kept]
        texts_by_index = {i: [found.columns[i][row] for row in chosen] for i in texts}
        numbers_by_index = {i: x[kept] for i, x in values.items()}
        if time is not None:
            clock = [found.columns[time][row] for row in chosen]
            if (seconds := read_seconds(clock, self.numbers)) is not None:
                numbers_by_index[time] = seconds
        return TableColumns(numbers_by_index, texts_by_index, found.lines[chosen], tuple(notes))

    def _select_rows(
        self, found: _Rows, chosen: np.ndarray, finite: np.ndarray, numbers: Sequence[int]
    ) -> tuple[np.ndarray, dict[str, list[tuple[int, list[str]]]], list[int]]:
        """Mask of the `chosen` rows with a reading, the others by kind with their lines, and rows
        above the names of further specimens; `finite`: mask of the needed cells.
        """
        total = len(found.lines)
        has_extra = np.zeros(total, dtype=bool)
        for column in found.extra:
            has_extra |= np.array([cell != "" for cell in column], dtype=bool)
        firsts = found.columns[0]
        words = np.array([cell[:1].isalpha() and not _is_hole(cell) for cell in firsts], dtype=bool)
        odd = ~finite.all(axis=0) | (has_extra | words | found.short)[chosen]
        kept, left_out, ends = ~odd, {kind: [] for kind in _LEFT_OUT}, []
        # below rows that begin otherwise, a word begins those of a mean and the like
        starts = (k for k in np.flatnonzero(~odd).tolist() if is_number(firsts[chosen[k]] or "0"))
        led = next(starts, chosen.size)
        for k in np.flatnonzero(odd):
            row, line = int(chosen[k]), int(found.lines[chosen[k]])
            cells = [column[row] for column in found.columns]
            needed, is_whole = [cells[i] for i in numbers], bool(finite[:, k].all())
            has_hole = found.short[row] or (not is_whole and any(map(_is_hole, needed)))
            is_text = words[row] and k > led
            if is_text or not (is_whole or has_hole or any(map(is_number, needed))):
                self._check_header(cells, line, row + 1)
                left_out["words"].append((line, cells))
                ends += [row] if _SPECIMEN.fullmatch(cells[0]) else []
            elif has_extra[row]:
                further = [column[row] for column in found.extra]
                raise self._width_error(line, _trim([*cells, *further]))
            elif has_hole:
                left_out["holes"].append((line, cells))
            elif is_whole:
                kept[k] = True
            else:
                raise self._number_error(line, cells, numbers[int(np.argmin(finite[:, k]))])
        return kept, left_out, ends

    def _rows(self) -> _Rows:
        """Cells of the rows, read by pandas."""
        require("pandas")
        import pandas as pd

        width, delimiter = len(self.header), self.delimiter
        lines = ["" if line[:1] in " \t#%/" and is_remark(line) else line for line in self.body]
        if delimiter.isspace() and delimiter != "\t":
            blanks = re.compile(f"[ \t]{{{len(delimiter)},}}")
            lines, delimiter = [blanks.sub("\t", line.strip()) for line in lines], "\t"
        lines = self._join_quotes(lines, delimiter)
        most = 1 + max((line.count(delimiter) for line in lines), default=0)
        if most > _MAX_COLUMNS:
            line = next(i for i, line in enumerate(lines) if line.count(delimiter) + 1 == most)
            rule = f"more than {_MAX_COLUMNS} cells, where the header has {width}"
            raise ValueError(f"{self.source}, line {self.first + line}: {rule}.")
        text = "\n".join(lines)
        if not text.strip():
            empty = np.zeros(0, dtype=int)
            return _Rows([[] for _ in self.header], [], empty, empty.astype(bool))
        try:
            frame = pd.read_csv(
                io.StringIO(text), sep=delimiter, header=None, names=range(max(most, width)),
                dtype=str, keep_default_na=False, skip_blank_lines=False, skipinitialspace=True,
            )  # fmt: skip
        except pd.errors.ParserError as error:
            text = " ".join(str(error).split()).rstrip(".")
            raise ValueError(f"{self.source}: no rows of a table: {text}.") from None
        if len(frame) < len(text.rstrip("\n").split("\n")):
            raise ValueError(f"{self.source}: a quote in it has no end: close or drop it.")
        columns = [list(map(str.strip, frame[i].tolist())) for i in frame]
        used = np.ones(len(columns[0]), dtype=bool)
        firsts = {"", self.header[0], self.units[0]}
        for row in [row for row, cell in enumerate(columns[0]) if cell in firsts]:
            cells = tuple(column[row] for column in columns)
            used[row] = any(cells) and cells[:width] not in (self.header, self.units)
        kept = np.flatnonzero(used)
        columns = [list(compress(column, used)) for column in columns]
        short = np.array([lines[row].count("\t") + 1 < self.row_width for row in kept], dtype=bool)
        return _Rows(columns[:width], columns[width:], self.first + kept, short)

    def _join_quotes(self, lines: list[str], delimiter: str) -> list[str]:
        """Lines with cells in quotes that go on in the next ones joined; blank lines take their
        places.
        """
        if not any('"' in line for line in lines):
            return lines
        sign = re.escape(delimiter)
        begin = re.compile(rf'(?:^|{sign})\s*"')
        joined, start = lines.copy(), None
        for i, line in enumerate(lines):
            if start is not None:
                joined[start], joined[i] = f"{joined[start]} {line}", ""
                start = None if '"' in line else start
            elif line.count('"') % 2 and begin.search(line):
                start = i
            is_row = sum(map(is_number, split_cells(line, delimiter))) > 1
            if start is not None and i > start and is_row:
                rule = "its quote has no end: close or drop it"
                raise ValueError(f"{self.source}, line {self.first + start}: {rule}.")
        return joined

    def _check_header(self, row: Sequence[str], line: int, count: int) -> None:
        """Refuse a `row` of names or units, the `count`-th, that differ from the header's."""
        units = self.units if any(self.units) else [read_header(x)[0][1] for x in self.header]
        if len(set(filter(is_known, row))) > 1:
            is_other = any(map(differ, row, self.header))
        else:
            row = _without_label(row) or row
            cells = [
                (strip_brackets(a), strip_brackets(b)) for a, b in zip(row, units, strict=False)
            ]
            is_other = _are_units(row) and any(a != b for a, b in cells if a)
        if is_other:
            before = (
                f"{self.source}, line {line}: another header than in line {self.line}: split the"
            )
            choice = ("rows", "", f"1:{count - 1}", ", for those above it")
            raise MissingMetadataError(f"{before} file there, or give ", choice)

    def _check_loss(self, left_out: dict[str, list[tuple[int, list[str]]]], count: int) -> None:
        """Refuse a record of `count` readings with more rows of numbers that can't be read."""
        lost = left_out["holes"]
        if len(lost) > _MAX_LOSS * (count + len(lost)):
            first = min(line for line, _ in lost)
            raise ValueError(
                f"{self.source}, line {first}: {len(lost)} of {count + len(lost)} rows have holes:"
                " fill or delete them, resample channels to one rate, or choose other columns."
            )

    def _empty_error(
        self, numbers: Sequence[int], left_out: dict[str, list[tuple[int, list[str]]]], count: int
    ) -> ValueError:
        """The error for a table of which none of its `count` rows could be read."""
        for line, row in left_out["words"][:1]:
            for column in numbers:
                if self.numbers.value(row[column]) is None:
                    return self._number_error(line, row, column)
        rule = f"no readings below the header in line {self.line}"
        if holes := left_out["holes"]:
            rule = f"no row has a number in each column, the first hole is in line {holes[0][0]}"
        elif count or self.body:
            rule = f"no readings in those rows: it has {len(self._rows().lines)}"
        return ValueError(f"{self.source}: {rule}.")

    def _width_error(self, line: int, row: Sequence[str]) -> ValueError:
        """The error for a row with more cells than the header."""
        message = (
            f"{len(row)} cells, where the header has {len(self.header)}: quote or drop the odd ones"
        )
        if self.delimiter == "," and len(row) <= 2 * len(self.header):
            message += ", or part the columns by semicolons if decimals stand after commas"
        return ValueError(f"{self.source}, line {line}: {message}.")

    def _number_error(self, line: int, row: Sequence[str], column: int) -> ValueError:
        """The error for a cell that holds no number."""
        text = row[column]
        if meanings := self.numbers.meanings(text):
            before = self.cell_error(line, column, f"{text!r} has decimals or thousands: give ")
            choices = (("decimal", "", sign, after) for sign, after in meanings)
            return MissingMetadataError(str(before), *choices)
        return self.cell_error(line, column, f"{self.numbers.rule(text)}.")


def open_table(
    raw: bytes,
    source: str,
    header_line: int | None = None,
    names: Sequence[str] = (),
    *,
    decimal: str | None = None,
) -> Table:
    """Read the header of a table from the `raw` bytes of a text file; its cells stay text.

    `source` names the file in errors; `header_line` is the header's line, counted from 1, and
    `decimal` the sign before decimals; default: they are inferred. `names` are the columns' names
    of a table without header. Raises a `ValueError` for anything but a table.
    """
    lines = decode(raw, source).replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head, remarks = _first_lines(lines, source)
    if not head:
        raise ValueError(f"{source}: empty: it needs a header and at least one row below it.")
    header_index = None
    if header_line is not None:
        header_index = next(
            (i for i, (number, _) in enumerate(head) if number == header_line), None
        )
        if header_index is None:
            raise ValueError(
                f"{source}, line {header_line}: no header can stand there: name one of the first"
                f" {_HEAD_LINES} lines that is neither blank nor a remark."
            )
    layout = _find_layout([text for _, text in head], header_index)
    cells = [split_cells(text, layout.delimiter) for _, text in head]
    if layout.header is not None:
        line, text = head[layout.header]
        header = split_cells(text, layout.delimiter, trim=False)
        last, titles = max(layout.header, layout.units or 0), head[: layout.header]
    else:
        line, last, titles = head[layout.start][0], layout.start - 1, head[: layout.start]
        where, leading = f"{source}, line {line}", remarks if last < 0 else []
        header = _headless(leading, names, layout, where)
    if header and "->" in header[0]:
        rule = "remove the clock of the serial monitor before each line, or switch it off"
        raise ValueError(f"{source}, line {line}: {rule}.")
    if any(len(name) > LONGEST_NAME for name in header):
        raise ValueError(
            f"{source}, line {line}: a column's name is longer than {LONGEST_NAME}"
            " characters: write # before lines above the header."
        )
    first = head[last + 1][0] if last + 1 < len(head) else len(lines) + 1
    body = lines[first - 1 :]
    if len(body) > MAX_ROWS:
        raise ValueError(
            f"{source}: more than {MAX_ROWS} rows: keep every tenth, or split the file."
        )
    step = max(len(body) // _SAMPLE_ROWS, 1)
    sample = [split_cells(text, layout.delimiter) for text in body[::step] if not is_remark(text)]
    numbers = detect_format(sample, layout.delimiter, decimal)
    units = (*_unit_row(cells, layout), *[""] * len(header))[: len(header)]
    return Table(
        source, tuple(header), line, units, tuple(remarks), tuple(printable(t) for _, t in titles),
        body, layout.delimiter, numbers, first,
        layout.width if layout.delimiter.isspace() and layout.delimiter != "\t" else 0,
    )  # fmt: skip


def _is_hole(cell: str) -> bool:
    return cell.lower().lstrip("+-?*.") in _HOLES


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
        raise ValueError(
            f"{where}: {len(names)} columns were named, but it has {width}: name each in its place,"
            " `-` for one to skip."
        )
    if names:
        return [*names, *[""] * (width - len(names))]
    header, units = [
        cells if len(cells) == width and not any(map(is_number, cells)) else []
        for cells in ([split_cells(text, layout.delimiter) for text in ["", "", *remarks][-2:]])
    ]
    if header and units and _are_units(units):
        return [f"{name} [{unit}]" for name, unit in zip(header, units, strict=True)]
    if units:  # the last remark has the names
        return units
    before = (
        f"{where}: no header, but numbers in {width} columns: name the columns in order, such as "
    )
    after = f"; `-` skips a column; the names are {', '.join(ROLES)}"
    raise MissingMetadataError(before, ("columns", "", _EXAMPLE, after))


def _first_lines(lines: Sequence[str], source: str) -> tuple[list[tuple[int, str]], list[str]]:
    """The first lines that are neither blank nor remarks with their numbers, and the remarks above
    the first.
    """
    head: list[tuple[int, str]] = []
    remarks: list[str] = []
    for number, text in enumerate(lines, 1):
        if len(head) == _HEAD_LINES:
            break
        if len(text) > _LONGEST_LINE:
            if head:
                break  # a long line below doesn't concern the header
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
    for delimiter in _DELIMITERS:
        cells = [split_cells(text, delimiter) for text in lines]
        counts = [sum(map(is_number, row)) for row in cells]
        is_row = [
            count > 1 and (header_index is None or i > header_index)
            for i, count in enumerate(counts)
        ]
        edges = np.flatnonzero(np.diff([False, *is_row, False])).tolist()
        blocks = []
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            widths = [len(row) for row in cells[start:end]]
            width = max(set(widths), key=widths.count)
            header, units = _header_above(cells, start, width, delimiter, header_index)
            layout = _Layout(delimiter, header, units, start, width)
            filled = sum(sum(map(bool, row)) for row in cells[start:end])
            number_share = sum(counts[start:end]) / filled
            blocks.append(((header is not None, end - start, -start), number_share, layout))
        if blocks:
            _, number_share, layout = max(blocks, key=lambda block: block[0])
            # odd lines, or a header that is printed again, part readings: the first block counts
            names = None if layout.header is None else cells[layout.header]
            shape = layout.width, counts[layout.start]
            first, is_again = next(
                (block, is_again)
                for (_, size, _), _, block in blocks
                for is_again in [block.header is not None and cells[block.header] == names]
                if block == layout
                or (
                    (block.width, counts[block.start]) == shape and (is_again or size >= _MIN_BLOCK)
                )
            )
            layout = first if first.header is None or is_again else layout
            if layout.header is not None:
                return layout
            headless.append((number_share, layout))
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
        if not any(character.isalpha() for cell in row for character in cell):
            continue
        if any(map(is_number, row)):
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


def _begins_blocks(cells: Sequence[str]) -> bool:
    """True for a number in the first row of each of several blocks, and blanks in their other rows,
    two or more.
    """
    signs = "".join(("1" if is_number(cell) else "x") if cell else "0" for cell in cells)
    return bool(re.fullmatch("(?:1000*){2,}", signs))


def _fill_down(cells: Sequence[str]) -> list[str]:
    """Cells of which blank ones take the one above them."""
    filled: list[str] = []
    for cell in cells:
        filled.append(cell or (filled[-1] if filled else ""))
    return filled


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
    return line.lstrip().startswith(_REMARK) and not (
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


def is_number(cell: str) -> bool:
    """True for a number of any format, also with signs between thousands."""
    return bool(NUMBER.fullmatch(cell) or _GROUPED.fullmatch(cell))


def detect_format(
    rows: Sequence[Sequence[str]], delimiter: str, decimal: str | None = None
) -> NumberFormat:
    """Format of the numbers in `rows` of cells of a table with a `delimiter`; `decimal`: the sign
    before decimals, if it is known.
    """
    if decimal is not None:
        if decimal not in (".", ","):
            raise InvalidInputError("decimal", 'must be "." or ","', decimal)
        return NumberFormat(decimal, grouped=True)
    cells = [cell for row in rows for cell in row]
    matches = [match for match in map(_GROUPED.fullmatch, cells) if match]
    tails = {match["tail"][0] for match in matches if match["tail"] and match["sign"] in ".,"}
    if len(tails) == 1:
        return NumberFormat(tails.pop(), True)

    any_points, any_commas = (any(map(kind.fullmatch, cells)) for kind in (_POINT, _COMMA))
    # decimals that can't be thousands make the meaning of others clear
    clear = [cell for cell in cells if not _may_be_thousands(cell)]
    points, commas = (any(map(kind.fullmatch, clear)) for kind in (_POINT, _COMMA))
    if not points and not commas and _has_integers_beside_thousands(rows):
        return NumberFormat(unclear=".,")
    if not any_commas or (delimiter == "," and any_points):
        return NumberFormat(".")
    if points and not commas:
        return NumberFormat(".", unclear=",")
    unclear = ("" if points else ".") + ("," if delimiter == "," and not commas else "")
    return NumberFormat(",", unclear=unclear)


def _may_be_thousands(cell: str) -> bool:
    """True for digits with one sign before each three of them: `2.000`, but not `0.500`."""
    match = _GROUPED.fullmatch(cell)
    return match is not None and not match["tail"] and cell.lstrip("+-")[0] != "0"


def _has_integers_beside_thousands(rows: Sequence[Sequence[str]]) -> bool:
    """True if `1.010` stands in a column with `950`, or in the only column with signs beside
    columns of integers: an instrument that writes three decimals writes `950.000`.
    """
    columns = [list(filter(is_number, column)) for column in zip_longest(*rows, fillvalue="")]
    grouped = [list(map(_may_be_thousands, column)) for column in columns if column]
    mixed = [column for column in grouped if any(column) and not all(column)]
    return bool(mixed) or (len(grouped) > 1 == sum(map(any, grouped)))


def read_seconds(texts: Sequence[str], numbers: NumberFormat) -> np.ndarray | None:
    """Times: numbers as they are, in their column's unit; clock times from the first one on [s],
    with their dates if they have them; `None` for other texts.
    """
    values = numbers.values(texts)
    if np.isfinite(values).all():
        return values
    matches = [match for match in map(_CLOCK.fullmatch, texts) if match]
    if len(matches) < len(texts):
        return None
    dates, *clocks = zip(*(match.groups() for match in matches), strict=True)
    if any(hour is None and len(second) == 2 for hour, _, second, _ in zip(*clocks, strict=True)):
        return None  # 10:11 may be minutes or hours
    seconds = np.array([
        3600 * (int(hour or 0) % 12 + 12 * (half in "Pp") if half else int(hour or 0))
        + 60 * int(minute)
        + float(re.sub("[,:]", ".", second))
        for hour, minute, second, half in zip(*clocks, strict=True)
    ])  # fmt: skip
    if any(dates):
        if (days := _read_days(dates)) is None:
            return None
    else:
        days = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -43_200)  # half a day back
    seconds = seconds + 86_400.0 * (days - days[0])
    return np.round(seconds - seconds[0], 6)  # finer than clocks are


def _read_days(texts: Sequence[str | None]) -> np.ndarray | None:
    """Days of dates since 1970; `None` for other texts, and where day and month may be swapped.

    A year stands first, and dots part day and month in this order; slashes are read by the order
    that all dates allow, unless both do and give other differences.
    """
    parts = [_DATE.fullmatch(text or "") for text in texts]
    if not all(parts):
        return None
    found: list[np.ndarray] = []
    for order in ("ymd", "dmy", "mdy"):
        fits = {"ymd": "-./", "dmy": "./-", "mdy": "/-"}[order]
        try:
            days = [_day(dict(zip(order, match.group(1, 3, 4), strict=True)))
                    for match in parts if match and match[2] in fits]  # fmt: skip
        except ValueError:
            continue
        if len(days) == len(parts):
            found.append(np.array(days))
    differences = {tuple((days - days[0]).tolist()) for days in found}
    return found[0] if len(differences) == 1 else None


def _day(date: dict[str, str]) -> int:
    """Days of a date since 1970; a year that stands last may have two digits."""
    if len(date["y"]) != 4 and (len(date["y"]) != 2 or next(iter(date)) == "y"):
        raise ValueError(date)
    year = int(date["y"]) + 2000 * (len(date["y"]) == 2)
    return (dt.date(year, int(date["m"]), int(date["d"])) - dt.date(1970, 1, 1)).days
