"""A calibrated muscle's numbers, rounded to what its data know: `27.8 deg`, not sixteen digits.

As few digits are kept as leave each fitted constant within `SHARE` of the width of its interval,
and each reading's force within `SHARE` of the root mean square of what the fit leaves over. What
wasn't fitted, and stood in the muscle that the fit began with, is left as it was given.
"""

import warnings
from collections.abc import Iterable

import numpy as np

from ..calibrate.after.calibration import Calibration
from ..calibrate.problem.parameters import of_muscle
from ..core.module import tree_leaves, tree_replace
from ..core.validation import HIGHEST_PRESSURE
from ..muscle import Muscle
from ..muscle.fitted_length import copy_fit_info
from ..units import DIMENSIONS, exact, parse, pretty


SHARE = 0.01  # of an interval, and of what is left over: far below what anyone can tell
_FEWEST, _MOST = 3, 17  # digits; with 17 every float is itself


def told(value: float, dimension: str, width: float) -> str:
    """A fitted `value` [SI] and its unit with as few digits as keep it within `SHARE` of its
    interval's `width` [SI], at least three.
    """
    for digits in range(_FEWEST, _MOST):
        text = pretty(value, dimension, digits)
        if abs(parse(text, dimension) - value) <= SHARE * width:
            return text
    return exact(value, dimension)


def as_known(made: Calibration) -> tuple[Muscle, str]:
    """The fitted muscle as its file has it.

    **Arguments:** `made`: the calibration [-].

    **Returns:** the muscle, and how far it was rounded, in words [-].
    """
    given = set(_numbers(made.start))
    for digits in range(_FEWEST, _MOST):
        rounded = _rounded(made.muscle, given, digits)
        moved = _moved(made, rounded)
        if moved is not None:
            return copy_fit_info(made.muscle, rounded), (
                f"to {digits} digits: no fitted constant is off by more than {SHARE:.0%} of its"
                f" interval, no reading's force by more than {pretty(moved, 'force', 2)}"
            )
    return made.muscle, "not rounded"


def _moved(made: Calibration, rounded: Muscle) -> float | None:
    """By how much a reading's force moves [N]; `None` where that, or a constant, is too much."""
    known = of_muscle(made.muscle)
    for one in made.parameters:
        off = abs(float(known[one.name].value(rounded)) - float(known[one.name].value(made.muscle)))
        if not off <= SHARE * (one.high - one.low):
            return None
    pressure = np.clip(made.record.pressure, 0.0, HIGHEST_PRESSURE)
    with warnings.catch_warnings():  # a level's pressure is its mean: readings lie above the last
        warnings.simplefilter("ignore")
        forces = [np.asarray(m.force(pressure, made.record.strain)) for m in (rounded, made.muscle)]
    off = float(np.max(np.abs(forces[0] - forces[1])))
    return off if off <= SHARE * made.rmse else None


def _rounded(muscle: Muscle, given: set[float], digits: int) -> Muscle:
    leaves = tree_leaves(muscle)
    shorter = [_shorter(leaf, given, digits) for leaf in leaves]
    found: Muscle = tree_replace(muscle, shorter)
    angle = float(muscle.braid_angle)
    if angle in given:
        return found
    # in degrees, as it is written
    degrees = angle / float(DIMENSIONS["angle"].factors["deg"])
    return found.replace(braid_angle=parse(f"{degrees:.{digits}g} deg", "angle"))


def _shorter(leaf: object, given: set[float], digits: int) -> object:
    values = np.asarray(leaf)
    if values.dtype.kind != "f":
        return leaf
    short = [x if x in given else float(f"{x:.{digits}g}") for x in values.ravel().tolist()]
    return values.dtype.type(short[0]) if values.ndim == 0 else np.reshape(short, values.shape)


def _numbers(muscle: Muscle) -> Iterable[float]:
    for leaf in tree_leaves(muscle):
        if np.asarray(leaf).dtype.kind == "f":
            yield from np.asarray(leaf).ravel().tolist()
