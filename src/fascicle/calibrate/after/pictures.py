"""What a calibration's pictures show, in plain arrays: its curves with what they are uncertain by,
and the rest. `plot` draws them.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.errors import InvalidInputError
from ...core.validation import HIGHEST_PRESSURE
from ...muscle import Muscle
from ...plot import calibration as plot
from ...plot.calibration import Profiled
from ...records.record import Record
from ...units import DIMENSIONS
from ..data.grid import grid, trimmed
from ..data.pulling import force_of, strain_of, untuned
from ..problem.linear import linear
from ..problem.uncertainty import NORMAL
from .calibration import Calibration
from .profiling import Profile


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .posterior import Posterior

_PLACES = 161  # of a curve, so close that a kink looks like one
_NO_PRESSURE = 0.01  # of the highest: below, nothing is read


def figures(
    made: Calibration,
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
) -> "dict[str, Figure]":
    """The figures of a calibration.

    **Arguments:**

    - `made`: the calibration [-].
    - `profiles`: of its parameters [-]; none, no figure of them.
    - `posterior`: its draws' covariance makes the band [-]; left out, the fit's own does.

    **Returns:** figures by name: "fit", "residuals", then "readings" and "profiles" if there
    are any [-].
    """
    read = None if made.readings is None else read_of(made)
    profiled = profiled_of(made, profiles) if profiles else ()
    return plot.figures(fitted_of(made, posterior), read, profiled)


def fitted_of(made: Calibration, posterior: "Posterior | None" = None) -> plot.Fitted:
    """Readings and curves, with the band that holds 90 % of readings, to first order.

    **Arguments:** as `figures` [-].

    **Returns:** them in plain arrays [-].
    """
    data = made.data
    P, used = np.asarray(data.pressure)[:, 0], np.asarray(data.count) > 0
    strain = np.where(used, np.asarray(data.strain), np.nan)
    ends = np.nanmin(strain, axis=1), np.nanmax(strain, axis=1)
    curve = np.linspace(*ends, _PLACES, axis=1)
    force = _curve(made, P, curve)
    noise = np.full(curve.shape, float(made.problem.noise))
    if made.readings is not None:
        noise = np.where(curve <= made.free_strain[:, None], made.readings.noise, noise)
    away = NORMAL * np.sqrt(_variance(made, curve, _joint(made, posterior)) + noise**2)
    # where nothing could be read the curves' own uncertainty means nothing
    away[_unread(made, P)] = np.nan
    return plot.Fitted(
        pressure=P,
        strain=strain,
        force=np.where(used, np.asarray(data.force), np.nan),
        censored=np.asarray(data.censored) & used,
        residual=made.residual,
        noise=float(made.problem.noise),
        curve_strain=curve,
        curve_force=force,
        low=force - away,
        high=force + away,
        follows={one.along: one.share for one in made.seen.found},
    )


def beside(record: Record, muscle: Muscle, label: str = "the muscle") -> plot.Fitted:
    """Readings with the curves of any muscle, as its laws give them.

    **Arguments:**

    - `record`: the readings [-].
    - `muscle`: the muscle [-].
    - `label`: what its curves are called [-].

    **Returns:** them in plain arrays [-].
    """
    data = trimmed(grid(record))
    used = np.asarray(data.count) > 0
    censored = np.asarray(data.censored) & used
    P = np.clip(np.asarray(data.pressure), 0.0, HIGHEST_PRESSURE)
    strain = np.where(used, np.asarray(data.strain), np.nan)
    force = np.where(used, np.asarray(data.force), np.nan)
    curve = np.linspace(np.nanmin(strain, axis=1), np.nanmax(strain, axis=1), _PLACES, axis=1)
    left = force - np.asarray(muscle.force(P, np.where(used, strain, 0.0)))
    residual = np.where(used & ~censored, left, np.nan)
    return plot.Fitted(
        pressure=P[:, 0],
        strain=strain,
        force=force,
        censored=censored,
        residual=residual,
        noise=float(np.nanstd(residual)),
        curve_strain=curve,
        curve_force=np.asarray(muscle.force(P, curve)),
        label=label,
    )


def _unread(made: Calibration, P: np.ndarray) -> np.ndarray:
    """Which levels of pressure the tuning could read nothing at."""
    if made.readings is None:
        return np.zeros(P.shape, dtype=bool)
    return ~made.readings.valid[: P.size] & (_NO_PRESSURE * P.max() < P)


def _curve(made: Calibration, P: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Forces [N] of the fitted muscle. Where nothing pushed curves end with its pull: what it does
    past the free strain was not measured.
    """
    rest = made.record.rest_length
    own = strain if rest is None else strain * (rest / float(made.muscle.length))
    if not made.problem.pulls:
        return np.asarray(made.muscle.force(P[:, None], own))
    force, _ = force_of(made.muscle, P[:, None], own)
    # to the first place past it, so that a line meets the axis
    ends = np.argmax(force < 0, axis=1)
    past = (np.arange(force.shape[1]) > ends[:, None]) & np.any(force < 0, axis=1)[:, None]
    return np.where(past, np.nan, np.maximum(force, 0.0))


def _joint(made: Calibration, posterior: "Posterior | None") -> np.ndarray:
    """Covariance of the fitted coordinates and of the readings' curves together."""
    if posterior is not None:
        return np.cov(np.hstack([posterior.coordinates, posterior.curves]), rowvar=False)
    # what the data don't determine is kept: its prior would only say that nothing is known
    known = np.array([one.identifiable for one in made.parameters])
    k, n = known.size, 0 if made.readings is None else made.readings.coefficients.size
    joint = np.zeros((k + n, k + n))
    joint[:k, :k] = np.where(np.outer(known, known), made.covariance, 0.0)
    if made.readings is not None:
        joint[k:, k:] = made.readings.covariance
    return joint


def _variance(made: Calibration, strain: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """Variance [N²] of the model's force at `strain` [-], a row for each level, to first order."""
    problem, z = made.problem, made.problem.whole(made.coordinates)
    shape = np.shape(problem.data.count)
    columns = np.concatenate([problem.chosen, np.arange(z.size, z.size + len(joint))])
    columns = columns[: len(joint)]
    out = np.zeros(strain.shape)
    # in the tables' shape, which is compiled already
    for start in range(0, strain.shape[1], shape[1]):
        part = strain[:, start : start + shape[1]]
        filled = np.zeros(shape)
        filled[: part.shape[0], : part.shape[1]] = part
        at = replace(problem, data=replace(problem.data, strain=filled))
        slopes = linear(at, z).force_slopes[: part.shape[0], : part.shape[1]][..., columns]
        out[:, start : start + shape[1]] = np.einsum("lri,ij,lrj->lr", slopes, joint, slopes)
    return np.maximum(out, 0.0)


def read_of(made: Calibration) -> plot.Read:
    """What was read at each pressure, and the curves through it.

    **Arguments:** `made`: a calibration with readings [-].

    **Returns:** them in plain arrays [-].

    **Raises:** `ValueError` for one that has none.
    """
    found = made.readings
    if found is None:
        raise InvalidInputError(
            "made", "holds no readings", None, "its method fits the constants directly"
        )
    good = found.valid
    top = float(np.max(found.pressure))
    P = np.linspace(1.2 * _NO_PRESSURE, 1, _PLACES) * top
    mean, C = found.coefficients, found.covariance
    # both curves are linear in their coefficients
    free = strain_of(untuned(made.muscle), P, np.zeros(P.shape))
    shape, line = np.zeros((P.size, mean.size)), np.zeros((P.size, mean.size))
    shape[:, :-2] = free[:, None] * (P / top)[:, None] ** np.arange(mean.size - 2)
    line[:, -2], line[:, -1] = 1.0, P / top

    def band(basis: np.ndarray) -> np.ndarray:
        away = NORMAL * np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", basis, C, basis), 0))
        return np.stack([basis @ mean - away, basis @ mean, basis @ mean + away])

    return plot.Read(
        pressure=found.pressure[good],
        blocked_force=found.blocked_force[good],
        blocked_force_error=NORMAL * found.blocked_force_deviation[good],
        free_strain=found.free_strain[good],
        free_strain_error=NORMAL * found.free_strain_deviation[good],
        curve_pressure=P,
        blocked_force_curve=band(line),
        free_strain_curve=band(shape),
    )


def profiled_of(made: Calibration, profiles: Sequence[Profile]) -> list[Profiled]:
    """Profiles in the units that they are shown in.

    **Arguments:**

    - `made`: the calibration [-].
    - `profiles`: of its parameters, in their order [-].

    **Returns:** them in plain arrays [-].
    """
    out = []
    for profile, one in zip(profiles, made.parameters, strict=True):
        kind = DIMENSIONS[one.dimension]
        scale = float(kind.factors[kind.shown])
        out.append(
            Profiled(
                one.name,
                kind.shown,
                profile.value / scale,
                profile.rise,
                one.value / scale,
                one.low / scale,
                one.high / scale,
                (profile.low / scale, profile.high / scale),
                one.identifiable,
            )
        )
    return out
