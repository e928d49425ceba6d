r"""Force curves over the throttled pressure: what a recruitment state can change.

In a recruitment state some units are at no pressure, some at the supply's, and the rest
share one throttled pressure $p$. Over the level $u = p/P_s$, at one strain, the rest give

$$G_k(u, \varepsilon) = \sum_j w_{kj} F_j(u P_s, \varepsilon), \tag{B8}$$

with $w_{kj}$ muscles of kind $j$ in state $k$. Each unlike muscle is evaluated once for all
the states and units that have it.
"""

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Batch
from ..muscle import Muscle
from .alike import stacked
from .plates import muscle_strain


Lanes = Float[Array, " lane"]
Shares = Float[Array, "state muscle"]


class Like(eqx.Module):
    """Muscles of the same laws, stacked on a first axis, with $L/L_i$ [-] where unlike."""

    muscles: Muscle
    ratios: Batch | None

    def __len__(self) -> int:
        return self.muscles.length.shape[0]

    def each(self, function: Callable[[Muscle, Batch], Any], strain: Batch) -> Any:
        """`function` of every muscle and its own strain [-], muscles on a new first axis."""
        if len(self) == 1:  # no batching where there is nothing to batch
            alone = _own(function, _one(self, 0), strain)
            return jax.tree.map(lambda leaf: leaf[None], alone)
        return jax.vmap(lambda own: _own(function, own, strain))((self.muscles, self.ratios))

    def picked(
        self, function: Callable[[Muscle, Lanes, Lanes], Lanes], place: Array, *lanes: Lanes
    ) -> Lanes:
        """`function` of the muscle at each lane's `place`, its own strain [-] last in `lanes`."""

        def one(place: Array | int, level: Batch, strain: Batch) -> Batch:
            return _own(lambda muscle, eps: function(muscle, level, eps), _one(self, place), strain)

        return one(0, *lanes) if len(self) == 1 else jax.vmap(one)(place, *lanes)


class Bank(eqx.Module):
    """A bundle's unlike muscles in stacks, and how many of them [-] each state has:
    `throttled`, at `no` pressure and at `full` supply pressure $P_s$ [Pa].
    """

    stacks: tuple[Like, ...]
    throttled: Shares
    no: Shares
    full: Shares
    supply: Batch
    members: tuple[tuple[int, ...], ...] = eqx.field(static=True)  # columns that a state throttles
    resistance: bool = eqx.field(static=True)

    def forces(self, level: Batch, strain: Batch) -> Batch:
        """Force [N] of one muscle of each kind at `level` [-] and `strain` [-], kinds first."""

        def one(muscle: Muscle, eps: Batch) -> Batch:
            return self._force(muscle, level, eps)

        return jnp.concatenate([stack.each(one, strain) for stack in self.stacks])

    def table(
        self, levels: Float[Array, " node"], strain: Float[Array, "demand 1"]
    ) -> tuple[Array, Array, Array]:
        """`forces` [N] over `levels` [-], those at its two ends, and their slope in strain [N]."""

        def one(muscle: Muscle, eps: Array) -> tuple[Array, Array, Array]:
            at = muscle._law().at(levels * self.supply)
            less = jax.eval_shape(lambda: muscle._law().at(levels[:2] * self.supply))
            # what depends on pressure is known at the ends, and needn't be solved for again
            ends = jax.tree.map(
                lambda leaf, few: leaf if leaf.shape == few.shape else leaf[np.array([0, -1])],
                at,
                less,
            )
            force, slope = jax.jvp(
                lambda e: self._kept(ends.response(e).force), (eps,), (jnp.ones_like(eps),)
            )
            return self._kept(at.response(eps).force), force, slope

        parts = [stack.each(one, strain) for stack in self.stacks]
        whole, ends, slopes = (jnp.concatenate(rows) for rows in zip(*parts, strict=True))
        return whole, ends, slopes

    def curves(self, table: Float[Array, "muscle *points"]) -> Float[Array, "state *points"]:
        """Equation (B8) for every state [N], from the muscles' forces."""
        return jnp.stack(
            [
                sum(self.throttled[k, j] * table[j] for j in columns)
                for k, columns in enumerate(self.members)
            ]
        )

    def held(self, ends: Float[Array, "muscle *points two"]) -> Float[Array, "state *points"]:
        """Force [N] of the units a state doesn't throttle, from those at no and full pressure."""
        none, full = ends[..., 0], ends[..., 1]
        return jnp.tensordot(self.no, none, axes=1) + jnp.tensordot(self.full, full, axes=1)

    def curve(self, state: Int[Array, " lane"], level: Lanes, strain: Lanes) -> Lanes:
        """Equation (B8) [N] for one `state` at each `level` [-] and `strain` [-]."""
        if any(len(columns) > 1 for columns in self.members):
            return jnp.sum(self.throttled[state].T * self.forces(level, strain), axis=0)
        columns = np.array(self.members)[:, 0]
        total, first = jnp.zeros(()), 0
        for stack in self.stacks:
            place = np.clip(columns - first, 0, len(stack) - 1)
            share = jnp.sum(self.throttled[:, first : first + len(stack)], axis=1)
            force = stack.picked(self._force, jnp.asarray(place)[state], level, strain)
            total = total + share[state] * force
            first += len(stack)
        return total

    def force(self, state: Int[Array, " lane"], level: Lanes, strain: Lanes) -> Lanes:
        """Force [N] of the whole bundle in a `state` at `level` [-] and `strain` [-]."""
        ends = self.forces(jnp.arange(2.0), strain[:, None])
        held = jnp.take_along_axis(self.held(ends), state[None], axis=0)[0]
        return self.curve(state, level, strain) + held

    def _force(self, muscle: Muscle, level: Batch, strain: Batch) -> Batch:
        return self._kept(muscle._law().at(level * self.supply).response(strain).force)

    def _kept(self, force: Batch) -> Batch:
        return force if self.resistance else jnp.where(force > 0, force, 0.0)


def bank(
    muscles: Sequence[Muscle],
    counts: Sequence[Array],
    places: Sequence[int],
    length: Batch | None,
    supply: Batch,
    scheme: str,
    resistance: bool,
) -> Bank:
    """The bank of a bundle whose units have `counts` of the `muscles` at `places`; `length`:
    between its plates [m], where that isn't the muscles' own; `supply` $P_s$ [Pa].
    """
    groups = stacked(muscles)
    stacks = [Like(one, None if length is None else length / one.length) for _, one in groups]
    order = [i for row, _ in groups for i in row]
    column = [order.index(place) for place in places]

    unit, state = np.arange(len(places)), np.arange(len(places))[:, None]
    active = unit <= state if scheme == "batch" else unit == state
    full = np.zeros_like(active) if scheme == "batch" else unit < state
    kinds = jnp.eye(len(order))[np.array(column)] * jnp.stack(counts)[:, None]
    throttled, no, full = (jnp.asarray(x) @ kinds for x in (active, unit > state, full))
    members = tuple(tuple(sorted({column[i] for i in np.flatnonzero(row)})) for row in active)
    return Bank(tuple(stacks), throttled, no, full, supply, members, resistance)


def _one(stack: Like, place: Array | int) -> tuple[Muscle, Batch | None]:
    return jax.tree.map(lambda leaf: leaf[place], (stack.muscles, stack.ratios))


def _own(function: Callable, own: tuple[Muscle, Batch | None], strain: Batch) -> Any:
    """`function` of a muscle and its own strain [-] at the bundle's."""
    muscle, ratio = own
    return function(muscle, strain if ratio is None else muscle_strain(ratio, strain))
