"""Model selection: choice of the free constants of a muscle, by cross-validation.

While a muscle pulls, its force depends on the tension law alone. So the free constants are first
selected there, on the record as a gauge that only pulls would have seen it. The two constants of
the rubber are free together: with one of them fixed at a value that nobody measured the other
constants would look too certain. The wall thickness stays as given: the force depends on its
product with the rubber's constants. Where the record shows resisting force, the best candidate and
the paper's tuning are then fitted to all readings, with the factors on the resisting force.

Pressures are left out one by one, or a few neighbors at a time where there are many; with too few
to interpolate between them, stretches of strain are. Of the candidates that are no worse than the
best the one with the fewest constants is selected.

**Source:** Breiman et al. (1984) for the one-standard-error rule.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtri

from ..core.errors import InvalidInputError
from ..core.validation import check_choice
from ..muscle import Muscle
from ..muscle.materials import MooneyRivlin
from ..records.record import Record
from .calibration import RULER, Calibration, largest_force, rms
from .data import MIN_PUSHES, FitData, Grid, pulling_only, select_fit_data, thin
from .diagnostics import force_slopes_of, project_out, span
from .fitting import (
    STARTS,
    FitOptions,
    Prior,
    fit_data,
    fits_loop,
    on_length,
    set_up_problem,
    starts_of,
)
from .gauges import CLEAR, drift_confounders, reading_noise
from .least_squares import KNOWN, NORMAL, ROUGH, Problem, loop_force, solve, solve_with_noise
from .parameters import (
    FACTOR_NAMES,
    RUBBER,
    WEAK,
    parameters_of,
    pulling_parameters,
    put,
    with_optional_laws,
)
from .readings import SmoothCurves, read_curves, tension_force, top_pressure
from .tuning import refit_tuning


_TOLERANCE = 0.02  # of the least left-out error beyond noise: a smaller difference has no use
_STANDARD_ERRORS = 1.0  # of a difference: the one-standard-error rule
_SURE = 0.95  # probability: constants that improve a fit by less may have improved it by chance
_OUTLIER = 3.0  # of the usual error: outliers of a robust fit count no more than that
_DISTINCT = 1e-3  # of a constant's effect on the force: with less it duplicates the others
_CONTRADICTS = 3.0  # deviations of a prior: a set of constants that needs more leaves one out
_STARTS = 2  # points to begin from: each search also begins at a neighboring candidate's end
_MAX_FOLDS = 12  # pressures left out one by one: each is a refit
_GROUPS = 8  # of neighboring pressures where there are more
_MIN_LEVELS = 3  # pressures: with fewer there is nothing to interpolate between
_STRETCHES = 6  # of strain, as many as typical pressures
_BAND, _WALL, _ACTIVE, _ZERO = "dead_band", "wall_thickness", "active_length", "force_zero"

Names = tuple[str, ...]
Priors = Mapping[str, Prior]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A set of free constants, tried by the model selection.

    - `method`: "tuning" or "constants".
    - `constants`: number of fitted numbers, with those of a tuning's curves.
    - `rmse`, `left_out_rmse`: error [N] of the fit, and at pressures that it was not fitted to; of
      contractions that were read under set loads [-].
    - `relative_rmse`, `relative_left_out_rmse`: over the largest force, or contraction [-].
    - `readings`: compared readings: "pulling" or "all".
    - `violation`: what makes the fitted muscle impossible: "length", an active length above the
      muscle's, of this `value` [m]; "bound", a constant at the end of its range; "prior", one
      that lies this many deviations from its prior; else empty.
    - `left_out_errors`: of its predictions, reading by reading; NaN for clipped ones.
    """

    names: Names
    method: str
    constants: int
    rmse: float
    left_out_rmse: float
    relative_rmse: float
    relative_left_out_rmse: float
    readings: str = "pulling"
    violation: str = ""
    value: float = float("nan")
    chosen: bool = False
    left_out_errors: np.ndarray | None = None

    @property
    def valid(self) -> bool:
        """True if it can be selected: a possible muscle with a finite left-out error."""
        return bool(np.isfinite(self.left_out_rmse)) and not self.violation


@dataclass(frozen=True, eq=False)
class Selection:
    """The fit of the selected constants to all readings, and all sets that were compared.

    `by_strain`: stretches of strain were left out in turn, not pressures; `compared`: number of
    readings that the candidates were compared on.
    """

    calibration: Calibration
    candidates: tuple[Candidate, ...] = ()
    by_strain: bool = False
    compared: int = 0


def select_model(
    record: Record,
    muscle: Muscle,
    priors: Priors | None = None,
    *,
    loss: str = "linear",
    starts: int = STARTS,
    seed: int = 0,
    given_laws: Collection[str] = (),
    progress: Callable[[str], object] = lambda _: None,
) -> Selection:
    """Select the constants that a record determines, and fit them.

    **Arguments:**

    - `record`: the measured readings.
    - `muscle`: sizes, laws and constants to begin with.
    - `priors`: prior knowledge of some constants; these are always free.
    - `loss`, `starts`, `seed`: as of `fit`.
    - `given_laws`: kinds of law that stay as they are, such as "ends"; "material": the rubber was
      given, and may stay as it is.
    - `progress`: is called with a line on each step.

    **Returns:** the selection, with all candidates.

    **Raises:** `InvalidInputError` as `fit`.
    """
    data, priors = select_fit_data(record, muscle), dict(priors or {})
    if 0 < data.pushes < MIN_PUSHES and not data.reads_contraction:
        data = pulling_only(data)
    options = FitOptions(loss, starts, seed, whole=False)
    extended = muscle if "ends" in given_laws else with_optional_laws(muscle)
    for name in priors:
        check_choice(name, parameters_of(extended), "priors")
    pulling = thin(pulling_only(data))
    if not np.any(pulling.grid.measured):  # `fit` raises the error
        return Selection(fit_data(data, muscle, None, None, replace(options, whole=True)))
    compared, by_strain = thin(data), _measured_levels(data.grid).size < _MIN_LEVELS
    # the rubber's force is the same at all pressures: few of them don't tell it from the sizes
    parts = pulling, muscle, extended, priors, options, by_strain or "material" in given_laws
    trials, noise = _pulling_trials(*parts, progress)
    count = len(compared.record)
    if data.pulls:
        best = select(trials, noise, loss)
        progress("fitting")
        tune = best.method == "tuning"
        names = None if tune else best.names
        options = replace(options, tune=tune)
        fitted = fit_data(data, muscle, names, _priors_of(priors, names or ()), options)
        return Selection(fitted, _mark_chosen(trials, best), by_strain, count)
    best = select([trial for trial in trials if trial.method == "constants"], noise, loss)
    muscle, free = with_optional_laws(muscle, best.names), best.names
    full_trials, searches = _full_trials(compared, muscle, priors, options, free, noise, progress)
    final = select(full_trials, noise, loss)
    options = replace(searches[full_trials.index(final)], thorough=True)
    progress("fitting all readings")
    fitted = fit_data(data, muscle, final.names, _priors_of(priors, final.names), options)
    candidates = (*_mark_chosen(trials, best), *_mark_chosen(full_trials, final))
    return Selection(fitted, candidates, by_strain, count)


def make_candidate(
    names: Names,
    method: str,
    constants: int,
    errors: np.ndarray,
    left_out: np.ndarray,
    loss: str,
    top: float,
    readings: str = "pulling",
    violation: tuple[str, float] = ("", float("nan")),
) -> Candidate:
    """Candidate with its `errors` and those of fits without the reading, `left_out` [N]; NaN for
    clipped ones. `top`: the largest measured force [N]. `violation`: its code and value.
    """
    rmse, left_out_rmse = error_size(errors, loss), error_size(left_out, loss)
    # candidates are compared on all readings: one that can't predict some of them is out
    if not np.all(np.isfinite(left_out) | ~np.isfinite(errors)):
        left_out_rmse = float("nan")
    sizes = rmse, left_out_rmse, rmse / top, left_out_rmse / top
    return Candidate(names, method, constants, *sizes, readings, *violation, False, left_out)


def select(trials: Sequence[Candidate], noise: float, loss: str) -> Candidate:
    """Select the candidate with the fewest constants whose squared errors exceed the best one's by
    no more than a standard error of their sum, 2 % of the error beyond the `noise` of a reading [N]
    (0 where it is unknown), or one reading's average share, which any constant gains on noise; or
    whose fit is no worse by Fisher's test: a prediction far from other readings may err less by
    chance.

    **Raises:** `InvalidInputError` if no fit has a left-out error.
    """
    valid = [trial for trial in trials if trial.valid]
    if not any(trial.constants for trial in valid):  # the muscle as given needs no fit
        rule, remedy = "is too short to leave readings out", "name what to fit, such as c10, c01"
        if any(trial.violation and np.isfinite(trial.left_out_rmse) for trial in trials):
            rule = "gives no fit with possible constants"
            remedy = f"check the muscle's sizes and the record's rest length and units, or {remedy}"
        raise InvalidInputError("record", rule, None, remedy)
    best = min(valid, key=lambda trial: trial.left_out_rmse)
    limit = _OUTLIER * best.left_out_rmse if loss != "linear" else np.inf
    squares = []
    for trial in valid:
        errors = np.asarray(trial.left_out_errors)
        squares.append(np.minimum(errors[np.isfinite(errors)] ** 2, limit**2))
    best_squares = squares[valid.index(best)]
    mean = float(np.mean(best_squares))
    tolerance = ((1 + _TOLERANCE) ** 2 - 1) * max(mean - noise**2, 0.0)
    equivalent = []
    for trial, square in zip(valid, squares, strict=True):
        excess = square - best_squares
        chance = _STANDARD_ERRORS * float(np.std(excess)) / np.sqrt(excess.size)
        fewer, freedom = best.constants - trial.constants, max(excess.size - best.constants, 1)
        gain = fewer / freedom * float(fdtri(fewer, freedom, _SURE)) if fewer > 0 else -1.0
        fits_as_well = trial.rmse**2 - best.rmse**2 <= gain * best.rmse**2
        if fits_as_well or float(np.mean(excess)) <= max(chance, tolerance, mean / excess.size):
            equivalent.append(trial)
    return min(equivalent, key=lambda trial: (trial.constants, trial.left_out_rmse))


def error_size(errors: np.ndarray, loss: str) -> float:
    """Root mean square of `errors` [N] without NaN; a robust estimate of it for a robust `loss`."""
    if loss == "linear" or not np.any(np.isfinite(errors)):
        return rms(errors)
    return 1.4826 * float(np.nanmedian(np.abs(errors)))  # equal for normal errors


def folds(grid: Grid) -> list[np.ndarray]:
    """Masks of the parts of a `grid` that are left out in turn; each contains measured forces."""
    levels = _measured_levels(grid)
    if levels.size >= _MIN_LEVELS:
        rows = np.arange(len(grid.count))[:, None]
        groups = np.array_split(levels, levels.size if levels.size <= _MAX_FOLDS else _GROUPS)
        return [np.isin(rows, group) & grid.used for group in groups]
    ends = np.quantile(grid.strain[grid.measured], np.linspace(0, 1, _STRETCHES + 1))
    stretch = np.clip(np.searchsorted(ends, grid.strain, "right") - 1, 0, _STRETCHES - 1)
    masks = [(stretch == index) & grid.used for index in range(_STRETCHES)]
    return [mask for mask in masks if np.any(mask & grid.measured)]


def left_out_force(calibration: Calibration) -> np.ndarray:
    """Forces [N] on a calibration's grid, each predicted by a fit without it."""
    problem, point, readings = calibration.problem, calibration.coordinates, calibration.readings
    if readings is None:
        return _predicted_force(problem, point, static=True)
    force = np.full(problem.grid.force.shape, np.nan)
    for fold in folds(problem.grid):
        grid, joint = problem.grid.without(fold), readings.pulling is not None
        end, refitted = refit_tuning(problem, point, grid, joint)
        force[fold] = replace(refitted, grid=problem.grid).force(end)[fold]
    return force


def possible_gauge_errors(data: FitData) -> list[str]:
    """Names of zeros of force and pressure that a record doesn't show at rest, and of a drift of
    the force where time runs on over several sweeps of each direction, and of each file; none where
    contraction was read.
    """
    if data.reads_contraction:
        return []
    channels = (channel for channel in ("force", "pressure") if channel not in data.record.zeroed)
    names = [f"{channel}_zero" for channel in channels]
    may_drift = data.record.has_one_clock and np.ptp(data.grid.elapsed) > 0
    if may_drift and "force" not in data.record.zeroed and not drift_confounders(data.record):
        names.append("force_drift")
    return names


def candidate_sets(
    muscle: Muscle,
    optional: Collection[str] = (),
    required: Collection[str] = (),
    gauges: Collection[str] = (),
    rubber_given: bool = False,
    loaded: bool = True,
) -> list[Names]:
    """Sets of constants to compare, each with the `required` ones: none, the sizes if the rubber is
    given, the rubber, both, each with a dead band; the first of these, and both, with the errors of
    the `gauges`; both with each `optional` constant, and with all of them. Unless `loaded`, a
    radius can't be told from a free rubber, and stays beside it.
    """
    usual = muscle.tension.fit_parameters()
    sizes = tuple(name for name in usual if name not in RUBBER)
    bases = [sizes]
    if len(sizes) < len(usual) and isinstance(muscle.material, MooneyRivlin):
        # beside a rubber that nobody measured the sizes alone would make up for it
        distinct = sizes if loaded else tuple(name for name in sizes if name != "outer_radius")
        bases = [*([sizes] if rubber_given else []), RUBBER, (*RUBBER, *distinct)]
    sets = [(), *bases, *((*base, _BAND) for base in bases)]
    # a zero of one gauge alone would make up for the others', and seem too certain
    sets += [(*base, *gauges) for base in (bases[0], bases[-1])]
    sets += [(*bases[-1], name) for name in optional] + [(*bases[-1], *optional)]
    unique = {frozenset(union): union for union in (_union(names, required) for names in sets)}
    return list(unique.values())


def identifiable_constants(
    data: FitData, muscle: Muscle, options: FitOptions, first: Collection[str]
) -> list[str]:
    """Names of the constants with distinct effects on the measured pull; those `first` go first."""
    problem, _ = set_up_problem(data, muscle, (), {}, options)
    constants = pulling_parameters(problem.muscle)
    slopes = force_slopes_of(problem, problem.center, constants)[problem.grid.measured]
    effects = dict(zip((p.name for p in constants), np.nan_to_num(slopes).T, strict=True))
    names, basis = [], np.zeros((len(slopes), 0))
    for name in sorted(effects, key=lambda name: name not in first):
        distinct = project_out(basis, effects[name])
        if np.linalg.norm(distinct) > _DISTINCT * np.linalg.norm(effects[name]):
            names.append(name)
            basis = span(np.column_stack([basis, distinct]))
    return names


def _pulling_trials(
    data: FitData,
    muscle: Muscle,
    extended: Muscle,
    priors: Priors,
    options: FitOptions,
    rubber_given: bool,
    progress: Callable[[str], object],
) -> tuple[list[Candidate], float]:
    """Candidates on readings that pull, and the noise of a reading [N], 0 where it can't be seen;
    `extended`: the muscle with its optional laws.
    """
    constants_with_priors = [name for name in priors if name not in FACTOR_NAMES]
    # errors that readings without pressure show are fitted with every candidate
    required = list(dict.fromkeys([*constants_with_priors, *data.gauge.faults]))
    # friction is the same for all of them: without it the half-way curve decides
    options = replace(options, starts=min(options.starts, _STARTS), loop=True)
    usual = {*muscle.tension.fit_parameters(), _WALL}
    constants = identifiable_constants(data, extended, options, usual)
    optional = [name for name in constants if name not in usual]
    gauges, loaded = possible_gauge_errors(data), bool(np.any(data.record.force))
    sets = candidate_sets(muscle, optional, required, gauges, rubber_given, loaded)
    sets = [names for names in sets if len(names) < np.sum(data.grid.measured)]
    trials: dict[frozenset[str], Candidate] = {}
    ends: dict[frozenset[str], dict[str, float]] = {}  # coordinates at the end of each search
    for number, names in enumerate(sets, 1):
        progress(f"selecting the constants: fit {number} of {len(sets)}")
        # a search that begins at the end of a subset's search can't end with a larger error
        subsets = [key for key in ends if key <= set(names)]
        start = min(subsets, key=lambda key: trials[key].rmse, default=frozenset[str]())
        settings = replace(options, near=ends.get(start, {}))
        trial, end = _try_constants(data, muscle, names, _priors_of(priors, names), settings)
        trials[frozenset(names)] = trial
        if names and not trial.violation:
            ends[frozenset(names)] = end
    candidates = list(trials.values())
    if all(trial.violation for trial in candidates):  # one is returned all the same
        candidates = [replace(trial, violation="") for trial in candidates]
    if data.reads_contraction:  # no curves of force
        return candidates, 0.0
    noise = read_curves(muscle, on_length(data, muscle)).noise
    if not constants_with_priors:  # a tuning can't take prior knowledge of them into account
        loop = fits_loop(data, (), options)
        candidates[1:1] = _try_tuning(data, muscle, options.loss, loop)
    return candidates, min(noise, reading_noise(data.record.force))


def _try_constants(
    data: FitData, muscle: Muscle, names: Names, priors: Priors, options: FitOptions
) -> tuple[Candidate, dict[str, float]]:
    """Candidate of a set of constants, and the coordinates at the end of its search."""
    problem, _ = set_up_problem(data, muscle, names, priors, options)
    point, violation = problem.center, ("", float("nan"))
    if names:
        starts = starts_of(problem, options)
        problem, _, point, minimum, _ = solve_with_noise(problem, starts, tolerance=ROUGH)
        fitted = put(problem.parameters, problem.muscle, point)
        violation = _length_violation(data, muscle, fitted, names, priors)
        misfit = np.abs(point - problem.center) / problem.deviation
        given = [p.name in priors for p in problem.parameters]
        if np.any(misfit[given] > _CONTRADICTS):
            violation = "prior", float(np.max(misfit[given]))
        # a constant that went far beyond its weak prior and has no effect there is at its bound
        far = misfit > 1
        no_effect = np.diag(minimum.covariance) > (KNOWN * problem.deviation / WEAK) ** 2
        weak = [not p.of_gauge and p.name not in priors for p in problem.parameters]
        if not violation[0] and np.any(far & no_effect & weak):
            violation = "bound", float("nan")
    force = problem.force(point)
    left_out = _predicted_force(problem, point) if names else force
    errors = _errors(data, problem, force), _errors(data, problem, left_out)
    top = data.largest_strain if data.reads_contraction else largest_force(data.record)
    facts = options.loss, top, "pulling", violation
    trial = make_candidate(names, "constants", len(names), *errors, *facts)
    free = (parameter.name for parameter in problem.parameters)
    return trial, dict(zip(free, point.tolist(), strict=True))


def _errors(data: FitData, problem: Problem, force: np.ndarray) -> np.ndarray:
    """Errors of a model's `force` [N]; of contractions [-] where these were read."""
    if data.reads_contraction:
        return problem.contraction_errors(force, data)
    return _settled(data, data.errors(force))


def _settled(data: FitData, errors: np.ndarray) -> np.ndarray:
    """The `errors` of readings, NaN after a turn of their sweep."""
    return errors if data.turning is None else np.where(data.turning, np.nan, errors)


def _try_tuning(data: FitData, muscle: Muscle, loss: str, loop: bool) -> list[Candidate]:
    """Candidate of the paper's tuning, if blocked force and free strain can be read; `loop`: with a
    hysteresis loop beside it.
    """
    grid = on_length(data, muscle)
    curves = SmoothCurves(muscle, grid.pressure[:, 0], top_pressure(grid))
    untuned = tension_force(curves.law, grid.pressure, grid.strain)

    def tuned_force(grid_part: Grid) -> tuple[np.ndarray, int] | None:
        readings = read_curves(muscle, grid_part)
        if not np.any(readings.valid):
            return None
        c1, c2 = curves.corrections(readings.coefficients)
        return c2[:, None] * (untuned - c1[:, None]), readings.order + 3

    fitted = tuned_force(grid)
    if fitted is None:
        return []
    left_out = np.full(untuned.shape, np.nan)
    for fold in folds(grid):
        refitted = tuned_force(grid.without(fold))
        if refitted is not None:
            left_out[fold] = refitted[0][fold]
    forces = [fitted[0], left_out]
    if loop:
        weight, used = data.settled.astype(float), data.grid.used
        for force in forces:
            force[used] += loop_force(data.grid, data.branch, weight, force[used])
    errors, left_out = (_settled(data, data.errors(force)) for force in forces)
    top = largest_force(data.record)
    return [make_candidate((), "tuning", fitted[1], errors, left_out, loss, top)]


def _full_trials(
    data: FitData,
    muscle: Muscle,
    priors: Priors,
    options: FitOptions,
    names: Names,
    noise: float,
    progress: Callable[[str], object],
) -> tuple[list[Candidate], list[FitOptions]]:
    """Candidates on all readings, and the options of a search from each one's end.

    Tried are the paper's tuning; the constants `names`, which are best where the muscle pulls, with
    the factors on the resisting force and without; and these factors alone. Where residuals are not
    like noise, a zero of the load cell is tried beside them.
    """
    options = replace(options, whole=True, thorough=False, held=(*names, *FACTOR_NAMES))
    top_force = largest_force(data.record)
    attempts: list[tuple[Names, bool]] = [(_union(names, FACTOR_NAMES), False), (names, False)]
    # a tuning can't take prior knowledge of constants into account
    if not set(priors) - set(FACTOR_NAMES):
        factors = [((*FACTOR_NAMES, *data.gauge.faults), False)] if names else []
        attempts = [(FACTOR_NAMES, True), *attempts, *factors]
    trials, searches = [], []

    def attempt(free: Names, tune: bool) -> tuple[Candidate, FitOptions, Calibration]:
        nonlocal options
        progress(f"fitting the resisting force: fit {len(trials) + 1} of {len(attempts)}")
        options = replace(options, tune=tune)
        fitted = fit_data(data, muscle, free, _priors_of(priors, free), options)
        end = dict(zip(fitted.names, fitted.coordinates.tolist(), strict=True))
        # the next search begins at this end, too: few other points are enough
        options = replace(options, starts=min(options.starts, _STARTS))
        search = replace(options, near=end)
        options = replace(options, near={**options.near, **end})
        curves = 0 if fitted.readings is None else fitted.readings.order + 3
        left_out = fitted.fit_data.errors(left_out_force(fitted))  # corrected as the fit is
        violation = _length_violation(data, muscle, fitted.muscle, free, priors)
        facts = options.loss, top_force, "all", violation
        count = len(free) + curves
        trial = make_candidate(free, fitted.method, count, fitted.errors, left_out, *facts)
        return trial, search, fitted

    for free, tune in attempts:
        trial, search, fitted = attempt(free, tune)
        trials.append(trial)
        searches.append(search)
        # without the factors the resisting force is the law's, and a zero would make up for it
        may_have_zero = {*FACTOR_NAMES} <= {*free} and _ZERO not in free
        may_have_zero &= "force" not in data.record.zeroed
        if tune or fitted.diagnosis.is_white_noise or not may_have_zero:
            continue
        zeroed, search, fitted = attempt((*free, _ZERO), tune)
        if _shows_zero(fitted) and select([trial, zeroed], noise, options.loss) is zeroed:
            trials.append(zeroed)
            searches.append(search)
    if all(trial.violation for trial in trials):  # one is returned all the same, with a warning
        trials = [replace(trial, violation="") for trial in trials]
    return trials, searches


def _shows_zero(fitted: Calibration) -> bool:
    """A fit shows a zero of the load cell clearly, and with residuals like noise: where these vary,
    the law is in error, and a zero would only make up for some of it.
    """
    zero = next(estimate for estimate in fitted.parameters if estimate.name == _ZERO)
    deviation = (zero.high - zero.low) / (2 * NORMAL)
    return fitted.diagnosis.is_white_noise and abs(zero.value) > CLEAR * deviation


def _predicted_force(problem: Problem, point: np.ndarray, static: bool = False) -> np.ndarray:
    """Forces [N] on the grid, each of a refit without its fold, begun at a `point`; `static`:
    without a loop that was fitted beside them.
    """
    force = np.full(problem.grid.force.shape, np.nan)
    for fold in folds(problem.grid):
        end, refit = point, problem
        if point.size:
            refit = replace(problem, weight=np.where(fold, 0.0, problem.weight))
            end = solve(refit, point[None], tolerance=ROUGH).points[0]
        force[fold] = (replace(refit, branch=None) if static else refit).force(end)[fold]
    return force


def _length_violation(
    data: FitData, muscle: Muscle, fitted: Muscle, names: Names, priors: Priors
) -> tuple[str, float]:
    """Code and active length [m] of a muscle longer than the distance of its fittings."""
    length, rest_length = float(fitted.length), data.record.rest_length or float(muscle.length)
    if _ACTIVE in names and _ACTIVE not in priors and length > (1 + RULER) * rest_length:
        return "length", length
    return "", float("nan")


def _measured_levels(grid: Grid) -> np.ndarray:
    """Indices of the levels with a force that isn't clipped."""
    return np.flatnonzero(grid.measured.any(axis=1))


def _mark_chosen(trials: Sequence[Candidate], best: Candidate) -> tuple[Candidate, ...]:
    """The `trials`, with the `best` marked as chosen."""
    return tuple(replace(trial, chosen=trial is best) for trial in trials)


def _priors_of(priors: Priors, names: Collection[str]) -> dict[str, Prior]:
    return {name: prior for name, prior in priors.items() if name in names}


def _union(names: Names, additions: Collection[str]) -> Names:
    return (*names, *(name for name in additions if name not in names))
