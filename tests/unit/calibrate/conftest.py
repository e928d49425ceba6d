"""Problems that need no muscle's law, so that what is asked of them has a closed form."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array, Float

import fascicle as fs
from fascicle.calibrate.after.calibration import Calibration
from fascicle.calibrate.data.grid import Grid, Table
from fascicle.calibrate.data.taking import taken
from fascicle.calibrate.problem.linear import linear
from fascicle.calibrate.problem.parameters import PARAMETERS
from fascicle.calibrate.problem.residuals import Problem, Vector
from fascicle.calibrate.problem.solving import solve
from fascicle.calibrate.problem.uncertainty import Conclusion
from fascicle.records.record import Record


SIZES = (0.127, 6.35e-3, 1.6e-3, np.radians(33))
NAMES = ("youngs_modulus_factor", "collapse_moment_factor")


class Straight(Problem):
    """A problem whose force is linear in its coordinates: X z."""

    design: Float[Array, "level reading parameter"] | None = None

    def force(self, coordinates: Vector) -> Table:
        """X z."""
        return self.design @ coordinates


@pytest.fixture(scope="session")
def straight():
    """`straight(levels, readings, noise, seed)`: a calibration with a straight law, two
    coordinates that are known by the data, and the priors' deviation.
    """

    def make(levels=4, readings=10, sigma=0.3, seed=0, prior=3.0, weight=None, censored=None):
        rng = np.random.default_rng(seed)
        X = rng.normal(size=(levels, readings, 2)) + np.array([1.0, 0.5])
        truth = np.array([0.2, -0.4])
        F = X @ truth + sigma * rng.normal(size=(levels, readings))
        P = 1e5 * np.arange(1, levels + 1)[:, None]
        clipped = np.zeros(F.shape, bool) if censored is None else censored
        F = np.where(clipped, 0.0, F)  # as a gauge that clips at zero writes it
        data = Grid(
            jnp.asarray(P), jnp.zeros(F.shape), jnp.asarray(F), jnp.ones(F.shape),
            jnp.asarray(clipped),
        )  # fmt: skip
        muscle = fs.Muscle.from_dimensions(*SIZES)
        weight = np.ones(F.shape) if weight is None else weight
        problem = Straight(
            muscle, data, jnp.asarray(weight), jnp.asarray(sigma), jnp.zeros(2),
            prior * jnp.ones(2), None, None, tuple(PARAMETERS[name] for name in NAMES),
            design=jnp.asarray(X),
        )  # fmt: skip
        solutions = solve(problem, np.zeros((1, 2)))
        z = solutions.coordinates[0]
        rows = X[~clipped] * (weight[~clipped] / sigma)[:, None]
        covariance = np.linalg.inv(rows.T @ rows + np.eye(2) / prior**2)
        found, none = linear(problem, z), np.zeros((2, 2))
        record = Record.of(np.broadcast_to(P, F.shape), np.zeros(F.shape), F, clipped)
        of = taken(record)
        return Calibration(
            muscle=problem.muscle_at(jnp.asarray(z)),
            start=muscle,
            # in the shape of the problem, which no table of a fit's has
            taken=replace(of, gathered=replace(of.gathered, data=data)),
            method="constants",
            problem=problem,
            coordinates=z,
            covariance=covariance,
            from_curves=none,
            from_trends=none,
            readings=None,
            conclusion=Conclusion(covariance, none, sigma, found, found.misfits),
            force=found.force,
            free_strain=np.zeros(levels),
            solutions=solutions,
            inflation=1.0,
        )

    return make
