"""Validation of values where they enter the library; laws trust them.

A traced value (inside `jax.jit`, `jax.grad`, `jax.vmap`) has no number to check: it was checked
where it entered, or is the caller's own affair.

Text and pint quantities, `"2 bar"` and `2 * ureg.bar`, become SI numbers here. A bare number is in
the SI unit that the argument's docstring gives.

An impossible size is refused: millimeters read as meters, a prefix too many. A possible, but
unusual one gets a warning. Between the limits every law has a finite value. The limits are wide of
what is built:

- *small*: De Volder, Moers and Reynaerts (2011) made muscles of 1.5 mm in diameter and 22 mm in
  length; thinner ones, of half a millimeter, have been tried;
- *large*: Festo's DMSP go up to 40 mm in diameter, 9 m in length and 6 kN; muscles that move
  parts of buildings are some 3 m long and 100 mm in radius.

**Source** of the domain: Kim, Mazzoleni and Bryant (2021), whose muscles are driven with up to
0.42 MPa; muscles on sale go up to 0.8 MPa.
"""

import difflib
import itertools
import math
import reprlib
import sys
import warnings
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..units import has_units, to_si
from .array_namespace import array_namespace, imported_jax, is_jax_array
from .errors import InvalidInputError
from .types import Batch, IntBatch, Values


HIGHEST_PRESSURE = 1e6  # Pa, gauge: muscles on sale go up to 0.8 MPa
LARGEST_STRAIN = 0.6  # no braid contracts by more than 0.423, a bundle's muscles may be pushed on
_MAX_SHOWN = 60  # characters of a refused value: an error is one line
NEUTRAL_ANGLE = math.atan(math.sqrt(2))  # rad, 54.7356 deg: a braid neither pulls nor pushes


def check_interval(
    value: Values,
    low: Batch,
    high: Batch,
    name: str,
    unit: str,
    why: str = "",
    closed: tuple[bool, bool] = (False, False),
    remedy: str = "",
    remedy_above: str = "",
) -> Batch:
    """Return `value` in SI as floats; refuse numbers outside the interval, and NaN.

    A traced value of JAX passes without a check. Low and high end are open or `closed`; they may be
    arrays, which broadcast against the value. `why` completes the rule in words: "to contract";
    `remedy` says what to do, `remedy_above` for a value above the high end.
    """
    value = to_si(value, name, unit)
    if not is_concrete(value):
        return traced_floats(value)
    x = _as_floats(value, name, unit)
    # written so that NaN is refused too
    good = ((x >= low) if closed[0] else (x > low)) & ((x <= high) if closed[1] else (x < high))
    if not np.all(good):
        bad, low, high = (float(np.broadcast_to(x, good.shape)[~good][0]) for x in (x, low, high))
        bad_text, low_text, high_text = distinct_texts(bad, low, high)
        interval = f"{'[' if closed[0] else '('}{low_text}, {high_text}{']' if closed[1] else ')'}"
        rule = f"must lie in {_append_unit(interval, unit)} {why}".rstrip()
        if (low, high) == (0, math.inf) and not any(closed):
            rule = "must be positive and finite"
        remedy = remedy_above if remedy_above and bad > high else remedy
        raise InvalidInputError(name, rule, bad, remedy, shown=_append_unit(bad_text, unit))
    return x[()]


def check_positive(value: Values, name: str, unit: str, remedy: str = "") -> Batch:
    """Return `value` as floats, NumPy's, if it is positive and finite; `remedy` says what to do."""
    return check_interval(value, 0.0, math.inf, name, unit, remedy=remedy)


def check_nonnegative(value: Values, name: str, unit: str) -> Batch:
    """Return `value` as floats, NumPy's, if it is finite and not below zero."""
    return check_interval(value, 0.0, math.inf, name, unit, closed=(True, False))


def check_finite(value: Values, name: str, unit: str) -> Batch:
    """Return `value` as floats, NumPy's, if it is neither NaN nor infinite."""
    return check_interval(value, -math.inf, math.inf, name, unit)


def match_array_type(value: Values, checked: Batch) -> Batch:
    """Convert a `checked` value to the array library of the original `value`."""
    return array_namespace(value).asarray(checked)[()]


def check_choice(name: str, choices: Iterable[str], argument: str) -> str:
    """Return `name` if it is among the `choices`; the error suggests the most similar one."""
    if name in (choices := list(choices)):
        return name
    names = sorted(choices)
    similar = difflib.get_close_matches(str(name), names, n=1, cutoff=0.4)
    hint = f"did you mean {similar[0]!r}? " if similar else ""
    remedy = f"{hint}choose one of {', '.join(names) or 'none'}"
    raise InvalidInputError(argument, f"{name!r} is unknown", name, remedy, shown="")


def is_concrete(*values: Values) -> bool:
    """True where none of the `values` is traced or contains traced arrays."""
    jax = imported_jax()
    if jax is None:
        return True
    return not any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(values))


def traced_floats(value: Values) -> Batch:
    """A traced `value` [any unit] as floats of JAX."""
    return sys.modules["jax.numpy"].asarray(value, dtype=float)


def broadcast_shape(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """Shape to which arguments of these `shapes`, by name, broadcast; else an error names two."""
    if not any(shapes.values()):
        return ()
    for (first, shape), (second, next_shape) in itertools.combinations(shapes.items(), 2):
        axes = zip(shape[::-1], next_shape[::-1], strict=False)
        if any(m != n and 1 not in (m, n) for m, n in axes):
            rule = f"must broadcast against `{first}`"
            remedy = "to combine each with each add an axis to one, x[:, None]"
            text = f"the shapes {next_shape} and {shape}"
            raise InvalidInputError(second, rule, None, remedy, shown=text)
    return np.broadcast_shapes(*shapes.values())


def _number_text(value: float, digits: int = 6) -> str:
    return f"{value:.{digits}g}".replace("e+0", "e")


def distinct_texts(bad: float, *limits: float) -> list[str]:
    """Texts of a refused value and its limits, with enough digits to tell the value from them."""
    digits = 6
    while digits < 17 and any(  # 17 tell any two floats apart
        _number_text(bad, digits) == _number_text(limit, digits) for limit in limits
    ):
        digits += 1
    # six digits write many limits exactly
    enough = (6 if float(_number_text(x)) == x else digits for x in limits)
    return [_number_text(bad, digits), *map(_number_text, limits, enough)]


def _append_unit(text: str, unit: str) -> str:
    """The `text` and its unit; the `text` alone if `unit` is "-"."""
    return text if unit == "-" else f"{text} {unit}"


def _as_floats(value: Values, name: str, unit: str) -> np.ndarray:
    """The `value` as an array of floats, refused if it isn't one of numbers, or if it is masked."""
    is_jax_array(value)  # refuses one before `import fascicle.jax`
    if np.ma.is_masked(value):
        text = f"{np.ma.count_masked(value)} masked elements"
        remedy = "drop them, x.compressed(), or fill them, x.filled(…)"
        raise InvalidInputError(name, "must not be masked", None, remedy, shown=text)
    try:
        x = np.asarray(value)
        if x.dtype.kind not in "fiu":  # a bool or a string is no measurement
            raise TypeError
        return np.asarray(x.astype(float) + 0.0)  # no negative zero
    except (TypeError, ValueError):
        rule = "takes dimensionless numbers" if unit == "-" else f"takes numbers in {unit}"
        text = " ".join(repr(value).split())
        text = text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"
        raise InvalidInputError(name, rule, value, shown=text) from None


class Range(NamedTuple):
    """Possible values, `least` to `largest`, and usual ones, `low` to `high`, all in SI."""

    unit: str
    least: float
    low: float
    high: float
    largest: float


LENGTH = Range("m", 1e-4, 3e-3, 10.0, 100.0)  # a hair's width; a building's height
RADIUS = Range("m", 1e-5, 2e-4, 0.15, 1.0)  # of a single fiber; of a car tire and more
_FACTOR = Range("-", 1e-6, 0.01, 100.0, 1e6)  # on a modulus: from foam to glass is 1e6

RANGES: Mapping[str, Range] = MappingProxyType(
    {
        "length": LENGTH,
        "outer_radius": RADIUS,
        "radius": RADIUS,
        # below a micrometer no rubber is a film; kitchen film is 10 µm
        "wall_thickness": Range("m", 1e-6, 1e-5, 0.03, 0.5),
        # 25 and 100 in the paper; past a thousand the force falls within a strain of 0.001
        "transition_rate": Range("-", 1e-3, 0.5, 1e3, 1e6),
        "youngs_modulus_factor": _FACTOR,
        "hinge_stiffness_factor": _FACTOR,
        # a large one is how to say that a muscle doesn't collapse
        "collapse_moment_factor": Range("-", 1e-6, 0.01, 1e6, 1e9),
        "c2": Range("-", 1e-4, 0.1, 10.0, 1e4),  # measured over modeled force
        "c1": Range("N", -1e6, -1e5, 1e5, 1e6),  # the largest muscles pull 6 kN
        # muscles in one motor unit: beyond a thousand it is rather a slip, whatever memory holds
        "count": Range("-", 1.0, 1.0, 1e3, 1e6),
        # a pascal is a tenth of a mm of water
        "supply_pressure": Range("Pa", 1.0, 1e3, HIGHEST_PRESSURE, HIGHEST_PRESSURE),
    }
)


_HYDRAULIC = (
    "muscles of higher pressure are hydraulic, no law here was compared with one; the ideal force,"
    " equation (3) of the theory page on the braid, holds for them"
)
FAINT_PRESSURE = 1e3  # Pa: 10 cm of water, at which no muscle moves


class BareNumberWarning(UserWarning):
    """A number in Pa that is so small that it may be in another unit."""


def warn_user(message: str, category: type[UserWarning] = UserWarning) -> None:
    """Warn with a `message`, unless it is empty, at the user's line: the first outside fascicle."""
    if not message:
        return
    frame, levels = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").split(".")[0] == "fascicle":
        frame, levels = frame.f_back, levels + 1
    warnings.warn(message, category, stacklevel=levels)


def check_gauge_pressure(value: Values, name: str = "pressure") -> Batch:
    """Return gauge pressures [Pa] as floats, in the array library of `value`, if they lie in 0 to
    1 MPa; warn of bare numbers that may be in bar.
    """
    limits = (0.0, HIGHEST_PRESSURE, name, "Pa", "(gauge)", (True, True))
    pressure = check_interval(value, *limits, remedy_above=_HYDRAULIC)
    highest = np.max(np.asarray(pressure), initial=0.0) if is_concrete(pressure) else 0.0
    # zeros, and ranges that begin so low, don't warn
    if 0 < highest < FAINT_PRESSURE and not has_units(value):
        guess = f"{highest:g} {'bar' if highest <= HIGHEST_PRESSURE / 1e5 else 'kPa'}"
        message = f"Pressure {highest:g} Pa is very low. Bare numbers are in Pa"
        warn_user(f'{message}: did you mean "{guess}"?', BareNumberWarning)
    return match_array_type(value, pressure)


def check_size(value: Values, name: str, limits: Range | None = None) -> Batch:
    """Return a `value` [SI] as floats; refuse or warn by its `limits` (default: the range of its
    `name`). One whose least value is positive must be positive.
    """
    limits = limits or RANGES[name]
    check = check_positive if limits.least > 0 else check_finite
    return check_plausible(check(value, name, limits.unit), name, limits)


def check_plausible(value: Batch, name: str, limits: Range | None = None) -> Batch:
    """Return a number or array [SI] as it is; refuse one outside of `limits` (default: the range of
    its `name`), warn of an unusual one, and let JAX's tracers pass.
    """
    unit, smallest, low, high, largest = RANGES[name] if limits is None else limits
    if (isinstance(value, float) and low <= value <= high) or not is_concrete(value):
        return value
    closed, remedy = (True, True), "" if unit == "-" else "check its unit"
    x = np.asarray(check_interval(value, smallest, largest, name, unit, "", closed, remedy))
    usual = (x >= low) & (x <= high)
    if not np.all(usual):
        interval = _append_unit(f"[{_number_text(low)}, {_number_text(high)}]", unit)
        text = _append_unit(_number_text(x[~usual][0]), unit)
        warn_user(f"`{name}` of {text} is unusual, most lie in {interval}.")
    return value


def check_whole_number(value: Values, name: str, low: int, high: float = math.inf) -> int:
    """Return a `value` that is one whole number from `low` to `high`."""
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not is_whole or not low <= value <= high:
        rule = f"must be at least {low}" if high == math.inf else f"must lie in [{low}, {high}]"
        rule = rule if is_whole else f"must be a whole number from {low} on"
        raise InvalidInputError(name, rule, value, shown=reprlib.repr(value))
    return int(value)


def check_scalar(value: Values, name: str) -> float:
    """Return the number in a checked `value` [any unit]; `InvalidInputError` for several."""
    if np.ndim(value):
        text = f"an array of shape {np.shape(value)}"
        raise InvalidInputError(name, "must be a single number", value, shown=text)
    return float(value)


def check_count(value: Values, name: str) -> IntBatch:
    """Return whole numbers of 1 or more as integers; refuse others, and too many."""
    if not is_concrete(value):
        return value
    n = np.asarray(value)
    if n.dtype.kind not in "iu" or np.any(n < 1):
        rule = "must be a whole number of at least 1"
        raise InvalidInputError(name, rule, value, shown=reprlib.repr(value))
    check_plausible(n, name)
    return n[()]
