"""The nearest force to one that no state gives, and the level that gives it.

It lies at a stretch's side, at a kink, or at an extremum inside: stretches that could come nearer
than all sides do are cut, and the turn in question is closed in on. With a guide it is an end's,
but where a part of a curve may come nearer; there all turns between a `line`'s levels are closed in
on, and only what jumps past a demand has its stretches cut.
"""

from typing import Any

import numpy as np

from ...core.arrays import absolute, library, maximum, minimum, where
from ...core.types import Numbers
from ..crossings import cut, following, sides
from ..lists import put, ranked, repeated, worked
from .lanes import INSET, Lanes
from .line import turns


_TURNS = 30  # at most, toward a turn
_NARROW = 1e-7  # of the level: a turn's place by slopes
_ASIDE = (1e-5, 4e-7, 4e-7, 2e-8, 4e-9)  # of the level: from what an inset hides to rounding
ALIKE = 1e-10  # N, apart: forces that are one


def nearest(lanes: Lanes, count: Any, low: Numbers, high: Numbers) -> tuple[Any, Any, Any]:
    """The level [-] nearest to each demand, its state and miss [N]; of use where none is met.
    `low` and `high`: how far above lanes are at the ends of their curves [N].
    """
    guide = lanes.bank.guide
    if guide is None:
        return _nearest_of(lanes, count)
    some = np.flatnonzero(count == 0)
    if not len(some):
        return np.zeros(len(count)), np.zeros(len(count), int), np.zeros(len(count))
    at_ends = np.stack([low, high], axis=-1).reshape(len(count), -1)
    far = np.abs(at_ends)
    # one state's end may be another's: of those alike the lowest state is told
    best = np.argmax(far <= far.min(axis=1, keepdims=True) + ALIKE, axis=1)
    state, side = np.divmod(best, 2)
    miss = at_ends[np.arange(len(count)), best]
    level = side + 0.0 * miss
    part = lanes.of(_lanes_of(some, lanes.each))
    within = np.repeat(np.abs(miss[some]), lanes.each)
    parts = guide.nearer(part.state, part.strain, part.wanted, within)
    if not len(parts.lane):
        return level, state, miss
    (lane, low, high, level_near, by), jumps = turns(part.along, parts, within[parts.lane])
    turned, by = _turned(part, lane, (low, high), level_near, by)
    # the nearest of each demand comes first
    order = np.lexsort((np.abs(by), lane // lanes.each))
    owner, first = np.unique(lane[order] // lanes.each, return_index=True)
    best = order[first]
    nearer = np.abs(by[best]) < np.abs(miss[some[owner]]) - ALIKE
    best, owner = best[nearer], some[owner[nearer]]
    level[owner], state[owner], miss[owner] = turned[best], lane[best] % lanes.each, by[best]
    past = some[np.unique(parts.lane[jumps] // lanes.each)]
    if len(past):
        found = _nearest_of(lanes.of(_lanes_of(past, lanes.each)), count[past])
        level[past], state[past], miss[past] = found
    return level, state, miss


def _lanes_of(demands: np.ndarray, each: int) -> np.ndarray:
    return (demands[:, None] * each + np.arange(each)).reshape(-1)


def _nearest_of(lanes: Lanes, count: Any) -> tuple[Any, Any, Any]:
    """The same, looked for in all stretches."""
    states, at_work = lanes.each, library(lanes.wanted)
    demands = len(count)
    stretches = sides(lanes, lanes.ends(), INSET)

    def of_demand(x: Any) -> Any:
        return x.reshape(demands, -1)

    far = where(stretches.real, 0.0, np.inf)
    misses = at_work.concatenate(
        [of_demand(x + far) for x in (stretches.value_low, stretches.value_high)], axis=1
    )
    levels = at_work.concatenate([of_demand(stretches.low), of_demand(stretches.high)], axis=1)
    best = at_work.min(absolute(misses), axis=1)
    # what a stretch can't come nearer than, and those beside it, at whose kinks it may turn
    within = maximum(maximum(stretches.least, -stretches.most), 0.0) + far
    worth = within < at_work.repeat(where(count > 0, -1.0, best), states)[:, None]
    looked = cut(lanes, stretches, worth | _before(worth, stretches.real))
    total = at_work.sum(looked.real)
    turned = worked(lambda *x: _looked_at(lanes, *x), total, *looked[:3])
    owner = looked.lane // states
    rank, _ = ranked(owner, total, demands)
    width = max(1, stretches.low.size // max(demands, 1))
    shape, where_to = (demands, width), (owner, rank)
    level, miss = (
        put(fill, shape, where_to, x, total) for fill, x in zip((0.0, np.inf), turned, strict=True)
    )
    state = put(0, shape, where_to, looked.lane % states, total)
    per_state = stretches.low.shape[1]
    states_of = np.tile(np.repeat(np.arange(states), per_state), 2)
    states_of = at_work.broadcast_to(states_of, misses.shape)
    levels, misses, of_state = (
        at_work.concatenate(pair, axis=1)
        for pair in ((levels, level), (misses, miss), (states_of, state))
    )
    far = absolute(misses)
    alike = far <= at_work.min(far, axis=1, keepdims=True) + ALIKE
    taken = at_work.argmin(where(alike, of_state, states), axis=1)[:, None]
    return tuple(
        at_work.take_along_axis(x, taken, axis=1)[:, 0] for x in (levels, of_state, misses)
    )


def _before(marks: Any, real: Any) -> Any:
    """The stretches before those that are marked, of the `real` ones."""
    at_work = library(marks)
    beyond = at_work.concatenate([marks, marks[:, :1] & False], axis=1)
    return at_work.take_along_axis(beyond, following(real), axis=1) & real


def _looked_at(lanes: Lanes, lane: Any, nodes: Any, value: Any) -> tuple[Numbers, Numbers]:
    """The level [-] nearest to what is wanted in each cut stretch, and its miss [N]."""
    at_work = library(value)
    best = at_work.argmin(absolute(value), axis=1)
    last = nodes.shape[1] - 1

    def at(x: Any, place: Any) -> Numbers:
        return at_work.take_along_axis(x, place[:, None], axis=1)[:, 0]

    between = at(nodes, maximum(best - 1, 0)), at(nodes, minimum(best + 1, last))
    return _turned(lanes, lane, between, at(nodes, best), at(value, best))


def _turned(
    lanes: Lanes, lane: Any, between: tuple[Numbers, Numbers], level: Numbers, miss: Numbers
) -> tuple[Numbers, Numbers]:
    """The level [-] `between` two [-] at which lanes are nearest to what is wanted, and its miss
    [N], from a `level` between them [-] and its `miss` [N].
    """
    at_work, (low, high) = library(miss), between
    sense = where(miss > 0, 1.0, -1.0)
    value, slope = lanes.sums(lane, at_work.stack([low, high], axis=1))
    (g_a, g_b), (s_a, s_b) = ((sense * x[:, 0], sense * x[:, 1]) for x in (value, slope))
    state = (low, high, g_a, s_a, g_b, s_b, level, sense * miss)

    def step(n: Any, entry: tuple, state: tuple) -> tuple:
        lane, sense = entry
        a, b, g_a, s_a, g_b, s_b, level, miss = state
        bend = where(s_b == s_a, np.inf, s_b - s_a)
        secant, tangents = a - s_a * (b - a) / bend, (g_a - g_b + s_b * b - s_a * a) / bend
        guess = where(n % 3 == 0, secant, where(n % 3 == 1, tangents, 0.5 * (a + b)))
        x = where((a < guess) & (guess < b), guess, 0.5 * (a + b))
        g, s = (sense * y[:, 0] for y in lanes.sums(lane, x[:, None]))
        falls = s < 0
        nearer = absolute(g) < absolute(miss)  # past by rounding, where it just reaches, too
        return (
            where(falls, x, a), where(falls, b, x),
            where(falls, g, g_a), where(falls, s, s_a),
            where(falls, g_b, g), where(falls, s_b, s),
            where(nearer, x, level), where(nearer, g, miss),
        )  # fmt: skip

    def ended(_: tuple, state: tuple) -> Any:
        a, b, s_a, s_b = state[0], state[1], state[3], state[5]
        return (b - a <= _NARROW) | (s_a >= 0) | (s_b <= 0)  # where it doesn't turn, a node is best

    state = repeated(step, (lane, sense), state, ended, _TURNS)
    level, miss = state[6:]
    for aside in _ASIDE:
        level, miss = _lined(lanes, lane, sense, aside, level, miss)
    return level, sense * miss


def _lined(
    lanes: Lanes, lane: Any, sense: Numbers, aside: float, level: Numbers, miss: Numbers
) -> tuple[Numbers, Numbers]:
    """A `level` [-] near a kink and its `miss`, made positive [N], or those where lines from
    `aside` on both sides [-] meet: slopes don't tell on which side of a kink they are.
    """
    places = level[:, None] + aside * library(level).asarray([-2.0, -1.0, 1.0, 2.0])
    g = sense[:, None] * lanes.above(lane, minimum(maximum(places, 0.0), 1.0))
    falls, rises = g[:, 1] - g[:, 0], g[:, 3] - g[:, 2]
    share = (g[:, 1] - g[:, 2] + falls + rises) / where(rises > falls, rises - falls, np.inf)
    x = level + aside * minimum(maximum(share, -1.0), 1.0)
    x = minimum(maximum(x, 0.0), 1.0)
    g = sense * lanes.above(lane, x[:, None])[:, 0]
    nearer = absolute(g) < absolute(miss)
    return where(nearer, x, level), where(nearer, g, miss)
