"""Published constants of one maker's muscle, and a line where another muscle has them.

A law that is fitted to measured forces says those of the muscle that was measured. Nothing in it
tells what they are of another diameter or length. Constants that somebody has fitted or written
are that one's own, and nothing is said of them.
"""

import warnings
from typing import Any

import numpy as np

from ..core.validation import is_concrete
from ..units import pretty
from .tension.tension_law import AbstractTension


_NOMINAL = 0.1  # of a size: names of catalogs are no closer to what calipers find


def foreign(muscle: Any, law: type[AbstractTension] | None = None) -> str:
    """Of whom the constants of a `muscle`'s [-] tension law are, in words [-]; empty where they
    are its own, or of a muscle of its size. `law`: another one than the muscle's, as published [-].
    """
    kind = type(muscle.tension) if law is None else law
    if not kind.made_for or not is_concrete(
        muscle.length, muscle.outer_radius, muscle.wall_thickness
    ):
        return ""
    if law is None and not _as_published(muscle.tension):
        return ""
    told = [*_width(muscle, kind.made_diameter), *_length(muscle, kind.made_length)]
    if not told:
        return ""
    return (
        f"`{kind.name}` has the numbers of {kind.made_for}, and this muscle is"
        f" {' and '.join(told)}: what it says here nobody has measured, unless its constants are"
        " fitted to this muscle (`fascicle calibrate`)."
    )


def warn_foreign(muscle: Any, stacklevel: int = 3) -> None:
    """Warn of a `muscle` [-] that has another one's constants; `stacklevel`: of the caller [-]."""
    if told := foreign(muscle):
        warnings.warn(told, stacklevel=stacklevel)


def as_wide(muscle: Any, diameter: float) -> bool:
    """Whether a `muscle` [-] is as wide as one of a nominal `diameter` [m]: makers name the inner
    diameter or the braid's.
    """
    outer = 2 * np.asarray(muscle.outer_radius)
    inner = outer - 2 * np.asarray(muscle.wall_thickness)
    return bool(np.all((inner * (1 - _NOMINAL) <= diameter) & (diameter <= outer * (1 + _NOMINAL))))


def _width(muscle: Any, diameter: float | None) -> list[str]:
    if diameter is None or as_wide(muscle, diameter):
        return []
    return [f"{_size(2 * muscle.outer_radius)} wide"]


def _length(muscle: Any, length: float | None) -> list[str]:
    if length is None or np.all(np.abs(np.asarray(muscle.length) / length - 1) <= _NOMINAL):
        return []
    return [f"{_size(muscle.length)} long"]


def _size(value: Any) -> str:
    low, high = (pretty(float(x), "length", 3) for x in (np.min(value), np.max(value)))
    return low if low == high else f"{low} to {high}"


def _as_published(law: AbstractTension) -> bool:
    """Whether all constants of a `law` [-] can be looked at, and are its default ones."""
    return is_concrete(law) and all(
        np.all(np.asarray(getattr(law, one.name)) == one.default) for one in law.constants()
    )
