"""Checks of a muscle's arguments: sizes, pressures and strains of its domain, and its limitations.

Laws trust what has passed here.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import (
    HIGHEST_PRESSURE,
    LARGEST_STRAIN,
    NEUTRAL_ANGLE,
    Range,
    broadcast_shape,
    check_choice,
    check_gauge_pressure,
    check_interval,
    check_plausible,
    is_concrete,
    match_array_type,
    to_si,
    warn_user,
)
from ..units import exact, pretty
from .materials import MATERIALS, AbstractMaterial
from .tension import AbstractTension
from .tuning import Tuning


if TYPE_CHECKING:
    from .muscle import Muscle
    from .piecewise import Piecewise


# (r/r0)² = ε(2 − ε)/tan²α0 + 1 is right to about 1e-16/tan²α0 there, and rises from zero by
# 2 cosα0/sin²α0 times this: ten million times as much at any angle
_STRAIGHT_MARGIN = 1e-9
# a stretched muscle is rarely measured past this; a sign error is: published tests begin at rest
EXTENSION_WARNED = 0.02
_NOMINAL = 0.1  # relative: sizes in catalogs are no closer to what calipers measure
_BEAM = 7.0  # length over radius, below which beams' theory ends: sections don't stay plane
# length over radius of a muscle as long as wide. It is warned about, not refused: fits and designs
# pass through such sizes, and every law is finite there
_DISK = 2.0
# a braid locks where its fibers touch, at 10 deg or more; the law's own end is at 54.7356 deg
_ANGLE = Range("deg", 1.0, 8.0, 52.0, math.inf)
LENGTH_TOLERANCE = 0.02  # of a fitted length: two people measure it as closely
END_PARAMETERS = frozenset({"inactive_length", "end_compliance"})
_LARGEST_RATIO = 1.5  # of the bladder's strain to the muscle's: a third of the length inactive


def choose_material(value: AbstractMaterial | str) -> AbstractMaterial:
    """Material given as an object or by name; `InvalidInputError` for others."""
    if isinstance(value, AbstractMaterial):
        return value
    if isinstance(value, str):
        return MATERIALS[check_choice(value, MATERIALS, "material")]
    rule = f"must be one of {', '.join(sorted(MATERIALS))} or an object of AbstractMaterial"
    raise InvalidInputError("material", rule, value)


def choose_tuning(value: Tuning | None) -> Tuning:
    """Tuning given as an object, or none; `InvalidInputError` for others."""
    if not isinstance(value, Tuning | None):
        raise InvalidInputError("tuning", "must be a Tuning or None", value)
    return Tuning() if value is None else value


def lowest_strain(law: "Piecewise") -> Batch:
    """Strain [-] of straight fibers by a force `law`, and a margin; -inf for a traced one."""
    angle, ratio = law.tension.bladder.braid.angle, law.tension.strain_ratio
    if not is_concrete(angle, ratio):
        return -np.inf
    # fibers that are straight within rounding have no radius, and no finite force
    return (1 - 1 / np.cos(np.asarray(angle))) / np.asarray(ratio) + _STRAIGHT_MARGIN


def validate_point(muscle: "Muscle", pressure: Values, strain: Values) -> tuple[Batch, Batch]:
    """`pressure` [Pa] and `strain` [-] as floats, if in a muscle's domain and broadcasting."""
    P = validate_pressure(muscle, pressure)
    eps = validate_strain(strain, muscle.law)
    if np.ndim(P) or np.ndim(eps):  # numbers go with any rows of muscles
        check_broadcast(P, eps, batch=muscle.batch_shape)
    return P, eps


def check_broadcast(*arrays: Batch, batch: tuple[int, ...] = ()) -> None:
    """Refuse pressures and strains that don't broadcast with one another and a `batch`."""
    names = ("pressure", "strain") if len(arrays) == 2 else ("values",)
    shapes = dict(zip(names, map(np.shape, arrays), strict=True))
    if batch:
        broadcast_shape(muscles=batch, **shapes)
    broadcast_shape(**shapes)


def validate_pressure(muscle: "Muscle", value: Values) -> Batch:
    """Return a gauge pressure [Pa] of the domain; warn of one above the range of the tuning."""
    pressure = check_gauge_pressure(value)
    muscle.tuning.warn_extrapolation(pressure)
    return pressure


def validate_strain(value: Values, law: "Piecewise") -> Batch:
    """Return a strain [-] if a muscle's force `law` is valid there; warn of an extension."""
    return check_strain(value, lowest_strain(law))


def check_strain(
    value: Values,
    low: Batch,
    high: Batch = LARGEST_STRAIN,
    why: str = "(fibers straight at the lower end)",
) -> Batch:
    """Return a strain `value` [-] as floats if it lies between `low` and `high` [-]; warn of an
    extension. `low` may be an array, of rows of muscles; `why`: reason of the limits, in words.
    """
    if np.ndim(low):
        value = to_si(value, "strain", "-")
        broadcast_shape(muscles=np.shape(low), strain=np.shape(value))
    strain = check_interval(value, low, high, "strain", "-", why, (False, True))
    warn_user(extension_message(strain, low))
    return match_array_type(value, strain)


def extension_message(strain: Batch, straight: Batch) -> str:
    """Warning of a `strain` [-] below -2 %, else an empty text; `straight`: its limit [-]."""
    if not is_concrete(strain) or not np.size(strain):
        return ""
    strains, limits = np.broadcast_arrays(np.asarray(strain), np.asarray(straight))
    worst = np.argmin(strains)
    lowest = strains.flat[worst]
    if not lowest < -EXTENSION_WARNED:
        return ""
    return (
        f"Strain {lowest:g} stretches the muscle by {-lowest:.3g} times its length: contraction is"
        f" positive. The braid's fibers are straight at {limits.flat[worst]:.4g}, where the force"
        " grows without limit; real fibers give before that."
    )


def validate_braid_angle(value: Values) -> Batch:
    """Return a braid angle [rad] of a muscle that contracts."""
    value = to_si(value, "braid_angle", "rad")
    try:
        angle = check_interval(value, 0.0, NEUTRAL_ANGLE, "braid_angle", "rad")
    except ValueError:
        if np.asarray(value).dtype.kind not in "fiu":
            raise
        degrees, top = np.degrees(np.asarray(value, dtype=float)), np.degrees(NEUTRAL_ANGLE)
        bad = degrees[~((degrees > 0) & (degrees < top))].flat[0]
        number = math.radians(bad)
        # a number that would be usual in degrees
        is_degrees = _ANGLE.low <= number < top
        remedy = f'numbers are in rad, write "{number:g} deg"' if is_degrees else ""
        if top <= bad < 90:
            remedy = (
                "above it a muscle lengthens (an extensor), which fascicle doesn't model; the ideal"
                " force, equation (3) of the theory page on the braid, holds for it, too"
            )
        rule = f"must lie in (0, {top:.4f}) deg to contract"
        raise InvalidInputError("braid_angle", rule, bad, remedy, shown=f"{bad:g} deg") from None
    check_plausible(np.degrees(angle) if is_concrete(angle) else angle, "braid_angle", _ANGLE)
    return angle


def check_muscle(muscle: "Muscle") -> None:
    """Refuse sizes of a `muscle` that can't be together, and warn of those its laws don't fit."""
    t0, r0, ratio = (
        muscle.wall_thickness,
        muscle.outer_radius,
        muscle.ends.strain_ratio(muscle.length),
    )
    if is_concrete(t0, r0) and np.any(np.asarray(t0) >= r0):
        t0, r0 = np.broadcast_arrays(t0, r0)
        bad, limit = (float(x[t0 >= r0].flat[0]) for x in (t0, r0))
        rule = "must be less than `outer_radius`"
        text = f"{pretty(bad, 'length')} and {pretty(limit, 'length')}"
        raise InvalidInputError("wall_thickness", rule, bad, shown=text)
    warn_user(proportions_message(muscle.length, muscle.outer_radius))
    if is_concrete(ratio) and not np.all((np.asarray(ratio) >= 1) & (ratio < _LARGEST_RATIO)):
        rule = "must be less than a third of `length`"
        value = getattr(muscle.ends, "inactive_length", None)
        raise InvalidInputError("inactive_length", rule, value, "check its unit")
    warn_user(stretched_fibers_message(muscle))
    warn_user(published_range_message(muscle))


def proportions_message(length: Batch, outer_radius: Batch) -> str:
    """Warning of a `length` [m] too short for its `outer_radius` [m], else an empty text."""
    if not is_concrete(length, outer_radius):
        return ""
    lengths, radii = np.broadcast_arrays(np.asarray(length), np.asarray(outer_radius))
    worst = np.argmin(lengths / radii)
    L0, r0 = lengths.flat[worst], radii.flat[worst]
    if not L0 / r0 < _BEAM:
        return ""
    effect = (
        "a muscle shorter than it is wide is unusual, and the laws ignore end effects."
        " Check both units."
        if L0 / r0 < _DISK
        else f"below {_BEAM:g}, beam theory does not apply; results past the free strain are"
        " unreliable."
    )
    return f"`length` {L0:g} m is {L0 / r0:.3g} times `outer_radius` {r0:g} m: {effect}"


def stretched_fibers_message(muscle: "Muscle") -> str:
    """Warning of a muscle whose fibers stretch too far below 1 MPa, else an empty text."""
    sizes = (muscle.length, muscle.outer_radius, muscle.braid_angle)
    if not muscle.tension.stretches or not is_concrete(*sizes, muscle.material, muscle.tension):
        return ""
    highest = np.min(np.asarray(muscle.tension.highest_pressure(muscle.bladder)))
    if not highest < HIGHEST_PRESSURE:
        return ""
    return (
        f"`{muscle.tension.name}` is valid up to {highest / 1e3:.4g} kPa at rest length: above it"
        " the fibers would stretch further than the law allows, and their stretch is kept constant."
    )


def published_range_message(muscle: "Muscle", law: type[AbstractTension] | None = None) -> str:
    """Warning of a `muscle` unlike the one for which its tension law, or another `law`, was
    published, else an empty text. Constants that the user has fitted or written are accepted.
    """
    kind = type(muscle.tension) if law is None else law
    sizes = (muscle.length, muscle.outer_radius, muscle.wall_thickness)
    if not kind.reference_muscle or not is_concrete(*sizes):
        return ""
    if law is None and not (is_concrete(muscle.tension) and muscle.tension == kind()):
        return ""
    differences = []
    diameter, length = kind.reference_diameter, kind.reference_length
    outer = 2 * np.asarray(muscle.outer_radius)  # makers name the inner diameter or the braid's
    inner = outer - 2 * np.asarray(muscle.wall_thickness)
    nearest = np.clip(diameter or 0.0, inner, outer)
    if diameter is not None and np.any(np.abs(diameter - nearest) > _NOMINAL * nearest):
        differences.append(f"{_size_text(2 * muscle.outer_radius)} in diameter")
    if length is not None and np.any(np.abs(np.asarray(muscle.length) / length - 1) > _NOMINAL):
        differences.append(f"{_size_text(muscle.length)} long")
    if not differences:
        return ""
    return (
        f"`{kind.name}` was fitted to {kind.reference_muscle}; this muscle is"
        f" {' and '.join(differences)}. Results are an extrapolation unless you recalibrate"
        " (`fascicle calibrate`)."
    )


def _size_text(value: Batch) -> str:
    """Text of a length [m], or from the least to the largest of several."""
    low, high = (pretty(float(x), "length", 3) for x in (np.min(value), np.max(value)))
    return low if low == high else f"{low} to {high}"


class FittedLength(NamedTuple):
    """`length` [m] at which a muscle was fitted; `with_ends`: true if its ends were fitted, too.

    At another length a law without ends gives the same force at rest, and measured muscles differ.
    """

    length: float
    with_ends: bool = False


def fit_info_entries(muscle: "Muscle") -> dict[str, Values]:
    """Entries of the `[calibration]` table of a muscle's file; none of a muscle never fitted."""
    fitted = muscle.fitted_length
    if fitted is None:
        return {}
    entries: dict[str, Values] = {"fitted_length": exact(fitted.length, "length")}
    return entries | ({"fitted_ends": True} if fitted.with_ends else {})


def fitted_length_mismatch(muscle: "Muscle") -> str:
    """Warning of a muscle that was fitted at another length, else an empty text."""
    if muscle.fitted_length is None or not is_concrete(muscle.length):
        return ""
    length, ends = muscle.fitted_length
    lengths = np.asarray(muscle.length)
    if not np.any(np.abs(lengths / length - 1) > LENGTH_TOLERANCE):
        return ""
    extremes = dict.fromkeys(pretty(float(x), "length") for x in (lengths.min(), lengths.max()))
    return (
        f"The muscle was fitted at a length of {pretty(length, 'length')} and its length is now"
        f" {' to '.join(extremes)}, {_reason(ends)}"
    )


def fitted_length_note(muscle: "Muscle") -> str:
    """Note of the length at which a muscle was fitted, else an empty text."""
    if muscle.fitted_length is None:
        return ""
    length, ends = muscle.fitted_length
    return f"All parameters were fitted at a length of {pretty(length, 'length')}, {_reason(ends)}"


def _reason(ends: bool) -> str:
    """Reason why parameters hold at the fitted length alone; `ends`: the ends were fitted, too."""
    if ends:
        return "with its ends: data at one length separate them from the braid angle only in part."
    return (
        "without its ends: force depends on length, one maker's 10 mm muscle holds 304 N at 83 mm"
        " and 441 N at 382 mm."
    )
