"""The length at which a muscle was fitted, kept beside it, and a line where it gets another.

A calibration is of one length. To another a law without ends gives the same force at rest, and
measured muscles say otherwise: one maker's 10 mm muscle holds 304 N at 83 mm and 441 N at 382 mm.
The length is no part of the muscle: it is compared, compiled and differentiated as any other.

**Source:** of both forces a report to this project; the record is not in its reach. Bolen's law, a
fit to muscles of that kind, says 292 N and 434 N (`tension.Bolen`).
"""

import warnings
from typing import Any, TypeVar

import numpy as np

from ..core.module import Module, replace_checked
from ..core.validation import is_concrete
from ..units import exact, pretty


Fitted = TypeVar("Fitted", bound=Module)
_KEY = "fitted at"
_SAME = 0.02  # of the length: as far as two people measure it apart
OF_ENDS = frozenset({"inactive_length", "end_compliance"})


def remembering(muscle: Fitted, length: float, ends: bool) -> Fitted:
    """The same `muscle` [-], which remembers the `length` at which it was fitted [m], and whether
    its `ends` were fitted, too [-].
    """
    muscle.store[_KEY] = (length, ends)
    return muscle


def carried(old: Module, new: Fitted) -> Fitted:
    """The `new` muscle [-] with what the `old` one [-] remembers."""
    if _KEY in old.store:
        new.store[_KEY] = old.store[_KEY]
    return new


def replaced(old: Fitted, changes: dict[str, Any]) -> Fitted:
    """The `old` muscle [-] but for `changes` of its arguments [SI], with what it remembers; a
    length that it wasn't fitted at warns.
    """
    new = carried(old, replace_checked(old, changes))
    if "length" in changes:
        warn_elsewhere(new, stacklevel=4)
    return new


def memory(muscle: Any) -> dict[str, Any]:
    """What a `muscle` [-] remembers, as the `[calibration]` of its file has it [-]; empty where it
    wasn't fitted.
    """
    length, ends = _fit(muscle)
    if length is None:
        return {}
    return {"fitted_length": exact(length, "length"), **({"fitted_ends": True} if ends else {})}


def elsewhere(muscle: Any) -> str:
    """What to know of a `muscle` [-] that was fitted at another length [-]; empty where it wasn't
    fitted, or at this one.
    """
    length, ends = _fit(muscle)
    if length is None or not is_concrete(muscle.length):
        return ""
    own = np.asarray(muscle.length)
    if not np.any(np.abs(own / length - 1) > _SAME):
        return ""
    now = " to ".join(dict.fromkeys(pretty(float(x), "length") for x in (own.min(), own.max())))
    return (
        f"The muscle was fitted at a length of {pretty(length, 'length')} and has {now} now,"
        f" {_why(ends)}"
    )


def holds_at(muscle: Any) -> str:
    """At which length a fitted `muscle` [-] was fitted, and why that matters [-]; empty where it
    wasn't.
    """
    length, ends = _fit(muscle)
    if length is None:
        return ""
    return f"All of it was fitted at a length of {pretty(length, 'length')}, {_why(ends)}"


def _fit(muscle: Any) -> tuple[float | None, bool]:
    """At which length [m] a muscle was fitted, none where it wasn't, and whether its ends were."""
    return muscle.store.get(_KEY, (None, False))


def _why(ends: bool) -> str:
    if ends:
        return "its ends too: one length tells them only as far as no braid angle does the same."
    return (
        "without its ends: force goes with length, one maker's 10 mm muscle holds 304 N at 83 mm"
        " and 441 N at 382 mm."
    )


def warn_elsewhere(muscle: Any, stacklevel: int = 3) -> None:
    """Warn of a `muscle` [-] that was fitted at another length; `stacklevel`: of the caller [-]."""
    if told := elsewhere(muscle):
        warnings.warn(told, stacklevel=stacklevel)
