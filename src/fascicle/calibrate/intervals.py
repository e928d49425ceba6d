r"""Intervals beyond the linear approximation: profile likelihoods.

Coordinate $i$ is held at $z_i$ and all others are fitted again:

$$\Delta(z_i) = \min_{z_{j \ne i}} \lVert r \rVert^2 - \min \lVert r \rVert^2 \tag{C4}$$

In a nearly linear problem this is the squared distance in standard deviations; it is 2.71 at the
ends of a 90 % interval. A flat profile shows a parameter that the data do not determine; an uneven
one shows an asymmetric interval. The readings of a tuning are fixed here, so $\Delta$ counts in
proportion to the part of the variance that noise causes.

**Source:** Raue et al. (2009).
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .calibration import Calibration, Profile, value_of
from .least_squares import KNOWN, NORMAL, solve
from .parameters import WEAK


_CRITICAL = NORMAL**2  # 90 % of a squared normal deviate
_STEPS = np.linspace(0.6, 3.0, 5)  # standard deviations: well past the critical rise
_TOLERANCE = 3e-4  # of a cost of some hundreds: 5 % of the critical rise, 3 % of its distance


def with_profiles(calibration: Calibration) -> Calibration:
    """The `calibration` with profiles of those parameters whose quick interval says nothing."""
    estimates, doubtful = calibration.parameters, calibration.doubtful
    names = [e.name for e in estimates if not e.identifiable and e.name not in doubtful]
    return replace(calibration, profiles=profiles(calibration, names=names))


def profiles(calibration: Calibration, names: Collection[str] | None = None) -> tuple[Profile, ...]:
    """Profile likelihoods [-] of a calibration's parameters, by default of all; each ends where it
    passes the critical rise.
    """
    # noise is held at its fitted value: the rise counts in proportion to noise's part of variance
    minimum = calibration.minimum
    noise = np.diag(minimum.covariance - minimum.from_curves)
    noise_share = noise / np.diag(calibration.covariance)
    out = []
    for i, name in enumerate(calibration.names):
        if names is not None and name not in names:
            continue
        value, coordinate, rise = _profile(calibration, i, noise_share[i])
        width = np.ptp(_crossings(coordinate, rise))
        factor = calibration.problem.parameters[i].deviation / WEAK  # coordinates of a factor of e
        identified = bool(width < 2 * NORMAL * KNOWN * factor)
        out.append(Profile(name, value, rise, *_crossings(value, rise), identified))
    return tuple(out)


def _profile(
    calibration: Calibration, index: int, noise_share: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Held values [SI unit] and coordinates [-] of a parameter, and the rise of the deviance after
    a refit at each [-], times `noise_share`.
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
    for side in (-_STEPS, _STEPS):
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
