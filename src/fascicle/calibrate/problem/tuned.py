r"""The paper's tuning: readings give $C_1$, $C_2$, and least squares the factors.

Where the muscle pulls, the tension law is corrected to the blocked force and the free
strain that were read (`readings`). Where it resists, past the free strain so found, the
factors on $E$, on the collapse moment and on the hinge's stiffness and the rate $\beta$ are
fitted to all pressures at once (`problem`). The two use different readings, so the
uncertainty of the first carries over to the second without being counted twice.

**Source:** Kim, Mazzoleni and Bryant (2021), section 5.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...muscle import Muscle
from ..data.grid import Grid, weighed
from ..data.readings import Readings, read, smooth_free_strain
from .joint import joined
from .linear import linear
from .parameters import Parameter
from .residuals import Problem
from .solving import ROUGH, solve


_CLEAR = 2.0  # deviations of the free strain


def problem_of(
    muscle: Muscle,
    data: Grid,
    weight: np.ndarray,
    center: np.ndarray,
    deviation: np.ndarray,
    parameters: tuple[Parameter, ...],
    loss: str,
    rest_length: Any = None,
    **more: Any,
) -> tuple[Readings, Problem]:
    """The readings of `data` [-] and the problem that remains past the free strain.

    **Arguments:**

    - `muscle`: to begin with [-]; its own tuning's tables are replaced.
    - `data`: strains refer to the muscle's length [-].
    - `weight`: of each reading's residual [-].
    - `center`, `deviation`: of the prior on each coordinate [-].
    - `parameters`: those that are free [-].
    - `loss`: one of `LOSSES` [-].
    - `rest_length`: that of the muscle [m], where another fit of the record needs one.
    - `more`: further fields of the problem [-].

    **Returns:** both [-].
    """
    readings = read(muscle, data)
    free, deviates = smooth_free_strain(muscle, readings)
    # nearer to the free strain than its own error a reading may belong to either side
    free = free + _CLEAR * deviates
    # a gauge that never shows a push has measured nothing there: what it clipped says no more
    count, censored = np.asarray(data.count), np.asarray(data.censored)
    force = np.where((count > 0) & ~censored, np.asarray(data.force), 0.0)
    pulls_only = bool(np.any((count > 0) & censored) and np.min(force) >= 0)
    resists = weight * (np.asarray(data.strain) > free[:, None]) * (not pulls_only)
    problem = Problem(
        muscle, data, resists, np.asarray(readings.noise), center, deviation, rest_length,
        readings.coefficients, parameters, loss,
        **more,
    )  # fmt: skip
    return readings, problem


def left_out(
    problem: Problem, coordinates: np.ndarray, fold: np.ndarray, weights: str, whole: bool = False
) -> np.ndarray:
    """Forces [N] everywhere of a tuning that did not see the places in a `fold` [-], begun from
    the `coordinates` [-] of the one that did; `problem` and `weights` are that one's [-]; whether
    its curves and factors were one vector, `whole` [-].
    """
    data = problem.data
    seen = replace(data, count=np.where(fold, 0.0, np.asarray(data.count)))
    readings, without = problem_of(
        problem.muscle, seen, weighed(seen, weights), np.asarray(problem.center),
        np.asarray(problem.deviation),
        problem.parameters, problem.loss, problem.rest_length, free=problem.free,
        pulls=problem.pulls, corrects=problem.corrects,
    )  # fmt: skip
    again = solve(without, coordinates[None], little=ROUGH).coordinates[0]
    together = None
    if whole:
        together = joined(without, readings, again, weighed(seen, weights), starts=1)
    if together is not None:
        without, again = together.problem, together.coordinates
    return linear(without, again).force
