"""Levenberg-Marquardt from several starts, and in words how each of them ended.

MINPACK's walks, by way of SciPy, with exact Jacobians (`linear`). The loop runs outside of what is
compiled, which is then one evaluation of the law and no more.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import leastsq

from .linear import Linear, Linearized
from .residuals import Problem


STEPS = 200
_SAME = 0.02  # of the cost, a fifth of a standard deviation
_FAR = 1.0  # coordinates that the data don't determine are not sent further
_TOLERANCE = 1e-8  # of coordinates: far below any parameter's uncertainty
_LITTLE = 1e-10  # of the cost, which is some hundreds: a ten-thousandth of a deviation
ROUGH = 1e-6  # of the cost, where it is for an error's first digits
_SETTLED = 5e-5  # of the cost yet to win, a hundredth of a standard deviation

_NO_NUMBER = 1e9  # deviations
_FULL = 5  # MINPACK's word for all steps taken

CONVERGED, STOPPED, BROKE = 0, 1, 2
_WORDS = {
    CONVERGED: "converged",
    STOPPED: f"stopped after {STEPS} steps, before it settled",
    BROKE: "stopped where the solver could not go on",
}


@dataclass(frozen=True, eq=False)
class Solutions:
    """Where each start ended: coordinates of all the problem's parameters, half the sum of
    squares, status, steps [-].
    """

    coordinates: np.ndarray
    cost: np.ndarray
    status: np.ndarray
    steps: np.ndarray

    @property
    def best(self) -> int:
        """Which start ended lowest [-]."""
        return int(np.argmin(np.where(np.isfinite(self.cost), self.cost, np.inf)))


def solve(
    problem: Problem,
    starts: np.ndarray,
    moving: np.ndarray | None = None,
    little: float = _LITTLE,
) -> Solutions:
    """Minimize `problem` [-] from each of `starts` [-], coordinates of all its parameters, over
    those that are free, or of these only the places that are `moving` [-]; it is settled where a
    step wins no more than `little` of the cost [-].
    """
    places, linear = problem.chosen if moving is None else moving, Linearized(problem)
    ends = [walked(linear, start, places, little) for start in np.asarray(starts, float)]
    z, cost, status, steps = zip(*ends, strict=True)
    return Solutions(np.array(z), np.array(cost), np.array(status), np.array(steps))


def walked(
    linear: Callable[[np.ndarray], Linear],
    start: np.ndarray,
    free: np.ndarray,
    little: float = _LITTLE,
) -> tuple[np.ndarray, float, int, int]:
    """One walk of `solve` [-]: what is minimized as `linear` has it [-], from `start` [-] over the
    `free` places [-]. Where it ended, half the sum of squares, status, steps [-].
    """
    last: dict[bytes, Linear] = {}

    def at(z: np.ndarray) -> Linear:
        # the solver asks for residuals and Jacobian one after the other
        key = z.tobytes()
        if key not in last:
            last.clear()
            whole = start.copy()
            whole[free] = z
            last[key] = linear(whole)
        return last[key]

    def residuals(z: np.ndarray) -> np.ndarray:
        r = at(z).residuals
        # where the law has no number a step is too far
        return r if np.all(np.isfinite(r)) else np.full(r.size, _NO_NUMBER)

    z, begun = start[free], at(start[free])
    if not (np.all(np.isfinite(begun.residuals)) and np.all(np.isfinite(begun.slopes[:, free]))):
        return start, np.nan, BROKE, 0
    if not free.size:
        return start, 0.5 * float(begun.residuals @ begun.residuals), CONVERGED, 0
    minpack: Any = leastsq  # its stubs know only the short answer
    found, _, told, _, end = minpack(
        residuals, z, Dfun=lambda z: at(z).slopes[:, free], full_output=True, ftol=little,
        xtol=_TOLERANCE, gtol=0.0, maxfev=STEPS,
    )  # fmt: skip
    whole = start.copy()
    whole[free] = found
    ended = at(found)
    if not (np.all(np.isfinite(ended.residuals)) and np.all(np.isfinite(ended.slopes))):
        return start, np.nan, BROKE, 0
    # 1 to 4: nothing moves any more, or no step within rounding is left
    settled = end != _FULL or _to_win(ended.residuals, ended.slopes[:, free]) < _SETTLED
    cost = 0.5 * float(ended.residuals @ ended.residuals)
    return whole, cost, CONVERGED if settled else STOPPED, int(told["njev"])


def _to_win(r: np.ndarray, jacobian: np.ndarray) -> float:
    """What a whole Gauss-Newton step would take off the cost [-].

    Along a direction that the data hardly determine, coordinates creep long after the fit has
    settled.
    """
    basis, size, _ = np.linalg.svd(jacobian, full_matrices=False)
    part = np.where(size > 1e-12 * size[0], basis.T @ r, 0)
    return 0.5 * float(part @ part)


def scattered(center: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """`count` starts [-]: the `center` [-], then others about it within a factor of 2."""
    rng = np.random.default_rng(seed)
    others = center + np.log(2) * rng.uniform(-1, 1, (count - 1, center.size))
    return np.concatenate([center[None], others])


def around(best: np.ndarray, covariance: np.ndarray, count: int, seed: int = 0) -> np.ndarray:
    """`count` starts [-]: the `best` [-], then others twice its deviations about it."""
    spread, basis = np.linalg.eigh(np.nan_to_num(covariance))
    normal = np.random.default_rng(seed).normal(size=(count - 1, best.size))
    away = 2 * normal @ (basis * np.sqrt(np.clip(spread, 0, _FAR**2))).T
    return np.concatenate([best[None], best + away])


def joined(first: Solutions, second: Solutions) -> Solutions:
    """The ends [-] of two searches, one after the other."""
    return Solutions(*(
        np.concatenate([getattr(one, name) for one in (first, second)])
        for name in ("coordinates", "cost", "status", "steps")
    ))  # fmt: skip


def least(solutions: Solutions) -> float:
    """The lowest cost [-]; infinite where all broke."""
    return float(np.min(np.where(np.isfinite(solutions.cost), solutions.cost, np.inf)))


def in_words(solutions: Solutions) -> list[str]:
    """How each start ended [-], a line each."""
    best = least(solutions)
    lines = []
    for i, (cost, status, steps) in enumerate(
        zip(solutions.cost.tolist(), solutions.status.tolist(), solutions.steps.tolist(),
            strict=True), start=1
    ):  # fmt: skip
        how = f"start {i}: {_WORDS[status]} ({steps} step{'' if steps == 1 else 's'})"
        if status != BROKE:
            # two ends are one minimum if no data could tell them apart
            same = cost - best < _SAME
            how += ", at the best minimum" if same else f", at a worse one (cost {cost:.6g})"
        lines.append(how)
    return lines
