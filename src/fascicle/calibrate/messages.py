"""Messages about a calibration: readings and their use, intervals, reasons, and tables."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ..repr_table import ReprTable
from ..units import pretty
from .calibration import Calibration, Candidate, Estimate, Selection, Trial
from .data import MIN_PUSHES, FitData
from .findings import calibration_findings
from .friction import Friction
from .least_squares import SearchEnds


TUNING = "the paper's tuning"
AS_GIVEN = "the muscle as given"
_MAX_DIGITS = 12  # of a printed interval: float64 is exact to little more
_NO_FRICTION = 5e-3  # of the mean width of loops: a smaller part would print as zero
_SAME_MINIMUM = 0.02  # of the cost, a fifth of a standard deviation: no data tell two ends apart
_STATUS = ("converged", "stopped after 200 steps before convergence",
           "stopped because the solver could not continue")  # fmt: skip
_CONSTANTS = {
    "dead_band": "a dead band", "active_length": "a fitted active length",
    "end_compliance": "end compliance",
}  # fmt: skip


def hysteresis_message(calibration: Calibration) -> str:
    """Width of the record's loops and its share of the error in use; empty without loops."""
    loop, friction = calibration.loop, calibration.friction
    if loop is None:
        return ""
    count, width = loop.pressure.size, np.maximum(loop.width, 0.0)  # noise may be negative
    if friction is not None and friction.law is None:
        return (
            "No hysteresis loop above the noise: mean width"
            f" {float(np.mean(width)):.2g} N at {count} pressure{'s' * (count > 1)}."
        )
    scope = f"at {count} pressures" if count > 1 else "there"
    message = (
        f"Hysteresis loop: its width is {range_text(100 * np.maximum(loop.share, 0.0))} % of the"
        f" pull at a pressure, {range_text(width)} N {scope}. The error of a muscle in use,"
        f" {calibration.rmse:.4g} N, contains half of it; against the half-way curve the error is"
        f" {calibration.half_way_rmse:.4g} N."
    )
    return message if friction is None else f"{message} {friction_message(friction)}"


def friction_message(friction: Friction) -> str:
    """Fitted friction, in a sentence or two."""
    if friction.law is None:
        return "No friction above the noise: both branches coincide."
    count, constant = len(friction.resolved), friction.half_width(0.0)
    rise, limit = friction.half_width(1e5) - constant, _NO_FRICTION * float(np.mean(friction.width))
    # at 10 bar, more than any record holds, a rise may matter that doesn't at one
    terms = [f"{constant:.3g} N"] * (constant > limit) + [f"{rise:.3g} N/bar"] * (10 * rise > limit)
    message = (
        f"Friction: {count} sliding spring{'s' if count > 1 else ''}, together ±"
        f"{' + '.join(terms)}; the error of their loops' widths is {friction.rmse:.3g} N."
    )
    if not all(friction.resolved):
        message += " The build-up after a turn is shorter than a step of the readings."
    return message


def fit_data_lines(data: FitData) -> list[str]:
    """Readings by their use in the fit, in sentences."""
    lines = [f"{data.read} readings read"]
    lines += [f"{count} left out: {reason}" for reason, count in data.left_out.items()]
    if not data.left_out:
        lines[0] += ", none left out"
    if data.clipped:
        ceiling = 0 if data.at_ceiling is None else int(np.sum(data.at_ceiling))
        if data.clipped > ceiling:
            lines.append(
                f"{data.clipped - ceiling} are clipped: they only say that the force was not above"
                f" {floor_text(data.floor)}"
            )
        if ceiling:
            lines.append(f"{ceiling} at the load cell's ceiling: the force was not below it")
    if data.noise_clipped:
        lines.append(
            f"{data.noise_clipped} small forces at strains where the pressure's other readings are"
            " clipped or do not pull: noise, taken as a force not above zero"
        )
    if data.pushes_clipped:
        verb = "does" if data.pushes_clipped == 1 else "do"
        lines.append(
            f"{data.pushes_clipped} {verb} not pull, too few to fit the resisting force"
            f" ({MIN_PUSHES} constants): taken as a force not above zero; `--fit tuning` fits it"
            " nevertheless"
        )
    if data.averaged:
        lines.append(
            f"{data.averaged} averaged into {data.means} means for the fit, in steps of strain,"
            " each branch by itself; errors are those of all readings"
        )
    levels, pressures = len(data.grid.pressure), np.unique(data.record.pressure).size
    if pressures > levels:
        lines.append(f"{pressures} pressures grouped into {levels} level{'s' * (levels > 1)}")
    return lines


def floor_text(floor: float) -> str:
    """Force at which readings are clipped, in words."""
    return pretty(floor, "force") if floor else "zero"


def end_messages(solutions: SearchEnds) -> list[str]:
    """Ends of the search from all starts, a line each."""
    lowest, lines = np.nanmin(solutions.cost), []
    columns = (solutions.cost.tolist(), solutions.status.tolist(), solutions.steps.tolist())
    for i, (cost, status, steps) in enumerate(zip(*columns, strict=True), start=1):
        line = f"start {i}: {_STATUS[status]} ({steps} step{'' if steps == 1 else 's'})"
        if cost - lowest < _SAME_MINIMUM:
            line += ", at the best minimum"
        elif np.isfinite(cost):
            line += f", at a worse minimum (cost {cost:.6g})"
        lines.append(line)
    return lines


def interval_method(calibration: Calibration) -> str:
    """Method of the 90 % intervals, in words."""
    profiles = ", profile likelihood where the data give a limit" * bool(calibration.profiles)
    return f"linear approximation{profiles}, conditional on the selected model"


def interval_texts(estimate: Estimate) -> tuple[str, str]:
    """Value and 90 % interval of an estimate, with enough digits to distinguish them."""
    width = estimate.high - estimate.low
    size = max(abs(estimate.value), abs(estimate.low), abs(estimate.high))
    digits = 3 if not 0 < width < size else 2 + math.ceil(math.log10(size / width))
    digits = min(max(digits, 3), _MAX_DIGITS)
    value = pretty(estimate.value, estimate.dimension, max(digits, 4))
    # an end nearer than half of its last digit may round to the other side of the value
    nearest = min(estimate.value - estimate.low, estimate.high - estimate.value)
    if nearest < 5 * 10.0**-digits * size:
        digits = max(digits, 4)
    low, high = (pretty(x, estimate.dimension, digits) for x in (estimate.low, estimate.high))
    return value, f"{low} to {high}"


def calibration_table(calibration: Calibration) -> ReprTable:
    """Constants with their intervals, the error and the warnings."""
    limits = (
        f", of which {calibration.censored} only limit the force" if calibration.censored else ""
    )
    relative = f"{100 * calibration.relative_rmse:.2g} % of the largest force"
    facts = [
        ("method", calibration.method),
        ("fitted to", f"{calibration.points} readings{limits}"),
        ("error, rms", f"{calibration.rmse:.3g} N, {relative}"),
        ("best start", calibration.status),
        ("intervals", calibration.intervals),
    ]
    rows = [
        [e.name, *(pretty(x, e.dimension) for x in (e.value, e.low, e.high)),
         "yes" if e.identifiable else "no"]
        for e in calibration.parameters
    ]  # fmt: skip
    heads = ("fitted", "value", "from, 90 %", "to", "identifiable")
    kind = "synthetic readings" if calibration.record.synthetic else "a record"
    notes = [f"! {finding.code}" for finding in calibration_findings(calibration)]
    return ReprTable(f"Calibration to {kind}", facts, heads, rows, notes)


def selection_table(selection: Selection) -> ReprTable:
    """The selected calibration, and the reasons."""
    table = calibration_table(selection.calibration)
    tried = f"{len(selection.candidates)} candidates" if selection.candidates else "no others"
    return table._replace(
        title=f"Selected: {table.title[0].lower()}{table.title[1:]}",
        facts=[*table.facts, ("tried", tried)],
        notes=[*selection.reasons, *table.notes],
    )


def selection_reasons(trials: Sequence[Trial], best: Trial, by_strain: bool = False) -> list[str]:
    """Reasons for the `best` of the `trials`, a line each.

    `by_strain`: stretches of strain were left out in turn, not pressures.
    """
    valid = [trial.candidate for trial in trials if trial.valid]
    selected, lowest = best.candidate, min(valid, key=lambda c: c.left_out_rmse)
    lines = [
        f"Selected: {selected.label} ({_count(selected)}), cross-validated error"
        f" {_error(selected)} of the largest force."
    ]
    if lowest is selected:
        possible = "" if len(valid) == len(trials) else " possible"
        lines.append(f"None of the {len(valid)}{possible} candidates has a smaller error.")
    else:
        lines.append(
            f"The smallest error is {_error(lowest)}, with {lowest.label} ({_count(lowest)}): the"
            " difference is no larger than chance or 2 %, so the fewest constants are selected."
        )
    lines += [*marginal_gains(trials, best), *exclusions(trials)]
    lines += [
        f"The paper's tuning ({_count(candidate)}): {_error(candidate)}."
        for candidate in valid
        if candidate.label == TUNING and candidate is not selected
    ]
    fold = "stretch-of-strain" if by_strain else "pressure"
    return [
        *lines,
        f"Model selected by leave-one-{fold}-out cross-validation (one-standard-error rule): the"
        " fewest parameters within one standard error, 2 %, or one reading's share of the best.",
    ]


def exclusions(trials: Sequence[Trial]) -> list[str]:
    """Candidates that no muscle can be, though they may have smaller errors, a line each."""
    return [
        f"Excluded: {trial.candidate.label}: {trial.violation} is impossible."
        for trial in trials
        if trial.violation
    ]


def marginal_gains(trials: Sequence[Trial], best: Trial) -> Iterator[str]:
    """Gain of each constant of the `best` trial, and of each further one, a line each."""
    errors = {
        frozenset(trial.candidate.names): trial.candidate
        for trial in trials
        if trial.valid and trial.candidate.method == "constants"
    }
    if best.candidate.method != "constants":
        return
    names = frozenset(best.candidate.names)
    for name in dict.fromkeys(name for trial in trials for name in trial.candidate.names):
        neighbor, constant = errors.get(names ^ {name}), _CONSTANTS.get(name, f"`{name}`")
        if neighbor is None:
            continue
        if name in names:
            yield (
                f"Adding {constant} reduces the cross-validated error from {_error(neighbor)} to"
                f" {_error(best.candidate)}."
            )
        else:
            yield (
                f"Adding {constant} does not pay: the cross-validated error would be"
                f" {_error(neighbor)}."
            )


def length_violation(active: float, rest_length: float, tolerance: float) -> str:
    """Message for an `active` length [m] above the distance of the fittings, `rest_length` [m].

    Empty for one that isn't longer by more than a `tolerance` [-].
    """
    if active <= (1 + tolerance) * rest_length:
        return ""
    lengths = pretty(active, "length"), pretty(rest_length, "length")
    return "an active length of {} in a muscle of {}".format(*lengths)


def _error(candidate: Candidate) -> str:
    """Text of a candidate's cross-validated error, in percent of the largest force."""
    return f"{100 * candidate.relative_left_out_rmse:.3g} %"


def _count(candidate: Candidate) -> str:
    """Text of a candidate's number of constants."""
    return f"{candidate.constants} constant{'' if candidate.constants == 1 else 's'}"


def range_text(values: np.ndarray) -> str:
    """Range of `values` with two digits."""
    low, high = f"{float(np.min(values)):.2g}", f"{float(np.max(values)):.2g}"
    return low if low == high else f"{low} to {high}"


def list_text(names: Sequence[str]) -> str:
    """Names in a sentence: a, b and c."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
