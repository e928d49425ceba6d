"""Words of a calibration: its verdict, its findings and what to do about them, its readings, the
search and the model selection.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..calibrate.calibration import CALIPERS, Calibration, Estimate, largest_force
from ..calibrate.data import MIN_PUSHES, FitData
from ..calibrate.findings import Verdict, calibration_findings, judge
from ..calibrate.gauges import DIMENSIONS as GAUGE_DIMENSIONS
from ..calibrate.gauges import PERFECT
from ..calibrate.least_squares import STATUS, SearchEnds
from ..calibrate.model_selection import Candidate, Selection
from ..calibrate.parameters import FACTOR_NAMES, parameter_descriptions
from ..core.findings import Finding
from ..units import pretty
from .words import Part, count_text, list_text, render


_ACTIONS = 2  # in a verdict: more are not done
_MAX_DIGITS = 12  # of a printed interval: float64 is exact to little more
_NO_FRICTION = 5e-3  # of the mean width of loops: a smaller part would print as zero
_SAME_MINIMUM = 0.02  # of the cost, a fifth of a standard deviation: no data tell two ends apart
_PUSHING = "with a gauge that measures pushes"
_RUBBER_TEST = " in a tensile test of the rubber"
_STATUS = {
    "converged": "converged", "stopped": "stopped after 200 steps before convergence",
    "broke": "stopped because the solver could not continue",
}  # fmt: skip
_CONSTANTS = {
    "dead_band": "a dead band", "active_length": "a fitted active length",
    "end_compliance": "end compliance", "force_zero": "a zero of the load cell",
    "pressure_zero": "a zero of the pressure transducer",
}  # fmt: skip
# what to read about, by the first part of a finding's code
_TOPICS = {
    "gauge": "gauges", "channel": "gauges",
    "fit": "residuals", "residuals": "residuals", "intervals": "residuals",
    "readings": "not measured", "coverage": "not measured",
    "constants": "not determined by these data", "curves": "not determined by these data",
    "use": "use of the muscle",
}  # fmt: skip
_GAUGES = {
    "force_zero": ("The load cell does not read zero without force", "zero the load cell"),
    "force_gain": ("The load cell's readings are not to scale",
                   "check the load cell with a known weight"),
    "force_drift": ("The load cell's zero drifts", "let the load cell warm up"),
    "pressure_zero": ("The pressure transducer does not read zero without pressure",
                      "zero the transducer with the muscle vented"),
    "displacement_zero": ("The contraction does not read zero at the rest length",
                          "measure the rest length again"),
}  # fmt: skip
_FITS = {
    "not converged": "the search did not converge: do not use these constants",
    "untested": "too few readings to judge the fit",
    "noise": "good fit: the residuals look like noise",
    "other sizes": "good fit, with fitted sizes that differ from the given ones",
    "well": "good fit: the errors are small but systematic",
    "roughly": "rough fit: errors of {}",
    "poorly": "bad fit: errors of {}; a law, a size or a gauge is wrong",
}  # of a verdict, with the size of the errors
# causes of residuals and remedies; without a remedy, the constant is to be fitted
_CAUSES = {
    "compliance": ("an end effect, compliant fibers or fittings", "fit end_compliance, too"),
    "unswelling_ends": ("an end effect, ends that do not swell",
                        "compare tension laws: tondu_lopez scales the strain"),
    "length_zero": ("an error of the length's zero", "check the rest length"),
    "load_cell_zero": ("an offset of the load cell",
                       "subtract the load cell's reading without pressure at the rest length"),
    "rubber": (
        "the bladder's elasticity, a force that depends on strain alone",
        "use the model at the measured strains only: c10 and c01 can't describe this force",
    ),
    "friction": ("friction, a hysteresis loop",
                 "count the loop's width as an error of the muscle in use"),
    "drift": ("a drift in time", "measure the first pressure again at the end"),
    "drift_or_friction": ("a drift in time, or friction on branches that are not known",
                          "measure the first pressure again at the end"),
    "resisting_law": (
        "the law past the free strain, or an error of a gauge: these data can't tell them apart",
        "compare the laws with --compare, and zero the load cell with the muscle vented, at rest",
    ),
    "dead_band": ("a dead band, or an offset of the pressure transducer", ""),
    "passive_length": ("an end effect, part of the length is passive", ""),
    "wall_thickness": ("a wrong wall thickness", ""),
    "modulus": ("a wrong modulus of the rubber", ""),
    "braid_angle": ("a wrong braid angle", ""),
    "outer_radius": ("a wrong radius", ""),
}  # fmt: skip
_CONFOUNDERS = {
    "branch": "friction, as each direction was measured in its own time",
    "file": "another zero in each file, as each was measured in its own time",
}
_SHAPES = {
    "free_strain": "The free strain over the law's is no polynomial of order 3 or less",
    "blocked_force": "The blocked force is not linear in pressure",
}
Data = Mapping[str, Any]


class Words(NamedTuple):
    """Words of a finding, and the `action` to take, if any; the least `rank` matters most."""

    topic: str
    rank: int
    text: str
    action: str = ""

    @property
    def line(self) -> str:
        """Text and action."""
        return f"{self.text} What to do: {self.action}." if self.action else self.text


def words_of(finding: Finding) -> Words:
    """Words of a `finding` of a calibration."""
    kind, _, name = finding.code.partition(".")
    rank, text, action = _CATALOGUE.get(finding.code) or _CATALOGUE[kind]
    data = {**finding.data, "name": name} if kind == "gauge" else finding.data
    return Words(_TOPICS[kind], rank, render(text, data), render(action, data))


def warnings_by_topic(calibration: Calibration) -> dict[str, tuple[str, ...]]:
    """Warnings to read before the fitted muscle is used, by topic, the most important first."""
    words = [words_of(finding) for finding in calibration_findings(calibration)]
    ranked = sorted(words, key=lambda entry: entry.rank)
    return {
        topic: tuple(entry.line for entry in ranked if entry.topic == topic)
        for topic in dict.fromkeys(entry.topic for entry in words)
    }


def warning_lines(calibration: Calibration) -> list[str]:
    """Warnings to read before the fitted muscle is used."""
    return [line for lines in warnings_by_topic(calibration).values() for line in lines]


def actions(calibration: Calibration) -> tuple[str, ...]:
    """Advice on what to do next, the most important first."""
    words = [words_of(finding) for finding in calibration_findings(calibration)]
    # of one rank, topics as in the list of warnings
    order = list(dict.fromkeys(_TOPICS.values()))
    words.sort(key=lambda entry: (entry.rank, order.index(entry.topic)))
    return tuple(entry.action for entry in words if entry.action)[:_ACTIONS]


def cause_words(cause: Data) -> tuple[str, str]:
    """Name and remedy of a likely cause."""
    code, constant = cause["code"], cause["constant"]
    name, remedy = _CAUSES.get(code) or (f"{code}, {parameter_descriptions()[code]}", "")
    return name, f"fit {constant}, too" if constant else remedy


def verdict_lines(
    calibration: Calibration, selection: Selection | None = None
) -> tuple[list[str], list[str]]:
    """Lines of the verdict on a calibration before and after the table of constants."""
    verdict, rows = judge(calibration, selection), constant_rows(calibration.parameters)
    limits = [f"{name} ({interval})" for name, _, interval in rows if name in verdict.limits]
    gaps = [*verdict.undetermined, *limits]
    if not np.isfinite(verdict.resisting_rmse):
        gaps.append("forces past the free strain (not measured)")
    unknown = [f"Unknown: {', '.join(gaps)}."] * bool(gaps)
    to_do = [f"To do {i}: {action}." for i, action in enumerate(actions(calibration), start=1)]
    return [_judgment(calibration, verdict), _error_line(calibration, verdict)], [*unknown, *to_do]


def _judgment(calibration: Calibration, verdict: Verdict) -> str:
    """Verdict, pattern of the residuals, and likely causes."""
    diagnosis = calibration.diagnosis
    largest = "contraction" if calibration.fit_data.reads_contraction else "force"
    shares = verdict.relative_rmse, float(np.fmax(verdict.relative_rmse, verdict.left_out_rmse))
    fitted, worst = (f"{100 * share:.2g} % of the largest {largest}" for share in shares)
    size = worst if worst == fitted else f"{worst} at readings left out of the fit"
    judgment = f"Verdict: {_FITS[verdict.fit].format(size)}."
    if not diagnosis.is_white_noise:
        tests = (*diagnosis.significant, *diagnosis.autocorrelated)
        along = [word for test in tests for word in test.along.split(" and ")]
        cause = "The cause is unknown."
        if causes := diagnosis.causes:
            share = f"{100 * causes[0].share:.2g} % of the squared residuals"
            alternatives = "; or ".join(cause_words(vars(cause))[0] for cause in causes)
            cause = f"Likely cause{'s' * (len(causes) > 1)} ({share}): {alternatives}."
        names = list_text(list(dict.fromkeys(along)))
        return f"{judgment} The residuals vary with {names}. {cause}"
    if verdict.fit in ("roughly", "poorly"):
        return f"{judgment} The residuals look like noise."
    return judgment


def _error_line(calibration: Calibration, verdict: Verdict) -> str:
    """Root mean square errors of all readings and of parts of them."""
    record, data = calibration.record, calibration.fit_data
    kind = "synthetic readings" if record.synthetic else "readings"
    clipped = f", {data.clipped} of them clipped" if data.clipped else ""
    error = f"Root-mean-square error of {calibration.points} {kind}{clipped}:"
    relative = f"{100 * verdict.relative_rmse:.2g} % of the largest"
    rmse = pretty(verdict.rmse, "force", 3)
    if data.reads_contraction:
        largest = pretty(calibration.length * data.largest_strain, "length", 3)
        contraction = pretty(verdict.contraction_rmse, "length", 3)
        error += f" {contraction} of contraction under set loads, {relative} ({largest}), or {rmse}"
    else:
        error += f" {rmse}, {relative} force ({pretty(largest_force(record), 'force', 3)})"
    if np.isfinite(verdict.torque_rmse) and record.moment_arm is not None:
        torques = verdict.torque_rmse, float(np.max(np.abs(record.force * record.moment_arm)))
        torque, largest = (pretty(value, "moment", 3) for value in torques)
        error += f"; {torque} of torque ({largest} the largest)"
    if np.isfinite(verdict.pulling_rmse) and np.isfinite(verdict.resisting_rmse):
        error += (
            f"; {verdict.pulling_rmse:.3g} N where the muscle pulls, {verdict.resisting_rmse:.3g} N"
            " past the free strain"
        )
    if np.isfinite(verdict.left_out_rmse):
        error += f"; {100 * verdict.left_out_rmse:.2g} % at readings left out of the fit"
    loop, half_way, friction = calibration.loop, calibration.half_way, calibration.friction
    if loop is not None and half_way and (friction is None or friction.law is not None):
        error += (
            f"; {pretty(calibration.half_way_rmse, 'force', 3)} from the half-way curve of the"
            f" loops, which are {range_text(np.maximum(loop.width, 0.0))} N wide on average and"
            f" {pretty(float(np.nanmax(half_way.width)), 'force', 2)} at most"
        )
    return f"{error}."


def constant_rows(estimates: Sequence[Estimate]) -> list[tuple[str, str, str]]:
    """Name, value and 90 % interval of each constant."""
    rows = []
    for estimate in estimates:
        value, interval = interval_texts(estimate)
        if estimate.bound:
            low, high = interval.split(" to ")
            interval = f"at most {high}" if estimate.bound == "upper" else f"at least {low}"
        elif not estimate.identifiable:
            interval = "not determined by the data"
        rows.append((estimate.name, value, interval))
    return rows


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


def interval_method(calibration: Calibration) -> str:
    """Method of the 90 % intervals."""
    profiles = ", profile likelihood where the data give a limit" * bool(calibration.profiles)
    return f"linear approximation{profiles}, conditional on the selected model"


def search_lines(solutions: SearchEnds) -> list[str]:
    """Ends of the search from all starts, a line each."""
    lowest, lines = np.nanmin(solutions.cost), []
    ends = zip(solutions.cost, solutions.status, solutions.steps, strict=True)
    for i, (cost, status, steps) in enumerate(ends, start=1):
        line = f"start {i}: {_STATUS[STATUS[status]]} ({count_text(steps, 'step')})"
        if cost - lowest < _SAME_MINIMUM:
            line += ", at the best minimum"
        elif np.isfinite(cost):
            line += f", at a worse minimum (cost {cost:.6g})"
        lines.append(line)
    return lines


def fit_data_lines(data: FitData) -> list[str]:
    """Readings by their use in the fit, in sentences."""
    ceiling = 0 if data.at_ceiling is None else int(np.sum(data.at_ceiling))
    levels, pressures = len(data.grid.pressure), np.unique(data.record.pressure).size
    rows = [(count, f"left out: {reason}") for reason, count in data.left_out.items()]
    rows += [
        (data.clipped - ceiling, "are clipped: they only say that the force was not above"
         f" {floor_text(data.floor)}"),
        (ceiling, "at the load cell's ceiling: the force was not below it"),
        (data.noise_clipped, "small forces at strains where the pressure's other readings are"
         " clipped or do not pull: noise, taken as a force not above zero"),
        (data.pushes_clipped, f"without a pull, too few to fit the resisting force ({MIN_PUSHES}"
         " constants): taken as a force not above zero; `--fit tuning` fits it nevertheless"),
        (data.averaged, f"averaged into {data.means} means for the fit, in steps of strain, each"
         " branch by itself; errors are those of all readings"),
        (pressures * (pressures > levels), f"pressures grouped into {count_text(levels, 'level')}"),
    ]  # fmt: skip
    lines = [f"{data.read} readings read{'' if data.left_out else ', none left out'}"]
    if data.reads_contraction:
        lines.append("loads were set and contractions read: the errors are those of contractions")
    return lines + [f"{count} {text}" for count, text in rows if count > 0]


def floor_text(floor: float) -> str:
    """Force at which readings are clipped."""
    return pretty(floor, "force") if floor else "zero"


def hysteresis_message(calibration: Calibration) -> str:
    """Width of the record's loops and its share of the error in use; empty without loops."""
    loop, friction = calibration.loop, calibration.friction
    if loop is None:
        return ""
    width, pressures = np.maximum(loop.width, 0.0), count_text(loop.pressure.size, "pressure")
    share = np.maximum(loop.share, 0.0)  # noise may be negative
    if friction is not None and friction.law is None:
        mean = float(np.mean(width))
        return f"No hysteresis loop above the noise: mean width {mean:.2g} N at {pressures}."
    message = (
        f"Hysteresis loop: its width is {range_text(100 * share)} % of the pull at a pressure,"
        f" {range_text(width)} N at {pressures}. The error of a muscle in use,"
        f" {calibration.rmse:.4g} N, contains half of it; against the half-way curve the error is"
        f" {calibration.half_way_rmse:.4g} N."
    )
    if friction is None:
        return message
    constant, limit = friction.half_width(0.0), _NO_FRICTION * float(np.mean(friction.width))
    rise = friction.half_width(1e5) - constant
    # at 10 bar, more than any record holds, a rise may matter that doesn't at one
    terms = [f"{constant:.3g} N"] * (constant > limit) + [f"{rise:.3g} N/bar"] * (10 * rise > limit)
    message += (
        f" Friction: {count_text(len(friction.resolved), 'sliding spring')}, together ±"
        f"{' + '.join(terms)}; the error of their loops' widths is {friction.rmse:.3g} N."
    )
    if not all(friction.resolved):
        message += " The build-up after a turn is shorter than a step of the readings."
    return message


def damping_message(calibration: Calibration) -> str:
    """Friction by speed, in a line; empty if it is unknown."""
    damping = calibration.damping
    if len(damping.unknown) == 2:
        return ""
    texts = []
    for name in ("shortening", "lengthening"):
        if (side := getattr(damping, name)) is None:
            texts.append(f"unknown while {name}, for want of two speeds")
            continue
        value, error = side.at(side.pressure)
        pressure = pretty(side.pressure, "pressure", 3)
        text = f"{value:.3g} ± {error:.2g} N·s/m at {pressure} while {name}"
        if side.pressures > 1:
            text += f" ({side.coefficients[1] * 1e5:+.2g} N·s/m per bar)"
        texts.append(text if side.is_clear else f"{text}, not above its error: taken as none")
    speeds = " to ".join(f"{1e3 * speed:.3g}" for speed in damping.speeds)
    return f"Damping, from speeds of {speeds} mm/s: {'; '.join(texts)}."


def candidate_label(candidate: Candidate) -> str:
    """Free constants of a candidate, in a line."""
    if candidate.method == "tuning":
        return "the paper's tuning"
    names = [name for name in candidate.names if name not in FACTOR_NAMES]
    label = ", ".join(names) or "the muscle as given"
    has_factors = set(FACTOR_NAMES) <= set(candidate.names)
    return f"{label} and the factors on the resisting force" if has_factors else label


def selection_reasons(selection: Selection | None) -> list[str]:
    """Reasons for the selected constants, a line each; none without a selection."""
    if selection is None or not selection.candidates:
        return []
    groups = [
        [candidate for candidate in selection.candidates if candidate.readings == readings]
        for readings in ("pulling", "all")
    ]
    lines: list[str] = []
    for candidates in filter(None, groups):
        (best,) = (candidate for candidate in candidates if candidate.chosen)
        if candidates is groups[0] and groups[1]:
            lines.append(f"Where the muscle pulls, the best fit is {candidate_label(best)}.")
        else:
            lines += _comparison_with_best(candidates, best)
        lines += [*_gains(candidates, best), *_exclusions(selection, candidates)]
    fold = "stretch-of-strain" if selection.by_strain else "pressure"
    lines.append(
        f"Model selected by leave-one-{fold}-out cross-validation (one-standard-error rule): the"
        " fewest parameters within one standard error, 2 %, or one reading's share of the best, or"
        " with no significantly worse fit (Fisher's test, 5 %)."
    )
    part, total = selection.compared, selection.calibration.points
    if part < total:
        lines.append(f"Candidates were compared on {part} of {total} readings; the fit uses all.")
    return lines


def _comparison_with_best(candidates: Sequence[Candidate], best: Candidate) -> Iterator[str]:
    valid = [candidate for candidate in candidates if candidate.valid]
    lowest = min(valid, key=lambda candidate: candidate.left_out_rmse)
    label, number = candidate_label(best), count_text(best.constants, "constant")
    yield f"Selected: {label} ({number}), cross-validated error {_error(best)}."
    if lowest is best:
        yield f"None of the {len(valid)} possible candidates has a smaller error."
    else:
        label, number = candidate_label(lowest), count_text(lowest.constants, "constant")
        yield (
            f"The smallest error is {_error(lowest)}, with {label} ({number}): the difference is no"
            " larger than chance or 2 %, so the fewest constants are selected."
        )


def _gains(candidates: Sequence[Candidate], best: Candidate) -> Iterator[str]:
    """Gain of each constant of the `best` candidate, and of each further one, a line each."""
    if best.method != "constants":
        return
    valid = [c for c in candidates if c.valid and c.method == "constants"]
    errors = {frozenset(candidate.names): _error(candidate) for candidate in valid}
    names, by = frozenset(best.names), "the cross-validated error"
    for name in dict.fromkeys(name for candidate in candidates for name in candidate.names):
        error, constant = errors.get(names ^ {name}), _CONSTANTS.get(name, f"`{name}`")
        if error is not None and name in names:
            yield f"Adding {constant} reduces {by} from {error} to {_error(best)}."
        elif error is not None:
            yield f"Adding {constant} does not pay: {by} would be {error}."


def _exclusions(selection: Selection, candidates: Sequence[Candidate]) -> Iterator[str]:
    """Candidates that no muscle can be, though they may have smaller errors, a line each."""
    calibration = selection.calibration
    rest_length = calibration.record.rest_length or float(calibration.start.length)
    for candidate in candidates:
        label = candidate_label(candidate)
        if candidate.violation == "length":
            active, whole = pretty(candidate.value, "length"), pretty(rest_length, "length")
            reason = f"an active length of {active} in a muscle of {whole} is impossible"
            yield f"Excluded: {label}: {reason}."
        elif candidate.violation == "prior":
            reason = f"a constant would lie {candidate.value:.2g} deviations from its prior"
            yield f"Excluded: {label}: {reason}."
        elif candidate.violation:
            yield f"Excluded: {label}: a constant is at the end of its range."


def _error(candidate: Candidate) -> str:
    """Text of a candidate's cross-validated error, in percent."""
    return f"{100 * candidate.relative_left_out_rmse:.3g} %"


def range_text(values: np.ndarray) -> str:
    """Range of `values` with two digits."""
    return " to ".join(dict.fromkeys(f"{float(end):.2g}" for end in (values.min(), values.max())))


def gauge_error_texts(calibration: Calibration) -> list[str]:
    """Errors of the gauges that the readings were corrected for, with intervals."""
    findings = calibration_findings(calibration)
    errors = [
        (f.code.removeprefix("gauge."), f.data) for f in findings if f.code.startswith("gauge.")
    ]
    return [_gauge_text({**data, "name": name}) for name, data in errors]


def _gauge_text(data: Data) -> str:
    name = data["name"]
    dimension, interval = GAUGE_DIMENSIONS[name], ""
    if "low" in data:
        low, high = (pretty(data[end], dimension, 3) for end in ("low", "high"))
        interval = f", 90 % interval {low} to {high}"
        if data["low"] <= getattr(PERFECT, name) <= data["high"]:
            interval += ": perhaps no error"
    return f"{_GAUGES[name][0]} ({pretty(data['value'], dimension, 3)}{interval})"


def _saturation(data: Data) -> str:
    channel = data["channel"]
    value = pretty(data["value"], "strain" if channel == "displacement" else channel, 3)
    readings = f"{data['count']} readings of the {channel}"
    return f"{readings} are exactly {value}, the largest: the channel may be saturated."


def _pattern(data: Data) -> str:
    trends = [f"{along} ({100 * share:.2g} %)" for along, share in data["trends"].items()]
    signs = "{along} ({changes} of {pairs} pairs change sign)"
    runs = [signs.format_map(run) for run in data["runs"]]
    causes = [
        f"{cause_words(cause)[0]} (would explain {100 * cause['share']:.2g} %)"
        for cause in data["causes"]
    ]
    pieces = []
    if trends:
        pieces.append(
            f"Residuals vary with {list_text(trends)}, in brackets the share of the squared"
            " residuals: an error of the model or of the gauge, not noise."
        )
    if runs:
        pieces.append(f"Neighboring residuals are correlated along {list_text(runs)}.")
    likely = f"Likely cause: {'; or '.join(causes)}."
    return " ".join([*pieces, likely if causes else "No known cause would explain it."])


def _pattern_remedy(data: Data) -> str:
    # the data can't distinguish causes of about one share
    remedies = "; or ".join(dict.fromkeys(cause_words(cause)[1] for cause in data["causes"]))
    return remedies or "look for a pattern in the report's residuals"


def _limited(data: Data) -> str:
    limits, kinds = [], {"upper": "an upper limit", "lower": "a lower limit"}
    for limit in data["limits"]:
        value = pretty(limit["value"], limit["dimension"], 3)
        limits.append(f"{limit['name']} only {kinds[limit['bound']]}, {value} (90 %)")
    return f"The data give {list_text(limits)}."


def _correlated(data: Data) -> str:
    pairs = data["pairs"]
    texts = [f"{' and '.join(p['constants'])} ({p['correlation']:.3f})" for p in pairs]
    return f"Strongly correlated: {'; '.join(texts)}. Do not interpret them individually."


def _fitted_length(data: Data) -> str:
    length, nominal = pretty(data["length"], "length"), data["reference"]
    reference = "the initial length" if nominal is None else pretty(nominal, "length")
    own = f"The fitted muscle is {length} long: its contractions refer to that length"
    return f"{own}, those of the record to {reference}."


def _damping_unknown(data: Data) -> str:
    directions = " and while ".join(data["directions"])
    why = "there are no sweeps at constant pressure with times"
    if data["slowest"] > 0:
        slow, fast = (f"{1e3 * data[key]:.3g}" for key in ("slowest", "fastest"))
        why = f"sweeps at one pressure have one speed ({slow} to {fast} mm/s in all)"
    return f"Damping, friction that grows with the speed, is unknown while {directions}: {why}."


def _other_size(data: Data) -> str:
    value, nominal = (pretty(data[key], data["dimension"], 3) for key in ("value", "nominal"))
    return (
        f"{data['constant']} is {value}, given as {nominal}, and its whole interval is more than"
        f" {100 * CALIPERS:g} % off: it is the law's effective size, with the errors of law, gauges"
        " and record in it. The given size may well be right."
    )


def _remedy(name: str) -> str:
    """Action for a constant that the data do not determine."""
    if name in FACTOR_NAMES:
        return f"to determine {name}, take more readings near and past the collapse, {_PUSHING}"
    if name in GAUGE_DIMENSIONS:
        return "read the gauges without pressure at the rest length, first and last"
    if name == "dead_band":  # nothing else measures it
        return ""
    test = _RUBBER_TEST if name in ("c10", "c01") else ""
    return f"measure {name}{test} and give it as the prior {name}=VALUE,DEVIATION"


# rank, text and action by code, or by its first part
_CATALOGUE: dict[str, tuple[int, Part, Part]] = {
    "gauge": (
        4, lambda data: f"{_gauge_text(data)}: the readings are corrected for it.",
        lambda data: f"{_GAUGES[data['name']][1]} before the next record"),
    "channel.ceiling": (
        5, "{count} forces are exactly {value:force}, the load cell's ceiling: they only say that"
        " the force was not below it.", "use a load cell of a larger range"),
    "channel.saturation": (5, _saturation, "check the range of the {channel}"),
    "fit.not_converged": (
        0, lambda data: f"The search {_STATUS[data['status']]}.",
        "search from more starts, --starts 16"),
    "fit.untested": (
        1, "Too few readings for the number of constants: residuals can't be tested.",
        "take more readings, or fit fewer constants"),
    "fit.noisy": (
        1, "Errors of {relative_rmse:percent} of the largest value without a pattern: the noise of"
        " a gauge, or a column that is not what it was read as.",
        "check the columns of pressure, force and length, and the noise of their gauges"),
    "residuals.pattern": (3, _pattern, _pattern_remedy),
    "intervals.wider_by_model": (
        9, lambda data: f"Intervals are {range_text(np.array([data['least'], data['most']]))} times"
        " as wide as from noise alone, by the model's error.", ""),
    "intervals.wider_by_correlation": (
        9, "Intervals are {ratio:.2g} times as wide as from noise alone, by correlated residuals.",
        ""),
    "readings.clipped": (
        9, lambda data: f"{data['count']} readings are clipped at {floor_text(data['floor'])}: they"
        " only say that the force was not above it.", ""),
    "coverage.one_pressure": (
        1, "Data at one pressure only ({pressure:pressure}): the dependence on pressure is the"
        " law's.", "measure at three pressures or more"),
    "coverage.no_resistance": (
        7, "Nothing past the free strain was measured: the data contain no information on bending,"
        " collapse and the hinge.",
        f"if pushes matter, compress the muscle past its free strain, {_PUSHING}"),
    "coverage.no_collapse": (
        6, "No reading lies past a collapse: the data do not determine {constants:list}.",
        "compress the muscle until it folds"),
    "coverage.tuning_range": (
        9, "C1 and C2 are determined up to {pressure:pressure} and held constant above it.", ""),
    "constants.limited": (6, _limited, lambda data: _remedy(data["limits"][0]["name"])),
    "constants.undetermined": (
        5, "The data do not determine {constants:list}: their values rest on their priors.",
        lambda data: _remedy(data["constants"][0])),
    "constants.law_in_doubt": (
        3, "The residuals contradict the law past the free strain: {constants:list} hold for this"
        " law only.", ""),
    "constants.confounded": (
        9, "Not fitted: {constants:list}. The data can't distinguish these from the fitted"
        " constants.", ""),
    "constants.correlated": (
        4, _correlated,
        lambda data: data["constant"] and (
            _remedy(data["constant"]) or f"leave {data['constant']} out of --fit")),
    "constants.sparse_transition": (
        6, "Only {count:.2g} readings at a pressure lie in the transition after collapse (1/β of"
        " strain): with fewer than {enough} the collapse moment's interval is too narrow.",
        "take more readings near the collapse"),
    "curves.unread": (
        8, lambda data: "Blocked force and free strain could not be read at"
        f" {', '.join(f'{p / 1e3:.4g}' for p in data['pressures'])} kPa: too few readings pull"
        " there.", "measure more strains at these pressures"),
    "curves.misfit": (
        8, lambda data: f"{_SHAPES[data['curve']]} within the errors of its readings"
        f" ({data['ratio']:.3g} times them): the smooth curve misses some of them, and its"
        " uncertainty is increased.", ""),
    "coverage.drift_confounded": (
        9, lambda data: "A drift of the load cell can't be distinguished from "
        + " or ".join(_CONFOUNDERS[name] for name in data["confounders"]) + ".",
        "measure the first pressure again at the end, in the same file"),
    "use.no_force": (
        1, "No force was measured: free contraction shows how far a muscle goes, not how strong it"
        " is. Computed forces rest on the given radius or rubber, and are untested.",
        "hang a known mass on the muscle and record it, too"),
    "use.no_loop": (
        7, "Measured in one direction, or in an unknown one: a muscle in use has a hysteresis loop"
        " of friction, which these errors do not contain.",
        "measure each pressure while the muscle shortens and while it lengthens"),
    "use.damping_unknown": (9, _damping_unknown, "measure each pressure at two speeds or more"),
    "use.fitted_length": (9, _fitted_length, ""),
    "use.other_length": (
        2, lambda data: f"The muscle is {pretty(data['length'], 'length')} long, but the record's"
        f" strains refer to {pretty(data['reference'], 'length')}: they were multiplied by"
        f" {data['reference'] / data['length']:.4g}.",
        "correct the muscle's length or the record's rest length, which a record of strains doesn't"
        " need; if the fittings are farther apart than the muscle is long, both are right"),
    "use.other_size": (
        2, _other_size, lambda data: "use {} (given {}) as this law's {}, not as a measured"
        " size".format(*(pretty(data[key], data["dimension"], 3) for key in ("value", "nominal")),
                       data["constant"])),
}  # fmt: skip
