r"""Strains at which a bundle gives a force: of none, the first one and all, and of any force.

A bundle's force at fixed pressures is smooth between the kinks of its units (free strain,
onset of buckling, collapse), and before the first free strain all of them pull. So zeros are
looked for in the stretches from there on, to the end of the domain: with most laws all push
beyond the largest free strain, with some a unit may pull again. Other forces are looked for from
where a muscle's fibers are straight.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, isfinite, maximum, minimum, where
from ..core.roots import find_root, refine_root, stop_gradient
from ..core.types import AnyArray, Bool, Float, Int, Numbers
from .at import Pressurized
from .crossings import Cut, changes, cut, sides
from .first import APART, INSET, LANES, first
from .lanes import Lanes
from .lists import put, ranked


_MOST_LANES = 2**12  # searches at once
_PAIRS = 2**16  # of units in all of them, which take a search's memory and time: 0.2 GB


class Zeros(NamedTuple):
    """Strains of that force [-], rising along the last axis, NaN where there are fewer; whether
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


class _Loaded(NamedTuple):
    """The same less a `load` [N] that each lane holds."""

    units: _Units
    load: Numbers

    def terms(self, lane: Any, strain: Any) -> tuple[Any, Any]:
        """Forces of the units, the load's among them [N], and their slopes [N]."""
        force, slope = self.units.terms(lane, strain)
        at_work, held = array_namespace(force, self.load), -self.load[lane][:, None, None]
        held = at_work.broadcast_to(held, (*force.shape[:-1], 1))
        pairs = ((force, held), (slope, 0.0 * held))
        return tuple(at_work.concatenate(pair, axis=-1) for pair in pairs)

    def values(self, lane: Any, strain: Any) -> Any:
        """Forces alone [N]."""
        return self.terms(lane, strain)[0]


def zeros(lanes: Lanes) -> Zeros:
    """All zeros of a bundle's force between its plates.

    **Arguments:** `lanes`: the bundle at pressures [-].

    **Returns:** strains [-], whether stable, and how many [-].
    """
    return _in_blocks(_zeros, lanes)


def loaded(lanes: Lanes, load: Float[AnyArray, " lane"]) -> Zeros:
    """All strains at which a bundle holds a load.

    **Arguments:**

    - `lanes`: the bundle at pressures [-].
    - `load`: what it pulls with [N].

    **Returns:** strains [-], whether stable, and how many [-].
    """
    return _in_blocks(_loaded, lanes, load)


def _in_blocks(search: Callable[..., Zeros], lanes: Lanes, *load: Numbers) -> Zeros:
    count, units = lanes.pressures.shape
    step = together(units)
    if not lanes.at_once or array_namespace(*load) is not np or count <= step:
        return search(lanes, *load)
    blocks = (slice(start, start + step) for start in range(0, count, step))
    parts = [search(lanes.of(block), *(x[block] for x in load)) for block in blocks]
    return Zeros(*map(np.concatenate, zip(*parts, strict=True)))


def _zeros(lanes: Lanes) -> Zeros:
    live = lanes.live
    here = stop_gradient(live)
    low, largest, ends = _ends(here)
    units = _Units(here)
    stretches = sides(units, ends, INSET)
    looked = cut(units, stretches, stretches.may_cross)
    # at the first free strain all pull, by definition; rounding may say otherwise there
    first = looked.nodes <= low[looked.lane][:, None]
    looked = looked._replace(value=where(first, 1.0, looked.value))

    def settled(lane: Any, before: Any, strain: Any) -> Any:
        # equal units vanish together, where they do
        alike = (before <= low[lane]) & ((largest - low)[lane] <= APART)
        return where(alike, low[lane], strain)

    return _solved(live, 0.0 * largest, looked, lanes.pressures.shape, settled)


def _loaded(lanes: Lanes, load: Any) -> Zeros:
    live = lanes.live
    here, held = stop_gradient((live, load))
    curves = _Loaded(_Units(here), held)
    stretches = sides(curves, _all_ends(here), INSET)
    looked = cut(curves, stretches, stretches.may_cross)
    return _solved(live, load, looked, lanes.pressures.shape)


def _solved(
    live: Pressurized,
    load: Any,
    looked: Cut,
    shape: tuple[int, ...],
    settled: Callable | None = None,
) -> Zeros:
    lanes, units = shape
    most = 2 * units + 1  # a unit adds one dip, before it collapses, so two at most
    found = changes(looked, lanes * most)
    sense = where(found.falls, 1.0, -1.0)[:, None]
    theta = (live.of(found.lane), sense, load[found.lane][:, None])
    bracket = (found.low[:, None], found.high[:, None])
    middle = 0.5 * (bracket[0] + bracket[1])
    strain = find_root(_falling, *stop_gradient((theta, *bracket, middle)))
    if settled is not None:
        strain = settled(found.lane, found.low, strain[:, 0])[:, None]
    strain = refine_root(_falling, theta, strain)[:, 0]
    rank, count = ranked(found.lane, found.total, lanes)
    table = ((lanes, most), (found.lane, rank))
    return Zeros(
        put(np.nan, *table, strain, found.total),
        put(False, *table, found.falls, found.total),
        count,
    )


def carried(live: Pressurized, load: Numbers, strain: Numbers) -> Numbers:
    """Strains at which a bundle holds a load, with their derivatives.

    **Arguments:**

    - `live`: the bundle at pressures, with an axis of one ahead of units [-].
    - `load`: what it pulls with [N], with an axis of one.
    - `strain`: found, without derivatives [-]; where it is not finite there is none.

    **Returns:** the same strains [-].
    """
    there = isfinite(strain)
    theta, x = (live, 1.0, load), where(there, strain, 0.0)
    return where(there, refine_root(_falling, theta, x), strain)


def first_zero(lanes: Lanes) -> Float[AnyArray, " lane"]:
    """The smallest of them [-], inf where there is none; arguments as of `zeros`."""
    if not lanes.at_once:
        return _smallest(zeros(lanes))
    count, units = lanes.pressures.shape
    strain, sure = np.zeros(count), np.zeros(count, bool)
    step = max(1, LANES // units)
    for some in (slice(start, start + step) for start in range(0, count, step)):
        strain[some], sure[some] = first(lanes.of(some).live)
    if not np.all(sure):
        strain[~sure] = _smallest(zeros(lanes.of(~sure)))
    return strain


def _smallest(found: Zeros) -> Any:
    return where(found.count > 0, found.strain[:, 0], np.inf)


def _ends(here: Pressurized) -> tuple[Any, Any, Any]:
    """The least and the largest free strain of each lane [-], and the ends of its stretches."""
    free = here.free_strains
    at_work = array_namespace(free)
    low, largest = at_work.min(free, axis=-1), at_work.max(free, axis=-1)
    top = maximum(here.farthest + 0.0 * low, largest)
    kinks = minimum(maximum(here.kinks, low[..., None]), top[..., None])
    ends = at_work.concatenate([*kinks[:, :, 0], top], axis=-1)
    return low[:, 0], largest[:, 0], at_work.sort(ends, axis=-1)


def _all_ends(here: Pressurized) -> Any:
    """The ends of each lane's stretches [-] from straight fibers to the end of the domain."""
    at_work = array_namespace(here.free_strains)
    none = 0.0 * here.free_strains[..., 0]
    bottom, top = here.nearest + none, here.farthest + none
    kinks = minimum(maximum(here.kinks, bottom[..., None]), top[..., None])
    return at_work.sort(at_work.concatenate([bottom, *kinks[:, :, 0], top], axis=-1), axis=-1)


def _falling(theta: tuple, strain: Numbers) -> tuple[Numbers, Numbers]:
    """The bundle's force beyond a load [N], made to fall, and its slope [N] at `strain` [-]."""
    here, sense, load = theta
    force, slope = here.force(strain)
    return sense * (force - load), sense * slope
