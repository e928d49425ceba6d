r"""A tuning's curves and factors as one vector, over all readings.

The readings' curves (`readings`) begin it: blocked force and free strain as lines tell them, place
by place. From there coefficients $c$ of the curves and coordinates $z$ of the factors are moved
together,

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
"""

from dataclasses import dataclass, replace

import numpy as np

from ..data.readings import ORDERS, Readings
from .linear import Linear, Linearized, linear
from .misfit import Misfit
from .parameters import WEAK
from .residuals import Problem
from .solving import around, walked
from .uncertainty import Conclusion, scatter


_SHRINK = 0.3  # of the free strain: deviation of each term above the constant
_WIDE = 10.0  # of the largest blocked force: as good as no prior on the line's two numbers
_AGREES = 5.0  # deviations of factors that were searched for alone: more is the law's error
_FAR = 2.0  # of a coordinate, a factor of 7: as far for factors that were hardly known
_CARRIES = 1.5  # of the readings' own scatter: more is the law's error, not noise


@dataclass(frozen=True, eq=False)
class Joined:
    """Where the joint search ended: a tuning's `problem` with the curves there [-], its `readings`
    with these and their covariance [-], coordinates of all parameters [-], and what holds there.
    """

    problem: Problem
    readings: Readings
    coordinates: np.ndarray
    end: Conclusion


class _Whole:
    """Residuals of all readings and priors, by coordinates and then curves."""

    def __init__(self, problem: Problem, weight: np.ndarray, readings: Readings, noise: float):
        data, self.k = problem.data, len(problem.parameters)
        self.at = Linearized(problem)
        blocked = np.abs(readings.blocked_force[readings.valid])
        line = _WIDE * float(np.max(blocked, initial=1.0))
        center = [1.0, *np.zeros(ORDERS - 1), 0.0, 0.0]
        deviation = [WEAK, *np.full(ORDERS - 1, _SHRINK), line, line]
        force, count, censored = (np.asarray(x) for x in (data.force, data.count, data.censored))
        self.misfit = Misfit(
            force,
            count,
            censored,
            weight,
            np.asarray(noise),
            center=np.concatenate([np.asarray(problem.center), center]),
            deviation=np.concatenate([np.asarray(problem.deviation), deviation]),
            loss=problem.loss,
        )

    def __call__(self, both: np.ndarray) -> Linear:
        return self.at.by(self.misfit, both[: self.k], both[self.k :], every=both)


def joined(
    problem: Problem,
    readings: Readings,
    best: np.ndarray,
    weight: np.ndarray,
    starts: int = 4,
    seed: int = 0,
    apart: np.ndarray | None = None,
) -> Joined | None:
    """Coordinates and curves moved together, (C14).

    **Arguments:**

    - `problem`: of a tuning [-].
    - `readings`: its curves [-], [N].
    - `best`: coordinates of all parameters, where the factors' own search ended [-].
    - `weight`: of each reading's residual, wherever it lies [-].
    - `starts`: how many places it begins from [-], about the first end: kinks leave shallow minima.
    - `seed`: of these places [-].
    - `apart`: covariance of the factors' own search [-]; left out, it isn't compared with.

    **Returns:** where it ended; `None` where nothing was read, the law doesn't carry the pull's
    shape, or what resists asks for another pull [-].
    """
    pulling = np.asarray(problem.data.uncensored) & (np.asarray(problem.weight) == 0)
    if problem.curves is None or not np.any(readings.valid) or not np.any(pulling):
        return None
    # what a gauge that only pulls clipped stays out, as the factors' search has it
    used = np.where(pulling, weight, np.asarray(problem.weight))
    k, n = len(problem.parameters), problem.chosen.size
    free = np.concatenate([problem.chosen, k + np.arange(readings.coefficients.size)])
    at, noise = np.concatenate([best, readings.coefficients]), float(readings.noise)
    whole = _Whole(problem, used, readings, noise)
    at, ended = _walked(whole, at[None], free)
    if starts > 1 and np.all(np.isfinite(ended.slopes)):
        J = ended.slopes[:, free]
        near = np.tile(at, (starts, 1))
        near[:, free] = around(at[free], np.linalg.inv(J.T @ J), starts, seed)
        at, ended = _walked(whole, near, free)
    if not np.all(np.isfinite(ended.residuals)):
        return None
    missed, sigma = ended.misfits * noise, np.asarray(noise)
    noise = scatter(replace(problem, weight=used, noise=sigma), ended.misfits, free.size)
    seen = pulling & (used > 0)
    if not np.sqrt(np.mean(missed[seen] ** 2)) < _CARRIES * readings.noise:
        return None
    if apart is not None:
        away = np.abs(at[problem.chosen] - best[problem.chosen])
        if np.any(away > np.minimum(_AGREES * np.sqrt(np.diag(apart)), _FAR)):
            return None
    J = ended.slopes.copy()
    J[: missed.size] *= float(sigma) / noise  # priors are in no units of the noise
    covariance = np.linalg.inv(J[:, free].T @ J[:, free])
    problem = replace(problem, curves=at[k:], noise=np.asarray(noise))
    here = linear(problem, at[:k])
    own = here.slopes[:, problem.chosen]
    caused = covariance[:n, :n] - np.linalg.inv(own.T @ own)
    end = Conclusion(covariance[:n, :n], caused, noise, here, here.misfits)
    rows = np.concatenate([seen.reshape(-1), np.zeros(k, bool), np.ones(len(free) - n, bool)])
    read = replace(
        readings, coefficients=at[k:], covariance=covariance[n:, n:], order=ORDERS - 1,
        alone=_alone(J[rows, k:], ended.residuals[rows] * float(sigma) / noise, at[k:]),
    )  # fmt: skip
    return Joined(problem, read, at[:k], end)


def _walked(whole: _Whole, starts: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, Linear]:
    """Where the best of searches from `starts` [-] ended, and what holds there."""
    ends = [walked(whole, start, free) for start in starts]
    best = min(ends, key=lambda end: end[1] if np.isfinite(end[1]) else np.inf)[0]
    return best, whole(best)


def _alone(J: np.ndarray, r: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and covariance of the curves that readings which pull and the curves' priors
    give, by a step of Gauss and Newton from where the joint search ended.
    """
    covariance = np.linalg.inv(J.T @ J)
    return at - covariance @ J.T @ r, covariance
