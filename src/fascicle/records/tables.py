"""Text tables as instruments write them: header, units, remarks, and columns as numbers.

Cells between tabs, semicolons, bars, commas or blanks; any encoding and line ends; decimal commas;
remarks after `#` or `%`; titles above the header, units beside it; headers that are repeated
between blocks of readings; a serial monitor's clock; lines of `name: number` pairs.
"""

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from .headers import ROLES, MissingMetadataError, is_known
from .units import is_unit
from .wide_tables import read_wide_header


MAX_ROWS = 20_000_000  # five hours at a kilohertz
_LONGEST_LINE = 100_000  # characters: what is longer is no header
_LONGEST_PRINT = 500  # characters of a line that a monitor shows: longer ones take long to search
_LONGEST_NAME = 100  # characters of a column's name
_HEAD_LINES = 200  # lines in which the header may stand: a data logger writes some sixty above it
_HEADER_REACH = 6  # lines above the readings in which their header may stand
_WIDE_REACH = 3  # of them for the names, pressures and units of a wide table
_DELIMITERS = ("\t", ";", "|", ",", " ", "  ")  # the first that parts a table is taken
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0\u202f]\d{3})+(?:[.,]\d+)?", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_HOLES = {"", "-", "--", "nan", "inf", "infinity", "na", "n/a", "null", "none", "#n/a"}
_EXAMPLE = "force[N],pressure[kPa],-,length[mm]"  # columns in their order
_REMARK = ("#", "%", "//")
_CLOCK = re.compile(r"(?:.*[\sT])?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)\s*(?:([AaPp])[Mm]|Z)?")
_MONITOR = re.compile(r"(?:[\d-]+[ T])?(\d\d:\d\d:\d\d[.,]\d+)\s*->\s*")
_PAIR = re.compile(r"([^\W\d][\w ]*?)\s*[:=]\s*([+-]?\d[\d.]*(?:[eE][+-]?\d+)?)[ \t]*([a-zA-Z%µ]*)")
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')


@dataclass
class TableColumns:
    """A table's columns, `numbers` and `texts`, each keyed by its position in the header.

    - `numbers`: as the file writes them; clock times in seconds.
    - `texts`: as the file writes them.
    - `lines`: the file's line of each row.
    - `notes`: on rows that were left out.
    """

    numbers: dict[int, np.ndarray]
    texts: dict[int, list[str]]
    lines: list[int]
    notes: list[str] = field(default_factory=list)

    def only(self, mask: np.ndarray) -> "TableColumns":
        """Rows in a `mask`."""
        rows = np.flatnonzero(mask)
        return TableColumns(
            {i: values[rows] for i, values in self.numbers.items()},
            {i: [texts[row] for row in rows] for i, texts in self.texts.items()},
            [self.lines[row] for row in rows],
            self.notes,
        )


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
    - `delimiter`, `decimal`: the signs between cells and in numbers.
    - `body`: the lines of the rows; `first`: the number of the first one.
    - `origins`: of a table that was wide, the file's line of each line.
    """

    source: str
    header: tuple[str, ...]
    line: int
    units: tuple[str, ...]
    remarks: tuple[str, ...]
    titles: tuple[str, ...]
    delimiter: str
    decimal: str
    body: list[str]
    first: int
    origins: tuple[int, ...] = ()

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
        rows: tuple[int, int] = (1, MAX_ROWS),
    ) -> TableColumns:
        """Read the columns with indices `numbers` as finite floats, those in `texts` as text.

        Rows with holes in `numbers` are left out. The column `time`, of numbers or clock times, is
        missing in the result if it holds something else. `rows`: first and last row, from 1.
        Raises a `ValueError` with line and column for the first bad cell.
        """
        if cells := self._read_regular(numbers, texts, time, rows):
            return cells
        width, count, is_led = len(self.header), 0, False
        values: list[list[float]] = []
        texts = [*texts, *([] if time is None else [time])]
        cells = TableColumns({}, {i: [] for i in texts}, [])
        holes: list[tuple[int, list[str]]] = []
        text_rows: list[tuple[int, list[str]]] = []
        for line, row in self._rows():
            count += 1
            if not rows[0] <= count <= rows[1]:
                continue
            row.extend([""] * (width - len(row)))
            needed = [row[i] for i in numbers]
            # below rows that begin with a number, a word begins those of a mean and the like
            is_led = is_led or bool(_NUMBER.fullmatch(row[0]))
            is_text = is_led and row[0][:1].isalpha() and row[0].lower() not in _HOLES
            is_good = all(map(_NUMBER.fullmatch, needed)) and not is_text
            has_hole = not is_good and any(x.lower().lstrip("+-") in _HOLES for x in needed)
            if is_text or not (is_good or has_hole or any(map(_NUMBER.fullmatch, needed))):
                text_rows.append((line, row))
            elif any(row[width:]):
                raise self._width_error(line, len(row))
            elif has_hole:
                holes.append((line, row))
            else:
                values.append(
                    [self._number(x, line, i) for i, x in zip(numbers, needed, strict=True)]
                )
                cells.lines.append(line)
                for i in texts:
                    cells.texts[i].append(row[i])
        if not values:
            raise self._no_readings(numbers, holes, text_rows, count)
        cells.numbers = dict(zip(numbers, np.array(values).T, strict=True))
        if time is not None and (seconds := _seconds(cells.texts.pop(time))) is not None:
            cells.numbers[time] = seconds
        for kind, left in (("with holes", holes), ("of words", text_rows)):
            if left:
                noun = "row" if len(left) == 1 else "rows"
                first = f"the first in line {left[0][0]}"
                cells.notes.append(f"{len(left)} {noun} {kind} left out, {first}")
        return cells

    def _read_regular(
        self, numbers: Sequence[int], texts: Sequence[int], time: int | None, rows: tuple[int, int]
    ) -> TableColumns | None:
        """All rows read by pandas, in a tenth of the time; `None` if they aren't regular."""
        import pandas as pd

        width = len(self.header)
        if {line.count(self.delimiter) for line in self.body} != {width - 1}:
            return None
        floats = [*numbers, *([] if time is None else [time])]
        # the nearest float is pandas' default from 3.1 on
        old = tuple(map(int, re.findall(r"\d+", pd.__version__)[:2])) < (3, 1)
        try:
            frame = pd.read_csv(
                io.StringIO("\n".join(self.body)), header=None, names=range(width), index_col=False,
                dtype={i: float if i in floats else str for i in range(width)}, na_filter=False,
                sep=self.delimiter, decimal=self.decimal, skip_blank_lines=False,
                skipinitialspace=True, float_precision="round_trip" if old else None,
            )  # fmt: skip
        except (ValueError, OverflowError):
            return None
        has_text = 0 not in floats and any(str(text)[:1].isalpha() for text in frame[0])
        if (
            has_text
            or len(frame) != len(self.body)
            or not np.isfinite(frame[floats]).all(axis=None)
        ):
            return None
        frame = frame.iloc[rows[0] - 1 : rows[1]]
        return None if frame.empty else TableColumns(
            {i: frame[i].to_numpy() for i in floats},
            {i: [text.strip() for text in frame[i]] for i in texts},
            [self._file_line(self.first + int(i)) for i in frame.index],
        )  # fmt: skip

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line and stripped cells of each row that is neither blank, a remark nor a header."""
        lines = ("" if _is_remark(line) else line for line in self.body)
        delimiter = self.delimiter
        if delimiter.isspace() and delimiter != "\t":
            blanks = re.compile(f"[ \t]{{{len(delimiter)},}}")
            lines, delimiter = (blanks.sub("\t", line.strip()) for line in lines), "\t"
        rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
        repeats = [list(self.header), list(self.units)]
        try:
            for cells in rows:
                row = [cell.strip() for cell in cells]
                if any(row) and row not in repeats:
                    yield self._file_line(self.first + rows.line_num - 1), row
        except csv.Error as error:
            line = self._file_line(self.first + rows.line_num - 1)
            raise ValueError(f"{self.source}, line {line}: no row of a table: {error}.") from None

    def _file_line(self, line: int) -> int:
        return self.origins[line - 1] if self.origins else line

    def _no_readings(
        self, numbers: Sequence[int], holes: list, text_rows: list, count: int
    ) -> ValueError:
        """The error for a table of which no row can be read."""
        if text_rows:
            line, row = text_rows[0]
            try:
                for i in numbers:
                    self._number(row[i], line, i)
            except ValueError as error:
                return error
        rule = f"no readings below the header in line {self.line}"
        if holes:
            rule = f"no row has a number in each column, the first hole is in line {holes[0][0]}"
        elif count:
            rule = f"no readings in those rows: it has {count}"
        return ValueError(f"{self.source}: {rule}.")

    def _width_error(self, line: int, count: int) -> ValueError:
        width, remedy = len(self.header), "quote or drop the odd ones"
        if self.delimiter == "," and width < count <= 2 * width:
            remedy = "if its decimals stand after commas, part the columns by semicolons"
        message = f"{count} cells, where the header has {width}: {remedy}."
        return ValueError(f"{self.source}, line {line}: {message}")

    def _number(self, text: str, line: int, column: int) -> float:
        plain = text.replace(",", ".") if self.decimal == "," else text
        # Python's own numbers, such as 1_000 and nan, are none here
        if _NUMBER.fullmatch(plain) and "," not in plain and math.isfinite(value := float(plain)):
            return value
        excerpt = text if len(text) <= 30 else text[:27] + "…"
        hint = ": write the decimals after a point" if _DECIMAL_COMMA.fullmatch(text) else ""
        if _THOUSANDS.fullmatch(text):
            hint = ": write it without signs between thousands"
        raise self.cell_error(line, column, f"{excerpt!r} is no finite number{hint}.")


def open_table(
    raw: bytes,
    source: str,
    header_line: int | None = None,
    names: Sequence[str] = (),
    *,
    wide: bool = True,
) -> Table:
    """Read the header of a table from the `raw` bytes of a text file; its cells stay text.

    `source` names the file in errors; `header_line` is the header's line, counted from 1;
    default: it is inferred. `names` are the columns' names of a table without header. `wide`: a
    table with columns for each pressure becomes a long one. Raises a `ValueError` for anything but
    a table.
    """
    lines = _split_lines(_decode(raw, source))
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
    if wide and (long := _unfold(lines, head, layout, names, source)) is not None:
        text, origins = long
        table = open_table(text.encode(), source, names=names, wide=False)
        return replace(table, line=origins[table.line - 1], origins=origins)
    cells = [_split(text, layout.delimiter) for _, text in head]
    if layout.header is not None:
        line, text = head[layout.header]
        header = _split(text, layout.delimiter, trim=False)
        last, titles = max(layout.header, layout.units or 0), head[: layout.header]
    else:
        line, last, titles = head[layout.start][0], layout.start - 1, head[: layout.start]
        header = _headless(remarks if last < 0 else [], names, layout, f"{source}, line {line}")
    if any(len(name) > _LONGEST_NAME for name in header):
        raise ValueError(
            f"{source}, line {line}: a column's name is longer than {_LONGEST_NAME}"
            " characters: write # before lines above the header."
        )
    first = head[last + 1][0] if last + 1 < len(head) else len(lines) + 1
    body = lines[first - 1 :]
    if len(body) > MAX_ROWS:
        raise ValueError(
            f"{source}: more than {MAX_ROWS} rows: keep every tenth, or split the file."
        )
    sample = [cell for row in cells[layout.start : layout.start + 50] for cell in row]
    points = any(re.fullmatch(r"[+-]?\d*\.\d+", cell) for cell in sample)
    comma = any(map(_DECIMAL_COMMA.fullmatch, sample)) and not (layout.delimiter == "," and points)
    units = (*_unit_row(cells, layout), *[""] * len(header))[: len(header)]
    return Table(
        source, tuple(header), line, units, tuple(remarks), tuple(_printable(t) for _, t in titles),
        layout.delimiter, "," if comma else ".", body, first,
    )  # fmt: skip


def _unfold(
    lines: Sequence[str],
    head: Sequence[tuple[int, str]],
    layout: _Layout,
    names: Sequence[str],
    source: str,
) -> tuple[str, tuple[int, ...]] | None:
    """Text of a wide table as a long one, and the file's line of each of its lines; `None` for
    other tables.
    """
    rows = [_split(text, layout.delimiter, trim=False) for _, text in head]
    start = layout.start
    firsts = [_NUMBER.fullmatch(row[0]) is not None for row in rows[start : start + 2]]
    start += firsts == [False, True]  # a row of pressures that begins with their name
    above = max(start - _WIDE_REACH, 0)
    try:
        header = read_wide_header(rows[above:start], max(map(len, rows[above : start + 50])))
    except ValueError as error:
        raise ValueError(f"{source}, line {head[start - 1][0]}: {error}.") from None
    if header is None or len(names) >= len(header.names):
        return None
    first, top = head[start][0] if start < len(head) else len(lines) + 1, head[above][0]
    body = [
        [] if _is_remark(line) else _split(line, layout.delimiter, trim=False)
        for line in lines[first - 1 :]
    ]
    is_led = any(_NUMBER.fullmatch(row[0]) for row in body if row)
    is_row = [
        any(map(_NUMBER.fullmatch, row)) and not (is_led and row[0][:1].isalpha()) for row in body
    ]
    readings = header.long_rows(
        [row if flag else [] for row, flag in zip(body, is_row, strict=True)]
    )
    words = [(i, row[:1]) for i, row in enumerate(body) if any(row) and not is_row[i]]
    below, titles = [*readings, *words], [
        (line, text) for (line, text), row in zip(head[above:start], rows[above:start], strict=True)
        if sum(map(bool, row)) == 1
    ]  # fmt: skip
    text = [*lines[: top - 1], *(title for _, title in titles), "\t".join(header.names)]
    text += ["\t".join(row) for _, row in below]
    origins = [*range(1, top), *(line for line, _ in titles), head[start - 1][0]]
    return "\n".join(text), (*origins, *(first + i for i, _ in below))


def has_readings(raw: bytes) -> bool:
    """True for text that holds a table with rows of numbers."""
    head, _ = _first_lines(raw.decode().split("\n"), "")
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
    header = _split(remarks[-1], layout.delimiter) if remarks else []
    if len(header) == width and not any(map(_NUMBER.fullmatch, header)):
        return header
    before = f"{where}: no header, but numbers in {width} columns: name them in order, such as "
    after = f", `-` for one to skip, of {', '.join(ROLES)}"
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
        if _is_remark(text):
            remarks += [text.strip().lstrip("#%/").strip()] * (not head)
        elif head and text.count('"') % 2 and head[-1][1].count('"') % 2:
            head[-1] = head[-1][0], f"{head[-1][1]} {text}"  # a name over two lines, in quotes
        elif text.strip():
            head.append((number, text))
    return head, remarks


def _is_remark(line: str) -> bool:
    """True for a line after a remark's sign; units in a row may begin with one, too: `%,N`."""
    return line.lstrip().startswith(_REMARK) and not (
        len(cells := re.split(r"[\t,;|]", line)) > 1 and all(map(is_unit, cells))
    )


def _find_layout(lines: Sequence[str], header_index: int | None) -> _Layout:
    """Delimiter, header and units of a table; `header_index`: of the header, if it is known.

    Its readings are the longest block of lines with two numbers or more; the header is the line
    above them with as many cells, units may stand between. Without readings it is the first line.
    """
    headless: list[tuple[float, _Layout]] = []
    for delimiter in _DELIMITERS:
        cells = [_split(text, delimiter) for text in lines]
        counts = [sum(map(bool, map(_NUMBER.fullmatch, row))) for row in cells]
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
            number_share = sum(counts[start:end]) / sum(widths)
            blocks.append(((header is not None, end - start, -start), number_share, layout))
        if blocks:
            _, number_share, layout = max(blocks, key=lambda block: block[0])
            if layout.header is not None:
                return layout
            headless.append((number_share, layout))
    if headless:  # of several delimiters the one that leaves numbers
        return max(headless, key=lambda pair: pair[0])[1]
    first = header_index or 0
    delimiter = max(("\t", ";", ","), key=lambda sign: len(_split(lines[first], sign)))
    below = _split(lines[first + 1], delimiter) if len(lines) > first + 1 else []
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
        if any(map(_NUMBER.fullmatch, row)):
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
    for row in cells[: layout.header or 0]:
        if row and re.search(r"unit|einheit", row[0], re.IGNORECASE) and _are_units(row[1:]):
            return ["", *row[1:]]
    return []


def _are_units(cells: Sequence[str]) -> bool:
    """True for cells of which at least half are units, and none is a number."""
    written = [cell for cell in cells if cell]
    units = sum(map(is_unit, written))
    # 1 is a unit of strain, and a reading
    return 2 * units >= max(len(written), 1) and not any(map(_NUMBER.fullmatch, written))


def _seconds(texts: Sequence[str]) -> np.ndarray | None:
    """Times as numbers; clock times from the first one on [s]; `None` for other texts."""
    if all(map(_NUMBER.fullmatch, texts)):
        values = np.array([float(text.replace(",", ".")) for text in texts])
        return values if np.isfinite(values).all() else None
    clocks = [match.groups() for match in map(_CLOCK.fullmatch, texts) if match]
    if len(clocks) < len(texts):
        return None
    hours = [int(h) % 12 + 12 * (half in "Pp") if half else int(h) for h, _, _, half in clocks]
    minutes = [60 * h + int(clock[1]) for h, clock in zip(hours, clocks, strict=True)]
    seconds = np.array([float(clock[2].replace(",", ".")) for clock in clocks])
    seconds += 60 * np.array(minutes)
    nights = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -43_200)  # half a day back
    return np.round(seconds + 86_400 * nights - seconds[0], 6)  # finer than clocks are


def _decode(raw: bytes, source: str) -> str:
    """Text of a file in any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return raw.decode("utf-16", errors="replace")
    if raw[1:8:2] == b"\0\0\0\0":
        return raw.decode("utf-16-le", errors="replace")
    if b"\0" in raw[:_LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def _split_lines(text: str) -> list[str]:
    """Lines of a text, with the clock of a serial monitor and `name: number` pairs as cells."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head = [line for line in lines[:50] if line.strip()]
    if any(len(line) > _LONGEST_PRINT for line in head):
        return lines
    if all(map(_MONITOR.match, head)):
        head = [_MONITOR.sub("", line, count=1) for line in head]
        sign = max("\t;|, ", key=lambda sign: sum(sign in line for line in head))
        headers = [i for i, line in enumerate(head) if sum(map(is_known, _split(line, sign))) > 1]
        for i, line in enumerate(lines):
            clock = "monitor_clock" if i in headers[:1] else r"\1"
            # without header, columns are named by their place in what was printed
            lines[i] = _MONITOR.sub(f"{clock}{sign}" if headers else "", line, count=1)
    pairs = [_PAIR.findall(line) for line in head]
    rests = "".join(_PAIR.sub("", line) for line in head)
    if len({tuple((name, unit) for name, _, unit in row) for row in pairs}) == 1 and not (
        len(pairs[0]) < 2 or rests.strip(" \t,;|")
    ):
        header = "\t".join(f"{name} [{unit}]" if unit else name for name, _, unit in pairs[0])
        rows = ("\t".join(number for _, number, _ in _PAIR.findall(line)) for line in lines)
        lines = [header, *rows]
    return lines


def _printable(cell: str) -> str:
    """A header as messages show it, on one line."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in cell).split())


def _split(line: str, delimiter: str, *, trim: bool = True) -> list[str]:
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
    cells = [_printable(cell) for cell in cells]
    while trim and cells and not cells[-1]:
        cells.pop()
    return cells
