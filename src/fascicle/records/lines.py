"""Lines and cells of a text file: encoding, remarks, a monitor's clock, `name: number` pairs."""

import csv
import re

from .headers import is_known
from .units import is_unit


LONGEST_LINE = 100_000  # characters: what is longer is no header
_LONGEST_PRINT = 500  # characters of a line that a monitor shows: longer ones take long to search
_REMARK = ("#", "%", "//")
_MONITOR = re.compile(r"(?:[\d-]+[ T])?(\d\d:\d\d:\d\d[.,]\d+)\s*->\s*")
_PAIR = re.compile(r"([^\W\d][\w ]*?)\s*[:=]\s*([+-]?\d[\d.]*(?:[eE][+-]?\d+)?)[ \t]*([a-zA-Z%µ]*)")
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
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")  # of older Windows programs


def split_lines(text: str) -> list[str]:
    """Lines of a text, with the clock of a serial monitor and `name: number` pairs as cells."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").rstrip().split("\n")
    head = [line for line in lines[:50] if line.strip()]
    if any(len(line) > _LONGEST_PRINT for line in head):
        return lines
    if all(map(_MONITOR.match, head)):
        head = [_MONITOR.sub("", line, count=1) for line in head]
        sign = max("\t;|, ", key=lambda sign: sum(sign in line for line in head))
        headers = [
            i for i, line in enumerate(head) if sum(map(is_known, split_cells(line, sign))) > 1
        ]
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
