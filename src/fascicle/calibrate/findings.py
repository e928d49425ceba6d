"""Findings of a calibration, as codes and numbers: gauges, residuals, coverage, constants, use.

The words are in `report.calibration_words`.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..core.findings import Finding, Severity
from .calibration import Calibration
from .verdict import LARGE_ERROR


_TIED = 0.95  # correlation from which two parameters can't be interpreted one by one
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_WIDER = 1.05  # ratio of widths: a smaller change is not visible in two digits
_MIN_LEVELS = 3  # pressures: fewer show no dependence on pressure
_CLEAR = 4.0  # standard deviations of a reading, from which two of them differ
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
    fitted = {estimate.name: estimate for estimate in calibration.parameters}
    for name, value in calibration.gauge.faults.items():
        estimate = fitted.get(name)
        ends = {} if estimate is None else {"low": estimate.low, "high": estimate.high}
        yield _warning(f"gauge.{name}", value=value, **ends)
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
        yield _warning(
            "residuals.pattern",
            trends={trend.along: trend.share for trend in diagnosis.significant},
            runs=[
                {"along": run.along, "pairs": run.pairs, "changes": run.changes}
                for run in diagnosis.autocorrelated
            ],
            causes=[vars(cause) for cause in diagnosis.causes],
        )
        yield from _of_patterns(calibration)
    if not calibration.parameters:
        return
    if diagnosis.significant and np.max(calibration.wider) >= _WIDER:
        low, high = float(np.min(calibration.wider)), float(np.max(calibration.wider))
        yield _note("intervals.wider_by_model", least=low, most=high)
    if diagnosis.inflation > 1:
        yield _note("intervals.wider_by_correlation", ratio=float(np.sqrt(diagnosis.inflation)))


def _of_patterns(calibration: Calibration) -> Iterator[Finding]:
    """Signs of the residuals, and their change with pressure at the least strain."""
    diagnosis = calibration.diagnosis
    if diagnosis.signs:
        yield _note("residuals.one_sided", strains=[vars(entry) for entry in diagnosis.signs])
    if len(diagnosis.lowest_strain_means) < _MIN_LEVELS or not np.isfinite(diagnosis.noise):
        return
    # end effects and a dead band show here
    P, means = np.array(diagnosis.lowest_strain_means).T
    low, high = sorted((int(np.argmin(means)), int(np.argmax(means))))
    if np.ptp(means) >= _CLEAR * diagnosis.noise:
        ends = [{"pressure": float(P[i]), "force": float(means[i])} for i in (low, high)]
        yield _note("residuals.at_least_strain", ends=ends)


def _of_coverage(calibration: Calibration) -> Iterator[Finding]:
    """Parts of the law that the data do not cover."""
    grid = calibration.grid
    strain = calibration.problem.strain(calibration.muscle)
    # a reading at the free strain itself may lie past it by rounding
    past = grid.measured & (strain > calibration.free_strain[:, None] + 1e-9)
    if clipped := calibration.fit_data.clipped:
        yield _note("readings.clipped", count=clipped, floor=calibration.floor)
    levels = grid.measured.any(axis=1)
    if np.sum(levels) == 1:
        yield _warning("coverage.one_pressure", pressure=float(grid.pressure[levels][0, 0]))
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
    limits = [
        {"name": e.name, "dimension": e.dimension, "bound": e.bound,
         "value": e.high if e.bound == "upper" else e.low}
        for e in estimates if e.bound
    ]  # fmt: skip
    if limits:
        yield _warning("constants.limited", limits=limits)
    names = [
        e.name for e in estimates if not (e.identifiable or e.bound) and e.name not in doubtful
    ]
    if names:
        yield _warning("constants.undetermined", constants=names)
    if doubtful:
        yield _warning("constants.law_in_doubt", constants=list(doubtful))
    if confounded := list(calibration.diagnosis.confounded):
        yield _note("constants.confounded", constants=confounded)
    determined = [(i, e) for i, e in enumerate(estimates) if e.identifiable]
    tied = [
        (abs(float(calibration.correlation[i, j])), first, second)
        for i, second in determined
        for j, first in determined
        if j < i and abs(calibration.correlation[i, j]) > _TIED
    ]
    if tied:
        tied.sort(key=lambda pair: -pair[0])
        pairs = [{"constants": [a.name, b.name], "correlation": r} for r, a, b in tied]
        _, first, second = tied[0]
        size = next((e.name for e in (second, first) if e.dimension in _SIZES), second.name)
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
    """Findings on the use of the muscle: a loop of friction that was not measured, strains that
    refer to a fitted length, and fitted sizes that contradict the given ones.
    """
    rest_length = calibration.record.rest_length
    if calibration.loop is None:
        yield _note("use.no_loop")
    if "active_length" in calibration.names:
        length = float(calibration.muscle.length)
        yield _note("use.fitted_length", length=length, reference=rest_length)
    for estimate, nominal in calibration.other_sizes:
        data = {"dimension": estimate.dimension, "value": estimate.value}
        yield _warning("use.other_size", constant=estimate.name, nominal=nominal, **data)
