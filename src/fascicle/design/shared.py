r"""Designs that are compositions of one muscle: its forces are shared, a design costs a few sums.

With $a$ muscles at full supply, $n$ throttled and $r$ unfed, all alike, the force is

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon), \tag{G2}$$

so a state's edges follow from four numbers at each strain: $F_{full}$, $F_{none}$ and the least
and the largest $F$ over $p$. The depth of reversal depends on $(a, n)$ alone, the overlap of
two successive states on $(a, n, n')$: both are tabulated once for all compositions.
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float, Int

from ..muscle import Muscle
from .objectives import judged
from .outcome import Demand, Outcome, visited
from .packing import bowed_diameter
from .table import SHARED, Resolution, Table, at_levels, first_zeros, tabulated


class Prepared(eqx.Module):
    """A muscle's `table`, how many `muscles` [-] a design has of it; `low` and `high` [N] over
    the levels at each point, and where asked for `depth` [-] by $(a, n)$ and `overlap` [N] by
    $(a, n, n')$.
    """

    table: Table
    muscles: Int[Array, ""]
    low: Float[Array, " point"]
    high: Float[Array, " point"]
    depth: Float[Array, "a n"] | None
    overlap: Float[Array, "a n after"] | None


@partial(jax.jit, static_argnames=("most", "needs", "resolution"))
def prepared(
    muscle: Muscle,
    muscles: Int[Array, ""] | int,
    demand: Demand,
    *,
    most: int,
    needs: tuple[str, ...],
    resolution: Resolution = SHARED,
) -> Prepared:
    """What all compositions of one muscle share.

    **Arguments:**

    - `muscle`: the one [-].
    - `muscles`: how many of it a design has [-], at most `most`.
    - `demand`: the task's [-].
    - `most`: size of the tables [-].
    - `needs`: "size", "curves", both or nothing [-].
    - `resolution`: of levels and strains [-].

    **Returns:** what is shared [-].
    """
    at = at_levels(muscle, demand.supply, resolution)
    top = at.column.free_strain[-1, 0]
    table = tabulated(muscle, at, top, demand, resolution, needs)
    depth = overlap = None
    N = jnp.asarray(muscles)
    if table.curves is not None:
        depth = _depths(table.curves, top, N, most)
        overlap = _overlaps(table.curves, N, most, demand.scheme)
    low, high = jnp.min(table.force, axis=0), jnp.max(table.force, axis=0)
    return Prepared(table, N, low, high, depth, overlap)


@partial(jax.jit, static_argnames="names")
def shared_objectives(
    known: Prepared, counts: Int[Array, "design unit"], demand: Demand, *, names: tuple[str, ...]
) -> Float[Array, "objective design"]:
    """Objectives of compositions of one muscle.

    **Arguments:**

    - `known`: what they share [-].
    - `counts`: muscles in each unit [-], zeros last.
    - `demand`: the task's [-].
    - `names`: of the objectives [-].

    **Returns:** them, a row for each name, in its unit [SI].
    """
    return judged(shared_outcome(known, counts, demand), names)


def shared_outcome(known: Prepared, counts: Int[Array, "design unit"], demand: Demand) -> Outcome:
    """What compositions of one muscle do; arguments as of `shared_objectives` [-]."""
    n = counts.T
    fed = jnp.cumsum(n, axis=0)
    table, N = known.table, known.muscles
    a = fed - n if demand.scheme == "orderly" else jnp.zeros_like(n)
    throttled = n if demand.scheme == "orderly" else fed
    full, none = table.force[-1][:, None], table.force[0][:, None]
    held = [a[k] * full + (N - fed[k]) * none for k in range(n.shape[0])]
    # not stacked: states are looked at in turn, and needn't be written to memory
    low = [x + w * known.low[:, None] for x, w in zip(held, throttled, strict=True)]
    high = [x + w * known.high[:, None] for x, w in zip(held, throttled, strict=True)]
    visit = visited(demand, table.length, low, high, n > 0)
    # few units: a sum over them is faster than to look the state up
    active = sum(jnp.where(visit.state >= k, n[k], 0) for k in range(n.shape[0]))
    return Outcome(
        force=demand.force[:, None],
        weight=demand.weight[:, None],
        work=demand.work(table.length)[:, None],
        reached=visit.reached,
        shortfall=visit.shortfall,
        spare=visit.spare,
        energy=demand.supply * table.volume[:, None] * active,
        blocked=n * table.blocked,
        units=jnp.sum(n > 0, axis=0),
        size=_size(table, counts),
        depth=_deepest(known.depth, fed - n, n),
        overlap=_widest(known.overlap, fed - n, n),
    )


def _size(table: Table, counts: Int[Array, "design unit"]) -> Float[Array, " design"] | None:
    if table.radius is None or table.bulge is None:
        return None
    return bowed_diameter(jnp.broadcast_to(table.radius, counts.shape), counts, table.bulge)


def _deepest(table: Array | None, a: Array, n: Array) -> Float[Array, " design"] | None:
    if table is None:
        return None
    depth = table[a, n]  # 0 for no muscles throttled, and for none before them
    return jnp.max(depth, axis=0)


def _widest(table: Array | None, a: Array, n: Array) -> Float[Array, " design"] | None:
    if table is None:
        return None
    after = jnp.concatenate([n[1:], jnp.zeros_like(n[:1])])
    return jnp.max(table[a, n, after], axis=0)


def _depths(curves: Array, top: Array, N: Array, most: int) -> Float[Array, "a n"]:
    """Fall of the free strain for each $(a, n)$; 0 where there is no such transition."""
    a, n = (np.array(x) for x in zip(*_pairs(most), strict=True))

    def one(pair: tuple[Array, Array]) -> Array:
        a, n = pair
        force = a * curves[-1] + n * curves + (N - a - n) * curves[0]
        zeros = first_zeros(force, top)
        return zeros[0] - jnp.min(zeros)

    falls = lax.map(one, (jnp.asarray(a), jnp.asarray(n)))
    falls = jnp.where(a + n <= N, falls, 0.0)
    return jnp.zeros((most + 1, most + 1)).at[a, n].set(falls)


def _overlaps(curves: Array, N: Array, most: int, scheme: str) -> Float[Array, "a n after"]:
    """Widest overlap of the states $(a, n)$ and $(a + n, n')$; 0 where there are none."""
    full, none = curves[-1], curves[0]
    least, largest = jnp.min(curves, axis=0), jnp.max(curves, axis=0)
    triples = [(a, n, m) for a, n in [(0, n) for n in range(1, most)] + _pairs(most)
               for m in range(1, most + 1 - a - n)]  # fmt: skip
    if not triples:
        return jnp.zeros((most + 1,) * 3)
    a, n, m = (np.array(x) for x in zip(*triples, strict=True))

    def edges(before: Array, own: Array) -> tuple[Array, Array]:
        if scheme == "batch":
            before, own = jnp.zeros_like(before), before + own
        held = before * full + (N - before - own) * none
        return held + own * least, held + own * largest

    def one(triple: tuple[Array, Array, Array]) -> Array:
        a, n, m = triple
        (low, high), (next_low, next_high) = edges(a, n), edges(a + n, m)
        return jnp.max(jnp.minimum(high, next_high) - jnp.maximum(jnp.maximum(low, next_low), 0.0))

    widths = lax.map(one, (jnp.asarray(a), jnp.asarray(n), jnp.asarray(m)))
    widths = jnp.where(a + n + m <= N, jnp.maximum(widths, 0.0), 0.0)
    return jnp.zeros((most + 1,) * 3).at[a, n, m].set(widths)


def _pairs(most: int) -> list[tuple[int, int]]:
    """Muscles fed and muscles throttled, at least one of each; a dummy where there are none."""
    return [(a, n) for a in range(1, most) for n in range(1, most + 1 - a)] or [(0, 0)]
