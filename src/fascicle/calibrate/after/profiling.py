r"""Profile likelihoods: how much worse the fit gets when a parameter is held elsewhere.

With coordinate $i$ held at $z_i$ all the others are fitted again, and

$$\Delta(z_i) = \min_{z_{j \ne i}} \lVert r \rVert^2 - \min \lVert r \rVert^2 \tag{C4}$$

is a squared number of standard deviations where the problem is nearly linear: 2.71 at the
ends of a 90 % interval. A flat profile is a parameter that the data don't determine; an
uneven one, an interval that isn't symmetric. Readings are held at their values here, so
$\Delta$ is taken in proportion to the part of the variance that remains.

**Source:** Raue et al. (2009).
"""

import itertools
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..problem.solving import solve
from .calibration import Calibration, value_of


CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate


@dataclass(frozen=True, eq=False)
class Profile:
    """A parameter's profile.

    - `name`: the parameter's [-].
    - `value`: where it was held [SI unit of the parameter], rising.
    - `rise`: $\\Delta$ there [-].
    - `low`, `high`: where it crosses 2.71 [the same unit]; infinite if it doesn't.
    """

    name: str
    value: np.ndarray
    rise: np.ndarray
    low: float
    high: float


def profiles(made: Calibration, points: int = 11, reach: float = 3.0) -> tuple[Profile, ...]:
    """The profile of each parameter of a calibration.

    **Arguments:**

    - `made`: the calibration [-].
    - `points`: at how many places each is held [-], odd.
    - `reach`: how far on either side [-], in standard deviations.

    **Returns:** the profiles in the order of the parameters [-].
    """
    steps = np.linspace(-reach, reach, points)
    found = [_walk(made, i, steps) for i in range(len(made.names))]
    # readings are held, and residuals taken for noise: as much more unsure as the fit is of it
    share = np.diag(made.from_noise) / np.diag(made.covariance)
    return tuple(
        Profile(name, held, rise * share[i], *_ends(held, rise * share[i]))
        for i, (name, (held, rise)) in enumerate(zip(made.names, found, strict=True))
    )


def _walk(made: Calibration, which: int, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where a parameter was held [SI unit], and by how much the sum of squares rises [-]."""
    problem, C, z = made.problem, made.covariance, made.coordinates
    place = problem.chosen[which]
    others = np.delete(problem.chosen, which)
    center, deviation = float(problem.center[place]), float(problem.deviation[place])
    # along the fit's own correlations: the others begin where a linear problem has them
    away = steps[:, None] * C[which] / np.sqrt(C[which, which])
    found = solve(problem, problem.whole(z + away), others)
    least = solve(problem, problem.whole(z)[None], np.zeros(0, dtype=int)).cost[0]
    # the likelihood's rise: what the parameter's own prior adds is none of the data's
    own = (np.append(found.coordinates[:, place], z[which]) - center) / deviation
    rise = 2 * (found.cost - least) - own[:-1] ** 2 + own[-1] ** 2
    rows = found.coordinates[:, problem.chosen]
    return np.array([value_of(problem, row)[which] for row in rows]), rise


def _ends(value: np.ndarray, rise: np.ndarray) -> tuple[float, float]:
    """Where a profile first crosses the critical rise on either side of its lowest place."""
    middle = int(np.argmin(rise))
    cross = partial(_crossing, value, rise)
    return cross(range(middle, -1, -1), -np.inf), cross(range(middle, rise.size), np.inf)


def _crossing(value: np.ndarray, rise: np.ndarray, places: range, otherwise: float) -> float:
    for inner, outer in itertools.pairwise(places):
        if rise[outer] > CRITICAL:
            # deviations are nearly linear in the value, their squares are not
            a, b, c = np.sqrt([max(rise[inner], 0.0), rise[outer], CRITICAL])
            share = (c - a) / (b - a)
            return float(value[inner] + share * (value[outer] - value[inner]))
    return otherwise
