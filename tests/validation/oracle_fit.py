"""The oracle, part 5: fits by plain SciPy, of clipped readings and of the factors.

Written from the equations; it never imports the library that it judges. Coordinates and
weak priors are stated here once more: logarithms of what is positive, the logit of the braid
angle over 54.7 degrees, the logarithm of radius less wall, and for the hinge the logarithm
of its factor at zero pressure and z in ln(1 + e^z), its factor at 1 MPa.
"""

import dataclasses
import math

import numpy as np
from oracle_force import force
from oracle_muscle import Material
from scipy.optimize import least_squares, minimize
from scipy.stats import norm


NEUTRAL = math.atan(math.sqrt(2))
WEAK = 3.0
WEAK_SLOPE = 30.0
FACTORS = ("youngs_modulus_factor", "collapse_moment_factor", "hinge_stiffness_factor",
           "hinge_stiffness_slope", "transition_rate")  # fmt: skip


# ---- four constants of the tension law, with clipped readings


def constants_at(muscle, z):
    """`muscle` with c10, c01, braid angle and radius at coordinates z; E follows."""
    c10, c01 = math.exp(z[0]), math.exp(z[1])
    return dataclasses.replace(
        muscle,
        material=Material(c10, c01, 6 * (c10 + c01), muscle.material.poisson_ratio),
        braid_angle=NEUTRAL / (1 + math.exp(-z[2])),
        outer_radius=muscle.wall_thickness + math.exp(z[3]),
    )


def constants_of(muscle):
    """Its coordinates."""
    share = muscle.braid_angle / NEUTRAL
    return np.array([
        math.log(muscle.material.c10), math.log(muscle.material.c01),
        math.log(share / (1 - share)), math.log(muscle.outer_radius - muscle.wall_thickness),
    ])  # fmt: skip


def negative_log_likelihood(muscle, data, sigma):
    """Of Tobin's model, without the constant of each measured reading, with its sigma."""
    P, strain, F, clipped = data
    mu = np.array([force(muscle, p, e) for p, e in zip(P, strain, strict=True)])
    measured = 0.5 * ((F - mu) / sigma) ** 2 + math.log(sigma)
    return float(np.sum(np.where(clipped, -norm.logcdf(-mu / sigma), measured)))


def fit_constants(muscle, data, sigma=None, start=None):
    """Coordinates and sigma of the least negative log-likelihood, priors about `muscle`.

    With `sigma` given it is held, and the search is for a sum of squares; left out, it is a
    fifth parameter, and the search is for the likelihood itself.
    """
    center = constants_of(muscle)
    start = center if start is None else start
    if sigma is not None:
        return _squares(muscle, data, sigma, center, start), sigma

    def cost(x):
        prior = 0.5 * np.sum(((x[:4] - center) / WEAK) ** 2)
        return negative_log_likelihood(constants_at(muscle, x[:4]), data, math.exp(x[4])) + prior

    F = data[2]
    first = np.concatenate([start, [math.log(0.01 * F.max())]])
    found = minimize(cost, first, method="BFGS", options={"gtol": 1e-3}).x
    return found[:4], math.exp(found[4])


def _squares(muscle, data, sigma, center, start):
    P, strain, F, clipped = data

    def residuals(z):
        made = constants_at(muscle, z)
        mu = np.array([force(made, p, e) for p, e in zip(P, strain, strict=True)])
        r = np.where(clipped, np.sqrt(-2 * norm.logcdf(-mu / sigma)), (F - mu) / sigma)
        return np.concatenate([r, (z - center) / WEAK])

    return least_squares(residuals, start, method="lm", xtol=1e-13, ftol=1e-13, gtol=1e-13,
                         diff_step=1e-7).x  # fmt: skip


# ---- the factors, with C1 and C2 as they are


def factors_at(muscle, z):
    """`muscle` with its factors at coordinates z."""
    hinge = math.exp(z[2])
    return dataclasses.replace(
        muscle,
        tuning=dataclasses.replace(
            muscle.tuning,
            youngs_modulus_factor=math.exp(z[0]),
            collapse_moment_factor=math.exp(z[1]),
            hinge_stiffness_factor=hinge,
            hinge_stiffness_slope=(math.log1p(math.exp(z[3])) - hinge) / 1e6,
            transition_rate=math.exp(z[4]),
        ),
    )


def factors_of(muscle):
    """Its coordinates."""
    tuning = muscle.tuning
    top = tuning.hinge_stiffness_factor + 1e6 * tuning.hinge_stiffness_slope
    rate = muscle.transition_rate if tuning.transition_rate is None else tuning.transition_rate
    return np.array([
        math.log(tuning.youngs_modulus_factor), math.log(tuning.collapse_moment_factor),
        math.log(tuning.hinge_stiffness_factor), math.log(math.expm1(top)), math.log(rate),
    ])  # fmt: skip


def factor_residuals(muscle, data, sigma):
    """Of readings [N] over `sigma`, and of priors about `muscle`, by coordinates."""
    P, strain, F = data
    center = factors_of(muscle)
    deviation = np.array([WEAK, WEAK, WEAK, WEAK_SLOPE, WEAK])

    def residuals(z):
        made = factors_at(muscle, z)
        mu = np.array([force(made, p, e) for p, e in zip(P, strain, strict=True)])
        return np.concatenate([(F - mu) / sigma, (z - center) / deviation])

    return residuals


def fit_factors(muscle, data, sigma, start):
    """Coordinates and half the sum of squares at the minimum found from `start`."""
    found = least_squares(
        factor_residuals(muscle, data, sigma), start, xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    return found.x, found.cost
