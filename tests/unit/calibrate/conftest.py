"""Problems that need no muscle's law, so that what is asked of them has a closed form."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.calibrate.calibration import Calibration
from fascicle.calibrate.data import Grid, select_fit_data
from fascicle.calibrate.diagnostics import Diagnosis
from fascicle.calibrate.findings import calibration_findings
from fascicle.calibrate.least_squares import Minimum, Problem, linearize, solve
from fascicle.calibrate.parameters import PARAMETERS
from fascicle.records.record import Record


SIZES = (0.127, 6.35e-3, 1.6e-3, np.radians(33))
NAMES = ("youngs_modulus_factor", "collapse_moment_factor")


@dataclass(frozen=True, eq=False)
class Straight(Problem):
    """A problem whose force is linear in its coordinates: X z."""

    design: np.ndarray | None = None

    def reading_forces(self, point):
        """X z."""
        forces = self.design[self.grid.used] @ point
        return forces.T if point.ndim > 1 else forces


@pytest.fixture(scope="session")
def found():
    """`found(calibration)`: data of its findings by code."""

    def by_code(calibration):
        return {finding.code: finding.data for finding in calibration_findings(calibration)}

    return by_code


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
        grid = Grid(P, np.zeros(F.shape), F, np.ones(F.shape), clipped)
        muscle = fs.Muscle(*SIZES)
        weight = np.ones(F.shape) if weight is None else weight
        problem = Straight(
            muscle, grid, weight, sigma, np.zeros(2), prior * np.ones(2),
            tuple(PARAMETERS[name] for name in NAMES), design=X,
        )  # fmt: skip
        solutions = solve(problem, np.zeros((1, 2)))
        z = solutions.points[0]
        rows = X[~clipped] * (weight[~clipped] / sigma)[:, None]
        covariance = np.linalg.inv(rows.T @ rows + np.eye(2) / prior**2)
        record = Record.of(np.broadcast_to(P, F.shape), np.zeros(F.shape), F, clipped)
        return Calibration(
            muscle=problem.muscle_at(z),
            start=muscle,
            fit_data=replace(select_fit_data(record), grid=grid),
            problem=problem,
            coordinates=z,
            readings=None,
            minimum=Minimum(covariance, np.zeros((2, 2)), sigma, sigma, linearize(problem, z)),
            free_strain=np.zeros(levels),
            solutions=solutions,
            diagnosis=Diagnosis(),
        )

    return make
