r"""The paper's tuning: $C_1$ and $C_2$ from readings, and the factors by least squares.

Where the muscle pulls, the tension law is corrected to the measured blocked force and free strain
(`readings`). Past this free strain, where it resists, the factors on $E$, on the collapse moment
and on the hinge's stiffness and the rate $\beta$ are fitted to all pressures at once. The two steps
use different readings, so the uncertainty of the first one propagates to the second without being
counted twice.

Then coefficients $c$ of the curves and coordinates $z$ of the factors are fitted together,

$$\min_{z,\, c} \sum_i r_i(z, c)^2 + \sum_j \left(\frac{z_j - z_{0j}}{\tau_j}\right)^2
  + \sum_k \left(\frac{c_k - c_{0k}}{\tau_k}\right)^2, \tag{C14}$$

so that one covariance contains the information of readings past the free strain on the curves, and
the effect of the curves' uncertainty on the factors. The quotient of the free strain has all four
terms; those above the constant have a prior of zero with a deviation of 0.3, a third of the free
strain.

**Assumes** that the law describes the shape of the pull. If its error is more than 1.5 times the
scatter of the readings about their own lines, the result of the first two steps is kept. So it is
if the factors would change by more than five standard deviations of their own search or a factor
of 7: pull and resisting force then belong to different muscles.
**Source:** Kim, Mazzoleni and Bryant (2021), section 5.
"""

from dataclasses import replace

import numpy as np

from .data import Grid
from .least_squares import (
    ROUGH,
    Minimum,
    Problem,
    Solution,
    linearize,
    residual_noise,
    solve,
    starts_around,
)
from .parameters import WEAK
from .readings import ORDERS, Readings, SmoothCurves, read_curves, top_pressure


_CLEAR = 2.0  # deviations of the free strain: nearer readings may pull or resist
_SHRINK = 0.3  # of the free strain: prior deviation of each term above the constant
_WIDE = 10.0  # of the largest blocked force: practically no prior on the line's two numbers
_AGREES = 5.0  # deviations of factors fitted alone: a larger change is the law's error
_MAX_SHIFT = 2.0  # of a coordinate, a factor of 7: the same limit for undetermined factors
_MAX_ERROR = 1.5  # of the readings' own scatter: a larger error is the law's, not noise


def with_readings(problem: Problem, grid: Grid) -> tuple[Readings, Problem]:
    """Read a `grid`, its strains relative to the muscle's length, and limit a `problem` to the
    factors past the free strain.
    """
    readings = read_curves(problem.muscle, grid)
    curves = SmoothCurves(problem.muscle, readings.pressure, top_pressure(grid))
    # within the error of the free strain a reading may belong to either side
    error = curves.free_strain_deviation(readings.covariance)
    free = curves.free_strain(readings.coefficients) + _CLEAR * error
    # a gauge that never shows a push has measured nothing past the free strain
    force = np.where(grid.measured, grid.force, 0.0)
    pulls_only = bool(np.any(grid.used & grid.censored) and np.min(force) >= 0)
    weight = grid.used * (grid.strain > free[:, None]) * float(not pulls_only)
    return readings, replace(
        problem, grid=grid, weight=weight, noise=readings.noise, curves=readings.coefficients
    )


def refit_tuning(
    problem: Problem, point: np.ndarray, grid: Grid, joint: bool
) -> tuple[np.ndarray, Problem]:
    """Coordinates [-] of a tuning on another `grid`, from a `point`, and the problem with its
    curves; `joint`: fit curves and factors together.
    """
    readings, refit = with_readings(problem, grid)
    end = fit_jointly(refit, readings, point) if joint else None
    if end is not None:
        return end.point, end.problem
    return solve(refit, point[None], tolerance=ROUGH).points[0], refit


def fit_jointly(
    problem: Problem,
    readings: Readings,
    best: np.ndarray,
    starts: int = 1,
    seed: int = 0,
    covariance: np.ndarray | None = None,
) -> Solution | None:
    """Fit coordinates and curves together, (C14), from the end of the factors' own search, `best`,
    and further `starts` about the first end: kinks cause shallow minima.

    `covariance`: of the factors' own search, to compare the end with. `None` if nothing was read,
    the law does not describe the shape of the pull, or the factors change too much.
    """
    pulling = problem.grid.measured & (problem.weight == 0)
    if problem.curves is None or not np.any(readings.valid) or not np.any(pulling):
        return None
    k = len(best)
    line = _WIDE * float(np.max(np.abs(readings.blocked_force[readings.valid]), initial=1.0))
    center, deviation = [1.0, *np.zeros(ORDERS + 1)], [WEAK, *[_SHRINK] * (ORDERS - 1), line, line]
    joint = replace(
        problem,
        # clipped readings of a gauge that only pulls stay out, as in the factors' search
        weight=np.where(pulling, problem.grid.used, problem.weight),
        noise=readings.noise,
        center=np.concatenate([problem.center, center]),
        deviation=np.concatenate([problem.deviation, deviation]),
    )
    first = np.concatenate([best, readings.coefficients])[None]
    ends = solve(joint, first, tolerance=ROUGH)
    point = ends.points[0]
    end = linearize(joint, point)
    if starts > 1 and np.all(np.isfinite(end.slopes)):
        inverse = np.linalg.inv(end.slopes.T @ end.slopes)
        ends = solve(joint, starts_around(point, starts, seed, inverse), tolerance=ROUGH)
        point = solve(joint, ends.points[[ends.best]]).points[0]
        end = linearize(joint, point)
    if not np.all(np.isfinite(end.residuals)):
        return None
    errors, noise = end.misfits * joint.noise, residual_noise(joint, end.misfits, len(point))
    fitted = pulling & (joint.weight > 0)
    if not np.sqrt(np.mean(errors[fitted] ** 2)) < _MAX_ERROR * readings.noise:
        return None
    if covariance is not None:
        limit = np.minimum(_AGREES * np.sqrt(np.diag(covariance)), _MAX_SHIFT)
        if np.any(np.abs(point[:k] - best) > limit):
            return None
    J = end.slopes.copy()
    J[: errors.size] *= joint.noise / noise  # only readings are in units of the noise
    C = np.linalg.inv(J.T @ J)
    # curves from the pull and their priors alone: a Gauss-Newton step from the joint end
    rows = np.concatenate([fitted.reshape(-1), np.arange(len(point)) >= k])
    C_pull = np.linalg.inv(J[rows, k:].T @ J[rows, k:])
    residuals = end.residuals[rows] * joint.noise / noise
    problem = replace(problem, curves=point[k:], noise=noise)
    linear = linearize(problem, point[:k], by_curves=True)
    factor_slopes = linear.slopes[:, :k]
    from_curves = C[:k, :k] - np.linalg.inv(factor_slopes.T @ factor_slopes)
    pulling = point[k:] - C_pull @ J[rows, k:].T @ residuals, C_pull
    curves = {"coefficients": point[k:], "covariance": C[k:, k:], "order": ORDERS - 1}
    joint_readings = replace(readings, **curves, pulling=pulling)
    minimum = Minimum(C[:k, :k], from_curves, noise, noise, linear)
    return Solution(problem, ends, point[:k], minimum, joint_readings)
