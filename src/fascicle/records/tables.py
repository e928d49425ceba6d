"""Text tables as instruments write them: header, units, remarks, and columns as numbers.

Cells between tabs, semicolons, commas, bars or blanks; any encoding, Windows' line ends, decimal
commas; remarks after `#` or `%`; titles above the header, units beside it; headers that are
repeated between blocks of readings; a serial monitor's prefix; lines of `name: number` pairs.

pandas reads a regular table. One with holes, remarks between its rows or a bad cell is read row by
row, to leave out rows and to name the line of a bad cell.
"""

import csv
import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .headers import ROLES, MissingMetadataError, is_known
from .units import is_unit


if TYPE_CHECKING:
    import pandas as pd

MAX_ROWS = 20_000_000  # five hours at a kilohertz
_LONGEST_LINE = 100_000  # bytes: what is longer is no header
_LONGEST_NAME = 100  # characters of a column's name
_HEAD_LINES = 200  # lines in which the header may stand: a data logger writes some sixty above it
_HEADER_REACH = 6  # lines above the readings in which their header may stand
_DELIMITERS = ("\t", ";", "|", ",", " ", "  ")  # the first that parts a table is taken
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0\u202f]\d{3})+(?:[.,]\d+)?", re.ASCII)
_NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_HOLES = {"", "-", "--", "nan", "inf", "infinity", "na", "n/a", "null", "none", "#n/a"}
_EXAMPLE = "force[N],pressure[kPa],-,length[mm]"  # columns in their order
_REMARK = ("#", "%", "//")
_CLOCK = re.compile(r"(?:.*[\sT])?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)\s*(?:([AaPp])[Mm]|Z)?")
_MONITOR = re.compile(r"(?m)^\[?(\d\d:\d\d:\d\d[.,]\d+)\]?[ \t]*(?:->|:|,)?[ \t]*")
_MONITOR_LINE = re.compile(r"\[?\d\d:\d\d:\d\d[.,]\d+\]?\s*->")
_PAIR = re.compile(r"([^\W\d][\w ]*?)\s*[:=]\s*([+-]?\d[\d.]*(?:[eE][+-]?\d+)?)[ \t]*([a-zA-Z%µ]*)")
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')


@dataclass(frozen=True)
class Cells:
    """Columns of a table, by index in the header.

    - `numbers`: as the file writes them; clock times in seconds.
    - `texts`: as categories.
    - `lines`: the file's line of each row.
    - `notes`: on rows that were left out.
    """

    numbers: dict[int, np.ndarray]
    texts: dict[int, "pd.Categorical"]
    lines: np.ndarray
    notes: tuple[str, ...] = ()


class _Line(NamedTuple):
    """A line that is neither blank nor a remark, the position of the next one, its number."""

    text: str
    end: int
    number: int


class _Layout(NamedTuple):
    """Delimiter of a table, indices of its header and units among the first lines, its width.

    `header`: `None` for a table that begins with numbers in the line `start`.
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

    def cell_error(self, line: int, column: int, rule: str) -> ValueError:
        """The error for a cell that breaks a `rule`."""
        return ValueError(f"{self.source}, line {line}, column `{self.header[column]}`: {rule}")

    def read(
        self,
        numbers: Sequence[int],
        texts: Sequence[int],
        time: int | None = None,
        rows: tuple[int, int] = (1, MAX_ROWS),
    ) -> Cells:
        """Read the columns with indices `numbers` as finite floats, those in `texts` as text.

        Rows with holes in `numbers` are left out. The column `time`, of numbers or clock times, is
        missing in the result if it holds something else. `rows`: first and last row, from 1.
        Raises a `ValueError` with line and column for the first bad cell.
        """
        cells = self._read_regular(numbers, texts, time, rows)
        return cells or self._read_rows(numbers, texts, time, rows)

    def _read_regular(
        self, numbers: Sequence[int], texts: Sequence[int], time: int | None, rows: tuple[int, int]
    ) -> Cells | None:
        """All rows read by pandas, or `None` if they aren't regular."""
        import pandas as pd

        body, width = self.body.rstrip(), len(self.header)
        count = body.count(b"\n") + 1
        # pandas fills short rows: regular rows have this many delimiters in all
        regular = body.count(self.delimiter.encode()) == count * (width - 1)
        if not regular or b"#" in body or not body:
            return None
        floats = [*numbers] if time is None else [*numbers, time]
        kinds: Any = dict.fromkeys(range(width + 1), "category") | dict.fromkeys(floats, "float64")
        # the nearest float is pandas' default from 3.1 on
        old = tuple(map(int, re.findall(r"\d+", pd.__version__)[:2])) < (3, 1)
        try:
            frame = pd.read_csv(
                io.BytesIO(body + b"\n"), header=None, names=range(width + 1), dtype=kinds,
                sep=self.delimiter, decimal=self.decimal, na_filter=False, index_col=False,
                skip_blank_lines=False, skipinitialspace=True,
                float_precision="round_trip" if old else None,
            )  # fmt: skip
        except (ValueError, OverflowError):
            return None
        # a row with a cell too many fills the last column
        if len(frame) != count or any(map(str, frame[width].cat.categories)):
            return None
        if not np.isfinite(frame[floats].to_numpy()).all():
            return None
        frame = frame.iloc[rows[0] - 1 : rows[1]]
        # words before numbers, such as those of a mean below the readings
        leads = [] if 0 in floats else frame[0].cat.categories.astype(str)
        if frame.empty or (any(map(_is_word, leads)) and not _is_word(str(frame[0].iloc[0]))):
            return None
        return Cells(
            {i: frame[i].to_numpy() for i in floats},
            {i: frame[i].cat.rename_categories(str).array for i in texts},
            np.arange(self.first, self.first + count)[rows[0] - 1 : rows[1]],
        )

    def _read_rows(
        self, numbers: Sequence[int], texts: Sequence[int], time: int | None, rows: tuple[int, int]
    ) -> Cells:
        """All rows, one by one."""
        import pandas as pd

        columns: dict[int, list[Any]] = {i: [] for i in (*numbers, *texts)}
        times: list[str] = []
        lines: list[int] = []
        holes: list[int] = []
        words: list[tuple[int, list[str]]] = []  # rows without readings
        row_number, width, is_led = 0, len(self.header), False
        for line, row in self._rows():
            row_number += 1
            if not rows[0] <= row_number <= rows[1]:
                continue
            cells = [row[i] if i < len(row) else "" for i in numbers]
            # below rows that begin with a number, a word begins those of a mean and the like
            is_led = is_led or bool(_NUMBER.fullmatch(row[0]))
            if (is_led and _is_word(row[0])) or not any(map(_NUMBER.fullmatch, cells)):
                if any(cell.lower() not in _HOLES for cell in row):
                    words.append((line, row))
                else:
                    holes.append(line)
                continue
            if any(row[width:]):
                raise self._width_error(line, len(row))
            if any(cell.lower().lstrip("+-") in _HOLES for cell in cells):
                holes.append(line)
                continue
            lines.append(line)
            for i, cell in zip(numbers, cells, strict=True):
                columns[i].append(self._number(cell, line, i))
            for i in texts:
                columns[i].append(row[i] if i < len(row) else "")
            if time is not None:
                times.append(row[time] if time < len(row) else "")
        if not lines:
            raise self._no_readings(numbers, holes, words, row_number)
        notes = [
            f"{len(left)} {'row' if len(left) == 1 else 'rows'} {kind} left out, the first in line"
            f" {left[0]}"
            for kind, left in (("with holes", holes), ("of words", [n for n, _ in words]))
            if left
        ]
        values = {i: np.array(columns[i], dtype=float) for i in numbers}
        if time is not None and (seconds := self._seconds(times)) is not None:
            values[time] = seconds
        return Cells(
            values, {i: pd.Categorical(columns[i]) for i in texts}, np.array(lines), tuple(notes)
        )

    def _rows(self) -> Any:
        """Line and stripped cells of each row that is neither blank, a remark nor a header."""
        text = io.StringIO(self.body.decode(), newline="")
        uncommented = ("\n" if line.lstrip().startswith(_REMARK) else line for line in text)
        rows = csv.reader(uncommented, delimiter=self.delimiter, skipinitialspace=True)
        repeats = [list(self.header), list(self.units)]
        try:
            for cells in rows:
                row = [cell.strip() for cell in cells]
                if any(row) and row not in repeats:
                    yield self.first + rows.line_num - 1, row
        except csv.Error as error:
            line = self.first + rows.line_num - 1
            raise ValueError(f"{self.source}, line {line}: no row of a table: {error}.") from None

    def _no_readings(
        self,
        numbers: Sequence[int],
        holes: Sequence[int],
        words: Sequence[tuple[int, list[str]]],
        count: int,
    ) -> ValueError:
        """The error for a table of which no row can be read."""
        if words:
            line, row = words[0]
            try:
                for i in numbers:
                    self._number(row[i] if i < len(row) else "", line, i)
            except ValueError as error:
                return error
        if holes:
            rule = f"no row has a number in each column, the first hole is in line {holes[0]}"
        elif count:
            rule = f"no readings in those rows: it has {count}"
        else:
            rule = f"no readings below the header in line {self.line}"
        return ValueError(f"{self.source}: {rule}.")

    def _width_error(self, line: int, count: int) -> ValueError:
        width, remedy = len(self.header), "quote or drop the odd ones"
        if self.delimiter == "," and width < count <= 2 * width:
            remedy = "if its decimals stand after commas, part the columns by semicolons"
        message = f"{count} cells, where the header has {width}: {remedy}."
        return ValueError(f"{self.source}, line {line}: {message}")

    def _number(self, text: str, line: int, column: int) -> float:
        if _NUMBER.fullmatch(text) and ("," not in text or self.decimal == ","):
            value = float(text.replace(",", "."))
            if math.isfinite(value):
                return value
        excerpt = text if len(text) <= 30 else text[:27] + "…"
        hint = ": write the decimals after a point" if _DECIMAL_COMMA.fullmatch(text) else ""
        if _THOUSANDS.fullmatch(text):
            hint = ": write it without signs between thousands"
        raise self.cell_error(line, column, f"{excerpt!r} is no finite number{hint}.")

    def _seconds(self, texts: list[str]) -> np.ndarray | None:
        """Times as numbers; clock times from the first one on [s]; `None` for other texts."""
        if all(map(_NUMBER.fullmatch, texts)):
            values = np.array([float(text.replace(",", ".")) for text in texts])
            return values if np.isfinite(values).all() else None
        clocks = [match for match in map(_CLOCK.fullmatch, texts) if match]
        if len(clocks) < len(texts):
            return None
        parts = np.array([[float(x.replace(",", ".")) for x in m.groups()[:3]] for m in clocks])
        half = np.array([(m[4] or "").lower() for m in clocks])
        parts[:, 0] += 12 * ((half == "p") & (parts[:, 0] < 12)) - 12 * (
            (half == "a") & (parts[:, 0] == 12)
        )
        seconds = parts @ [3600.0, 60.0, 1.0]
        nights = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -43_200)  # half a day back
        # thousandths: finer than clocks are
        return np.round(seconds + 86_400 * nights - seconds[0], 6)


def open_table(
    raw: bytes, source: str, header_line: int | None = None, names: Sequence[str] = ()
) -> Table:
    """Read the header of a table from the `raw` bytes of a text file; its cells stay text.

    `source` names the file in errors; `header_line` is the header's line, counted from 1;
    default: it is inferred. `names` are the columns' names of a table without header. Raises a
    `ValueError` for anything but a table.
    """
    raw = _normalize(_decode(raw, source))
    lines, remarks = _first_lines(raw, source)
    if not lines:
        raise ValueError(f"{source}: empty: it needs a header and at least one row below it.")
    layout = _find_layout(lines, source, header_line)
    delimiter, start = layout.delimiter, layout.start
    cells = [_split(line.text, delimiter) for line in lines]
    units, above = [], [line.text for line in lines[:start]]
    if layout.header is not None:
        line = lines[layout.header].number
        header = _split(lines[layout.header].text, delimiter, trim=False)
        top = lines[max(layout.header, layout.units or 0)].end
        above = [text.text for text in lines[: layout.header]]
        units = _unit_row(cells, layout)
    else:
        line = lines[start].number
        top = lines[start - 1].end if start else 0
        header = _split(remarks[-1], delimiter) if remarks else []
        if len(names) > layout.width:
            raise ValueError(
                f"{source}, line {line}: {len(names)} columns were named, but it has"
                f" {layout.width}: name each in its place, `-` for one to skip."
            )
        if names:
            header = [*names, *[""] * (layout.width - len(names))]
        # NumPy writes the header as a remark
        elif start or len(header) != layout.width or any(map(_NUMBER.fullmatch, header)):
            before = (
                f"{source}, line {line}: no header, but numbers in {layout.width} columns: name"
            )
            example = ("columns", "", _EXAMPLE, f", `-` for one to skip, of {', '.join(ROLES)}")
            raise MissingMetadataError(f"{before} them in their order, such as ", example)
    header = tuple(_printable(cell) for cell in header)
    if any(len(name) > _LONGEST_NAME for name in header):
        raise ValueError(
            f"{source}, line {line}: a column's name is longer than {_LONGEST_NAME}"
            " characters: write # before lines above the header."
        )
    first, body = 1 + raw[:top].count(b"\n"), raw[top:]
    if body.count(b"\n") > MAX_ROWS:
        raise ValueError(
            f"{source}: more than {MAX_ROWS} rows: keep every tenth, or split the file."
        )
    sample = [cell for row in cells[start : start + 50] for cell in row]
    points = any(re.fullmatch(r"[+-]?\d*\.\d+", cell) for cell in sample)
    comma = any(map(_DECIMAL_COMMA.fullmatch, sample)) and not (delimiter == "," and points)
    if delimiter.isspace() and delimiter != "\t":
        body = re.sub(rb"[ \t\r]*\n[ \t]*", b"\n", b"\n" + body)[1:]
        body = re.sub(b"[ \t]{%d,}" % len(delimiter), b"\t", body)
        delimiter = "\t"
    return Table(
        source, header, line, tuple([*units, *[""] * len(header)][: len(header)]), tuple(remarks),
        delimiter, "," if comma else ".", body, first, tuple(map(_printable, above)),
    )  # fmt: skip


def has_readings(raw: bytes) -> bool:
    """True for text that holds a table with rows of numbers."""
    lines, _ = _first_lines(raw, "")
    return bool(lines) and _find_layout(lines, "", None).width > 1


def _first_lines(raw: bytes, source: str) -> tuple[list[_Line], list[str]]:
    """The first lines that are neither blank nor remarks, and the remarks above the first."""
    lines: list[_Line] = []
    remarks: list[str] = []
    top = number = 0
    while top < len(raw) and len(lines) < _HEAD_LINES:
        end = raw.find(b"\n", top)
        number += 1
        if end - top > _LONGEST_LINE:
            if lines:
                break  # a long line below doesn't concern the header
            raise ValueError(f"{source}, line {number}: too long for a table's header.")
        text, top = raw[top:end].decode().rstrip("\r"), end + 1
        if text.lstrip().startswith(_REMARK):
            remarks += [text.strip().lstrip("#%/").strip()] * (not lines)
        elif lines and text.count('"') % 2 and lines[-1].text.count('"') % 2:
            # a name over two lines, in quotes
            lines[-1] = lines[-1]._replace(text=f"{lines[-1].text} {text}", end=top)
        elif text.strip():
            lines.append(_Line(text, top, number))
    return lines, remarks


def _find_layout(lines: Sequence[_Line], source: str, header_line: int | None) -> _Layout:
    """Delimiter, header and units of a table.

    Its readings are the longest block of lines with two numbers or more; the header is the line
    above them with as many cells, units may stand between. Without readings it is the first line.
    """
    told = None
    if header_line is not None:
        told = next((i for i, line in enumerate(lines) if line.number == header_line), None)
        if told is None:
            raise ValueError(
                f"{source}, line {header_line}: no header can stand there: name one of the first"
                f" {_HEAD_LINES} lines that is neither blank nor a remark."
            )
    headless: list[tuple[float, _Layout]] = []
    for delimiter in _DELIMITERS:
        cells = [_split(line.text, delimiter) for line in lines]
        counts = [sum(map(bool, map(_NUMBER.fullmatch, row))) for row in cells]
        is_row = [count > 1 and i != told for i, count in enumerate(counts)]
        edges = np.flatnonzero(np.diff([False, *is_row, False])).tolist()
        blocks = zip(edges[::2], edges[1::2], strict=True)
        blocks = [block for block in blocks if told is None or block[0] > told]
        layouts = []
        for start, end in blocks:
            widths = [len(row) for row in cells[start:end]]
            width = max(set(widths), key=widths.count)
            header, units = _header_above(cells, start, width, delimiter, told)
            layouts.append((header is not None, end - start, -start, header, units, width))
        if layouts:
            found, length, start, header, units, width = max(layouts, key=lambda item: item[:3])
            layout = _Layout(delimiter, header, units, -start, width)
            if found:
                return layout
            total = sum(len(row) for row in cells[-start : length - start])
            headless.append((sum(counts[-start : length - start]) / total, layout))
    if headless and told is None:
        return max(headless, key=lambda item: item[0])[1]
    first = told or 0
    text = lines[first].text
    delimiter = max(("\t", ";", ","), key=lambda sign: len(_split(text, sign)))
    below = _split(lines[first + 1].text, delimiter) if len(lines) > first + 1 else []
    return _Layout(delimiter, first, first + 1 if _are_units(below) else None, len(lines), 0)


def _header_above(
    cells: Sequence[list[str]], start: int, width: int, delimiter: str, told: int | None
) -> tuple[int | None, int | None]:
    """Indices of the header above the readings from `start` on, and of a row of units."""
    headers, units = [], None
    for i in range(start - 1, max(start - 1 - _HEADER_REACH, -1), -1):
        row = cells[i]
        if not any(character.isalpha() for cell in row for character in cell):
            continue
        if any(map(_NUMBER.fullmatch, row)) and i != told:
            continue
        if units is None and _are_units(row):
            units = i
        elif len(row) >= width or (delimiter == "," and 2 < len(row) < width <= 2 * len(row)):
            headers.append(i)
        else:
            break
    if told is not None:
        return told, units if units != told else None
    if not headers:
        return units, None
    return max(headers, key=lambda i: (sum(map(is_known, cells[i])), i)), units


def _unit_row(cells: Sequence[list[str]], layout: _Layout) -> list[str]:
    """Units below the header, or of a line above it that begins with such as Y_Unit_Label."""
    if layout.units is not None:
        return cells[layout.units]
    for row in cells[: layout.header]:
        if re.search(r"unit|einheit", row[0], re.IGNORECASE) and _are_units(row[1:]):
            return ["", *row[1:]]
    return []


def _are_units(cells: Sequence[str]) -> bool:
    """True for cells of which at least half are units, and none is a number."""
    written = [cell for cell in cells if cell]
    units = sum(map(is_unit, written))
    # 1 is a unit of strain, and a reading
    return 2 * units >= max(len(written), 1) and not any(map(_NUMBER.fullmatch, written))


def _decode(raw: bytes, source: str) -> str:
    """Text of a file in any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return raw.decode("utf-16", errors="replace")
    raw = raw.removeprefix(b"\xef\xbb\xbf")
    if raw[1:8:2] == b"\0\0\0\0":
        return raw.decode("utf-16-le", errors="replace")
    if b"\0" in raw[:_LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def _normalize(text: str) -> bytes:
    """UTF-8 with plain line ends, a monitor's clock as a cell of its own, `name: number` pairs as
    cells.
    """
    if "\n" not in text:
        text = text.replace("\r", "\n")
    head = [line for line in text[:5000].split("\n")[:-1] if line.strip()][:10]
    if head and all(map(_MONITOR_LINE.match, head)):
        plain = _MONITOR.sub("", text)
        sign = next((sign for sign in "\t;|," if sign in plain.split("\n", 1)[0]), " ")
        if sum(map(bool, map(_NUMBER.fullmatch, _split(plain.split("\n", 1)[0], sign)))) < 2:
            text = _MONITOR.sub("monitor_clock" + sign, text, count=1)
            text = _MONITOR.sub(lambda match: f"{match[1]}{sign}", text)
        else:  # columns are named by their place in what was printed
            text = plain
        head = [line for line in plain[:5000].split("\n")[:-1] if line.strip()][:10]
    pairs = [_PAIR.findall(line) for line in head]
    names = {tuple((name, unit) for name, _, unit in row) for row in pairs}
    rests = "".join(_PAIR.sub("", line) for line in head)
    if head and len(names) == 1 and len(pairs[0]) > 1 and not rests.strip(" \t\r,;|"):
        header = "\t".join(f"{name} [{unit}]" if unit else name for name, _, unit in pairs[0])
        rows = (("\t".join(n for _, n, _ in _PAIR.findall(line))) for line in text.split("\n"))
        text = f"{header}\n" + "\n".join(rows)
    raw = text.encode(errors="replace")
    return raw if raw.endswith(b"\n") else raw + b"\n"


def _printable(cell: str) -> str:
    """A header as messages show it, on one line."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in cell).split())


def _is_word(cell: str) -> bool:
    return cell[:1].isalpha() and cell.lower() not in _HOLES


def _split(line: str, delimiter: str, *, trim: bool = True) -> list[str]:
    """Stripped cells of a line; `trim`: without blank ones at its end."""
    if delimiter == " ":
        cells = [a or b for a, b in _BLANK_CELLS.findall(line)]
    elif delimiter == "  ":
        cells = re.split(r"[ \t]{2,}", line.strip())
    else:
        try:
            reader = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
            cells = [_printable(cell) for cell in next(reader, [])]
        except csv.Error:
            cells = [_printable(cell) for cell in line.split(delimiter)]
    while trim and cells and not cells[-1]:
        cells.pop()
    return cells
