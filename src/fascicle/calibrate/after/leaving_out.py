"""What a fit says of readings that it did not see: it is repeated without them.

Pressures are left out one by one, or a few neighbors at a time where there are many; where there
are too few to interpolate between, stretches of strain are.
"""

from dataclasses import replace

import numpy as np

from ..data.grid import Grid
from ..problem.linear import linear
from ..problem.residuals import Problem
from ..problem.solving import ROUGH, solve
from ..problem.tuned import left_out
from .calibration import Calibration


_MOST = 24  # pressures that are left out one by one
_PARTS = 8  # parts that more pressures than these are left out in: each is a refit
_FEW = 3  # pressures; of fewer none can be left out
_STRETCHES = 6


def left_out_errors(made: Calibration) -> np.ndarray:
    """Errors [N] at each place of a calibration's `data` of fits that did not see it; NaN where
    it is clipped, or couldn't be left out.
    """
    force = left_out_force(made)
    return np.where(made.data.uncensored, np.asarray(made.data.force) - force, np.nan)


def left_out_force(made: Calibration) -> np.ndarray:
    """Forces [N] at each place of a calibration's `data` of fits that did not see it."""
    problem, every = made.problem, made.problem.whole(made.coordinates)
    whole = made.readings is not None and made.readings.alone is not None
    force = np.full(problem.data.uncensored.shape, np.nan)
    for fold in folds(problem.data):
        if made.method == "tuning":
            force[fold] = left_out(problem, every, fold, made.weights, whole)[fold]
        else:
            force[fold] = without(problem, every, fold)[fold]
    rows, columns = made.force.shape
    return force[:rows, :columns]


def without(problem: Problem, coordinates: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """Forces [N] everywhere of a fit that did not see the places in a `fold` [-], begun from the
    `coordinates` [-] of all parameters of the one that did.
    """
    weight = np.where(fold, 0.0, np.asarray(problem.weight))
    seen = replace(problem, weight=weight)
    again = solve(seen, coordinates[None], little=ROUGH).coordinates[0]
    return linear(problem, again).force


def folds(data: Grid) -> list[np.ndarray]:
    """Parts of `data` [-] to leave out, as masks of its places; each has something measured."""
    measured, levels = data.uncensored, _levels(data)
    if levels.size >= _FEW:
        rows = np.arange(len(measured))[:, None]
        parts = np.array_split(levels, levels.size if levels.size <= _MOST else _PARTS)
        return [np.isin(rows, part) & (np.asarray(data.count) > 0) for part in parts]
    strain = np.asarray(data.strain)
    ends = np.quantile(strain[measured], np.linspace(0, 1, _STRETCHES + 1))
    place = np.clip(np.searchsorted(ends, strain, "right") - 1, 0, _STRETCHES - 1)
    parts = [(place == part) & (np.asarray(data.count) > 0) for part in range(_STRETCHES)]
    return [part for part in parts if np.any(part & measured)]


def parts(data: Grid) -> str:
    """What of `data` [-] is left out in turn, in words [-]."""
    return "pressures" if _levels(data).size >= _FEW else "stretches of strain"


def _levels(data: Grid) -> np.ndarray:
    return np.flatnonzero(data.uncensored.any(axis=1))
