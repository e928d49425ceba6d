"""How wide a record's hysteresis loops are, pressure by pressure.

A static law describes the half-way curve. In use a muscle pulls by half of the loop's width less
while it contracts, and by as much more on the way back: an error of any such law, however well
it fits.
"""

from dataclasses import dataclass

import numpy as np

from .averaging import averaged
from .record import DOWN, UP, Record


_APART = 0.005  # of the largest pressure: closer ones are one, as levels of a fit are
_MOST = 12  # pressures that widths are told at; where more were measured, neighbors together


@dataclass(frozen=True, eq=False)
class Loop:
    """Widths of hysteresis loops: force on the way back less that on the way there.

    - `pressure`: where both ways were measured [Pa], rising.
    - `width`: mean over the loop at each of them [N]; `widest`: the largest there [N].
    - `pull`: the largest half-way force at each of them [N].
    - `half`: root mean square of half the width over all of them [N].
    """

    pressure: np.ndarray
    width: np.ndarray
    widest: np.ndarray
    pull: np.ndarray
    half: float

    @property
    def share(self) -> np.ndarray:
        """Width over the largest half-way force at each pressure [-]."""
        return self.width / np.where(self.pull > 0, self.pull, np.nan)


def loop_of(record: Record) -> Loop | None:
    """The widths of a `record`'s loops [-]; `record`: with both ways of each loop [-], else there
    is `None`.
    """
    if not {UP, DOWN} <= set(np.unique(record.branch).tolist()):
        return None
    try:
        half_way = averaged(record)
    except ValueError:  # no sweeps in it
        return None
    made = half_way.record
    both = np.isfinite(half_way.width) & ~made.censored
    if not np.any(both):
        return None
    P, width, force = made.pressure[both], half_way.width[both], made.force[both]
    top = max(float(P.max()), 1.0)
    order = np.argsort(P, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(P[order]) > _APART * top) + 1)
    if len(parts) > _MOST:
        parts = np.array_split(order, _MOST)
    return Loop(
        pressure=np.array([P[part].mean() for part in parts]),
        width=np.array([width[part].mean() for part in parts]),
        widest=np.array([width[part][np.argmax(np.abs(width[part]))] for part in parts]),
        pull=np.array([force[part].max() for part in parts]),
        half=float(np.sqrt(np.mean((width / 2) ** 2))),
    )
