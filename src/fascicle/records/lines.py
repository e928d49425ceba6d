"""Lines and cells of a text file: encoding, remarks, a monitor's clock, quantities in words.

A serial monitor shows a clock before each line, `12:00:01.123 -> ` or `[0.500] `. Behind it, or in
a log of its own, a board prints cells, `p=200.1 kPa F=3.2 N`, or `200.1 kPa; 3.2 N`.
"""

import csv
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from .headers import is_known
from .units import is_unit


LONGEST_LINE = 100_000  # characters: what is longer is no header
CLOCK_NAME = "monitor_clock"  # header of a serial monitor's clock
_LONGEST_PRINT = 500  # characters of a line that a monitor shows: longer ones take long to search
_REMARK = ("#", "%", "//")
_NUMBER = r"[+-]?(?:\d+(?:[.,]\d+|\.)?|\.\d+)(?:[eE][+-]?\d+)?"
_TIME_OF_DAY = r"(?:[\d./-]+[ T])?\d\d:\d\d:\d\d[.,]\d+"
_NAME = r"[^\W\d][\w -]*?(?:\s*[\[(][^\])]*[\])])?"  # a unit in brackets may follow
_MONITOR = re.compile(
    rf"(?:({_TIME_OF_DAY})\s*->|\[({_TIME_OF_DAY}|{_NUMBER})\]|({_NUMBER})\s*(?::|->)(?=\s)"
    # followed by a blank alone, only before a single number or a named one
    rf"|({_TIME_OF_DAY})(?=\s+(?:[\d.+-]\S*$|{_NAME}\s*[:=])))\s*"
)
_QUANTITY = re.compile(
    rf'"?({_NAME})"?\s*[:=]\s*"?({_TIME_OF_DAY}|{_NUMBER}|[+-]?(?:nan|inf|ovf))"?'
    rf"(?:[ \t]*([a-zA-Z%µ°]+)(?!\w*(?:\s*[\[(][^\])]*[\])])?\s*[:=]))?"  # no further name
    rf"|(?<![\w.+-])({_NUMBER})[ \t]*([a-zA-Z%µ°]+)(?![\w:=])"
)
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')


def decode(raw: bytes, source: str) -> str:
    """Text of a file in any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return raw.decode("utf-16", errors="replace")
    for first, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if raw[first:8:2] == b"\0\0\0\0":
            return raw.decode(encoding, errors="replace")
    raw = raw.rstrip(b"\0")  # of a logger that reserves its file
    if b"\0" in raw[:LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    try:
        return raw.decode("utf-8-sig").replace("\u2212", "-")  # the minus of typesetters
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def table_lines(text: str) -> tuple[list[str], tuple[str, ...]]:
    """Lines of a table's text, with the clock of a serial monitor and quantities in words as cells,
    and the names of columns for which no line has a header: the clock's, which comes first, and
    those of quantities in words.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head = [line for line in lines[:50] if line.strip()]
    if not head or any(len(line) > _LONGEST_PRINT for line in head):
        return lines, ()
    clocks: list[str] = []
    if 2 * sum(bool(_MONITOR.match(line)) for line in head) > len(head):
        matches = [_MONITOR.match(line) for line in lines]
        clocks = [next(filter(None, match.groups())) if match else "" for match in matches]
        lines = [line[match.end() :] if match else line
                 for line, match in zip(lines, matches, strict=True)]  # fmt: skip
    columns = _quantity_columns(lines[:50])
    if columns:
        lines = [_quantity_cells(line, columns) for line in lines]
    names = tuple(f"{name} [{unit}]" if unit else name for (name, _), unit in columns.items())
    if not clocks:
        return lines, names
    sign = max("\t;|, ", key=lambda sign: sum(sign in line for line in lines[:50]))
    counts = [sum(map(is_known, split_cells(line, sign))) for line in lines[:50]]
    header_index = next((i for i, count in enumerate(counts) if count > 1), None)
    if header_index is not None:
        clocks[header_index] = CLOCK_NAME
    return [f"{clock}{sign}{line}" if line.strip() else ""
            for clock, line in zip(clocks, lines, strict=True)], (CLOCK_NAME, *names)  # fmt: skip


def _quantity_columns(lines: Sequence[str]) -> dict[tuple[str, int], str]:
    """Unit of each column, where most `lines` consist of quantities in words; else empty."""
    lines = [line for line in lines if line.strip()]
    texts = (_QUANTITY.sub("", line) for line in lines)  # beside the quantities
    rows = [find_quantities(line) for line, text in zip(lines, texts, strict=True)
            if not any(map(str.isdigit, text))]  # fmt: skip
    (names, count), *_ = [*Counter(map(frozenset, rows)).most_common(1), (frozenset(), 0)]
    bare = [name for name, _ in names if name.startswith("[")]
    if len(names) < 2 or 2 * count <= len(lines) or not all(map(is_unit, bare)):
        return {}
    row = next(row for row in rows if row.keys() == names)
    return {column: unit for column, (_, unit) in row.items()}


def _quantity_cells(line: str, columns: Mapping[tuple[str, int], str]) -> str:
    """Numbers of a line's quantities in the order of `columns`, with a unit that differs from the
    column's; a line without quantities as it is.
    """
    row = find_quantities(line)
    cells = (
        number if unit == columns[column] else f"{number}{unit}"
        for column in columns
        for number, unit in [row.get(column, ("", columns[column]))]
    )  # fmt: skip
    return "\t".join(cells) if row else line.strip()


def find_quantities(line: str) -> dict[tuple[str, int], tuple[str, str]]:
    """Number and unit of each quantity in a line, by its name, or else its unit in brackets, and
    how many of that name stand before it.
    """
    row: dict[tuple[str, int], tuple[str, str]] = {}
    count: Counter[str] = Counter()
    for name, number, unit, bare_number, bare_unit in _QUANTITY.findall(line):
        column = name or f"[{bare_unit}]"
        row[column, count[column]] = (number, unit) if name else (bare_number, "")
        count[column] += 1
    return row


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
    while trim and cells and not cells[-1]:
        cells.pop()
    return cells
