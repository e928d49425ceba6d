"""What a fit leaves, as tests of it need it: residuals, what the fit could take up, and where.

A fit makes residuals orthogonal to its own Jacobian; so a trend must be looked for in what is
left of it beside the Jacobian. Priors are rows like readings: a constant that its prior holds has
taken nothing up.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..problem.residuals import Problem
from ..problem.uncertainty import Conclusion


_TOGETHER = 1e-8  # of their size: columns that are one but for rounding
_READ = 0.5  # of a direction's square that lies in readings, for it to be one of them


@dataclass(frozen=True, eq=False)
class Remainder:
    """Residuals of readings that were measured, and where these lie; the k last rows of
    `residual` and `slopes` are the priors'.

    - `residual`: measured less fitted force [N], times the root of how many readings it averages.
    - `slopes`: its Jacobian [N] by the free coordinates, then by the curves of the readings.
    - `weight`: root of how many readings are averaged [-]; 0 for a prior.
    - `strain`, `pressure`, `branch`, `time`, `force`: of each reading, the record's [-], [Pa],
      [-], [s], and the model's [N]; of priors they mean nothing.
    - `level`: of pressure [-].
    """

    residual: np.ndarray
    slopes: np.ndarray
    weight: np.ndarray
    strain: np.ndarray
    pressure: np.ndarray
    branch: np.ndarray
    time: np.ndarray
    force: np.ndarray
    level: np.ndarray

    @property
    def read(self) -> np.ndarray:
        """Which rows are readings [-]."""
        return self.weight > 0

    @property
    def squares(self) -> float:
        """Sum of squares of the readings' residuals [N²]."""
        return float(np.sum(self.residual[self.read] ** 2))

    @cached_property
    def taken(self) -> np.ndarray:
        """An orthonormal basis of what the fit could take up [-]."""
        return span(self.slopes)

    def beyond(self, basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """An orthonormal basis [-] of what of `columns` [any] lies beside an orthonormal `basis`
        [-]. What a constant takes up but for its prior is none of it: that lies in the priors'
        rows.
        """
        Q = span(beside(basis, columns))
        return Q[:, np.sum(Q[self.read] ** 2, axis=0) > _READ]

    def rows(self, values: np.ndarray) -> np.ndarray:
        """`values` [any] at the readings as columns to regress on: weighed, and zero for priors."""
        columns = np.asarray(values, dtype=float).reshape(self.weight.size, -1)
        return np.where(self.read[:, None], columns * self.weight[:, None], 0.0)


def remainder(
    problem: Problem,
    conclusion: Conclusion,
    coordinates: np.ndarray,
    branch: np.ndarray,
    time: np.ndarray,
) -> Remainder:
    """What a fit leaves.

    **Arguments:**

    - `problem`, `conclusion`: of the fit [-].
    - `coordinates`: of all its parameters at the minimum [-].
    - `branch`, `time`: of each place of the problem's tables [-], [s].

    **Returns:** the remainder [-].
    """
    data, found, free = problem.data, conclusion.linear, problem.chosen
    used, shape = np.asarray(data.uncensored), np.shape(data.count)
    noise, k = float(problem.noise), len(problem.parameters)
    columns = np.concatenate([free, np.arange(k, found.slopes.shape[1])])
    mine = np.broadcast_to(np.asarray(data.pressure), shape), np.indices(shape)[0]
    weight = np.sqrt(np.asarray(data.count)[used])
    # outliers stay played down as the loss has them, in a tuning also where it doesn't look
    away = (np.asarray(data.force) - found.force)[used]
    missed = weight * away
    if problem.loss != "linear":
        softened = found.residuals[: used.size].reshape(shape)[used] * noise
        missed = np.where(softened != 0, softened, missed)
    slopes = -weight[:, None] * found.force_slopes[used][:, columns]
    deviation = np.asarray(problem.deviation)[free]
    held = np.zeros((free.size, columns.size))
    held[:, : free.size] = np.diag(noise / deviation)
    pulled = (coordinates[free] - np.asarray(problem.center)[free]) * noise / deviation
    none = np.zeros(free.size)
    return Remainder(
        np.concatenate([missed, pulled]),
        np.concatenate([slopes, held]),
        np.concatenate([weight, none]),
        *(
            np.concatenate([values[used], none])
            for values in (np.asarray(data.strain), mine[0], branch, time, found.force, mine[1])
        ),
    )


def span(columns: np.ndarray) -> np.ndarray:
    """An orthonormal basis of what `columns` [any] span [-]."""
    scale = np.linalg.norm(columns, axis=0)
    some = columns[:, scale > 0] / scale[scale > 0]
    if not some.size:
        return np.zeros((len(columns), 0))
    basis, size, _ = np.linalg.svd(some, full_matrices=False)
    return basis[:, size > _TOGETHER * size[0]]


def beside(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """What of `columns` [any] lies beside the span of an orthonormal `basis` [-]."""
    left = columns - basis @ (basis.T @ columns)
    left = left - basis @ (basis.T @ left)  # once more for what rounding left
    nothing = np.linalg.norm(left, axis=0) < _TOGETHER * np.linalg.norm(columns, axis=0)
    return np.where(nothing, 0.0, left)
