r"""Comparison of laws on one record, by likelihood and by cross-validation.

Each row fits one choice of laws. It is compared by the likelihood $L$ of all $n$ readings, clipped
ones included, with a penalty for its $k$ free constants,

$$\mathrm{AIC} = -2 \ln L + 2k, \qquad \mathrm{BIC} = -2 \ln L + k \ln n \tag{C6}$$

A measured force has a normal density about the law's, a clipped one the probability of a force
below the floor:

$$-2 \ln L = \sum_{measured} \left[\ln \sigma^2 + n r^2/\sigma^2\right]
  - 2 \sum_{clipped} \ln \Phi(\sqrt n\, (F - \mu)/\sigma), \tag{C13}$$

with the residual $r$ and the number $n$ of averaged readings, up to a constant that is the same for
all laws. $\sigma$ minimizes it. The fit is also repeated without each pressure in turn, and
compared by its error there. Laws whose constants were published for one muscle are compared as
published.

**Source:** Akaike (1974); Schwarz (1978); Tobin (1958).
"""

import itertools
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import log_ndtr

from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..records.record import Record
from .calibration import Calibration, largest_force
from .data import Grid, select_fit_data
from .fitting import FitOptions, Prior, fit_data
from .model_selection import left_out_force
from .parameters import RESISTING, parameters_of, with_optional_laws


_MIN_NOISE = 1e-9  # of the largest force: a smaller noise is rounding
_RANGE = 5.0  # of the noise's logarithm: clipped readings never change it by a factor of 150


@dataclass(frozen=True)
class Row:
    """One law against a record, with a number of `free` constants.

    - `rmse`, `left_out_rmse`: error [N] of the fit, and at pressures that it was not fitted to.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `aic`, `bic`: (C6), less the smallest of a table [-].
    - `status`: how the search ended, as of a `Calibration`.
    - `clipped_pull`: largest pull where a reading was clipped at zero [N]; 0 without any.
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


@dataclass(frozen=True, eq=False)
class LawComparison:
    """Laws compared on one record: `rows`, the smallest AIC first, and the `fits` by label."""

    rows: Sequence[Row]
    fits: Mapping[str, Calibration]


def compare(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    **options: Any,
) -> LawComparison:
    """Fit every combination of laws of resisting force to a record; other arguments as of `fit`. A
    law of the muscle keeps its constants.
    """
    data, fits = select_fit_data(record, muscle), {}
    for names in itertools.product(*(LAWS[kind] for kind in RESISTING)):
        pairs = zip(RESISTING, names, strict=True)
        replaced = {kind: name for kind, name in pairs if name != getattr(muscle, kind).name}
        variant = muscle.replace(**replaced)
        # constants of the replaced laws are left out; `fit_data` raises for unknown names
        dropped = parameters_of(muscle).keys() - parameters_of(variant).keys()
        free = None if parameters is None else [n for n in parameters if n not in dropped]
        law_priors = {name: prior for name, prior in (priors or {}).items() if name not in dropped}
        fits[", ".join(names)] = fit_data(data, variant, free, law_priors, FitOptions(**options))
    return _rank_fits(fits)


def compare_tension(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    **options: Any,
) -> LawComparison:
    """Fit all tension laws to a record, with their usual constants or the `parameters` that they
    have, with and without a dead band; other arguments as of `fit`.
    """
    data, settings = select_fit_data(record, muscle), FitOptions(**options)
    fits, present, requested = {}, muscle.tension.name, list(parameters or ())
    muscle = with_optional_laws(muscle, requested)
    for law, kind in {present: type(muscle.tension), **LAWS["tension"]}.items():
        if kind.reference_muscle and law != present:
            label = f"{kind.title or law}, as published for {kind.reference_muscle}"
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "`.*` was fitted to ")  # the label says so
                published = muscle.replace(tension=law)
            fits[label] = fit_data(data, published, (), {}, settings)
            continue
        usual = kind.fit_parameters()
        variant = muscle if law == present else muscle.replace(tension=law)
        available = parameters_of(variant).keys() - {*muscle.tension.fit_parameters()}
        extra = [name for name in requested if name in available]
        bases = [requested or usual] if law == present else [usual, [*usual, *extra]]
        sets = [(*base, *band) for base in bases for band in ((), ("dead_band",))]
        for names in dict.fromkeys(tuple(dict.fromkeys(names)) for names in sets):
            law_priors = {name: prior for name, prior in (priors or {}).items() if name in names}
            label = f"{kind.title or law}: {', '.join(names)}"
            fits[label] = fit_data(data, variant, names, law_priors, settings)
    return _rank_fits(fits)


def comparison_row(label: str, fitted: Calibration) -> Row:
    """Row of a calibration with this `label`."""
    grid, top, free = fitted.grid, largest_force(fitted.record), len(fitted.names)

    def rmse(force: np.ndarray) -> float:
        used = grid.measured & np.isfinite(force)
        squares = (grid.force - force)[used] ** 2
        return float(np.sqrt(np.average(squares, weights=grid.count[used])))

    error, left_out = rmse(fitted.force), rmse(left_out_force(fitted))
    n, cost = int(np.sum(grid.used)), deviance(grid, fitted.force)
    pull = float(np.max(fitted.force[grid.used & grid.censored], initial=0.0))
    aic, bic = cost + 2 * free, cost + free * float(np.log(n))
    relative = error / top, left_out / top
    return Row(label, free, error, left_out, *relative, aic, bic, fitted.status, pull)


def _rank_fits(fits: Mapping[str, Calibration]) -> LawComparison:
    """Comparison of `fits` by label, smallest AIC first; AIC and BIC less their smallest."""
    rows = [comparison_row(label, fitted) for label, fitted in fits.items()]
    aic, bic = min(row.aic for row in rows), min(row.bic for row in rows)
    relative = [replace(row, aic=row.aic - aic, bic=row.bic - bic) for row in rows]
    return LawComparison(sorted(relative, key=lambda row: row.aic), fits)


def deviance(grid: Grid, force: np.ndarray) -> float:
    """(C13) of a law's `force` [N] on a `grid`, less the number of measured forces [-]."""
    used, clipped = grid.measured, grid.used & grid.censored
    # never zero, for the logarithm below
    n, top = int(np.sum(used)), float(np.max(np.abs(grid.force[used]), initial=1e-300))
    squares = float(np.sum((grid.precision * (grid.force - force))[used] ** 2))
    excess = (grid.precision * (force - grid.force))[clipped]
    measured = np.log(max(np.sqrt(squares / max(n, 1)), _MIN_NOISE * top))

    def value(log_noise: float) -> float:
        noise = np.exp(log_noise)
        of_clipped = -2 * float(np.sum(log_ndtr(-excess / noise)))
        return 2 * n * log_noise + squares / noise**2 - n + of_clipped

    if not excess.size:
        return value(measured)
    bounds = (measured - _RANGE, measured + _RANGE)
    # 1e-10 of the logarithm: a minimum can be found to 1e-8 at best, which then ends the search
    minimum = minimize_scalar(value, bounds=bounds, method="bounded", options={"xatol": 1e-10})
    return min(float(minimum.fun), value(measured))
