"""Length at which a muscle was fitted, stored beside its fields, and a warning at other lengths.

A calibration holds for one length. At another a law without ends gives the same force at rest, and
measured muscles differ: one maker's 10 mm muscle holds 304 N at 83 mm and 441 N at 382 mm.
The length is no part of the muscle: it is compared, compiled and differentiated as any other.

**Source:** both forces were reported by a user; the record is not public. Bolen's law, a fit to
muscles of that kind, gives 292 N and 434 N (`tension.Bolen`).
"""

from typing import Any, TypeVar

import numpy as np

from ..core.module import Module
from ..core.validation import is_concrete
from ..units import exact, pretty


MuscleType = TypeVar("MuscleType", bound=Module)
_FIT_INFO = "_fit_info"  # key of a muscle's `vars`, beside its fields
_TOLERANCE = 0.02  # of the length: two people measure it as closely
END_PARAMETERS = frozenset({"inactive_length", "end_compliance"})


def with_fitted_length(muscle: MuscleType, length: float, ends: bool) -> MuscleType:
    """A `muscle` marked as fitted at a `length` [m]; `ends`: true if its ends were fitted, too."""
    vars(muscle)[_FIT_INFO] = (length, ends)
    return muscle


def copy_fit_info(source: Module, target: MuscleType) -> MuscleType:
    """The `target` muscle, marked with the fitted length of a `source` muscle, if any."""
    if _FIT_INFO in vars(source):
        vars(target)[_FIT_INFO] = vars(source)[_FIT_INFO]
    return target


def fit_info_entries(muscle: Any) -> dict[str, Any]:
    """Entries of the `[calibration]` table of a muscle's file; none of a muscle never fitted."""
    length, ends = _fit_info(muscle)
    entries = {"fitted_length": exact(length, "length")} if length is not None else {}
    return entries | ({"fitted_ends": True} if ends else {})


def fitted_length_mismatch(muscle: Any) -> str:
    """Warning of a muscle that was fitted at another length, else an empty text."""
    length, ends = _fit_info(muscle)
    if length is None or not is_concrete(muscle.length):
        return ""
    lengths = np.asarray(muscle.length)
    if not np.any(np.abs(lengths / length - 1) > _TOLERANCE):
        return ""
    extremes = dict.fromkeys(pretty(float(x), "length") for x in (lengths.min(), lengths.max()))
    return (
        f"The muscle was fitted at a length of {pretty(length, 'length')} and its length is now"
        f" {' to '.join(extremes)}, {_reason(ends)}"
    )


def fitted_length_note(muscle: Any) -> str:
    """Note of the length at which a muscle was fitted, else an empty text."""
    length, ends = _fit_info(muscle)
    if length is None:
        return ""
    return f"All parameters were fitted at a length of {pretty(length, 'length')}, {_reason(ends)}"


def _fit_info(muscle: Any) -> tuple[float | None, bool]:
    """Length [m] at which a muscle was fitted, or `None`, and whether its ends were fitted, too."""
    return vars(muscle).get(_FIT_INFO, (None, False))


def _reason(ends: bool) -> str:
    """Reason why parameters hold at the fitted length alone; `ends`: the ends were fitted, too."""
    if ends:
        return "with its ends: data at one length separate them from the braid angle only in part."
    return (
        "without its ends: force depends on length, one maker's 10 mm muscle holds 304 N at 83 mm"
        " and 441 N at 382 mm."
    )
