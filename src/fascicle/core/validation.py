"""Validation of values where they enter the library; laws trust them.

A traced value (inside `jax.jit`, `jax.grad`, `jax.vmap`) has no number to check: it was checked
where it entered, or is the caller's own affair.

Text and pint quantities, `"2 bar"` and `2 * ureg.bar`, become SI numbers here. A bare number is in
the SI unit that the argument's docstring gives.

A number without a sense of scale is a slip: millimeters read as meters, a prefix too many. What no
muscle can be is refused; what is possible, but not usual, gets a warning. Between the limits every
law has a finite value. The limits are wide of what is built:

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
from typing import Any, NamedTuple

import numpy as np

from ..units import DIMENSIONS, sample
from ..units import parse as parsed
from .array_namespace import FLOATS, as_jax, imported_jax, is_jax_array
from .errors import InvalidInputError
from .types import Batch, Values


HIGHEST_PRESSURE = 1e6  # Pa, gauge
LARGEST_STRAIN = 0.6  # no braid contracts by more than 0.423, a bundle's muscles may be pushed on
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
) -> Batch:
    """Return `value` as floats, NumPy's, refusing anything outside the interval.

    The interval is open unless `closed` says otherwise for its low or high end. Ends may be
    arrays, which broadcast against the value. `why` completes the rule in words: "to
    contract"; `remedy` says what to do.
    """
    single = type(value) in FLOATS and type(low) is not np.ndarray
    if single and type(high) is not np.ndarray and low < value < high:
        return np.float64(value + 0.0)  # a single good one, soon
    value = to_si(value, name, unit)
    if not is_concrete(value):
        return traced_floats(value)
    x = _numeric(value, name, unit)
    # written so that NaN is refused too
    above = (x >= low) if closed[0] else (x > low)
    below = (x <= high) if closed[1] else (x < high)
    good = above & below
    if not np.all(good):
        bad, low, high = (float(np.broadcast_to(x, good.shape)[~good][0]) for x in (x, low, high))
        ends = f"{_number(low)}, {_number(high)}"
        interval = f"{'[' if closed[0] else '('}{ends}{']' if closed[1] else ')'}"
        rule = " ".join(part for part in (interval, _shown(unit), why) if part)
        raise InvalidInputError(name, f"must lie in {rule}", bad, remedy, shown=_amount(bad, unit))
    return x[()]


def check_positive(value: Values, name: str, unit: str, remedy: str = "") -> Batch:
    """Return `value` as floats, NumPy's, refusing anything that is not > 0 and finite; `remedy`
    says what to do.
    """
    value = to_si(value, name, unit)
    if not is_concrete(value):
        return traced_floats(value)
    x = _numeric(value, name, unit)
    good = (x > 0) & np.isfinite(x)
    if not np.all(good):
        bad = float(x[~good].flat[0])
        raise InvalidInputError(
            name, "must be positive and finite", bad, remedy, shown=_amount(bad, unit)
        )
    return x[()]


def check_finite(value: Values, name: str, unit: str) -> Batch:
    """Return `value` as floats, NumPy's, refusing NaN and infinities."""
    return check_interval(value, -math.inf, math.inf, name, unit)


def match_array_type(value: Values, checked: Batch) -> Batch:
    """Convert a `checked` value to the array library of the original `value`."""
    return as_jax(checked) if is_jax_array(value) else checked


def check_choice(name: str, choices: Iterable[str], what: str) -> str:
    """Return `name` if it is a choice; else refuse it and suggest the nearest."""
    if name in (choices := list(choices)):
        return name
    known = sorted(choices)
    near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.4)
    hint = f"did you mean {near[0]!r}? " if near else ""
    remedy = f"{hint}choose one of {', '.join(known)}"
    raise InvalidInputError(what, f"{name!r} is unknown", name, remedy, shown="")


def is_concrete(*values: Values) -> bool:
    """True where none of the `values` is traced or contains traced arrays."""
    jax = imported_jax()
    if jax is None:
        return True
    return not any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(values))


def traced_floats(value: Values) -> Batch:
    """A traced `value` [any unit] as JAX's floats."""
    return imported_jax().numpy.asarray(value, dtype=float)


def _shown(unit: str) -> str:
    return "" if unit == "-" else unit


def _number(value: float) -> str:
    return f"{value:g}".replace("e+0", "e")


def _amount(value: float | str, unit: str) -> str:
    text = value if isinstance(value, str) else _number(value)
    return " ".join(part for part in (text, _shown(unit)) if part)


def _numeric(value: Values, name: str, unit: str) -> np.ndarray:
    try:
        x = np.asarray(value)
        if x.dtype.kind not in "fiu":  # a bool or a string is no measurement
            raise TypeError
        return np.asarray(x.astype(float) + 0.0)  # no negative zero
    except (TypeError, ValueError):
        what = f"numbers in {unit}" if _shown(unit) else "dimensionless numbers"
        raise InvalidInputError(name, f"takes {what}", value, shown=repr(value)) from None


def broadcast_shape(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape to which arguments of these `shapes` broadcast, each by its name."""
    if not any(shapes.values()):
        return ()  # single numbers, soon
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        one, other = next(
            pair for pair in itertools.combinations(shapes, 2) if _apart(shapes, pair)
        )
    raise InvalidInputError(
        other,
        f"must broadcast against `{one}`",
        None,
        "for each with each give one an axis more, x[:, None]",
        shown=f"the shapes {shapes[other]} and {shapes[one]}",
    )


def _apart(shapes: dict[str, tuple[int, ...]], names: tuple[str, str]) -> bool:
    sizes = zip(*(reversed(shapes[name]) for name in names), strict=False)
    return any(x != y and 1 not in (x, y) for x, y in sizes)


_PLAIN = frozenset({float, int, bool, np.float64, np.int64, np.bool_, np.float32})
_SPELLED = str.maketrans({"·": "*", "²": "^2", "³": "^3"})
# of several with one unit, the first
_DIMENSIONS = {
    kind.si: name for name, kind in reversed(list(DIMENSIONS.items())) if not kind.unitless
}  # fmt: skip


def to_si(value: Any, name: str, unit: str) -> Any:
    """A value as SI numbers, where it is written with its unit; anything else as it is.

    **Arguments:**

    - `value`: text such as `"34.5 kPa"`, a pint quantity, or lists and arrays of them.
    - `name`: what to call it in an error.
    - `unit`: the SI unit that bare numbers have.

    **Returns:** numbers [SI].

    **Raises:** `ValueError`, one line, for another kind of quantity and for no quantity.
    """
    if type(value) in _PLAIN:
        return value
    dimension = "strain" if name == "strain" else _DIMENSIONS.get(unit.translate(_SPELLED))
    if dimension is None or not has_units(value):
        return value
    return _numbers(value, name, dimension)


def has_units(value: Any) -> bool:
    """True for text or a pint quantity, and for lists and arrays of them."""
    if isinstance(value, list | tuple):
        # the kinds first: a long list of numbers is passed over in a glance
        return not {type(one) for one in value} <= _PLAIN and any(map(has_units, value))
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "UO" and any(map(has_units, value.flat))
    return isinstance(value, str) or hasattr(value, "m_as")


def _numbers(value: Any, name: str, dimension: str) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, str):
        return parsed(value, dimension, name)
    if isinstance(value, list | tuple):
        return [_numbers(one, name, dimension) for one in value]
    if not hasattr(value, "m_as"):
        return value
    kind = DIMENSIONS[dimension]
    try:
        return value.m_as(kind.si or "dimensionless")
    except (TypeError, ValueError, AttributeError):  # pint's own is a TypeError
        rule = f"must be {kind.article}, such as {sample(dimension)}"
        raise InvalidInputError(name, rule, value, shown=f"{value}") from None


class Range(NamedTuple):
    """In `unit`, the `least` and the `largest` that can be, and between `low` and `high` what
    is usual, all in SI.
    """

    unit: str
    least: float
    low: float
    high: float
    largest: float


LENGTH = Range("m", 1e-4, 3e-3, 10.0, 100.0)  # a hair's width; a building's height
RADIUS = Range("m", 1e-5, 2e-4, 0.15, 1.0)  # of a single fiber; of a car tire and more
# a braid locks where its fibers touch, at 10 deg or more; the law's own end is at 54.7356 deg
_ANGLE = Range("deg", 1.0, 8.0, 52.0, math.inf)
_FACTOR = Range("-", 1e-6, 0.01, 100.0, 1e6)  # on a modulus: from foam to glass is 1e6

RANGES: Mapping[str, Range] = MappingProxyType({
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
})  # fmt: skip


FAINT_PRESSURE = 1e3  # Pa: 10 cm of water, at which no muscle moves
_SHOWN: set[str] = set()  # warnings that are shown once
_BEAM = 7.0  # length over radius, below which beams' theory ends: sections don't stay plane
# length over radius of a muscle as long as wide. It is warned about, not refused: fits and designs
# pass through such sizes, and every law is finite there
_DISK = 2.0


def warn_pressure_units(pressure: Any) -> None:
    """Warn, once, of a `pressure` [Pa] so low that it may be in bar or kPa without a unit.

    A range that begins so low is none of these, nor are zeros.
    """
    if "low pressure" in _SHOWN or not is_concrete(pressure) or not np.size(pressure):
        return
    highest = float(np.max(np.asarray(pressure)))
    if 0 < highest < FAINT_PRESSURE:
        _SHOWN.add("low pressure")
        meant = f"{highest:g} {'bar' if highest <= HIGHEST_PRESSURE / 1e5 else 'kPa'}"
        warn_user(
            f"Pressure {highest:g} Pa is very low. Bare numbers are in Pa: did you mean"
            f' "{meant}"? (shown once)'
        )


def warn_user(message: str) -> None:
    """Warn with a `message` at the user's line, the first one outside of fascicle."""
    frame, levels = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").split(".")[0] == "fascicle":
        frame, levels = frame.f_back, levels + 1
    warnings.warn(message, stacklevel=levels)


def disable_pressure_unit_warning() -> None:
    """Switch off the warning of low pressures, where all pressures came with their units."""
    _SHOWN.add("low pressure")


def check_size(value: Values, name: str) -> Batch:
    """Return `value` as a float array, if it is positive and of a size that can be.

    **Arguments:**

    - `value`: it [SI].
    - `name`: what it is called, a key of `RANGES`.

    **Returns:** the array [SI].

    **Raises:** `ValueError`, one line, for what can't be; for the unusual there is a warning.
    """
    return check_plausible(check_positive(value, name, RANGES[name].unit), name)


def check_signed(value: Values, name: str) -> Batch:
    """As `size`, for what needn't be positive; `value` [SI], `name`."""
    return check_plausible(check_finite(value, name, RANGES[name].unit), name)


def check_plausible(value: Any, name: str, known: Range | None = None) -> Any:
    """Return a `value` [SI], numbers already, if it can be what its `name` says, or what is
    `known` of it.
    """
    known = RANGES[name] if known is None else known
    if isinstance(value, float) and known.low <= value <= known.high:
        return value  # a single usual one, soon
    if is_concrete(value):
        _within(value, known, name)
    return value


def check_count(value: Values, name: str) -> None:
    """Refuse a `value` of this `name` that is no whole number of 1 or more, or too many."""
    if not is_concrete(value):
        return
    n = np.asarray(value)
    if n.dtype.kind not in "iu" or np.any(n < 1):
        rule = "must be a whole number of at least 1"
        raise InvalidInputError(name, rule, value, shown=reprlib.repr(value))
    check_plausible(n, name)


def check_braid_angle(braid_angle: Batch) -> None:
    """Refuse and warn of a `braid_angle` [rad] as `plausible` does, in degrees."""
    if is_concrete(braid_angle):
        _within(np.degrees(np.asarray(braid_angle)), _ANGLE, "braid_angle")


def _within(value: Values, known: Range, name: str) -> None:
    x = np.asarray(value, dtype=float)
    # written so that NaN is refused too
    good = (x >= known.least) & (x <= known.largest)
    if not np.all(good):
        rule = _interval(known.least, known.largest, known.unit)
        bad = float(x[~good].flat[0])
        got = _amount(bad, known.unit)
        raise InvalidInputError(name, f"must lie in {rule}", bad, "check its unit", shown=got)
    usual = (x >= known.low) & (x <= known.high)
    if not np.all(usual):
        rule = _interval(known.low, known.high, known.unit)
        got = _amount(x[~usual].flat[0], known.unit)
        warnings.warn(f"`{name}` of {got} is unusual, most lie in {rule}.", stacklevel=5)


def warn_slenderness(length: Batch, outer_radius: Batch) -> None:
    """Warn of a muscle shorter than it is wide, and, once, of one too short for beam theory.

    **Arguments:** `length`, `outer_radius`: of the muscle [m].
    """
    message, ratio = _proportions(length, outer_radius)
    if ratio < _DISK:
        warn_user(message)
    elif message and "slenderness" not in _SHOWN:
        _SHOWN.add("slenderness")
        warn_user(f"{message} (shown once)")


def proportions_message(length: Batch, outer_radius: Batch) -> str:
    """Warning of a muscle that is too short for its radius; empty where there is nothing to say.

    **Arguments:**

    - `length`: at rest [m].
    - `outer_radius`: of the braid [m]; broadcasts against `length`.

    **Returns:** one sentence or two.
    """
    return _proportions(length, outer_radius)[0]


def _proportions(length: Batch, outer_radius: Batch) -> tuple[str, float]:
    """Message, and the least length over radius [-]."""
    if not is_concrete(length, outer_radius):
        return "", math.inf
    lengths, radii = np.broadcast_arrays(np.asarray(length), np.asarray(outer_radius))
    worst = np.argmin(lengths / radii)
    ratio = lengths.flat[worst] / radii.flat[worst]
    if not ratio < _BEAM:
        return "", ratio
    sizes = (
        f"`length` {lengths.flat[worst]:g} m is {ratio:.3g} times `outer_radius`"
        f" {radii.flat[worst]:g} m:"
    )
    if ratio < _DISK:
        return (
            f"{sizes} a muscle shorter than it is wide is unusual, and the laws ignore end effects."
            " Check both units."
        ), ratio
    return (
        f"{sizes} below {_BEAM:g}, beam theory does not apply; results past the free strain are"
        " unreliable."
    ), ratio


def _interval(low: float, high: float, unit: str) -> str:
    return _amount(f"[{low:g}, {high:g}]", unit)
