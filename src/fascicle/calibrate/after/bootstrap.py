r"""Intervals by a parametric bootstrap: the whole fit, again and again, on records that it makes.

Each draw is a record of the fitted muscle at the readings' own places, with the noise that was
found, clipped where the gauge clips, and with a smooth error of the model where residuals show one,
(C10) drawn anew. Of it everything is done that was done of the record: blocked force and free
strain are read, factors and curves searched for together, or constants with the noise that is left.
The errors $\delta = \hat z^* - \hat z$ of the draws are taken for those of the fit,

$$\hat z - \delta_{95\,\%} < z < \hat z - \delta_{5\,\%}, \tag{C15}$$

which needs no problem that is nearly linear, as (C3) does: a collapse is a kink, which passes from
one reading to the next. Residuals that follow one another widen $\delta$ as they widen (C3).

A constant whose draws scatter by more than a factor of e is hardly known, as one that may be zero:
its errors aren't turned round, which would give it values that no fit found, but taken as they lie.

**Assumes** that the law is right but for that error. Which constants are free is not chosen anew.
**Source:** Efron and Tibshirani (1993), chapters 6 and 13.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...core.errors import InvalidInputError
from ..data.grid import Grid, weighed
from ..data.readings import Readings
from ..problem.joint import joined
from ..problem.residuals import Problem
from ..problem.searching import settled
from ..problem.solving import solve
from ..problem.tuned import problem_of
from ..problem.uncertainty import KNOWN
from .calibration import Bootstrap, Calibration, value_of


DRAWS = 199  # of which the 10th from either end are the ends of a 90 % interval
_TAIL = 0.05
_FEWEST = 19


def bootstrap(
    made: Calibration,
    draws: int = DRAWS,
    seed: int = 0,
    tell: Callable[[str], object] = lambda _: None,
) -> Calibration:
    """The same calibration with intervals from a parametric bootstrap of the whole fit.

    **Arguments:**

    - `made`: the calibration [-]; its noise must be normal, so its loss linear.
    - `draws`: how many records are simulated and fitted [-], at least 19.
    - `seed`: of chance [-].
    - `tell`: is told what is being done [-].

    **Returns:** it with `bootstrapped`, which its `parameters` tell [-].

    **Raises:** `ValueError` for a robust loss and too few draws.
    """
    if made.problem.loss != "linear":
        raise InvalidInputError(
            "loss", "must be linear for a bootstrap", None, "a robust one is no model"
        )
    if draws < _FEWEST:
        raise InvalidInputError("draws", f"must be at least {_FEWEST} for a 90 % interval", draws)
    rng, found = np.random.default_rng(seed), []
    for place in range(draws):
        tell(f"bootstrapping, {place + 1} of {draws}")
        z = fitted(made, simulated(made, rng))
        if np.all(np.isfinite(z)):
            found.append(z)
    if len(found) < draws / 2:
        raise InvalidInputError(
            "record", "is one whose simulated likes mostly can't be fitted", None
        )
    z = np.array(found)
    values = np.array([value_of(made.problem, row) for row in z])
    low, high = _ends(made, z, values)
    boots = Bootstrap(made.names, z, values, low, high, draws - len(found))
    return replace(made, bootstrapped=boots)


def simulated(made: Calibration, rng: np.random.Generator) -> Grid:
    """A record of the fitted muscle [-], as the problem's tables hold it; `rng`: chance [-]."""
    data, count = made.problem.data, np.asarray(made.problem.data.count)
    noise = made.seen.noise if made.seen.found else float(made.problem.noise)
    b = rng.standard_normal(made.discrepancy.shape[-1])
    errs = made.discrepancy @ b if b.size else 0.0
    scatter = noise / np.sqrt(np.maximum(count, 1.0)) * rng.standard_normal(count.shape)
    force = np.where(count > 0, made.conclusion.linear.force + errs + scatter, 0.0)
    if not np.any(data.censored):
        return replace(data, force=force)
    floor = np.min(np.asarray(data.force)[np.asarray(data.censored)])  # the gauge's, zero mostly
    clipped = (force <= floor) & (count > 0)
    return replace(data, force=np.where(clipped, floor, force), censored=clipped)


def fitted(made: Calibration, data: Grid) -> np.ndarray:
    """Coordinates [-] that the fit of such `data` [-] finds, begun where the record's own ended."""
    problem, every = made.problem, made.problem.whole(made.coordinates)
    if made.method != "tuning":
        seen = replace(problem, data=data, weight=weighed(data, made.weights))
        return settled(seen, every[None], None)[2][problem.chosen]
    readings, seen = _tuning(made, problem, data)
    found = solve(seen, every[None]).coordinates[0]
    assert made.readings is not None
    if made.readings.alone is not None:
        together = joined(seen, readings, found, weighed(data, made.weights), starts=1)
        if together is not None:
            found = together.coordinates
    return found[problem.chosen]


def _tuning(made: Calibration, problem: Problem, data: Grid) -> tuple[Readings, Problem]:
    return problem_of(
        problem.muscle, data, weighed(data, made.weights), np.asarray(problem.center),
        np.asarray(problem.deviation), problem.parameters, problem.loss, problem.rest_length,
        free=problem.free, pulls=problem.pulls, corrects=problem.corrects,
    )  # fmt: skip


def _ends(made: Calibration, z: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the intervals [SI units], (C15); even in value where a parameter is so told."""
    problem, wide = made.problem, np.sqrt(made.inflation)
    best, fitted = made.coordinates, value_of(made.problem, made.coordinates)
    ranks = [(z.shape[0] + 1) * share for share in (1 - _TAIL, _TAIL)]
    ends, lost = [], np.std(z, axis=0) > KNOWN
    errors = np.sort(z - best, axis=0)
    for rank in ranks:
        at = int(np.clip(round(rank), 1, z.shape[0])) - 1
        away = np.where(lost, -errors[-1 - at], errors[at]) * wide
        end = np.empty(best.size)
        for i, parameter in enumerate(problem.fitted):
            if parameter.linear:
                end[i] = fitted[i] - np.sort(values[:, i] - fitted[i])[at] * wide
            else:
                moved = best - away * (np.arange(best.size) == i)
                end[i] = value_of(problem, moved)[i]
        ends.append(end)
    return ends[0], ends[1]
