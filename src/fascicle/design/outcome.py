r"""What a design does at the points of a task, in the form that every objective is made from.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives. A demanded force within is met there, in the lowest state that
covers it, which takes least fluid; else its *shortfall* is the distance to the nearest force
that any state gives. What the largest of all states exceeds the demanded force by is *spare*.
The fluid energy is (29) with all units that the state feeds; a point
that isn't met is charged as if every unit were fed.

The least force of a state needn't be known: unfed, a state gives no more than the one before
does when fed, and the first, where nothing is fed, pulls nowhere. So the lowest state whose
largest force is enough covers a force that none below it reaches.

**Resolution:** regions are taken over a fixed number of throttled pressures. Their edges are
exact where the force is linear in pressure, that is, wherever the muscle pulls.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import numpy as np

from .._arrays import library, maximum, minimum, where
from .._domain import LARGEST_STRAIN
from .._types import Marks, Numbers, Whole
from .task import Task


MET = 1e-9  # N, a shortfall that is none


class Demand(eqx.Module):
    """A task as the kernels take it: `force` [N], `travel`, a strain [-] or `by_stroke` a length
    [m], `weight` [-], `supply` [Pa]. What it says of bundles of some `length` [m] has points on
    the first axis, and those of the length after it.
    """

    force: Numbers
    travel: Numbers
    weight: Numbers
    supply: Numbers
    scheme: str = eqx.field(static=True)
    by_stroke: bool = eqx.field(static=True)

    @classmethod
    def of(cls, task: Task) -> "Demand":
        """The demand of a `task` [-]."""
        travel = task.strain if task.stroke is None else task.stroke
        supply = np.float64(task.supply_pressure)
        return cls(task.force, travel, task.weight, supply, task.scheme, task.stroke is not None)

    def strain(self, length: Numbers) -> Numbers:
        """Contractions [-] of a bundle of `length` [m], no larger than the laws know."""
        travel = _laid(self.travel, np.ndim(length))
        return minimum(travel / length, LARGEST_STRAIN) if self.by_stroke else travel

    def work(self, length: Numbers) -> Numbers:
        """Work [J] of each point, for a bundle of `length` [m]."""
        work = _laid(self.force * self.travel, np.ndim(length))
        return work if self.by_stroke else work * length

    def can_be(self, length: Numbers) -> Marks:
        """Whether a bundle of `length` [m] can be that much shorter, whatever it pulls with."""
        travel = _laid(self.travel, np.ndim(length))
        return travel <= (LARGEST_STRAIN * length if self.by_stroke else np.inf)


class Outcome(eqx.Module):
    """What designs do, one on each place of the last axis; of a single one it is left out.

    `force` [N], `weight` [-] and `work` [J] of each demanded point; whether it is `reached`, by
    how much not (`shortfall` [N]), how much more could be pulled with (`spare` [N], negative
    where it isn't reached), and the fluid `energy` [J] it takes. `blocked` [N]: each unit's
    force at rest and full supply; `units`: how many motor units. Where they were asked for:
    `size` [m], the envelope's diameter, `depth` [-] of reversal, `overlap` [N].
    """

    force: Numbers
    weight: Numbers
    work: Numbers
    reached: Marks
    shortfall: Numbers
    spare: Numbers
    energy: Numbers
    blocked: Numbers
    units: Whole
    size: Numbers | None = None
    depth: Numbers | None = None
    overlap: Numbers | None = None


class Visit(NamedTuple):
    """Which points are `reached`, their `shortfall` and `spare` force [N], and the `state` used,
    counted from 0; that of a point that isn't reached is the last there is.
    """

    reached: Marks
    shortfall: Numbers
    spare: Numbers
    state: Whole


def visited(
    demand: Demand, length: Numbers, high: Sequence[Numbers] | Numbers, there: Marks
) -> Visit:
    """What happens at every point of a demand.

    **Arguments:**

    - `demand`: the task's [-].
    - `length`: of the bundles at rest [m], one or of every design.
    - `high`: largest force of each state in turn [N], points first, designs last.
    - `there`: which units, and so states, there are [-], designs last.

    **Returns:** the visit [-].
    """
    axes, at_work = np.ndim(high[0]) - 1, library(high[0])
    F, can_be = _laid(demand.force, axes), demand.can_be(length)
    can_be = can_be.reshape(can_be.shape + (1,) * (axes + 1 - can_be.ndim))
    last = at_work.broadcast_to(there.sum(axis=0) - 1, high[0].shape)
    top, state = -np.inf, last
    # from the last state to the first, so that the lowest that is enough has the word
    for k in reversed(range(len(high))):
        most = where(there[k], high[k], -np.inf)
        top = maximum(top, most)
        state = where(F - most <= MET, k, state)
    reached, state = (F - top <= MET) & can_be, where(can_be, state, last)
    miss = maximum(F - top, 0.0)
    # where it can't be that short it is short of the force, and of what it pushes with there
    miss = where(can_be, miss, maximum(miss, F))
    spare = where(can_be, top - F, minimum(top, 0.0) - F)
    return Visit(reached, where(reached, 0.0, miss), spare, state)


def _laid(points: Numbers, axes: int) -> Numbers:
    """Values of the `points` [any unit] with so many `axes` more."""
    return points.reshape(points.shape + (1,) * axes)
