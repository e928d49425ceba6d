r"""One muscle's forces over throttled pressure, on which everything a design does is based.

Levels $u = p/P_s$ are denser at low pressure, $u_i = (i/n)^{3/2}$, where collapse and free
strain change fastest; strains of the curves are even, from rest to the largest free strain.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..muscle import Muscle
from ..muscle.piecewise import Pressurized
from .outcome import Demand


class Resolution(eqx.Module):
    """How many throttled `levels`, and `strains` along the curves [-]."""

    levels: int = eqx.field(static=True, default=33)
    strains: int = eqx.field(static=True, default=129)

    @property
    def level(self) -> np.ndarray:
        """Levels of throttled pressure over the supply's [-], from 0 to 1."""
        return np.linspace(0.0, 1.0, self.levels) ** 1.5


SHARED = Resolution(257, 513)  # one muscle serves thousands of designs
UNLIKE = Resolution(33, 129)  # every design has muscles of its own


class Table(eqx.Module):
    """A muscle's `force` [N] at levels and the task's strains, the fluid `volume` [m³] taken
    in at these, its `blocked` force [N] and `length` [m]; where asked for its `radius` and
    `bulge` [m] at the largest strain, and `curves` [N] over levels and even strains to `top`.
    """

    force: Float[Array, "level point"]
    volume: Float[Array, " point"]
    blocked: Float[Array, ""]
    length: Float[Array, ""]
    radius: Float[Array, ""] | None
    bulge: Float[Array, ""] | None
    curves: Float[Array, "level strain"] | None


def at_levels(muscle: Muscle, supply: Array, resolution: Resolution) -> Pressurized:
    """A `muscle` [-] at every level of the `supply` [Pa], levels down; `resolution` [-]."""
    return muscle._law().at(jnp.asarray(resolution.level)[:, None] * supply)


def tabulated(
    muscle: Muscle,
    at: Pressurized,
    top: Float[Array, ""],
    demand: Demand,
    resolution: Resolution,
    needs: tuple[str, ...],
) -> Table:
    """A muscle's table.

    **Arguments:**

    - `muscle`: a single one [-].
    - `at`: the same at every level, as `at_levels` gives it [-].
    - `top`: the strain up to which curves go [-].
    - `demand`: the task's [-].
    - `resolution`: of levels and strains [-].
    - `needs`: "size", "curves", both or nothing [-].

    **Returns:** the table [-].
    """
    braid = muscle.braid
    demanded = demand.strain(muscle.length)
    strain, count = demanded, demanded.size
    if "curves" in needs:
        even = top * jnp.linspace(0.0, 1.0, resolution.strains)
        strain = jnp.concatenate([strain, even])
    # one call for all strains, so that the law is compiled once
    force = at.response(strain).force
    radius = bulge = None
    if "size" in needs:
        largest = jnp.max(demanded)
        radius = jnp.asarray(braid.radius_at(largest))
        # what depends on pressure has a row for each level, the first at none
        rows = (resolution.levels, 1)
        none = jax.tree.map(lambda leaf: leaf[0, 0] if jnp.shape(leaf) == rows else leaf, at)
        # deepest where it collapses, if it does before, else at the end
        stops = jnp.stack([largest, jnp.minimum(none.collapse, largest)])
        bulge = jnp.max(none.deflection(stops))
    return Table(
        force=force[:, :count],
        volume=braid.volume(demanded) - braid.volume(jnp.zeros(())),
        blocked=at.law.tension.force(demand.supply, jnp.zeros(())),
        length=muscle.length,
        radius=radius,
        bulge=bulge,
        curves=force[:, count:] if "curves" in needs else None,
    )


def first_zeros(force: Float[Array, "*any strain"], top: Float[Array, ""]) -> Float[Array, "*any"]:
    """First strain [-] at which a force [N] over even strains to `top` [-] vanishes.

    Linear between strains; `top` where it doesn't vanish before.
    """
    pushes = (force <= 0).at[..., 0].set(False).at[..., -1].set(True)
    j = jnp.argmax(pushes, axis=-1)
    right = jnp.take_along_axis(force, j[..., None], axis=-1)[..., 0]
    left = jnp.take_along_axis(force, j[..., None] - 1, axis=-1)[..., 0]
    # the last of all may still pull by rounding: it is the zero itself
    right = jnp.minimum(right, 0.0)
    drop = left - right
    share = jnp.where(left > 0, left / jnp.where(drop > 0, drop, 1.0), 0.0)
    return top * (j - 1 + share) / (force.shape[-1] - 1)
