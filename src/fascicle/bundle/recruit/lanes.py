"""Curves that demands look at: one for each demand and state, less what is demanded."""

from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import library
from ...core.types import Numbers
from .curves import Bank


INSET = 1e-4  # of a stretch, whose sides are seen from inside: kinks are known to 1e-6 of a level


class Lanes(NamedTuple):
    """A curve for every demand and state: what it is to give [N], at which strain [-], in which
    `state` [-]; `each` demand has so many [-].
    """

    bank: Bank
    wanted: Numbers
    strain: Numbers
    state: Any
    each: int

    def terms(self, lane: Any, level: Numbers) -> tuple[Numbers, Numbers]:
        """How far its parts are above what is wanted [N], and their slopes by level [N]."""
        value, slope = self.bank.terms(self.state[lane], level, self.strain[lane])
        short, at_work = self._short(lane, level), library(value)
        return tuple(
            at_work.concatenate(parts, axis=-1) for parts in ((value, short), (slope, 0.0 * short))
        )

    def values(self, lane: Any, level: Numbers) -> Numbers:
        """The same without slopes, at half the cost."""
        value = self.bank.values(self.state[lane], level, self.strain[lane])
        return library(value).concatenate([value, self._short(lane, level)], axis=-1)

    def sums(self, lane: Any, level: Numbers) -> tuple[Numbers, Numbers]:
        """How far a lane is above [N] at each `level` [-], and its slope [N]."""
        at_work = library(level, self.wanted)
        return tuple(at_work.sum(x, axis=-1) for x in self.terms(lane, level))

    def above(self, lane: Any, level: Numbers) -> Numbers:
        """How far a lane is above [N] at each `level` [-]."""
        return library(level, self.wanted).sum(self.values(lane, level), axis=-1)

    def along(self, lane: Any, node: Any) -> np.ndarray:
        """The same [N] at numbered levels [-]."""
        found = self.bank.along(self.state[lane], node, self.strain[lane])
        return found - self.wanted[lane][:, None]

    def of(self, some: Any) -> "Lanes":
        """Those lanes [-], whole demands or each by itself."""
        wanted, strain, state = (x[some] for x in (self.wanted, self.strain, self.state))
        return self._replace(wanted=wanted, strain=strain, state=state)

    def ends(self) -> Numbers:
        """Levels [-] between which each lane is smooth, rising along a last axis."""
        return self.bank.ends(self.strain, self.state)

    def _short(self, lane: Any, level: Numbers) -> Numbers:
        wanted = -self.wanted[lane][:, None, None]
        return library(level, wanted).broadcast_to(wanted, (*level.shape, 1))
