r"""The paper's tuning: readings give $C_1$, $C_2$, and least squares the factors.

Where the muscle pulls, the tension law is corrected to the blocked force and the free
strain that were read (`readings`). Where it resists, past the free strain so found, the
factors on $E$, on the collapse moment and on the hinge's stiffness and the rate $\beta$ are
fitted to all pressures at once (`problem`). The two use different readings, so the
uncertainty of the first carries over to the second without being counted twice.

All of it is one pure function of the forces: it can be compiled once, and batched over
many records of one protocol.

**Source:** Kim, Mazzoleni and Bryant (2021), section 5.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..muscle import Muscle
from .grid import Grid, Table
from .parameters import Parameter
from .problem import Problem, Vector
from .readings import Readings, free_strain_deviation, free_strain_of, read
from .solving import Solutions, solve
from .uncertainty import Conclusion, conclude


_CLEAR = 2.0  # deviations of the free strain


class Tuned(eqx.Module):
    """What the tuning found: readings, problem, solutions, and what holds at the best."""

    readings: Readings
    problem: Problem
    solutions: Solutions
    coordinates: Vector
    conclusion: Conclusion


def problem_of(
    muscle: Muscle,
    data: Grid,
    weight: Table,
    center: Vector,
    deviation: Vector,
    parameters: tuple[Parameter, ...],
    loss: str,
) -> tuple[Readings, Problem]:
    """The readings of `data` [-] and the problem that remains past the free strain.

    **Arguments:**

    - `muscle`: to begin with [-]; its own tuning's tables are replaced.
    - `data`: strains refer to the muscle's length [-].
    - `weight`: of each reading's residual [-].
    - `center`, `deviation`: of the prior on each coordinate [-].
    - `parameters`: those that are free [-].
    - `loss`: one of `LOSSES` [-].

    **Returns:** both [-].
    """
    readings = read(muscle, data)
    free = free_strain_of(muscle, readings.coefficients, readings.pressure)
    # nearer to the free strain than its own error a reading may belong to either side
    free = free + _CLEAR * free_strain_deviation(muscle, readings)
    # a gauge that never shows a push has measured nothing there: what it clipped says no more
    force = jnp.where(data.uncensored, data.force, 0.0)
    pulls_only = jnp.any((data.count > 0) & data.censored) & (jnp.min(force) >= 0)
    resists = weight * (data.strain > free[:, None]) * ~pulls_only
    problem = Problem(
        muscle, data, resists, readings.noise, center, deviation, None, readings.coefficients,
        parameters, loss,
    )  # fmt: skip
    return readings, problem


@eqx.filter_jit
def tune(
    muscle: Muscle,
    data: Grid,
    weight: Table,
    center: Vector,
    deviation: Vector,
    starts: Float[Array, "start parameter"],
    noise: Float[Array, ""],
    parameters: tuple[Parameter, ...],
    loss: str = "linear",
) -> Tuned:
    """The whole tuning.

    **Arguments:** as `problem_of`, and

    - `starts`: coordinates to begin from [-].
    - `noise`: of a reading [N] past the free strain; 0 for the one that the readings show.

    **Returns:** a `Tuned` [-].
    """
    readings, problem = problem_of(muscle, data, weight, center, deviation, parameters, loss)
    known = jnp.where(noise > 0, noise, problem.noise)
    problem = eqx.tree_at(lambda p: p.noise, problem, known)
    solutions = solve(problem, starts)
    z = solutions.coordinates[solutions.best]
    return Tuned(readings, problem, solutions, z, conclude(problem, z, readings.covariance))


def left_out(problem: Problem, z: Vector, level: Array) -> Float[Array, "reading"]:
    """Errors [N] at a `level` [-] of pressure of a tuning that did not see it, begun from the
    coordinates `z` [-] of the one that did; `problem` is that one's [-].
    """
    data = problem.data
    unseen = (jnp.arange(data.count.shape[0]) == level)[:, None]
    seen = eqx.tree_at(lambda d: d.count, data, jnp.where(unseen, 0.0, data.count))
    _, without = problem_of(
        problem.muscle, seen, jnp.ones_like(data.count), problem.center, problem.deviation,
        problem.parameters, problem.loss,
    )  # fmt: skip
    again = solve(without, z[None]).coordinates[0]
    return (data.force - without.force(again))[level]
