"""Text tables as instruments write them: header, units, remarks, and columns as numbers.

Cells between tabs, semicolons, bars, commas or blanks; any encoding and line ends; decimal commas;
remarks after `#` or `%`; titles above the header, units beside it; headers that are repeated
between blocks of readings.
"""

import csv
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, cast

import numpy as np

from .cells import (
    LONGEST_LINE,
    NumberFormat,
    decode,
    detect_format,
    is_number,
    is_remark,
    is_split_clock,
    printable,
    read_seconds,
    split_cells,
)
from .headers import (
    LONGEST_NAME,
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


MAX_ROWS = 20_000_000  # five hours at a kilohertz
_SAMPLE_ROWS = 500  # that show how numbers are written: a sweep reaches all of its sizes in them
_HEAD_LINES = 200  # lines in which the header may stand: a data logger writes some sixty above it
_HEADER_REACH = 6  # lines above the readings in which their header may stand
_MAX_DOUBLES = 0.05  # of the readings: more rows of two lines in one are no slip of a logger
_MAX_COLUMNS = 1000  # more take long to search, and no bench has them
_MIN_BLOCK = 3  # rows of numbers: fewer may be lines of a preamble
_DELIMITERS = ("\t", ";", "|", ",", " ", "  ")  # the first that parts a table is taken
_HOLES = {"", "nan", "inf", "infinity", "na", "n/a", "null", "none", "#n/a",
          "#div/0!", "#num!", "#value!", "#ref!", "nan(ind)", "1.#qnan", "1.#ind", "1.#inf",
          "ol", "ovl", "overload", "overflow", "overrange", "over", "err", "error"}  # fmt: skip
_SPECIMEN = re.compile(r"(?:specimen|sample|probe|prüfling)\W*\d+", re.IGNORECASE)
_EXAMPLE = "force[N],pressure[kPa],-,length[mm]"  # columns in their order


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


@dataclass(frozen=True)
class Table:
    """A file with its header read, and its cells still as text.

    - `source`: the file's name in errors.
    - `header`: the columns' names; `line`: their line.
    - `units`: from a row of units, or empty.
    - `remarks`: lines after `#` above the header; `titles`: other lines above it.
    - `delimiter`: the sign between cells; `numbers`: the format of numbers.
    - `body`: the lines of the rows; `first`: the number of the first one.
    - `row_width`: cells of a row between blanks, where a missing cell leaves no sign; else 0.
    """

    source: str
    header: tuple[str, ...]
    line: int
    units: tuple[str, ...]
    remarks: tuple[str, ...]
    titles: tuple[str, ...]
    delimiter: str
    numbers: NumberFormat
    body: list[str]
    first: int
    row_width: int

    @property
    def where(self) -> str:
        """File and line of the header, for messages."""
        return f"{self.source}, line {self.line}"

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
        take the number above them. Raises a `ValueError` with line and
        column for the first bad cell.
        """
        first, last = rows or (1, MAX_ROWS)
        width, count, is_led = len(self.header), 0, False
        values, lines = array("d"), array("q")  # row by row
        texts = [*texts, *([] if time is None else [time])]
        columns: dict[int, list[str]] = {i: [] for i in texts}
        left_out: dict[str, list[tuple[int, list[str]]]] = {
            "with holes": [], "of words": [], "of two lines in one": []
        }  # fmt: skip
        holes, text_rows, doubles = left_out.values()
        ends: list[int] = []  # rows above the names of further specimens
        for line, row in self._rows(block):
            count += 1
            if not first <= count <= last:
                continue
            is_short = len(row) < self.row_width
            row.extend([""] * (width - len(row)))
            # 10:11:12,100 in two cells
            if time is not None and len(row) == width + 1 and is_split_clock(*row[time : time + 2]):
                row[time : time + 2] = [f"{row[time]}.{row[time + 1]}"]
            needed = [row[i] for i in numbers]
            readings = list(map(self.numbers.value, needed))
            is_whole = None not in readings
            has_hole = is_short or (not is_whole and any(map(_is_hole, needed)))
            begins_with_word = row[0][:1].isalpha() and not _is_hole(row[0])
            # below rows that begin otherwise, a word begins those of a mean and the like
            is_text = is_led and begins_with_word
            if is_text or not (is_whole or has_hole or any(map(is_number, needed))):
                self._check_header(row, line, count)
                text_rows.append((line, row))
                ends += [count - 1] if _SPECIMEN.fullmatch(row[0]) else []
            elif any(row[width:]):
                doubles.append((line, row))
            elif has_hole:
                holes.append((line, row))
            elif not is_whole:
                raise self._number_error(line, row, numbers[readings.index(None)])
            else:
                is_led = is_led or not row[0] or is_number(row[0])
                values.extend(cast("list[float]", readings))
                lines.append(line)
                for i, column in columns.items():
                    column.append(self.numbers.plain(row[i]))
        if ends and rows is None:
            before = f"{self.source}: {len(ends) + 1} specimens in one file: read the first with "
            raise MissingMetadataError(before, ("rows", "", f"1:{ends[0]}", ", or all with 1:"))
        self._check_doubles(doubles, len(lines))
        if not lines:
            raise self._empty_error(numbers, holes, text_rows, count)
        data = np.reshape(values, (len(lines), len(numbers))).T
        numbers_by_index = dict(zip(numbers, data, strict=True))
        if time is not None and (seconds := read_seconds(columns.pop(time))) is not None:
            numbers_by_index[time] = seconds
        notes = tuple(
            f"{len(rows)} {'row' if len(rows) == 1 else 'rows'} {kind} left out, the first in line"
            f" {rows[0][0]}"
            for kind, rows in left_out.items()
            if rows
        )
        return TableColumns(numbers_by_index, columns, np.array(lines), notes)

    def names_blocks(self, column: int) -> bool:
        """True for a column with a number in the first row of each of several blocks, and with
        blanks in their other rows, two or more.
        """
        cells = (row[column] if column < len(row) else "" for _, row in self._rows())
        signs = (("1" if is_number(cell) else "x") if cell else "0" for cell in cells)
        head = "".join(islice(signs, 3))
        return head == "100" and bool(re.fullmatch("(?:1000*){2,}", head + "".join(signs)))

    def _rows(self, block: int | None = None) -> Iterator[tuple[int, list[str]]]:
        """Line and stripped cells of each row that is neither blank, a remark nor a header; blank
        cells of the column `block` are those above them.
        """
        lines = ("" if is_remark(line) else line for line in self.body)
        delimiter = self.delimiter
        if delimiter.isspace() and delimiter != "\t":
            blanks = re.compile(f"[ \t]{{{len(delimiter)},}}")
            lines, delimiter = (blanks.sub("\t", line.strip()) for line in lines), "\t"
        rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
        repeats, level, first = [list(self.header), list(self.units)], "", 0
        try:
            for cells in rows:
                inner_lines, first = self.body[first + 1 : rows.line_num], rows.line_num
                if inner_lines and self._swallows_readings(inner_lines):
                    line = self.first + rows.line_num - 1 - len(inner_lines)
                    raise ValueError(
                        f"{self.source}, line {line}: its quote has no end: close or drop it."
                    )
                row = [cell.strip() for cell in cells]
                if any(row) and row not in repeats:
                    if block is not None:
                        row += [""] * (block + 1 - len(row))
                        level = row[block] = row[block] or level
                    yield self.first + rows.line_num - 1, row
        except csv.Error as error:
            line = self.first + rows.line_num - 1
            raise ValueError(f"{self.source}, line {line}: no row of a table: {error}.") from None

    def _swallows_readings(self, lines: Sequence[str]) -> bool:
        """True for further `lines` of a cell in quotes that are rows of numbers themselves."""
        inner = lines[:-1] if '"' in lines[-1] else lines
        rows = (split_cells(line, self.delimiter) for line in inner)
        return any(sum(map(is_number, row)) > 1 for row in rows)

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

    def _empty_error(
        self,
        numbers: Sequence[int],
        holes: Sequence[tuple[int, list[str]]],
        text_rows: Sequence[tuple[int, list[str]]],
        count: int,
    ) -> ValueError:
        """The error for a table of which none of its `count` rows could be read."""
        for line, row in text_rows[:1]:
            for column in numbers:
                if self.numbers.value(row[column]) is None:
                    return self._number_error(line, row, column)
        rule = f"no readings below the header in line {self.line}"
        if holes:
            rule = f"no row has a number in each column, the first hole is in line {holes[0][0]}"
        elif count:
            rule = f"no readings in those rows: it has {count}"
        return ValueError(f"{self.source}: {rule}.")

    def _check_doubles(self, doubles: Sequence[tuple[int, list[str]]], count: int) -> None:
        """Refuse rows with more cells than the header, unless a few among `count` readings are
        `doubles`, two lines in one.
        """
        width, remedy = len(self.header), "quote or drop the odd ones"
        is_many = len(doubles) > _MAX_DOUBLES * count
        for line, row in doubles:
            if not is_many and len(row) >= 2 * width - 1:  # a cell of both, without a line's end
                continue
            if is_many and self.delimiter == "," and len(row) <= 2 * width:
                remedy = "if its decimals stand after commas, part the columns by semicolons"
            message = f"{len(row)} cells, where the header has {width}: {remedy}."
            raise ValueError(f"{self.source}, line {line}: {message}")

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
        if not names and sum(is_known(row[0]) for row in cells[layout.start :] if row) > 1:
            rule = "the names stand in the first column: transpose the table, a column for each"
            raise ValueError(f"{source}, line {line}: {rule}.")
        firsts = [is_number(row[0]) for row in cells[layout.start : layout.start + 2] if row]
        if not names and firsts == [False, True]:
            rule = "write above each column what its number means, such as `100 kPa`"
            raise ValueError(f"{source}, line {line}: numbers for a header: {rule}.")
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
        layout.delimiter, numbers, body, first,
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
        if len(text) > LONGEST_LINE:
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
