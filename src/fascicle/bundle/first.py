r"""The first strain at which a bundle's force vanishes, found without looking at all others.

Before the least free strain all units pull, at the largest none does. Between them the kinks of
all units (free strain, onset of buckling, collapse) are halved to two neighbors, from a force $F$
that pulls to one that doesn't. That it pulls everywhere before is proved by its units $F_i$, from
$a$ to $b$, wherever it does so at $b$:

$$\sum_i \max F_i' < 0 \quad\text{or}\quad \sum_i \min F_i > 0. \tag{B13}$$

Both are seen at $a$, at $b$ and on both sides of the unit's own kinks between them, with a margin
where a unit comes to pull more again. Between the two neighbors $F$ vanishes once if it falls.
What can't be proved so isn't called sure, and every stretch is to be looked at, as `zeros` does.

NumPy's alone: compiled, each lane would wait for the slowest, and for what few need.
"""

from typing import NamedTuple

import numpy as np

from ..core.roots import guarded
from .at import Pressurized
from .lists import repeated


LANES = 2**12  # times units, at once: their arrays stay in the cache
APART = 1e-13  # free strains closer than this are one
_MARGIN = 0.25  # of what a unit spans between two places, below both
INSET = 1e-7  # of a stretch: its side is seen from inside
_BESIDE = 1e-9  # of strain: a kink is seen from behind
_STEPS = 60  # toward a zero, at most: halving alone would need 53
_NEAR = 1e-8  # a Newton step this short leaves nothing but rounding


class First(NamedTuple):
    """The first zero of each lane [-], and whether it is `sure` that none lies before it."""

    strain: np.ndarray
    sure: np.ndarray


def first(here: Pressurized) -> First:
    """The first zero of a bundle's force.

    **Arguments:** `here`: the bundle at pressures, lanes and an axis of one ahead of units [-].

    **Returns:** a strain for each lane [-], and whether it is sure.
    """
    free, *more = here.kinks[:, :, 0]
    turns = [kink for kink in more if not np.array_equal(kink, free)]
    low, top = free.min(axis=1), free.max(axis=1)
    ends = np.minimum(np.concatenate([free, *turns], axis=1), top[:, None])
    before, behind = _halved(here, np.sort(ends, axis=1))
    sides = np.stack([before + INSET * (behind - before), behind], axis=1)
    force, slope = here.unit_forces(sides)
    found = _met(here, sides, force.sum(axis=-1), slope.sum(axis=-1))

    over, under = force.sum(axis=-1).T
    once = _steepest(slope[:, 0], slope[:, 1]).sum(axis=-1) < 0
    smooth = behind < here.fold[:, 0]  # slopes don't tell of a jump
    alike = top - low <= APART  # equal units vanish together
    sure = (over > 0) & (under <= 0) & once & smooth
    sure = sure & _pulls(here, low, sides[:, :1], (force[:, :1], slope[:, :1]), turns)
    return First(np.where(alike, low, found), alike | sure)


def _halved(here: Pressurized, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each lane's `ends` [-], two neighbors: it pulls at one, and doesn't at the next. It does
    so at the first of all, and at the last it doesn't.
    """

    def step(_: int, entry: tuple, state: tuple) -> tuple:
        (lane, ends), (pulls, pushes) = entry, state
        middle = (pulls + pushes) // 2
        still = _force(here, lane, ends[np.arange(len(ends)), middle])[0] > 0
        return np.where(still, middle, pulls), np.where(still, pushes, middle)

    def ended(_: tuple, state: tuple) -> np.ndarray:
        return state[1] - state[0] <= 1

    lanes, count = np.arange(len(ends)), ends.shape[1]
    state = (0 * lanes, 0 * lanes + count - 1)
    pulls, pushes = repeated(step, (lanes, ends), state, ended, count)
    return ends[lanes, pulls], ends[lanes, pushes]


def _pulls(
    here: Pressurized,
    low: np.ndarray,
    high: np.ndarray,
    at_high: tuple[np.ndarray, np.ndarray],
    turns: list[np.ndarray],
) -> np.ndarray:
    """Whether (B13) proves that each lane pulls from `low` up to `high` [-]: in one, or from one
    unit's last kink to the next one's. `at_high`: its units' forces there, and their slopes [N].
    """
    beside = (0.0, _BESIDE)
    kinks = [np.minimum(kink + step, high) for kink in turns for step in beside]
    seen = [here.forces_apart(kink[:, None]) for kink in kinks]

    def proved(lane: np.ndarray, stops: np.ndarray) -> np.ndarray:
        begun = here.of(lane).unit_forces(stops)
        force, slope = (
            np.concatenate([x, last[lane]], axis=1) for x, last in zip(begun, at_high, strict=True)
        )
        stops = np.concatenate([stops, high[lane]], axis=1)
        left, right = force[:, :-1], force[:, 1:]
        least, most = np.minimum(left, right), np.maximum(left, right)
        steepest = _steepest(slope[:, :-1], slope[:, 1:])
        for kink, (value, by) in zip(kinks, seen, strict=True):
            at = kink[lane, None]
            inside = (stops[:, :-1, None] < at) & (at < stops[:, 1:, None])
            least = np.where(inside, np.minimum(least, value[lane]), least)
            steepest = np.where(inside, _steepest(steepest, by[lane]), steepest)
        # what falls all along is least at its end
        least = np.where(steepest < 0, right, least - _MARGIN * (most - least))
        falls, above = (x.sum(axis=-1) for x in (steepest, least))
        return np.all((right.sum(axis=-1) > 0) & ((falls < 0) | (above > 0)), axis=-1)

    lanes = np.arange(len(high))
    sure = proved(lanes, low[:, None])
    left = lanes[~sure]
    last = np.minimum(turns[-1] if turns else high, high)[left]
    sure[left] = proved(left, np.sort(np.concatenate([low[left, None], last], axis=1), axis=1))
    return sure


def _steepest(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The largest slope [N] of units between two places: what falls at both falls between."""
    most = np.maximum(one, other)
    return np.where(most < 0, most, most + _MARGIN * np.abs(one - other))


def _met(here: Pressurized, sides: np.ndarray, force: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The strain [-] between two `sides` at which each lane's force vanishes, from its values there
    and its slopes [N].
    """

    def step(_: int, entry: tuple, state: tuple) -> tuple:
        a, b, x, before = state[:4]
        force, slope = _force(here, entry[0], x)
        a, b = np.where(force > 0, x, a), np.where(force > 0, b, x)
        newton = -force / guarded(slope < 0, slope)
        length, new = np.abs(newton), np.minimum(np.maximum(x + newton, a), b)
        # Newton's step while it halves and stays between
        good = (slope < 0) & ((length <= _NEAR) | ((length < 0.5 * before) & (new == x + newton)))
        new, length = np.where(good, new, 0.5 * (a + b)), np.where(good, length, b - a)
        return a, b, new, length, length <= _NEAR

    def ended(_: tuple, state: tuple) -> np.ndarray:
        return state[4]

    low, high = sides.T
    # from the side whose tangent meets zero sooner
    steps = np.where(slope < 0, -force / guarded(slope < 0, slope), np.inf)
    near = np.argmin(np.abs(steps), axis=1)
    lanes = np.arange(len(sides))
    start = np.minimum(np.maximum(sides[lanes, near] + steps[lanes, near], low), high)
    state = (low, high, start, 2 * (high - low), low > high)
    return repeated(step, (lanes,), state, ended, _STEPS)[2]


def _force(here: Pressurized, lane: np.ndarray, strain: np.ndarray) -> tuple[np.ndarray, ...]:
    """Force of some lanes [N] at a `strain` [-] of each, and its slope [N]."""
    return tuple(x[:, 0] for x in here.of(lane).force(strain[:, None]))
