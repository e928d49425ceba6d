"""Messages about a calibration: warnings, reasons for a selection, summaries, and tables."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ..repr_table import ReprTable
from ..units import pretty
from .calibration import Calibration, Candidate, Estimate, Selection, Trial
from .data import MIN_PUSHES, FitData
from .diagnostics import Diagnosis
from .friction import Friction
from .gauges import DIMENSIONS as GAUGE_DIMENSIONS
from .least_squares import Solutions


TUNING = "the paper's tuning"
AS_GIVEN = "the muscle as given"
_TIED = 0.95  # correlation from which two parameters can't be interpreted one by one
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_WIDER = 1.05  # ratio of widths: a smaller change is not visible in two digits
_MIN_LEVELS = 3  # pressures: fewer show no dependence on pressure
_CLEAR = 4.0  # standard deviations of a reading, from which two of them differ
_MAX_SIGNS = 3  # strains in a sentence that is still read
_CALIPERS = 0.1  # of a size: an error that no measurement with calipers makes
_SMALLEST_CHANCE = 1e-12  # real noise is never normal so far out in its tails
_MAX_DIGITS = 12  # of a printed interval: float64 is exact to little more
_NO_FRICTION = 5e-3  # of the mean width of loops: a smaller part would print as zero
_AFTER_COLLAPSE = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")
_SAME_MINIMUM = 0.02  # of the cost, a fifth of a standard deviation: no data tell two ends apart
_STATUS = ("converged", "stopped after 200 steps before convergence",
           "stopped because the solver could not continue")  # fmt: skip
_GAUGE_ERRORS = {
    "force_zero": "The load cell does not read zero without force",
    "force_gain": "The load cell's readings are not to scale",
    "force_drift": "The load cell's zero drifts",
    "pressure_zero": "The pressure transducer does not read zero without pressure",
    "displacement_zero": "The contraction does not read zero at the rest length",
}
_CONSTANTS = {
    "dead_band": "a dead band", "active_length": "another active length",
    "end_compliance": "end compliance",
}  # fmt: skip


def calibration_warnings(calibration: Calibration) -> dict[str, tuple[str, ...]]:
    """Warnings to read before the fitted muscle is used, by topic."""
    topics = {
        "gauges": gauge_warnings(calibration),
        "residuals": _residual_warnings(calibration),
        "not measured": _coverage_warnings(calibration),
        "not identifiable from these data": _parameter_warnings(calibration),
        "in use": _usage_warnings(calibration),
    }
    return {topic: tuple(lines) for topic, lines in topics.items() if lines}


def gauge_warnings(calibration: Calibration) -> list[str]:
    """Errors of the gauges that the readings were corrected for, and faults of the channels."""
    lines, fitted = [], {estimate.name: estimate for estimate in calibration.parameters}
    for name, value in calibration.gauge.faults.items():
        dimension = GAUGE_DIMENSIONS[name]
        interval = f" ({pretty(value, dimension, 3)})"
        if name in fitted:
            low, high = (pretty(x, dimension, 3) for x in (fitted[name].low, fitted[name].high))
            interval = f" ({pretty(value, dimension, 3)}, 90 % {low} to {high})"
        lines.append(f"{_GAUGE_ERRORS[name]}{interval}: the readings are corrected for it.")
    for fault in calibration.fit_data.faults:
        dimension = {"force": "force", "pressure": "pressure", "displacement": "strain"}
        value = pretty(fault.value, "time" if fault.kind == "lag" else dimension[fault.channel], 3)
        text = {
            "floor": "",  # in the readings that are clipped
            "ceiling": f"{fault.count} forces are exactly {value}, the load cell's ceiling: they"
            " only say that the force was not below it.",
            "saturation": f"{fault.count} readings of the {fault.channel} are exactly {value}, the"
            " largest: the channel may be saturated. Check its range.",
            "quantization": f"The forces are multiples of {value}: use a finer range of the load"
            " cell.",
            "lag": f"The force follows the {fault.channel} by {value}: check filters and"
            " synchronization of the channels, or move slower.",
        }[fault.kind]
        lines += [text] if text else []
    return lines


def _residual_warnings(calibration: Calibration) -> list[str]:
    """Failed search, trends and runs of the residuals, their causes, and wider intervals."""
    diagnosis, solutions, lines = calibration.diagnosis, calibration.solutions, []
    if solutions.status[solutions.best]:
        lines.append(
            f"The search {calibration.status}: treat the result with caution, or use more starts."
        )
    lines += [
        f"Residuals follow {trend.along}: a smooth curve along it explains"
        f" {100 * trend.share:.3g} % of their squares (p-value {_chance(trend.chance)}). This is"
        " an error of the model or of the gauge, not noise."
        for trend in diagnosis.significant
    ]
    lines += [
        f"Neighboring residuals along {run.along} change sign in {run.changes} of {run.pairs} pairs"
        " (noise: in half of them): they are correlated."
        for run in diagnosis.autocorrelated
    ]
    if not diagnosis.is_white_noise:
        lines += _pattern_lines(diagnosis)
    if diagnosis.significant and calibration.parameters:
        wider = calibration.wider
        ratio = "hardly wider than"
        if np.max(wider) >= _WIDER:
            ratio = f"{_range(wider)} times as wide as"
        lines.append(
            "Intervals include a discrepancy: a smooth error of the model along"
            f" {_list([trend.along for trend in diagnosis.significant])}, as large where the fit"
            f" absorbed it as where it is visible. They are {ratio} with noise alone."
        )
    if diagnosis.inflation > 1 and calibration.parameters:
        lines.append(
            "Residuals are correlated along a sweep: intervals are"
            f" {np.sqrt(diagnosis.inflation):.3g} times as wide for it."
        )
    if not np.isfinite(diagnosis.noise):
        lines.append("Too few readings for the number of constants: residuals can't be tested.")
    return lines


def _pattern_lines(diagnosis: Diagnosis) -> list[str]:
    """Signs of the residuals, their change with pressure at the least strain, and causes."""
    lines = []
    counts = [
        f"{max(entry.below, entry.count - entry.below)} of {entry.count} readings lie"
        f" {'below' if 2 * entry.below > entry.count else 'above'} the fit near strain"
        f" {entry.strain:.3g}"
        for entry in diagnosis.signs[:_MAX_SIGNS]
    ]
    if counts:
        lines.append(f"{_list(counts)}.")
    if len(diagnosis.least_strain) >= _MIN_LEVELS and np.isfinite(diagnosis.noise):
        # end effects and a dead band show here
        P, means = np.array(diagnosis.least_strain).T
        low, high = sorted((int(np.argmin(means)), int(np.argmax(means))))
        if np.ptp(means) >= _CLEAR * diagnosis.noise:
            lines.append(
                f"At the least strain residuals range from {means[low]:+.3g} N at"
                f" {P[low] / 1e3:.4g} kPa to {means[high]:+.3g} N at {P[high] / 1e3:.4g} kPa."
            )
    if diagnosis.causes:
        names = [f"{c.name} (would explain {100 * c.share:.3g} %)" for c in diagnosis.causes]
        remedy = diagnosis.causes[0].remedy
        lines.append(f"Likely cause: {'; or '.join(names)}. What to do: {remedy}.")
    else:
        lines.append("No known cause would explain much of it.")
    return lines


def _coverage_warnings(calibration: Calibration) -> list[str]:
    """Parts of the law that the data do not cover."""
    lines, grid = [], calibration.grid
    strain = calibration.problem.strain(calibration.muscle)
    past = grid.measured & (strain > calibration.free_strain[:, None] + 1e-9)
    if calibration.censored:
        effect = ", so nothing past the free strain was measured there"
        lines.append(
            f"{calibration.censored} readings are clipped at {calibration.floor}: they only say"
            f" that the force was not above it{effect if calibration.floor == 'zero' else ''}."
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
            "Nothing past the free strain was measured: the data contain no information on"
            " bending, collapse and the hinge."
        )
    elif names:
        columns = [calibration.names.index(name) for name in names]
        if not np.any(calibration.minimum.linear.slopes[: strain.size, columns]):
            verb = "stay at their priors" if len(names) > 1 else "stays at its prior"
            lines.append(
                f"No reading lies past a collapse: {_list(names)} can't be determined and {verb}."
            )
    if calibration.readings is not None and calibration.muscle.tuning.pressures.size > 1:
        highest = float(np.max(calibration.muscle.tuning.pressures))
        lines.append(
            f"C1 and C2 are determined up to {highest / 1e3:.4g} kPa and held constant above it."
        )
    return lines


def _parameter_warnings(calibration: Calibration) -> list[str]:
    """Parameters and curves that the data do not determine."""
    lines, estimates = [], calibration.parameters
    for estimate in estimates:
        if estimate.bound:
            end = estimate.high if estimate.bound == "upper" else estimate.low
            article = "an" if estimate.bound == "upper" else "a"
            lines.append(
                f"The data give {estimate.name} only {article} {estimate.bound} limit,"
                f" {pretty(end, estimate.dimension, 3)} (90 %)."
            )
    undetermined = [e.name for e in estimates if not e.identifiable and not e.bound]
    if len(undetermined) == 1:
        lines.append(
            f"{undetermined[0]} is not determined by the data; its estimate is dominated by the"
            " prior."
        )
    elif undetermined:
        lines.append(
            f"{_list(undetermined)} are not determined by the data; their estimates are dominated"
            " by the priors."
        )
    if confounded := list(calibration.diagnosis.confounded):
        lines.append(
            f"Not fitted: {_list(confounded)}. The data can't distinguish"
            f" {'them' if len(confounded) > 1 else 'it'} from the fitted constants."
        )
    for i, estimate in enumerate(estimates):
        for j, previous in enumerate(estimates[:i]):
            r = calibration.correlation[i, j]
            if abs(r) > _TIED and estimate.identifiable and previous.identifiable:
                lines.append(
                    f"{previous.name} and {estimate.name} are strongly correlated ({r:.3f}); do"
                    " not interpret them individually."
                )
    rate = next((e for e in estimates if e.name == "transition_rate" and e.identifiable), None)
    if rate is not None:
        used = calibration.grid.measured
        strain = np.where(used, calibration.problem.strain(calibration.muscle), np.nan)
        strain = strain[np.any(used, axis=1)]
        spacing = np.nanmax(strain, axis=1) - np.nanmin(strain, axis=1)
        spacing = float(np.median(spacing / np.sum(np.isfinite(strain), axis=1)))
        count = 1 / (rate.value * spacing)
        if count < _DENSE:
            lines.append(
                f"Only {count:.2g} readings at a pressure lie in the transition after collapse"
                f" (1/β of strain): with fewer than {_DENSE} the collapse moment's interval is too"
                " narrow."
            )
    if (readings := calibration.readings) is not None:
        P = readings.pressure
        missing = P[~readings.valid & (0.01 * P.max() < P)]
        if missing.size:
            lines.append(
                "Blocked force and free strain could not be read at"
                f" {', '.join(f'{p / 1e3:.4g}' for p in missing)} kPa: too few readings pull there."
            )
        shapes = ("The free strain over the law's is no polynomial of order 3 or less",
                  "The blocked force is not linear in pressure")  # fmt: skip
        lines += [
            f"{shape} within the errors of its readings ({np.sqrt(misfit):.3g} times them): the"
            " smooth curve misses some of them, and its uncertainty is increased."
            for misfit, shape in zip(readings.misfit, shapes, strict=True)
            if misfit > 1
        ]
    return lines


def _usage_warnings(calibration: Calibration) -> list[str]:
    """Effects in use that the errors leave out, and sizes that are not the muscle's."""
    lines, muscle, rest_length = [], calibration.start, calibration.record.rest_length
    if calibration.loop is None:
        lines.append(
            "Measured in one direction, or in an unknown one: these errors do not contain the"
            " hysteresis loop of friction, which a muscle in use has."
        )
    if "active_length" in calibration.names:
        reference = "the initial length" if rest_length is None else pretty(rest_length, "length")
        length = pretty(float(calibration.muscle.length), "length")
        lines.append(
            f"The fitted muscle is {length} long: its contractions refer to that length, those of"
            f" the record to {reference}."
        )
    for estimate in calibration.parameters:
        size, name = getattr(muscle, estimate.name, None), estimate.name
        if name == "active_length":
            size = rest_length or float(muscle.length)
        if size is None or not estimate.identifiable:
            continue
        if estimate.dimension not in ("length", "angle"):
            continue
        larger, smaller = (
            estimate.low > (1 + _CALIPERS) * size,
            estimate.high < (1 - _CALIPERS) * size,
        )
        # an active length may be shorter than the distance of the fittings, never longer
        if larger or (smaller and name != "active_length"):
            value, given = (pretty(x, estimate.dimension, 3) for x in (estimate.value, float(size)))
            lines.append(
                f"{name} is {value}, given as {given}, and its whole interval is more than"
                f" {100 * _CALIPERS:g} % off: it compensates for an error of the law and is no"
                " measured size."
            )
    return lines


def hysteresis_message(calibration: Calibration) -> str:
    """Width of the record's loops and its share of the error in use; empty without loops."""
    loop, friction = calibration.loop, calibration.friction
    if loop is None:
        return ""
    count = loop.pressure.size
    if friction is not None and friction.law is None:
        return (
            "No hysteresis loop above the noise: mean width"
            f" {float(np.mean(loop.width)):.2g} N at {count} pressure{'s' * (count > 1)}."
        )
    place = f"at {count} pressures" if count > 1 else "there"
    message = (
        f"Hysteresis loop: its width is {_range(100 * loop.share)} % of the pull at a pressure,"
        f" {_range(loop.width)} N {place}. The error of a muscle in use, {calibration.rmse:.4g} N,"
        f" contains half of it; against the half-way curve the error is"
        f" {calibration.half_way_rmse:.4g} N."
    )
    return message if friction is None else f"{message} {friction_message(friction)}"


def friction_message(friction: Friction) -> str:
    """Fitted friction, in a sentence or two."""
    if friction.law is None:
        return "No friction above the noise: both branches coincide."
    count, constant = len(friction.resolved), friction.half_width(0.0)
    rise, least = friction.half_width(1e5) - constant, _NO_FRICTION * float(np.mean(friction.width))
    # at 10 bar, more than any record holds, a rise may matter that doesn't at one
    terms = [f"{constant:.3g} N"] * (constant > least) + [f"{rise:.3g} N/bar"] * (10 * rise > least)
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
        above = 0 if data.at_ceiling is None else int(np.sum(data.at_ceiling))
        if data.clipped > above:
            lines.append(
                f"{data.clipped - above} clipped: they only say that the force was not above"
                f" {data.floor}"
            )
        if above:
            lines.append(f"{above} at the load cell's ceiling: the force was not below it")
    if data.noise_clipped:
        lines.append(
            f"{data.noise_clipped} of these are small forces at strains where the pressure's other"
            " readings are clipped: treated as noise"
        )
    if data.pushes_clipped:
        verb = "does" if data.pushes_clipped == 1 else "do"
        lines.append(
            f"{data.pushes_clipped} of these {verb} not pull, too few to fit the resisting force"
            f" ({MIN_PUSHES} numbers): `--fit tuning` fits it nevertheless"
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


def end_messages(solutions: Solutions) -> list[str]:
    """Ends of the search from all starts, a line each."""
    lowest, lines = np.nanmin(solutions.cost), []
    columns = (solutions.cost.tolist(), solutions.status.tolist(), solutions.steps.tolist())
    for i, (cost, status, steps) in enumerate(zip(*columns, strict=True), start=1):
        line = f"start {i}: {_STATUS[status]} ({steps} step{'' if steps == 1 else 's'})"
        if cost - lowest < _SAME_MINIMUM:
            line += ", at the best minimum"
        elif np.isfinite(cost):
            line += f", at a worse one (cost {cost:.6g})"
        lines.append(line)
    return lines


def interval_method(calibration: Calibration) -> str:
    """Method of a calibration's 90 % intervals."""
    boots, condition = calibration.bootstrapped, ", conditional on the selected model"
    if boots is None:
        profiles = ", profile likelihood where the data give a limit" * bool(calibration.profiles)
        return f"linear approximation (C3){profiles}{condition}; --intervals bootstrap simulates"
    failed = f", {boots.failed} more failed" if boots.failed else ""
    return f"parametric bootstrap of the whole fit, {len(boots.values)} draws{failed}{condition}"


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


def identifiability_text(estimate: Estimate) -> str:
    """Note on an estimate that the data do not determine; else empty."""
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
        [e.name, *(pretty(x, e.dimension) for x in (e.value, e.low, e.high)),
         "yes" if e.identifiable else "no"]
        for e in calibration.parameters
    ]  # fmt: skip
    heads = ("fitted", "value", "from, 90 %", "to", "identifiable")
    kind = "synthetic readings" if calibration.record.synthetic else "a record"
    notes = [f"! {line}" for line in calibration.warnings]
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
            " difference is no larger than chance or 2 %, so the fewest numbers are selected."
        )
    lines += [*marginal_gains(trials, best), *exclusions(trials)]
    lines += [
        f"The paper's tuning ({_count(candidate)}): {_error(candidate)}."
        for candidate in valid
        if candidate.label == TUNING and candidate is not selected
    ]
    part = "stretch-of-strain" if by_strain else "pressure"
    return [
        *lines,
        f"Model selected by leave-one-{part}-out cross-validation (one-standard-error rule): the"
        " fewest parameters within one standard error, 2 %, or one reading's share of the best.",
    ]


def thinning(compared: int, total: int) -> tuple[str, ...]:
    """Sentence on the number of readings that candidates were `compared` on, if not all."""
    if compared == total:
        return ()
    return (f"Candidates were compared on {compared} of {total} readings, the fit uses all.",)


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


def length_violation(active: float, rest: float, tolerance: float) -> str:
    """Message for an `active` length [m] above the distance of the fittings, `rest` [m].

    Empty for one that isn't longer by more than a `tolerance` [-].
    """
    if active <= (1 + tolerance) * rest:
        return ""
    return f"an active length of {pretty(active, 'length')} in a muscle of {pretty(rest, 'length')}"


def _chance(chance: float) -> str:
    return f"{chance:.1g}" if chance > _SMALLEST_CHANCE else f"below {_SMALLEST_CHANCE:.0g}"


def _error(candidate: Candidate) -> str:
    return f"{100 * candidate.relative_left_out_rmse:.3g} %"


def _count(candidate: Candidate) -> str:
    return f"{candidate.constants} number{'' if candidate.constants == 1 else 's'}"


def _range(values: np.ndarray) -> str:
    low, high = f"{float(np.min(values)):.2g}", f"{float(np.max(values)):.2g}"
    return low if low == high else f"{low} to {high}"


def _list(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
