"""Data of a calibration's figures in plain arrays: curves with bands, readings, profiles."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..plot import calibration as plot
from ..records.record import Record
from ..units import DIMENSIONS
from .calibration import Calibration, Profile
from .data import Grid, tabulate
from .least_squares import NORMAL
from .readings import NO_PRESSURE, invert_force, pulling_force, without_tuning


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .posterior import Posterior

_POINTS = 161  # of a curve, so close that a kink looks sharp


def figures(
    calibration: Calibration,
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
) -> "dict[str, Figure]":
    """Draw the figures of a calibration.

    **Arguments:**

    - `calibration`: the calibration.
    - `profiles`: of its parameters, for a figure of them.
    - `posterior`: its draws, for the band's covariance; left out, the fit's own covariance.

    **Returns:** figures by name: "fit", "residuals", then "readings" and "profiles" if any.
    """
    readings = None if calibration.readings is None else readings_plot(calibration)
    profile_data = profiles_plot(calibration, profiles) if profiles else ()
    return plot.figures(fit_plot(calibration, posterior), readings, profile_data)


def fit_plot(calibration: Calibration, posterior: "Posterior | None" = None) -> plot.FitPlot:
    """Readings, and curves with the band of 90 % of the readings, to first order.

    **Arguments:** as of `figures`.
    """
    grid, readings = calibration.grid, calibration.readings
    P, noise = grid.pressure[:, 0], calibration.problem.noise
    strain, force, curve = _strains(grid)
    fitted = _curve(calibration, curve)
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
    )


def measured_with_curves(record: Record, muscle: Muscle, label: str = "the muscle") -> plot.FitPlot:
    """Readings with the curves of any muscle.

    **Arguments:**

    - `record`: the readings.
    - `muscle`: the muscle.
    - `label`: of its curves.
    """
    grid = tabulate(record).grid
    P = np.clip(grid.pressure, 0.0, HIGHEST_PRESSURE)
    strain, force, curve = _strains(grid)
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


def _strains(grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Strains [-] and forces [N] of a `grid`, NaN for padding, and strains of its curves [-]."""
    strain, force = (np.where(grid.used, values, np.nan) for values in (grid.strain, grid.force))
    low, high = np.nanmin(strain, axis=1), np.nanmax(strain, axis=1)
    return strain, force, np.linspace(low, high, _POINTS, axis=1)


def _curve(calibration: Calibration, strain: np.ndarray) -> np.ndarray:
    """Forces [N] of the fitted muscle; without measured pushes, up to the free strain only."""
    muscle, P = calibration.muscle, calibration.grid.pressure
    rest_length = calibration.record.rest_length
    if rest_length is not None:
        strain = strain * (rest_length / float(muscle.length))
    if not calibration.problem.pulls:
        return np.asarray(muscle.force(P, strain))
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
    grid = replace(problem.grid, strain=strain, count=np.ones_like(strain))
    along = replace(problem, grid=grid)
    slopes = along.force_slopes(point, along.force(point))
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
    """Profiles in the units of the figure.

    **Arguments:**

    - `calibration`: the calibration.
    - `profiles`: of some of its parameters.
    """
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
