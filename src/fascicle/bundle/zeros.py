r"""Zeros of a bundle's force in strain: the first one, and all of them.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain,
onset of buckling, collapse), and before the first free strain all of them pull. So zeros are
looked for in the stretches from there on, to the end of the domain: with most laws all push
beyond the largest free strain, with some a unit may pull again.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from .._arrays import library, maximum, minimum, where
from .._math import root, still
from .._types import AnyArray, Numbers
from .at import Pressurized
from .crossings import changes, cut, sides
from .lists import put, ranked


_MOST_LANES = 2**12  # searches at once
_PAIRS = 2**16  # of units in all of them, which take a search's memory and time: 0.2 GB
_INSET = 1e-7  # of a stretch: its sides are seen from inside
_APART = 1e-13  # free strains closer than this are one

At = Callable[[Any], Pressurized]
Lanes = Float[AnyArray, "lane unit"]


class Zeros(NamedTuple):
    """Strains of zero force [-], rising along the last axis, NaN where there are fewer; whether
    the force falls there; how many there are [-].
    """

    strain: Float[AnyArray, "lane zero"]
    falls: Bool[AnyArray, "lane zero"]
    count: Int[AnyArray, " lane"]


def together(units: int) -> int:
    """How many searches [-] of bundles of so many `units` are made at once."""
    return max(1, min(_MOST_LANES, _PAIRS // units**2))


class _Units(NamedTuple):
    """The bundle's force over strain, unit by unit."""

    here: Pressurized

    def terms(self, lane: Any, strain: Any) -> tuple[Any, Any]:
        """Forces of the units [N] and their slopes [N] at each `strain` [-]."""
        return self.here.of(lane).unit_forces(strain)

    def values(self, lane: Any, strain: Any) -> Any:
        """Their forces alone [N]."""
        return self.terms(lane, strain)[0]


def zeros(at: At, pressures: Lanes) -> Zeros:
    """All zeros of a bundle's force between its plates.

    **Arguments:**

    - `at`: the bundle at pressures [Pa], units on the last axis [-].
    - `pressures`: gauge pressures [Pa].

    **Returns:** strains [-], whether stable, and how many [-].
    """
    step = together(pressures.shape[1])
    if library(pressures) is not np or len(pressures) <= step:
        return _zeros(at, pressures)
    starts = range(0, len(pressures), step)
    parts = [_zeros(at, pressures[start : start + step]) for start in starts]
    return Zeros(*map(np.concatenate, zip(*parts, strict=True)))


def _zeros(at: At, pressures: Lanes) -> Zeros:
    lanes, count = pressures.shape
    most = 2 * count + 1  # a unit adds one dip, before it collapses, so two at most
    live = at(pressures[:, None, :])
    here = still(live)
    low, largest, ends = _ends(here)

    units = _Units(here)
    stretches = sides(units, ends, _INSET)
    looked = cut(units, stretches, stretches.may_cross)
    # at the first free strain all pull, by definition; rounding may say otherwise there
    first = looked.nodes <= low[looked.lane][:, None]
    found = changes(looked._replace(value=where(first, 1.0, looked.value)), lanes * most)
    theta = (live.of(found.lane), where(found.falls, 1.0, -1.0)[:, None])
    bracket = (found.low[:, None], found.high[:, None])
    strain = root(_falling, theta, *bracket, 0.5 * (bracket[0] + bracket[1]))[:, 0]
    # equal units vanish together, where they do
    together = (found.low <= low[found.lane]) & ((largest - low)[found.lane] <= _APART)
    strain = where(together, low[found.lane], strain)
    rank, count = ranked(found.lane, found.total, lanes)
    table = ((lanes, most), (found.lane, rank))
    return Zeros(
        put(np.nan, *table, strain, found.total),
        put(False, *table, found.falls, found.total),
        count,
    )


def first_zero(at: At, pressures: Lanes) -> Float[AnyArray, " lane"]:
    """The smallest of them [-], inf where there is none; arguments as of `zeros`."""
    found = zeros(at, pressures)
    return where(found.count > 0, found.strain[:, 0], np.inf)


def _ends(here: Pressurized) -> tuple[Any, Any, Any]:
    """The least and the largest free strain of each lane [-], and the ends of its stretches."""
    free = here.free_strains
    at_work = library(free)
    low, largest = at_work.min(free, axis=-1), at_work.max(free, axis=-1)
    top = maximum(here.farthest + 0.0 * low, largest)
    kinks = minimum(maximum(here.kinks, low[..., None]), top[..., None])
    ends = at_work.concatenate([*kinks[:, :, 0], top], axis=-1)
    return low[:, 0], largest[:, 0], at_work.sort(ends, axis=-1)


def _falling(theta: tuple[Pressurized, Numbers], strain: Numbers) -> tuple[Numbers, Numbers]:
    """The bundle's force [N], made to fall, and its slope [N] at `strain` [-]."""
    here, sense = theta
    force, slope = here.force(strain)
    return sense * force, sense * slope
