"""What a calibration found, with how sure it is and what the data could not tell."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ...muscle import Muscle
from ...records.hysteresis import Loop, averaged, loop_of
from ...records.record import Record
from ...repr_table import with_table_repr
from ...units import pretty
from ..data.grid import Grid, trimmed
from ..data.readings import Readings
from ..data.taking import Taken, floor_of
from ..problem.parameters import WEAK, Parameter, put, values
from ..problem.residuals import Problem
from ..problem.solving import Solutions
from ..problem.uncertainty import KNOWN, NORMAL, Conclusion
from .causes import Cause
from .friction import Friction, friction_of
from .printing import sheet
from .trends import Looked


_MOST_DIGITS = 12  # of a printed interval: float64 has no more to tell
_AS_CHOSEN = ", of these constants, which are not chosen anew"


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: its value and 90 % interval [SI unit of the dimension].

    `start`: where its prior is centered. `identifiable`: whether the data alone know it.
    `deviation`: of its coordinate [-]. `bound`: where the data give one end of the interval alone,
    "upper" or "lower" [-].
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
    bound: str = ""

    def texts(self) -> tuple[str, str]:
        """Value and 90 % interval for people [-], with digits enough to tell them apart."""
        width = self.high - self.low
        size = max(abs(self.value), abs(self.low), abs(self.high))
        digits = 3 if not 0 < width < size else 2 + math.ceil(math.log10(size / width))
        digits = min(max(digits, 3), _MOST_DIGITS)
        several = max(digits, 4)
        # an end nearer than half of its last digit, once rounded, may lie past the value
        if min(self.value - self.low, self.high - self.value) < 5 * 10.0**-digits * size:
            digits = several
        low, high = (pretty(x, self.dimension, digits) for x in (self.low, self.high))
        return pretty(self.value, self.dimension, several), f"{low} to {high}"

    @property
    def verdict(self) -> str:
        """How well the data know it, in words [-]; empty where they do."""
        if self.identifiable:
            return ""
        return f"{self.bound} limit only" if self.bound else "not known"


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """What fits of simulated records found (`bootstrap`).

    - `names`: of the parameters [-].
    - `coordinates`, `values`: a row for each draw [-], [SI unit of each parameter].
    - `low`, `high`: ends of each parameter's 90 % interval [SI unit], (C15).
    - `failed`: draws whose fit broke [-].
    """

    names: tuple[str, ...]
    coordinates: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    failed: int


@with_table_repr(sheet)
@dataclass(frozen=True, eq=False)
class Calibration:
    """A muscle that was fitted to a record.

    - `muscle`: the fitted one [-].
    - `start`: the muscle that the fit began with [-].
    - `taken`: what of the record was fitted, and what became of the rest [-].
    - `method`: "tuning", the paper's, or "constants" [-].
    - `problem`: the least-squares problem [-], its noise that of the residuals.
    - `coordinates`: of the fitted parameters at the minimum [-].
    - `covariance`: theirs [-].
    - `from_curves`: the part of it that blocked forces and free strains cause [-].
    - `from_trends`: the part that the model's own error causes [-].
    - `readings`: blocked forces and free strains, or `None` [-].
    - `conclusion`: what holds at the minimum, as far as noise goes [-].
    - `force`: the fitted muscle's at each place of `data` [N].
    - `free_strain`: the fitted muscle's at each level of `data` [-].
    - `solutions`: where each start ended [-].
    - `inflation`: of the covariance that noise causes, for residuals that follow one another [-].
    - `seen`: trends and runs in the residuals [-]; `causes` that would explain them.
    - `untold`: constants that weren't fitted, and that the data could not tell [-].
    - `discrepancy`: the model's own error that these tell of: columns [N] at the places of the
      problem's tables, each to be taken a standard normal deviate times [-].
    - `weights`: how levels count [-].
    - `warned`: what to know before using it: lines, by what they are about [-].
    - `bootstrapped`: fits of simulated records, whose intervals `parameters` then have; `None`:
      these are the quick ones of (C3) [-].
    - `profiles`: of the parameters whose quick interval says nothing, by name [-]: their ends
      are the better ones.
    """

    muscle: Muscle
    start: Muscle
    taken: Taken
    method: str
    problem: Problem
    coordinates: np.ndarray
    covariance: np.ndarray
    from_curves: np.ndarray
    from_trends: np.ndarray
    readings: Readings | None
    conclusion: Conclusion
    force: np.ndarray
    free_strain: np.ndarray
    solutions: Solutions
    inflation: float
    seen: Looked = field(default_factory=Looked)
    causes: tuple[Cause, ...] = field(default=())
    untold: tuple[str, ...] = field(default=())
    discrepancy: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 0)))
    weights: str = "uniform"
    warned: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    bootstrapped: Bootstrap | None = None
    profiles: tuple["Profile", ...] = ()

    @property
    def record(self) -> Record:
        """The readings that were fitted [-]."""
        return self.taken.record

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before using it, a line each [-]."""
        return tuple(line for lines in self.warned.values() for line in lines)

    @cached_property
    def data(self) -> Grid:
        """What was fitted by level of pressure [-], without the rows that hold nothing."""
        return trimmed(self.problem.data)

    @property
    def names(self) -> tuple[str, ...]:
        """The fitted parameters' names [-]."""
        return tuple(parameter.name for parameter in self.problem.fitted)

    @cached_property
    def parameters(self) -> tuple[Estimate, ...]:
        """The fitted parameters, in the order of the covariance [-]."""
        quick, boots = estimates(self.problem, self.coordinates, self.covariance), self.bootstrapped
        if boots is None:
            ends = {profile.name: profile for profile in self.profiles}
            return tuple(_with_profile(one, ends.get(one.name)) for one in quick)
        known = np.std(boots.coordinates, axis=0) < KNOWN
        return tuple(
            replace(one, low=float(low), high=float(high),
                    identifiable=one.identifiable and bool(told or of.linear))
            for one, of, low, high, told in
            zip(quick, self.problem.fitted, boots.low, boots.high, known, strict=True)
        )  # fmt: skip

    @property
    def intervals(self) -> str:
        """How `parameters` came to their 90 % intervals, in words [-]."""
        boots = self.bootstrapped
        if boots is None:
            by = ", by profile where that says more" if self.profiles else ""
            return f"quick, by the linear (C3){by}{_AS_CHOSEN}; --intervals bootstrap simulates"
        failed = f", {boots.failed} more broke" if boots.failed else ""
        draws = f"{len(boots.values)} draws{failed}"
        return f"parametric bootstrap of the whole fit, {draws}{_AS_CHOSEN}"

    @property
    def correlation(self) -> np.ndarray:
        """Correlations of the coordinates [-]."""
        scale = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(scale, scale)

    @property
    def from_noise(self) -> np.ndarray:
        """The part of the covariance that noise causes, as if residuals were that [-]."""
        return (self.covariance - self.from_curves - self.from_trends) / self.inflation

    @property
    def wider(self) -> np.ndarray:
        """How much wider each interval is than noise alone makes it [-], for what residuals
        show beside it.
        """
        noise = np.diag(self.from_noise) + np.diag(self.from_curves)
        return np.sqrt(np.diag(self.covariance) / noise)

    @property
    def residual(self) -> np.ndarray:
        """Measured less fitted force [N] where it was measured, NaN elsewhere."""
        data = self.data
        return np.where(np.asarray(data.uncensored), np.asarray(data.force) - self.force, np.nan)

    @cached_property
    def errors(self) -> np.ndarray:
        """Measured less fitted force of each of the record's readings [N], NaN where clipped."""
        return self.taken.errors(self.force, np.asarray(trimmed(self.taken.data).strain))

    @cached_property
    def loop(self) -> Loop | None:
        """How wide the record's hysteresis loops are [-], `None` where it doesn't hold both ways;
        half of that is in the errors of such a record's readings.
        """
        return loop_of(self.record)

    @cached_property
    def half_way_rmse(self) -> float:
        """Root mean square error [N] against the mean of both branches, where the record holds
        both; NaN elsewhere.
        """
        if self.loop is None:
            return float("nan")
        half_way = averaged(self.record)
        both = np.isfinite(half_way.width) & ~half_way.record.censored
        readings = half_way.record.only(both)
        length, rest = float(self.muscle.length), self.record.rest_length
        strain = readings.strain * (1.0 if rest is None else rest / length)
        force = np.asarray(self.muscle.force(readings.pressure, strain))
        return float(np.sqrt(np.mean((readings.force - force) ** 2)))

    @cached_property
    def friction(self) -> Friction | None:
        """Springs that slip, fitted to these loops [-], `None` where there are none; the fitted
        muscle is as it is without.
        """
        length = self.record.rest_length
        return friction_of(self.record, float(self.muscle.length) if length is None else length)

    @property
    def points(self) -> int:
        """Readings that were fitted [-], each of an average counted."""
        return len(self.record)

    @property
    def censored(self) -> int:
        """Readings of these that only say "not above" [-]."""
        return self.taken.clipped

    @property
    def floor(self) -> str:
        """Force at which readings are clipped, in words [-]."""
        return floor_of(self.record)

    @property
    def rmse(self) -> float:
        """Root mean square error of all readings [N], censored ones left out."""
        return float(np.sqrt(np.nanmean(self.errors**2)))

    @property
    def relative_rmse(self) -> float:
        """That over the largest force that was measured [-]."""
        return self.rmse / largest_force(self.record)

    @property
    def status(self) -> str:
        """How the best start ended, in words [-]."""
        from ..problem.solving import in_words

        return in_words(self.solutions)[int(self.solutions.best)].split(": ", 1)[1]

    @property
    def starts(self) -> list[str]:
        """How each start ended, in words [-]."""
        from ..problem.solving import in_words

        return in_words(self.solutions)

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Coordinates drawn from the fit's normal approximation [-], one row a draw; `count`: how
        many [-], `seed`: of chance [-].

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
    if not problem.fitted:
        return ()
    z, C = np.asarray(coordinates), np.asarray(covariance)
    deviations = np.sqrt(np.diag(C))
    center, prior = (np.asarray(x)[problem.chosen] for x in (problem.center, problem.deviation))
    found, start = value_of(problem, z), value_of(problem, center)
    out = []
    for i, (parameter, deviation) in enumerate(zip(problem.fitted, deviations, strict=True)):
        away = NORMAL * deviation * (np.arange(z.size) == i)
        ends = [value_of(problem, z + side * away)[i] for side in (-1, 1)]
        if parameter.linear:
            slope = slope_of(problem, z)[i]
            even = NORMAL * np.sqrt(slope @ C @ slope)
            ends = [found[i] - even, found[i] + even]
        known = identifiable(parameter, deviation, float(prior[i]))
        out.append(
            Estimate(
                parameter.name, parameter.dimension, parameter.about, float(found[i]),
                float(ends[0]), float(ends[1]), float(start[i]), float(deviation), known,
            )
        )  # fmt: skip
    return tuple(out)


@dataclass(frozen=True, eq=False)
class Profile:
    """A parameter's profile.

    - `name`: the parameter's [-].
    - `value`: where it was held [SI unit of the parameter], rising.
    - `rise`: $\\Delta$ there [-].
    - `low`, `high`: where it crosses 2.71 [the same unit]; infinite if it doesn't.
    - `known`: whether both ends lie within a factor of e either way [-].
    """

    name: str
    value: np.ndarray
    rise: np.ndarray
    low: float
    high: float
    known: bool = False


def _with_profile(estimate: Estimate, profile: Profile | None) -> Estimate:
    """An `estimate` with the ends of its `profile` [SI unit], as far as that has any."""
    if profile is None or not (np.isfinite(profile.low) or np.isfinite(profile.high)):
        return estimate
    low, high, bound = estimate.low, estimate.high, "both"
    if np.isfinite(profile.low):
        low = min(profile.low, estimate.value)
    else:
        bound = "upper"
    if np.isfinite(profile.high):
        high = max(profile.high, estimate.value)
    else:
        bound = "lower"
    bound = "" if profile.known or bound == "both" else bound
    return replace(estimate, low=low, high=high, identifiable=profile.known, bound=bound)


def identifiable(parameter: Parameter, deviation: float, prior: float) -> bool:
    """Whether the data alone, a `prior` deviation [-] taken off, know a coordinate of this
    `deviation` [-] within a factor of e.
    """
    information = 1 / deviation**2 - 1 / prior**2
    known = KNOWN * parameter.deviation / WEAK
    return bool(information > 1 / known**2)


def largest_force(record: Record) -> float:
    """The largest force that was measured [N]; of a record that never pulls, the largest push."""
    measured = record.force[~record.censored]
    pull = float(np.max(measured, initial=-np.inf))
    return pull if pull > 0 or not measured.size else float(np.max(np.abs(measured)))


def root_mean_square(residual: np.ndarray, count: np.ndarray) -> float:
    """Of residuals [N] that stand for `count` readings each [-]; NaN ones are left out."""
    used = np.isfinite(residual)
    return float(np.sqrt(np.average(residual[used] ** 2, weights=count[used])))


def value_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Values of the fitted parameters, each in its SI unit [SI], at their `coordinates` [-]."""
    return values(problem.fitted, put(problem.fitted, problem.muscle, np.asarray(coordinates)))


def slope_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Slopes of these values by the coordinates [SI], a row for each parameter."""
    return np.asarray(_slopes(problem.fitted, problem.muscle, jnp.asarray(coordinates)))


@eqx.filter_jit
def _slopes(parameters: tuple[Parameter, ...], muscle: Muscle, z: jax.Array) -> jax.Array:
    return jax.jacfwd(lambda z: values(parameters, put(parameters, muscle, z)))(z)
