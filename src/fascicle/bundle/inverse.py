r"""The inverse: the pressures that give a force at a strain.

In recruitment state $k$ one throttled pressure $p$ is free, so a demanded force $F_d$ asks
for the roots of

$$F_k(p, \varepsilon) = F_d, \qquad 0 \le p \le P_s, \quad k = 1 \dots n. \tag{B9}$$

There may be several, in one state and in several: past its free strain a muscle resists
more at a low pressure than at none, so that the force falls with pressure before it rises.
`levels` finds them all; here the states are set up, and one solution is chosen.

*Efficiency.* The fluid energy (29), $P_s \sum n_i (V_i(\varepsilon) - V_i(0))$ over the
active units, doesn't depend on the throttled pressure, and the active units of a state are
among those of the next. While a muscle's volume grows with contraction the lowest state is
the cheapest; within it, the lowest pressure is taken. At $\varepsilon \le 0$, where
volumes shrink or stay, the lowest state is taken as well, for want of an order.

*Derivatives.* The pressure chosen is a root of (B9) and has its implicit derivative, where
it moves smoothly: not where two solutions meet, and not where the choice changes.
"""

from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .._types import Batch, IntBatch, PerUnit
from ..muscle import Muscle
from .curves import Bank, bank
from .levels import solve


REACHED, ABOVE, BELOW = 0, 1, 2

Demands = Float[Array, " demand"]
States = Int[Array, " demand"]


class Solutions(eqx.Module):
    """All solutions on the last axis, by state and pressure: the throttled `pressure` [Pa],
    the `state`, whether `stable`; NaN, 0 and False where there are fewer. No derivatives.
    """

    pressure: Float[Array, "*points solution"]
    state: Int[Array, "*points solution"]
    stable: Bool[Array, "*points solution"]


class Recruited(eqx.Module):
    """What to do for a demanded force. `pressures` [Pa], units on the last axis; `state`,
    counted from 1; `force` [N] that they give; `status`: 0 reached, 1 the demanded force is
    above what is reachable there, 2 below: then all this is the nearest reachable force's.
    `stable`: the force falls with strain at these pressures. `solutions`, and their `count`.
    """

    pressures: PerUnit
    state: Int[Array, "*points"]
    force: Float[Array, "*points"]
    status: Int[Array, "*points"]
    stable: Bool[Array, "*points"]
    solutions: Solutions
    count: Int[Array, "*points"]


@partial(jax.jit, static_argnames=("places", "scheme", "resistance"))
def recruited(
    muscles: tuple[Muscle, ...],
    counts: tuple[IntBatch, ...],
    length: Batch | None,
    supply: Batch,
    force: Batch,
    strain: Batch,
    present: PerUnit | None,
    *,
    places: tuple[int, ...],
    scheme: str,
    resistance: bool,
) -> Recruited:
    """Equation (B9) solved.

    `muscles` are the unlike ones, `places` which of them each unit has, `length` the plates'
    distance [m] where unlike; `force` [N], `strain` [-], `supply` and `present` [Pa].
    """
    one = () if present is None else present.shape[:-1]
    shape = jnp.broadcast_shapes(force.shape, strain.shape, one)
    force, strain = (jnp.broadcast_to(x, shape).reshape(-1) for x in (force, strain))
    if present is not None:
        units = present.shape[-1]
        present = jnp.broadcast_to(present, (*shape, units)).reshape(-1, units)
    live = bank(muscles, counts, places, length, supply, scheme, resistance)
    fixed, f, eps = lax.stop_gradient((live, force, strain))
    found = solve(fixed, f, eps)
    units, met = len(places), found.met
    reached = jnp.any(met, axis=1)

    cost = jnp.where(met, jnp.arange(met.shape[1]), jnp.inf)  # they are in this order already
    if present is not None:
        every = _pressures(found.state, found.level, fixed.supply, units, scheme)
        apart = jnp.sum((every - lax.stop_gradient(present)[:, None]) ** 2, axis=-1)
        cost = jnp.where(met, apart, jnp.inf)
    taken = jnp.argmin(jnp.where(reached[:, None], cost, jnp.abs(found.miss)), axis=1)
    state, level, miss, falls = (
        jnp.take_along_axis(x, taken[:, None], axis=1)[:, 0]
        for x in (found.state, found.level, found.miss, found.falls)
    )
    level, there = _implicit(live, force, strain, state, reached, level, f + miss)
    answer = Recruited(
        pressures=_pressures(state, level, supply, units, scheme),
        state=state + 1,
        force=there,
        status=jnp.where(reached, REACHED, jnp.where(miss < 0, ABOVE, BELOW)),
        stable=falls < 0,
        solutions=Solutions(
            pressure=jnp.where(met, found.level * fixed.supply, jnp.nan),
            state=jnp.where(met, found.state + 1, 0),
            stable=met & (found.falls < 0),
        ),
        count=jnp.sum(met, axis=1) + found.lost,
    )
    return jax.tree.map(lambda leaf: leaf.reshape(*shape, *leaf.shape[1:]), answer)


@jax.custom_jvp
def _implicit(
    live: Bank,  # noqa: ARG001 what the derivatives are of
    force: Demands,  # noqa: ARG001
    strain: Demands,  # noqa: ARG001
    state: States,  # noqa: ARG001
    reached: Bool[Array, " demand"],  # noqa: ARG001
    level: Demands,
    there: Demands,
) -> tuple[Demands, Demands]:
    """The `level` [-] found and the force [N] `there`, given their derivatives."""
    return level, there


@_implicit.defjvp
def _(primals: tuple, tangents: tuple) -> tuple:
    live, _, strain, state, reached, *_ = primals
    d_live, d_force, d_strain, *_ = tangents
    level, there = _implicit(*primals)
    zero = jax.tree.map(jnp.zeros_like, d_live)

    def change(live_too: Any, strain_too: Demands, level_too: Demands) -> Demands:
        return jax.jvp(
            lambda b, e, u: b.force(state, u, e),
            (live, strain, level),
            (live_too, strain_too, level_too),
        )[1]

    moved = change(d_live, d_strain, jnp.zeros_like(level))
    slope = change(zero, jnp.zeros_like(level), jnp.ones_like(level))
    rise = (d_force - moved) / jnp.where(slope == 0, jnp.inf, slope)
    return (level, there), (jnp.where(reached, rise, 0.0), jnp.where(reached, d_force, moved))


def _pressures(
    state: Int[Array, "*points"], level: Batch, supply: Batch, units: int, scheme: str
) -> PerUnit:
    """Pressures [Pa] of all units, on a new last axis; `state` counts from 0."""
    unit, state, P = jnp.arange(units), state[..., None], level[..., None] * supply
    if scheme == "batch":
        return jnp.where(unit <= state, P, 0.0)
    return jnp.where(unit < state, supply, jnp.where(unit == state, P, 0.0))
