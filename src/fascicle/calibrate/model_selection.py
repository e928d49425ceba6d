"""Model selection: candidates for what a record can tell, compared by cross-validation.

Where a muscle pulls, the tension law is all of the model, so what is free of it is selected there
first, on the record as a gauge that only pulls would have seen it. Candidates are the muscle as
given, then its sizes, its rubber, both, each with a dead band, and the paper's tuning. The rubber's
two constants are free together: one held at a value that nobody measured would make the others look
surer than they are. Then every other constant that moves the pull is tried beside the best of them:
each alone, again while one of them is worth it, and all together, of which what isn't worth it is
taken away again. What is known only as a product stays as given: the wall beside them. Where the
record shows what resists, the best set and the paper's tuning are then fitted with the factors on
all that resists, to all readings.

Pressures are left out one by one, or a few neighbors at a time where there are many; where there
are too few to interpolate between, stretches of strain are. Of the candidates that are no worse
than the best the one with the fewest constants is selected.

**Source:** Breiman et al. (1984) for the one-standard-error rule.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..core.errors import InvalidInputError
from ..muscle import Muscle
from ..muscle.materials import MooneyRivlin
from ..records.record import Record
from .calibration import Calibration, Candidate, Selection, Trial, largest_force
from .data import MIN_PUSHES, FitData, Grid, pulling_only, select_fit_data
from .diagnostics import held_slopes, project_out, span
from .fitting import STARTS, FitOptions, Prior, fit_data, on_length, set_up_problem, starts_of
from .least_squares import ROUGH, Problem, solve, solve_with_noise
from .messages import (
    AS_GIVEN,
    TUNING,
    exclusions,
    length_violation,
    marginal_gains,
    selection_reasons,
)
from .parameters import (
    FACTOR_NAMES,
    RUBBER,
    pulling_constants,
    put,
    select_parameters,
    with_optional_laws,
)
from .readings import SmoothCurves, pulling_force, read, top_pressure
from .tuning import refit_tuning


_TOLERANCE = 0.02  # of the least left-out error beyond noise: candidates that near it are as good
_STANDARD_ERRORS = 1.0  # of a difference: the one-standard-error rule
_OUTLIER = 3.0  # of the usual error: what a robust fit leaves counts no more
_RULER = 0.02  # of the length between the fittings: a ruler's error, generously
_MAX_READINGS = 64  # at a pressure while candidates are tried
_DISTINCT = 1e-3  # of a constant's effect on the force: less than that others have, too
_STARTS = 2  # points each begins from, beside where the one before it ended
_ROUNDS = 4  # of taking one more, or one less
_MAX_FOLDS = 24  # pressures that are left out one by one
_PARTS = 8  # parts that more pressures than these are left out in: each is a refit
_MIN_LEVELS = 3  # pressures; of fewer none can be left out
_STRETCHES = 6  # of strain
_BAND, _WALL, _ACTIVE = "dead_band", "wall_thickness", "active_length"

Names = tuple[str, ...]


def select_model(
    record: Record,
    muscle: Muscle,
    priors: Mapping[str, Prior] | None = None,
    *,
    loss: str = "linear",
    weights: str = "uniform",
    starts: int = STARTS,
    seed: int = 0,
    tell: Callable[[str], object] = lambda _: None,
) -> Selection:
    """Find out what a record can tell of a muscle, and fit that.

    **Arguments:**

    - `record`: the measured readings.
    - `muscle`: sizes, laws and constants to begin with.
    - `priors`: prior knowledge of some constants; these are always free.
    - `loss`, `weights`, `starts`, `seed`: as of `fit`.
    - `tell`: is called with the present step, in words.

    **Returns:** the selection, with all candidates.

    **Raises:** `ValueError` as `fit`.
    """
    data, priors = select_fit_data(record), dict(priors or {})
    if 0 < data.pushes < MIN_PUSHES:
        data = pulling_only(data)
    options = FitOptions(loss, weights, starts, seed, whole=False)
    if priors:
        select_parameters(list(priors), with_optional_laws(muscle))  # refuses unknown ones
    tell("trying what the record can tell")
    trials, noise = _pulling_trials(pulling_only(data, _MAX_READINGS), muscle, priors, options)
    if not trials:  # nothing pulls: the fit says what is missing
        return Selection(fit_data(data, muscle, None, None, replace(options, whole=True)))
    parts = "pressures" if _levels(data.grid).size >= _MIN_LEVELS else "stretches of strain"
    if data.pulls:
        best = select(trials, noise, loss)
        tell("fitting")
        tuning = best.candidate.method == "tuning"
        names = None if tuning else best.candidate.names
        known = {name: prior for name, prior in priors.items() if name in (names or ())}
        fitted = fit_data(data, muscle, names, known, replace(options, tune=tuning))
        reasons = selection_reasons(trials, best, parts)
        return Selection(fitted, _marked(trials, best), reasons)
    tell("fitting what resists")
    options = replace(options, whole=True)
    constants = [trial for trial in trials if trial.candidate.method == "constants"]
    best = select(constants, noise, loss)
    whole, fits = _whole_trials(data, muscle, priors, options, best.candidate.names)
    end = select(whole, noise, loss)
    reasons = (
        f"Where the muscle pulls, {best.candidate.label} is best.",
        *marginal_gains(trials, best),
        *exclusions(trials),
        *selection_reasons(whole, end, parts),
    )
    candidates = (*_marked(trials, best), *_marked(whole, end))
    return Selection(fits[whole.index(end)], candidates, reasons)


def make_trial(
    candidate: tuple[str, Names, str, int],
    errors: np.ndarray,
    unseen: np.ndarray,
    loss: str,
    top: float,
    readings: str = "pulling",
    violation: str = "",
) -> Trial:
    """A candidate with the size of its errors.

    **Arguments:**

    - `candidate`: its label, names, method and number of constants.
    - `errors`: where it was fitted, reading by reading [N]; NaN for clipped ones.
    - `unseen`: where it was left out, in the same way [N].
    - `loss`: of the fits.
    - `top`: the largest force measured [N].
    - `readings`, `violation`: as of `Candidate` and `Trial`.
    """
    rmse, left = cross_validated_error(errors, loss), cross_validated_error(unseen, loss)
    # others are compared on every reading: one that has no answer for some can't be among them
    if not np.all(np.isfinite(unseen) | ~np.isfinite(errors)):
        left = float("nan")
    sizes = rmse, left, rmse / top, left / top
    return Trial(Candidate(*candidate, *sizes, readings), unseen, violation)


def select(trials: Sequence[Trial], noise: float, loss: str) -> Trial:
    """Select the trial with the fewest constants among those that are no worse than the best.

    No worse is one whose squared errors exceed the best one's by no more than a standard error of
    their sum; or by 2 % of what the best one errs beyond the noise; or by what one reading has of
    them on average, since a constant may follow that much of any noise.

    **Arguments:**

    - `trials`: compared on the same readings.
    - `noise`: of a reading [N], as far as it is known.
    - `loss`: of the fits.

    **Raises:** `InvalidInputError` where no error is known.
    """
    valid = [trial for trial in trials if trial.valid]
    if not any(trial.candidate.constants for trial in valid):  # the muscle as given needs no fit
        raise InvalidInputError(
            "record",
            "is too short to leave readings out",
            None,
            "name what to fit, such as c10, c01",
        )
    best = min(valid, key=lambda trial: trial.candidate.left_out_rmse)
    far = _OUTLIER * best.candidate.left_out_rmse if loss != "linear" else np.inf
    squares = [np.minimum(t.unseen[np.isfinite(t.unseen)] ** 2, far**2) for t in valid]
    least = squares[valid.index(best)]
    mean = float(np.mean(least))
    tolerance = ((1 + _TOLERANCE) ** 2 - 1) * max(mean - noise**2, 0.0)
    good = []
    for trial, square in zip(valid, squares, strict=True):
        excess = square - least
        chance = _STANDARD_ERRORS * float(np.std(excess)) / np.sqrt(excess.size)
        if float(np.mean(excess)) <= max(chance, tolerance, mean / excess.size):
            good.append(trial)
    return min(good, key=lambda trial: (trial.candidate.constants, trial.candidate.left_out_rmse))


def cross_validated_error(errors: np.ndarray, loss: str) -> float:
    """Size of `errors` [N], NaN for clipped readings: their root mean square, or with a robust
    `loss` that of most of them, so that outliers don't decide.
    """
    known = errors[np.isfinite(errors)]
    if not known.size:
        return float("nan")
    if loss != "linear":
        return 1.4826 * float(np.median(np.abs(known)))
    return float(np.sqrt(np.mean(known**2)))


def folds(grid: Grid) -> list[np.ndarray]:
    """Parts of a `grid` to leave out, as masks of its places; each has something measured."""
    levels = _levels(grid)
    if levels.size >= _MIN_LEVELS:
        rows = np.arange(len(grid.count))[:, None]
        parts = np.array_split(levels, levels.size if levels.size <= _MAX_FOLDS else _PARTS)
        return [np.isin(rows, part) & grid.used for part in parts]
    ends = np.quantile(grid.strain[grid.measured], np.linspace(0, 1, _STRETCHES + 1))
    stretch = np.clip(np.searchsorted(ends, grid.strain, "right") - 1, 0, _STRETCHES - 1)
    masks = [(stretch == part) & grid.used for part in range(_STRETCHES)]
    return [mask for mask in masks if np.any(mask & grid.measured)]


def _levels(grid: Grid) -> np.ndarray:
    return np.flatnonzero(grid.measured.any(axis=1))


def refit_without(problem: Problem, point: np.ndarray, fold: np.ndarray) -> np.ndarray:
    """Forces [N] everywhere of a fit that did not see the places in a `fold`, begun from the
    `point` where the one that did ended.
    """
    if not point.size:
        return problem.force(point)
    rest = replace(problem, weight=np.where(fold, 0.0, problem.weight))
    return rest.force(solve(rest, point[None], tolerance=ROUGH).points[0])


def left_out_force(calibration: Calibration) -> np.ndarray:
    """Forces [N] at each place of a calibration's grid, of fits that did not see it."""
    problem, point, readings = calibration.problem, calibration.coordinates, calibration.readings
    force = np.full(problem.grid.force.shape, np.nan)
    for fold in folds(problem.grid):
        if readings is None:
            force[fold] = refit_without(problem, point, fold)[fold]
        else:
            rest, joint = problem.grid.without(fold), readings.pulling is not None
            again, tuned = refit_tuning(problem, point, rest, calibration.weights, joint)
            force[fold] = tuned.force(again)[fold]
    return force


def left_out_errors(calibration: Calibration) -> np.ndarray:
    """Errors [N] at each place of a calibration's grid, of fits that did not see it; NaN where
    none was measured, or it couldn't be left out.
    """
    grid = calibration.grid
    return np.where(grid.measured, grid.force - left_out_force(calibration), np.nan)


def _marked(trials: Sequence[Trial], best: Trial) -> tuple[Candidate, ...]:
    return tuple(replace(trial.candidate, chosen=trial is best) for trial in trials)


def base_parameter_sets(muscle: Muscle, always: Collection[str] = ()) -> list[Names]:
    """Sets of constants to try on a `muscle` one after the other, each with those that are `always`
    free.
    """
    usual = muscle.tension.usually_free()
    sizes = tuple(name for name in usual if name not in RUBBER)
    if len(sizes) == len(usual) or not isinstance(muscle.material, MooneyRivlin):
        bases = [sizes]
    else:
        bases = [sizes, RUBBER, (*RUBBER, *sizes)]
    sets = [(), *bases, *((*base, _BAND) for base in bases)]
    return list(dict.fromkeys(_union(names, always) for names in sets))


def stepwise_selection(
    best: Callable[[], Names],
    others: Sequence[str],
    always: Collection[str],
    attempt: Callable[[Names], object],
) -> None:
    """Try more constants beside the best ones, and fewer again.

    **Arguments:**

    - `best`: the best of all that was tried by now.
    - `others`: constants that may be taken beside them.
    - `always`: those that are always free.
    - `attempt`: is called with what to try; what was tried already it leaves.
    """
    for _ in range(_ROUNDS):
        before = best()
        for name in others:
            attempt(_union(before, (name,)))
        if best() == before:
            break
    attempt(_union(best(), others))  # two may be worth it that alone are not
    for _ in range(_ROUNDS):
        before = best()
        for name in before:
            if name in others and name not in always:
                attempt(tuple(other for other in before if other != name))
        if best() == before:
            break


def _union(names: Names, more: Collection[str]) -> Names:
    return (*names, *(name for name in more if name not in names))


def _pulling_trials(
    data: FitData, muscle: Muscle, priors: Mapping[str, Prior], options: FitOptions
) -> tuple[list[Trial], float]:
    """Candidates where the muscle pulls, each with its left-out error; and the noise of a
    reading [N], 0 where it can't be seen.
    """
    measured = int(np.sum(data.grid.measured))
    if not measured:
        return [], 0.0
    always = [name for name in priors if name not in FACTOR_NAMES]
    trials: list[Trial] = []
    ends: dict[frozenset[str], dict[str, float]] = {}  # coordinates where each set ended

    def attempt(names: Names) -> None:
        if len(names) < measured and frozenset(names) not in ends:
            known = {name: prior for name, prior in priors.items() if name in names}
            near = ends.get(_nested(trials, names), {})
            begin = replace(options, near=near, starts=min(options.starts, _STARTS))
            trial, ends[frozenset(names)] = _try_constants(data, muscle, names, known, begin)
            trials.append(trial)

    for names in base_parameter_sets(muscle, always):
        attempt(names)
    noise = read(muscle, on_length(data, muscle)).noise
    if any(trial.valid for trial in trials):
        usual = {*muscle.tension.usually_free(), _WALL}
        telling = identifiable_constants(data, with_optional_laws(muscle), options, usual)
        others = [name for name in telling if name not in usual]
        best = lambda: select(trials, noise, options.loss).candidate.names  # noqa: E731 as short
        stepwise_selection(best, others, always, attempt)
    # a tuning has no place for what is known of constants
    tuning = [] if always else _try_tuning(data, muscle, options.loss)
    return [*trials[:1], *tuning, *trials[1:]], noise


def identifiable_constants(
    data: FitData, muscle: Muscle, options: FitOptions, first: Collection[str]
) -> list[str]:
    """Constants that move the force of a `muscle` where it was measured to pull, each in a way
    that those before it and the wall don't; those in `first` come first.
    """
    problem, _ = set_up_problem(data, muscle, (), {}, options)
    constants = pulling_constants(problem.muscle)
    slopes = held_slopes(problem, problem.center, constants)[problem.grid.measured]
    slopes = np.nan_to_num(slopes)
    names = [parameter.name for parameter in constants]
    out, basis = [], np.zeros((len(slopes), 0))
    for i in sorted(range(len(names)), key=lambda i: names[i] not in first):
        own = project_out(basis, slopes[:, i])
        if np.linalg.norm(own) > _DISTINCT * np.linalg.norm(slopes[:, i]):
            out.append(names[i])
            basis = span(np.column_stack([basis, own]))
    return out


def _try_constants(
    data: FitData, muscle: Muscle, names: Names, priors: Mapping[str, Prior], options: FitOptions
) -> tuple[Trial, dict[str, float]]:
    """A set of constants, and the coordinates where its search ended."""
    near: dict[str, float] = {}
    problem, _ = set_up_problem(data, muscle, names, priors, options)
    point, violation = problem.center, ""
    if names:
        problem, _, point, _ = solve_with_noise(problem, starts_of(problem, options))
        fitted = put(problem.parameters, problem.muscle, point)
        violation = _violation(data, muscle, fitted, names, priors)
        if not violation:
            pairs = zip(problem.parameters, point.tolist(), strict=True)
            near = {parameter.name: z for parameter, z in pairs}
    force = problem.force(point)
    unseen = np.full(force.shape, np.nan) if names else force
    for fold in folds(problem.grid) if names else ():
        unseen[fold] = refit_without(problem, point, fold)[fold]
    label = ", ".join(names) or AS_GIVEN
    top = largest_force(data.record)
    trial = make_trial(
        (label, names, "constants", len(names)), data.errors(force), data.errors(unseen),
        options.loss, top, violation=violation,
    )  # fmt: skip
    return trial, near


def _violation(
    data: FitData, muscle: Muscle, fitted: Muscle, names: Names, priors: Mapping[str, Prior]
) -> str:
    """Why no muscle can be as the `fitted` one; empty where it can."""
    if _ACTIVE not in names or _ACTIVE in priors:
        return ""
    rest = data.record.rest_length or float(muscle.length)
    return length_violation(float(fitted.length), rest, _RULER)


def _nested(trials: Sequence[Trial], names: Names) -> frozenset[str]:
    """The best set of constants so far that `names` hold all of: a search that begins where it
    ended can't err more than it.
    """
    within = [
        trial.candidate
        for trial in trials
        if trial.candidate.names and not trial.violation and set(trial.candidate.names) <= {*names}
    ]
    best = min(within, key=lambda candidate: candidate.rmse, default=None)
    return frozenset() if best is None else frozenset(best.names)


def _try_tuning(data: FitData, muscle: Muscle, loss: str) -> list[Trial]:
    """The paper's tuning where the muscle pulls, if blocked force and free strain can be read."""
    grid = on_length(data, muscle)
    curves = SmoothCurves(muscle, grid.pressure[:, 0], top_pressure(grid))
    untuned = pulling_force(curves.law, grid.pressure, grid.strain)

    def forces(part: Grid) -> tuple[np.ndarray, int] | None:
        readings = read(muscle, part)
        if not np.any(readings.valid):
            return None
        c1, c2 = curves.tables(readings.coefficients)
        return c2[:, None] * (untuned - c1[:, None]), readings.order + 3

    whole = forces(grid)
    if whole is None:
        return []
    unseen = np.full(untuned.shape, np.nan)
    for fold in folds(grid):
        part = forces(grid.without(fold))
        if part is not None:
            unseen[fold] = part[0][fold]
    top_force = largest_force(data.record)
    errors = data.errors(whole[0]), data.errors(unseen)
    return [make_trial((TUNING, (), "tuning", whole[1]), *errors, loss, top_force)]


def _whole_trials(
    data: FitData,
    muscle: Muscle,
    priors: Mapping[str, Prior],
    options: FitOptions,
    names: Names,
) -> tuple[list[Trial], list[Calibration]]:
    """Fits of all that was measured: the paper's tuning; the constants `names` that are best where
    the muscle pulls, with the factors on what resists and without; and these factors alone.
    """
    muscle = with_optional_laws(muscle, names)
    options = replace(options, held=(*names, *FACTOR_NAMES))
    with_factors = "and the factors on what resists"
    attempts: list[tuple[str, Names, bool]] = [(TUNING, FACTOR_NAMES, True)]
    if names:
        label = ", ".join(names)
        attempts.append((f"{label} {with_factors}", _union(names, FACTOR_NAMES), False))
        attempts.append((label, names, False))
    attempts.append((f"{AS_GIVEN} {with_factors}", FACTOR_NAMES, False))
    if not names:
        attempts.append((AS_GIVEN, (), False))
    if set(priors) - set(FACTOR_NAMES):  # a tuning has no place for what is known of constants
        attempts = attempts[1:3]
    trials, fits = [], []
    near: dict[str, float] = {}
    for label, free, tune in attempts:
        known = {name: prior for name, prior in priors.items() if name in free}
        begin = replace(options, tune=tune, near=dict(near))
        fitted = fit_data(data, muscle, free, known, begin)
        # the next begin where this one ended: few other points are enough
        options = replace(options, starts=min(options.starts, _STARTS))
        near.update(zip(fitted.names, fitted.coordinates.tolist(), strict=True))
        curves = 0 if fitted.readings is None else fitted.readings.order + 3
        candidate = label, free, fitted.method, len(free) + curves
        unseen = data.errors(left_out_force(fitted))
        violation = _violation(data, muscle, fitted.muscle, free, priors)
        top = largest_force(data.record)
        loss = options.loss
        trials.append(make_trial(candidate, fitted.errors, unseen, loss, top, "all", violation))
        fits.append(fitted)
    if all(trial.violation for trial in trials):  # nothing else to take: the warnings say it
        trials = [replace(trial, violation="") for trial in trials]
    return trials, fits
