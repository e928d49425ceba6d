r"""What a design does at the points of a task, in the form that every objective is made from.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives. A demanded force within is met there, in the lowest state that
covers it, which takes least fluid; else its *shortfall* is the distance to the nearest force
that any state gives. What the largest of all states exceeds the demanded force by is *spare*.
The fluid energy is (29) with all units that the state feeds; a point
that isn't met is charged as if every unit were fed.

**Resolution:** regions are taken over a fixed number of throttled pressures. Their edges are
exact where the force is linear in pressure, that is, wherever the muscle pulls.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .task import LARGEST_STRAIN, Task


MET = 1e-9  # N, a shortfall that is none

Points = Float[Array, " point"]
Edges = Sequence[Array] | Array  # of every state in turn, over points and designs


class Demand(eqx.Module):
    """A task as the kernels take it: `force` [N], `travel`, a strain [-] or `by_stroke` a length
    [m], `weight` [-], `supply` [Pa].
    """

    force: Points
    travel: Points
    weight: Points
    supply: Float[Array, ""]
    scheme: str = eqx.field(static=True)
    by_stroke: bool = eqx.field(static=True)

    @classmethod
    def of(cls, task: Task) -> "Demand":
        """The demand of a `task` [-]."""
        travel = task.strain if task.stroke is None else task.stroke
        force, moved, weight = (jnp.asarray(x) for x in (task.force, travel, task.weight))
        supply = jnp.asarray(task.supply_pressure)
        return cls(force, moved, weight, supply, task.scheme, task.stroke is not None)

    def strain(self, length: Float[Array, ""]) -> Points:
        """Contractions [-] of a bundle of `length` [m], no larger than the laws know."""
        return jnp.minimum(self.travel / length, LARGEST_STRAIN) if self.by_stroke else self.travel

    def work(self, length: Float[Array, ""]) -> Points:
        """Work [J] of each point, for a bundle of `length` [m]."""
        return self.force * self.travel * (1.0 if self.by_stroke else length)

    def can_be(self, length: Float[Array, ""]) -> Bool[Array, " point"]:
        """Whether a bundle of `length` [m] can be that much shorter, whatever it pulls with."""
        if not self.by_stroke:
            return jnp.ones(self.travel.shape, bool)
        return self.travel <= LARGEST_STRAIN * length


class Outcome(eqx.Module):
    """What designs do, one on each place of the last axis; of a single one it is left out.

    `force` [N], `weight` [-] and `work` [J] of each demanded point; whether it is `reached`, by
    how much not (`shortfall` [N]), how much more could be pulled with (`spare` [N], negative
    where it isn't reached), and the fluid `energy` [J] it takes. `blocked` [N]: each unit's
    force at rest and full supply; `units`: how many motor units. Where they were asked for:
    `size` [m], the envelope's diameter, `depth` [-] of reversal, `overlap` [N].
    """

    force: Float[Array, "point *#design"]
    weight: Float[Array, "point *#design"]
    work: Float[Array, "point *#design"]
    reached: Bool[Array, "point *design"]
    shortfall: Float[Array, "point *design"]
    spare: Float[Array, "point *design"]
    energy: Float[Array, "point *design"]
    blocked: Float[Array, "unit *design"]
    units: Int[Array, "*design"]
    size: Float[Array, "*design"] | None = None
    depth: Float[Array, "*design"] | None = None
    overlap: Float[Array, "*design"] | None = None


class Visit(NamedTuple):
    """Which points are `reached`, their `shortfall` and `spare` force [N], and the `state` used,
    counted from 0; that of a point that isn't reached is the last there is.
    """

    reached: Bool[Array, "point *design"]
    shortfall: Float[Array, "point *design"]
    spare: Float[Array, "point *design"]
    state: Int[Array, "point *design"]


def visited(
    demand: Demand,
    length: Float[Array, ""],
    low: Edges,
    high: Edges,
    there: Bool[Array, "unit *design"],
) -> Visit:
    """What happens at every point of a demand.

    **Arguments:**

    - `demand`: the task's [-].
    - `length`: of the bundle at rest [m].
    - `low`: least force of each state [N], at every point.
    - `high`: the largest [N].
    - `there`: which units, and so states, there are [-].

    **Returns:** the visit [-].
    """
    shape = low[0].shape
    F, can_be = (
        x.reshape(-1, *(1,) * (len(shape) - 1)) for x in (demand.force, demand.can_be(length))
    )
    reached = jnp.zeros(shape, bool)
    shortfall, top = jnp.full(shape, jnp.inf), jnp.full(shape, -jnp.inf)
    state = jnp.broadcast_to(jnp.sum(there, axis=0) - 1, shape)
    last = state
    # from the last state to the first, so that the lowest that covers a point has the word
    for k in reversed(range(len(low))):
        miss = jnp.maximum(jnp.maximum(low[k] - F, F - high[k]), 0.0)
        miss = jnp.where(there[k], miss, jnp.inf)
        covers = miss <= MET
        shortfall = jnp.minimum(shortfall, miss)
        top = jnp.maximum(top, jnp.where(there[k], high[k], -jnp.inf))
        state = jnp.where(covers, k, state)
        reached = reached | covers
    reached, state = reached & can_be, jnp.where(can_be, state, last)
    # where it can't be that short it is short of the force, and of what it pushes with there
    miss = jnp.where(can_be, shortfall, jnp.maximum(shortfall, F))
    spare = jnp.where(can_be, top - F, jnp.minimum(top, 0.0) - F)
    return Visit(reached, jnp.where(reached, 0.0, miss), spare, state)
