"""What a muscle lets in: sizes that can exist, laws by name, points of the domain.

Laws trust what has passed here. A single point is looked at quickly: the full check, which
can name any array's worst value, would take longer than the law.
"""

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import (
    FAINT_PRESSURE,
    HIGHEST_PRESSURE,
    LARGEST_STRAIN,
    NEUTRAL_ANGLE,
    broadcast_shape,
    check_braid_angle,
    check_choice,
    check_interval,
    has_units,
    is_concrete,
    match_array_type,
    to_si,
    warn_pressure_units,
    warn_user,
)
from .bladder import Bladder
from .braid import Braid
from .ends.ends_law import AbstractEnds
from .foreign import warn_foreign
from .tuning import Tuning


# (r/r0)² = ε(2 − ε)/tan²α0 + 1 is known to about 1e-16/tan²α0 there, and rises from zero by
# 2 cosα0/sin²α0 times this: ten million times as much at any angle
_STRAIGHT = 1e-9
# a stretched muscle is rarely measured past this; a sign error is: published tests begin at rest
EXTENSION_WARNED = 0.02


def lowest_strain(braid_angle: Batch, stretch: Batch = 1.0) -> Batch:
    """Strain [-] that straightens the fibers, and a margin, at `braid_angle` [rad]; -inf for a
    traced one. Fibers that are straight within rounding have no radius left, and no finite force.
    `stretch`: the bladder's strain over the ends' [-].
    """
    if not is_concrete(braid_angle, stretch):
        return -np.inf
    return (1 - 1 / np.cos(np.asarray(braid_angle))) / np.asarray(stretch) + _STRAIGHT


def lowest_of(muscle: Any) -> tuple[Batch, Batch]:
    """The braid angle of a `muscle` [rad], and its bladder's strain over its ends' [-]."""
    return muscle.braid_angle, muscle.ends.stretch(muscle.length)


def active(ends: AbstractEnds, length: Batch) -> None:
    """Refuse `ends` [-] that take a third of the `length` [m] or more: not much would contract."""
    stretch = ends.stretch(length)
    if is_concrete(stretch) and not np.all(
        (np.asarray(stretch) >= 1) & (np.asarray(stretch) < 1.5)
    ):
        rule, remedy = "must be less than a third of `length`", "check its unit"
        raise InvalidInputError(
            "inactive_length", rule, getattr(ends, "inactive_length", None), remedy
        )


def good_point(muscle: Any, pressure: Values, strain: Values) -> bool:
    """Whether these are two floats, `pressure` [Pa] and `strain` [-], to which no check or
    warning of a `muscle` [-] has anything to say.
    """
    if not (isinstance(pressure, float) and isinstance(strain, float)):
        return False
    rows = muscle.tuning.pressures
    measured = rows.size < 2 or (is_concrete(rows) and pressure <= np.asarray(rows)[-1])
    inside = 0.0 <= strain <= LARGEST_STRAIN  # where an extension ends depends on the braid
    told = FAINT_PRESSURE <= pressure <= HIGHEST_PRESSURE or pressure == 0
    return bool(measured and inside and told)


def point(muscle: Any, pressure: Values, strain: Values) -> tuple[Any, Any]:
    """`pressure` [Pa] and `strain` [-] of a `muscle` [-], checked: a single point quickly."""
    good = good_point(muscle, pressure, strain)
    return (np.float64(pressure), np.float64(strain)) if good else checked(muscle, pressure, strain)


def checked(muscle: Any, pressure: Values, strain: Values) -> tuple[Batch, Batch]:
    """`pressure` [Pa] and `strain` [-] of a `muscle` [-], if they are in its domain."""
    return gauge(pressure, muscle.tuning), strained(strain, *lowest_of(muscle))


def points_of(*arrays: Batch, muscles: tuple[int, ...] = ()) -> int:
    """How many points [-] pressures and strains, or one of them, make together; they fit rows of
    `muscles` of that shape [-].
    """
    names = ("pressure", "strain") if len(arrays) == 2 else ("values",)
    shapes = dict(zip(names, map(np.shape, arrays), strict=True))
    if muscles:
        broadcast_shape(muscles=muscles, **shapes)
    return math.prod(broadcast_shape(**shapes))


def gauge(value: Values, tuning: Tuning) -> Batch:
    """A gauge pressure [Pa] of the domain; a warning where the `tuning` [-] was measured below."""
    closed = (True, True)
    checked = check_interval(value, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", closed)
    if not has_units(value):
        warn_pressure_units(checked)
    tuning.warn_beyond(checked)
    return match_array_type(value, checked)


def strained(value: Values, braid_angle: Batch, stretch: Batch = 1.0) -> Batch:
    """A strain [-] of the domain, of a braid at `braid_angle` [rad]; `stretch`: its own strain
    over the ends' [-]. Warns of an extension.
    """
    return validate_strain(value, lowest_strain(braid_angle, stretch))


def validate_strain(
    value: Values,
    low: Batch,
    high: Batch = LARGEST_STRAIN,
    why: str = "(fibers straight at the lower end)",
) -> Batch:
    """Return a strain as a float array, refusing it outside its domain, and warn of an extension.

    **Arguments:**

    - `value`: contraction [-].
    - `low`: strain at which fibers are straight [-], one or one for each muscle of a row.
    - `high`: largest strain [-].
    - `why`: reason of the limits, in words [-].

    **Returns:** the strain [-].

    **Raises:** `ValueError` for a concrete strain outside.
    """
    if np.ndim(low):
        value = to_si(value, "strain", "-")
        broadcast_shape(muscles=np.shape(low), strain=np.shape(value))
    strain = check_interval(value, low, high, "strain", "-", why, (False, True))
    warn_extension(strain, low)
    return match_array_type(value, strain)


def extension_message(strain: Batch, straight: Batch) -> str:
    """Warning of an extension past 2 % [-]; empty where there is none.

    **Arguments:**

    - `strain`: contraction, as it was given [-].
    - `straight`: strain at which fibers are straight [-]; broadcasts against `strain`.

    **Returns:** one sentence or two [-].
    """
    if not is_concrete(strain) or not np.size(strain):
        return ""
    every, straight = np.broadcast_arrays(np.asarray(strain), np.asarray(straight))
    worst = np.argmin(every)
    least, straight = every.flat[worst], straight.flat[worst]
    if not least < -EXTENSION_WARNED:
        return ""
    return (
        f"Strain {least:g} stretches the muscle by {-least:.3g} times its length: contraction is"
        f" positive. The braid's fibers are straight at {straight:.4g}, where the force grows"
        " without limit; real fibers give before that."
    )


def warn_extension(strain: Batch, straight: Batch) -> None:
    """Warn of a `strain` [-] past 2 % of extension; fibers are `straight` at that strain [-]."""
    if message := extension_message(strain, straight):
        warn_user(message)


def centerline_points(value: int) -> int:
    """How many points [-] a centerline has."""
    if value < 3:
        raise InvalidInputError("points", "must be at least 3", value)
    return int(value)


def contracting(value: Values) -> Batch:
    """A braid angle [rad] that contracts."""
    value = to_si(value, "braid_angle", "rad")
    try:
        angle = check_interval(value, 0.0, NEUTRAL_ANGLE, "braid_angle", "rad")
    except ValueError:
        if np.asarray(value).dtype.kind not in "fiu":
            raise
        degrees, top = np.degrees(np.asarray(value, dtype=float)), np.degrees(NEUTRAL_ANGLE)
        bad = degrees[~((degrees > 0) & (degrees < top))].flat[0]
        given = math.radians(bad)
        # a number that would do in degrees
        remedy = f'numbers are in rad, write "{given:g} deg"' if math.pi / 2 < given < top else ""
        raise InvalidInputError(
            "braid_angle",
            f"must lie in (0, {top:.4f}) deg to contract",
            bad,
            remedy,
            shown=f"{bad:g} deg",
        ) from None
    check_braid_angle(angle)
    return angle


def thinner(wall_thickness: Batch, outer_radius: Batch) -> None:
    """Refuse a `wall_thickness` [m] that fills the `outer_radius` [m]."""
    t0, r0 = np.broadcast_arrays(np.asarray(wall_thickness), np.asarray(outer_radius))
    if np.any(t0 >= r0):
        worst = np.argmax(t0 >= r0)
        raise InvalidInputError(
            "wall_thickness",
            "must be less than `outer_radius`",
            float(t0.flat[worst]),
            shown=f"{t0.flat[worst]:g} m and {r0.flat[worst]:g} m",
        )


def told(muscle: Any) -> None:
    """Warn of what the tension law of a `muscle` [-] can't know: the highest pressures, sizes that
    it wasn't published for.
    """
    _held(muscle)
    warn_foreign(muscle, stacklevel=4)


def _held(muscle: Any) -> None:
    """Warn of a `muscle` [-] whose tension law has nothing to say of the highest pressures."""
    sizes = (muscle.length, muscle.outer_radius, muscle.braid_angle)
    if not muscle.tension.stretches or not is_concrete(*sizes, muscle.material, muscle.tension):
        return
    bladder = Bladder(Braid(*sizes), muscle.wall_thickness, muscle.material)
    highest = np.min(np.asarray(muscle.tension.highest_pressure(bladder)))
    if highest < HIGHEST_PRESSURE:
        warnings.warn(
            f"`{muscle.tension.name}` holds up to {highest / 1e3:.4g} kPa at rest length: above it"
            " the fibers would stretch further than the law says, and are held there.",
            stacklevel=4,
        )


def chosen(value: Any, kind: type, known: Mapping[str, Any], what: str) -> Any:
    """A law [-] by object or by name; a class stands for its default object."""
    if isinstance(value, kind):
        return value
    if isinstance(value, str):
        law = known[check_choice(value, known, what)]
        return law() if isinstance(law, type) else law
    raise InvalidInputError(
        what, f"must be one of {', '.join(sorted(known))} or an object of {kind.__name__}", value
    )
