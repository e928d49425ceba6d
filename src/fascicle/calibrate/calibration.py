"""Results: a calibration with how sure its constants are, and the selection of a model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..core.lazy import import_late
from ..records.hysteresis import Averaged, Loop, averaged, loop_of
from ..records.record import Record
from ..repr_table import ReprTable, with_table_repr
from .data import clip_floor
from .diagnostics import Diagnosis
from .friction import Friction, fit_friction
from .least_squares import KNOWN, NORMAL, Fit, Problem
from .parameters import WEAK, Parameter, put, values


_SLOPE_STEP = 1e-6  # of a coordinate, for slopes of values


def _calibration_table(calibration: "Calibration") -> ReprTable:
    return import_late("calibrate.messages.calibration_table")(calibration)


def _selection_table(selection: "Selection") -> ReprTable:
    return import_late("calibrate.messages.selection_table")(selection)


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: its value and 90 % interval [SI unit of the dimension].

    `start`: where its prior is centered. `identifiable`: whether the data alone know it.
    `deviation`: of its coordinate [-]. `bound`: where the data give one end of the interval alone,
    "upper" or "lower".
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
class Bootstrap:
    """Fits of simulated records (`bootstrap`).

    - `names`: of the parameters.
    - `coordinates`, `values`: a row for each draw [-], [SI unit of each parameter].
    - `low`, `high`: ends of each parameter's 90 % interval [SI unit], (C15).
    - `failed`: number of draws whose fit broke.
    """

    names: tuple[str, ...]
    coordinates: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    failed: int


@dataclass(frozen=True, eq=False)
class Profile:
    """A parameter's profile.

    - `name`: of the parameter.
    - `value`: where it was held [SI unit of the parameter], rising.
    - `rise`: $\\Delta$ there [-].
    - `low`, `high`: where it crosses 2.71 [the same unit]; infinite if it doesn't.
    - `known`: whether both ends lie within a factor of e either way.
    """

    name: str
    value: np.ndarray
    rise: np.ndarray
    low: float
    high: float
    known: bool = False


@with_table_repr(_calibration_table)
@dataclass(frozen=True, eq=False)
class Calibration(Fit):
    """A muscle that was fitted to a record, diagnosed.

    - `diagnosis`: residual diagnostics, their likely causes, and the model's own error.
    - `bootstrapped`: fits of simulated records, whose intervals `parameters` then have; `None`:
      these are the quick ones of (C3).
    - `profiles`: of the parameters whose quick interval says nothing, with better ends.
    """

    diagnosis: Diagnosis
    bootstrapped: Bootstrap | None = None
    profiles: tuple[Profile, ...] = ()

    @cached_property
    def warnings_by_topic(self) -> Mapping[str, tuple[str, ...]]:
        """Lines to read before the muscle is used."""
        return import_late("calibrate.messages.calibration_warnings")(self)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Lines to read before the muscle is used."""
        return tuple(line for lines in self.warnings_by_topic.values() for line in lines)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fitted parameters."""
        return tuple(parameter.name for parameter in self.problem.parameters)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of the coordinates: of noise, of the readings, and of the model's error."""
        noise = self.minimum.covariance - self.minimum.from_curves
        trends = self.diagnosis.covariance
        total = self.diagnosis.inflation * noise + self.minimum.from_curves
        return total if trends is None else total + trends

    @cached_property
    def parameters(self) -> tuple[Estimate, ...]:
        """Estimates of the fitted parameters, in the order of the covariance."""
        quick, boots = estimates(self.problem, self.coordinates, self.covariance), self.bootstrapped
        if boots is None:
            ends = {profile.name: profile for profile in self.profiles}
            return tuple(_with_profile(one, ends.get(one.name)) for one in quick)
        known = np.std(boots.coordinates, axis=0) < KNOWN
        return tuple(
            replace(
                estimate, low=float(boots.low[i]), high=float(boots.high[i]),
                identifiable=estimate.identifiable and bool(known[i] or parameter.linear),
            )
            for i, (estimate, parameter) in enumerate(
                zip(quick, self.problem.parameters, strict=True)
            )
        )  # fmt: skip

    @property
    def intervals(self) -> str:
        """Method of the 90 % intervals, in words."""
        return import_late("calibrate.messages.interval_method")(self)

    @property
    def correlation(self) -> np.ndarray:
        """Correlations of the coordinates [-]."""
        scale = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(scale, scale)

    @property
    def wider(self) -> np.ndarray:
        """Width of each interval over that from noise alone [-]."""
        return np.sqrt(np.diag(self.covariance) / np.diag(self.minimum.covariance))

    @cached_property
    def half_way(self) -> Averaged | None:
        """Mean of the record's two branches and their distance; `None` where there are no two."""
        try:
            half_way = averaged(self.record)
        except ValueError:  # no sweeps in it
            return None
        return half_way if np.any(np.isfinite(half_way.width)) else None

    @cached_property
    def loop(self) -> Loop | None:
        """Widths of the record's hysteresis loops; half of them is in the errors of its readings.
        `None` where it doesn't hold both branches.
        """
        return loop_of(self.record)

    @cached_property
    def half_way_rmse(self) -> float:
        """Root mean square error [N] against the mean of both branches; NaN without these."""
        if self.loop is None or self.half_way is None:
            return float("nan")
        both = np.isfinite(self.half_way.width) & ~self.half_way.record.censored
        readings = self.half_way.record.only(both)
        rest = self.record.rest_length
        strain = readings.strain * (1.0 if rest is None else rest / float(self.muscle.length))
        force = np.asarray(self.muscle.force(readings.pressure, strain))
        return float(np.sqrt(np.mean((readings.force - force) ** 2)))

    @cached_property
    def friction(self) -> Friction | None:
        """Springs that slip, fitted to the loops; the fitted muscle is as it is without them."""
        length = self.record.rest_length
        return fit_friction(self.record, float(self.muscle.length) if length is None else length)

    @property
    def points(self) -> int:
        """Number of readings that were fitted, each of an average counted."""
        return len(self.record)

    @property
    def censored(self) -> int:
        """Number of readings that only say "not above"."""
        return self.fit_data.clipped

    @property
    def floor(self) -> str:
        """Force at which readings are clipped, in words."""
        return clip_floor(self.record)

    @property
    def rmse(self) -> float:
        """Root mean square error of all readings [N], censored ones left out."""
        return float(np.sqrt(np.nanmean(self.errors**2)))

    @property
    def relative_rmse(self) -> float:
        """Root mean square error over the largest measured force [-]."""
        return self.rmse / largest_force(self.record)

    @property
    def status(self) -> str:
        """End of the best start, in words."""
        return self.starts[self.solutions.best].split(": ", 1)[1]

    @property
    def starts(self) -> list[str]:
        """Ends of all starts, a line each."""
        return import_late("calibrate.messages.end_messages")(self.solutions)

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Draw coordinates [-] from the fit's normal approximation, one row a draw.

        Those that the data don't determine are kept at their fitted value: drawn from their
        prior they would only say that nothing is known.

        **Arguments:**

        - `count`: how many.
        - `seed`: random seed.
        """
        known = np.array([estimate.identifiable for estimate in self.parameters])
        covariance = np.where(np.outer(known, known), self.covariance, 0.0)
        spread, basis = np.linalg.eigh(covariance)
        normal = np.random.default_rng(seed).normal(size=(count, known.size))
        return self.coordinates + normal @ (basis * np.sqrt(np.maximum(spread, 0))).T


@dataclass(frozen=True)
class Candidate:
    """A candidate for what is free.

    - `label`: what was free; `names`: of these constants.
    - `method`: "tuning" or "constants".
    - `constants`: how many numbers were fitted, with those of a tuning's curves.
    - `rmse`, `left_out_rmse`: error [N] where it was fitted, and at pressures that it wasn't.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `readings`: which were compared: "pulling", where the muscle pulls, or "all".
    - `chosen`: whether it was selected.
    """

    label: str
    names: tuple[str, ...]
    method: str
    constants: int
    rmse: float
    left_out_rmse: float
    relative_rmse: float
    relative_left_out_rmse: float
    readings: str = "pulling"
    chosen: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """A `candidate` and its errors where it was left out, reading by reading [N]; NaN for those
    that are clipped. `violation`: why no muscle can be so, empty where one can.
    """

    candidate: Candidate
    unseen: np.ndarray
    violation: str = ""

    @property
    def valid(self) -> bool:
        """Whether it can be selected: a muscle can be so, and its left-out error is known."""
        return bool(np.isfinite(self.candidate.left_out_rmse)) and not self.violation


@with_table_repr(_selection_table)
@dataclass(frozen=True, eq=False)
class Selection:
    """The `calibration` that was selected for a record; the `candidates` it was selected from; and
    the `reasons`, a line each.
    """

    calibration: Calibration
    candidates: tuple[Candidate, ...] = ()
    reasons: tuple[str, ...] = ()


def estimates(
    problem: Problem, coordinates: np.ndarray, covariance: np.ndarray
) -> tuple[Estimate, ...]:
    """Estimates of a problem's parameters, from the `coordinates` at its minimum and their
    `covariance`.
    """
    if not problem.parameters:
        return ()
    z, deviations = np.asarray(coordinates), np.sqrt(np.diag(covariance))
    found, start = value_of(problem, z), value_of(problem, problem.center)
    out = []
    for i, (parameter, deviation) in enumerate(zip(problem.parameters, deviations, strict=True)):
        if parameter.linear:
            slope = slope_of(problem, z)[i]
            even = NORMAL * np.sqrt(slope @ covariance @ slope)
            low, high = found[i] - even, found[i] + even
        else:
            away = NORMAL * deviation * (np.arange(z.size) == i)
            low, high = (value_of(problem, z + side * away)[i] for side in (-1, 1))
        known = is_identifiable(parameter, deviation, problem.deviation[i])
        out.append(
            Estimate(
                parameter.name, parameter.dimension, parameter.about, float(found[i]),
                float(low), float(high), float(start[i]), float(deviation), known,
            )
        )  # fmt: skip
    return tuple(out)


def _with_profile(estimate: Estimate, profile: Profile | None) -> Estimate:
    """An `estimate` with the ends of its `profile` [SI unit], as far as that has any."""
    if profile is None or not (np.isfinite(profile.low) or np.isfinite(profile.high)):
        return estimate
    low, high = np.isfinite(profile.low), np.isfinite(profile.high)
    bound = "" if profile.known or (low and high) else "lower" if low else "upper"
    return replace(
        estimate,
        low=min(profile.low, estimate.value) if low else estimate.low,
        high=max(profile.high, estimate.value) if high else estimate.high,
        identifiable=profile.known,
        bound=bound,
    )


def is_identifiable(parameter: Parameter, deviation: float, prior: float) -> bool:
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


def value_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Values of the fitted parameters, each in its SI unit [SI], at their `coordinates` [-]."""
    return values(problem.parameters, put(problem.parameters, problem.muscle, coordinates))


def slope_of(problem: Problem, coordinates: np.ndarray) -> np.ndarray:
    """Slopes of these values by the coordinates [SI], a row for each parameter."""
    steps = _SLOPE_STEP * np.eye(len(coordinates))
    ends = [[value_of(problem, coordinates + side * h) for h in steps] for side in (1, -1)]
    return ((np.array(ends[0]) - np.array(ends[1])) / (2 * _SLOPE_STEP)).T
