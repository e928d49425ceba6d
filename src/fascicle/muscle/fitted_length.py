"""Length at which a muscle was fitted, and a warning at other lengths.

A calibration holds for one length. At another a law without ends gives the same force at rest, and
measured muscles differ: one maker's 10 mm muscle holds 304 N at 83 mm and 441 N at 382 mm.

**Source:** both forces were reported by a user; the record is not public. Bolen's law, a fit to
muscles of that kind, gives 292 N and 434 N (`tension.Bolen`).
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.validation import is_concrete
from ..units import exact, pretty


_TOLERANCE = 0.02  # of the length: two people measure it as closely
END_PARAMETERS = frozenset({"inactive_length", "end_compliance"})


class FittedLength(NamedTuple):
    """`length` [m] at which a muscle was fitted; `with_ends`: true if its ends were fitted, too."""

    length: float
    with_ends: bool = False


def fit_info_entries(muscle: Any) -> dict[str, Any]:
    """Entries of the `[calibration]` table of a muscle's file; none of a muscle never fitted."""
    fitted = muscle.fitted_length
    if fitted is None:
        return {}
    entries: dict[str, Any] = {"fitted_length": exact(fitted.length, "length")}
    return entries | ({"fitted_ends": True} if fitted.with_ends else {})


def fitted_length_mismatch(muscle: Any) -> str:
    """Warning of a muscle that was fitted at another length, else an empty text."""
    if muscle.fitted_length is None or not is_concrete(muscle.length):
        return ""
    length, ends = muscle.fitted_length
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
