r"""What others fit to such a record: the published empirical law of Sárosi, for comparison.

$$F = (a p + b)\, e^{c \kappa} + d p \kappa + e p + f \tag{C5}$$

with the pressure $p$ in bar and the contraction $\kappa$ in percent. Six numbers without
physics: it says nothing of another muscle, nor of anything past the free strain. Those
published are of a Festo DMSP-20-200N.

**Source:** Sárosi et al. (2015), as the six-parameter law and its constants are quoted.
"""

import numpy as np
from scipy.optimize import least_squares
from scipy.special import log_ndtr

from ...core.array_namespace import exp
from ...core.types import AnyArray, Float
from .grid import Grid


SAROSI_DMSP_20_200N = (
    -4.00180705,
    292.4620246,
    -0.32930845,
    -9.33564098,
    294.0538256,
    -280.498151,
)
DIAMETER = 20e-3  # m, nominal, of the muscle that these are of
_BAR, _PERCENT = 1e5, 1e-2
_FIRST_NOISE = 0.02  # of the largest force: where the search for the noise begins
_LEAST = 1e-3  # of the noise before: without noise there is an end to it
_ROUNDS, _SETTLED = 8, 1e-3  # of the noise: what a clipped reading says follows it
_SURE = 30.0  # deviations below zero, where a clipped reading says nothing in float64


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
    """The six constants [-] that fit the `weight`ed [-] readings best, clipped ones as (C2) has
    them, with the noise that the others leave.
    """
    P = np.broadcast_to(data.pressure, np.shape(data.strain))
    strain, F = np.asarray(data.strain), np.asarray(data.force)
    scaled = np.asarray(weight) * np.sqrt(np.asarray(data.count))
    clipped, first = np.asarray(data.censored), np.asarray(SAROSI_DMSP_20_200N)
    free = max(int(np.sum((scaled > 0) & ~clipped)) - first.size, 1)
    noise, share = _FIRST_NOISE * float(np.max(np.abs(F))), np.ones(first.size)

    def residuals(share: np.ndarray) -> np.ndarray:
        # constants of unlike size are moved in proportion to the published ones
        mu = sarosi(share * first, P, strain)
        not_above = np.sqrt(-2 * log_ndtr(np.minimum(-mu / noise, _SURE)))
        return (scaled * np.where(clipped, not_above, (mu - F) / noise)).reshape(-1)

    for _ in range(_ROUNDS):
        share = least_squares(residuals, share, method="lm", xtol=1e-12, ftol=1e-12).x
        left = np.where(clipped, 0.0, scaled * (sarosi(share * first, P, strain) - F))
        before, noise = noise, max(float(np.sqrt(np.sum(left**2) / free)), _LEAST * noise)
        if not np.any(clipped & (scaled > 0)) or abs(noise / before - 1) < _SETTLED:
            break
    return share * first
