r"""Designs that differ in everything: every motor unit has a muscle of its own.

Each unit's table is made for its own sizes; states add them up as in (B1). The cost of a
design is that of the force law at all its units' levels and strains: nothing is shared.
"""

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float, Int

from ..muscle import Muscle
from .objectives import judged
from .outcome import Demand, Outcome, visited
from .packing import bowed_diameter
from .table import UNLIKE, Resolution, at_levels, first_zeros, tabulated


_POINTS = 2**16  # forces worked on at once: what stays in cache


class Sizes(NamedTuple):
    """Designs as arrays: `counts` [-] and `radius` [m], `wall` [m] and `angle` [rad] of the
    muscles of each unit, their `length` [m]. Padded units have no muscles, and sizes that exist.
    """

    counts: Int[Array, "*design unit"]
    length: Float[Array, "*design"]
    radius: Float[Array, "*design unit"]
    wall: Float[Array, "*design unit"]
    angle: Float[Array, "*design unit"]


def sized(drawing: Muscle, length: Array, radius: Array, wall: Array, angle: Array) -> Muscle:
    """A muscle of other sizes.

    **Arguments:**

    - `drawing`: whose material, laws and tuning it has [-].
    - `length`: between the end fittings [m].
    - `radius`: of the bladder at rest [m].
    - `wall`: its thickness at rest [m].
    - `angle`: of the braid at rest [rad].

    **Returns:** the muscle [-].
    """
    return eqx.tree_at(
        lambda m: (m.length, m.outer_radius, m.wall_thickness, m.braid_angle),
        drawing,
        (length, radius, wall, angle),
    )


@partial(jax.jit, static_argnames=("names", "needs", "resolution"))
def unlike_objectives(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    *,
    names: tuple[str, ...],
    needs: tuple[str, ...],
    resolution: Resolution = UNLIKE,
) -> Float[Array, "objective design"]:
    """Objectives of designs that differ in everything.

    **Arguments:**

    - `drawing`: whose material, laws and tuning all muscles have [-].
    - `sizes`: of the designs, on the first axis [-].
    - `demand`: the task's [-].
    - `names`: of the objectives [-].
    - `needs`: what these need beyond the task's points [-].
    - `resolution`: of levels and strains [-].

    **Returns:** them, a row for each name, in its unit [SI].
    """
    units = sizes.counts.shape[-1]
    strains = demand.travel.size + ("curves" in needs) * resolution.strains
    block = max(1, _POINTS // (units * resolution.levels * strains))

    def one(sizes: Sizes) -> Float[Array, " objective"]:
        return judged(unlike_outcome(drawing, sizes, demand, needs, resolution), names)

    return lax.map(one, sizes, batch_size=min(block, len(sizes.counts))).T


def unlike_outcome(
    drawing: Muscle,
    sizes: Sizes,
    demand: Demand,
    needs: tuple[str, ...],
    resolution: Resolution = UNLIKE,
) -> Outcome:
    """What a single design does, without the designs' axis; arguments as of
    `unlike_objectives` [-].
    """
    own = (sizes.radius, sizes.wall, sizes.angle)

    def muscle(radius: Array, wall: Array, angle: Array) -> Muscle:
        return sized(drawing, sizes.length, radius, wall, angle)

    at = jax.vmap(lambda *own: at_levels(muscle(*own), demand.supply, resolution))(*own)
    n, there = sizes.counts, sizes.counts > 0
    top = jnp.max(jnp.where(there, at.column.free_strain[:, -1, 0], 0.0))
    tables = jax.vmap(lambda at, *own: tabulated(muscle(*own), at, top, demand, resolution, needs))(
        at, *own
    )
    low, high = _edges(n, tables.force, demand.scheme)
    visit = visited(demand, sizes.length, low, high, there)
    fed = jnp.arange(n.size)[:, None] <= visit.state
    size = depth = overlap = None
    if tables.radius is not None and tables.bulge is not None:
        bulge = jnp.max(jnp.where(there, tables.bulge, 0.0))
        size = bowed_diameter(tables.radius, n, bulge)
    if tables.curves is not None:
        depth = _depth(n, tables.curves, top)
        overlap = _overlap(n, tables.curves, demand.scheme)
    return Outcome(
        force=demand.force,
        weight=demand.weight,
        work=demand.work(sizes.length),
        reached=visit.reached,
        shortfall=visit.shortfall,
        spare=visit.spare,
        energy=demand.supply * jnp.sum(fed * (n[:, None] * tables.volume), axis=0),
        blocked=n * tables.blocked,
        units=jnp.sum(there),
        size=size,
        depth=depth,
        overlap=overlap,
    )


def _held(n: Array, force: Float[Array, "unit level *point"]) -> Float[Array, "unit *point"]:
    """Force [N] of the units before each one at full supply and of those after it unfed."""
    full, none = (n * force[:, row].T for row in (-1, 0))
    before = jnp.cumsum(full, axis=-1) - full
    after = jnp.sum(none, axis=-1, keepdims=True) - jnp.cumsum(none, axis=-1)
    return (before + after).T


def _edges(n: Array, force: Array, scheme: str) -> tuple[Array, Array]:
    """Least and largest force [N] of every state."""
    weighed = n[:, None, None] * force
    if scheme == "orderly":
        throttled, held = weighed, _held(n, force)
    else:
        throttled, none = jnp.cumsum(weighed, axis=0), weighed[:, 0]
        held = jnp.sum(none, axis=0) - jnp.cumsum(none, axis=0)
    return held + jnp.min(throttled, axis=1), held + jnp.max(throttled, axis=1)


def _depth(n: Array, curves: Float[Array, "unit level strain"], top: Array) -> Array:
    force = _held(n, curves)[:, None] + n[:, None, None] * curves
    zeros = first_zeros(force, top)
    falls = zeros[:, 0] - jnp.min(zeros, axis=1)
    later = (jnp.arange(n.size) > 0) & (n > 0)
    return jnp.max(jnp.where(later, falls, 0.0))


def _overlap(n: Array, curves: Float[Array, "unit level strain"], scheme: str) -> Array:
    low, high = _edges(n, curves, scheme)
    bottom = jnp.maximum(jnp.maximum(low[:-1], low[1:]), 0.0)
    height = jnp.max(jnp.minimum(high[:-1], high[1:]) - bottom, axis=-1, initial=0.0)
    return jnp.max(jnp.where(n[1:] > 0, height, 0.0), initial=0.0)
