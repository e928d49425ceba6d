"""Lines, cells, numbers and clock times of a text file as instruments write them.

Numbers have decimal points or commas, signs between thousands, and exponents with E, or with D as
Fortran's.
"""

import csv
import datetime as dt
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from ..core.errors import InvalidInputError
from .headers import is_unit


LONGEST_LINE = 100_000  # characters: what is longer is no header
_REMARK = ("#", "%", "//")
# words between blanks, a unit in brackets with the word before it
_BLANK_CELLS = re.compile(r'"([^"]*)"|([^\s"\[({]+(?:\s?[\[({][^\])}]*[\])}])?|\S+)')
# some loggers write blanks behind the sign
NUMBER = re.compile(r"(?:[+-] *)?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+|[dD][+-]\d+)?", re.ASCII)
_FORTRAN = str.maketrans("dD", "ee", " ")  # exponents of double precision
_COMMA = re.compile(r"(?:[+-] *)?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_WITH_UNIT = re.compile(rf"{NUMBER.pattern}\s*[^\W\d_]+", re.ASCII)
_POINT = re.compile(r"(?:[+-] *)?\d*\.\d+", re.ASCII)
# with signs between thousands, and a tail of decimals
_GROUPED = re.compile(
    r"[+-]?\d{1,3}(?P<sign>[.,' \u00a0\u202f])\d{3}(?:(?P=sign)\d{3})*(?P<tail>[.,]\d+)?", re.ASCII
)
_OTHER_SIGNS = {".": frozenset(",' \u00a0\u202f"), ",": frozenset(".' \u00a0\u202f")}
_CLOCK = re.compile(
    r"(?:(\S*\d)[\sT]+)?"
    r"(?:(\d\d?):)?(\d\d):(\d\d(?:[.,:]\d+)?)\s*(?:([AaPp])[Mm]|Z|[+-]\d\d:?\d\d)?"
)
_DATE = re.compile(r"(\d+)([-./])(\d+)\2(\d+)")


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


def is_number(cell: str) -> bool:
    """True for a number of any format, also with signs between thousands."""
    return bool(NUMBER.fullmatch(cell) or _GROUPED.fullmatch(cell))


def _to_float(text: str) -> float:
    return float(text.translate(_FORTRAN))


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

    def plain(self, cell: str) -> str:
        """A number without signs between thousands; its decimal sign, and other cells, as they
        are.
        """
        if _OTHER_SIGNS[self.decimal].isdisjoint(cell):  # quick, as in most cells
            return cell
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
        if self.unclear and self._unclear_sign(cell):
            return None
        plain = self.plain(cell)
        plain = plain.replace(",", ".") if self.decimal == "," else plain
        # Python's own numbers, such as 1_000 and nan, are none here
        is_plain = NUMBER.fullmatch(plain) and "," not in plain
        return value if is_plain and math.isfinite(value := _to_float(plain)) else None

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


def detect_format(
    rows: Sequence[Sequence[str]], delimiter: str, decimal: str | None = None
) -> NumberFormat:
    """Format of the numbers in `rows` of cells of a table with a `delimiter`; `decimal`: the sign
    before decimals, if it is known.
    """
    if decimal is not None:
        if decimal not in _OTHER_SIGNS:
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


def is_split_clock(clock: str, fraction: str) -> bool:
    """True for the two cells of a clock time whose decimals stood after a comma."""
    return re.fullmatch(r".*\d:\d\d:\d\d", clock) is not None and fraction.isdecimal()


def read_seconds(texts: Sequence[str]) -> np.ndarray | None:
    """Times: numbers as they are, in their column's unit; clock times from the first one on [s],
    with their dates if they have them; `None` for other texts.
    """
    if all(map(NUMBER.fullmatch, texts)):
        values = np.array([_to_float(text.replace(",", ".")) for text in texts])
        return values if np.isfinite(values).all() else None
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
