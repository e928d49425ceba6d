"""A muscle's force at single points, as one demand asks for it, with what was solved for before.

Of numbers a law takes a quarter of an array's time, and most of that for what depends on pressure
alone. That is solved for once at many levels. Where the muscle surely pulls there, its tension law
alone says all; elsewhere its free strain is nearly known, and mostly that it hasn't collapsed. The
last points are remembered, as a level that was found is asked for again.
"""

import math
from typing import Any

import jax
import numpy as np

from ...core.roots import finished
from ...muscle import Muscle


# levels of pressure, dense where free strain and collapse change fastest
CELLS = 512
LEVELS = (np.arange(CELLS + 1) / CELLS) ** 2
_REMEMBERED = 64

Point = tuple[Any, Any]


class Single:
    """A muscle at points, between no pressure and the supply's."""

    def __init__(self, muscle: Muscle, supply: float):
        """**Arguments:** `muscle` [-]; `supply`: $P_s$ [Pa]."""
        self.law, self._supply = muscle.law, supply
        self._at: Any = None
        self._free = self._pulls = self._bows = np.empty(0)
        self._last: dict[Point, Point] = {}

    def force(self, pressure: float, strain: float) -> Point:
        """Force [N] and its slope [N] at `pressure` [Pa] and the muscle's `strain` [-]."""
        point = (pressure, strain)
        if (known := self._last.get(point)) is not None:
            return known
        found = self._found(pressure, strain)
        if len(self._last) >= _REMEMBERED:
            self._last.clear()
        self._last[point] = found
        return found

    def along(self, node: np.ndarray, strain: np.ndarray) -> Point:
        """Forces [N] and their slopes [N] at numbered `LEVELS` and strains [-]."""
        one = self._solved()

        def those(part: Any) -> Any:
            levels = LEVELS.shape  # on a last axis, of what is solved for
            return jax.tree.map(lambda x: x[..., node] if np.shape(x)[-1:] == levels else x, part)

        column = those(one.column._replace(tension=None))._replace(tension=one.column.tension)
        hinge, collapse = those((one.hinge, one.collapse))
        return one._replace(column=column, hinge=hinge, collapse=collapse).force(strain)

    def _found(self, pressure: float, strain: float) -> Point:
        self._solved()
        place = math.sqrt(pressure / self._supply) * CELLS
        cell = min(int(place), CELLS - 1)
        tension, collapse = self.law.tension, None
        if strain < self._pulls[cell]:
            pull = tension.pull(pressure, strain)
            if pull.force > 0:
                return pull.force, pull.slope
        if strain < self._bows[cell]:
            collapse = np.inf
        before, behind = self._free[cell : cell + 2]
        free = finished(_pull, (tension, pressure), before + (place - cell) * (behind - before))
        return self.law.at(pressure, free, collapse).force(strain)

    def _solved(self) -> Any:
        """What depends on pressure alone, solved for at all levels."""
        if self._at is None:
            self._at = self.law.at(LEVELS * self._supply)
            self._free = self._at.column.free_strain
            least = (np.minimum(x[1:], x[:-1]) for x in (self._free, self._at.collapse))
            self._pulls, self._bows = least
        return self._at


def _pull(theta: tuple, strain: Any) -> Point:
    """What vanishes at the free strain [N], and its slope [N]."""
    tension, pressure = theta
    pull = tension.pull(pressure, strain)
    return pull.force, pull.slope
