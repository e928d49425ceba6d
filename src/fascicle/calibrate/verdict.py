"""Verdict on a calibration: does it fit, how far is it off, what is unknown, and what to do.

A notice says what is wrong and what to do about it. All notices are the warnings of a calibration;
the most important ones end the verdict.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..units import pretty
from .calibration import Calibration, Estimate, Selection, largest_force
from .gauges import DIMENSIONS as GAUGE_DIMENSIONS
from .gauges import PERFECT
from .messages import interval_texts, list_text, range_text
from .parameters import FACTOR_NAMES


# of the largest force: the errors of a good bench, and those that friction of the braid causes
_WELL, _ROUGHLY = 0.02, 0.05
_OVERFIT = 1.5  # of the error of the fit: a larger error at readings left out shows an overfit
_ACTIONS = 2  # in a verdict: more are not done
_TIED = 0.95  # correlation from which two parameters can't be interpreted one by one
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_WIDER = 1.05  # ratio of widths: a smaller change is not visible in two digits
_MIN_LEVELS = 3  # pressures: fewer show no dependence on pressure
_CLEAR = 4.0  # standard deviations of a reading, from which two of them differ
_SIZE = 2  # rank of a size that the muscle does not have
_MAX_SIGNS = 3  # strains in a sentence that is still read
_SIZES = ("length", "angle")  # dimensions of sizes
_CALIPERS = 0.1  # of a size: an error that no measurement with calipers makes
_AFTER_COLLAPSE = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")
GAUGES, RESIDUALS, NOT_MEASURED, UNKNOWN, IN_USE = (
    "gauges", "residuals", "not measured", "not determined by these data", "use of the muscle",
)  # fmt: skip
_GAUGE = "with a gauge that measures pushes"
_TESTS: dict[str, str] = dict.fromkeys(("c10", "c01"), " in a tensile test of the rubber")
_GAUGE_ERRORS = {
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
FITS = {
    "not converged": "the search did not converge: do not use these constants",
    "untested": "too few readings to judge the fit",
    "noise": "good fit: the residuals look like noise",
    "other sizes": "good fit, but only with sizes that are not this muscle's",
    "well": "good fit: the errors are small but systematic",
    "roughly": "rough fit: errors of {}",
    "poorly": "bad fit: errors of {}; a law, a size or a gauge is wrong",
}  # of a verdict, with the size of the errors


@dataclass(frozen=True)
class Verdict:
    """Verdict on a calibration.

    - `fit`: one of `FITS`.
    - `rmse`, `relative_rmse`: root mean square error [N], and over the largest force [-].
    - `pulling_rmse`, `resisting_rmse`: below and past the free strain [N]; NaN without readings.
    - `torque_rmse`: of the joint's torque [N·m]; NaN without moment arms.
    - `left_out_rmse`: at readings left out of the fit, over the largest force [-]; NaN if unknown.
    - `undetermined`, `limits`: constants that the data do not determine, and those with one limit.
    - `actions`: what to do next, the most important first.
    """

    fit: str
    rmse: float
    relative_rmse: float
    pulling_rmse: float
    resisting_rmse: float
    torque_rmse: float
    left_out_rmse: float
    undetermined: tuple[str, ...]
    limits: tuple[str, ...]
    actions: tuple[str, ...]


def judge(calibration: Calibration, selection: Selection | None = None) -> Verdict:
    """Verdict: one word of `FITS`, errors, undetermined constants and next actions; the
    `selection`, if any, gives the error at left-out readings.

    The size of the errors comes first: a fit is good only if they are small.
    """
    diagnosis = calibration.diagnosis
    chosen = [c for c in selection.candidates if c.chosen] if selection else []
    left_out = chosen[-1].relative_left_out_rmse if chosen else float("nan")
    relative, errors = calibration.relative_rmse, calibration.errors
    worst = float(np.fmax(relative, left_out))  # one of them may be NaN
    ranked = sorted(notices(calibration), key=lambda notice: notice.rank)
    if calibration.solutions.status[calibration.solutions.best]:
        fit = "not converged"
    elif worst > _ROUGHLY:
        fit = "poorly"
    elif not np.isfinite(diagnosis.noise) and calibration.parameters:
        fit = "untested"
    elif worst > _WELL:
        fit = "roughly"
    elif any(notice.rank == _SIZE for notice in ranked):
        fit = "other sizes"
    else:
        overfits = left_out > _OVERFIT * relative
        fit = "noise" if diagnosis.is_white_noise and not overfits else "well"
    strain = calibration.record.strain * calibration.strain_scale
    past = strain > calibration.free_strain[calibration.fit_data.level]
    past &= not calibration.fit_data.pulls
    parts = [errors[mask & np.isfinite(errors)] for mask in (~past, past)]
    pulling, resisting = (
        float(np.sqrt(np.mean(group**2))) if group.size else float("nan") for group in parts
    )
    undetermined = tuple(e.name for e in calibration.parameters if not (e.identifiable or e.bound))
    limits = tuple(e.name for e in calibration.parameters if e.bound)
    actions = tuple(notice.action for notice in ranked if notice.action)[:_ACTIONS]
    return Verdict(
        fit, calibration.rmse, relative, pulling, resisting, calibration.torque_rmse, left_out,
        undetermined, limits, actions,
    )  # fmt: skip


def verdict_lines(calibration: Calibration, verdict: Verdict) -> tuple[list[str], list[str]]:
    """Lines of a verdict before and after the table of constants."""
    record, diagnosis = calibration.record, calibration.diagnosis
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
    shares = verdict.relative_rmse, float(np.fmax(verdict.relative_rmse, verdict.left_out_rmse))
    fitted, worst = (f"{100 * share:.2g} % of the largest force" for share in shares)
    size = worst if worst == fitted else f"{worst} at readings left out of the fit"
    judgment = f"Verdict: {FITS[verdict.fit].format(size)}."
    if not diagnosis.is_white_noise:
        tests = (*diagnosis.significant, *diagnosis.autocorrelated)
        along = [word for test in tests for word in test.along.split(" and ")]
        cause = "The cause is unknown."
        if causes := diagnosis.causes:
            share = f"{100 * causes[0].share:.2g} % of the squared residuals"
            plural = "s" * (len(causes) > 1)
            alternatives = "; or ".join(cause.name for cause in causes)
            cause = f"Likely cause{plural} ({share}): {alternatives}."
        names = list_text(list(dict.fromkeys(along)))
        judgment += f" The residuals vary with {names}. {cause}"
    elif verdict.fit in ("roughly", "poorly"):
        judgment += " The residuals look like noise."
    gaps = [
        f"{name} ({interval})"
        for name, _, interval in constant_rows(calibration.parameters)
        if name in verdict.limits
    ]
    if not np.isfinite(verdict.resisting_rmse):
        gaps.append("forces past the free strain (not measured)")
    gaps = [*verdict.undetermined, *gaps]
    unknown = [f"Unknown: {', '.join(gaps)}."] * bool(gaps)
    actions = [f"To do {i}: {action}." for i, action in enumerate(verdict.actions, start=1)]
    return [judgment, f"{error}."], [*unknown, *actions]


def constant_rows(estimates: tuple[Estimate, ...]) -> list[tuple[str, str, str]]:
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


class Notice(NamedTuple):
    """Warning about a calibration, by `topic`: its `text`, and the `action` to take, if any.

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


def calibration_warnings(calibration: Calibration) -> dict[str, tuple[str, ...]]:
    """Warnings to read before the fitted muscle is used, by topic."""
    topics: dict[str, tuple[str, ...]] = {}
    for notice in notices(calibration):
        topics[notice.topic] = (*topics.get(notice.topic, ()), notice.line)
    return topics


def notices(calibration: Calibration) -> list[Notice]:
    """Warnings about a calibration, topic by topic."""
    kinds = (
        _gauge_notices,
        _residual_notices,
        _coverage_notices,
        _parameter_notices,
        _usage_notices,
    )
    return [notice for kind in kinds for notice in sorted(kind(calibration), key=lambda n: n.rank)]


def gauge_errors(calibration: Calibration) -> dict[str, str]:
    """Errors of the gauges that the readings were corrected for, with intervals, by name."""
    fitted, texts = {estimate.name: estimate for estimate in calibration.parameters}, {}
    for name, value in calibration.gauge.faults.items():
        dimension = GAUGE_DIMENSIONS[name]
        interval = ""
        if name in fitted:
            ends = fitted[name].low, fitted[name].high
            low, high = (pretty(x, dimension, 3) for x in ends)
            interval = f", 90 % interval {low} to {high}"
            if ends[0] <= getattr(PERFECT, name) <= ends[1]:
                interval += ": perhaps no error"
        texts[name] = f"{_GAUGE_ERRORS[name][0]} ({pretty(value, dimension, 3)}{interval})"
    return texts


def _gauge_notices(calibration: Calibration) -> Iterator[Notice]:
    """Errors of the gauges, and faults of the channels."""
    for name, text in gauge_errors(calibration).items():
        line = f"{text}: the readings are corrected for it."
        yield Notice(GAUGES, 4, line, f"{_GAUGE_ERRORS[name][1]} before the next record")
    for fault in calibration.fit_data.faults:
        value = pretty(fault.value, _CHANNELS[fault.channel], 3)
        texts = {
            "ceiling": (f"{fault.count} forces are exactly {value}, the load cell's ceiling: they"
                        " only say that the force was not below it.",
                        "use a load cell of a larger range"),
            "saturation": (f"{fault.count} readings of the {fault.channel} are exactly {value}, the"
                           " largest: the channel may be saturated.",
                           f"check the range of the {fault.channel}"),
        }  # fmt: skip
        if fault.kind in texts:  # a floor is among the readings that are clipped
            yield Notice(GAUGES, 5, *texts[fault.kind])


def _residual_notices(calibration: Calibration) -> Iterator[Notice]:
    """Failed search, trends and runs of the residuals, their causes, and wider intervals."""
    diagnosis, solutions = calibration.diagnosis, calibration.solutions
    if solutions.status[solutions.best]:
        text = f"The search {calibration.status}."
        yield Notice(RESIDUALS, 0, text, "search from more starts, --starts 16")
    if not np.isfinite(diagnosis.noise):
        text = "Too few readings for the number of constants: residuals can't be tested."
        yield Notice(RESIDUALS, 1, text, "take more readings, or fit fewer constants")
    elif diagnosis.is_white_noise and calibration.relative_rmse > _WELL:
        text = (
            f"Errors of {100 * calibration.relative_rmse:.2g} % of the largest force without a"
            " pattern: the noise of a gauge, or a column that is not what it was read as."
        )
        action = "check the columns of pressure, force and length, and the noise of their gauges"
        yield Notice(RESIDUALS, 1, text, action)
    if not diagnosis.is_white_noise:
        pieces = []
        if diagnosis.significant:
            trends = [f"{t.along} ({100 * t.share:.2g} %)" for t in diagnosis.significant]
            pieces.append(
                f"Residuals vary with {list_text(trends)}, in brackets the share of the squared"
                " residuals: an error of the model or of the gauge, not noise."
            )
        if diagnosis.autocorrelated:
            runs = [f"{run.along} ({run.changes} of {run.pairs} pairs change sign)"
                    for run in diagnosis.autocorrelated]  # fmt: skip
            pieces.append(f"Neighboring residuals are correlated along {list_text(runs)}.")
        causes = diagnosis.causes
        names = [f"{cause.name} (would explain {100 * cause.share:.2g} %)" for cause in causes]
        pieces.append(
            f"Likely cause: {'; or '.join(names)}." if names else "No known cause would explain it."
        )
        # the data can't distinguish causes of about one share
        action = "; or ".join(dict.fromkeys(cause.remedy for cause in causes))
        action = action or "look for a pattern in the report's residuals"
        yield Notice(RESIDUALS, 3, " ".join(pieces), action)
        yield from (Notice(RESIDUALS, 9, line) for line in _pattern_lines(calibration))
    wider = []
    if diagnosis.significant and calibration.parameters and np.max(calibration.wider) >= _WIDER:
        wider.append(f"{range_text(calibration.wider)} times, by the error of the model")
    if diagnosis.inflation > 1 and calibration.parameters:
        wider.append(f"{np.sqrt(diagnosis.inflation):.2g} times, by correlated residuals")
    if wider:
        text = f"Intervals are wider than from noise alone, {list_text(wider)}."
        yield Notice(RESIDUALS, 9, text)


def _pattern_lines(calibration: Calibration) -> Iterator[str]:
    """Signs of the residuals, and their change with pressure at the least strain."""
    diagnosis = calibration.diagnosis
    counts = [
        f"{max(entry.below, entry.count - entry.below)} of {entry.count} readings lie"
        f" {'below' if 2 * entry.below > entry.count else 'above'} the fit near strain"
        f" {entry.strain:.3g}"
        for entry in diagnosis.signs[:_MAX_SIGNS]
    ]
    if counts:
        yield f"{list_text(counts)}."
    if len(diagnosis.lowest_strain_means) >= _MIN_LEVELS and np.isfinite(diagnosis.noise):
        # end effects and a dead band show here
        P, means = np.array(diagnosis.lowest_strain_means).T
        low, high = sorted((int(np.argmin(means)), int(np.argmax(means))))
        if np.ptp(means) >= _CLEAR * diagnosis.noise:
            yield (
                f"At the least strain residuals range from {means[low]:+.3g} N at"
                f" {P[low] / 1e3:.4g} kPa to {means[high]:+.3g} N at {P[high] / 1e3:.4g} kPa."
            )


def _coverage_notices(calibration: Calibration) -> Iterator[Notice]:
    """Parts of the law that the data do not cover."""
    grid = calibration.grid
    strain = calibration.problem.strain(calibration.muscle)
    # a reading at the free strain itself may lie past it by rounding
    past = grid.measured & (strain > calibration.free_strain[:, None] + 1e-9)
    if clipped := calibration.fit_data.clipped:
        text = (
            f"{clipped} readings are clipped at {calibration.floor}: they only say that the force"
            " was not above it."
        )
        yield Notice(NOT_MEASURED, 9, text)
    levels = grid.measured.any(axis=1)
    if np.sum(levels) == 1:
        pressure = pretty(float(grid.pressure[levels][0, 0]), "pressure")
        text = f"Data at one pressure only ({pressure}): the dependence on pressure is the law's."
        yield Notice(NOT_MEASURED, 1, text, "measure at three pressures or more")
    names = [name for name in calibration.names if name in _AFTER_COLLAPSE]
    if calibration.fit_data.pulls or not np.any(past):
        text = (
            "Nothing past the free strain was measured: the data contain no information on"
            " bending, collapse and the hinge."
        )
        action = f"if pushes matter, compress the muscle past its free strain, {_GAUGE}"
        yield Notice(NOT_MEASURED, 7, text, action)
    elif names:
        columns = [calibration.names.index(name) for name in names]
        if not np.any(calibration.minimum.linear.slopes[: strain.size, columns]):
            text = f"No reading lies past a collapse: {list_text(names)} can't be determined."
            yield Notice(NOT_MEASURED, 6, text, "compress the muscle until it folds")
    if calibration.readings is not None and calibration.muscle.tuning.pressures.size > 1:
        highest = pretty(float(np.max(calibration.muscle.tuning.pressures)), "pressure")
        text = f"C1 and C2 are determined up to {highest} and held constant above it."
        yield Notice(NOT_MEASURED, 9, text)


def _parameter_notices(calibration: Calibration) -> Iterator[Notice]:
    """Parameters that the data do not determine."""
    estimates = calibration.parameters
    limits = [
        f"{e.name} only {'an' if e.bound == 'upper' else 'a'} {e.bound} limit,"
        f" {pretty(e.high if e.bound == 'upper' else e.low, e.dimension, 3)} (90 %)"
        for e in estimates
        if e.bound
    ]
    if limits:
        bounded = [e.name for e in estimates if e.bound]
        yield Notice(UNKNOWN, 6, f"The data give {list_text(limits)}.", _remedy(bounded))
    names = [e.name for e in estimates if not e.identifiable and not e.bound]
    if names:
        verb, prior = ("are", "their priors") if len(names) > 1 else ("is", "its prior")
        text = f"{list_text(names)} {verb} not determined by the data: the fit returns {prior}."
        yield Notice(UNKNOWN, 5, text, _remedy(names))
    if confounded := list(calibration.diagnosis.confounded):
        pronoun = "them" if len(confounded) > 1 else "it"
        text = (
            f"Not fitted: {list_text(confounded)}. The data can't distinguish {pronoun} from the"
            " fitted constants."
        )
        yield Notice(UNKNOWN, 9, text)
    tied = sorted(
        (
            (abs(calibration.correlation[i, j]), previous, estimate)
            for i, estimate in enumerate(estimates)
            for j, previous in enumerate(estimates[:i])
            if estimate.identifiable and previous.identifiable
        ),
        key=lambda pair: -pair[0],
    )
    tied = [pair for pair in tied if pair[0] > _TIED]
    if tied:
        pairs = [f"{first.name} and {second.name} ({r:.3f})" for r, first, second in tied]
        text = f"Strongly correlated: {'; '.join(pairs)}. Do not interpret them individually."
        _, *constants = tied[0]
        size = next((e.name for e in constants[::-1] if e.dimension in _SIZES), "")
        name = size or constants[1].name
        yield Notice(UNKNOWN, 4, text, _remedy([name]) or f"leave {name} out of --fit")
    rate = next((e for e in estimates if e.name == "transition_rate" and e.identifiable), None)
    if rate is not None:
        used = calibration.grid.measured
        strain = np.where(used, calibration.problem.strain(calibration.muscle), np.nan)
        strain = strain[np.any(used, axis=1)]
        spacing = np.nanmax(strain, axis=1) - np.nanmin(strain, axis=1)
        spacing = float(np.median(spacing / np.sum(np.isfinite(strain), axis=1)))
        count = 1 / (rate.value * spacing)
        if count < _DENSE:
            text = (
                f"Only {count:.2g} readings at a pressure lie in the transition after collapse"
                f" (1/β of strain): with fewer than {_DENSE} the collapse moment's interval is too"
                " narrow."
            )
            yield Notice(UNKNOWN, 6, text, "take more readings near the collapse")
    yield from _curve_notices(calibration)


def _curve_notices(calibration: Calibration) -> Iterator[Notice]:
    """Blocked forces and free strains of a tuning that could not be read, or miss their curve."""
    readings = calibration.readings
    if readings is None:
        return
    P = readings.pressure
    if (missing := P[~readings.valid & (0.01 * P.max() < P)]).size:
        pressures = ", ".join(f"{p / 1e3:.4g}" for p in missing)
        text = (
            f"Blocked force and free strain could not be read at {pressures} kPa: too few"
            " readings pull there."
        )
        yield Notice(UNKNOWN, 8, text, "measure more strains at these pressures")
    shapes = ("The free strain over the law's is no polynomial of order 3 or less",
              "The blocked force is not linear in pressure")  # fmt: skip
    for misfit, shape in zip(readings.misfit, shapes, strict=True):
        if misfit > 1:
            text = (
                f"{shape} within the errors of its readings ({np.sqrt(misfit):.3g} times them):"
                " the smooth curve misses some of them, and its uncertainty is increased."
            )
            yield Notice(UNKNOWN, 8, text)


def _remedy(names: Sequence[str]) -> str:
    """Action for constants that the data do not determine."""
    name = names[0]
    if name in FACTOR_NAMES:
        return f"to determine {name}, take more readings near and past the collapse, {_GAUGE}"
    if name in GAUGE_DIMENSIONS:
        return "read the gauges without pressure at the rest length, first and last"
    if name == "dead_band":  # nothing else measures it
        return ""
    test = _TESTS.get(name, "")
    return f"measure {name}{test} and give it as the prior {name}=VALUE,DEVIATION"


def _usage_notices(calibration: Calibration) -> Iterator[Notice]:
    """Notices of what differs in use: a loop of friction that was not measured, strains that refer
    to a fitted length, and fitted sizes that contradict the given ones.
    """
    muscle, rest_length = calibration.start, calibration.record.rest_length
    if calibration.loop is None:
        text = (
            "Measured in one direction, or in an unknown one: a muscle in use has a hysteresis loop"
            " of friction, which these errors do not contain."
        )
        action = "measure each pressure while the muscle shortens and while it lengthens"
        yield Notice(IN_USE, 7, text, action)
    if "active_length" in calibration.names:
        reference = "the initial length" if rest_length is None else pretty(rest_length, "length")
        length = pretty(float(calibration.muscle.length), "length")
        text = (
            f"The fitted muscle is {length} long: its contractions refer to that length, those of"
            f" the record to {reference}."
        )
        yield Notice(IN_USE, 9, text)
    for estimate in calibration.parameters:
        size, name = getattr(muscle, estimate.name, None), estimate.name
        if name == "active_length":
            size = rest_length or float(muscle.length)
        if size is None or not estimate.identifiable or estimate.dimension not in _SIZES:
            continue
        larger = estimate.low > (1 + _CALIPERS) * size
        smaller = estimate.high < (1 - _CALIPERS) * size
        # an active length may be shorter than the distance of the fittings, never longer
        if larger or (smaller and name != "active_length"):
            value, nominal = (
                pretty(x, estimate.dimension, 3) for x in (estimate.value, float(size))
            )
            text = (
                f"{name} is {value}, given as {nominal}, and its whole interval is more than"
                f" {100 * _CALIPERS:g} % off: it compensates for an error of the law or of the"
                " gauge and is no measured size."
            )
            action = f"check the muscle's {name}: fitted {value}, given {nominal}"
            yield Notice(IN_USE, _SIZE, text, action)
