"""How large what muscles are made of can be, for all doors: Python, files, commands, explorer.

A number without a sense of scale is a slip: millimeters read as meters, a prefix too many. What
no muscle can be is refused; what is possible, but not usual, is warned about. Between the limits
every law has a finite value. The limits are wide of what is built:

- *small*: De Volder, Moers and Reynaerts (2011) made muscles of 1.5 mm in diameter and 22 mm in
  length; thinner ones, of half a millimeter, have been tried;
- *large*: Festo's DMSP go up to 40 mm in diameter, 9 m in length and 6 kN; muscles that move
  parts of buildings are some 3 m long and 100 mm in radius.
"""

import math
import reprlib
import sys
import warnings
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from .checks import concrete, finite, positive
from .domain import HIGHEST_PRESSURE
from .refused import Refused
from .types import Batch, Values


class Range(NamedTuple):
    """In `unit` [-], the `least` and the `largest` that can be, and between `low` and `high` what
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
_OURS = ("fascicle",)
_said_to_be_faint: list[float] = []
_BEAM = 7.0  # length over radius, below which beams' theory ends: sections don't stay plane
# length over radius of a muscle as long as wide. It is warned about, not refused: fits and designs
# pass through such sizes, and every law is finite there
_DISK = 2.0
_said_to_be_stubby: list[float] = []


def pressed(pressure: Any) -> None:
    """Warn, once, of numbers of `pressure` [Pa] that are none at all: bar or kPa without a unit.
    A range that begins so low is none of these, nor are zeros.
    """
    if _said_to_be_faint or not concrete(pressure) or not np.size(pressure):
        return
    highest = float(np.max(np.asarray(pressure)))
    if 0 < highest < FAINT_PRESSURE:
        _said_to_be_faint.append(highest)
        meant = f"{highest:g} {'bar' if highest <= HIGHEST_PRESSURE / 1e5 else 'kPa'}"
        warn_user(
            f"a pressure of {highest:g} Pa is next to nothing; numbers are in Pa: for {meant} write"
            f' "{meant}". This is said once.'
        )


def warn_user(message: str) -> None:
    """Warn with a `message` [-] at the user's line, the first one outside of fascicle."""
    frame, levels = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").split(".")[0] in _OURS:
        frame, levels = frame.f_back, levels + 1
    warnings.warn(message, stacklevel=levels)


def pascals_meant() -> None:
    """Let no low pressure be warned of, where all of them came with their units."""
    _said_to_be_faint.append(0.0)


def size(value: Values, name: str) -> Batch:
    """Return `value` as a float array, if it is positive and of a size that can be.

    **Arguments:**

    - `value`: it [SI].
    - `name`: what it is called, a key of `RANGES` [-].

    **Returns:** the array [SI].

    **Raises:** `ValueError`, one line, for what can't be; for the unusual there is a warning.
    """
    return plausible(positive(value, name, RANGES[name].unit), name)


def signed(value: Values, name: str) -> Batch:
    """As `size`, for what needn't be positive; `value` [SI], `name` [-]."""
    return plausible(finite(value, name, RANGES[name].unit), name)


def plausible(value: Any, name: str, known: Range | None = None) -> Any:
    """Return a `value` [SI], numbers already, if it can be what its `name` [-] says, or what is
    `known` [-] of it.
    """
    known = RANGES[name] if known is None else known
    if isinstance(value, float) and known.low <= value <= known.high:
        return value  # a single usual one, soon
    if concrete(value):
        _within(value, known, name)
    return value


def whole(value: Values, name: str) -> None:
    """Refuse a `value` [-] of this `name` [-] that is no whole number of 1 or more, or too many."""
    if not concrete(value):
        return
    n = np.asarray(value)
    if n.dtype.kind not in "iu" or np.any(n < 1):
        rule = "must be a whole number of at least 1"
        raise Refused(name, rule, value, shown=reprlib.repr(value))
    plausible(n, name)


def tilted(braid_angle: Batch) -> None:
    """Refuse and warn of a `braid_angle` [rad] as `plausible` does, in degrees."""
    if concrete(braid_angle):
        _within(np.degrees(np.asarray(braid_angle)), _ANGLE, "braid_angle")


def _within(value: Values, known: Range, name: str) -> None:
    x = np.asarray(value, dtype=float)
    # written so that NaN is refused too
    good = (x >= known.least) & (x <= known.largest)
    if not np.all(good):
        rule = _interval(known.least, known.largest, known.unit)
        bad = float(x[~good].flat[0])
        got = _amount(bad, known.unit)
        raise Refused(name, f"must lie in {rule}", bad, "check its unit", shown=got)
    usual = (x >= known.low) & (x <= known.high)
    if not np.all(usual):
        rule = _interval(known.low, known.high, known.unit)
        got = _amount(x[~usual].flat[0], known.unit)
        warnings.warn(f"`{name}` of {got} is unusual, most lie in {rule}.", stacklevel=5)


def slender(length: Batch, outer_radius: Batch) -> None:
    """Warn of a muscle shorter than it is wide, and, once, of one that is no beam; `length` and
    `outer_radius` [m].
    """
    message, ratio = _proportions(length, outer_radius)
    if ratio < _DISK:
        warn_user(message)
    elif message and not _said_to_be_stubby:
        _said_to_be_stubby.append(ratio)
        warn_user(f"{message} This is said once.")


def proportions_message(length: Batch, outer_radius: Batch) -> str:
    """Warning of a muscle that is too short for its radius; empty where there is nothing to say.

    **Arguments:**

    - `length`: at rest [m].
    - `outer_radius`: of the braid [m]; broadcasts against `length`.

    **Returns:** one sentence or two [-].
    """
    return _proportions(length, outer_radius)[0]


def _proportions(length: Batch, outer_radius: Batch) -> tuple[str, float]:
    """The message [-], and the least length over radius [-]."""
    if not concrete(length, outer_radius):
        return "", math.inf
    lengths, radii = np.broadcast_arrays(np.asarray(length), np.asarray(outer_radius))
    worst = np.argmin(lengths / radii)
    ratio = lengths.flat[worst] / radii.flat[worst]
    if not ratio < _BEAM:
        return "", ratio
    what = (
        f"`length` {lengths.flat[worst]:g} m is {ratio:.3g} times `outer_radius`"
        f" {radii.flat[worst]:g} m:"
    )
    if ratio < _DISK:
        return (
            f"{what} a muscle shorter than it is wide is unusual, and the laws leave its ends out."
            " Check both units."
        ), ratio
    return (
        f"{what} below {_BEAM:g} a muscle is no beam, and what is said of it past its free strain"
        " is a guess."
    ), ratio


def _interval(low: float, high: float, unit: str) -> str:
    return _amount(f"[{low:g}, {high:g}]", unit)


def _amount(value: float | str, unit: str) -> str:
    text = value if isinstance(value, str) else f"{value:g}"
    return text if unit == "-" else f"{text} {unit}"
