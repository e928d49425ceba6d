"""Pinned curves: names, curves and differences to the first, and their text in a link."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..files import dumps, example, loads
from ..files.shipped_files import named_muscles
from ..io.sanitize import sanitize_line
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from ..units import exact, parse, pretty
from .muscle_curves import POINTS, strain_limit
from .state import Pin, view_of
from .widgets import SIZES, format_quantity, unit_factor


MOST_PINS = 6  # more colors and dashes can't be told apart
LONGEST_NAME = 40  # characters: a line of a phone
_MOST_PARTS = 2  # of a name that lists differences: a name with more is longer than a line
# of a quantity and unit [SI]: a smaller reference is zero but for rounding, and has no percentage
_ZERO = {"force": 1e-6, "strain": 1e-9}
MINUS = "−"


@dataclass(frozen=True)
class PinCurve:
    """Force [N] of a pin over `strain` [-], with its marks."""

    strain: np.ndarray
    force: np.ndarray
    blocked_force: float  # [N]
    free_strain: float  # [-]
    collapse_strain: float  # [-], inf where it never collapses


@dataclass(frozen=True)
class PinQuantity:
    """A quantity of all pins: `values` [SI, of a `dimension`], the first is the reference."""

    label: str
    dimension: str
    values: tuple[float, ...]

    @property
    def differences(self) -> list[tuple[float, float]]:
        """Difference to the reference [SI], and its share of the reference's magnitude [-].

        NaN where one of both is infinite, and the share where the reference is zero.
        """
        reference = self.values[0]
        size = abs(reference) if abs(reference) > _ZERO[self.dimension] else math.nan
        both = [
            value - reference if math.isfinite(value - reference) else math.nan
            for value in self.values
        ]
        return [(difference, difference / size) for difference in both]


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


def quantities(pins: Sequence[Pin], strain: float) -> list[PinQuantity]:
    """Quantities of `pins` to compare; the last is the force at a `strain` [-]."""
    top = top_strain(pins)
    curves = [pin_curve(pin.muscle, pin.pressure, top) for pin in pins]
    at_strain = tuple(float(pin.muscle.force(pin.pressure, strain)) for pin in pins)
    return [
        PinQuantity("Blocked force", "force", tuple(curve.blocked_force for curve in curves)),
        PinQuantity("Free strain", "strain", tuple(curve.free_strain for curve in curves)),
        PinQuantity("Collapse strain", "strain", tuple(curve.collapse_strain for curve in curves)),
        PinQuantity(f"Force at ε = {strain:.4g}", "force", at_strain),
    ]


def quantity_texts(quantity: PinQuantity, unit: str) -> list[tuple[str, str, str]]:
    """Value, difference and percentage of each pin, numbers in a `unit` with real minus signs."""
    scale = unit_factor(unit, quantity.dimension)
    form = ".4f" if quantity.dimension == "strain" else ".4g"

    def number_text(value: float, form: str) -> str:
        if math.isnan(value):
            return "–"
        return format(value, form).replace("-", MINUS) if math.isfinite(value) else "never"

    return [
        (
            number_text(value / scale, form),
            "reference" if i == 0 else number_text(difference / scale, f"+{form}"),
            "" if i == 0 else number_text(100 * fraction, "+.1f") + " %" * math.isfinite(fraction),
        )
        for i, (value, (difference, fraction)) in enumerate(
            zip(quantity.values, quantity.differences, strict=True)
        )
    ]


def add_pin(
    pins: tuple[Pin, ...], name: str, muscle: Muscle, pressure: float, unit: str
) -> tuple[Pin, ...]:
    """The `pins` and a new pin of a `muscle` at a `pressure` [Pa].

    The new pin's name lists what differs from the first pin; `name` and pressure if there is none,
    or too much.

    **Arguments:** `name` of the muscle; `unit` of the pressure in the pin's name.

    **Raises:** `InvalidInputError` for a curve that is among them, and for too many.
    """
    for pin in pins:
        if pin.muscle == muscle and pin.pressure == pressure:
            rule = f"must differ: this curve is “{pin.name}” already"
            raise InvalidInputError("pins", rule, None)
    check_pin_count(len(pins) + 1)
    at_pressure = format_quantity(pressure, unit, "pressure", 4)
    parts = [] if not pins else _differences(pins[0].muscle, muscle)
    if pins and pins[0].pressure != pressure:
        parts.append(at_pressure)
    if not 0 < len(parts) <= _MOST_PARTS:
        parts = [name.removesuffix(".toml"), at_pressure]
    return (*pins, Pin(_free_name(", ".join(parts), pins), muscle, pressure))


def rename_pin(pins: tuple[Pin, ...], index: int, name: str) -> tuple[Pin, ...]:
    """The `pins`, one of them with another `name`; `InvalidInputError` for a bad name."""
    pins_left = (*pins[:index], *pins[index + 1 :])
    name = check_pin_name(name, pins_left)
    return (*pins[:index], Pin(name, pins[index].muscle, pins[index].pressure), *pins[index + 1 :])


def check_pin_name(name: str, pins_left: Sequence[Pin]) -> str:
    """Name of a pin in one line, none of `pins_left`; `InvalidInputError` if it can't be."""
    line = sanitize_line(name, 2 * LONGEST_NAME)
    # a spreadsheet takes a leading =, +, - or @ for a formula
    if not line[:1].isalnum() or len(line) > LONGEST_NAME:
        rule = f"must begin with a letter or digit and have {LONGEST_NAME} characters at most"
        raise InvalidInputError("name", rule, name, shown=f"“{line}”")
    if any(pin.name == line for pin in pins_left):
        raise InvalidInputError("name", "must differ from the other curves'", line)
    return line


def check_pin_count(number: int) -> None:
    """Refuse a `number` of pins that is too large."""
    if number > MOST_PINS:
        rule = f"must be {MOST_PINS} curves at most, as many as can be told apart"
        raise InvalidInputError("pins", rule, number, "remove one")


def pins_text(pins: Sequence[Pin]) -> str:
    """Text of `pins`, for `parse_pins`; muscles that are shipped by their names."""
    items = []
    for pin in pins:
        shipped = next((name for name in named_muscles() if shipped_muscle(name) == pin.muscle), "")
        muscle = {"example": shipped} if shipped else {"file": dumps(pin.muscle)}
        pressure = exact(pin.pressure, "pressure")
        items.append({"name": pin.name, "pressure": pressure, **muscle})
    return json.dumps(items, ensure_ascii=False)


def parse_pins(text: str) -> tuple[Pin, ...]:
    """Pins of a text by `pins_text`; `InvalidInputError` or `ValueError` for anything else."""
    try:
        items = json.loads(text)
    except (ValueError, RecursionError):
        items = None
    if not isinstance(items, list) or not all(map(_is_item, items)):
        raise InvalidInputError("pins", "are no curves that this explorer has packed", None)
    check_pin_count(len(items))
    pins: tuple[Pin, ...] = ()
    for item in items:
        pressure = parse(item["pressure"], "pressure")
        check_interval(pressure, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", (True, True))
        name = check_pin_name(item["name"], pins)
        if "file" in item:
            muscle = view_of(loads(item["file"], source=name), name).muscle
        elif item["example"] in named_muscles():
            muscle = shipped_muscle(item["example"])
        else:
            raise InvalidInputError("pins", "must name a shipped muscle", item["example"][:40])
        pins = (*pins, Pin(name, muscle, pressure))
    return pins


@lru_cache(maxsize=64)  # more than there are; a link is written after every move
def shipped_muscle(name: str) -> Muscle:
    """Muscle of an example or of a measured muscle; of a bundle, its first unit's."""
    return view_of(example(name), name).muscle


def _is_item(item: Any) -> bool:
    """True for a pin's object of `pins_text`: texts alone, a muscle among them."""
    return (
        isinstance(item, dict)
        and {"name", "pressure"} < item.keys()
        and bool({"file", "example"} & item.keys())
        and all(isinstance(value, str) for value in item.values())
    )


def _free_name(name: str, pins: Sequence[Pin]) -> str:
    """The `name` cleaned for a pin, with a number if one of the `pins` has it already."""
    line = sanitize_line(name, LONGEST_NAME - 10).lstrip("=+-@_. ") or "muscle"
    names = {pin.name for pin in pins}
    candidates = (line, *(f"{line} ({i})" for i in range(2, MOST_PINS + 2)))
    return next(candidate for candidate in candidates if candidate not in names)


def _differences(first: Muscle, second: Muscle) -> list[str]:
    """Sizes, material and laws of the `second` muscle that the first has not, in words."""
    parts = [
        f"{label.lower()} {pretty(float(getattr(second, name)), dimension)}"
        for name, (label, dimension) in SIZES.items()
        if getattr(first, name) != getattr(second, name)
    ]
    if first.material != second.material:
        names = (name for name, material in MATERIALS.items() if material == second.material)
        parts.append(next(names, "other material").replace("_", " "))
    laws = (getattr(second, kind) for kind in LAWS if getattr(first, kind) != getattr(second, kind))
    parts += [law.name.replace("_", " ") for law in laws]
    return parts if first.tuning == second.tuning else [*parts, "other tuning"]
