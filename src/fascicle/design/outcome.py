r"""What a design does at the points of a task, in the form that every objective is made from.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives. A demanded force within is met there, in the lowest state that
covers it, which takes least fluid; else its *shortfall* is the distance to the nearest force
that any state gives. The fluid energy is (29) with all units that the state feeds; a point
that isn't met is charged as if every unit were fed.

**Resolution:** regions are taken over a fixed number of throttled pressures. Their edges are
exact where the force is linear in pressure, that is, wherever the muscle pulls.
"""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .task import Task


MET = 1e-9  # N, a shortfall that is none

Points = Float[Array, " point"]
Edges = Sequence[Array] | Array  # of every state in turn, over points and designs


class Demand(eqx.Module):
    """A task as the kernels take it: `force` [N], `strain` [-], `weight` [-], `supply` [Pa]."""

    force: Points
    strain: Points
    weight: Points
    supply: Float[Array, ""]
    scheme: str = eqx.field(static=True)

    @classmethod
    def of(cls, task: Task) -> "Demand":
        """The demand of a `task` [-]."""
        force, strain, weight = (jnp.asarray(x) for x in (task.force, task.strain, task.weight))
        return cls(force, strain, weight, jnp.asarray(task.supply_pressure), task.scheme)


class Outcome(eqx.Module):
    """What designs do, one on each place of the last axis; of a single one it is left out.

    `weight` [-] and `work` [J] of each demanded point; whether it is `reached`, by how much
    not (`shortfall` [N]), and the fluid `energy` [J] it takes. `blocked` [N]: each unit's
    force at rest and full supply; `units`: how many motor units. Where they were asked for:
    `size` [m], the envelope's diameter, `depth` [-] of reversal, `overlap` [N].
    """

    weight: Float[Array, "point *#design"]
    work: Float[Array, "point *#design"]
    reached: Bool[Array, "point *design"]
    shortfall: Float[Array, "point *design"]
    energy: Float[Array, "point *design"]
    blocked: Float[Array, "unit *design"]
    units: Int[Array, "*design"]
    size: Float[Array, "*design"] | None = None
    depth: Float[Array, "*design"] | None = None
    overlap: Float[Array, "*design"] | None = None


def visited(
    force: Points,
    low: Edges,
    high: Edges,
    there: Bool[Array, "unit *design"],
) -> tuple[
    Bool[Array, "point *design"], Float[Array, "point *design"], Int[Array, "point *design"]
]:
    """Which points are reached, their shortfall [N], and the state used, counted from 0.

    `force` [N] is demanded; states cover `low` to `high` [N] where the unit is `there`. The
    state of a point that isn't reached is the last there is.
    """
    shape = low[0].shape
    F = force.reshape(-1, *(1,) * (len(shape) - 1))
    reached = jnp.zeros(shape, bool)
    shortfall = jnp.full(shape, jnp.inf)
    state = jnp.broadcast_to(jnp.sum(there, axis=0) - 1, shape)
    # from the last state to the first, so that the lowest that covers a point has the word
    for k in reversed(range(len(low))):
        miss = jnp.maximum(jnp.maximum(low[k] - F, F - high[k]), 0.0)
        miss = jnp.where(there[k], miss, jnp.inf)
        covers = miss <= MET
        shortfall = jnp.minimum(shortfall, miss)
        state = jnp.where(covers, k, state)
        reached = reached | covers
    return reached, jnp.where(reached, 0.0, shortfall), state
