"""A muscle's force at single points, as one demand asks for it, with what was solved for before.

Most of a point's time goes to what depends on pressure alone. That is solved for once at many
levels. Where the muscle surely pulls there, its tension law alone says all; elsewhere its free
strain is nearly known, and mostly that it hasn't collapsed. At both ends all of it is known. The
last points are remembered, as a level that was found is asked for again.
"""

import math
from functools import cached_property
from typing import Any

import jax
import numpy as np

from ...core.often import Often
from ...core.roots import finished
from ...core.types import Numbers
from ...muscle import Muscle
from ...muscle.piecewise import Piecewise, Pressurized


# levels of pressure, dense where free strain and collapse change fastest
CELLS = 512
LEVELS = (np.arange(CELLS + 1) / CELLS) ** 2
_REMEMBERED = 64
_FEW = 64  # points up to which one by one is sooner than an array

Point = tuple[Any, Any]


class Single:
    """A muscle at points, between no pressure and the supply's."""

    def __init__(self, muscle: Muscle, supply: float):
        """**Arguments:** `muscle` [-]; `supply`: $P_s$ [Pa]."""
        self.law, self._supply = muscle.law, float(supply)
        laws = {_pull: 2, _solved: 4, _bowed: 3, _whole: 3}
        self._pull, self._solved, self._bowed, self._whole = (
            Often(law, self.law, count) for law, count in laws.items()
        )
        self._last: dict[Point, Point] = {}

    def force(self, pressure: float, strain: float) -> Point:
        """Force [N] and its slope [N] at `pressure` [Pa] and the muscle's `strain` [-]."""
        point = (pressure, strain)
        if (known := self._last.get(point)) is not None:
            return known
        if len(self._last) >= _REMEMBERED:
            self._last.clear()
        self._last[point] = found = self._found(pressure, strain)
        return found

    def ends_at_once(self) -> bool:
        """Whether at both ends it is soon told by itself."""
        return all(end.spelled_out() for end in self._ends)

    def _found(self, pressure: float, strain: float) -> Point:
        place = math.sqrt(pressure / self._supply) * CELLS
        if place in (0, CELLS):
            return self._ends[place > 0](strain)
        cell = min(int(place), CELLS - 1)
        (_, before, collapse), (_, behind, later) = self._known[cell : cell + 2]
        if strain < min(before, behind):
            pull = self._pull(pressure, strain)
            if pull[0] > 0:
                return pull
        near = before + (place - cell) * (behind - before)
        bows = strain < min(collapse, later)
        return (self._bowed if bows else self._whole)(pressure, near, strain)

    def along(self, node: np.ndarray, strain: Numbers) -> np.ndarray:
        """Forces [N] at numbered `LEVELS` and strains [-]."""
        if node.size <= _FEW and self._solved.spelled_out(node.size):
            levels = [self._known[n] for n in node.flat]
            strains = np.broadcast_to(strain, node.shape).flat
            found = [self._solved(*one, eps) for one, eps in zip(levels, strains, strict=True)]
            return np.reshape(found, node.shape)
        one = self._at

        def those(part: Any) -> Any:
            levels = LEVELS.shape  # on a last axis, of what is solved for
            return jax.tree.map(lambda x: x[..., node] if np.shape(x)[-1:] == levels else x, part)

        column = those(one.column._replace(tension=None))._replace(tension=one.column.tension)
        hinge, collapse = those((one.hinge, one.collapse))
        return one._replace(column=column, hinge=hinge, collapse=collapse).force(strain)[0]

    @cached_property
    def _at(self) -> Any:
        """What depends on pressure alone, solved for at all levels."""
        return self.law.at(LEVELS * self._supply)

    @cached_property
    def _known(self) -> list[tuple[float, float, float]]:
        """All levels' pressures [Pa], free and collapse strains [-]."""
        one = self._at
        parts = (one.column.pressure, one.column.free_strain, one.collapse)
        return list(zip(*(x.tolist() for x in parts), strict=True))

    @cached_property
    def _ends(self) -> tuple[Often, Often]:
        """It at no and at supply pressure."""
        none, full = (self.law.at(np.float64(P)) for P in (0.0, self._supply))
        return Often(_force, none, 1), Often(_force, full, 1)


def _pull(law: Piecewise, pressure: Any, strain: Any) -> Point:
    """What the tension law alone says [N], and its slope [N]."""
    pull = law.tension.pull(pressure, strain)
    return pull.force, pull.slope


def _force(at: Pressurized, strain: Any) -> Point:
    """Force [N] and its slope [N] at a pressure."""
    return at.force(strain)


def _solved(law: Piecewise, pressure: Any, free: Any, collapse: Any, strain: Any) -> Any:
    """Force [N] where `free` and `collapse` strain [-] are known."""
    return law.at(pressure, free, collapse).force(strain)[0]


def _whole(law: Piecewise, pressure: Any, near: Any, strain: Any, collapse: Any = None) -> Point:
    """Force [N] and its slope [N] of what is `near` its free strain [-]."""
    free = finished(_vanishing, (law, pressure), near)
    return law.at(pressure, free, collapse).force(strain)


def _bowed(law: Piecewise, pressure: Any, near: Any, strain: Any) -> Point:
    """The same of what hasn't collapsed."""
    return _whole(law, pressure, near, strain, np.inf)


def _vanishing(theta: tuple, strain: Any) -> Point:
    """What vanishes at the free strain [N], and its slope [N]."""
    law, pressure = theta
    return _pull(law, pressure, strain)
