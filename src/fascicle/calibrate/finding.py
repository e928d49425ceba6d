"""Finding the fit: what a record can tell is tried, and chosen by readings that were left out.

Where a muscle pulls, the tension law is all of the model, so what is free of it is chosen there
first, on the record as a gauge that only pulls would have seen it. Tried are the muscle as given,
sets of its constants, and the paper's tuning. Where the record shows what resists, the best set
and the paper's tuning are then fitted with the factors on all that resists, to all readings.

A candidate is judged by its error at pressures that it did not see. Of those within 2 % of the
least the one with the fewest constants is taken: what the data don't ask for isn't fitted.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from .._checks import one_of
from ..muscle import Muscle
from ..records.record import Record
from .calibration import Calibration, largest_force, root_mean_square
from .candidates import longer, sets
from .choosing import AS_GIVEN, TUNING, Candidate, chosen, marked, reasons
from .fitting import STARTS, Prior, Search, begun, fitted, on_length, places_of, settled
from .grid import WEIGHTS, Grid
from .leaving_out import folds, without
from .linear import linear
from .parameters import named
from .misfit import LOSSES
from .pulling import force_of, untuned
from .readings import read, tables_of
from .resisting import FACTOR_NAMES, resisting
from .taking import Taken, pulling_of, taken


@dataclass(frozen=True, eq=False)
class Choice:
    """The calibration that was found for a record: `made`; the `candidates` it was chosen from;
    and the `reasons`, a line each.
    """

    made: Calibration
    candidates: tuple[Candidate, ...] = ()
    reasons: tuple[str, ...] = ()


def find(
    record: Record,
    muscle: Muscle,
    priors: Mapping[str, Prior] | None = None,
    *,
    loss: str = "linear",
    weights: str = "uniform",
    starts: int = STARTS,
    seed: int = 0,
    tell: Callable[[str], object] = lambda _: None,
) -> Choice:
    """Find out what a record can tell of a muscle, and fit that.

    **Arguments:**

    - `record`: what was measured [-].
    - `muscle`: sizes, laws and constants to begin with [-].
    - `priors`: what is known of some constants beforehand [-]; these are always free.
    - `loss`, `weights`, `starts`, `seed`: as `fit` [-].
    - `tell`: is told what is being done [-].

    **Returns:** the choice, with all that was tried [-].

    **Raises:** `ValueError` as `fit`.
    """
    of, given = taken(record), dict(priors or {})
    search = Search(loss, weights, starts, seed, whole=False)
    one_of(loss, LOSSES, "loss")
    one_of(weights, WEIGHTS, "weights")
    if given:
        named(list(given), muscle)  # refuses what no muscle has
    tell("trying what the record can tell")
    rows = _tension(pulling_of(of), muscle, given, search)
    if not rows:  # nothing pulls: the fit says what is missing
        return Choice(fitted(of, muscle, None, None, replace(search, whole=True)))
    if of.pulls:
        best = chosen(rows)
        tell("fitting")
        names = None if best.method == "tuning" else best.names
        told = {name: prior for name, prior in given.items() if name in (names or ())}
        made = fitted(of, muscle, names, told, search)
        return Choice(made, marked(rows, best), reasons(rows, best))
    tell("fitting what resists")
    search = replace(search, whole=True)
    best = chosen([one for one in rows if one.method == "constants"])
    last, fits = resisting(of, muscle, given, search, best.names)
    taken_ = chosen(last)
    told = (f"Where the muscle pulls {best.label} is best.", *reasons(last, taken_))
    every = (*marked(rows, best), *marked(last, taken_))
    return Choice(fits[last.index(taken_)], every, told)


def _tension(
    of: Taken, muscle: Muscle, given: Mapping[str, Prior], search: Search
) -> list[Candidate]:
    """What can be free where the muscle pulls, each with its left-out error."""
    measured = int(np.sum(of.data.uncensored))
    if not measured:
        return []
    always = [name for name in given if name not in FACTOR_NAMES]
    rows, near = [], {}

    def tried(names: tuple[str, ...]) -> None:
        if len(names) < measured:
            told = {name: prior for name, prior in given.items() if name in names}
            rows.append(_constants(of, muscle, names, told, replace(search, near=dict(near)), near))

    for names in sets(muscle, always):
        tried(names)
    for names in longer(chosen(rows).names):
        tried(names)
    # a tuning has no place for what is known of constants
    tuning = [] if always else _tuning(of, muscle)
    return [*rows[:1], *tuning, *rows[1:]]


def _constants(
    of: Taken,
    muscle: Muscle,
    names: tuple[str, ...],
    priors: Mapping[str, Prior],
    search: Search,
    near: dict[str, float],
) -> Candidate:
    """A set of constants; where it ended is noted in `near`, for the next to begin from."""
    problem, _ = begun(of, muscle, names or ("braid_angle",), priors, search)
    every, noise = np.asarray(problem.center), float(problem.noise)
    if names:
        problem, _, every, _ = settled(problem, problem.whole(places_of(problem, search)), None)
        near.update({one.name: every[i] for one, i in zip(problem.fitted, problem.chosen)})
    else:
        problem = replace(problem, free=jnp.zeros(len(problem.parameters), dtype=bool))
    used, count = problem.data.uncensored, np.asarray(problem.data.count)
    force = np.asarray(problem.data.force)
    errors = np.where(used, force - linear(problem, every).force, np.nan)
    unseen = np.full(errors.shape, np.nan)
    for fold in folds(problem.data) if names else ():
        unseen[fold] = without(problem, every, fold)[fold]
    unseen = np.where(used, unseen if names else errors, np.nan)
    return _candidate(of, names, "constants", len(names), errors, unseen, count, search.loss)


def _tuning(of: Taken, muscle: Muscle) -> list[Candidate]:
    """The paper's tuning where the muscle pulls, if blocked force and free strain can be read."""
    data, count = on_length(of.data, of.record, muscle), np.asarray(of.data.count)
    law, used = untuned(muscle), of.data.uncensored
    P, strain = np.asarray(data.pressure), np.asarray(data.strain)

    def missed(seen: Grid) -> tuple[np.ndarray, int] | None:
        readings = read(muscle, seen)
        if not np.any(readings.valid):
            return None
        c1, c2 = (x[:, None] for x in tables_of(muscle, readings, P[:, 0]))
        force = c2 * (force_of(law, P, strain)[0] - c1)
        return np.asarray(data.force) - force, readings.order + 3

    first = missed(data)
    if first is None:
        return []
    errors, constants = first
    unseen = np.full(errors.shape, np.nan)
    for fold in folds(data):
        found = missed(replace(data, count=jnp.asarray(np.where(fold, 0.0, count))))
        unseen[fold] = np.nan if found is None else found[0][fold]
    errors, unseen = (np.where(used, x, np.nan) for x in (errors, unseen))
    return [_candidate(of, (), "tuning", constants, errors, unseen, count, "linear")]


def _candidate(
    of: Taken,
    names: tuple[str, ...],
    method: str,
    constants: int,
    errors: np.ndarray,
    unseen: np.ndarray,
    count: np.ndarray,
    loss: str,
) -> Candidate:
    label = ", ".join(names) or (AS_GIVEN if method == "constants" else TUNING)
    used = np.isfinite(errors)
    rmse = root_mean_square(errors, count)
    left = float("nan")
    if np.all(np.isfinite(unseen[used])):
        left = root_mean_square(unseen, count)
        if loss != "linear":  # what a robust fit plays down must not decide
            left = 1.4826 * float(np.median(np.abs(unseen[used])))
    top = largest_force(of.record)
    return Candidate(label, names, method, constants, rmse, left, rmse / top, left / top)
