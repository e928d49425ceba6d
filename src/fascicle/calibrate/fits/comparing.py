r"""Which law tells a record best, and which one tells what it has not seen.

Each row fits one choice of laws. Its error is compared by what it costs: with $n$ readings,
$k$ free constants and the noise $\sigma$ that remains,

$$\mathrm{AIC} = n \ln \sigma^2 + 2k, \qquad \mathrm{BIC} = n \ln \sigma^2 + k \ln n \tag{C6}$$

and by what it is for: the fit is repeated without each pressure in turn, and judged by its
error there. With the paper's tuning the blocked force and free strain that a left-out
pressure would have given are read off the smooth curves of the others.

**Source:** Akaike (1974); Schwarz (1978).
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...muscle import Muscle
from ...muscle.laws import LAWS
from ...records.record import Record
from ..after.calibration import Calibration, largest_force, root_mean_square
from ..after.leaving_out import left_out_errors
from ..data.reference import SAROSI_DMSP_20_200N, refitted, sarosi
from ..data.taking import taken
from ..problem.alternatives import collapse_named, post_collapse_named
from ..problem.beginning import Prior, Search
from ..problem.parameters import of_muscle
from .fitting import fitted


@dataclass(frozen=True)
class Row:
    """One law against a record.

    - `label`: the law [-]. `free`: how many constants were fitted [-].
    - `rmse`, `left_out_rmse`: error [N] where it was fitted, and at pressures that it
      wasn't.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `aic`, `bic`: (C6) [-], less the least of a table.
    - `status`: how the fit ended [-].
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


def compare(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    buckling: Sequence[str] = tuple(LAWS["buckling"]),
    collapse: Sequence[str] = tuple(LAWS["collapse"]),
    post_collapse: Sequence[str] = tuple(LAWS["post_collapse"]),
    **search: Any,
) -> list[Row]:
    """Every choice of buckling, collapse and post-collapse law, fitted to a record.

    The numbers of the muscle's own laws go with them, a factor on its collapse law among them.

    **Arguments:**

    - `record`, `muscle`, `parameters`, `priors`: as `fit` [-].
    - `buckling`, `collapse`, `post_collapse`: names of the laws to choose from [-].
    - `search`: loss, weights, starts and seed, as `fit` [-].

    **Returns:** a row for each, the least AIC first [-].
    """
    of, rows = taken(record), []
    for names in itertools.product(buckling, collapse, post_collapse):
        other = muscle.replace(
            buckling=muscle.buckling if names[0] == muscle.buckling.name else names[0],
            collapse=collapse_named(names[1], muscle.collapse),
            post_collapse=post_collapse_named(names[2], muscle.post_collapse),
        )
        # a constant of a law is free with that law alone; a name that nobody knows is refused
        gone = of_muscle(muscle).keys() - of_muscle(other).keys()
        free = None if parameters is None else [one for one in parameters if one not in gone]
        told = {name: prior for name, prior in (priors or {}).items() if name not in gone}
        rows.append(row(", ".join(names), fitted(of, other, free, told, Search(**search))))
    return ranked(rows)


def compare_tension(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    **search: Any,
) -> list[Row]:
    """Tension laws and the published empirical one, each with its own constants.

    **Arguments:**

    - `record`: what was measured [-].
    - `muscle`: nominal sizes [-].
    - `parameters`: what is free of the muscle's own law [-]; of these dead band and active length
      are free with every other law too. Left out, each law's usual ones.
    - `priors`: as `fit` [-], for those laws that have the parameter.
    - `search`: loss, weights, starts and seed, as `fit` [-].

    **Returns:** a row for each, the least AIC first [-].
    """
    of, fits = taken(record), {}
    own = muscle.tension.name
    for law, kind in {own: type(muscle.tension), **LAWS["tension"]}.items():
        label, free = kind.title or law, kind.usually_free()
        names = list(parameters or free) if law == own else list(free)
        names += [one for one in _ANY_LAW if one in (parameters or ()) and one not in names]
        with_law = muscle if law == own else muscle.replace(tension=law)
        told = {name: prior for name, prior in (priors or {}).items() if name in names}
        fits[f"{label}: {', '.join(names)}"] = fitted(of, with_law, names, told, Search(**search))
    rows = [row(label, made) for label, made in fits.items()]
    return ranked([*rows, *_sarosi(next(iter(fits.values())))])


_ANY_LAW = ("dead_band", "active_length")


def row(label: str, made: Calibration) -> Row:
    """A calibration's row [-], under this `label` [-]."""
    unseen = root_mean_square(left_out_errors(made), np.asarray(made.data.count))
    return _row(label, len(made.names), made.residual, unseen, made, made.status)


def ranked(rows: Sequence[Row]) -> list[Row]:
    """Rows [-] by AIC, which with BIC is counted from the least."""
    aic, bic = min(one.aic for one in rows), min(one.bic for one in rows)
    counted = [replace(one, aic=one.aic - aic, bic=one.bic - bic) for one in rows]
    return sorted(counted, key=lambda one: one.aic)


def _row(
    label: str, free: int, residual: np.ndarray, unseen: float, made: Calibration, status: str
) -> Row:
    rmse = root_mean_square(residual, np.asarray(made.data.count))
    n, top = int(np.sum(np.isfinite(residual))), largest_force(made.record)
    spread = n * np.log(rmse**2)
    return Row(
        label, free, rmse, unseen, rmse / top, unseen / top, float(spread + 2 * free),
        float(spread + free * np.log(n)), status,
    )  # fmt: skip


def _sarosi(made: Calibration) -> list[Row]:
    """Sárosi's law as published and refitted to the record of `made` [-]."""
    data = made.data
    P, used = np.asarray(data.pressure), data.uncensored
    every = np.broadcast_to(data.pressure, data.strain.shape)

    def errors(constants: np.ndarray) -> np.ndarray:
        force = sarosi(constants, every, data.strain)
        return np.where(used, np.asarray(data.force) - force, np.nan)

    count = np.asarray(data.count)
    published = errors(np.asarray(SAROSI_DMSP_20_200N))
    again = errors(np.asarray(refitted(data, np.ones(count.shape))))
    unseen = np.full(count.shape, np.nan)
    for level in range(P.size):
        weight = np.ones(count.shape)
        weight[level] = 0.0
        unseen[level] = errors(np.asarray(refitted(data, weight)))[level]
    return [
        _row("Sárosi, as published for a DMSP-20-200N", 0, published,
             root_mean_square(published, count), made, "not fitted"),
        _row("Sárosi, refitted", 6, again, root_mean_square(unseen, count), made,
             "converged"),
    ]  # fmt: skip
