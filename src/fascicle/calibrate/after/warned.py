"""What the data could not tell, in words: a calibration's warnings."""

from typing import TYPE_CHECKING

import numpy as np

from ...units import pretty
from ..problem.solving import CONVERGED


if TYPE_CHECKING:
    from .calibration import Calibration

_TIED = 0.95  # correlation from which two parameters are told apart no longer
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_WIDER = 1.05  # from here on an interval is called wider
_FEWEST = 3  # pressures, for residuals to go with them
_CLEAR = 4.0  # deviations of a reading, from which a difference of two is told
_TOLD = 3  # strains at which residuals' signs are told
_CALIPERS = 0.1  # of a size: more than that nobody errs who measures it
_TINY = 1e-12  # a chance below that is none: nobody's noise is so normal
_NOTHING_PAST = ", so nothing past the free strain was measured there"
_AFTER = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")


def warned(made: "Calibration") -> dict[str, tuple[str, ...]]:
    """Lines to read before the fitted muscle of `made` [-] is used, by what they are about [-]."""
    found = {
        "what is left of the readings": [*_search(made), *_noise(made)],
        "what was not measured": _reach(made),
        "what these readings can't tell": [*_parameters(made), *_dense(made), *_curves(made)],
        "where it is used": _use(made),
    }
    return {about: tuple(lines) for about, lines in found.items() if lines}


def _search(made: "Calibration") -> list[str]:
    status = np.asarray(made.solutions.status)
    if status[made.solutions.best] != CONVERGED:
        return [f"The search {made.status}: take the result with caution, or give more starts."]
    return []


def _reach(made: "Calibration") -> list[str]:
    """What part of the law the data cover."""
    lines, used = [], np.asarray(made.problem.data.uncensored)
    strain = made.conclusion.linear.strain[: len(made.free_strain)]
    past = used[: len(strain)] & (strain > made.free_strain[:, None] + 1e-9)
    if made.censored:
        lines.append(
            f"{made.censored} readings are clipped at {made.floor}: they only say that the force"
            f" was not above it{_NOTHING_PAST if made.floor == 'zero' else ''}."
        )
    levels = used.any(axis=1)
    if np.sum(levels) == 1:
        only = float(np.asarray(made.problem.data.pressure)[levels][0, 0])
        lines.append(
            f"Measured at {pretty(only, 'pressure')} only: how force goes with pressure is the"
            " law's word, not the data's."
        )
    names = _named(made, _AFTER)
    if made.taken.pulls or not np.any(past):
        lines.append(
            "Nothing past the free strain was measured: the data say nothing of bending, collapse"
            " and the hinge."
        )
    elif names and not np.any(_moved(made, names)):
        lines.append(
            f"No reading lies past a collapse: {_list(names)} can't be determined and"
            f" {'stay' if len(names) > 1 else 'stays'} at the prior."
        )
    if made.readings is not None and np.size(made.muscle.tuning.pressures) > 1:
        highest = float(np.max(np.asarray(made.muscle.tuning.pressures)))
        lines.append(
            f"C1 and C2 are read up to {highest / 1e3:.4g} kPa and held constant above it."
        )
    return lines


def _moved(made: "Calibration", names: list[str]) -> np.ndarray:
    """Which of the fitted readings these parameters move at all."""
    places = [made.problem.chosen[made.names.index(name)] for name in names]
    rows = made.conclusion.linear.slopes[: np.size(made.problem.data.count)]
    return np.any(rows[:, places] != 0, axis=1)


def _parameters(made: "Calibration") -> list[str]:
    lines = []
    found = made.parameters
    lost = [one.name for one in found if not one.identifiable and not one.bound]
    for one in found:
        if one.bound:
            end = one.high if one.bound == "upper" else one.low
            lines.append(
                f"The data give {one.name} only {'an' if one.bound == 'upper' else 'a'}"
                f" {one.bound} limit, {pretty(end, one.dimension, 3)} (90 %)."
            )
    if lost:
        lines.append(
            f"The data alone do not determine {_list(lost)}: what stands there is mostly its prior."
        )
    if made.untold:
        lines.append(
            "Not fitted, and not to be told from these data beside what was:"
            f" {_list([*made.untold])} {'stay' if len(made.untold) > 1 else 'stays'} as given."
        )
    known = [one.identifiable for one in found]
    for i in range(len(found)):
        for j in range(i):
            r = made.correlation[i, j]
            if abs(r) > _TIED and known[i] and known[j]:
                lines.append(
                    f"{found[j].name} and {found[i].name} are known together, not apart"
                    f" (correlation {r:.3f}): don't read one without the other."
                )
    return lines


def _dense(made: "Calibration") -> list[str]:
    """Whether sweeps are dense enough to see the transition after collapse."""
    rate = next((one for one in made.parameters if one.name == "transition_rate"), None)
    if rate is None or not rate.identifiable:
        return []
    used = np.asarray(made.problem.data.uncensored)
    strain = np.where(used, made.conclusion.linear.strain, np.nan)[np.any(used, axis=1)]
    spacing = (np.nanmax(strain, axis=1) - np.nanmin(strain, axis=1)) / np.sum(
        np.isfinite(strain), axis=1
    )
    within = 1 / (rate.value * float(np.median(spacing)))
    if within >= _DENSE:
        return []
    return [
        f"Only {within:.2g} readings at a pressure fall into the transition after collapse (1/β of"
        f" strain): below {_DENSE} the collapse moment's interval comes out too narrow."
    ]


def _curves(made: "Calibration") -> list[str]:
    if made.readings is None:
        return []
    lines = []
    used = np.any(np.asarray(made.problem.data.count) > 0, axis=1)  # not what only fills the table
    valid, P = np.asarray(made.readings.valid)[used], np.asarray(made.readings.pressure)[used]
    unread = P[~valid & (0.01 * P.max() < P)]
    if unread.size:
        lines.append(
            "Blocked force and free strain could not be read at"
            f" {', '.join(f'{p / 1e3:.4g}' for p in unread)} kPa: too few readings pull there."
        )
    what = ("free strain is no polynomial of order 3 or less times the law's",
            "blocked force is not linear in pressure")  # fmt: skip
    for misfit, words in zip(np.asarray(made.readings.misfit), what, strict=True):
        if misfit > 1:
            lines.append(
                f"The {words} within its readings' errors ({np.sqrt(misfit):.3g} times them): the"
                " smooth curve misses some of them, and its uncertainty is widened."
            )
    return lines


def _noise(made: "Calibration") -> list[str]:
    """Whether residuals are noise, and what else they are."""
    seen = made.seen
    lines = [
        f"Residuals follow {trend.along}: a smooth curve along it explains"
        f" {100 * trend.share:.3g} % of their squares (chance of that in noise:"
        f" {_chance(trend.chance)}). That is the model's own error, or the gauge's, not noise."
        for trend in seen.found
    ]
    lines += [
        f"Neighboring residuals along {one.along} change sign {one.changes} times in"
        f" {one.pairs}, where noise would in half of them: they follow something."
        for one in seen.wandering
    ]
    if seen.signs and not seen.noisy:
        told = [
            f"{max(one.below, one.count - one.below)} of {one.count} lie"
            f" {'below' if 2 * one.below > one.count else 'above'} the fit near strain"
            f" {one.strain:.3g}"
            for one in seen.signs[:_TOLD]
        ]
        lines.append(f"Of the readings {_list(told)}.")
    if not seen.noisy:
        lines += [*_at_rest(made), *_causes(made)]
    if seen.found and made.parameters:
        wide = made.wider
        so = "hardly wider than"
        if np.max(wide) >= _WIDER:
            so = f"{_range(wide)} times as wide as"
        lines.append(
            "Intervals count a discrepancy for it, an error of the model that goes smoothly along"
            f" {_list([one.along for one in seen.found])} and is as large where the fit took it up"
            f" as where it shows: they are {so} noise alone makes them."
        )
    if made.inflation > 1 and made.parameters:
        lines.append(
            "Residuals follow one another along a sweep, more than noise does: intervals are"
            f" widened by {np.sqrt(made.inflation):.3g} for it."
        )
    if not np.isfinite(seen.noise):
        lines.append(
            "Too few readings are left beside the constants to tell whether residuals are noise."
        )
    return lines


def _at_rest(made: "Calibration") -> list[str]:
    """How residuals at the least strain go with pressure, where it is more than noise: ends and a
    dead band show there.
    """
    seen = made.seen
    if len(seen.rest) < _FEWEST or not np.isfinite(seen.noise):
        return []
    P, missed = np.array(seen.rest).T
    if np.ptp(missed) < _CLEAR * seen.noise:
        return []
    low, high = sorted((int(np.argmin(missed)), int(np.argmax(missed))))
    return [
        f"At the least strain they run from {missed[low]:+.3g} N at {P[low] / 1e3:.4g} kPa to"
        f" {missed[high]:+.3g} N at {P[high] / 1e3:.4g} kPa."
    ]


def _causes(made: "Calibration") -> list[str]:
    if not made.causes:
        return ["None of the causes that are looked for here would explain much of it."]
    told = [f"{one.name} (would explain {100 * one.share:.3g} %)" for one in made.causes]
    return [f"Most like it: {'; or '.join(told)}. What to do: {made.causes[0].remedy}."]


def _use(made: "Calibration") -> list[str]:
    """What its figures don't hold, or hold besides the model."""
    lines = []
    if made.loop is None:
        lines.append(
            "Measured one way, or the way isn't told: friction's hysteresis loop is not in these"
            " errors, and a muscle in use has one."
        )
    if "active_length" in made.names:
        length = float(made.muscle.length)
        lines.append(
            f"The fitted muscle is {pretty(length, 'length')} long: its contractions refer to that,"
            f" the record's to {_rest(made)}."
        )
    return lines + _sizes(made)


def _sizes(made: "Calibration") -> list[str]:
    """Sizes that were fitted, and aren't those that were measured: they make up for something."""
    given, lines = made.start, []
    rest = made.record.rest_length or float(given.length)
    for one in made.parameters:
        # an active length may be shorter than what lies between the fittings, never longer
        real = {"active_length": rest}.get(one.name, getattr(given, one.name, None))
        if real is None or not one.identifiable or one.dimension not in ("length", "angle"):
            continue
        longer, shorter = one.low > (1 + _CALIPERS) * real, one.high < (1 - _CALIPERS) * real
        if longer or (shorter and one.name != "active_length"):
            value, known = (pretty(x, one.dimension, 3) for x in (one.value, float(real)))
            lines.append(
                f"{one.name} is {value}, given as {known}, its whole interval more than"
                f" {100 * _CALIPERS:g} % off: it makes up for what the law lacks, and is no"
                " measured size."
            )
    return lines


def _chance(chance: float) -> str:
    """A chance in words that claim no more than is computed."""
    return f"{chance:.1g}" if chance > _TINY else f"below {_TINY:.0g}"


def hysteresis(made: "Calibration") -> str:
    """How wide the record's loops are, and what that is of the muscle's error in use; nothing where
    the record doesn't hold both ways [-].
    """
    loop = made.loop
    if loop is None:
        return ""
    if made.friction is not None and made.friction.law is None:
        return (
            "No hysteresis loop stands out of the noise: mean width"
            f" {float(np.mean(loop.width)):.2g} N at {loop.pressure.size}"
            f" pressure{'s' * (loop.pressure.size > 1)}."
        )
    where = f"at {loop.pressure.size} pressures" if loop.pressure.size > 1 else "there"
    return (
        f"Hysteresis loop {_range(100 * loop.share)} % of the pull at a pressure wide,"
        f" {_range(loop.width)} N {where}: half of it is in the error of a muscle in use,"
        f" {made.rmse:.4g} N; from the half-way curve it errs by {made.half_way_rmse:.4g} N."
        f"{'' if made.friction is None else f' {made.friction.words()}'}"
    )


def _rest(made: "Calibration") -> str:
    rest = made.record.rest_length
    return "the length it began with" if rest is None else pretty(rest, "length")


def _range(values: np.ndarray) -> str:
    low, high = f"{float(np.min(values)):.2g}", f"{float(np.max(values)):.2g}"
    return low if low == high else f"{low} to {high}"


def _named(made: "Calibration", names: tuple[str, ...]) -> list[str]:
    return [name for name in made.names if name in names]


def _list(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
