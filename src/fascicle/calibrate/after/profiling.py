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
from collections.abc import Collection
from dataclasses import replace
from functools import partial

import numpy as np

from ..problem.parameters import WEAK
from ..problem.solving import solve
from ..problem.uncertainty import KNOWN, NORMAL
from .calibration import Calibration, Profile, value_of
from .warned import warned


CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_POINTS, _REACH = 11, 3.0  # of a profile, where nobody says otherwise


def with_profiles(made: Calibration) -> Calibration:
    """The calibration with profiles of those parameters whose quick interval says nothing.

    **Arguments:** `made`: the calibration [-].

    **Returns:** the same, with better intervals and what follows from them [-].
    """
    names = [one.name for one in made.parameters if not one.identifiable]
    if not names or made.bootstrapped is not None:
        return made
    made = replace(made, profiles=profiles(made, names=names))
    return replace(made, warned=warned(made))


def profiles(
    made: Calibration,
    points: int = _POINTS,
    reach: float = _REACH,
    names: Collection[str] | None = None,
) -> tuple[Profile, ...]:
    """The profile of each parameter of a calibration.

    **Arguments:**

    - `made`: the calibration [-]; profiles that it has already are not computed again.
    - `points`: at how many places each is held [-], odd.
    - `reach`: how far on either side [-], in standard deviations.
    - `names`: of these parameters [-]; left out, all.

    **Returns:** the profiles in the order of the parameters [-].
    """
    steps = np.linspace(-reach, reach, points)
    # readings are held, and residuals taken for noise: as much more unsure as the fit is of it
    share = np.diag(made.from_noise) / np.diag(made.covariance)
    same_places = (points, reach) == (_POINTS, _REACH)
    walked = {one.name: one for one in made.profiles} if same_places else {}
    out = []
    for i, name in enumerate(made.names):
        if names is not None and name not in names:
            continue
        if name in walked:
            out.append(walked[name])
        else:
            value, coordinate, rise = _walk(made, i, steps)
            rise = rise * share[i]
            span = np.ptp(_ends(coordinate, rise))
            factor = made.problem.fitted[i].deviation / WEAK  # coordinates of a factor of e
            known = bool(span < 2 * NORMAL * KNOWN * factor)
            out.append(Profile(name, value, rise, *_ends(value, rise), known))
    return tuple(out)


def _walk(
    made: Calibration, which: int, steps: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where a parameter was held [SI unit], its coordinate [-], and by how much the sum of squares
    rises [-].
    """
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
    values = np.array([value_of(problem, row)[which] for row in rows])
    return values, found.coordinates[:, place], rise


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
