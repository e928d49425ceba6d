r"""Muscles of unlike length between the same plates: what each one's strain is.

Plates at rest a distance $L$ apart, moved to $L (1 - \varepsilon)$, give a muscle of length
$L_i$ at rest the strain

$$\varepsilon_i = 1 - \frac{L}{L_i} (1 - \varepsilon), \tag{B7}$$

so a longer muscle is slack, or buckled, where a shorter one is still at rest, and a muscle
that is shorter than $L$ is stretched from the start. **Valid** while no muscle's fibers are
straight as long as another one isn't pulled.
"""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import LARGEST_STRAIN, check_size, is_concrete, traced_floats
from ..muscle import Muscle
from ..muscle.validation import check_strain, lowest_strain, strain_domain


def muscle_strain(ratio: Batch, strain: Batch) -> Batch:
    """A muscle's contraction [-] at the plates' `strain` [-]; `ratio`: $L/L_i$ [-], (B7)."""
    return 1 - ratio * (1 - strain)


def plate_strain(ratio: Batch, strain: Batch) -> Batch:
    """The plates' contraction [-] at a muscle's `strain` [-]; `ratio`: $L/L_i$ [-]."""
    return 1 - (1 - strain) / ratio


def plate_distance(length: Values, muscles: Sequence[Muscle]) -> Batch | None:
    """The distance between the plates at rest, where it isn't simply the muscles' length.

    **Arguments:**

    - `length`: the distance [m], or `None` for the muscles' common length.
    - `muscles`: between the plates [-].

    **Returns:** the distance [m], or `None` where all muscles are as long.

    **Raises:** `ValueError` for unlike lengths and no distance, and for muscles that no
    plates can hold together.
    """
    lengths = [muscle.length for muscle in muscles]
    if length is None:
        if is_concrete(*lengths):
            _equal(lengths)
        return None
    L = check_size(length, "length")
    if not is_concrete(L, *lengths):
        return L
    if all(np.array_equal(np.broadcast_arrays(L, one)[0], one) for one in lengths):
        return None
    if is_concrete(*(muscle.braid_angle for muscle in muscles)):
        _reachable(L, muscles)
    return L


def within_reach(strain: Values, length: Batch, muscles: Sequence[Muscle]) -> Batch:
    """Return the plates' `strain` as a float array, refusing what leaves a muscle's domain.

    **Arguments:**

    - `strain`: the plates' contraction [-].
    - `length`: their distance at rest [m].
    - `muscles`: between them [-].

    **Returns:** the strain [-].

    **Raises:** `ValueError` for a concrete strain at which a muscle's own is off the domain.
    """
    if not is_concrete(length, *((muscle.length, muscle.braid_angle) for muscle in muscles)):
        return traced_floats(strain)
    low: Batch = np.float64(-np.inf)
    high: Batch = np.float64(np.inf)
    for muscle in muscles:
        ratio = np.asarray(length / muscle.length)
        straight = lowest_strain(*strain_domain(muscle))
        low = np.maximum(low, plate_strain(ratio, straight))
        high = np.minimum(high, plate_strain(ratio, LARGEST_STRAIN))
    return check_strain(strain, low, high, "(every muscle in its domain, seen from the plates)")


def _reachable(length: Batch, muscles: Sequence[Muscle]) -> None:
    """Refuse muscles of which one is overstretched before another one is even taut."""
    longest = reduce(np.maximum, [np.asarray(m.length) for m in muscles], np.asarray(length))
    for i, muscle in enumerate(muscles, start=1):
        straight = np.asarray(muscle.length) / np.cos(np.asarray(muscle.braid_angle))
        if np.any(longest >= straight):
            raise InvalidInputError(
                "length",
                f"and the muscles' must stay below {float(np.min(straight)):g} m, where unit {i}'s"
                " fibers are straight",
                float(np.max(longest)),
                "take lengths that are nearer to each other",
                shown=f"{float(np.max(longest)):g} m",
            )


def _equal(lengths: Sequence[Batch]) -> None:
    first = np.asarray(lengths[0])
    for i, length in enumerate(lengths[1:], start=2):
        if not np.allclose(length, first, rtol=1e-9, atol=0):
            raise InvalidInputError(
                "motor_units",
                "must hold muscles of one length, or `length` say how far apart the plates are at"
                " rest, in m",
                float(np.max(np.asarray(length))),
                shown=f"{float(np.max(first)):g} m in unit 1 and"
                f" {float(np.max(np.asarray(length))):g} m in unit {i}",
            )
