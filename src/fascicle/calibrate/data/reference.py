r"""What others fit to such a record: the published empirical law of Sárosi, for comparison.

$$F = (a p + b)\, e^{c \kappa} + d p \kappa + e p + f \tag{C5}$$

with the pressure $p$ in bar and the contraction $\kappa$ in percent. Six numbers without
physics: it says nothing of another muscle, nor of anything past the free strain. Those
published are of a Festo DMSP-20-200N.

**Source:** Sárosi et al. (2015), as the six-parameter law and its constants are quoted.
"""

import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Float

from ...core.arrays import exp
from ...core.types import AnyArray
from .grid import Grid


SAROSI_DMSP_20_200N = (
    -4.00180705,
    292.4620246,
    -0.32930845,
    -9.33564098,
    294.0538256,
    -280.498151,
)
_BAR, _PERCENT = 1e5, 1e-2


def sarosi(
    constants: Float[AnyArray, "6"],
    pressure: Float[AnyArray, "*grid"],
    strain: Float[AnyArray, "*grid"],
) -> Float[AnyArray, "*grid"]:
    """Force [N] by (C5) at `pressure` [Pa] and `strain` [-], with its six `constants` [-]."""
    a, b, c, d, e, f = constants
    p, kappa = pressure / _BAR, strain / _PERCENT
    return (a * p + b) * exp(c * kappa) + d * p * kappa + e * p + f


def refitted(data: Grid, weight: Float[AnyArray, "level reading"]) -> Float[AnyArray, "6"]:
    """The six constants [-] that fit the `weight`ed [-], unclipped readings best."""
    P = np.broadcast_to(data.pressure, data.strain.shape)
    used = weight * data.uncensored * np.sqrt(data.count)
    scale = np.max(np.abs(data.force))
    first = np.asarray(SAROSI_DMSP_20_200N)

    def residuals(share: Float[AnyArray, "6"], _: None) -> Float[AnyArray, "residual"]:
        # constants of unlike size are moved in proportion to the published ones
        missed = sarosi(share * first, P, data.strain) - data.force
        return (used * missed / scale).reshape(-1)

    solver = optx.LevenbergMarquardt(rtol=1e-9, atol=1e-9)
    found = optx.least_squares(residuals, solver, jnp.ones(6), max_steps=500, throw=False)
    return found.value * first
