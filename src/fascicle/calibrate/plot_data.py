"""Data of a calibration's figures in plain arrays: curves with bands, readings, loops, laws."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..plot import calibration as plot
from ..plot.theme import styled
from ..records.record import UNKNOWN, Record
from ..records.segmentation import runs
from ..units import DIMENSIONS
from .calibration import Calibration, Profile
from .comparison import LawComparison
from .data import Grid, fit_table
from .least_squares import NORMAL
from .readings import NO_PRESSURE, invert_force, pulling_force, static_force, without_tuning


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .posterior import Posterior

_POINTS = 161  # of a curve, so close that a kink looks sharp
_ROWS = 41  # of a curve in a file: linear interpolation between them is exact to a pixel
_LOOPS = 5  # in one picture: more lie on one another
_SAME_LEVEL = 0.02  # of the range of levels: runs that share a level
_PANELS = 6  # pressures at which laws are compared in one picture


@styled
def figures(
    calibration: Calibration,
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
    comparison: LawComparison | None = None,
) -> "dict[str, Figure]":
    """Draw the figures of a calibration.

    **Arguments:**

    - `calibration`: the calibration.
    - `profiles`: of its parameters, for a figure of them.
    - `posterior`: its draws, for the band's covariance; left out, the fit's own covariance.
    - `comparison`: of other laws, for a figure of them.

    **Returns:** figures by name: "fit", "residuals", then "loops", "readings", "profiles" and
    "laws" if any.
    """
    data = fit_plot(calibration, posterior)
    panels = {"fit": plot.fit(data), "residuals": plot.residuals(data)}
    if calibration.loop is not None and (loop_data := loops_plot(calibration)):
        panels["loops"] = plot.loops(loop_data)
    if calibration.readings is not None:
        panels["readings"] = plot.readings(readings_plot(calibration))
    if profiles:
        panels["profiles"] = plot.profiles(profiles_plot(calibration, profiles))
    if comparison is not None:
        panels["laws"] = plot.laws(laws_plot(calibration, comparison))
    for figure in panels.values():
        # a layout moves a little each time it is made: the files of one figure would differ
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)
        figure.set_layout_engine(None)
    return panels


def fit_plot(
    calibration: Calibration, posterior: "Posterior | None" = None, points: int = _POINTS
) -> plot.FitPlot:
    """Data of a fit's figure: readings, residuals [N], fitted curves and their 90 % bands [N].

    A band holds 90 % of the readings, to first order. `posterior`: as of `figures`; `points`:
    number of points of each curve.
    """
    grid, readings = calibration.grid, calibration.readings
    P, noise = grid.pressure[:, 0], calibration.problem.noise
    strain, force, curve = _plot_strains(grid, points)
    fitted = _curve_forces(calibration, curve)
    scatter = np.full(curve.shape, noise)
    if readings is not None:
        scatter = np.where(curve <= calibration.free_strain[:, None], readings.noise, noise)
    half_width = NORMAL * np.sqrt(_variance(calibration, curve, posterior) + scatter**2)
    if readings is not None:
        # without readings at a pressure the curves' uncertainty there is meaningless
        half_width[~readings.valid & (NO_PRESSURE * P.max() < P)] = np.nan
    return plot.FitPlot(
        pressure=P,
        strain=strain,
        force=force,
        censored=grid.censored & grid.used,
        residual=calibration.residual,
        noise=noise,
        curve_strain=curve,
        curve_force=fitted,
        low=fitted - half_width,
        high=fitted + half_width,
        trends={trend.along: trend.share for trend in calibration.diagnosis.significant},
        branch=calibration.fit_data.branch,
        time=calibration.fit_data.time,
    )


def curves_csv(calibration: Calibration, posterior: "Posterior | None" = None) -> str:
    """CSV of the fitted curves, with the band of 90 % of the readings; units in the headers."""
    data = fit_plot(calibration, posterior, _ROWS)
    assert data.low is not None
    assert data.high is not None
    columns = {
        "pressure [kPa]": np.repeat(data.pressure / 1e3, _ROWS), "strain [-]": data.curve_strain,
        "force [N]": data.curve_force, "low [N]": data.low, "high [N]": data.high,
    }  # fmt: skip
    table = np.stack([np.ravel(column) for column in columns.values()], axis=1)
    rows = (",".join(f"{x:.6g}" for x in row) for row in table[np.isfinite(table[:, 2])])
    return "\n".join([",".join(columns), *rows]).replace("nan", "") + "\n"


def measured_with_curves(record: Record, muscle: Muscle, label: str = "the muscle") -> plot.FitPlot:
    """Readings of a `record` with the curves of any `muscle`, and their `label`."""
    grid = fit_table(record).grid
    P = np.clip(grid.pressure, 0.0, HIGHEST_PRESSURE)
    strain, force, curve = _plot_strains(grid)
    errors = force - np.asarray(muscle.force(P, np.where(grid.used, strain, 0.0)))
    residual = np.where(grid.measured, errors, np.nan)
    return plot.FitPlot(
        pressure=P[:, 0],
        strain=strain,
        force=force,
        censored=grid.censored & grid.used,
        residual=residual,
        noise=float(np.nanstd(residual)),
        curve_strain=curve,
        curve_force=np.asarray(muscle.force(P, curve)),
        label=label,
    )


def loops_plot(calibration: Calibration) -> plot.LoopsPlot | None:
    """Strokes of the record's loops at a few levels, and the loops' width by pressure; `None`
    without two strokes at a level.
    """
    record, loop = calibration.record, calibration.loop
    stroke_runs = [run for run in runs(record) if run.kind != "mixed" and run.branch != UNKNOWN]
    if loop is None or not stroke_runs:
        return None
    kinds = [run.kind for run in stroke_runs]
    kind = max(set(kinds), key=kinds.count)
    stroke_runs = [run for run in stroke_runs if run.kind == kind]
    levels = np.unique([run.level for run in stroke_runs])
    gap = _SAME_LEVEL * float(np.ptp(levels))
    groups = np.split(levels, np.flatnonzero(np.diff(levels) > gap) + 1)
    # loops at the ends and evenly between them
    index = np.linspace(0, len(groups) - 1, min(len(groups), _LOOPS)).round().astype(int)
    strokes = [
        plot.Stroke(
            float(np.mean(groups[i])), run.branch,
            (record.strain if kind == "pressure" else record.pressure)[run.points],
            record.force[run.points],
        )
        for i in index
        for run in stroke_runs
        if run.level in groups[i]
    ]  # fmt: skip
    friction, curve = calibration.friction, None
    if friction is not None and friction.law is not None:
        curve = np.array([2 * friction.half_width(P) for P in loop.pressure])
    return plot.LoopsPlot(kind, strokes, loop.pressure, loop.width, curve)


def laws_plot(calibration: Calibration, comparison: LawComparison) -> plot.LawsPlot:
    """Readings at a few pressures, and the curves of all compared laws there."""
    grid = calibration.grid
    levels = np.flatnonzero(grid.measured.any(axis=1))
    if levels.size > _PANELS:
        levels = levels[np.linspace(0, levels.size - 1, _PANELS).round().astype(int)]
    strain, force, curve = _plot_strains(grid)
    curves = {label: _curve_forces(fit, curve)[levels] for label, fit in comparison.fits.items()}
    return plot.LawsPlot(
        grid.pressure[levels, 0], strain[levels], force[levels],
        (grid.censored & grid.used)[levels], curve[levels],
        [(row.label, row.rmse, curves[row.label]) for row in comparison.rows],
    )  # fmt: skip


def _plot_strains(grid: Grid, points: int = _POINTS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strains [-] and forces [N] of a `grid`, NaN for padding, and strains of its curves [-]."""
    strain, force = (np.where(grid.used, values, np.nan) for values in (grid.strain, grid.force))
    low, high = np.nanmin(strain, axis=1), np.nanmax(strain, axis=1)
    return strain, force, np.linspace(low, high, points, axis=1)


def _curve_forces(calibration: Calibration, strain: np.ndarray) -> np.ndarray:
    """Forces [N] of the fitted muscle; without measured pushes, up to the free strain only."""
    # a corrected pressure may lie a little below zero
    muscle, P = calibration.muscle, np.maximum(calibration.grid.pressure, 0.0)
    strain = strain * calibration.strain_scale
    if not calibration.problem.pulls:
        return static_force(muscle, P, strain)
    force = pulling_force(muscle, P, strain)
    # up to the first point past the free strain, so that the line meets the axis
    end = np.argmax(force < 0, axis=1)[:, None]
    past = (np.arange(force.shape[1]) > end) & np.any(force < 0, axis=1)[:, None]
    return np.where(past, np.nan, np.maximum(force, 0.0))


def _variance(
    calibration: Calibration, strain: np.ndarray, posterior: "Posterior | None"
) -> np.ndarray:
    """Variance [N²] of the model's force at `strain` [-], to first order; a row for each level."""
    problem, point, readings = calibration.problem, calibration.coordinates, calibration.readings
    if readings is not None:
        assert problem.curves is not None
        point = np.concatenate([point, problem.curves])
    if posterior is not None:
        covariance = np.cov(np.hstack([posterior.coordinates, posterior.curves]), rowvar=False)
    else:
        # undetermined parameters stay fixed: their prior would make the band meaningless
        determined = np.array([p.identifiable for p in calibration.parameters], bool)
        k, both = determined.size, np.outer(determined, determined)
        covariance = np.zeros((point.size, point.size))
        covariance[:k, :k] = np.where(both, calibration.covariance, 0.0)
        if readings is not None:
            covariance[k:, k:] = readings.covariance
    count = problem.grid.count
    elapsed = np.sum(count * problem.grid.elapsed, axis=1, keepdims=True)
    elapsed = elapsed / np.sum(count, axis=1, keepdims=True)
    grid = replace(problem.grid, strain=strain, count=np.ones_like(strain), elapsed=elapsed)
    along = replace(problem, grid=grid, branch=None)  # a curve between the loop's branches
    slopes = along.force_and_slopes(point)[1]
    variance = np.einsum("lri,ij,lrj->lr", slopes, np.atleast_2d(covariance), slopes)
    return np.maximum(variance, 0.0)


def readings_plot(calibration: Calibration) -> plot.ReadingsPlot:
    """Blocked force and free strain at each pressure, and the curves through them.

    **Raises:** `InvalidInputError` for a calibration of constants.
    """
    readings = calibration.readings
    if readings is None:
        rule = "has no readings of blocked force and free strain"
        raise InvalidInputError("calibration", rule, None, "use one of the method `tuning`")
    good, mean, C = readings.valid, readings.coefficients, readings.covariance
    top = float(np.max(readings.pressure))
    P = np.linspace(1.2 * NO_PRESSURE, 1, _POINTS) * top
    # both curves are linear in their coefficients
    free = invert_force(without_tuning(calibration.muscle), P, np.zeros(P.shape))
    shape, line = np.zeros((P.size, mean.size)), np.zeros((P.size, mean.size))
    shape[:, :-2] = free[:, None] * (P / top)[:, None] ** np.arange(mean.size - 2)
    line[:, -2], line[:, -1] = 1.0, P / top

    def band(basis: np.ndarray) -> np.ndarray:
        half_width = NORMAL * np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", basis, C, basis), 0))
        return np.stack([basis @ mean - half_width, basis @ mean, basis @ mean + half_width])

    return plot.ReadingsPlot(
        pressure=readings.pressure[good],
        blocked_force=readings.blocked_force[good],
        blocked_force_error=NORMAL * readings.blocked_force_deviation[good],
        free_strain=readings.free_strain[good],
        free_strain_error=NORMAL * readings.free_strain_deviation[good],
        curve_pressure=P,
        blocked_force_curve=band(line),
        free_strain_curve=band(shape),
    )


def profiles_plot(calibration: Calibration, profiles: Sequence[Profile]) -> list[plot.ProfilePlot]:
    """Profiles of some parameters of a `calibration`, in the units of the figure."""
    estimates = {estimate.name: estimate for estimate in calibration.parameters}
    rows = []
    for profile in profiles:
        estimate = estimates[profile.name]
        kind = DIMENSIONS[estimate.dimension]
        scale = float(kind.factors[kind.common])
        rows.append(
            plot.ProfilePlot(
                estimate.name, kind.common, profile.value / scale, profile.rise,
                estimate.value / scale, estimate.low / scale, estimate.high / scale,
                (profile.low / scale, profile.high / scale), estimate.identifiable,
            )
        )  # fmt: skip
    return rows
