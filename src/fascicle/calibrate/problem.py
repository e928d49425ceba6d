r"""The least-squares problem: what the data and what is known beforehand say of a muscle.

Coordinates $z$ give a muscle and its forces $\mu$. A measured force $F$, the mean of $n$
readings that scatter by $\sigma$, leaves the residual

$$r = \sqrt{n}\, \frac{F - \mu}{\sigma}, \tag{C1}$$

a censored one, which only says that the force was not above zero,

$$r = \sqrt{-2 \ln \Phi(-\mu/\sigma)}, \tag{C2}$$

so that half the sum of squares is the negative logarithm of the likelihood: nothing where
the model pushes, and as much as any other deviation where it pulls. Each coordinate's
prior adds $(z - z_0)/\tau$.

**Source:** Tobin (1958) for censored regression.
"""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jax.scipy.special import log_ndtr
from jaxtyping import Array, Float

from .._math import guarded
from ..muscle import Muscle
from .grid import Grid, Table
from .parameters import Parameter, put
from .readings import tables


LOSSES = ("linear", "soft_l1", "cauchy")
_SURE = 30.0  # deviations below zero, where a censored reading says nothing in float64

Vector = Float[Array, "parameter"]


class Problem(eqx.Module):
    """Data, a muscle to begin with, and which of its constants are free.

    - `weight`: of each reading's residual [-]; 0 leaves it out.
    - `noise`: $\\sigma$ [N] of one reading.
    - `center`, `deviation`: of the prior on each coordinate [-].
    - `rest_length`: that the data's strains refer to [m]; `None`: the muscle's own.
    - `curves`: coefficients of the readings' smooth curves [-], [N], that give $C_1$, $C_2$;
      `None` where the muscle's own tuning holds.
    """

    muscle: Muscle
    data: Grid
    weight: Table
    noise: Float[Array, ""]
    center: Vector
    deviation: Vector
    rest_length: Float[Array, ""] | None
    curves: Float[Array, "coefficient"] | None
    parameters: tuple[Parameter, ...] = eqx.field(static=True)
    loss: str = eqx.field(static=True, default="linear")

    def muscle_at(self, coordinates: Vector) -> Muscle:
        """The muscle [-] at these `coordinates` [-]."""
        muscle = put(self.parameters, self.muscle, coordinates)
        if self.curves is None:
            return muscle
        P = self.data.pressure[:, 0]
        c1, c2 = tables(muscle, self.curves, P)
        seen = muscle.tuning.effective_pressure(P)
        return eqx.tree_at(
            lambda m: (m.tuning.pressures, m.tuning.c1, m.tuning.c2), muscle, (seen, c1, c2)
        )

    def strain(self, muscle: Muscle) -> Table:
        """The data's strains [-] as contractions of `muscle` [-], which may be shorter than
        the length they were measured on.
        """
        if self.rest_length is None:
            return self.data.strain
        return self.data.strain * (self.rest_length / muscle.length)

    def force(self, coordinates: Vector) -> Table:
        """The model's forces [N] at the readings' places."""
        muscle = self.muscle_at(coordinates)
        return muscle.force(self.data.pressure, self.strain(muscle))

    def misfits_of(self, force: Table) -> Table:
        """Residuals of the readings [-], (C1) and (C2), at a model's `force` [N]; no loss."""
        data, scaled = self.data, jnp.sqrt(self.data.count) / self.noise
        not_above = jnp.sqrt(-2 * log_ndtr(jnp.minimum(-force * scaled, _SURE)))
        missed = (data.force - force) * scaled
        return self.weight * jnp.where(data.censored, not_above, missed)

    def residuals_of(self, force: Table, coordinates: Vector) -> Float[Array, "residual"]:
        """All residuals [-]: the readings' under the loss, then the priors'."""
        r = _LOSS[self.loss](self.misfits_of(force))
        prior = (coordinates - self.center) / self.deviation
        return jnp.concatenate([r.reshape(-1), prior])

    def residuals(self, coordinates: Vector) -> Float[Array, "residual"]:
        """All residuals [-] at these `coordinates` [-]."""
        return self.residuals_of(self.force(coordinates), coordinates)


def _soft(r: Table) -> Table:
    # of two forms of 2 (sqrt(1 + r²) - 1), the one without cancellation
    return r * jnp.sqrt(2 / (jnp.sqrt(1 + r**2) + 1))


def _cauchy(r: Table) -> Table:
    some = r**2 > 1e-12
    square = guarded(some, r**2)
    return jnp.where(some, r * jnp.sqrt(jnp.log1p(square) / square), r)


_LOSS: dict[str, Any] = {"linear": lambda r: r, "soft_l1": _soft, "cauchy": _cauchy}
