"""What a calibration found, with how sure it is and what the data could not tell."""

from dataclasses import dataclass, field

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..muscle import Muscle
from ..records.record import Record
from .parameters import WEAK, Parameter, put, values
from .problem import Problem
from .readings import Readings
from .solving import Solutions
from .uncertainty import KNOWN, NORMAL, Conclusion


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: its value and 90 % interval [SI unit of the dimension].

    `start`: where its prior is centered. `identifiable`: whether the data alone know it.
    `deviation`: of its coordinate [-].
    """

    name: str
    dimension: str
    about: str
    value: float
    low: float
    high: float
    start: float
    deviation: float
    identifiable: bool


@dataclass(frozen=True, eq=False)
class Calibration:
    """A muscle that was fitted to a record.

    - `muscle`: the fitted one [-].
    - `start`: the muscle that the fit began with [-].
    - `record`: what was measured [-].
    - `method`: "tuning", the paper's, or "constants" [-].
    - `problem`: the least-squares problem [-], its noise that of the residuals.
    - `coordinates`: of the parameters at the minimum [-].
    - `covariance`: theirs [-].
    - `from_curves`: the part of it that blocked forces and free strains cause [-].
    - `readings`: those, or `None` [-].
    - `conclusion`: what holds at the minimum [-].
    - `force`: the fitted muscle's at each place of the problem's grid [N].
    - `solutions`: where each start ended [-].
    - `inflation`: of the covariance, for residuals that follow one another [-].
    - `warnings`: what to know before using it, a line each [-].
    """

    muscle: Muscle
    start: Muscle
    record: Record
    method: str
    problem: Problem
    coordinates: np.ndarray
    covariance: np.ndarray
    from_curves: np.ndarray
    readings: Readings | None
    conclusion: Conclusion
    force: np.ndarray
    solutions: Solutions
    inflation: float
    warnings: tuple[str, ...] = field(default=())

    @property
    def names(self) -> tuple[str, ...]:
        """The fitted parameters' names [-]."""
        return tuple(parameter.name for parameter in self.problem.parameters)

    @property
    def parameters(self) -> tuple[Estimate, ...]:
        """The fitted parameters, in the order of the covariance [-]."""
        return estimates(self.problem, self.coordinates, self.covariance)

    @property
    def correlation(self) -> np.ndarray:
        """Correlations of the coordinates [-]."""
        scale = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(scale, scale)

    @property
    def residual(self) -> np.ndarray:
        """Measured less fitted force [N] where it was measured, NaN elsewhere."""
        data = self.problem.data
        return np.where(np.asarray(data.uncensored), np.asarray(data.force) - self.force, np.nan)

    @property
    def points(self) -> int:
        """Readings that were compared [-], an average counted as one."""
        return int(np.sum(np.asarray(self.problem.data.count) > 0))

    @property
    def censored(self) -> int:
        """Readings of these that only say "not above" [-]."""
        data = self.problem.data
        return int(np.sum((np.asarray(data.count) > 0) & np.asarray(data.censored)))

    @property
    def rmse(self) -> float:
        """Root mean square of the residuals [N], censored readings left out."""
        return root_mean_square(self.residual, np.asarray(self.problem.data.count))

    @property
    def relative_rmse(self) -> float:
        """That over the largest force that was measured [-]."""
        return self.rmse / largest_force(self.problem)

    @property
    def status(self) -> str:
        """How the best start ended, in words [-]."""
        from .solving import in_words

        return in_words(self.solutions)[int(self.solutions.best)].split(": ", 1)[1]

    @property
    def starts(self) -> list[str]:
        """How each start ended, in words [-]."""
        from .solving import in_words

        return in_words(self.solutions)

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Coordinates drawn from the fit's normal approximation [-], one row a draw.

        Those that the data don't determine are kept at their fitted value: drawn from their
        prior they would only say that nothing is known.
        """
        known = np.array([one.identifiable for one in self.parameters])
        covariance = np.where(np.outer(known, known), self.covariance, 0.0)
        spread, basis = np.linalg.eigh(covariance)
        normal = np.random.default_rng(seed).normal(size=(count, known.size))
        return self.coordinates + normal @ (basis * np.sqrt(np.maximum(spread, 0))).T


def estimates(
    problem: Problem, coordinates: np.ndarray, covariance: np.ndarray
) -> tuple[Estimate, ...]:
    """Each parameter with its interval.

    **Arguments:**

    - `problem`: that was solved [-].
    - `coordinates`: at its minimum [-].
    - `covariance`: theirs [-].

    **Returns:** the estimates in the problem's order [-].
    """
    z, C = np.asarray(coordinates), np.asarray(covariance)
    deviations = np.sqrt(np.diag(C))
    away = NORMAL * np.diag(deviations)
    rows = np.concatenate([[z, np.asarray(problem.center)], z - away, z + away])
    at, jacobian = (np.asarray(x) for x in _values(problem, jnp.asarray(rows)))
    (found, start), k = at[:2], z.size
    low, high = np.diag(at[2 : 2 + k]), np.diag(at[2 + k :])
    even = NORMAL * np.sqrt(np.einsum("ij,jk,ik->i", jacobian[0], C, jacobian[0]))
    out = []
    for i, parameter in enumerate(problem.parameters):
        ends = (found[i] - even[i], found[i] + even[i]) if parameter.linear else (low[i], high[i])
        known = identifiable(parameter, deviations[i], float(problem.deviation[i]))
        out.append(
            Estimate(
                parameter.name, parameter.dimension, parameter.about, float(found[i]),
                float(ends[0]), float(ends[1]), float(start[i]), float(deviations[i]), known,
            )
        )  # fmt: skip
    return tuple(out)


def identifiable(parameter: Parameter, deviation: float, prior: float) -> bool:
    """Whether the data alone, a `prior` deviation [-] taken off, know a coordinate of this
    `deviation` [-] within a factor of e.
    """
    information = 1 / deviation**2 - 1 / prior**2
    known = KNOWN * parameter.deviation / WEAK
    return bool(information > 1 / known**2)


def largest_force(problem: Problem) -> float:
    """The largest force that was measured [N]."""
    data = problem.data
    return float(np.max(np.where(np.asarray(data.uncensored), np.asarray(data.force), -np.inf)))


def root_mean_square(residual: np.ndarray, count: np.ndarray) -> float:
    """Of residuals [N] that stand for `count` readings each [-]; NaN ones are left out."""
    used = np.isfinite(residual)
    return float(np.sqrt(np.average(residual[used] ** 2, weights=count[used])))


def follows(residual: np.ndarray) -> float:
    """How much wider residuals [-] that follow one another make a variance [-].

    1 unless the correlation from one to the next is more than chance allows.
    """
    pairs, total = 0.0, float(np.nansum(residual**2))
    count = int(np.sum(np.isfinite(residual)))
    for row in residual:
        used = row[np.isfinite(row)]
        pairs += float(np.sum(used[1:] * used[:-1]))
    rho = min(max(pairs / total if total > 0 else 0.0, 0.0), 0.99)
    return (1 + rho) / (1 - rho) if rho > 3 / np.sqrt(max(count, 1)) else 1.0


@eqx.filter_jit
def _values(problem: Problem, rows: jax.Array) -> tuple[jax.Array, jax.Array]:
    def of(z: jax.Array) -> jax.Array:
        return values(problem.parameters, put(problem.parameters, problem.muscle, z))

    return jax.vmap(of)(rows), jax.vmap(jax.jacfwd(of))(rows)
