r"""The first strain at which a bundle's force vanishes, found without looking at all others.

Before the least free strain all units pull, at the largest none does. Between them the kinks of
all units (free strain, onset of buckling, collapse) are halved to two neighbors, from a force $F$
that pulls to one that doesn't. That it pulls everywhere before is proved by its units $F_i$, from
$a$ to $b$, wherever it does so at $b$:

$$\sum_i \max F_i' < 0 \quad\text{or}\quad \sum_i \min F_i > 0. \tag{B13}$$

Both are seen at $a$, at $b$ and on both sides of the unit's own kinks between them, with a margin
where a unit comes to pull more again. Between the two neighbors $F$ vanishes once if it falls.
What can't be proved so isn't called sure, and every stretch is to be looked at, as `zeros` does.

Compiled, only what costs no lane much is tried: the rest is left to NumPy.
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, maximum, minimum, where
from ..core.roots import guarded
from ..core.types import Marks, Numbers, Whole
from .at import Pressurized
from .lists import repeated


# lanes times units after which a search is compiled: NumPy takes 5 µs for each, a compiled search
# a fourth of it after 5 s of compiling, which these are worth, at once or one after the other
MANY = 2**20
LANES = 2**12  # times units, at once: their arrays stay in the cache
APART = 1e-13  # free strains closer than this are one
_MARGIN = 0.25  # of what a unit spans between two places, below both
INSET = 1e-7  # of a stretch: its side is seen from inside
_BESIDE = 1e-9  # of strain: a kink is seen from behind
_STEPS = 60  # toward a zero, at most: halving alone would need 53
_NEAR = 1e-8  # a Newton step this short leaves nothing but rounding


class First(NamedTuple):
    """The first zero of each lane [-], and whether it is `sure` that none lies before it."""

    strain: Numbers
    sure: Marks


def first(here: Pressurized) -> First:
    """The first zero of a bundle's force.

    **Arguments:** `here`: the bundle at pressures, lanes and an axis of one ahead of units [-].

    **Returns:** a strain for each lane [-], and whether it is sure.
    """
    at_work = array_namespace(here.free_strains)
    free, *turns = (kink[:, 0] for kink in (here.free_strains, *here.turns))
    low, top = at_work.min(free, axis=1), at_work.max(free, axis=1)
    ends = minimum(at_work.concatenate([free, *turns], axis=1), top[:, None])
    before, behind = _halved(here, at_work.sort(ends, axis=1))
    sides = at_work.stack([before + INSET * (behind - before), behind], axis=1)

    # the sides, the beginning, and each unit at its own kinks: all at once
    kinks = [minimum(kink + step, sides[:, :1]) for kink in turns for step in (0.0, _BESIDE)]
    places = at_work.concatenate([sides, low[:, None]], axis=1)[..., None] + 0.0 * free[:, None]
    every = at_work.concatenate([places, *(x[:, None] for x in kinks)], axis=1)
    seen = here.forces_apart(every)
    force, slope = (x[:, :2] for x in seen)
    totals = force.sum(axis=-1), slope.sum(axis=-1)
    found = _met(here, sides, *totals)

    over, under = totals[0].T
    once = _steepest(slope[:, 0], slope[:, 1]).sum(axis=-1) < 0
    smooth = behind < here.fold[:, 0]  # slopes don't tell of a jump
    alike = top - low <= APART  # equal units vanish together
    sure = (over > 0) & (under <= 0) & once & smooth & _pulls(here, low, sides[:, :1], kinks, seen)
    return First(where(alike, low, found), alike | sure)


def _halved(here: Pressurized, ends: Numbers) -> tuple[Numbers, Numbers]:
    """Of each lane's `ends` [-], two neighbors: it pulls at one, and doesn't at the next. It does
    so at the first of all, and at the last it doesn't.
    """

    def step(_: Any, entry: tuple, state: tuple) -> tuple:
        (lane, ends), (pulls, pushes) = entry, state
        middle = (pulls + pushes) // 2
        still = _force(here, lane, _picked(ends, middle))[0] > 0
        return where(still, middle, pulls), where(still, pushes, middle)

    def ended(_: tuple, state: tuple) -> Any:
        return state[1] - state[0] <= 1

    count = ends.shape[1]
    none = array_namespace(ends).zeros(len(ends), int)
    entries = (_lanes(ends), ends)
    pulls, pushes = repeated(step, entries, (none, none + count - 1), ended, count)
    return _picked(ends, pulls), _picked(ends, pushes)


def _pulls(
    here: Pressurized,
    low: Numbers,
    high: Numbers,
    kinks: list[Numbers],
    seen: tuple[Numbers, Numbers],
) -> Marks:
    """Whether (B13) proves that each lane pulls from `low` up to `high` [-]: in one, or from one
    unit's last kink to the next one's. `seen`: forces of its units and their slopes [N] at `high`,
    behind it, at `low` and at their `kinks`.
    """
    at_work = array_namespace(low)

    def proved(lane: Any, stops: Numbers, begun: tuple[Numbers, Numbers]) -> Marks:
        force, slope = (
            at_work.concatenate([x, all_of[lane, :1]], axis=1)
            for x, all_of in zip(begun, seen, strict=True)
        )
        stops = at_work.concatenate([stops, high[lane]], axis=1)
        left, right = force[:, :-1], force[:, 1:]
        least, most = minimum(left, right), maximum(left, right)
        steepest = _steepest(slope[:, :-1], slope[:, 1:])
        for n, kink in enumerate(kinks):
            at, (value, by) = kink[lane, None], (x[lane, n + 3 : n + 4] for x in seen)
            inside = (stops[:, :-1, None] < at) & (at < stops[:, 1:, None])
            least = where(inside, minimum(least, value), least)
            steepest = where(inside, _steepest(steepest, by), steepest)
        # what falls all along is least at its end
        least = where(steepest < 0, right, least - _MARGIN * (most - least))
        falls, above = (x.sum(axis=-1) for x in (steepest, least))
        return at_work.all((right.sum(axis=-1) > 0) & ((falls < 0) | (above > 0)), axis=-1)

    lanes = _lanes(low)
    sure = proved(lanes, low[:, None], tuple(x[:, 2:3] for x in seen))
    if at_work is np and not np.all(sure):
        left = lanes[~sure]
        last = minimum(kinks[-2] if kinks else high, high)[left]
        stops = np.sort(np.concatenate([low[left, None], last], axis=1), axis=1)
        sure[left] = proved(left, stops, here.of(left).unit_forces(stops))
    return sure


def _steepest(one: Numbers, other: Numbers) -> Numbers:
    """The largest slope [N] of units between two places: what falls at both falls between."""
    most = maximum(one, other)
    return where(most < 0, most, most + _MARGIN * absolute(one - other))


def _met(here: Pressurized, sides: Numbers, force: Numbers, slope: Numbers) -> Numbers:
    """The strain [-] between two `sides` at which each lane's force vanishes, from its values there
    and its slopes [N].
    """

    def step(_: Any, entry: tuple, state: tuple) -> tuple:
        a, b, x, before = state[:4]
        force, slope = _force(here, entry[0], x)
        a, b = where(force > 0, x, a), where(force > 0, b, x)
        newton = -force / guarded(slope < 0, slope)
        length, new = absolute(newton), minimum(maximum(x + newton, a), b)
        # Newton's step while it halves and stays between
        good = (slope < 0) & ((length <= _NEAR) | ((length < 0.5 * before) & (new == x + newton)))
        new, length = where(good, new, 0.5 * (a + b)), where(good, length, b - a)
        return a, b, new, length, length <= _NEAR

    def ended(_: tuple, state: tuple) -> Any:
        return state[4]

    low, high = sides.T
    # from the side whose tangent meets zero sooner
    steps = where(slope < 0, -force / guarded(slope < 0, slope), np.inf)
    near = array_namespace(steps).argmin(absolute(steps), axis=1)
    start = minimum(maximum(_picked(sides + steps, near), low), high)
    state = (low, high, start, 2 * (high - low), low > high)
    return repeated(step, (_lanes(low),), state, ended, _STEPS)[2]


def _force(here: Pressurized, lane: Any, strain: Numbers) -> tuple[Numbers, ...]:
    """Force of some lanes [N] at a `strain` [-] of each, and its slope [N]."""
    return tuple(x[:, 0] for x in here.of(lane).force(strain[:, None]))


def _lanes(x: Numbers) -> Any:
    """All lanes of `x`: listed by NumPy, which leaves some out as they end."""
    return np.arange(len(x)) if array_namespace(x) is np else slice(None)


def _picked(x: Numbers, column: Whole) -> Numbers:
    """What each row of `x` has in one `column` [-]."""
    return array_namespace(x).take_along_axis(x, column[:, None], axis=1)[:, 0]
