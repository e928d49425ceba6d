"""Sentences about a calibration: warnings, likely causes, reasons of a choice, and tables."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..repr_table import ReprTable
from ..units import pretty
from .calibration import Calibration, Candidate, Estimate, Selection, Trial
from .data import MIN_PUSHES, FitData, clip_floor
from .friction import Friction
from .least_squares import Solutions


TUNING = "the paper's tuning"
AS_GIVEN = "the muscle as given"
_TIED = 0.95  # correlation from which two parameters are told apart no longer
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_WIDER = 1.05  # from here on an interval is called wider
_MIN_LEVELS = 3  # pressures, for residuals to go with them
_CLEAR = 4.0  # deviations of a reading, from which a difference of two is told
_MAX_SIGNS = 3  # strains at which residuals' signs are told
_CALIPERS = 0.1  # of a size: nobody who measures it errs by more
_SMALLEST_CHANCE = 1e-12  # nobody's noise is so normal that a smaller one means anything
_MAX_DIGITS = 12  # of a printed interval: float64 has no more to tell
_NO_FRICTION = 5e-3  # of the mean width of loops: a part below it isn't told
_AFTER_COLLAPSE = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")

_STATUS = (
    "converged", "stopped after 200 steps, before it settled",
    "stopped where the solver could not go on",
)  # fmt: skip
_SAME_MINIMUM = 0.02  # of the cost, a fifth of a standard deviation: no data tell two ends apart
_CHOICES = {
    "dead_band": "a dead band", "active_length": "another active length",
    "end_compliance": "end compliance",
}  # fmt: skip


def calibration_warnings(calibration: Calibration) -> dict[str, tuple[str, ...]]:
    """Lines to read before the fitted muscle is used, by topic."""
    topics = {
        "residuals": [*_search(calibration), *_noise(calibration)],
        "not measured": _coverage(calibration),
        "not identifiable from these data": [
            *_parameters(calibration), *_sampling(calibration), *_curves(calibration)
        ],
        "in use": _use(calibration),
    }  # fmt: skip
    return {topic: tuple(lines) for topic, lines in topics.items() if lines}


def _search(calibration: Calibration) -> list[str]:
    solutions = calibration.solutions
    if solutions.status[solutions.best]:
        return [
            f"The search {calibration.status}: treat the result with caution, or give more starts."
        ]
    return []


def _coverage(calibration: Calibration) -> list[str]:
    """Parts of the law that the data don't cover."""
    lines, grid = [], calibration.grid
    strain = calibration.problem.strain(calibration.muscle)
    past = grid.measured & (strain > calibration.free_strain[:, None] + 1e-9)
    if calibration.censored:
        nothing = ", so nothing past the free strain was measured there"
        lines.append(
            f"{calibration.censored} readings are clipped at {calibration.floor}: they only say"
            f" that the force was not above it{nothing if calibration.floor == 'zero' else ''}."
        )
    levels = grid.measured.any(axis=1)
    if np.sum(levels) == 1:
        pressure = pretty(float(grid.pressure[levels][0, 0]), "pressure")
        lines.append(
            f"Data at one pressure only ({pressure}): the pressure dependence comes from the model."
        )
    names = [name for name in calibration.names if name in _AFTER_COLLAPSE]
    if calibration.fit_data.pulls or not np.any(past):
        lines.append(
            "Nothing past the free strain was measured: the data say nothing of bending, collapse"
            " and the hinge."
        )
    elif names:
        columns = [calibration.names.index(name) for name in names]
        if not np.any(calibration.minimum.linear.slopes[: strain.size, columns]):
            lines.append(
                f"No reading lies past a collapse: {_list(names)} can't be determined and"
                f" {'stay' if len(names) > 1 else 'stays'} at the prior."
            )
    if calibration.readings is not None and calibration.muscle.tuning.pressures.size > 1:
        highest = float(np.max(calibration.muscle.tuning.pressures))
        lines.append(
            f"C1 and C2 are read up to {highest / 1e3:.4g} kPa and held constant above it."
        )
    return lines


def _parameters(calibration: Calibration) -> list[str]:
    lines, estimates = [], calibration.parameters
    for estimate in estimates:
        if estimate.bound:
            end = estimate.high if estimate.bound == "upper" else estimate.low
            lines.append(
                f"The data give {estimate.name} only {'an' if estimate.bound == 'upper' else 'a'}"
                f" {estimate.bound} limit, {pretty(end, estimate.dimension, 3)} (90 %)."
            )
    unknown = [one.name for one in estimates if not one.identifiable and not one.bound]
    if len(unknown) == 1:
        lines.append(
            f"{unknown[0]} is not determined by the data; its estimate is dominated by the prior."
        )
    elif unknown:
        lines.append(
            f"{_list(unknown)} are not determined by the data; their estimates are dominated by"
            " the priors."
        )
    confounded = calibration.diagnosis.confounded
    if confounded:
        lines.append(
            "Not fitted, and not identifiable from these data beside the fitted constants:"
            f" {_list([*confounded])} {'stay' if len(confounded) > 1 else 'stays'} as given."
        )
    for i, one in enumerate(estimates):
        for j, other in enumerate(estimates[:i]):
            r = calibration.correlation[i, j]
            if abs(r) > _TIED and one.identifiable and other.identifiable:
                lines.append(
                    f"{other.name} and {one.name} are strongly correlated ({r:.3f}); do not"
                    " interpret them individually."
                )
    return lines


def _sampling(calibration: Calibration) -> list[str]:
    """Whether sweeps are dense enough to see the transition after collapse."""
    rate = next((one for one in calibration.parameters if one.name == "transition_rate"), None)
    if rate is None or not rate.identifiable:
        return []
    used = calibration.grid.measured
    strain = np.where(used, calibration.problem.strain(calibration.muscle), np.nan)
    strain = strain[np.any(used, axis=1)]
    spacing = np.nanmax(strain, axis=1) - np.nanmin(strain, axis=1)
    spacing = spacing / np.sum(np.isfinite(strain), axis=1)
    within = 1 / (rate.value * float(np.median(spacing)))
    if within >= _DENSE:
        return []
    return [
        f"Only {within:.2g} readings at a pressure fall into the transition after collapse (1/β of"
        f" strain): below {_DENSE} the collapse moment's interval comes out too narrow."
    ]


def _curves(calibration: Calibration) -> list[str]:
    lines, readings = [], calibration.readings
    if readings is None:
        return []
    P = readings.pressure
    unread = P[~readings.valid & (0.01 * P.max() < P)]
    if unread.size:
        lines.append(
            "Blocked force and free strain could not be read at"
            f" {', '.join(f'{p / 1e3:.4g}' for p in unread)} kPa: too few readings pull there."
        )
    what = ("free strain is no polynomial of order 3 or less times the law's",
            "blocked force is not linear in pressure")  # fmt: skip
    for misfit, words in zip(readings.misfit, what, strict=True):
        if misfit > 1:
            lines.append(
                f"The {words} within its readings' errors ({np.sqrt(misfit):.3g} times them): the"
                " smooth curve misses some of them, and its uncertainty is widened."
            )
    return lines


def _noise(calibration: Calibration) -> list[str]:
    """Whether residuals are noise, and what else they are."""
    diagnosis = calibration.diagnosis
    lines = [
        f"Residuals follow {trend.along}: a smooth curve along it explains"
        f" {100 * trend.share:.3g} % of their squares (p-value {_chance(trend.chance)}). That is"
        " an error of the model or of the gauge, not noise."
        for trend in diagnosis.significant
    ]
    lines += [
        f"Neighboring residuals along {run.along} change sign {run.changes} times in"
        f" {run.pairs}, where noise would in half of them: they are correlated."
        for run in diagnosis.autocorrelated
    ]
    if not diagnosis.is_white_noise:
        parts = [
            f"{max(one.below, one.count - one.below)} of {one.count} lie"
            f" {'below' if 2 * one.below > one.count else 'above'} the fit near strain"
            f" {one.strain:.3g}"
            for one in diagnosis.signs[:_MAX_SIGNS]
        ]
        if parts:
            lines.append(f"Of the readings {_list(parts)}.")
        lines += [*_at_rest(calibration), *_causes(calibration)]
    if diagnosis.significant and calibration.parameters:
        wider = calibration.wider
        by = "hardly wider than"
        if np.max(wider) >= _WIDER:
            by = f"{_range(wider)} times as wide as"
        lines.append(
            "Intervals include a discrepancy for it, a smooth error of the model along"
            f" {_list([trend.along for trend in diagnosis.significant])}, as large where the fit"
            f" took it up as where it shows: they are {by} from noise alone."
        )
    if diagnosis.inflation > 1 and calibration.parameters:
        lines.append(
            "Residuals are correlated along a sweep: intervals are widened by"
            f" {np.sqrt(diagnosis.inflation):.3g} for it."
        )
    if not np.isfinite(diagnosis.noise):
        lines.append("Too few readings beside the constants to tell whether residuals are noise.")
    return lines


def _at_rest(calibration: Calibration) -> list[str]:
    """Residuals at the least strain over pressure, where they are more than noise: ends and a dead
    band show there.
    """
    diagnosis = calibration.diagnosis
    if len(diagnosis.at_rest) < _MIN_LEVELS or not np.isfinite(diagnosis.noise):
        return []
    P, missed = np.array(diagnosis.at_rest).T
    if np.ptp(missed) < _CLEAR * diagnosis.noise:
        return []
    low, high = sorted((int(np.argmin(missed)), int(np.argmax(missed))))
    return [
        f"At the least strain they run from {missed[low]:+.3g} N at {P[low] / 1e3:.4g} kPa to"
        f" {missed[high]:+.3g} N at {P[high] / 1e3:.4g} kPa."
    ]


def _causes(calibration: Calibration) -> list[str]:
    causes = calibration.diagnosis.causes
    if not causes:
        return ["No known cause would explain much of it."]
    parts = [f"{cause.name} (would explain {100 * cause.share:.3g} %)" for cause in causes]
    return [f"Likely cause: {'; or '.join(parts)}. What to do: {causes[0].remedy}."]


def _use(calibration: Calibration) -> list[str]:
    """Effects that its figures leave out, or include besides the model."""
    lines = []
    if calibration.loop is None:
        lines.append(
            "Measured one way, or in an unknown direction: friction's hysteresis loop is not in"
            " these errors, and a muscle in use has one."
        )
    if "active_length" in calibration.names:
        rest = calibration.record.rest_length
        lines.append(
            f"The fitted muscle is {pretty(float(calibration.muscle.length), 'length')} long: its"
            " contractions refer to that, the record's to"
            f" {'the length it began with' if rest is None else pretty(rest, 'length')}."
        )
    return lines + _sizes(calibration)


def _sizes(calibration: Calibration) -> list[str]:
    """Fitted sizes that aren't those that were measured: they make up for something."""
    given, lines = calibration.start, []
    rest = calibration.record.rest_length or float(given.length)
    for one in calibration.parameters:
        # an active length may be shorter than what lies between the fittings, never longer
        real = {"active_length": rest}.get(one.name, getattr(given, one.name, None))
        if real is None or not one.identifiable or one.dimension not in ("length", "angle"):
            continue
        longer, shorter = one.low > (1 + _CALIPERS) * real, one.high < (1 - _CALIPERS) * real
        if longer or (shorter and one.name != "active_length"):
            value, known = (pretty(x, one.dimension, 3) for x in (one.value, float(real)))
            lines.append(
                f"{one.name} is {value}, given as {known}, its whole interval more than"
                f" {100 * _CALIPERS:g} % off: it makes up for an error of the law, and is no"
                " measured size."
            )
    return lines


def _chance(chance: float) -> str:
    """A chance in words that claim no more than is computed."""
    return f"{chance:.1g}" if chance > _SMALLEST_CHANCE else f"below {_SMALLEST_CHANCE:.0g}"


def hysteresis_message(calibration: Calibration) -> str:
    """Width of the record's loops, and its share of the muscle's error in use; empty where the
    record doesn't hold both branches.
    """
    loop, friction = calibration.loop, calibration.friction
    if loop is None:
        return ""
    several = loop.pressure.size > 1
    if friction is not None and friction.law is None:
        return (
            "No hysteresis loop stands out of the noise: mean width"
            f" {float(np.mean(loop.width)):.2g} N at {loop.pressure.size} pressure{'s' * several}."
        )
    where = f"at {loop.pressure.size} pressures" if several else "there"
    return (
        f"Hysteresis loop: {_range(100 * loop.share)} % of the pull at a pressure wide,"
        f" {_range(loop.width)} N {where}. Half of it is in the error of a muscle in use,"
        f" {calibration.rmse:.4g} N; against the half-way curve the error is"
        f" {calibration.half_way_rmse:.4g} N."
        f"{'' if friction is None else f' {friction_message(friction)}'}"
    )


def friction_message(friction: Friction) -> str:
    """Fitted friction, in a sentence or two."""
    if friction.law is None:
        return "No friction above the noise: both branches are one."
    count, still = len(friction.resolved), friction.half_width(0.0)
    rise, clear = friction.half_width(1e5) - still, _NO_FRICTION * float(np.mean(friction.width))
    # at 10 bar, more than any record holds, a rise may matter that doesn't at one
    parts = [f"{still:.3g} N"] * (still > clear) + [f"{rise:.3g} N/bar"] * (10 * rise > clear)
    line = (
        f"Friction: {count} sliding spring{'s' if count > 1 else ''}, together"
        f" {' + '.join(parts)} either way; their loops' widths err by {friction.rmse:.3g} N."
    )
    if not all(friction.resolved):
        line += " Its build-up after a turn is not resolved: it is there at the next reading."
    return line


def fit_data_lines(data: FitData) -> list[str]:
    """Readings by what became of them, in sentences."""
    lines = [f"{data.read} readings read"]
    lines += [f"{count} left out: {reason}" for reason, count in data.left_out.items()]
    if not data.left_out:
        lines[0] += ", none left out"
    if data.clipped:
        floor = clip_floor(data.record)
        lines.append(f"{data.clipped} clipped: they only say that the force was not above {floor}")
    if data.noise_clipped:
        lines.append(
            f"{data.noise_clipped} of these are small forces past the strain from which the others"
            " of their pressure are clipped: treated as noise"
        )
    if data.pushes_clipped:
        verb = "does" if data.pushes_clipped == 1 else "do"
        lines.append(
            f"{data.pushes_clipped} of these {verb} not pull, too few to fit what resists"
            f" ({MIN_PUSHES} numbers): `--fit tuning` fits that all the same"
        )
    if data.averaged:
        lines.append(
            f"{data.averaged} averaged into {data.means} means for the fit, in steps of strain,"
            " each way by itself; errors are those of all readings"
        )
    levels, pressures = len(data.grid.pressure), np.unique(data.record.pressure).size
    if pressures > levels:
        lines.append(f"{pressures} pressures gathered into {levels} level{'s' * (levels > 1)}")
    return lines


def end_messages(solutions: Solutions) -> list[str]:
    """Ends of the search from all starts, a line each."""
    least, lines = np.nanmin(solutions.cost), []
    columns = (solutions.cost.tolist(), solutions.status.tolist(), solutions.steps.tolist())
    for i, (cost, status, steps) in enumerate(zip(*columns, strict=True), start=1):
        line = f"start {i}: {_STATUS[status]} ({steps} step{'' if steps == 1 else 's'})"
        if cost - least < _SAME_MINIMUM:
            line += ", at the best minimum"
        elif np.isfinite(cost):
            line += f", at a worse one (cost {cost:.6g})"
        lines.append(line)
    return lines


def interval_method(calibration: Calibration) -> str:
    """Method of a calibration's 90 % intervals."""
    boots, given = calibration.bootstrapped, ", conditional on the selected model"
    if boots is None:
        profiles = ", by profile likelihood where that says more" * bool(calibration.profiles)
        return f"linear approximation (C3){profiles}{given}; use --intervals bootstrap to simulate"
    failed = f", {boots.failed} more failed" if boots.failed else ""
    return f"parametric bootstrap of the whole fit, {len(boots.values)} draws{failed}{given}"


def interval_texts(estimate: Estimate) -> tuple[str, str]:
    """Value and 90 % interval for people, with digits enough to tell them apart."""
    width = estimate.high - estimate.low
    size = max(abs(estimate.value), abs(estimate.low), abs(estimate.high))
    digits = 3 if not 0 < width < size else 2 + math.ceil(math.log10(size / width))
    digits = min(max(digits, 3), _MAX_DIGITS)
    several = max(digits, 4)
    # an end nearer than half of its last digit, once rounded, may lie past the value
    nearest = min(estimate.value - estimate.low, estimate.high - estimate.value)
    if nearest < 5 * 10.0**-digits * size:
        digits = several
    low, high = (pretty(x, estimate.dimension, digits) for x in (estimate.low, estimate.high))
    return pretty(estimate.value, estimate.dimension, several), f"{low} to {high}"


def identifiability_text(estimate: Estimate) -> str:
    """How well the data know an estimate; empty where they do."""
    if estimate.identifiable:
        return ""
    return f"{estimate.bound} limit only" if estimate.bound else "not known"


def calibration_table(calibration: Calibration) -> ReprTable:
    """Constants with their intervals, the error and the warnings."""
    clipped = f", of which {calibration.censored} are clipped" if calibration.censored else ""
    relative = f"{100 * calibration.relative_rmse:.2g} % of the largest force"
    facts = [
        ("method", calibration.method),
        ("fitted to", f"{calibration.points} readings{clipped}"),
        ("error, rms", f"{calibration.rmse:.3g} N, {relative}"),
        ("best start", calibration.status),
        ("intervals", calibration.intervals),
    ]
    rows = [
        [
            one.name,
            *(pretty(x, one.dimension) for x in (one.value, one.low, one.high)),
            "yes" if one.identifiable else "no",
        ]
        for one in calibration.parameters
    ]
    heads = ("fitted", "value", "from, 90 %", "to", "identifiable")
    kind = "synthetic readings" if calibration.record.synthetic else "a record"
    notes = [f"! {line}" for line in calibration.warnings]
    return ReprTable(f"Calibration to {kind}", facts, heads, rows, notes)


def selection_table(selection: Selection) -> ReprTable:
    """The selected calibration, and the reasons."""
    table = calibration_table(selection.calibration)
    tried = f"{len(selection.candidates)} candidates" if selection.candidates else "none beside it"
    return table._replace(
        title=f"Selected: {table.title[0].lower()}{table.title[1:]}",
        facts=[*table.facts, ("tried", tried)],
        notes=[*selection.reasons, *table.notes],
    )


def selection_reasons(
    trials: Sequence[Trial], best: Trial, parts: str = "pressures"
) -> tuple[str, ...]:
    """Why the `best` of the `trials` was selected, a line each; `parts` were left out in turn."""
    valid = [trial.candidate for trial in trials if trial.valid]
    chosen, least = best.candidate, min(valid, key=lambda one: one.left_out_rmse)
    lines = [
        f"Selected: {chosen.label} ({_count(chosen)}), cross-validated error {_share(chosen)} of"
        " the largest force."
    ]
    if least is chosen:
        possible = "" if len(valid) == len(trials) else " possible"
        lines.append(f"None of the {len(valid)}{possible} candidates has a smaller one.")
    else:
        lines.append(
            f"The smallest is {_share(least)}, with {least.label} ({_count(least)}): no better"
            " than chance or 2 % make it, so the fewest numbers are selected."
        )
    lines += [*marginal_gains(trials, best), *exclusions(trials)]
    tuning = next((one for one in valid if one.label == TUNING and one is not chosen), None)
    if tuning is not None:
        lines.append(f"The paper's tuning ({_count(tuning)}): {_share(tuning)}.")
    part = "pressure" if parts == "pressures" else "stretch-of-strain"
    return (
        *lines,
        f"Model selected by leave-one-{part}-out cross-validation (one-standard-error rule): the"
        " fewest parameters within one standard error, 2 %, or one reading's share of the best.",
    )


def exclusions(trials: Sequence[Trial]) -> Iterator[str]:
    """Candidates that couldn't be selected, though they may err less, a line each."""
    for trial in trials:
        if trial.violation:
            yield f"Excluded: {trial.candidate.label}: {trial.violation} is impossible."


def marginal_gains(trials: Sequence[Trial], best: Trial) -> Iterator[str]:
    """Gain of each further constant beside the `best` of `trials`, and of each that it has."""
    errors = {
        frozenset(trial.candidate.names): trial.candidate
        for trial in trials
        if trial.valid and trial.candidate.method == "constants"
    }
    for name in dict.fromkeys(name for trial in trials for name in trial.candidate.names):
        yield from _marginal_gain(errors, best.candidate, name)


def _marginal_gain(
    errors: Mapping[frozenset[str], Candidate], best: Candidate, name: str
) -> Iterator[str]:
    what, names = _CHOICES.get(name, f"`{name}`"), frozenset(best.names)
    if best.method != "constants":
        return
    other = errors.get(names ^ {name})
    if other is None:
        return
    if name in names:
        yield (
            f"Adding {what} reduces the cross-validated error from {_share(other)} to"
            f" {_share(best)}."
        )
    else:
        yield f"Adding {what} does not pay: the cross-validated error would be {_share(other)}."


def length_violation(active: float, rest: float, tolerance: float) -> str:
    """Why an `active` length [m] is impossible between fittings `rest` [m] apart; empty where it
    isn't longer by more than a `tolerance` [-].
    """
    if active <= (1 + tolerance) * rest:
        return ""
    return f"an active length of {pretty(active, 'length')} in a muscle of {pretty(rest, 'length')}"


def _share(candidate: Candidate) -> str:
    return f"{100 * candidate.relative_left_out_rmse:.3g} %"


def _count(candidate: Candidate) -> str:
    return f"{candidate.constants} number{'' if candidate.constants == 1 else 's'}"


def _range(values: np.ndarray) -> str:
    low, high = f"{float(np.min(values)):.2g}", f"{float(np.max(values)):.2g}"
    return low if low == high else f"{low} to {high}"


def _list(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
