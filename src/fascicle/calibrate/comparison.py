r"""Comparison of laws on one record, by likelihood and by what they were not fitted to.

Each row fits one choice of laws. It is compared by how likely it makes all $n$ readings, clipped
ones too, and by what its $k$ free constants cost,

$$\mathrm{AIC} = -2 \ln L + 2k, \qquad \mathrm{BIC} = -2 \ln L + k \ln n \tag{C6}$$

A measured force has a normal density about the law's, one that was clipped the chance that it
isn't above:

$$-2 \ln L = \sum_{measured} \left[\ln \sigma^2 + n r^2/\sigma^2\right]
  - 2 \sum_{clipped} \ln \Phi(\sqrt n\, (F - \mu)/\sigma), \tag{C13}$$

with $r$ what the law misses and $n$ how many readings are averaged; what is the same for all laws
is left out. $\sigma$ is where that is least. The fit is also repeated without each pressure in
turn, and judged by its error there. Published constants of Sárosi's law without physics, and the
law fitted anew, stand beside them:

$$F = (a p + b)\, e^{c \kappa} + d p \kappa + e p + f \tag{C5}$$

with the pressure $p$ in bar and the contraction $\kappa$ in percent.

**Source:** Akaike (1974); Schwarz (1978); Tobin (1958); Sárosi et al. (2015), as the
six-parameter law and its constants are quoted.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares, minimize_scalar
from scipy.special import log_ndtr

from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..muscle.validation import diameter_matches
from ..records.record import Record
from ..units import pretty
from .calibration import Calibration, largest_force
from .data import FitData, Grid, select_fit_data
from .fitting import FitOptions, Prior, fit_data
from .model_selection import folds, left_out_force
from .parameters import parameters_of, with_optional_laws


# a law that collapses by itself takes seconds for each force, and would come once for each choice
_BUCKLING = tuple(name for name, law in LAWS["buckling"].items() if getattr(law, "collapses", True))
# a to f of (C5), of a Festo DMSP-20-200N; its diameter in m
SAROSI_DMSP_20_200N = np.array([
    -4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151,
])  # fmt: skip
_DIAMETER = 20e-3
_FINEST = 1e-9  # of the largest force: below, a noise is rounding
_WIDE = 5.0  # of the noise's logarithm: how far clipped readings may move it
_FIRST_NOISE = 0.02  # of the largest force: where the search for the noise begins
_LEAST = 1e-3  # of the noise before: without noise there is an end to it
_ROUNDS, _SETTLED = 8, 1e-3  # of the noise: what a clipped reading says follows it


@dataclass(frozen=True)
class Row:
    """One law against a record.

    - `label`: the law. `free`: how many constants were fitted.
    - `rmse`, `left_out_rmse`: error [N] where it was fitted, and at pressures that it wasn't.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `aic`, `bic`: (C6), less the least of a table.
    - `status`: end of the fit.
    - `clipped_pull`: the most that it pulls where a reading was clipped at zero [N]; 0 where it
      pulls at none.
    """

    label: str
    free: int
    rmse: float
    left_out_rmse: float
    relative_rmse: float
    relative_left_out_rmse: float
    aic: float
    bic: float
    status: str
    clipped_pull: float = 0.0


def compare(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    buckling: Sequence[str] = _BUCKLING,
    collapse: Sequence[str] = tuple(LAWS["collapse"]),
    post_collapse: Sequence[str] = tuple(LAWS["post_collapse"]),
    **options: Any,
) -> list[Row]:
    """Fit every choice of buckling, collapse and post-collapse law to a record.

    The numbers of the muscle's own laws go with them.

    **Arguments:**

    - `record`, `muscle`, `parameters`, `priors`: as of `fit`.
    - `buckling`, `collapse`, `post_collapse`: names of the laws to choose from; left out, all,
      but for buckling laws that never ask a collapse law.
    - `options`: loss, weights, starts and seed, as of `fit`.

    **Returns:** a row for each, the least AIC first.
    """
    data, rows = select_fit_data(record), []
    kinds = ("buckling", "collapse", "post_collapse")
    for names in itertools.product(buckling, collapse, post_collapse):
        pairs = zip(kinds, names, strict=True)
        laws = {kind: name for kind, name in pairs if name != getattr(muscle, kind).name}
        other = muscle.replace(**laws)
        # a constant of a law is free with that law alone; a name that nobody knows is refused
        gone = parameters_of(muscle).keys() - parameters_of(other).keys()
        free = None if parameters is None else [name for name in parameters if name not in gone]
        known = {name: prior for name, prior in (priors or {}).items() if name not in gone}
        fitted = fit_data(data, other, free, known, FitOptions(**options))
        rows.append(row(", ".join(names), fitted))
    return ranked(rows)


def compare_tension(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    **options: Any,
) -> list[Row]:
    """Fit all tension laws and the published empirical one to a record, each with its own
    constants.

    **Arguments:**

    - `record`: the measured readings.
    - `muscle`: nominal sizes.
    - `parameters`: what is free of the muscle's own law; those that other laws have as well
      are tried with them too. Left out, each law's usual ones. All are tried with and without a
      dead band.
    - `priors`: as of `fit`, for those laws that have the parameter.
    - `options`: loss, weights, starts and seed, as of `fit`.

    **Returns:** a row for each, the least AIC first.
    """
    data = select_fit_data(record)
    fits = tension_fits(data, muscle, parameters, priors, FitOptions(**options))
    rows = [row(label, calibration) for label, calibration in fits.items()]
    published = compare_published(next(iter(fits.values())))
    return ranked([*rows, *(one for one, _ in published)])


def tension_fits(
    data: FitData,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    options: FitOptions,
) -> dict[str, Calibration]:
    """Fits of `compare_tension` by label; arguments as there."""
    fits, own, asked = {}, muscle.tension.name, list(parameters or ())
    muscle = with_optional_laws(muscle, asked)
    for law, kind in {own: type(muscle.tension), **LAWS["tension"]}.items():
        if kind.made_for and law != own:
            continue  # its constants are another muscle's
        usual, with_law = kind.usually_free(), muscle if law == own else muscle.replace(tension=law)
        known = parameters_of(with_law)
        more = [n for n in asked if n not in muscle.tension.usually_free() and n in known]
        bases = [asked or usual] if law == own else [usual, [*usual, *more]]
        sets = [(*base, *band) for base in bases for band in ((), ("dead_band",))]
        for names in dict.fromkeys(tuple(dict.fromkeys(one)) for one in sets):
            given = {name: prior for name, prior in (priors or {}).items() if name in names}
            label = f"{kind.title or law}: {', '.join(names)}"
            fits[label] = fit_data(data, with_law, names, given, options)
    return fits


def row(label: str, calibration: Calibration) -> Row:
    """Row of a calibration, under this `label`."""
    free, unseen = len(calibration.names), left_out_force(calibration)
    return _row(label, free, calibration.force, unseen, calibration, calibration.status)


def ranked(rows: Sequence[Row]) -> list[Row]:
    """Rows by AIC, which with BIC is counted from the least."""
    aic, bic = min(one.aic for one in rows), min(one.bic for one in rows)
    counted = [replace(one, aic=one.aic - aic, bic=one.bic - bic) for one in rows]
    return sorted(counted, key=lambda one: one.aic)


def _row(
    label: str,
    free: int,
    force: np.ndarray,
    unseen: np.ndarray,
    calibration: Calibration,
    status: str,
) -> Row:
    grid, top = calibration.grid, largest_force(calibration.record)

    def rmse(force: np.ndarray) -> float:
        used = grid.measured & np.isfinite(force)
        squares = (grid.force - force)[used] ** 2
        return float(np.sqrt(np.average(squares, weights=grid.count[used])))

    seen, left = rmse(force), rmse(unseen)
    n, cost = int(np.sum(grid.used)), deviance(grid, force)
    pull = float(np.max(force[grid.used & grid.censored], initial=0.0))
    aic, bic = cost + 2 * free, cost + free * float(np.log(n))
    return Row(label, free, seen, left, seen / top, left / top, aic, bic, status, pull)


def deviance(grid: Grid, force: np.ndarray) -> float:
    """(C13) of a law's `force` [N], less how many forces were measured: without clipped ones that
    number times the logarithm of the mean square.
    """
    used, clipped = grid.measured, grid.used & grid.censored
    n, top = int(np.sum(used)), float(np.max(np.abs(grid.force[used]), initial=1e-300))
    squares = float(np.sum(grid.count[used] * (grid.force - force)[used] ** 2))
    excess = (np.sqrt(grid.count) * (force - grid.force))[clipped]
    alone = np.log(max(np.sqrt(squares / max(n, 1)), _FINEST * top))

    def value(log_noise: float) -> float:
        noise = np.exp(log_noise)
        lost = -2 * float(np.sum(log_ndtr(-excess / noise)))
        return 2 * n * log_noise + squares / noise**2 - n + lost

    if not excess.size:
        return value(alone)
    bounds = (alone - _WIDE, alone + _WIDE)
    least = minimize_scalar(value, bounds=bounds, method="bounded", options={"xatol": 1e-10})
    return min(float(least.fun), value(alone))


def compare_published(calibration: Calibration) -> list[tuple[Row, np.ndarray]]:
    """Sárosi's law as published and refitted to a calibration's record, and their forces [N] at
    the places of its grid.
    """
    grid, muscle = calibration.grid, calibration.start
    published = sarosi(SAROSI_DMSP_20_200N, grid)
    refitted, unseen = sarosi(fit_sarosi(grid), grid), np.full(grid.force.shape, np.nan)
    for fold in folds(grid):
        unseen[fold] = sarosi(fit_sarosi(grid.without(fold)), grid)[fold]
    label = "Sárosi, as published for a DMSP-20-200N"
    if not diameter_matches(muscle, _DIAMETER):
        widths = (pretty(x, "length") for x in (_DIAMETER, 2 * float(muscle.outer_radius)))
        label += ": {} wide, this muscle {}".format(*widths)
    return [
        (_row(label, 0, published, published, calibration, "not fitted"), published),
        (_row("Sárosi, refitted", 6, refitted, unseen, calibration, "converged"), refitted),
    ]


def sarosi(constants: np.ndarray, grid: Grid) -> np.ndarray:
    """Force [N] by (C5) at the places of a `grid`, with the six `constants`."""
    a, b, c, d, e, f = constants
    p, kappa = grid.pressure / 1e5, grid.strain / 1e-2
    return (a * p + b) * np.exp(c * kappa) + d * p * kappa + e * p + f


def fit_sarosi(grid: Grid) -> np.ndarray:
    """The six constants that fit a `grid` best, clipped readings as (C2) has them, with the noise
    that the others leave.
    """
    weight, clipped, first = np.sqrt(grid.count), grid.censored, SAROSI_DMSP_20_200N
    free = max(int(np.sum(grid.measured)) - first.size, 1)
    noise, share = _FIRST_NOISE * float(np.max(np.abs(grid.force))), np.ones(first.size)

    def residuals(share: np.ndarray) -> np.ndarray:
        # constants of unlike size are moved in proportion to the published ones
        mu = sarosi(share * first, grid)
        not_above = np.sqrt(-2 * log_ndtr(np.minimum((grid.force - mu) / noise, 30.0)))
        return (weight * np.where(clipped, not_above, (mu - grid.force) / noise)).reshape(-1)

    for _ in range(_ROUNDS):
        share = least_squares(residuals, share, method="lm", xtol=1e-12, ftol=1e-12).x
        left = np.where(clipped, 0.0, weight * (sarosi(share * first, grid) - grid.force))
        before, noise = noise, max(float(np.sqrt(np.sum(left**2) / free)), _LEAST * noise)
        if not np.any(clipped & grid.used) or abs(noise / before - 1) < _SETTLED:
            break
    return share * first
