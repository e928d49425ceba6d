"""One design whose units are unlike, its whole force law looked at at every level of pressure.

What its curves tell needs all of them; and what is differentiated, or done for many draws at
once, can't choose by its numbers what to look at.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ..bundle.schemes import Orderly
from ..bundle.states import States, common, states_of
from ..core.types import Float, Numbers, Whole
from .designs import Rows
from .outcome import Demand, existing, states_for
from .reversal import first_push, share
from .tables import Resolution, Table, sizes_at


class Looked(NamedTuple):
    """The units' `table`, the largest force of each state at the task's points, `high` [N], and
    the least, `low`, where gaps are between states; where asked for the `depth` of reversal [-] and
    the `overlap` [N].
    """

    table: Table
    low: Numbers | None
    high: Numbers
    depth: Numbers | None
    overlap: Numbers | None


def at_every_level(
    rows: Rows, n: Whole, demand: Demand, needs: tuple[str, ...], resolution: Resolution
) -> Looked:
    """What a design's units do at every level.

    **Arguments:**

    - `rows`: a muscle of each unit [-].
    - `n`: muscles in each [-].
    - `demand`: the task's [-].
    - `needs`: "size", "curves", both or nothing [-].
    - `resolution`: of levels and strains [-].

    **Returns:** it, JAX's [-].
    """
    muscle, there = rows.muscle, n > 0
    states = states_for(demand.scheme, len(n))
    pressure = jnp.asarray(resolution.level)[:, None, None] * demand.supply
    at = muscle.law.at(pressure + 0.0 * rows.length)
    top = jnp.max(jnp.where(there, at.column.free_strain[-1, 0], 0.0))
    demanded = jnp.asarray(demand.strain(rows.length[0]))
    strain, count = demanded, demanded.size
    if "curves" in needs:
        strain = jnp.concatenate([strain, top * jnp.linspace(0.0, 1.0, resolution.strains)])
    # one call for all strains, so that the law is compiled once
    force = jnp.moveaxis(at.force(strain[:, None])[0], -1, 0)
    points, curves = force[..., :count], force[..., count:]
    radius = bulge = depth = overlap = None
    if "size" in needs:
        # what depends on pressure has a row for each level, the first at none
        levels = (resolution.levels, 1)
        unfed = jax.tree.map(lambda x: x[0, 0] if jnp.shape(x)[:2] == levels else x, at)
        radius, bulge = sizes_at(muscle, unfed, jnp.max(demanded) + 0.0 * rows.length)
    if "curves" in needs:
        depth = _depth(n, curves, top, states)
        overlap = _overlap(_edges(n, curves, states), existing(demand.scheme, there))
    table = Table(
        unfed=points[:, 0].T,
        full=points[:, -1].T,
        largest=jnp.max(points, axis=1).T,
        volume=muscle.braid.volume(demanded[:, None]) - muscle.braid.volume(0.0 * rows.length),
        blocked=at.law.tension.force(demand.supply, 0.0 * rows.length),
        length=rows.length,
        radius=radius,
        bulge=bulge,
    )
    low, high = _edges(n, points, states)
    return Looked(table, None if states.joined else low, high, depth, overlap)


def _units_last(n: Array, force: Float[Array, "unit level point"]) -> tuple[Array, Array, Array]:
    """Force of each unit [N] at every level, and at no and at full pressure."""
    every = jnp.moveaxis(n[:, None, None] * force, 0, -1)
    return every, every[0], every[-1]


def _edges(n: Array, force: Array, states: States) -> tuple[Array, Array]:
    """Least and largest force [N] of every state."""
    return states.edges(*_units_last(n, force))


def _depth(
    n: Array, curves: Float[Array, "unit level strain"], top: Array, states: States
) -> Array:
    """Unit after unit in the order of recruitment, whatever pressures a state shares."""
    n, curves = n[states.order], curves[states.order]
    force = states_of(Orderly(), n.size).sums(*_units_last(n, curves))
    zeros = first_zeros(force, top)
    falls = zeros[:, 0] - jnp.min(zeros, axis=1)
    later = (jnp.arange(n.size) > 0) & (n > 0)
    return jnp.max(jnp.where(later, falls, 0.0))


def _overlap(edges: tuple[Array, Array], there: Array) -> Array:
    """Of each state with the next that is `there` [-]; `edges` [N]."""
    low, high = edges
    bottom, top = common((low[:-1], high[:-1]), (low[1:], high[1:]))
    height = jnp.max(top - bottom, axis=-1, initial=0.0)
    return jnp.max(jnp.where(there[1:], height, 0.0), initial=0.0)


def first_zeros(force: Float[Array, "*any strain"], top: Float[Array, ""]) -> Float[Array, "*any"]:
    """First strain [-] at which a force [N] over even strains to `top` [-] vanishes.

    Linear between strains; `top` where it doesn't vanish before.
    """
    j = first_push(force)
    left, right = (jnp.take_along_axis(force, j[..., None] + i, axis=-1)[..., 0] for i in (-1, 0))
    return top * (j - 1 + share(left, right)) / (force.shape[-1] - 1)
