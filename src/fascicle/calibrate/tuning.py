r"""The paper's tuning: readings give $C_1$, $C_2$, and least squares the factors.

Where the muscle pulls, the tension law is corrected to the blocked force and the free
strain that were read (`readings`). Where it resists, past the free strain so found, the
factors on $E$, on the collapse moment and on the hinge's stiffness and the rate $\beta$ are
fitted to all pressures at once. The two use different readings, so the uncertainty of the first
carries over to the second without being counted twice.

From there coefficients $c$ of the curves and coordinates $z$ of the factors are moved together,

$$\min_{z,\, c} \sum_i r_i(z, c)^2 + \sum_j \left(\frac{z_j - z_{0j}}{\tau_j}\right)^2
  + \sum_k \left(\frac{c_k - c_{0k}}{\tau_k}\right)^2, \tag{C14}$$

so that what a reading past the free strain says of the curves, and what the curves leave unsure of
the factors, is in one covariance. No order of the free strain's quotient is chosen: all four terms
are free, those above the constant shrunk towards zero by a prior of 0.3, a third of the free
strain.

**Assumes** that the law carries the pull's shape. Where it misses it by more than half as much
again as readings scatter about their own lines, blocked force and free strain stay as they were
read, and factors are what follows of them; so they do where factors would move by more than five
deviations of their own search, or a factor of 7: what pulls and what resists then ask for
different muscles.
**Source:** Kim, Mazzoleni and Bryant (2021), section 5.
"""

from dataclasses import dataclass, replace

import numpy as np

from .data import Grid
from .least_squares import (
    FINE,
    ROUGH,
    Minimum,
    Problem,
    linearize,
    residual_noise,
    solve,
    starts_around,
)
from .parameters import WEAK
from .readings import ORDERS, Readings, SmoothCurves, read, top_pressure


_CLEAR = 2.0  # deviations of the free strain
_SHRINK = 0.3  # of the free strain: deviation of each term above the constant
_WIDE = 10.0  # of the largest blocked force: as good as no prior on the line's two numbers
_AGREES = 5.0  # deviations of factors that were searched for alone: more is the law's error
_FAR = 2.0  # of a coordinate, a factor of 7: as far for factors that were hardly known
_CARRIES = 1.5  # of the readings' own scatter: more is the law's error, not noise


def with_readings(problem: Problem, grid: Grid, weights: str) -> tuple[Readings, Problem]:
    """Read a `grid`, and turn a problem into that of the factors past the free strain.

    **Arguments:**

    - `problem`: with the muscle, the parameters and their priors.
    - `grid`: readings, their strains those of the muscle's own length.
    - `weights`: how levels count, one of `WEIGHTS`.
    """
    readings = read(problem.muscle, grid)
    curves = SmoothCurves(problem.muscle, readings.pressure, top_pressure(grid))
    # nearer to the free strain than its own error a reading may belong to either side
    error = curves.free_strain_deviation(readings.covariance)
    free = curves.free_strain(readings.coefficients) + _CLEAR * error
    # a gauge that never shows a push has measured nothing there: what it clipped says no more
    force = np.where(grid.measured, grid.force, 0.0)
    pulls_only = bool(np.any(grid.used & grid.censored) and np.min(force) >= 0)
    weight = grid.weights(weights) * (grid.strain > free[:, None]) * (not pulls_only)
    return readings, replace(
        problem, grid=grid, weight=weight, noise=readings.noise, curves=readings.coefficients
    )


def refit_tuning(
    problem: Problem, point: np.ndarray, grid: Grid, weights: str, joint: bool
) -> tuple[np.ndarray, Problem]:
    """Tune to another `grid`: coordinates, and the problem with its curves.

    **Arguments:**

    - `problem`, `weights`: of the first tuning.
    - `point`: coordinates to begin from.
    - `grid`: other readings at the same places, or fewer.
    - `joint`: whether curves and factors are fitted together.
    """
    readings, again = with_readings(problem, grid, weights)
    point = solve(again, point[None], tolerance=ROUGH).points[0]
    together = fit_jointly(again, readings, point, weights, starts=1) if joint else None
    return (point, again) if together is None else (together.point, together.problem)


@dataclass(frozen=True, eq=False)
class JointFit:
    """End of the joint search: the `problem` with its curves there, the `readings` with these and
    their covariance, the `point`, coordinates alone, and the `minimum`.
    """

    problem: Problem
    readings: Readings
    point: np.ndarray
    minimum: Minimum


def fit_jointly(
    problem: Problem,
    readings: Readings,
    best: np.ndarray,
    weights: str,
    starts: int = 4,
    seed: int = 0,
    covariance: np.ndarray | None = None,
) -> JointFit | None:
    """Fit coordinates and curves together, (C14).

    **Arguments:**

    - `problem`, `readings`: of a tuning.
    - `best`: coordinates where the factors' own search ended.
    - `weights`: how levels count, one of `WEIGHTS`.
    - `starts`: how many points it begins from, about the first end: kinks leave shallow minima.
    - `seed`: random seed of these.
    - `covariance`: of the factors' own search; left out, it isn't compared with.

    **Returns:** its end; `None` where nothing was read, the law doesn't carry the pull's shape,
    or what resists asks for another pull.
    """
    pulling = problem.grid.measured & (problem.weight == 0)
    if problem.curves is None or not np.any(readings.valid) or not np.any(pulling):
        return None
    k = len(best)
    line = _WIDE * float(np.max(np.abs(readings.blocked_force[readings.valid]), initial=1.0))
    center, deviation = [1.0, *np.zeros(ORDERS + 1)], [WEAK, *[_SHRINK] * (ORDERS - 1), line, line]
    joint = replace(
        problem,
        # what a gauge that only pulls clipped stays out, as the factors' search has it
        weight=np.where(pulling, problem.grid.weights(weights), problem.weight),
        noise=readings.noise,
        center=np.concatenate([problem.center, center]),
        deviation=np.concatenate([problem.deviation, deviation]),
    )
    first = np.concatenate([best, readings.coefficients])[None]
    point = solve(joint, first, tolerance=FINE if starts > 1 else ROUGH).points[0]
    end = linearize(joint, point)
    if starts > 1 and np.all(np.isfinite(end.slopes)):
        inverse = np.linalg.inv(end.slopes.T @ end.slopes)
        point = solve(joint, starts_around(point, starts, seed, inverse)).best_point
        end = linearize(joint, point)
    if not np.all(np.isfinite(end.residuals)):
        return None
    missed, noise = end.misfits * joint.noise, residual_noise(joint, end.misfits, len(point))
    fitted = pulling & (joint.weight > 0)
    if not np.sqrt(np.mean(missed[fitted] ** 2)) < _CARRIES * readings.noise:
        return None
    if covariance is not None:
        limit = np.minimum(_AGREES * np.sqrt(np.diag(covariance)), _FAR)
        if np.any(np.abs(point[:k] - best) > limit):
            return None
    J = end.slopes.copy()
    J[: missed.size] *= joint.noise / noise  # priors are in no units of the noise
    whole = np.linalg.inv(J.T @ J)
    # the curves by what pulls alone and their priors: a Gauss-Newton step from the joint end
    rows = np.concatenate([fitted.reshape(-1), np.arange(len(point)) >= k])
    alone = np.linalg.inv(J[rows, k:].T @ J[rows, k:])
    left = end.residuals[rows] * joint.noise / noise
    problem = replace(problem, curves=point[k:], noise=noise)
    linear = linearize(problem, point[:k], by_curves=True)
    own = linear.slopes[:, :k]
    caused = whole[:k, :k] - np.linalg.inv(own.T @ own)
    read_jointly = replace(
        readings, coefficients=point[k:], covariance=whole[k:, k:], order=ORDERS - 1,
        pulling=(point[k:] - alone @ J[rows, k:].T @ left, alone),
    )  # fmt: skip
    minimum = Minimum(whole[:k, :k], caused, noise, noise, linear)
    return JointFit(problem, read_jointly, point[:k], minimum)
