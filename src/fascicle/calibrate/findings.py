"""Findings and verdict of a calibration, as codes and numbers: does it fit, how far is it off, what
is unknown. The words are in `report.calibration_words`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.findings import Finding, Severity
from ..records.record import DOWN, UP
from .calibration import RULER, Calibration, rms
from .gauges import PERFECT, drift_confounders
from .model_selection import Selection


# of the largest force: the errors of a good bench, and those that friction of the braid causes
LARGE_ERROR, _ROUGHLY = 0.02, 0.05
_OVERFIT = 1.5  # of the error of the fit: a larger error at readings left out shows an overfit

_TIED = 0.95  # correlation from which two parameters can't be interpreted one by one
_DENSE = 10  # readings in the transition: with fewer, the collapse moment's interval is too narrow
_WIDER = 1.05  # ratio of widths: a smaller change is not visible in two digits
_SIZES = ("length", "angle")  # dimensions of sizes
_AFTER_COLLAPSE = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")


def calibration_findings(calibration: Calibration) -> tuple[Finding, ...]:
    """Findings to read before the fitted muscle is used, topic by topic."""
    kinds = (_of_gauges, _of_residuals, _of_coverage, _of_constants, _of_curves, _of_use)
    return tuple(finding for kind in kinds for finding in kind(calibration))


def _warning(code: str, **data: Any) -> Finding:
    return Finding(code, Severity.WARNING, data)


def _note(code: str, **data: Any) -> Finding:
    return Finding(code, Severity.NOTE, data)


def _of_gauges(calibration: Calibration) -> Iterator[Finding]:
    """Errors of the gauges, and faults of the channels."""
    fitted = {
        e.name: {"value": e.value, "low": e.low, "high": e.high} for e in calibration.parameters
    }
    for name, value in calibration.gauge.faults.items():
        error = fitted.get(name, {"value": value})
        # an error that may be none isn't named
        if "low" not in error or not error["low"] <= getattr(PERFECT, name) <= error["high"]:
            yield _warning(f"gauge.{name}", **error)
    for fault in calibration.fit_data.faults:
        if fault.kind != "floor":  # its readings are among those that are clipped
            data = {"channel": fault.channel, "value": fault.value, "count": fault.count}
            yield _warning(f"channel.{fault.kind}", **data)


def _of_residuals(calibration: Calibration) -> Iterator[Finding]:
    """Failed search, trends and runs of the residuals, their causes, and wider intervals."""
    diagnosis, solutions = calibration.diagnosis, calibration.solutions
    if solutions.status[solutions.best]:
        yield Finding("fit.not_converged", Severity.ERROR, {"status": calibration.status})
    if not np.isfinite(diagnosis.noise):
        yield _warning("fit.untested")
    elif diagnosis.is_white_noise and calibration.relative_rmse > LARGE_ERROR:
        yield _warning("fit.noisy", relative_rmse=calibration.relative_rmse)
    if not diagnosis.is_white_noise:
        trends = {trend.along: trend.share for trend in diagnosis.significant}
        runs = [
            {"along": run.along, "pairs": run.pairs, "changes": run.changes}
            for run in diagnosis.autocorrelated
        ]
        causes = [vars(cause) for cause in diagnosis.causes]
        yield _warning("residuals.pattern", trends=trends, runs=runs, causes=causes)
    if not calibration.parameters:
        return
    if diagnosis.significant and np.max(calibration.wider) >= _WIDER:
        low, high = float(np.min(calibration.wider)), float(np.max(calibration.wider))
        yield _note("intervals.wider_by_model", least=low, most=high)
    if diagnosis.inflation > 1:
        yield _note("intervals.wider_by_correlation", ratio=float(np.sqrt(diagnosis.inflation)))


def _of_coverage(calibration: Calibration) -> Iterator[Finding]:
    """Parts of the law that the data do not cover."""
    grid = calibration.grid
    strain = calibration.problem.strain(calibration.muscle)
    # a reading at the free strain itself may lie past it by rounding
    past = grid.measured & (strain > calibration.free_strain[:, None] + 1e-9)
    if clipped := calibration.fit_data.clipped:
        yield _note("readings.clipped", count=clipped, floor=calibration.fit_data.floor)
    levels = grid.measured.any(axis=1)
    if np.sum(levels) == 1:
        yield _warning("coverage.one_pressure", pressure=float(grid.pressure[levels][0, 0]))
    drift_is_known = "force_drift" in {*calibration.gauge.faults, *calibration.names}
    confounders = [] if drift_is_known else drift_confounders(calibration.record)
    if confounders and "force" not in calibration.record.zeroed:
        yield _note("coverage.drift_confounded", confounders=confounders)
    names = [name for name in calibration.names if name in _AFTER_COLLAPSE]
    if calibration.fit_data.pulls or not np.any(past):
        yield _note("coverage.no_resistance")
    elif names:
        columns = [calibration.names.index(name) for name in names]
        if not np.any(calibration.minimum.linear.slopes[: strain.size, columns]):
            yield _warning("coverage.no_collapse", constants=names)
    if calibration.readings is not None and calibration.muscle.tuning.pressures.size > 1:
        highest = float(np.max(calibration.muscle.tuning.pressures))
        yield _note("coverage.tuning_range", pressure=highest)


def _of_constants(calibration: Calibration) -> Iterator[Finding]:
    """Constants that the data do not determine, or only together."""
    estimates, doubtful = calibration.parameters, calibration.doubtful
    limits = []
    for e in (e for e in estimates if e.bound):
        value = e.high if e.bound == "upper" else e.low
        limits.append({"name": e.name, "dimension": e.dimension, "bound": e.bound, "value": value})
    if limits:
        yield _warning("constants.limited", limits=limits)
    unknown = [e.name for e in estimates if not (e.identifiable or e.bound)]
    if names := [name for name in unknown if name not in doubtful]:
        yield _warning("constants.undetermined", constants=names)
    if doubtful:
        yield _warning("constants.law_in_doubt", constants=list(doubtful))
    if confounded := list(calibration.diagnosis.confounded):
        yield _note("constants.confounded", constants=confounded)
    determined = [(i, e) for i, e in enumerate(estimates) if e.identifiable]
    correlation = np.abs(calibration.correlation)
    tied = [
        (float(correlation[i, j]), first, second)
        for i, second in determined
        for j, first in determined
        if j < i and correlation[i, j] > _TIED
    ]
    if tied:
        tied.sort(key=lambda pair: -pair[0])
        pairs = [{"constants": [a.name, b.name], "correlation": r} for r, a, b in tied]
        _, first, second = tied[0]
        problem = calibration.problem
        priors = zip(problem.parameters, problem.deviation, strict=True)
        weak = {parameter.name for parameter, prior in priors if prior >= parameter.deviation}
        open_ones = [e for e in (second, first) if e.name in weak]
        names = [e.name for e in open_ones if e.dimension in _SIZES] + [e.name for e in open_ones]
        size = names[0] if names else ""
        yield _warning("constants.correlated", pairs=pairs, constant=size)
    rate = next((e for e in estimates if e.name == "transition_rate" and e.identifiable), None)
    if rate is not None:
        used = calibration.grid.measured
        strain = np.where(used, calibration.problem.strain(calibration.muscle), np.nan)
        strain = strain[np.any(used, axis=1)]
        spacing = np.nanmax(strain, axis=1) - np.nanmin(strain, axis=1)
        spacing = float(np.median(spacing / np.sum(np.isfinite(strain), axis=1)))
        count = 1 / (rate.value * spacing)
        if count < _DENSE:
            yield _warning("constants.sparse_transition", count=count, enough=_DENSE)


def _of_curves(calibration: Calibration) -> Iterator[Finding]:
    """Blocked forces and free strains of a tuning that could not be read, or miss their curve."""
    readings = calibration.readings
    if readings is None:
        return
    P = readings.pressure
    if (missing := P[~readings.valid & (0.01 * P.max() < P)]).size:
        yield _note("curves.unread", pressures=missing.tolist())
    curves = ("free_strain", "blocked_force")
    for curve, misfit in zip(curves, readings.misfit, strict=True):
        if misfit > 1:
            yield _note("curves.misfit", curve=curve, ratio=float(np.sqrt(misfit)))


def _of_use(calibration: Calibration) -> Iterator[Finding]:
    """No loop of friction, strains by a fitted length, and sizes that contradict the given ones."""
    if not np.any(calibration.record.force):
        yield _warning("use.no_force")
    # under a load that hangs, both branches are fitted though their loop has no width in force
    if calibration.loop is None and not {UP, DOWN} <= {*calibration.record.branch.tolist()}:
        yield _note("use.no_loop")
    if directions := calibration.damping.unknown:
        slow, fast = calibration.damping.speeds
        yield _note("use.damping_unknown", directions=directions, slowest=slow, fastest=fast)
    if "active_length" in calibration.names:
        length, reference = float(calibration.muscle.length), calibration.record.rest_length
        yield _note("use.fitted_length", length=length, reference=reference)
    elif calibration.start.fitted_length is None and abs(calibration.strain_scale - 1) > RULER:
        lengths = {"length": float(calibration.muscle.length), "reference": calibration.length}
        yield _warning("use.other_length", **lengths)
    for estimate, nominal in calibration.other_sizes:
        data = {"dimension": estimate.dimension, "value": estimate.value}
        yield _warning("use.other_size", constant=estimate.name, nominal=nominal, **data)


@dataclass(frozen=True)
class Verdict:
    """Verdict on a calibration: `fit` is "not converged", "untested", "noise", "other sizes",
    "well", "roughly" or "poorly"; errors as of the calibration.

    - `pulling_rmse`, `resisting_rmse`: below and past the free strain [N]; NaN without readings.
    - `left_out_rmse`: at readings left out of the fit, over the largest force [-]; NaN if unknown.
    - `undetermined`, `limits`: constants that the data do not determine, and those with one limit.
    """

    fit: str
    rmse: float
    contraction_rmse: float
    relative_rmse: float
    pulling_rmse: float
    resisting_rmse: float
    torque_rmse: float
    left_out_rmse: float
    undetermined: tuple[str, ...]
    limits: tuple[str, ...]


def judge(calibration: Calibration, selection: Selection | None = None) -> Verdict:
    """Verdict on a `calibration`; a `selection` gives the error at left-out readings. The size of
    the errors comes first: a fit is good only if they are small.
    """
    diagnosis = calibration.diagnosis
    chosen = [c for c in selection.candidates if c.chosen] if selection else []
    left_out = chosen[-1].relative_left_out_rmse if chosen else float("nan")
    relative, errors = calibration.relative_rmse, calibration.errors
    worst = float(np.fmax(relative, left_out))  # one of them may be NaN
    if calibration.solutions.status[calibration.solutions.best]:
        fit = "not converged"
    elif worst > _ROUGHLY:
        fit = "poorly"
    elif not np.isfinite(diagnosis.noise) and calibration.parameters:
        fit = "untested"
    elif worst > LARGE_ERROR:
        fit = "roughly"
    elif calibration.other_sizes:
        fit = "other sizes"
    else:
        overfits = left_out > _OVERFIT * relative
        fit = "noise" if diagnosis.is_white_noise and not overfits else "well"
    strain = calibration.record.strain * calibration.strain_scale
    past = strain > calibration.free_strain[calibration.fit_data.level]
    past &= not calibration.fit_data.pulls
    pulling, resisting = rms(errors[~past]), rms(errors[past])
    undetermined = tuple(e.name for e in calibration.parameters if not (e.identifiable or e.bound))
    limits = tuple(e.name for e in calibration.parameters if e.bound)
    return Verdict(
        fit, calibration.rmse, calibration.contraction_rmse, relative, pulling, resisting,
        calibration.torque_rmse, left_out, undetermined, limits,
    )  # fmt: skip
