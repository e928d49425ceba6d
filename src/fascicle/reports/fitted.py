"""A calibration as figures: its curves with what they are uncertain by, and the rest in plain
values.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ..calibrate.calibration import Calibration
from ..calibrate.grid import Grid, grid
from ..calibrate.problem import Problem
from ..calibrate.profiling import Profile
from ..calibrate.readings import free_strain_of
from ..calibrate.uncertainty import NORMAL
from ..muscle import Muscle
from ..muscle.entry import HIGHEST_PRESSURE
from ..plot import calibration as plot
from ..plot import profiles as plot_profiles
from ..records.record import Record
from ..units import DIMENSIONS


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..calibrate.posterior import Posterior

_PLACES = 161  # of a curve, so close that a kink looks like one
_DRAWS = 100
_NO_PRESSURE = 0.01  # of the highest: below, nothing is read
_LARGEST = 500_000  # forces to compute for a band


def figures(
    made: Calibration,
    profiles: Sequence[Profile] = (),
    posterior: "Posterior | None" = None,
    seed: int = 0,
) -> "dict[str, Figure]":
    """The figures of a calibration.

    **Arguments:**

    - `made`: the calibration [-].
    - `profiles`: of its parameters [-]; none, no figure of them.
    - `posterior`: its draws make the band [-]; left out, the normal approximation's do.
    - `seed`: of what is drawn [-].

    **Returns:** figures by name: "fit", "residuals", then "readings" and "profiles" if there
    are any [-].
    """
    fitted = fitted_of(made, posterior, seed)
    found = {"fit": plot.fit(fitted), "residuals": plot.residuals(fitted)}
    if made.readings is not None:
        found["readings"] = plot.readings(read_of(made))
    if profiles:
        found["profiles"] = plot_profiles.profiles(profiled_of(made, profiles))
    for figure in found.values():
        # a layout moves a little each time it is made: the files of one figure would differ
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
    return found


def fitted_of(
    made: Calibration, posterior: "Posterior | None" = None, seed: int = 0
) -> plot.Fitted:
    """Readings and curves, with the band that holds 90 % of readings.

    A posterior draws parameters and the curves through the readings together; without one
    they are drawn apart, as the readings behind them are.

    **Arguments:** as `figures` [-].

    **Returns:** them in plain arrays [-].
    """
    data = made.problem.data
    used = np.asarray(data.count) > 0
    strain = np.where(used, np.asarray(data.strain), np.nan)
    ends = np.nanmin(strain, axis=1), np.nanmax(strain, axis=1)
    curve = np.linspace(*ends, _PLACES, axis=1)
    count = int(np.clip(_LARGEST // curve.size, 20, _DRAWS))
    rng = np.random.default_rng(seed)
    if posterior is None:
        z, curves = made.draws(count, seed), _curves(made, count, rng)
    else:
        drawn = rng.integers(len(posterior.coordinates), size=count)
        z, curves = posterior.coordinates[drawn], posterior.curves[drawn]
    z = jnp.asarray(np.concatenate([made.coordinates[None], z]))
    if made.readings is None:
        curves = None
    else:
        curves = jnp.concatenate([made.readings.coefficients[None], jnp.asarray(curves)])
    force, free = (np.asarray(x) for x in _forces(_at(made.problem, curve), z, curves))
    noise = np.full(curve.shape, float(made.problem.noise))
    if made.readings is not None:
        noise = np.where(curve <= free[0][:, None], float(made.readings.noise), noise)
    P = np.asarray(data.pressure)[:, 0]
    away = NORMAL * np.sqrt(np.var(force[1:], axis=0) + noise**2)
    # where nothing could be read the curves' own uncertainty means nothing
    away[_unread(made, P)] = np.nan
    middle = np.mean(force[1:], axis=0)
    return plot.Fitted(
        pressure=P,
        strain=strain,
        force=np.where(used, np.asarray(data.force), np.nan),
        censored=np.asarray(data.censored) & used,
        residual=made.residual,
        noise=float(made.problem.noise),
        curve_strain=curve,
        curve_force=_curve(made, P, curve, force[0]),
        low=middle - away,
        high=middle + away,
    )


def beside(record: Record, muscle: Muscle, label: str = "the muscle") -> plot.Fitted:
    """Readings with the curves of any muscle, as its laws give them.

    **Arguments:**

    - `record`: the readings [-].
    - `muscle`: the muscle [-].
    - `label`: what its curves are called [-].

    **Returns:** them in plain arrays [-].
    """
    data = grid(record)
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
    return ~np.asarray(made.readings.valid) & (_NO_PRESSURE * P.max() < P)


def _curve(made: Calibration, P: np.ndarray, strain: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Forces [N] of the muscle as it is saved, which holds C1, C2 where nothing was read."""
    unread = _unread(made, P)
    if not unread.any():
        return force
    saved = np.asarray(made.muscle.force(P[:, None], strain))
    return np.where(unread[:, None], saved, force)


def read_of(made: Calibration) -> plot.Read:
    """What was read at each pressure, and the curves through it.

    **Arguments:** `made`: a calibration with readings [-].

    **Returns:** them in plain arrays [-].

    **Raises:** `ValueError` for one that has none.
    """
    found = made.readings
    if found is None:
        raise ValueError("`made` holds no readings: its method fits the constants directly.")
    good = np.asarray(found.valid)
    top = float(np.max(np.asarray(found.pressure)))
    P = np.linspace(1.2 * _NO_PRESSURE, 1, _PLACES) * top
    mean, C = np.asarray(found.coefficients), np.asarray(found.covariance)
    # both curves are linear in their coefficients
    each = _free_strains(made.problem, jnp.eye(mean.size), jnp.asarray(P), jnp.asarray(top))
    shape = np.array(each).T
    line = np.zeros_like(shape)
    line[:, -2], line[:, -1] = 1.0, P / top

    def band(basis: np.ndarray) -> np.ndarray:
        away = NORMAL * np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", basis, C, basis), 0))
        return np.stack([basis @ mean - away, basis @ mean, basis @ mean + away])

    return plot.Read(
        pressure=np.asarray(found.pressure)[good],
        blocked_force=np.asarray(found.blocked_force)[good],
        blocked_force_error=NORMAL * np.asarray(found.blocked_force_deviation)[good],
        free_strain=np.asarray(found.free_strain)[good],
        free_strain_error=NORMAL * np.asarray(found.free_strain_deviation)[good],
        curve_pressure=P,
        blocked_force_curve=band(line),
        free_strain_curve=band(shape),
    )


def profiled_of(made: Calibration, profiles: Sequence[Profile]) -> list[plot_profiles.Profiled]:
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
            plot_profiles.Profiled(
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


def _at(problem: Problem, strain: np.ndarray) -> Problem:
    """The problem with readings at other strains [-]."""
    P, places = problem.data.pressure, jnp.asarray(strain)
    data = Grid(P, places, jnp.zeros(places.shape), jnp.ones(places.shape),
                jnp.zeros(places.shape, bool))  # fmt: skip
    return eqx.tree_at(lambda p: p.data, problem, data)


def _curves(made: Calibration, count: int, rng: np.random.Generator) -> np.ndarray:
    """Coefficients of the readings' curves, drawn `count` times."""
    if made.readings is None:
        return np.zeros((count, 0))
    mean = np.asarray(made.readings.coefficients)
    spread, basis = np.linalg.eigh(np.asarray(made.readings.covariance))
    normal = rng.normal(size=(count, mean.size))
    return mean + normal @ (basis * np.sqrt(np.maximum(spread, 0))).T


@eqx.filter_jit
def _forces(
    problem: Problem, coordinates: jax.Array, curves: jax.Array | None
) -> tuple[jax.Array, jax.Array]:
    """Forces [N] at the problem's places, and free strains [-], for each draw."""

    def one(z: jax.Array, curve: jax.Array | None) -> tuple[jax.Array, jax.Array]:
        at = problem if curve is None else eqx.tree_at(lambda p: p.curves, problem, curve)
        muscle = at.muscle_at(z)
        return at.force(z), muscle.free_strain(at.data.pressure[:, 0])

    return jax.vmap(one)(coordinates, curves)


@eqx.filter_jit
def _free_strains(
    problem: Problem, coefficients: jax.Array, pressure: jax.Array, top: jax.Array
) -> jax.Array:
    """Free strains [-] that each row of coefficients gives."""
    return jax.vmap(lambda row: free_strain_of(problem.muscle, row, pressure, top))(coefficients)
