"""Pinned curves: their names, curves, and numbers beside the first one's."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..units import pretty
from .muscle_curves import POINTS, strain_limit
from .state import Pin
from .widgets import SIZES


MOST_PINS = 6  # more colors and dashes can't be told apart
LONGEST_NAME = 40  # characters: a line of a phone
_ROUNDING = 1e-6  # N or -: a smaller reference is zero but for rounding, and has no percentage


class PinCurve(NamedTuple):
    """Force [N] of a pin over `strain` [-], with its blocked force [N] and free strain [-]; the
    collapse strain [-] is inf where the muscle never collapses.
    """

    strain: np.ndarray
    force: np.ndarray
    blocked_force: float
    free_strain: float
    collapse_strain: float


def top_strain(pins: Sequence[Pin]) -> float:
    """Largest strain [-] that is drawn for all `pins`."""
    return max(strain_limit(pin.muscle, pin.pressure) for pin in pins)


@lru_cache(maxsize=128)  # visitors share it
def pin_curve(muscle: Muscle, pressure: float, top: float) -> PinCurve:
    """Curve of a muscle at a `pressure` [Pa] up to a strain `top` [-], kinks among its strains."""
    free = float(muscle.free_strain(pressure))
    collapse = float(muscle.collapse_strain(pressure))
    kinks = [strain for strain in (free, collapse) if 0 < strain < top]
    strain = np.union1d(np.linspace(0.0, top, POINTS), kinks)
    force = np.asarray(muscle.force(pressure, strain))
    return PinCurve(strain, force, float(muscle.blocked_force(pressure)), free, collapse)


def difference_text(value: float, reference: float, form: str) -> str:
    """A `value` in a `form`, and by how many percent of the size of a `reference` it differs."""
    if not math.isfinite(value):
        return "never"
    text = format(value, form)
    if math.isfinite(reference) and value != reference and abs(reference) > _ROUNDING:
        text += f" ({100 * (value - reference) / abs(reference):+.1f} %)"
    return text.replace("-", "−")


def add_pin(pins: tuple[Pin, ...], name: str, muscle: Muscle, pressure: float) -> tuple[Pin, ...]:
    """The `pins`, and a new one with a `name` that no other has; `InvalidInputError` if there are
    too many.
    """
    if len(pins) >= MOST_PINS:
        rule = f"must be {MOST_PINS} curves at most, as many as can be told apart"
        raise InvalidInputError("pins", rule, len(pins) + 1, "remove one")
    # a spreadsheet takes a leading =, +, - or @ for a formula
    line = sanitize_line(str(name), LONGEST_NAME).lstrip("=+-@ ") or "muscle"
    names = {pin.name for pin in pins}
    candidates = (line, *(f"{line} ({i})" for i in range(2, MOST_PINS + 2)))
    free_name = next(candidate for candidate in candidates if candidate not in names)
    return (*pins, Pin(free_name, muscle, float(pressure)))


def rename_pin(pins: tuple[Pin, ...], index: int, name: str) -> tuple[Pin, ...]:
    """The `pins`, the one of an `index` with another `name`."""
    others = (*pins[:index], *pins[index + 1 :])
    pin = add_pin(others, name, pins[index].muscle, pins[index].pressure)[-1]
    return (*pins[:index], pin, *pins[index + 1 :])


def name_difference(first: Muscle, second: Muscle) -> str:
    """Sizes, material and laws of the `second` muscle that the first has not, in words."""
    parts = [
        f"{label.lower()} {pretty(float(getattr(second, name)), dimension)}"
        for name, (label, dimension) in SIZES.items()
        if getattr(first, name) != getattr(second, name)
    ]
    parts += ["other material"] * (first.material != second.material)
    laws = (getattr(second, kind) for kind in LAWS if getattr(first, kind) != getattr(second, kind))
    parts += [law.name.replace("_", " ") for law in laws]
    parts += ["other tuning"] * (first.tuning != second.tuning)
    return ", ".join(parts)
