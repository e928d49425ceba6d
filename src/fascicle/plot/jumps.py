"""Curves that jump, as they are drawn: open where they do, the jump itself apart, dotted."""

from collections.abc import Callable

import numpy as np

from ..bundle.reversal import Reversal
from ..core.types import Float


Curve = tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]
Jump = tuple[Float[np.ndarray, " end"], Float[np.ndarray, " end"]]


_VISIBLE = 1e-4  # a smaller step is no wider than the line
_HALVINGS = 40  # of an interval of pressure: to its last bits
_JUMP = 1e-6  # what a smooth curve can't rise in what is left of the interval


def split_at_jumps(
    pressure: np.ndarray, strain: np.ndarray, curve: Callable[[np.ndarray], np.ndarray]
) -> tuple[Curve, list[Jump]]:
    """A curve of free strain, open wherever it jumps between two of its points.

    **Arguments:**

    - `pressure`: of the unit that varies [Pa], rising.
    - `strain`: free strains there [-].
    - `curve`: free strains [-] at any pressures [Pa].

    **Returns:** pressures [Pa] and strains [-] of the curve, NaN in each gap; and the two ends of
    each jump.
    """
    at = np.flatnonzero(np.abs(np.diff(strain)) > _VISIBLE)
    low, high, before, after = pressure[at], pressure[at + 1], strain[at], strain[at + 1]
    for _ in range(_HALVINGS if at.size else 0):
        middle = (low + high) / 2
        value = curve(middle)
        left = np.abs(value - before) > np.abs(after - value)  # the larger step lies there
        low, before = np.where(left, low, middle), np.where(left, before, value)
        high, after = np.where(left, middle, high), np.where(left, value, after)
    found = np.flatnonzero(np.abs(after - before) > _JUMP)
    places = np.repeat(at[found] + 1, 3)
    gaps = np.full(found.size, np.nan)
    P = np.insert(pressure, places, np.stack([low, high, high], axis=-1)[found].ravel())
    ends = np.stack([before[found], gaps, after[found]], axis=-1)
    jumps = [(np.array([low[i], high[i]]), np.array([before[i], after[i]])) for i in found]
    return (P, np.insert(strain, places, ends.ravel())), jumps


def broken(pressure: np.ndarray, strain: np.ndarray, turn: Reversal) -> tuple[Curve, Jump]:
    """A curve of free strain through its turning point.

    **Arguments:**

    - `pressure`: of the second unit [Pa], rising.
    - `strain`: free strains there [-].
    - `turn`: where they turn [-].

    **Returns:** pressures [Pa] and strains [-] of the curve, NaN in the gap of a jump; and those
    of the jump's two ends, or none.
    """
    none = (np.empty(0), np.empty(0))
    if turn.depth <= 0:
        return (pressure, strain), none
    after = int(np.searchsorted(pressure, turn.pressure))
    P, eps = [turn.pressure], [turn.free_strain]
    jump = none
    if turn.jump:
        ends = [max(after - 1, 0), min(after, len(strain) - 1)]
        gaps = np.abs(strain[ends] - turn.free_strain)
        far = ends[int(gaps[1] >= gaps[0])]
        jump = np.array([turn.pressure, pressure[far]]), np.array([turn.free_strain, strain[far]])
        P, eps = P * 2, [np.nan, *eps] if gaps[0] > gaps[1] else [*eps, np.nan]
    at = [after] * len(P)
    return (np.insert(pressure, at, P), np.insert(strain, at, eps)), jump
