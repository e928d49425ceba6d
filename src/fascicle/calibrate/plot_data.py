"""Data of a calibration's figures in plain arrays: curves with their bands, readings, profiles.

`plot` draws them.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..plot import calibration as plot
from ..plot.calibration import ProfilePlot
from ..records.record import Record
from ..units import DIMENSIONS
from .calibration import Calibration, Profile
from .data import tabulate
from .least_squares import NORMAL
from .readings import NO_PRESSURE, invert_force, pulling_force, without_tuning


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .posterior import Posterior

_POINTS = 161  # of a curve, so close that a kink looks like one


def figures(
    calibration: Calibration,
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
) -> "dict[str, Figure]":
    """Draw the figures of a calibration.

    **Arguments:**

    - `calibration`: the calibration.
    - `profiles`: of its parameters; none, no figure of them.
    - `posterior`: its draws' covariance makes the band; left out, the fit's own does.

    **Returns:** figures by name: "fit", "residuals", then "readings" and "profiles" if there
    are any.
    """
    read = None if calibration.readings is None else readings_plot(calibration)
    profiled = profiles_plot(calibration, profiles) if profiles else ()
    return plot.figures(fit_plot(calibration, posterior), read, profiled)


def fit_plot(calibration: Calibration, posterior: "Posterior | None" = None) -> plot.FitPlot:
    """Readings and curves, with the band that holds 90 % of readings, to first order.

    **Arguments:** as of `figures`.
    """
    grid, readings = calibration.grid, calibration.readings
    P, noise = grid.pressure[:, 0], calibration.problem.noise
    strain = np.where(grid.used, grid.strain, np.nan)
    curve = np.linspace(np.nanmin(strain, axis=1), np.nanmax(strain, axis=1), _POINTS, axis=1)
    force = _curve(calibration, curve)
    scatter = np.full(curve.shape, noise)
    if readings is not None:
        scatter = np.where(curve <= calibration.free_strain[:, None], readings.noise, noise)
    away = NORMAL * np.sqrt(_variance(calibration, curve, posterior) + scatter**2)
    if readings is not None:
        # where nothing could be read the curves' own uncertainty means nothing
        away[~readings.valid & (NO_PRESSURE * P.max() < P)] = np.nan
    return plot.FitPlot(
        pressure=P,
        strain=strain,
        force=np.where(grid.used, grid.force, np.nan),
        censored=grid.censored & grid.used,
        residual=calibration.residual,
        noise=noise,
        curve_strain=curve,
        curve_force=force,
        low=force - away,
        high=force + away,
        trends={trend.along: trend.share for trend in calibration.diagnosis.significant},
    )


def measured_with_curves(record: Record, muscle: Muscle, label: str = "the muscle") -> plot.FitPlot:
    """Readings with the curves of any muscle, as its laws give them.

    **Arguments:**

    - `record`: the readings.
    - `muscle`: the muscle.
    - `label`: of its curves.
    """
    grid = tabulate(record).grid
    P = np.clip(grid.pressure, 0.0, HIGHEST_PRESSURE)
    strain, force = (np.where(grid.used, x, np.nan) for x in (grid.strain, grid.force))
    curve = np.linspace(np.nanmin(strain, axis=1), np.nanmax(strain, axis=1), _POINTS, axis=1)
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


def _curve(calibration: Calibration, strain: np.ndarray) -> np.ndarray:
    """Forces [N] of the fitted muscle. Where nothing pushed curves end with its pull: what it does
    past the free strain was not measured.
    """
    muscle, P = calibration.muscle, calibration.grid.pressure
    rest = calibration.record.rest_length
    own = strain if rest is None else strain * (rest / float(muscle.length))
    if not calibration.problem.pulls:
        return np.asarray(muscle.force(P, own))
    force = pulling_force(muscle, P, own)
    # to the first point past it, so that a line meets the axis
    end = np.argmax(force < 0, axis=1)[:, None]
    past = (np.arange(force.shape[1]) > end) & np.any(force < 0, axis=1)[:, None]
    return np.where(past, np.nan, np.maximum(force, 0.0))


def _variance(
    calibration: Calibration, strain: np.ndarray, posterior: "Posterior | None"
) -> np.ndarray:
    """Variance [N²] of the model's force at `strain` [-], a row for each level, to first order."""
    problem, point, readings = calibration.problem, calibration.coordinates, calibration.readings
    if readings is not None:
        assert problem.curves is not None
        point = np.concatenate([point, problem.curves])
    if posterior is not None:
        covariance = np.cov(np.hstack([posterior.coordinates, posterior.curves]), rowvar=False)
    else:
        # what the data don't determine is kept: its prior would only say that nothing is known
        known = np.array([estimate.identifiable for estimate in calibration.parameters], bool)
        k = known.size
        covariance = np.zeros((point.size, point.size))
        covariance[:k, :k] = np.where(np.outer(known, known), calibration.covariance, 0.0)
        if readings is not None:
            covariance[k:, k:] = readings.covariance
    along = replace(problem, grid=replace(problem.grid, strain=strain))
    slopes = along.force_slopes(point, along.force(point))
    variance = np.einsum("lri,ij,lrj->lr", slopes, np.atleast_2d(covariance), slopes)
    return np.maximum(variance, 0.0)


def readings_plot(calibration: Calibration) -> plot.ReadingsPlot:
    """Readings at each pressure, and the curves through them.

    **Raises:** `InvalidInputError` for a calibration that has none.
    """
    readings = calibration.readings
    if readings is None:
        raise InvalidInputError(
            "calibration", "holds no readings", None, "its method fits the constants directly"
        )
    good, mean, C = readings.valid, readings.coefficients, readings.covariance
    top = float(np.max(readings.pressure))
    P = np.linspace(1.2 * NO_PRESSURE, 1, _POINTS) * top
    # both curves are linear in their coefficients
    free = invert_force(without_tuning(calibration.muscle), P, np.zeros(P.shape))
    shape, line = np.zeros((P.size, mean.size)), np.zeros((P.size, mean.size))
    shape[:, :-2] = free[:, None] * (P / top)[:, None] ** np.arange(mean.size - 2)
    line[:, -2], line[:, -1] = 1.0, P / top

    def band(basis: np.ndarray) -> np.ndarray:
        away = NORMAL * np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", basis, C, basis), 0))
        return np.stack([basis @ mean - away, basis @ mean, basis @ mean + away])

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


def profiles_plot(calibration: Calibration, profiles: Sequence[Profile]) -> list[ProfilePlot]:
    """Profiles in the units that they are shown in.

    **Arguments:**

    - `calibration`: the calibration.
    - `profiles`: of its parameters, in their order.
    """
    out = []
    for profile, estimate in zip(profiles, calibration.parameters, strict=True):
        kind = DIMENSIONS[estimate.dimension]
        scale = float(kind.factors[kind.shown])
        out.append(
            ProfilePlot(
                estimate.name, kind.shown, profile.value / scale, profile.rise,
                estimate.value / scale, estimate.low / scale, estimate.high / scale,
                (profile.low / scale, profile.high / scale), estimate.identifiable,
            )
        )  # fmt: skip
    return out
