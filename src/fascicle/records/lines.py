"""Lines and cells of a text file: encoding, remarks, a monitor's clock, `name: number` pairs."""

import csv
import re
from collections import Counter
from collections.abc import Sequence

from .headers import is_known
from .units import is_unit


LONGEST_LINE = 100_000  # characters: what is longer is no header
CLOCK_NAME = "monitor_clock"  # header of a serial monitor's clock
_LONGEST_PRINT = 500  # characters of a line that a monitor shows: longer ones take long to search
_REMARK = ("#", "%", "//")
_MONITOR = re.compile(r"(?:[\d-]+[ T])?(\d\d:\d\d:\d\d[.,]\d+)\s*->\s*")
_PAIR = re.compile(
    r"([^\W\d][\w ]*?)\s*[:=]\s*([+-]?\d[\d.]*(?:[eE][+-]?\d+)?)"
    r"(?:[ \t]*([a-zA-Z%µ]+)(?!\w*\s*[:=]))?"  # a unit, not the next name
)
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')


def decode(raw: bytes, source: str) -> str:
    """Text of a file in any encoding of instruments."""
    if raw[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return raw.decode("utf-16", errors="replace")
    if raw[1:8:2] == b"\0\0\0\0":
        return raw.decode("utf-16-le", errors="replace")
    if b"\0" in raw[:LONGEST_LINE]:
        raise ValueError(f"{source}: not a text file; a record is a CSV, export it as one.")
    try:
        return raw.decode("utf-8-sig").replace("\u2212", "-")  # the minus of typesetters
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def table_lines(text: str) -> tuple[list[str], bool]:
    """Lines of a table's text, with `name: number` pairs and the clock of a serial monitor as
    cells, and a flag: true if there is a clock, which comes first.
    """
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head = [line for line in lines[:50] if line.strip()]
    if not head or any(len(line) > _LONGEST_PRINT for line in head):
        return lines, False
    clocks: list[str] = []
    if all(map(_MONITOR.match, head)):
        matches = [_MONITOR.match(line) for line in lines]
        clocks = [match[1] if match else "" for match in matches]
        lines = [line[match.end() :] if match else line
                 for line, match in zip(lines, matches, strict=True)]  # fmt: skip
        head = lines[:50]
    if names := _pair_names(head):
        header = "\t".join(f"{name} [{unit}]" if unit else name for name, unit in names)
        first = next(i for i, line in enumerate(lines) if names[0] in _pairs(line))
        lines = [_pair_cells(line, names) for line in lines]
        lines.insert(first, header)  # below the lines of a start
        clocks.insert(first, "")
    if not any(clocks):
        return lines, False
    sign = max("\t;|, ", key=lambda sign: sum(sign in line for line in lines[:50]))
    counts = [sum(map(is_known, split_cells(line, sign))) for line in lines[:50]]
    header_index = next((i for i, count in enumerate(counts) if count > 1), None)
    if header_index is not None:
        clocks[header_index] = CLOCK_NAME
    return [f"{clock}{sign}{line}" if line.strip() else ""
            for clock, line in zip(clocks, lines, strict=True)], True  # fmt: skip


def _pair_names(lines: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Names and units of the `name: number` pairs of which most `lines` consist; empty for other
    lines.
    """
    lines = [line for line in lines if line.strip()]
    rows = [_pairs(line) for line in lines if not _PAIR.sub("", line).strip(" \t,;|")]
    (names, count), *_ = [*Counter(map(tuple, rows)).most_common(1), ((), 0)]
    return names if len(names) > 1 and 2 * count > len(lines) else ()


def _pair_cells(line: str, names: Sequence[tuple[str, str]]) -> str:
    """Numbers of a line's pairs in the order of `names`; a line without pairs as it is."""
    pairs = _pairs(line)
    return "\t".join(pairs.get(name, "") for name in names) if pairs else line.strip()


def _pairs(line: str) -> dict[tuple[str, str], str]:
    """Numbers of a line's `name: number` pairs, by name and unit."""
    return {(name, unit): number for name, number, unit in _PAIR.findall(line)}


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
