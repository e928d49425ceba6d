"""Results: a calibration, its residual diagnostics, and the uncertainty of its constants."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..muscle import Muscle
from ..records.hysteresis import Averaged, Loop, averaged, loop_of
from ..records.record import Record
from .damping import FittedDamping, fit_damping
from .data import FitData, Grid
from .friction import Friction, fit_friction
from .gauges import Gauge, default_deviations, strain_scale
from .least_squares import KNOWN, NORMAL, STATUS, Minimum, Problem, SearchEnds
from .parameters import FACTOR_NAMES, GAUGE_UNITS, WEAK, Parameter, put, values
from .readings import Readings, static_force


_MAJORITY = 0.5  # of the trends' squares: more lies past the free strain than before it
_SIZES = ("length", "angle")  # dimensions of sizes
CALIPERS = 0.1  # of a size: an error that no measurement with calipers makes
RULER = 0.02  # of the distance of the fittings: the error of a ruler, generously
_SLOPE_STEP = 1e-6  # of a coordinate: rounding and curvature are both below 1e-9 of the slope


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: `value`, 90 % interval `low` to `high`, and `start`, the center of its
    prior [SI unit of `dimension`].

    - `deviation`: standard deviation of its coordinate [-].
    - `identifiable`: the data alone determine it within a factor of e.
    - `bound`: "upper" or "lower" if the data determine only that end of the interval.
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


@dataclass(frozen=True, eq=False)
class Profile:
    """Profile likelihood: `rise` $\\Delta$ [-] at held values of a parameter [its SI unit].

    `low`, `high`: values at which it crosses 2.71, infinite if it does not; `known`: both lie
    within a factor of e.
    """

    name: str
    value: np.ndarray
    rise: np.ndarray
    low: float
    high: float
    known: bool = False


@dataclass(frozen=True, eq=False)
class Trend:
    """Result of a test for a trend of the residuals.

    - `along`: "strain", "pressure", "strain and pressure", "branch" or "time".
    - `share`: fraction of the residuals' squares it explains [-], after more significant trends.
    - `chance`: probability of at least this share in noise [-]; `found`: it is significant.
    - `columns`: polynomials at the residuals' rows, of mean square 1.
    """

    along: str
    share: float
    chance: float
    found: bool
    columns: np.ndarray


@dataclass(frozen=True)
class Runs:
    """Result of a test for runs of one sign: numbers of neighboring `pairs` of residuals `along`
    "strain" or "pressure", and of those that change sign; others as of a `Trend`.
    """

    along: str
    pairs: int
    changes: int
    chance: float
    found: bool


@dataclass(frozen=True)
class Cause:
    """A likely cause of the residuals, the share of their squares that it would explain [-], and
    the name of a constant that a fit may free because of it, if any.
    """

    code: str
    share: float
    constant: str = ""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Residual diagnostics of a fit.

    - `trends`: results of the trend tests, significant ones first; `runs`: of the sign tests.
    - `noise`: standard deviation of a reading [N] about fit and all trends; NaN of too few.
    - `inflation`: factor on the covariance from noise for correlated residuals [-].
    - `from_pressure`, `covariance`: contributions of the pressures' scatter and of the model's
      error to the covariance of the coordinates [-].
    - `discrepancy`: columns [N] of the model's error on the grid, for standard normal deviates.
    - `causes`: likely causes, the likeliest first.
    - `confounded`: constants that were not fitted, and that the data can't tell from fitted ones.
    - `past_free_strain`: share of the significant trends' squares past the free strain [-].
    """

    trends: tuple[Trend, ...] = ()
    runs: tuple[Runs, ...] = ()
    noise: float = float("nan")
    inflation: float = 1.0
    from_pressure: np.ndarray | float = 0.0
    covariance: np.ndarray | float = 0.0
    discrepancy: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 0)))
    causes: tuple[Cause, ...] = ()
    confounded: tuple[str, ...] = ()
    past_free_strain: float = 0.0

    @property
    def resisting_law_in_doubt(self) -> bool:
        """Trends lie mainly past the free strain, where an error of a gauge alone would not."""
        return self.past_free_strain > _MAJORITY

    @property
    def significant(self) -> tuple[Trend, ...]:
        """Significant trends."""
        return tuple(trend for trend in self.trends if trend.found)

    @property
    def autocorrelated(self) -> tuple[Runs, ...]:
        """Directions along which neighbors share their sign more often than noise does."""
        return tuple(run for run in self.runs if run.found)

    @property
    def is_white_noise(self) -> bool:
        """Residuals are compatible with noise."""
        return not self.significant and not self.autocorrelated


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """A muscle fitted to a record, with diagnostics.

    - `start`: the muscle that the fit began with.
    - `problem`: the least-squares problem, its noise that of the residuals.
    - `coordinates`: of the fitted parameters at the `minimum` [-].
    - `readings`: of a tuning, blocked forces and free strains, or `None`.
    - `free_strain`: the fitted muscle's at each level of the grid [-].
    - `solutions`: ends of all starts.
    - `profiles`: of the parameters that the linear interval leaves undetermined.
    """

    muscle: Muscle
    start: Muscle
    fit_data: FitData
    problem: Problem
    coordinates: np.ndarray
    readings: Readings | None
    minimum: Minimum
    free_strain: np.ndarray
    solutions: SearchEnds
    diagnosis: Diagnosis = Diagnosis()
    profiles: tuple[Profile, ...] = ()

    def __repr__(self) -> str:
        constants = ", ".join(f"{e.name}={e.value:.4g}" for e in self.parameters)
        return f"Calibration({constants}; rmse={self.rmse:.3g} N, {self.relative_rmse:.2%})"

    @property
    def method(self) -> str:
        """Method of the fit: "tuning", the paper's, or "constants"."""
        return "constants" if self.readings is None else "tuning"

    @property
    def record(self) -> Record:
        """Record of the fitted readings, one by one, corrected for the `gauge`."""
        return self.fit_data.record

    @property
    def gauge(self) -> Gauge:
        """Errors of the bench's gauges."""
        return self.fit_data.gauge

    @property
    def length(self) -> float:
        """Reference of the record's strains [m]."""
        return self.record.rest_length or float(self.muscle.length)

    @property
    def strain_scale(self) -> float:
        """Contraction of the fitted muscle over the record's strain [-]."""
        return strain_scale(self.record, self.muscle)

    @property
    def grid(self) -> Grid:
        """The readings by level of pressure."""
        return self.problem.grid

    @property
    def observed(self) -> Grid:
        """The readings as they were read, also where the grid is about the model's contractions."""
        return self.problem.observed or self.problem.grid

    @cached_property
    def force(self) -> np.ndarray:
        """Force of the fitted muscle at each place of the grid [N], without a loop."""
        if self.problem.branch is None:
            return self.minimum.linear.force
        return replace(self.problem, branch=None).force(self.coordinates)

    @property
    def residual(self) -> np.ndarray:
        """Measured less fitted force [N] on the grid, NaN where none was measured."""
        return np.where(self.grid.measured, self.grid.force - self.force, np.nan)

    @cached_property
    def errors(self) -> np.ndarray:
        """Measured less fitted force of each of the record's readings [N], NaN where clipped."""
        return self.problem.errors(self.force, self.fit_data)

    @property
    def points(self) -> int:
        """Number of fitted readings, each of an average counted."""
        return len(self.record)

    @property
    def censored(self) -> int:
        """Number of readings that only limit the force: clipped ones, and few that don't pull."""
        return int(np.sum(self.record.censored))

    @property
    def rmse(self) -> float:
        """Root mean square error of all readings that are not clipped [N]."""
        return rms(self.errors)

    @property
    def contraction_rmse(self) -> float:
        """Root mean square error of contractions read under set loads [m]; else NaN."""
        if not self.fit_data.reads_contraction:
            return float("nan")
        errors = self.problem.contraction_errors(self.force, self.fit_data)
        return rms(errors) * self.length

    @property
    def relative_rmse(self) -> float:
        """Root mean square error over the largest force [-], or the largest contraction."""
        if self.fit_data.reads_contraction:
            return self.contraction_rmse / (self.length * self.fit_data.largest_strain)
        return self.rmse / largest_force(self.record)

    @property
    def torque_rmse(self) -> float:
        """Root mean square error of the joint's torque [N·m]; NaN without moment arms."""
        arm = self.record.moment_arm
        return float("nan") if arm is None else rms(arm * self.errors)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fitted parameters."""
        return tuple(parameter.name for parameter in self.problem.parameters)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of the coordinates [-]: from noise of the forces, the curves of blocked force
        and free strain, scatter of the pressures, and the model's error.
        """
        diagnosis, from_curves = self.diagnosis, self.minimum.from_curves
        noise = diagnosis.inflation * (self.minimum.covariance - from_curves)
        return noise + from_curves + diagnosis.from_pressure + diagnosis.covariance

    @cached_property
    def parameters(self) -> tuple[Estimate, ...]:
        """Estimates of the fitted parameters, in the order of the covariance."""
        rows = estimates(self.problem, self.coordinates, self.covariance)
        profiles = {profile.name: profile for profile in self.profiles}
        center, half = self.problem.center, NORMAL * self.problem.deviation
        low, high = value_of(self.problem, center - half), value_of(self.problem, center + half)
        rows = [
            _with_profile(e, profiles[e.name], *ends) if e.name in profiles else e
            for e, *ends in zip(rows, low, high, strict=True)
        ]
        unknown = {"identifiable": False, "bound": ""}
        return tuple(replace(e, **unknown) if e.name in self.doubtful else e for e in rows)

    @property
    def doubtful(self) -> tuple[str, ...]:
        """Names of fitted factors whose law past the free strain the data contradict."""
        in_doubt = self.diagnosis.resisting_law_in_doubt
        return tuple(name for name in self.names if in_doubt and name in FACTOR_NAMES)

    @property
    def other_sizes(self) -> tuple[tuple[Estimate, float], ...]:
        """Fitted sizes whose whole interval contradicts the given ones, and those [SI]."""
        fittings = self.record.rest_length or float(self.start.length)
        sizes = []
        for estimate in self.parameters:
            # an active length may be shorter than the distance of the fittings, never longer
            is_length = estimate.name == "active_length"
            size = fittings if is_length else getattr(self.start, estimate.name, None)
            if size is None or not estimate.identifiable or estimate.dimension not in _SIZES:
                continue
            smaller = estimate.high < (1 - CALIPERS) * size and not is_length
            if smaller or estimate.low > (1 + CALIPERS) * size:
                sizes.append((estimate, float(size)))
        return tuple(sizes)

    @property
    def correlation(self) -> np.ndarray:
        """Correlations of the coordinates [-]."""
        scale = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(scale, scale)

    @property
    def wider(self) -> np.ndarray:
        """Ratio of each interval's width to its width from noise alone [-]."""
        return np.sqrt(np.diag(self.covariance) / np.diag(self.minimum.covariance))

    @property
    def status(self) -> str:
        """How the search from the best start ended: "converged", "stopped" or "broke"."""
        return STATUS[self.solutions.status[self.solutions.best]]

    @cached_property
    def half_way(self) -> Averaged | None:
        """Mean of the record's two branches and their distance; `None` without two branches."""
        try:
            half_way = averaged(self.record)
        except ValueError:  # no sweeps in it
            return None
        return half_way if np.any(np.isfinite(half_way.width)) else None

    @cached_property
    def loop(self) -> Loop | None:
        """Widths of the record's hysteresis loops; `None` without two branches."""
        return None if self.half_way is None else loop_of(self.record, self.half_way)

    @cached_property
    def half_way_rmse(self) -> float:
        """Root mean square error against the half-way curve [N]; NaN without two branches."""
        if self.loop is None or self.half_way is None:
            return float("nan")
        both = np.isfinite(self.half_way.width) & ~self.half_way.record.censored
        readings = self.half_way.record.only(both)
        strain = readings.strain * self.strain_scale
        force = static_force(self.muscle, np.maximum(readings.pressure, 0.0), strain)
        return rms(readings.force - force)

    @cached_property
    def damping(self) -> FittedDamping:
        """Friction by speed; it is no part of the fitted muscle."""
        return fit_damping(self.record, self.errors, self.length)

    @cached_property
    def friction(self) -> Friction | None:
        """Sliding springs fitted to the loops without `damping`; no part of the fitted muscle."""
        record, damping = self.record, self.damping
        if damping.law is not None:
            drag = np.asarray(damping.law.force(damping.velocity, record.pressure))
            record = replace(record, force=record.force + drag)
        return fit_friction(record, self.length)

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Coordinates [-] of a `count` of draws from the fit's normal approximation, in rows;
        parameters that the data do not determine stay at their fitted value.
        """
        determined = np.array([estimate.identifiable for estimate in self.parameters])
        covariance = np.where(np.outer(determined, determined), self.covariance, 0.0)
        spread, basis = np.linalg.eigh(covariance)
        normal = np.random.default_rng(seed).normal(size=(count, determined.size))
        return self.coordinates + normal @ (basis * np.sqrt(np.maximum(spread, 0))).T

    def muscles(self, count: int, seed: int = 0) -> list[Muscle]:
        """Muscles at so many `draws`, each checked as a new one: to train on, or to judge a design.
        `InvalidInputError` for a draw that no muscle can have.
        """
        return [self.problem.muscle_at(z).replace() for z in self.draws(count, seed)]


def rms(errors: np.ndarray) -> float:
    """Root mean square of `errors` but NaN, in their unit; NaN without any."""
    finite = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")


def estimates(
    problem: Problem, coordinates: np.ndarray, covariance: np.ndarray
) -> tuple[Estimate, ...]:
    """Estimates of a problem's parameters, from `coordinates` at its minimum and `covariance`."""
    if not problem.parameters:
        return ()
    z, deviations = np.asarray(coordinates), np.sqrt(np.diag(covariance))
    fitted, start = value_of(problem, z), value_of(problem, problem.center)
    rows, prior = [], _prior_deviations(problem)
    for i, (parameter, deviation) in enumerate(zip(problem.parameters, deviations, strict=True)):
        if parameter.linear:
            slope = slope_of(problem, z)[i]
            half_width = NORMAL * np.sqrt(slope @ covariance @ slope)
            low, high = fitted[i] - half_width, fitted[i] + half_width
        else:
            step = NORMAL * deviation * (np.arange(z.size) == i)
            low, high = (value_of(problem, z + side * step)[i] for side in (-1, 1))
        name = parameter.name, parameter.dimension, parameter.about
        known = is_identifiable(parameter, deviation, prior[i])
        value, low, high, center = (float(x) for x in (fitted[i], low, high, start[i]))
        rows.append(Estimate(*name, value, low, high, center, float(deviation), known))
    return tuple(rows)


def _prior_deviations(problem: Problem) -> np.ndarray:
    """Deviations of the priors; of gauge errors the defaults, before readings without pressure."""
    grid, length = problem.grid, float(problem.muscle.length)
    usual = default_deviations(grid.force, grid.pressure, grid.elapsed, length)
    pairs = zip(problem.parameters, problem.deviation, strict=True)
    return np.array([usual[p.name] / GAUGE_UNITS[p.name] if p.of_gauge else d for p, d in pairs])


def _with_profile(estimate: Estimate, profile: Profile, lowest: float, highest: float) -> Estimate:
    """An `estimate` with the ends of its `profile`; without those beyond the 90 % interval of its
    prior, `lowest` to `highest`, unless the data determine it.
    """
    ends, known = {}, profile.known
    if np.isfinite(profile.low) and (known or profile.low > lowest):
        ends["low"] = min(profile.low, estimate.value)
    if np.isfinite(profile.high) and (known or profile.high < highest):
        ends["high"] = max(profile.high, estimate.value)
    if not ends:
        return estimate
    bound = "" if known or len(ends) == 2 else "lower" if "low" in ends else "upper"
    return replace(estimate, **ends, identifiable=known, bound=bound)


def is_identifiable(parameter: Parameter, deviation: float, prior: float) -> bool:
    """The data without the prior determine a coordinate within a factor of e; `deviation`, `prior`:
    standard deviations of the coordinate and of its prior [-].
    """
    information = 1 / deviation**2 - 1 / prior**2
    # of a gauge: the data alone determine it to a third of its usual deviation
    limit = KNOWN * (prior if parameter.of_gauge else parameter.deviation) / WEAK
    return bool(information > 1 / limit**2)


def largest_force(record: Record) -> float:
    """Largest measured force [N]; of a record that never pulls, the largest push."""
    measured = record.force[~record.censored]
    pull = float(np.max(measured, initial=-np.inf))
    return pull if pull > 0 or not measured.size else float(np.max(np.abs(measured)))


def value_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Values of the fitted parameters [SI unit of each] at their `coordinates` [-]."""
    muscle = put(problem.parameters, problem.muscle, coordinates)
    return values(problem.parameters, muscle, problem.gauge_at(coordinates))


def slope_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Slopes of these values by the coordinates [SI], a row for each parameter."""
    steps = _SLOPE_STEP * np.eye(len(coordinates))
    ends = [[value_of(problem, coordinates + side * h) for h in steps] for side in (1, -1)]
    return ((np.array(ends[0]) - np.array(ends[1])) / (2 * _SLOPE_STEP)).T
