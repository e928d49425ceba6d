"""Curves that jump, as they are drawn: open where they do, the jump itself apart, dotted."""

import numpy as np
from jaxtyping import Float

from ..bundle.reversal import Reversal


Curve = tuple[Float[np.ndarray, " point"], Float[np.ndarray, " point"]]
Jump = tuple[Float[np.ndarray, " end"], Float[np.ndarray, " end"]]


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
