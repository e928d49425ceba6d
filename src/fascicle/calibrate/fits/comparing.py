r"""Which law tells a record best, and which one tells what it has not seen.

Each row fits one choice of laws. It is compared by how likely it makes all $n$ readings, clipped
ones too (C13), and by what its $k$ free constants cost,

$$\mathrm{AIC} = -2 \ln L + 2k, \qquad \mathrm{BIC} = -2 \ln L + k \ln n \tag{C6}$$

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

from ...core.types import AnyArray, Float
from ...muscle import Muscle
from ...muscle.laws import LAWS
from ...muscle.validation import diameter_matches
from ...records.record import Record
from ...units import pretty
from ..after.calibration import Calibration, largest_force, root_mean_square
from ..after.leaving_out import folds, left_out_errors
from ..data.grid import Grid
from ..data.reference import DIAMETER, SAROSI_DMSP_20_200N, refitted, sarosi
from ..data.taking import Taken, taken
from ..problem.alternatives import collapse_named, post_collapse_named
from ..problem.beginning import Prior, Search
from ..problem.likelihood import deviance
from ..problem.parameters import of_muscle
from .candidates import BAND, with_laws
from .fitting import fitted


# a law that collapses by itself takes seconds for each force, and would come once for each choice
_BUCKLING = tuple(name for name, law in LAWS["buckling"].items() if getattr(law, "collapses", True))


@dataclass(frozen=True)
class Row:
    """One law against a record.

    - `label`: the law [-]. `free`: how many constants were fitted [-].
    - `rmse`, `left_out_rmse`: error [N] where it was fitted, and at pressures that it
      wasn't.
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force [-].
    - `aic`, `bic`: (C6) [-], less the least of a table.
    - `status`: how the fit ended [-].
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
    **search: Any,
) -> list[Row]:
    """Every choice of buckling, collapse and post-collapse law, fitted to a record.

    The numbers of the muscle's own laws go with them, a factor on its collapse law among them.

    **Arguments:**

    - `record`, `muscle`, `parameters`, `priors`: as `fit` [-].
    - `buckling`, `collapse`, `post_collapse`: names of the laws to choose from [-]; left out, all,
      but for buckling laws that never ask a collapse law.
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
    - `parameters`: what is free of the muscle's own law [-]; those that other laws have as well
      are tried with them too. Left out, each law's usual ones. All are tried with and without a
      dead band.
    - `priors`: as `fit` [-], for those laws that have the parameter.
    - `search`: loss, weights, starts and seed, as `fit` [-].

    **Returns:** a row for each, the least AIC first [-].
    """
    fits = tension_fits(taken(record), muscle, parameters, priors, Search(**search))
    rows = [row(label, made) for label, made in fits.items()]
    return ranked([*rows, *(one for one, _ in compare_published(next(iter(fits.values()))))])


def tension_fits(
    of: Taken,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    search: Search,
) -> dict[str, Calibration]:
    """The fits of `compare_tension` by label [-]; arguments as there, `of` what was taken of a
    record [-].
    """
    fits, own, asked = {}, muscle.tension.name, list(parameters or ())
    muscle = with_laws(muscle, asked)
    for law, kind in {own: type(muscle.tension), **LAWS["tension"]}.items():
        if kind.made_for and law != own:
            continue  # its constants are another muscle's
        free, with_law = kind.usually_free(), muscle if law == own else muscle.replace(tension=law)
        every = of_muscle(with_law)
        more = [one for one in asked if one not in muscle.tension.usually_free() and one in every]
        bases = [asked or free] if law == own else [free, [*free, *more]]
        sets = [[*base, *band] for base in bases for band in ((), (BAND,))]
        for names in dict.fromkeys(tuple(dict.fromkeys(one)) for one in sets):
            told = {name: prior for name, prior in (priors or {}).items() if name in names}
            label = f"{kind.title or law}: {', '.join(names)}"
            fits[label] = fitted(of, with_law, names, told, search)
    return fits


def row(label: str, made: Calibration) -> Row:
    """A calibration's row [-], under this `label` [-]."""
    unseen = root_mean_square(left_out_errors(made), np.asarray(made.data.count))
    return _row(label, len(made.names), made.force, unseen, made, made.status)


def ranked(rows: Sequence[Row]) -> list[Row]:
    """Rows [-] by AIC, which with BIC is counted from the least."""
    aic, bic = min(one.aic for one in rows), min(one.bic for one in rows)
    counted = [replace(one, aic=one.aic - aic, bic=one.bic - bic) for one in rows]
    return sorted(counted, key=lambda one: one.aic)


def _row(
    label: str, free: int, force: np.ndarray, unseen: float, made: Calibration, status: str
) -> Row:
    data, top = made.data, largest_force(made.record)
    rmse = root_mean_square(_missed(data, force), np.asarray(data.count))
    clipped = (np.asarray(data.count) > 0) & np.asarray(data.censored)
    n, cost = int(np.sum(np.asarray(data.count) > 0)), deviance(data, force)
    return Row(
        label, free, rmse, unseen, rmse / top, unseen / top, cost + 2 * free,
        cost + free * float(np.log(n)), status, float(np.max(force[clipped], initial=0.0)),
    )  # fmt: skip


def _missed(data: Grid, force: np.ndarray) -> np.ndarray:
    """Measured less a law's `force` [N], NaN where it is clipped."""
    return np.where(data.uncensored, np.asarray(data.force) - force, np.nan)


def compare_published(made: Calibration) -> list[tuple[Row, np.ndarray]]:
    """Sárosi's law as published and refitted to the record of `made` [-], and their forces [N] at
    its places.
    """
    data = made.data
    every, count = np.broadcast_to(data.pressure, data.strain.shape), np.asarray(data.count)

    def force(constants: Float[AnyArray, "6"]) -> np.ndarray:
        return np.asarray(sarosi(constants, every, np.asarray(data.strain)))

    published, again = force(np.asarray(SAROSI_DMSP_20_200N)), force(refitted(data, 0 * count + 1))
    unseen = np.full(count.shape, np.nan)
    for fold in folds(data):
        unseen[fold] = force(refitted(data, np.where(fold, 0.0, 1.0)))[fold]
    left = root_mean_square(_missed(data, published), count)
    label = f"Sárosi, as published for a DMSP-20-200N{_other(made.start)}"
    missed = root_mean_square(_missed(data, unseen), count)
    return [
        (_row(label, 0, published, left, made, "not fitted"), published),
        (_row("Sárosi, refitted", 6, again, missed, made, "converged"), again),
    ]


def _other(muscle: Muscle) -> str:
    """That published constants are of another diameter than a `muscle`'s, if they are."""
    if diameter_matches(muscle, DIAMETER):
        return ""
    wide, own = (pretty(x, "length") for x in (DIAMETER, 2 * float(muscle.outer_radius)))
    return f": {wide} wide, this muscle {own}"
