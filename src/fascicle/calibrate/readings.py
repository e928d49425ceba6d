r"""Blocked force and free strain, read from the data, and $C_1(P)$, $C_2(P)$ from them.

At each pressure the measured pull is regressed on the untuned force $T$ of the law, near zero
strain for the blocked force and near the free strain for the free strain: locally $F = a + b T$, so

$$\hat F_{blocked} = a + b\, T(0), \qquad \hat C_1 = -a/b, \qquad
  T(\hat\varepsilon_f) = \hat C_1. \tag{34}$$

The law describes the shape of the curve, so a straight line and a few readings are enough. The
variances follow from those of the regression.

Between the measured pressures both are smooth: the blocked force is linear above a threshold,
$\hat F_{blocked} = a (P - P_0)$, as in the paper, and the free strain is that of the untuned law
times a low-order polynomial in pressure, $\hat\varepsilon_f(P) = \varepsilon_f(P)\, q(P)$. In the
paper the free strain itself is such a polynomial; the quotient needs a lower order, since the law
describes the saturation of the strain, and vanishes without pressure. With them

$$C_1(P) = T(\hat\varepsilon_f, P), \qquad
  C_2(P) = \frac{\hat F_{blocked}}{T(0, P) - C_1}. \tag{35}$$

**Source:** Kim, Mazzoleni and Bryant (2021), (31)-(35); Meller, Bryant and Garcia (2014).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from ..core.array_namespace import array_namespace, where
from ..core.module import to_numpy, with_fields
from ..core.roots import guarded
from ..core.types import AnyArray, Batch, Float
from ..muscle import Muscle
from ..muscle.tuning import Tuning
from .data import Grid


ORDERS = 4  # of the free strain's quotient: constant to cubic
NO_PRESSURE = 0.01  # of the highest pressure: forces below it are too small to read [R13]
_WINDOW = 0.3  # of the free strain: deviation of the Gaussian window of a regression
_PULLING = 0.15  # of the level's largest force: larger readings certainly pull
_LARGEST_STRAIN = 0.8  # strain at which every mesh pushes hard
_ROUNDING = 1e-4  # of the largest value: rounding of bench files

Level = Float[AnyArray, "level"]


@dataclass(frozen=True, eq=False)
class Readings:
    """Blocked forces and free strains by level of pressure, and the smooth curves through them.

    - `pressure`: of each level [Pa]; `valid`: levels with enough readings.
    - `noise`: standard deviation of a single force reading [N].
    - `coefficients`: the quotient's polynomial [-] of an `order` in pressure over the highest, then
      the blocked force's level and slope [N] over the same; `covariance`: of these.
    - `misfit`: squared deviations from both curves, over their expectation [-]; 1 if they agree.
    - `pulling`: after a joint fit, coefficients and covariance from the pull alone; else `None`.
    """

    pressure: np.ndarray
    free_strain: np.ndarray
    free_strain_deviation: np.ndarray
    blocked_force: np.ndarray
    blocked_force_deviation: np.ndarray
    valid: np.ndarray
    noise: float
    coefficients: np.ndarray
    covariance: np.ndarray
    order: int
    misfit: np.ndarray
    pulling: tuple[np.ndarray, np.ndarray] | None = None


def without_tuning(muscle: Muscle) -> Muscle:
    """The `muscle` without its tuning, except for its dead band."""
    return with_fields(muscle, tuning=with_fields(Tuning(), dead_band=muscle.tuning.dead_band))


def tension_force(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """Pull of braid and bladder [N], with tuning and ends, as if the muscle never buckled; at a
    `pressure` [Pa] and `strain` [-].
    """
    with np.errstate(all="ignore"):  # unused branches of the law
        return muscle.law.tension.force(pressure, strain)


def static_force(muscle: Muscle, pressure: Batch, strain: Batch) -> Batch:
    """Force [N] of a `muscle` at `pressure` [Pa] and `strain` [-] as a fit computes it, also beyond
    ranges; NaN where the laws have no number.
    """
    shape = np.broadcast_shapes(np.shape(pressure), np.shape(strain))
    P, eps = (np.broadcast_to(values, shape)[..., None] for values in (pressure, strain))
    with np.errstate(all="ignore"):  # unused branches of the law
        return muscle.law.at(P).pulling_force(eps)[..., 0]


def invert_force(muscle: Muscle, pressure: Batch, force: Batch) -> Batch:
    """Strain [-] of an untuned `muscle` at a `force` [N] and `pressure` [Pa], by its tension law; 0
    within the dead band, an end of the searched strains for forces that the law doesn't reach.
    """
    xp = array_namespace(pressure, force, muscle.braid_angle)
    law = muscle.law.tension
    P = law.tuning.effective_pressure(pressure)
    with np.errstate(all="ignore"):
        strain = law.law.free_strain(law.bladder, guarded(P > 0, P, 1e5), lambda _: force)
        low = 0.5 * (1 - 1 / xp.cos(muscle.braid_angle))  # as in the law's search
    strain = where(P > 0, strain, 0.0)
    return xp.where(xp.isnan(strain), _LARGEST_STRAIN, xp.clip(strain, low, _LARGEST_STRAIN))


def read_curves(muscle: Muscle, grid: Grid) -> Readings:
    """Read blocked forces and free strains from a `grid`, with the untuned law of a `muscle`."""
    law = without_tuning(to_numpy(muscle))
    P, strain, F, count = grid.pressure[:, 0], grid.strain, grid.force, grid.count
    top, zero = top_pressure(grid), np.zeros(P.shape)
    pressurized = (NO_PRESSURE * top < P) & np.any(grid.used, axis=1)
    T, blocked_law = tension_force(law, P[:, None], strain), tension_force(law, P, zero)
    free_law = invert_force(law, P, zero)

    # a first line through readings that certainly pull gives the strain at which the pull ends
    w = np.where(grid.measured, count, 0.0)
    certain = w * (_PULLING * np.max(np.where(w > 0, F, 0.0), axis=1, keepdims=True) < F)
    ends = invert_force(law, P, _regress(T, F, certain, count).offset)
    pulling = w * (strain <= ends[:, None])

    scale = safe(_WINDOW * ends[:, None])
    start_weight = pulling * np.exp(-0.5 * (strain / scale) ** 2)
    end_weight = pulling * np.exp(-0.5 * ((strain - ends[:, None]) / scale) ** 2)
    start, end = _regress(T, F, start_weight, count), _regress(T, F, end_weight, count)
    noise = _reading_scatter(T, F, pulling * pressurized[:, None])

    blocked = start.value + start.slope * (blocked_law - start.center)
    blocked_deviation = noise * np.sqrt(start.variance(blocked_law))
    c1 = end.offset
    c1_deviation = noise * np.sqrt(end.variance(c1)) / safe(np.abs(end.slope))
    free = invert_force(law, P, c1)
    with np.errstate(all="ignore"):
        slope = np.broadcast_to(law.law.tension.pull(P, free).slope, P.shape)
    free_deviation = c1_deviation / safe(np.abs(slope))
    enough = (np.sum(pulling > 0, axis=1) >= 2) & (end.slope > 0) & (start.slope > 0) & pressurized
    finite = np.isfinite(blocked_deviation + free_deviation + free)
    valid = enough & finite & (free > 0) & (free_law > 0)
    relative_pressure = P[valid] / top
    quotient = free[valid] / free_law[valid], free_deviation[valid] / free_law[valid]
    orders = range(min(ORDERS, max(relative_pressure.size, 1)))  # terms up to readings
    fits = [_polynomial(relative_pressure, *quotient, order, ORDERS) for order in orders]
    # Schwarz's criterion
    penalty = np.log(relative_pressure.size + 1.0)
    order = int(np.argmin([fit.squares + (n + 1) * penalty for n, fit in enumerate(fits)]))
    line = _polynomial(relative_pressure, blocked[valid], blocked_deviation[valid], 1, 2)
    both = fits[order], line
    levels = P, free, free_deviation, blocked, blocked_deviation, valid
    coefficients = np.concatenate([fit.coefficients for fit in both])
    covariance = np.asarray(block_diag(*(fit.covariance for fit in both)))
    misfit = np.array([fit.misfit for fit in both])
    return Readings(*levels, noise, coefficients, covariance, order, misfit)


class SmoothCurves:
    """Free strain and blocked force at each `pressure` [Pa], linear in coefficients of it over
    `top` [Pa].
    """

    def __init__(self, muscle: Muscle, pressure: Level, top: float):
        self.law, self.pressure = without_tuning(muscle), pressure
        self.relative_pressure = pressure / top
        self.valid = (self.relative_pressure > NO_PRESSURE) & (muscle.tuning.dead_band < pressure)
        self.untuned_free_strain = invert_force(self.law, pressure, 0.0 * pressure)
        self.untuned_blocked_force = tension_force(self.law, pressure, 0.0 * pressure)

    def free_strain(self, coefficients: Float[AnyArray, "coefficient"]) -> Level:
        """Free strain [-]; 0 without pressure [R13]."""
        xp = array_namespace(coefficients)
        x = self.relative_pressure
        free = self.untuned_free_strain * xp.polyval(coefficients[:ORDERS][::-1], x)
        return where(x > NO_PRESSURE, free, 0.0)

    def corrections(self, coefficients: Float[AnyArray, "coefficient"]) -> tuple[Level, Level]:
        """Corrections $C_1$ [N], (34), and $C_2$ [-], (35), at each pressure; 0 and 1 up to the
        dead band and up to 1 % of the highest pressure.
        """
        blocked = coefficients[ORDERS] + coefficients[ORDERS + 1] * self.relative_pressure
        c1 = tension_force(self.law, self.pressure, self.free_strain(coefficients))
        span = self.untuned_blocked_force - c1
        c2 = blocked / guarded(self.valid & (span != 0), span)
        return where(self.valid, c1, 0.0), where(self.valid, c2, 1.0)

    def free_strain_deviation(self, covariance: np.ndarray) -> np.ndarray:
        """Standard deviation of the free strain [-], from the coefficients' `covariance`."""
        basis = self.relative_pressure[:, None] ** np.arange(ORDERS)
        variance = np.einsum("li,ij,lj->l", basis, covariance[:ORDERS, :ORDERS], basis)
        return self.free_strain(np.eye(ORDERS)[0]) * np.sqrt(np.maximum(variance, 0.0))


def top_pressure(grid: Grid) -> float:
    """Highest pressure of a `grid` [Pa], the unit of the curves; 1 Pa for a passive muscle."""
    return max(float(np.max(grid.pressure)), 1.0)


@dataclass(frozen=True, eq=False)
class _Regression:
    """Straight lines through measured forces over the law's, level by level: `value` [N] at a
    `center` [N] and `slope` [-]; `spread`: variances and covariance of both, over a reading's.
    """

    center: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    spread: tuple[np.ndarray, np.ndarray, np.ndarray]

    @property
    def offset(self) -> np.ndarray:
        """Force of the law at which the line is zero [N]."""
        return self.center - self.value / safe(self.slope)

    def variance(self, T: np.ndarray) -> np.ndarray:
        """Variance of the line at a force `T` of the law [N], over that of a single reading [-]."""
        dT, (a, b, c) = T - self.center, self.spread
        return a + 2 * dT * b + dT**2 * c


def _regress(T: np.ndarray, F: np.ndarray, weight: np.ndarray, count: np.ndarray) -> _Regression:
    """Regress measured forces `F`, means of `count` readings, on the law's `T` with `weight`."""

    def mean(values: np.ndarray) -> np.ndarray:
        return np.sum(weight * values, axis=1) / total

    total = safe(np.sum(weight, axis=1))
    center, value = mean(T), mean(F)
    dT = T - center[:, None]
    moment = np.sum(weight * dT**2, axis=1)
    moment = np.where(moment > 0, moment, np.inf)
    slope = np.sum(weight * dT * F, axis=1) / moment
    # the variance of an entry is that of a reading over the number of readings it averages
    square = weight**2 / np.where(count > 0, count, np.inf)
    sums = [np.sum(square * dT**power, axis=1) for power in range(3)]
    spread = sums[0] / total**2, sums[1] / (total * moment), sums[2] / moment**2
    return _Regression(center, value, slope, spread)


def _reading_scatter(T: np.ndarray, F: np.ndarray, weight: np.ndarray) -> float:
    """Standard deviation [N] of forces `F` about a parabola in the law's `T`, level by level."""
    t = T / safe(np.max(np.abs(T), axis=1, keepdims=True))
    basis = np.stack([np.ones_like(t), t, t**2], axis=-1) * np.sqrt(weight)[..., None]
    target = F * np.sqrt(weight)
    # a small diagonal keeps the system of a level without readings regular
    gram = np.einsum("lri,lrj->lij", basis, basis) + 1e-12 * np.eye(3)
    best = np.linalg.solve(gram, np.einsum("lri,lr->li", basis, target)[..., None])[..., 0]
    squares = np.sum((target - np.einsum("lri,li->lr", basis, best)) ** 2, axis=1)
    free = np.sum(weight > 0, axis=1) - 3
    if np.any(free > 0):
        return float(np.sqrt(np.sum(squares[free > 0]) / np.sum(free[free > 0])))
    # too few readings to see any scatter: a typical load cell has 1 % of the largest force
    return 0.01 * max(float(np.max(np.abs(F))), 1e-9)


class _Polynomial(NamedTuple):
    """Coefficients from the constant up, normalized sum of `squares` of the residuals, and
    `misfit`, this sum over its expectation [-].
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    squares: float
    misfit: float


def _polynomial(
    x: np.ndarray, y: np.ndarray, deviation: np.ndarray, order: int, size: int
) -> _Polynomial:
    """Fit a polynomial of an `order` to `y` with its `deviation`, padded to `size` coefficients."""
    if not x.size:
        return _Polynomial(np.zeros(size), np.zeros((size, size)), 0.0, 1.0)
    # readings that agree to the last digit seem exact: their rounding limits the weight
    weight = 1 / np.maximum(deviation, _ROUNDING * np.max(np.abs(y), initial=1e-9)) ** 2
    basis = x[:, None] ** np.arange(order + 1)
    scale = max(float(np.max(weight)), 1e-300)
    gram = np.einsum("l,li,lj->ij", weight / scale, basis, basis) + 1e-14 * np.eye(order + 1)
    if x.size < 2 and order > 0:
        gram[0, 0] += 1e9  # a single reading carries a line through the origin
    inverse = np.linalg.inv(gram)
    best = inverse @ np.einsum("l,li,l->i", weight / scale, basis, y)
    squares = float(np.sum(weight * (y - basis @ best) ** 2))
    free = x.size - (order + 1)
    ratio = squares / max(free, 1)
    # a curve that misses its readings significantly is as uncertain as it misses them
    misfit = ratio if free > 0 and ratio > 1 + 3 * np.sqrt(2 / free) else 1.0
    pad = size - (order + 1)
    covariance = np.pad(misfit * inverse / scale, ((0, pad), (0, pad)))
    return _Polynomial(np.pad(best, (0, pad)), covariance, squares, misfit)


def safe(values: np.ndarray) -> np.ndarray:
    """Divisors: `values`, with 1 in place of 0."""
    return np.where(values == 0, 1.0, values)
