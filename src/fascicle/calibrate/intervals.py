r"""Intervals beyond the linear approximation: profile likelihoods and a parametric bootstrap.

**Profiles.** Coordinate $i$ is held at $z_i$ and all others are fitted again:

$$\Delta(z_i) = \min_{z_{j \ne i}} \lVert r \rVert^2 - \min \lVert r \rVert^2 \tag{C4}$$

In a nearly linear problem this is the squared distance in standard deviations; it is 2.71 at the
ends of a 90 % interval. A flat profile shows a parameter that the data do not determine; an uneven
one shows an asymmetric interval. The readings of a tuning are fixed here, so $\Delta$ counts in
proportion to the part of the variance that noise causes.

**Bootstrap.** Each draw simulates a record of the fitted muscle at the measured points, with the
fitted noise, clipped where the gauge clips. If the residuals show an error of the model, a smooth
error is drawn from (C10) and added. Each simulated record is fitted as the measured one was. The
errors $\delta = \hat z^* - \hat z$ of the draws stand for the error of the fit:

$$\hat z - \delta_{95\,\%} < z < \hat z - \delta_{5\,\%}, \tag{C15}$$

Unlike (C3), this does not assume a nearly linear problem: the strain of collapse is a kink that
passes from one reading to the next. Correlated residuals widen $\delta$ as they widen (C3).

If the draws of a constant scatter by more than a factor of e, (C15) would give it values that no
fit has reached. For such a constant the quantiles of the draws are used directly.

**Assumes** that the law is right except for that error. The free constants are not selected anew.
**Source:** Raue et al. (2009); Efron and Tibshirani (1993), chapters 6 and 13.
"""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from ..core.errors import InvalidInputError
from .calibration import Bootstrap, Calibration, Profile, value_of
from .data import Grid
from .least_squares import KNOWN, NORMAL, solve, solve_with_noise
from .parameters import WEAK
from .tuning import refit_tuning


DRAWS = 199  # of which the 10th from either end are the ends of a 90 % interval
_TAIL = 0.05  # a 90 % interval lacks it at either end
_MIN_DRAWS = 19  # of which the lowest and highest are the ends of a 90 % interval
_CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_POINTS, _REACH = 11, 3.0  # of a profile by default: steps of 0.6 standard deviations
_TOLERANCE = 3e-4  # of a cost of some hundreds: 5 % of the critical rise, 3 % of its distance


def with_profiles(calibration: Calibration) -> Calibration:
    """The `calibration` with profiles of those parameters whose quick interval says nothing."""
    names = [parameter.name for parameter in calibration.parameters if not parameter.identifiable]
    if not names or calibration.bootstrapped is not None:
        return calibration
    return replace(calibration, profiles=profiles(calibration, names=names))


def profiles(
    calibration: Calibration,
    points: int = _POINTS,
    reach: float = _REACH,
    names: Collection[str] | None = None,
) -> tuple[Profile, ...]:
    """Profile likelihoods of a calibration's parameters, over at most `points` held values of each.

    A profile ends on either side where it passes the critical rise.

    **Arguments:**

    - `calibration`: the calibration; profiles that it has already are not computed again.
    - `points`: largest number of values that a profile holds its parameter at, odd.
    - `reach`: distance of the first and last from the fitted value, in standard deviations [-].
    - `names`: of these parameters; all by default.

    **Returns:** the profiles in the order of the parameters.
    """
    steps = np.linspace(-reach, reach, points)
    # noise is held at its fitted value: the rise counts in proportion to noise's part of variance
    minimum = calibration.minimum
    noise = np.diag(minimum.covariance - minimum.from_curves)
    noise_share = noise / np.diag(calibration.covariance)
    default = (points, reach) == (_POINTS, _REACH)
    present = {profile.name: profile for profile in calibration.profiles} if default else {}
    out = []
    for i, name in enumerate(calibration.names):
        if names is not None and name not in names:
            continue
        if name in present:
            out.append(present[name])
            continue
        value, coordinate, rise = _profile(calibration, i, steps, noise_share[i])
        width = np.ptp(_crossings(coordinate, rise))
        factor = calibration.problem.parameters[i].deviation / WEAK  # coordinates of a factor of e
        identified = bool(width < 2 * NORMAL * KNOWN * factor)
        out.append(Profile(name, value, rise, *_crossings(value, rise), identified))
    return tuple(out)


def _profile(
    calibration: Calibration, index: int, steps: np.ndarray, noise_share: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Profile of a parameter: its held values [SI unit] and coordinates [-], and the rise of the
    deviance after a refit at each [-], times `noise_share`; `steps` in standard deviations [-].
    """
    problem, C, z = calibration.problem, calibration.covariance, calibration.coordinates
    other_columns = np.delete(np.arange(z.size), index)
    direction = C[index] / np.sqrt(C[index, index])  # along the fit's correlations

    def refit(start: np.ndarray) -> tuple[float, np.ndarray]:
        """Rise at the end of a refit, and the end."""
        end = solve(problem, start[None], other_columns, tolerance=_TOLERANCE)
        point = end.points[0]
        # a parameter's own prior is no part of the likelihood
        priors = ((np.array([point, z])[:, index] - center) / deviation) ** 2
        return noise_share * (2 * (end.cost[0] - lowest) - priors[0] + priors[1]), point

    center, deviation = problem.center[index], problem.deviation[index]
    lowest = solve(problem, z[None], np.zeros(0, dtype=int)).cost[0]
    ends = [(0.0, z)]
    for side in (-np.sort(-steps[steps < 0]), np.sort(steps[steps > 0])):
        last_step, last, course = 0.0, z, direction
        for step in side:
            # each refit begins where the two before it lead
            end = refit(last + (step - last_step) * course)
            if end[0] > _CRITICAL:  # kinks cause shallow minima: the lower end of two counts
                end = min(end, refit(z + step * direction), key=lambda end: end[0])
            ends.append(end)
            if end[0] > _CRITICAL:
                break
            course, last, last_step = (end[1] - last) / (step - last_step), end[1], step
    rises, points = zip(*ends, strict=True)
    order = np.argsort([point[index] for point in points])
    path = np.array(points)[order]
    values = np.array([value_of(problem, point)[index] for point in path])
    return values, path[:, index], np.array(rises)[order]


def _crossings(value: np.ndarray, rise: np.ndarray) -> tuple[float, float]:
    """Values where a profile first crosses the critical rise on either side of its lowest point."""
    middle, ends = int(np.argmin(rise)), []
    for side, otherwise in ((np.s_[middle::-1], -np.inf), (np.s_[middle:], np.inf)):
        # deviations are nearly linear in the value, their squares are not
        x, deviation = value[side], np.sqrt(np.maximum(rise[side], 0.0))
        outer = int(np.argmax(deviation**2 > _CRITICAL))
        pair = slice(outer - 1, outer + 1)
        crossing = np.interp(np.sqrt(_CRITICAL), deviation[pair], x[pair]) if outer else otherwise
        ends.append(float(crossing))
    return ends[0], ends[1]


def bootstrap(
    calibration: Calibration,
    draws: int = DRAWS,
    seed: int = 0,
    tell: Callable[[str], object] = lambda _: None,
) -> Calibration:
    """Intervals from a parametric bootstrap of the whole fit.

    **Arguments:**

    - `calibration`: the calibration; its noise must be normal, so its loss linear.
    - `draws`: how many records are simulated and fitted, at least 19.
    - `seed`: random seed.
    - `tell`: is called with the present step, in words.

    **Returns:** the calibration with `bootstrapped`, whose intervals its `parameters` have.

    **Raises:** `InvalidInputError` for a robust loss and too few draws.
    """
    if calibration.problem.loss != "linear":
        raise InvalidInputError(
            "loss", "must be linear for a bootstrap", None, "a robust one is no model"
        )
    if draws < _MIN_DRAWS:
        raise InvalidInputError(
            "draws", f"must be at least {_MIN_DRAWS} for a 90 % interval", draws
        )
    rng, rows = np.random.default_rng(seed), []
    for draw in range(draws):
        tell(f"bootstrapping, {draw + 1} of {draws}")
        z = refit(calibration, simulate_grid(calibration, rng))
        if np.all(np.isfinite(z)):
            rows.append(z)
    if len(rows) < draws / 2:
        raise InvalidInputError(
            "record", "can't be bootstrapped: most simulated records like it can't be fitted", None
        )
    z = np.array(rows)
    values = np.array([value_of(calibration.problem, row) for row in z])
    ends = _bootstrap_ends(calibration, z, values)
    boots = Bootstrap(calibration.names, z, values, *ends, draws - len(rows))
    return replace(calibration, bootstrapped=boots)


def simulate_grid(calibration: Calibration, rng: np.random.Generator) -> Grid:
    """Simulate a record of the fitted muscle, as a grid."""
    grid, diagnosis = calibration.grid, calibration.diagnosis
    noise = diagnosis.noise if diagnosis.significant else calibration.problem.noise
    b = rng.standard_normal(diagnosis.discrepancy.shape[-1])
    error = diagnosis.discrepancy @ b if b.size else 0.0
    scatter = noise / np.sqrt(np.maximum(grid.count, 1)) * rng.standard_normal(grid.count.shape)
    force = np.where(grid.used, calibration.force + error + scatter, 0.0)
    if not np.any(grid.censored):
        return replace(grid, force=force)
    floor = np.min(grid.force[grid.censored])  # the gauge's, zero mostly
    clipped = (force <= floor) & grid.used
    return replace(grid, force=np.where(clipped, floor, force), censored=clipped)


def refit(calibration: Calibration, grid: Grid) -> np.ndarray:
    """Coordinates [-] of the fit to another `grid`, begun where the record's own ended."""
    problem, point, readings = calibration.problem, calibration.coordinates, calibration.readings
    if readings is not None:
        joint = readings.pulling is not None
        return refit_tuning(problem, point, grid, calibration.weights, joint)[0]
    again = replace(problem, grid=grid, weight=grid.weights(calibration.weights))
    return solve_with_noise(again, point[None]).point


def _bootstrap_ends(
    calibration: Calibration, z: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the intervals [SI units], (C15); even in value where a parameter is so given."""
    problem, wide = calibration.problem, np.sqrt(calibration.diagnosis.inflation)
    best, count = calibration.coordinates, len(z)
    fitted, undetermined = value_of(problem, best), np.std(z, axis=0) > KNOWN
    errors, value_errors = np.sort(z - best, axis=0), np.sort(values - fitted, axis=0)
    ends = []
    for fraction in (1 - _TAIL, _TAIL):
        rank = int(np.clip(round((count + 1) * fraction), 1, count)) - 1
        away = np.where(undetermined, -errors[-1 - rank], errors[rank]) * wide
        displaced = [
            value_of(problem, best - away * row)[i] for i, row in enumerate(np.eye(best.size))
        ]
        linear = [parameter.linear for parameter in problem.parameters]
        ends.append(np.where(linear, fitted - value_errors[rank] * wide, displaced))
    return ends[0], ends[1]
