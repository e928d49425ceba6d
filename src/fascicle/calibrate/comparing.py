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

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..muscle import Muscle
from ..muscle.buckling import BUCKLING_LAWS
from ..muscle.collapse import COLLAPSE_LAWS, POST_COLLAPSE_LAWS
from ..records.record import Record
from .alternatives import collapse_named, post_collapse_named
from .calibration import Calibration, largest_force, root_mean_square
from .fitting import Prior, fit
from .problem import Problem, Vector
from .reference import SAROSI_DMSP_20_200N, refitted, sarosi
from .solving import solve
from .tuned import left_out


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
    buckling: Sequence[str] = tuple(BUCKLING_LAWS),
    collapse: Sequence[str] = tuple(COLLAPSE_LAWS),
    post_collapse: Sequence[str] = tuple(POST_COLLAPSE_LAWS),
) -> list[Row]:
    """Every choice of buckling, collapse and post-collapse law, fitted to a record.

    **Arguments:**

    - `record`, `muscle`, `parameters`, `priors`: as `fit` [-].
    - `buckling`, `collapse`, `post_collapse`: names of the laws to choose from [-].

    **Returns:** a row for each, the least AIC first [-].
    """
    rows = []
    for names in itertools.product(buckling, collapse, post_collapse):
        other = _with(
            muscle,
            buckling=names[0],
            collapse=collapse_named(names[1]),
            post_collapse=post_collapse_named(names[2]),
        )
        made = fit(record, other, parameters, priors)
        rows.append(row(", ".join(names), made))
    return ranked(rows)


def compare_tension(record: Record, muscle: Muscle) -> list[Row]:
    """Tension laws and the published empirical one, each with its own constants.

    **Arguments:**

    - `record`: what was measured [-].
    - `muscle`: nominal sizes [-].

    **Returns:** a row for each, the least AIC first [-].
    """
    fits = {
        f"{label}: {', '.join(free)}": fit(record, _with(muscle, tension=law), free)
        for label, law, free in _TENSION
    }
    rows = [row(label, made) for label, made in fits.items()]
    return ranked([*rows, *_sarosi(next(iter(fits.values())))])


def left_out_errors(made: Calibration) -> np.ndarray:
    """Errors [N] at each level of pressure of a fit to all the others; NaN where clipped."""
    levels = jnp.arange(made.problem.data.count.shape[0])
    if made.method == "tuning":
        errors = _tuned_without(made.problem, jnp.asarray(made.coordinates), levels)
    else:
        errors = _fitted_without(made.problem, jnp.asarray(made.coordinates), levels)
    return np.where(np.asarray(made.problem.data.uncensored), np.asarray(errors), np.nan)


def row(label: str, made: Calibration) -> Row:
    """A calibration's row [-], under this `label` [-]."""
    data = made.problem.data
    count = np.asarray(data.count)
    unseen = root_mean_square(left_out_errors(made), count)
    return _row(label, len(made.names), made.residual, unseen, made.problem, made.status)


def ranked(rows: Sequence[Row]) -> list[Row]:
    """Rows [-] by AIC, which with BIC is counted from the least."""
    aic, bic = min(one.aic for one in rows), min(one.bic for one in rows)
    counted = [replace(one, aic=one.aic - aic, bic=one.bic - bic) for one in rows]
    return sorted(counted, key=lambda one: one.aic)


# name in the table, law, free constants: two for each correction of the ideal law
_TENSION = (
    ("Klute-Hannaford", "klute_hannaford", ("c10", "c01", "braid_angle", "outer_radius")),
    ("ideal", "ideal", ("braid_angle", "outer_radius")),
    ("Tondu-Lopez", "tondu_lopez", ("strain_factor", "outer_radius")),
    ("Meller", "meller2014", ("strain_factor", "force_factor")),
    ("Kothera", "kothera2009", ("youngs_modulus", "braid_angle", "outer_radius")),
)


def _with(muscle: Muscle, **laws: Any) -> Muscle:
    """`muscle` with other laws, by name or as they are."""
    names = ("length", "outer_radius", "wall_thickness", "braid_angle", "material", "tension",
             "buckling", "collapse", "post_collapse", "transition_rate", "tuning")  # fmt: skip
    given: dict[str, Any] = {name: getattr(muscle, name) for name in names}
    return Muscle(**{**given, **laws})


def _row(
    label: str, free: int, residual: np.ndarray, unseen: float, problem: Problem, status: str
) -> Row:
    rmse = root_mean_square(residual, np.asarray(problem.data.count))
    n, top = int(np.sum(np.isfinite(residual))), largest_force(problem)
    spread = n * np.log(rmse**2)
    return Row(
        label, free, rmse, unseen, rmse / top, unseen / top, float(spread + 2 * free),
        float(spread + free * np.log(n)), status,
    )  # fmt: skip


def _sarosi(made: Calibration) -> list[Row]:
    """Sárosi's law as published and refitted to the record of `made` [-]."""
    data = made.problem.data
    P, used = np.asarray(data.pressure), np.asarray(data.uncensored)

    def errors(constants: np.ndarray) -> np.ndarray:
        force = np.asarray(sarosi(jnp.asarray(constants), data.pressure, data.strain))
        return np.where(used, np.asarray(data.force) - force, np.nan)

    count = np.asarray(data.count)
    published = errors(np.asarray(SAROSI_DMSP_20_200N))
    again = errors(np.asarray(refitted(data, jnp.ones(count.shape))))
    unseen = np.full(count.shape, np.nan)
    for level in range(P.size):
        weight = jnp.ones(count.shape).at[level].set(0.0)
        unseen[level] = errors(np.asarray(refitted(data, weight)))[level]
    return [
        _row("Sárosi, as published for a DMSP-20-200N", 0, published,
             root_mean_square(published, count), made.problem, "not fitted"),
        _row("Sárosi, refitted", 6, again, root_mean_square(unseen, count), made.problem,
             "converged"),
    ]  # fmt: skip


@eqx.filter_jit
def _tuned_without(problem: Problem, z: Vector, levels: Array) -> Array:
    return jax.lax.map(lambda level: left_out(problem, z, level), levels)


@eqx.filter_jit
def _fitted_without(problem: Problem, z: Vector, levels: Array) -> Array:
    def one(level: Array) -> Float[Array, "reading"]:
        unseen = (jnp.arange(levels.size) == level)[:, None]
        seen = eqx.tree_at(lambda p: p.weight, problem, jnp.where(unseen, 0.0, problem.weight))
        again = solve(seen, z[None]).coordinates[0]
        return (problem.data.force - problem.force(again))[level]

    return jax.lax.map(one, levels)
