r"""Muscles split into motor units: compositions, where the order counts, and partitions.

$N$ equal muscles split into units in an order of recruitment are a composition of $N$: each
of the $N - 1$ gaps between muscles is cut or not, so there are $2^{N-1}$. Without the order
they are a partition; its units are then recruited from the smallest to the largest, as
Henneman's size principle has it.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Int


MOST_MUSCLES, MOST_SPLITS = 100, 2_000_000  # of a bundle whose splits are enumerated, and of these
SPLITS = ("all", "partitions")

Counts = Int[np.ndarray, "design unit"]


def compositions(muscles: int, most_units: int | None = None) -> Counts:
    """All compositions of a number of muscles.

    **Arguments:**

    - `muscles`: how many [-], 1 to 100.
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range, and for more than 2 000 000 compositions.
    """
    check_number((muscles,), "all", most_units)

    @cache
    def rows(rest: int, units: int) -> Counts:
        if rest == 0:
            return np.zeros((1, units), int)
        blocks = [np.zeros((0, units), int)]
        for first in range(rest, 0, -1) if units else ():
            others = rows(rest - first, units - 1)
            blocks.append(np.column_stack([np.full(len(others), first), others]))
        return np.concatenate(blocks)

    return rows(muscles, _width(muscles, most_units))


def partitions(muscles: int, most_units: int | None = None) -> Counts:
    """All partitions of a number of muscles, smallest unit first.

    **Arguments:**

    - `muscles`: how many [-], 1 to 100.
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range, and for more than 2 000 000 partitions.
    """
    check_number((muscles,), "partitions", most_units)

    def rows(rest: int, units: int, least: int) -> Iterator[tuple[int, ...]]:
        yield (rest,)
        for first in range(rest // 2, least - 1, -1) if units > 1 else ():
            for others in rows(rest - first, units - 1, first):
                yield first, *others

    width = _width(muscles, most_units)
    return padded(list(rows(muscles, width, 1)), width)


def number_of_splits(muscles: int, splits: str, most_units: int | None = None) -> int:
    """How many splits there are.

    **Arguments:**

    - `muscles`: how many [-].
    - `splits`: "all" compositions, or "partitions" [-].
    - `most_units`: largest number of motor units [-]; left out, any.

    **Returns:** their number [-].
    """
    width = _width(muscles, most_units)
    if splits == "all":
        return sum(math.comb(muscles - 1, cuts) for cuts in range(width))
    # partitions into at most so many parts are those into parts of at most that size
    ways = [1] + [0] * muscles
    for part in range(1, width + 1):
        for total in range(part, muscles + 1):
            ways[total] += ways[total - part]
    return ways[muscles]


def check_number(numbers: Iterable[int], splits: str, most_units: int | None = None) -> None:
    """Refuse numbers of muscles that have too many splits to be enumerated.

    **Arguments:**

    - `numbers`: of muscles [-].
    - `splits`: "all" compositions, or "partitions" [-].
    - `most_units`: largest number of motor units [-]; `None` for any.

    **Raises:** `ValueError` with what would leave fewer.
    """
    numbers = tuple(numbers)
    for number in numbers:
        if not 1 <= number <= MOST_MUSCLES:
            raise InvalidInputError(
                "muscles",
                f"must lie in [1, {MOST_MUSCLES}]",
                number,
                "of more, list some splits, as '10+50+90'",
            )

    def count(kind: str, most: int | None) -> int:
        return sum(number_of_splits(number, kind, most) for number in numbers)

    total = count(splits, most_units)
    if total <= MOST_SPLITS:
        return
    ways = []
    largest = max(numbers) if most_units is None else most_units
    units = next((m for m in range(largest, 0, -1) if count(splits, m) <= MOST_SPLITS), 0)
    if units:
        left = count(splits, units)
        ways.append(f"{units} motor units at most leave {left} ([limits] valves)")
    if splits == "all" and (left := count("partitions", most_units)) <= MOST_SPLITS:
        ways.append(f"splits = 'partitions' leaves {left}")
    raise InvalidInputError(
        "muscles",
        f"lead to {total} splits, more than {MOST_SPLITS}",
        None,
        ", ".join([*ways, "or list some splits"]),
    )


def padded(rows: Sequence[Sequence[int]], units: int | None = None) -> Counts:
    """Rows of unlike length as one array.

    **Arguments:**

    - `rows`: muscles in each unit [-].
    - `units`: length of the rows [-]; left out, the longest's.

    **Returns:** the same with zeros last [-].
    """
    width = max(map(len, rows)) if units is None else units
    counts = np.zeros((len(rows), width), int)
    for place, row in enumerate(rows):
        counts[place, : len(row)] = row
    return counts


def read(text: str) -> tuple[int, ...]:
    """A composition as it is written, `1+4`.

    **Arguments:** `text`: whole numbers with plus signs between [-].

    **Returns:** muscles in each unit [-].

    **Raises:** `ValueError` for anything else.
    """
    if not re.fullmatch(r"\s*[1-9]\d{0,3}(\s*\+\s*[1-9]\d{0,3})*\s*", text, re.ASCII):
        raise InvalidInputError(
            "splits", "must be written like '1+4', whole numbers and plus signs", text
        )
    return tuple(int(part) for part in text.split("+"))


def label(counts: Iterable[Any]) -> str:
    """A composition for a reader: `1+4`; `counts`: muscles in each unit [-], zeros aside."""
    return "+".join(str(int(n)) for n in counts if n)


def _width(muscles: int, most_units: int | None) -> int:
    """Length of a row of splits: the largest number of motor units."""
    return muscles if most_units is None else max(1, min(muscles, most_units))
