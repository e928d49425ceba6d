r"""What a design does at the points of a task, in the form that every objective is made from.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives. A demanded force within is met there, in the lowest state that
covers it, which takes least fluid; else its *shortfall* is the distance to the nearest force
that any state gives. What the largest of all states exceeds the demanded force by is *spare*.
The fluid energy is (29) with all units that the state feeds; a point
that isn't met is charged as if every unit were fed.

The least force of a state needn't be known where states are joined: unfed, a state gives no more
than an earlier one does when fed, and the first, where nothing is fed, pulls nowhere. So the lowest
state whose largest force is enough covers a force that none below it reaches. Where a scheme leaves
a gap between states it is asked for. Where units are independent, every choice of those that are
fed is a state here, and the one that takes least fluid is used.

**Resolution:** regions are taken over a fixed number of throttled pressures. Their edges are
exact where the force is linear in pressure, that is, wherever the muscle pulls.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import States, extends, states_of
from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.types import Marks, Numbers, Whole
from ..core.validation import LARGEST_STRAIN
from .task import Task


MET = 1e-9  # N, a shortfall that is none
MOST_SETS = 255  # that independent units are fed in: all of eight


class Demand(eqx.Module):
    """A task as the kernel takes it: `force` [N], `travel`, a strain [-] or `by_stroke` a length
    [m], `weight` [-], `supply` [Pa]. What it says of bundles of some `length` [m] has points on
    the first axis, and those of the length after it.
    """

    force: Numbers
    travel: Numbers
    weight: Numbers
    supply: Numbers
    scheme: AbstractScheme = eqx.field(static=True)
    by_stroke: bool = eqx.field(static=True)

    @classmethod
    def of(cls, task: Task) -> "Demand":
        """The demand of a `task` [-]."""
        travel = task.strain if task.stroke is None else task.stroke
        supply = np.float64(task.supply_pressure)
        return cls(task.force, travel, task.weight, supply, task.scheme, task.stroke is not None)

    def strain(self, length: Numbers) -> Numbers:
        """Contractions [-] of a bundle of `length` [m], no larger than the laws know."""
        travel = laid(self.travel, np.ndim(length))
        return minimum(travel / length, LARGEST_STRAIN) if self.by_stroke else travel

    def work(self, length: Numbers) -> Numbers:
        """Work [J] of each point, for a bundle of `length` [m]."""
        work = laid(self.force * self.travel, np.ndim(length))
        return work if self.by_stroke else work * length

    def can_be(self, length: Numbers) -> Marks:
        """Whether a bundle of `length` [m] can be that much shorter, whatever it pulls with."""
        travel = laid(self.travel, np.ndim(length))
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


@cache
def states_for(scheme: AbstractScheme, units: int) -> States:
    """What designs of so many units are judged in.

    **Arguments:**

    - `scheme`: of recruitment [-].
    - `units`: how many motor units designs have, or have room for [-].

    **Returns:** its states, or the sets of units that may be fed where these are independent [-].

    **Raises:** `ValueError` where there are too many.
    """
    return states_of(scheme, units).sets(most=MOST_SETS)[0]


def existing(scheme: AbstractScheme, there: Marks) -> Marks:
    """Which states designs have.

    **Arguments:**

    - `scheme`: of recruitment [-].
    - `there`: which units, and which are room alone [-], units first.

    **Returns:** a mark for each state [-], first.
    """
    at_work, units = array_namespace(there), len(there)
    states = states_for(scheme, units)
    if scheme.independent or not extends(scheme, units):
        # sets with a unit that isn't there are again those without it
        return at_work.ones((states.size, *there.shape[1:]), bool)
    numbers = [0, *(states_of(scheme, fewer).size for fewer in range(1, units + 1))]
    have = at_work.asarray(np.array(numbers))[there.sum(axis=0)]
    return np.arange(states.size).reshape((-1,) + (1,) * (there.ndim - 1)) < have


def visited(
    demand: Demand,
    length: Numbers,
    high: Sequence[Numbers] | Numbers,
    there: Marks,
    low: Sequence[Numbers] | Numbers | None = None,
    cost: Sequence[Numbers] | Numbers | None = None,
) -> Visit:
    """What happens at every point of a demand.

    **Arguments:**

    - `demand`: the task's [-].
    - `length`: of the bundles at rest [m], one or of every design.
    - `high`: largest force of each state in turn [N], points first, designs last.
    - `there`: which states there are [-], designs last.
    - `low`: their least force [N], in the same form; left out where no gap is between states.
    - `cost`: what each takes [any unit], of which the least is used; left out, the lowest state.

    **Returns:** the visit [-].
    """
    axes, at_work = np.ndim(high[0]) - 1, array_namespace(high[0])
    F, can_be = laid(demand.force, axes), laid(demand.can_be(length), axes)
    last = at_work.broadcast_to(there.sum(axis=0) - 1, high[0].shape)
    top, state, least, miss = -np.inf, last, np.inf, np.inf
    # from the last state to the first, so that the lowest that is enough has the word
    for k in reversed(range(len(high))):
        most = where(there[k], high[k], -np.inf)
        top = maximum(top, most)
        covers = F - most <= MET
        if low is not None:
            covers = covers & (low[k] - F <= MET)
            miss = minimum(miss, maximum(F - most, low[k] - F))
        if cost is not None:
            covers = covers & (cost[k] <= least)
            least = where(covers, cost[k], least)
        state = where(covers, k, state)
    miss = maximum(F - top if low is None else miss, 0.0)
    reached, state = (miss <= MET) & can_be, where(can_be, state, last)
    # where it can't be that short it is short of the force, and of what it pushes with there
    miss = where(can_be, miss, maximum(miss, F))
    spare = where(can_be, top - F, minimum(top, 0.0) - F)
    if low is not None:
        # in a gap a larger force is no help
        spare = where(reached, spare, minimum(spare, -miss))
    return Visit(reached, where(reached, 0.0, miss), spare, state)


def laid(points: Numbers | Marks, axes: int) -> Any:
    """Values of the points [any unit] with so many `axes` [-] in all after their own."""
    return points.reshape(points.shape + (1,) * (axes + 1 - points.ndim))
