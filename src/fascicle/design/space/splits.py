r"""Muscles split into motor units: compositions, where the order counts, and partitions.

$N$ equal muscles split into units in an order of recruitment are a composition of $N$: each
of the $N - 1$ gaps between muscles is cut or not, so there are $2^{N-1}$. Without the order
they are a partition; its units are then recruited from the smallest to the largest, as
Henneman's size principle has it.
"""

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int

from ...core.refused import Refused


MOST_COMPOSED, MOST_PARTED = 20, 60  # half a million compositions, a million partitions

Counts = Int[np.ndarray, "design unit"]


def compositions(muscles: int) -> Counts:
    """All compositions of a number of muscles.

    **Arguments:** `muscles`: how many [-], 1 to 20.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range.
    """
    n = _number(muscles, MOST_COMPOSED)
    index = np.arange(2 ** (n - 1))[:, None]
    # the most significant bit is the first gap
    cuts = (index >> np.arange(n - 1)[::-1]) & 1
    unit = np.concatenate([np.zeros((len(index), 1), int), np.cumsum(cuts, axis=1)], axis=1)
    counts = np.zeros((len(index), n), int)
    np.add.at(counts, (np.arange(len(index))[:, None], unit), 1)
    return counts


def partitions(muscles: int) -> Counts:
    """All partitions of a number of muscles, smallest unit first.

    **Arguments:** `muscles`: how many [-], 1 to 60.

    **Returns:** muscles in each unit [-], a row each, zeros last; the undivided one first.

    **Raises:** `ValueError` for a number out of range.
    """
    n = _number(muscles, MOST_PARTED)
    rows: list[list[int]] = []
    parts = [0] * (n + 1)
    k, rest = 1, n - 1
    # ascending compositions, each from the one before it (Kelleher and O'Sullivan 2009)
    while k != 0:
        smallest = parts[k - 1] + 1
        k -= 1
        while 2 * smallest <= rest:
            parts[k] = smallest
            rest -= smallest
            k += 1
        last = k + 1
        while smallest <= rest:
            parts[k], parts[last] = smallest, rest
            rows.append(parts[: k + 2])
            smallest += 1
            rest -= 1
        parts[k] = smallest + rest
        rest = smallest + rest - 1
        rows.append(parts[: k + 1])
    return padded(rows[::-1], n)


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
        raise Refused("splits", "must be written like '1+4', whole numbers and plus signs", text)
    return tuple(int(part) for part in text.split("+"))


def label(counts: Iterable[Any]) -> str:
    """A composition for a reader: `1+4`; `counts`: muscles in each unit [-], zeros aside."""
    return "+".join(str(int(n)) for n in counts if n)


def _number(muscles: int, most: int) -> int:
    if not 1 <= muscles <= most:
        raise Refused("muscles", f"must lie in [1, {most}]", muscles)
    return int(muscles)
