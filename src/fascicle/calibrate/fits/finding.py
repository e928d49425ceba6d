"""Finding the fit: what a record can tell is tried, and chosen by readings that were left out.

Where a muscle pulls, the tension law is all of the model, so what is free of it is chosen there
first, on the record as a gauge that only pulls would have seen it. Tried are the muscle as given,
sets of its constants, and the paper's tuning. Where the record shows what resists, the best set
and the paper's tuning are then fitted with the factors on all that resists, to all readings.

A candidate is judged by its error at pressures that it did not see, or at strains where there are
too few pressures. Of those that are no worse than the best the one with the fewest constants is
taken: what the data don't ask for isn't fitted.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.validation import check_choice
from ...muscle import Muscle
from ...records.record import Record
from ...repr_table import with_table_repr
from ..after.calibration import Calibration, largest_force
from ..after.leaving_out import folds, parts, without
from ..after.printing import choice_sheet
from ..after.remainder import beside, span
from ..data.grid import WEIGHTS, Grid
from ..data.pulling import force_of, untuned
from ..data.readings import read, tables_of
from ..data.taking import TELLING, Taken, pulling_of, taken
from ..problem.beginning import STARTS, Prior, Search, begun, on_length
from ..problem.linear import linear
from ..problem.misfit import LOSSES
from ..problem.parameters import named, put
from ..problem.searching import places_of, settled
from .candidates import ACTIVE, WALL, grown, sets, widened, with_laws
from .choosing import (
    AS_GIVEN,
    TUNING,
    Candidate,
    Trial,
    chosen,
    differences,
    impossible,
    marked,
    reasons,
    too_long,
    trial,
)
from .fitting import fitted
from .resisting import FACTOR_NAMES, resisting


_LONGEST = 64  # readings at a pressure while candidates are tried
_APART = 1e-3  # of a constant's effect on the force: less than that others have, too
_STARTS = 2  # places each begins from, beside where the one before it ended


@with_table_repr(choice_sheet)
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
    if 0 < of.pushing < TELLING:
        of = pulling_of(of)
    search = Search(loss, weights, starts, seed, whole=False)
    check_choice(loss, LOSSES, "loss")
    check_choice(weights, WEIGHTS, "weights")
    if given:
        named(list(given), widened(muscle))  # refuses what no muscle has
    tell("trying what the record can tell")
    trials, noise = _tension(pulling_of(of, _LONGEST), muscle, given, search)
    if not trials:  # nothing pulls: the fit says what is missing
        return Choice(fitted(of, muscle, None, None, replace(search, whole=True)))
    if of.pulls:
        best = chosen(trials, noise, loss)
        tell("fitting")
        tuning = best.candidate.method == "tuning"
        names = None if tuning else best.candidate.names
        told = {name: prior for name, prior in given.items() if name in (names or ())}
        made = fitted(of, muscle, names, told, replace(search, tune=tuning))
        return Choice(made, marked(trials, best), reasons(trials, best, parts(of.data)))
    tell("fitting what resists")
    search = replace(search, whole=True)
    best = chosen([one for one in trials if one.candidate.method == "constants"], noise, loss)
    muscle = with_laws(muscle, best.candidate.names)
    last, fits = resisting(of, muscle, given, search, best.candidate.names)
    end = chosen(last, noise, loss)
    told = (
        f"Where the muscle pulls {best.candidate.label} is best.",
        *differences(trials, best),
        *impossible(trials),
        *reasons(last, end, parts(of.data)),
    )
    every = (*marked(trials, best), *marked(last, end))
    return Choice(fits[last.index(end)], every, told)


def _tension(
    of: Taken, muscle: Muscle, given: Mapping[str, Prior], search: Search
) -> tuple[list[Trial], float]:
    """What can be free where the muscle pulls, each with its left-out error; and the noise of a
    reading [N], 0 where it can't be seen.
    """
    measured = int(np.sum(of.data.uncensored))
    if not measured:
        return [], 0.0
    always = [name for name in given if name not in FACTOR_NAMES]
    trials: list[Trial] = []
    ends: dict[frozenset[str], dict[str, float]] = {}  # coordinates where each set ended

    def tried(names: tuple[str, ...]) -> None:
        if len(names) < measured and frozenset(names) not in ends:
            told = {name: prior for name, prior in given.items() if name in names}
            near = ends.get(_nested(trials, names), {})
            begin = replace(search, near=near, starts=min(search.starts, _STARTS))
            law = with_laws(muscle, names)
            made, ends[frozenset(names)] = _constants(of, law, names, told, begin)
            trials.append(made)

    for names in sets(muscle, always):
        tried(names)
    noise = read(muscle, on_length(of.data, of.record, muscle)).noise
    if any(one.judged for one in trials):
        usual = {*muscle.tension.usually_free(), WALL}
        others = [
            name for name in _telling(of, widened(muscle), search, usual) if name not in usual
        ]
        grown(lambda: chosen(trials, noise, search.loss).candidate.names, others, always, tried)
    # a tuning has no place for what is known of constants
    tuning = [] if always else _tuning(of, muscle, search.loss)
    return [*trials[:1], *tuning, *trials[1:]], noise


def _telling(of: Taken, muscle: Muscle, search: Search, usual: Collection[str]) -> list[str]:
    """Constants that move the force of a `muscle` where it was measured to pull, each in a way
    that those before it and the wall don't [-], the `usual` ones [-] first.
    """
    problem, _ = begun(of, muscle, ("braid_angle",), {}, search)
    freed = replace(problem, free=np.ones(len(problem.parameters), dtype=bool))
    slopes = linear(freed, np.asarray(problem.center)).force_slopes[problem.data.uncensored]
    slopes = np.nan_to_num(slopes)
    names = [one.name for one in problem.parameters]
    found, basis = [], np.zeros((len(slopes), 0))
    for i in sorted(range(len(names)), key=lambda i: names[i] not in usual):
        own = beside(basis, slopes[:, i])
        if np.linalg.norm(own) > _APART * np.linalg.norm(slopes[:, i]):
            found.append(names[i])
            basis = span(np.column_stack([basis, own]))
    return found


def _constants(
    of: Taken,
    muscle: Muscle,
    names: tuple[str, ...],
    priors: Mapping[str, Prior],
    search: Search,
) -> tuple[Trial, dict[str, float]]:
    """A set of constants, and the coordinates where its search ended [-]."""
    near: dict[str, float] = {}
    problem, _ = begun(of, muscle, names or ("braid_angle",), priors, search)
    every, wrong = np.asarray(problem.center), ""
    if names:
        problem, _, every, _ = settled(problem, problem.whole(places_of(problem, search)), None)
        if ACTIVE in names and ACTIVE not in priors:
            found = put(problem.fitted, problem.muscle, every[problem.chosen])
            wrong = too_long(float(found.length), of.record.rest_length or float(muscle.length))
        if not wrong:
            names_there = [one.name for one in problem.fitted]
            near = dict(zip(names_there, every[problem.chosen].tolist(), strict=True))
    else:
        problem = replace(problem, free=np.zeros(len(problem.parameters), dtype=bool))
    force = linear(problem, every).force
    unseen = np.full(force.shape, np.nan) if names else force
    for fold in folds(problem.data) if names else ():
        unseen[fold] = without(problem, every, fold)[fold]
    return _trial(of, names, "constants", len(names), force, unseen, search.loss, wrong), near


def _nested(trials: Sequence[Trial], names: tuple[str, ...]) -> frozenset[str]:
    """The best set of constants so far that `names` [-] hold all of: a search that begins where it
    ended can't err more than it.
    """
    within = [
        one.candidate
        for one in trials
        if one.candidate.names and not one.impossible and set(one.candidate.names) <= set(names)
    ]
    best = min(within, key=lambda one: one.rmse, default=None)
    return frozenset() if best is None else frozenset(best.names)


def _tuning(of: Taken, muscle: Muscle, loss: str) -> list[Trial]:
    """The paper's tuning where the muscle pulls, if blocked force and free strain can be read."""
    data, count = on_length(of.data, of.record, muscle), np.asarray(of.data.count)
    law, P, strain = untuned(muscle), np.asarray(data.pressure), np.asarray(data.strain)

    def forces(seen: Grid) -> tuple[np.ndarray, int] | None:
        readings = read(muscle, seen)
        if not np.any(readings.valid):
            return None
        c1, c2 = (x[:, None] for x in tables_of(muscle, readings, P[:, 0]))
        return c2 * (force_of(law, P, strain)[0] - c1), readings.order + 3

    first = forces(data)
    if first is None:
        return []
    unseen = np.full(count.shape, np.nan)
    for fold in folds(data):
        found = forces(replace(data, count=np.where(fold, 0.0, count)))
        if found is not None:
            unseen[fold] = found[0][fold]
    return [_trial(of, (), "tuning", first[1], first[0], unseen, loss)]


def _trial(
    of: Taken,
    names: tuple[str, ...],
    method: str,
    constants: int,
    force: np.ndarray,
    unseen: np.ndarray,
    loss: str,
    wrong: str = "",
) -> Trial:
    label = ", ".join(names) or (AS_GIVEN if method == "constants" else TUNING)
    strain, top = np.asarray(of.data.strain), largest_force(of.record)
    errors, left = of.errors(force, strain), of.errors(unseen, strain)
    return trial(label, names, method, constants, errors, left, loss, top, impossible=wrong)
