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

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .calibration import Calibration
from .parameters import put, values
from .problem import Problem, Vector
from .solving import solve


CRITICAL = 2.705543454095404  # 90 % of a squared normal deviate
_HELD = 1e-6  # deviation of the prior that holds a coordinate


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
    z, C = jnp.asarray(made.coordinates), jnp.asarray(made.covariance)
    steps = jnp.linspace(-reach, reach, points)
    held, rise = (np.asarray(x) for x in _walk(made.problem, z, C, steps))
    total, curves = np.diag(made.covariance), np.diag(made.from_curves)
    rise = rise * ((total - curves) / total / made.inflation)[:, None]
    return tuple(
        Profile(name, held[i], rise[i], *_ends(held[i], rise[i]))
        for i, name in enumerate(made.names)
    )


@eqx.filter_jit
def _walk(
    problem: Problem, z: Vector, covariance: Array, steps: Array
) -> tuple[Float[Array, "parameter step"], Float[Array, "parameter step"]]:
    """Where each parameter was held, and by how much the sum of squares rises [-]."""
    least = jnp.sum(problem.residuals(z) ** 2)

    def at(place: tuple[Array, Array]) -> tuple[Array, Array]:
        i, step = place
        # along the fit's own correlations: the others begin where a linear problem has them
        away = step * covariance[i] / jnp.sqrt(covariance[i, i])
        held = eqx.tree_at(
            lambda p: (p.center, p.deviation),
            problem,
            (problem.center.at[i].set(z[i] + away[i]), problem.deviation.at[i].set(_HELD)),
        )
        found = solve(held, (z + away)[None]).coordinates[0].at[i].set(z[i] + away[i])
        value = values(problem.parameters, put(problem.parameters, problem.muscle, found))[i]
        # the likelihood's rise: what the parameter's own prior adds is none of the data's
        own = (jnp.stack([found[i], z[i]]) - problem.center[i]) / problem.deviation[i]
        rise = jnp.sum(problem.residuals(found) ** 2) - least - own[0] ** 2 + own[1] ** 2
        return value, rise

    places = jnp.meshgrid(jnp.arange(z.size), steps, indexing="ij")
    value, rise = jax.lax.map(at, tuple(x.reshape(-1) for x in places))
    return value.reshape(z.size, -1), rise.reshape(z.size, -1)


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
