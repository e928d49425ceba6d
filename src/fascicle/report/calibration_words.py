"""Words of a calibration's findings and verdict: what is wrong, and what to do about it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..calibrate.calibration import CALIPERS, Calibration, Estimate, Selection, largest_force
from ..calibrate.findings import calibration_findings
from ..calibrate.gauges import DIMENSIONS as GAUGE_DIMENSIONS
from ..calibrate.gauges import PERFECT
from ..calibrate.messages import floor_text, interval_texts, list_text, range_text
from ..calibrate.parameters import FACTOR_NAMES, parameter_descriptions
from ..calibrate.verdict import Verdict, judge
from ..core.findings import Finding
from ..units import pretty


_ACTIONS = 2  # in a verdict: more are not done
_MAX_SIGNS = 3  # strains in a sentence that is still read
# what to read about, by the first part of a finding's code
_TOPICS = {
    "gauge": "gauges", "channel": "gauges",
    "fit": "residuals", "residuals": "residuals", "intervals": "residuals",
    "readings": "not measured", "coverage": "not measured",
    "constants": "not determined by these data", "curves": "not determined by these data",
    "use": "use of the muscle",
}  # fmt: skip
_PUSHING = "with a gauge that measures pushes"
_TESTS: dict[str, str] = dict.fromkeys(("c10", "c01"), " in a tensile test of the rubber")
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
_CHANNELS = {"force": "force", "pressure": "pressure", "displacement": "strain"}  # dimensions
_FITS = {
    "not converged": "the search did not converge: do not use these constants",
    "untested": "too few readings to judge the fit",
    "noise": "good fit: the residuals look like noise",
    "other sizes": "good fit, but only with sizes that are not this muscle's",
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


class Words(NamedTuple):
    """Words of a finding: its `topic`, what is so, and the `action` to take, if any.

    The least `rank` matters most.
    """

    topic: str
    rank: int
    text: str
    action: str = ""

    @property
    def line(self) -> str:
        """Text and action."""
        action = f" What to do: {self.action}." if self.action else ""
        return f"{self.text}{action}"


def words_of(finding: Finding) -> Words:
    """Words of a `finding` of a calibration."""
    kind, _, name = finding.code.partition(".")
    rank, render = _CATALOGUE.get(finding.code) or _CATALOGUE[kind]
    text, action = render(finding.data if kind != "gauge" else {**finding.data, "name": name})
    return Words(_TOPICS[kind], rank, text, action)


def warnings_by_topic(calibration: Calibration) -> dict[str, tuple[str, ...]]:
    """Warnings to read before the fitted muscle is used, by topic, the most important first."""
    words = [words_of(finding) for finding in calibration_findings(calibration)]
    topics: dict[str, list[Words]] = {}
    for entry in words:
        topics.setdefault(entry.topic, []).append(entry)
    return {
        topic: tuple(entry.line for entry in sorted(entries, key=lambda entry: entry.rank))
        for topic, entries in topics.items()
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


def cause_words(cause: Mapping[str, Any]) -> tuple[str, str]:
    """Name and remedy of a likely cause."""
    code, constant = cause["code"], cause["constant"]
    name, remedy = _CAUSES.get(code) or (f"{code}, {parameter_descriptions()[code]}", "")
    return name, f"fit {constant}, too" if constant else remedy


def verdict_lines(
    calibration: Calibration, selection: Selection | None = None
) -> tuple[list[str], list[str]]:
    """Lines of the verdict on a calibration before and after the table of constants."""
    verdict = judge(calibration, selection)
    gaps = [
        f"{name} ({interval})"
        for name, _, interval in constant_rows(calibration.parameters)
        if name in verdict.limits
    ]
    if not np.isfinite(verdict.resisting_rmse):
        gaps.append("forces past the free strain (not measured)")
    gaps = [*verdict.undetermined, *gaps]
    unknown = [f"Unknown: {', '.join(gaps)}."] * bool(gaps)
    to_do = [f"To do {i}: {action}." for i, action in enumerate(actions(calibration), start=1)]
    return [_judgment(calibration, verdict), _error_line(calibration, verdict)], [*unknown, *to_do]


def _judgment(calibration: Calibration, verdict: Verdict) -> str:
    """Verdict, pattern of the residuals, and likely causes."""
    diagnosis = calibration.diagnosis
    shares = verdict.relative_rmse, float(np.fmax(verdict.relative_rmse, verdict.left_out_rmse))
    fitted, worst = (f"{100 * share:.2g} % of the largest force" for share in shares)
    size = worst if worst == fitted else f"{worst} at readings left out of the fit"
    judgment = f"Verdict: {_FITS[verdict.fit].format(size)}."
    if not diagnosis.is_white_noise:
        tests = (*diagnosis.significant, *diagnosis.autocorrelated)
        along = [word for test in tests for word in test.along.split(" and ")]
        cause = "The cause is unknown."
        if causes := diagnosis.causes:
            share = f"{100 * causes[0].share:.2g} % of the squared residuals"
            plural = "s" * (len(causes) > 1)
            alternatives = "; or ".join(cause_words(vars(cause))[0] for cause in causes)
            cause = f"Likely cause{plural} ({share}): {alternatives}."
        names = list_text(list(dict.fromkeys(along)))
        return f"{judgment} The residuals vary with {names}. {cause}"
    if verdict.fit in ("roughly", "poorly"):
        return f"{judgment} The residuals look like noise."
    return judgment


def _error_line(calibration: Calibration, verdict: Verdict) -> str:
    """Root mean square errors of all readings and of parts of them."""
    record = calibration.record
    kind = "synthetic readings" if record.synthetic else "readings"
    count = calibration.fit_data.clipped
    clipped = f", {count} of them clipped" if count else ""
    error = (
        f"Root-mean-square error of {calibration.points} {kind}{clipped}:"
        f" {pretty(verdict.rmse, 'force', 3)}, {100 * verdict.relative_rmse:.2g} % of the largest"
        f" force ({pretty(largest_force(record), 'force', 3)})"
    )
    if np.isfinite(verdict.torque_rmse) and record.moment_arm is not None:
        torque = float(np.max(np.abs(record.force * record.moment_arm)))
        error += (
            f"; {pretty(verdict.torque_rmse, 'moment', 3)} of torque"
            f" ({pretty(torque, 'moment', 3)} the largest)"
        )
    if np.isfinite(verdict.pulling_rmse) and np.isfinite(verdict.resisting_rmse):
        error += (
            f"; {verdict.pulling_rmse:.3g} N where the muscle pulls, {verdict.resisting_rmse:.3g} N"
            " past the free strain"
        )
    if np.isfinite(verdict.left_out_rmse):
        error += f"; {100 * verdict.left_out_rmse:.2g} % at readings left out of the fit"
    if (loop := calibration.loop) is not None and calibration.friction_is_visible:
        error += (
            f"; {pretty(calibration.half_way_rmse, 'force', 3)} from the half-way curve of the"
            f" loops, which are {range_text(np.maximum(loop.width, 0.0))} N wide"
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


def gauge_error_texts(calibration: Calibration) -> list[str]:
    """Errors of the gauges that the readings were corrected for, with intervals."""
    findings = calibration_findings(calibration)
    return [
        _gauge_text({**finding.data, "name": finding.code.partition(".")[2]})
        for finding in findings
        if finding.code.startswith("gauge.")
    ]


def _gauge_text(data: Mapping[str, Any]) -> str:
    name = data["name"]
    dimension, interval = GAUGE_DIMENSIONS[name], ""
    if "low" in data:
        low, high = (pretty(data[end], dimension, 3) for end in ("low", "high"))
        interval = f", 90 % interval {low} to {high}"
        if data["low"] <= getattr(PERFECT, name) <= data["high"]:
            interval += ": perhaps no error"
    return f"{_GAUGES[name][0]} ({pretty(data['value'], dimension, 3)}{interval})"


Phrases = tuple[str, str]


def _gauge(data: Mapping[str, Any]) -> Phrases:
    action = f"{_GAUGES[data['name']][1]} before the next record"
    return f"{_gauge_text(data)}: the readings are corrected for it.", action


def _ceiling(data: Mapping[str, Any]) -> Phrases:
    value = pretty(data["value"], "force", 3)
    text = (
        f"{data['count']} forces are exactly {value}, the load cell's ceiling: they only say that"
        " the force was not below it."
    )
    return text, "use a load cell of a larger range"


def _saturation(data: Mapping[str, Any]) -> Phrases:
    channel = data["channel"]
    value = pretty(data["value"], _CHANNELS[channel], 3)
    text = (
        f"{data['count']} readings of the {channel} are exactly {value}, the largest: the channel"
        " may be saturated."
    )
    return text, f"check the range of the {channel}"


def _noisy(data: Mapping[str, Any]) -> Phrases:
    text = (
        f"Errors of {100 * data['relative_rmse']:.2g} % of the largest force without a pattern:"
        " the noise of a gauge, or a column that is not what it was read as."
    )
    return text, "check the columns of pressure, force and length, and the noise of their gauges"


def _pattern(data: Mapping[str, Any]) -> Phrases:
    pieces = []
    if data["trends"]:
        trends = [f"{along} ({100 * share:.2g} %)" for along, share in data["trends"].items()]
        pieces.append(
            f"Residuals vary with {list_text(trends)}, in brackets the share of the squared"
            " residuals: an error of the model or of the gauge, not noise."
        )
    if data["runs"]:
        runs = [
            f"{run['along']} ({run['changes']} of {run['pairs']} pairs change sign)"
            for run in data["runs"]
        ]
        pieces.append(f"Neighboring residuals are correlated along {list_text(runs)}.")
    causes = [(*cause_words(cause), cause["share"]) for cause in data["causes"]]
    names = [f"{name} (would explain {100 * share:.2g} %)" for name, _, share in causes]
    pieces.append(
        f"Likely cause: {'; or '.join(names)}." if names else "No known cause would explain it."
    )
    # the data can't distinguish causes of about one share
    action = "; or ".join(dict.fromkeys(remedy for _, remedy, _ in causes))
    return " ".join(pieces), action or "look for a pattern in the report's residuals"


def _one_sided(data: Mapping[str, Any]) -> Phrases:
    counts = [
        f"{max(entry['below'], entry['count'] - entry['below'])} of {entry['count']} readings lie"
        f" {'below' if 2 * entry['below'] > entry['count'] else 'above'} the fit near strain"
        f" {entry['strain']:.3g}"
        for entry in data["strains"][:_MAX_SIGNS]
    ]
    return f"{list_text(counts)}.", ""


def _at_least_strain(data: Mapping[str, Any]) -> Phrases:
    ends = [f"{end['force']:+.3g} N at {end['pressure'] / 1e3:.4g} kPa" for end in data["ends"]]
    return f"At the least strain residuals range from {' to '.join(ends)}.", ""


def _wider_by_model(data: Mapping[str, Any]) -> Phrases:
    ratio = range_text(np.array([data["least"], data["most"]]))
    return f"Intervals are {ratio} times as wide as from noise alone, by the model's error.", ""


def _wider_by_correlation(data: Mapping[str, Any]) -> Phrases:
    text = f"Intervals are {data['ratio']:.2g} times as wide as from noise alone, by correlated"
    return f"{text} residuals.", ""


def _clipped(data: Mapping[str, Any]) -> Phrases:
    text = (
        f"{data['count']} readings are clipped at {floor_text(data['floor'])}: they only say that"
        " the force was not above it."
    )
    return text, ""


def _one_pressure(data: Mapping[str, Any]) -> Phrases:
    pressure = pretty(data["pressure"], "pressure")
    text = f"Data at one pressure only ({pressure}): the dependence on pressure is the law's."
    return text, "measure at three pressures or more"


def _no_resistance(_data: Mapping[str, Any]) -> Phrases:
    text = (
        "Nothing past the free strain was measured: the data contain no information on bending,"
        " collapse and the hinge."
    )
    return text, f"if pushes matter, compress the muscle past its free strain, {_PUSHING}"


def _no_collapse(data: Mapping[str, Any]) -> Phrases:
    text = f"No reading lies past a collapse: {list_text(data['constants'])} can't be determined."
    return text, "compress the muscle until it folds"


def _tuning_range(data: Mapping[str, Any]) -> Phrases:
    highest = pretty(data["pressure"], "pressure")
    return f"C1 and C2 are determined up to {highest} and held constant above it.", ""


def _limited(data: Mapping[str, Any]) -> Phrases:
    limits = [
        f"{e['name']} only {'an' if e['bound'] == 'upper' else 'a'} {e['bound']} limit,"
        f" {pretty(e['value'], e['dimension'], 3)} (90 %)"
        for e in data["limits"]
    ]
    return f"The data give {list_text(limits)}.", _remedy(data["limits"][0]["name"])


def _undetermined(data: Mapping[str, Any]) -> Phrases:
    names = data["constants"]
    verb, prior = ("are", "their priors") if len(names) > 1 else ("is", "its prior")
    text = f"{list_text(names)} {verb} not determined by the data: the fit returns {prior}."
    return text, _remedy(names[0])


def _law_in_doubt(data: Mapping[str, Any]) -> Phrases:
    names = data["constants"]
    verb = "hold" if len(names) > 1 else "holds"
    text = (
        f"{list_text(names)} {verb} for the fitted law past the free strain only, and the residuals"
        " contradict this law there."
    )
    return text, ""


def _confounded(data: Mapping[str, Any]) -> Phrases:
    names = data["constants"]
    pronoun = "them" if len(names) > 1 else "it"
    text = f"Not fitted: {list_text(names)}. The data can't distinguish {pronoun} from the fitted"
    return f"{text} constants.", ""


def _correlated(data: Mapping[str, Any]) -> Phrases:
    pairs = [
        f"{' and '.join(pair['constants'])} ({pair['correlation']:.3f})" for pair in data["pairs"]
    ]
    text = f"Strongly correlated: {'; '.join(pairs)}. Do not interpret them individually."
    name = data["constant"]
    return text, _remedy(name) or f"leave {name} out of --fit"


def _sparse_transition(data: Mapping[str, Any]) -> Phrases:
    text = (
        f"Only {data['count']:.2g} readings at a pressure lie in the transition after collapse"
        f" (1/β of strain): with fewer than {data['enough']} the collapse moment's interval is too"
        " narrow."
    )
    return text, "take more readings near the collapse"


def _unread(data: Mapping[str, Any]) -> Phrases:
    pressures = ", ".join(f"{p / 1e3:.4g}" for p in data["pressures"])
    text = (
        f"Blocked force and free strain could not be read at {pressures} kPa: too few readings"
        " pull there."
    )
    return text, "measure more strains at these pressures"


def _misfit(data: Mapping[str, Any]) -> Phrases:
    shape = {
        "free_strain": "The free strain over the law's is no polynomial of order 3 or less",
        "blocked_force": "The blocked force is not linear in pressure",
    }[data["curve"]]
    text = (
        f"{shape} within the errors of its readings ({data['ratio']:.3g} times them): the smooth"
        " curve misses some of them, and its uncertainty is increased."
    )
    return text, ""


def _no_loop(_data: Mapping[str, Any]) -> Phrases:
    text = (
        "Measured in one direction, or in an unknown one: a muscle in use has a hysteresis loop of"
        " friction, which these errors do not contain."
    )
    return text, "measure each pressure while the muscle shortens and while it lengthens"


def _fitted_length(data: Mapping[str, Any]) -> Phrases:
    length, given = pretty(data["length"], "length"), data["reference"]
    reference = "the initial length" if given is None else pretty(given, "length")
    text = (
        f"The fitted muscle is {length} long: its contractions refer to that length, those of the"
        f" record to {reference}."
    )
    return text, ""


def _other_size(data: Mapping[str, Any]) -> Phrases:
    name = data["constant"]
    value, nominal = (pretty(data[key], data["dimension"], 3) for key in ("value", "nominal"))
    text = (
        f"{name} is {value}, given as {nominal}, and its whole interval is more than"
        f" {100 * CALIPERS:g} % off: it compensates for an error of the law or of the gauge and is"
        " no measured size."
    )
    return text, f"check the muscle's {name}: fitted {value}, given {nominal}"


def _remedy(name: str) -> str:
    """Action for a constant that the data do not determine."""
    if name in FACTOR_NAMES:
        return f"to determine {name}, take more readings near and past the collapse, {_PUSHING}"
    if name in GAUGE_DIMENSIONS:
        return "read the gauges without pressure at the rest length, first and last"
    if name == "dead_band":  # nothing else measures it
        return ""
    test = _TESTS.get(name, "")
    return f"measure {name}{test} and give it as the prior {name}=VALUE,DEVIATION"


# rank and words by code, or by its first part
_CATALOGUE: dict[str, tuple[int, Callable[[Mapping[str, Any]], Phrases]]] = {
    "gauge": (4, _gauge),
    "channel.ceiling": (5, _ceiling),
    "channel.saturation": (5, _saturation),
    "fit.not_converged": (0, lambda data: (f"The search {data['status']}.",
                                           "search from more starts, --starts 16")),
    "fit.untested": (1, lambda _: (
        "Too few readings for the number of constants: residuals can't be tested.",
        "take more readings, or fit fewer constants")),
    "fit.noisy": (1, _noisy),
    "residuals.pattern": (3, _pattern),
    "residuals.one_sided": (9, _one_sided),
    "residuals.at_least_strain": (9, _at_least_strain),
    "intervals.wider_by_model": (9, _wider_by_model),
    "intervals.wider_by_correlation": (9, _wider_by_correlation),
    "readings.clipped": (9, _clipped),
    "coverage.one_pressure": (1, _one_pressure),
    "coverage.no_resistance": (7, _no_resistance),
    "coverage.no_collapse": (6, _no_collapse),
    "coverage.tuning_range": (9, _tuning_range),
    "constants.limited": (6, _limited),
    "constants.undetermined": (5, _undetermined),
    "constants.law_in_doubt": (3, _law_in_doubt),
    "constants.confounded": (9, _confounded),
    "constants.correlated": (4, _correlated),
    "constants.sparse_transition": (6, _sparse_transition),
    "curves.unread": (8, _unread),
    "curves.misfit": (8, _misfit),
    "use.no_loop": (7, _no_loop),
    "use.fitted_length": (9, _fitted_length),
    "use.other_size": (2, _other_size),
}  # fmt: skip
