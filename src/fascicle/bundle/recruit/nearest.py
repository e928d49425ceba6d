"""The nearest force to one that no state gives, and the level that gives it.

It lies at a stretch's side, at a kink, or at an extremum inside: stretches that could come nearer
than all sides do are cut, and the turn in question is closed in on.
"""

from typing import Any

import numpy as np

from ...core.arrays import absolute, library, maximum, minimum, where
from ...core.types import Numbers
from ..crossings import cut, following, sides
from ..lists import put, ranked, repeated, worked
from .lanes import Lanes


_INSET = 1e-4  # of a stretch: kinks are known to 1e-6 of a level
_TURNS = 30  # at most, toward a turn
_NARROW = 1e-13  # of the level: a turn's place


def nearest(lanes: Lanes, count: Any, low: Numbers, high: Numbers) -> tuple[Any, Any, Any]:
    """The level [-] nearest to each demand, its state and miss [N]; of use where none is met.
    `low` and `high`: how far above lanes are at the ends of their curves [N].
    """
    guide = lanes.bank.guide
    if guide is None:
        return _nearest_of(lanes, count)
    some = np.flatnonzero(count == 0)
    at_ends = np.concatenate([x.reshape(len(count), -1) for x in (low, high)], axis=1)
    best = np.argmin(np.abs(at_ends), axis=1)
    side, state = np.divmod(best, lanes.each)
    miss = at_ends[np.arange(len(count)), best]
    level = side + 0.0 * miss
    if len(some):
        part = lanes.of(_lanes_of(some, lanes.each))
        within = np.repeat(np.abs(miss[some]), lanes.each)
        nearer = guide.nearer(part.state, part.strain, part.wanted, within)
        some = some[nearer.reshape(-1, lanes.each).any(axis=1)]
    if len(some):
        found = _nearest_of(lanes.of(_lanes_of(some, lanes.each)), count[some])
        level[some], state[some], miss[some] = found
    return level, state, miss


def _lanes_of(demands: np.ndarray, each: int) -> np.ndarray:
    return (demands[:, None] * each + np.arange(each)).reshape(-1)


def _nearest_of(lanes: Lanes, count: Any) -> tuple[Any, Any, Any]:
    """The same, looked for in all stretches."""
    states, at_work = lanes.each, library(lanes.wanted)
    demands = len(count)
    stretches = sides(lanes, lanes.ends(), _INSET)

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
    turns = worked(lambda *x: _turned(lanes, *x), total, *looked[:3])
    owner = looked.lane // states
    rank, _ = ranked(owner, total, demands)
    width = max(1, stretches.low.size // max(demands, 1))
    shape, where_to = (demands, width), (owner, rank)
    level, miss = (
        put(fill, shape, where_to, x, total) for fill, x in zip((0.0, np.inf), turns, strict=True)
    )
    state = put(0, shape, where_to, looked.lane % states, total)
    per_state = stretches.low.shape[1]
    states_of = np.tile(np.repeat(np.arange(states), per_state), 2)
    states_of = at_work.broadcast_to(states_of, misses.shape)
    levels, misses, of_state = (
        at_work.concatenate(pair, axis=1)
        for pair in ((levels, level), (misses, miss), (states_of, state))
    )
    taken = at_work.argmin(absolute(misses), axis=1)[:, None]
    return tuple(
        at_work.take_along_axis(x, taken, axis=1)[:, 0] for x in (levels, of_state, misses)
    )


def _before(marks: Any, real: Any) -> Any:
    """The stretches before those that are marked, of the `real` ones."""
    at_work = library(marks)
    beyond = at_work.concatenate([marks, marks[:, :1] & False], axis=1)
    return at_work.take_along_axis(beyond, following(real), axis=1) & real


def _turned(lanes: Lanes, lane: Any, nodes: Any, value: Any) -> tuple[Numbers, Numbers]:
    """The level [-] nearest to what is wanted in each cut stretch, and its miss [N]."""
    at_work = library(value)
    best = at_work.argmin(absolute(value), axis=1)
    last = nodes.shape[1] - 1

    def at(x: Any, place: Any) -> Numbers:
        return at_work.take_along_axis(x, place[:, None], axis=1)[:, 0]

    level, miss = at(nodes, best), at(value, best)
    sense = where(miss > 0, 1.0, -1.0)
    low, high = at(nodes, maximum(best - 1, 0)), at(nodes, minimum(best + 1, last))
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
        nearer = (g < miss) & (g >= 0)
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
    return state[6], sense * state[7]
