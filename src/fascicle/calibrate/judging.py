"""What the data could not tell, in words: a calibration's warnings."""

from typing import TYPE_CHECKING

import numpy as np

from .solving import CONVERGED


if TYPE_CHECKING:
    from .calibration import Calibration

_TIED = 0.95  # correlation from which two parameters are told apart no longer
_DENSE = 10  # readings in the transition, as `benchmarks/recovery.py` shows
_AFTER = ("hinge_stiffness_factor", "hinge_stiffness_slope", "transition_rate")


def remarks(made: "Calibration") -> list[str]:
    """Lines [-] to read before the fitted muscle of `made` [-] is used."""
    return [
        *_search(made), *_reach(made), *_parameters(made), *_dense(made), *_curves(made),
        *_scatter(made),
    ]  # fmt: skip


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
            f"{made.censored} readings are clipped at zero: they only say that the force was not"
            " above it, so nothing past the free strain was measured there."
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
    lost = [one.name for one in found if not one.identifiable]
    if lost:
        lines.append(
            f"The data alone do not determine {_list(lost)}: what stands there is mostly its prior."
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
    valid, P = np.asarray(made.readings.valid), np.asarray(made.readings.pressure)
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


def _scatter(made: "Calibration") -> list[str]:
    if made.inflation <= 1:
        return []
    return [
        "Residuals follow one another along a sweep: what is left is the model's or the gauge's"
        f" own error, not noise. Intervals are widened by {np.sqrt(made.inflation):.3g}."
    ]


def _named(made: "Calibration", names: tuple[str, ...]) -> list[str]:
    return [name for name in made.names if name in names]


def _list(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
