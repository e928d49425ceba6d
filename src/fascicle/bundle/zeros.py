r"""Zeros of a bundle's force in strain: the first one, and all of them.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain,
onset of buckling, collapse). Every zero lies between the smallest and the largest free
strain of its units: below, all pull; above, all push. So the stretches between kinks are
cut into cells, each cell is cut again at the extremum of the cubic through its ends'
values and slopes, and a zero is refined wherever the sign changes. A pair of zeros that is
missed lies in a dip shallower than that cubic's error, of fourth order in the cell.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._math import root
from .._types import Batch


_CELLS = 8  # in each stretch between kinks
_INSET = 1e-7  # of a cell, to stay on one side of a kink when taking a slope

Force = Callable[[Batch], Batch]
Kinks = Float[Array, "kind unit"]
Scalar = Float[Array, ""]


def first_zero(force: Force, kinks: Kinks) -> Scalar:
    """Smallest strain [-] at which `force(strain)` [N] vanishes.

    `kinks` [-] has the units on its last axis; its first row is their free strains.
    """
    grid, pulls, wide = _refined(force, kinks)
    after = jnp.argmax(~pulls)  # the last always pushes
    low, high = grid[after - 1], grid[after]
    strain = root(force, low, high, start=0.5 * (low + high))
    return jnp.where(wide, strain, jnp.min(kinks[0]))


def crossings(
    force: Force, kinks: Kinks, most: int
) -> tuple[Float[Array, " most"], Bool[Array, " most"], Int[Array, ""]]:
    """Strains [-] of zero force, whether stable, and how many; NaN-padded to `most`."""
    grid, pulls, wide = _refined(force, kinks)
    changes = pulls[:-1] != pulls[1:]
    (at,) = jnp.nonzero(changes, size=most, fill_value=0)
    real = jnp.arange(most) < jnp.sum(changes)
    low, high, falling = grid[at], grid[at + 1], pulls[at]
    # `root` wants a residual that falls: where the force rises, its negative
    sign = jnp.where(falling, 1.0, -1.0)
    strain = root(lambda eps: sign * force(eps), low, high, start=0.5 * (low + high))
    # equal units vanish together, at the one strain there is
    single = jnp.arange(most) == 0
    strain = jnp.where(
        wide, jnp.where(real, strain, jnp.nan), jnp.where(single, jnp.min(kinks[0]), jnp.nan)
    )
    count = jnp.where(wide, jnp.sum(changes), 1)
    return strain, jnp.where(wide, real & falling, single), count


def _refined(
    force: Force, kinks: Kinks
) -> tuple[Float[Array, " grid"], Bool[Array, " grid"], Bool[Array, ""]]:
    """A rising grid of strains, whether the force pulls there, and whether it has width."""
    low, high = jnp.min(kinks[0]), jnp.max(kinks[0])
    ends = jax.lax.stop_gradient(jnp.sort(jnp.clip(kinks, low, high).reshape(-1)))
    share = jnp.arange(_CELLS) / _CELLS
    grid = (ends[:-1, None] + jnp.diff(ends)[:, None] * share).reshape(-1)
    grid = jnp.append(grid, ends[-1])

    a, b = grid[:-1], grid[1:]
    inset = _INSET * (b - a)
    sides = jnp.stack([a + inset, b - inset])
    value, slope = jax.jvp(force, (sides,), (jnp.ones_like(sides),))
    cut = a + (b - a) * _extremum(*value, *(slope * (b - a)))

    full = jnp.append(jnp.stack([a, cut], axis=-1).reshape(-1), grid[-1])
    pulls = force(full) > 0
    # by definition of the range; rounding may say otherwise at its very ends
    pulls = pulls.at[0].set(True).at[-1].set(False)
    return full, pulls, high - low > 1e-13


def _extremum(left: Batch, right: Batch, left_slope: Batch, right_slope: Batch) -> Batch:
    """Where in (0, 1) the cubic of these values and slopes turns; the middle if nowhere."""
    c3 = 2 * (left - right) + left_slope + right_slope
    c2 = 3 * (right - left) - 2 * left_slope - right_slope
    # 3 c3 t² + 2 c2 t + left_slope = 0, by the form that doesn't cancel
    inside = jnp.sqrt(jnp.maximum(c2**2 - 3 * c3 * left_slope, 0.0))
    q = -(c2 + jnp.where(c2 < 0, -inside, inside))
    t1 = q / jnp.where(c3 == 0, jnp.inf, 3 * c3)
    t2 = left_slope / jnp.where(q == 0, jnp.inf, q)
    good1, good2 = (t1 > 0) & (t1 < 1), (t2 > 0) & (t2 < 1)
    return jnp.where(good1, t1, jnp.where(good2, t2, 0.5))
