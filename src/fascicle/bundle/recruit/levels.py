r"""All levels of throttled pressure at which a bundle gives a demanded force, and the nearest.

At each demand's strain every state's curve (B8) is smooth between the levels at which a free
strain, an onset or a collapse strain comes to be there; over these stretches its crossings of
the demanded force are looked for. A change of sign in a jump of the force (collapse for good
ends at some pressure) is no solution. Where there is none at all, the nearest force there is
lies at a stretch's side, at a kink, or at an extremum inside: stretches that could come nearer
than all sides do are cut, and the turn in question is closed in on.

Nothing here carries a derivative; the solution chosen gets it later.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ...core.arrays import absolute, library, maximum, minimum, where
from ...core.types import AnyArray, Numbers
from ..crossings import Cut, changes, cut, following, sides
from ..lists import put, ranked, repeated, worked
from .curves import Bank
from .guide import Runs


EXACT = 2e-10  # N, the force that counts as met
ROOM = 2  # solutions of a state for which there is room, and as many more for all
_INSET = 1e-4  # of a stretch: kinks are known to 1e-6 of a level
_STEPS, _TURNS = 80, 30  # at most, toward a crossing and toward a turn
_SECANTS = 8  # of so many steps toward a crossing one halves its bracket, come what may
_NARROW, _ROUNDED = 1e-13, 1e-15  # of the level: a turn's place; as near as a crossing comes
_ROUNDING = 1e-13  # of a force


class Found(NamedTuple):
    """Solutions of each demand in the order of states and levels, unused slots last: `level` [-],
    `state`, whether it is `met`, how many there are. `nearest` [-] and its state and `miss` [N],
    how much more than what is demanded it gives, where none is.
    """

    level: Float[AnyArray, "demand slot"]
    state: Int[AnyArray, "demand slot"]
    met: Bool[AnyArray, "demand slot"]
    count: Int[AnyArray, " demand"]
    nearest: Float[AnyArray, " demand"]
    nearest_state: Int[AnyArray, " demand"]
    miss: Float[AnyArray, " demand"]


class Lanes(NamedTuple):
    """A curve for every demand and state: what it is to give [N], at which strain [-], in which
    `state` [-]; `each` demand has so many [-].
    """

    bank: Bank
    wanted: Numbers
    strain: Numbers
    state: Any
    each: int

    def terms(self, lane: Any, level: Numbers) -> tuple[Numbers, Numbers]:
        """How far its parts are above what is wanted [N], and their slopes by level [N]."""
        value, slope = self.bank.terms(self.state[lane], level, self.strain[lane])
        short, at_work = self._short(lane, level), library(value)
        return tuple(
            at_work.concatenate(parts, axis=-1) for parts in ((value, short), (slope, 0.0 * short))
        )

    def values(self, lane: Any, level: Numbers) -> Numbers:
        """The same without slopes, at half the cost."""
        value = self.bank.values(self.state[lane], level, self.strain[lane])
        return library(value).concatenate([value, self._short(lane, level)], axis=-1)

    def sums(self, lane: Any, level: Numbers) -> tuple[Numbers, Numbers]:
        """How far a lane is above [N] at each `level` [-], and its slope [N]."""
        at_work = library(level, self.wanted)
        return tuple(at_work.sum(x, axis=-1) for x in self.terms(lane, level))

    def above(self, lane: Any, level: Numbers) -> Numbers:
        """How far a lane is above [N] at each `level` [-]."""
        return library(level, self.wanted).sum(self.values(lane, level), axis=-1)

    def of(self, some: Any) -> "Lanes":
        """Those lanes [-], whole demands or each by itself."""
        wanted, strain, state = (x[some] for x in (self.wanted, self.strain, self.state))
        return self._replace(wanted=wanted, strain=strain, state=state)

    def ends(self) -> Numbers:
        """Levels [-] between which each lane is smooth, rising along a last axis."""
        return self.bank.ends(self.strain, self.state)

    def _short(self, lane: Any, level: Numbers) -> Numbers:
        wanted = -self.wanted[lane][:, None, None]
        return library(level, wanted).broadcast_to(wanted, (*level.shape, 1))


def solve(
    bank: Bank, force: Numbers, strain: Numbers, which: Any = None, beside: Any = None
) -> Found:
    """All levels of all states at which the bundle's force is `force` [N] at `strain` [-]; of each
    demand's own state alone where it is said `which` [-] that is: it is the only one then.
    `beside`: what the bank's `beside` gives there [N], where it is known.
    """
    demands, states = len(strain), bank.states if which is None else 1
    at_work = library(force, strain, bank.supply)
    beside = bank.beside(strain) if beside is None else beside
    held, _ = bank.held(beside)
    at_ends = [end @ bank.throttled.T for end, _ in beside]
    state = at_work.asarray(np.tile(np.arange(states), demands))
    if which is not None:
        every, state = np.arange(demands), at_work.asarray(which)
        held, *at_ends = (x[every, state][:, None] for x in (held, *at_ends))
    wanted = (force[:, None] - held).reshape(-1)
    low, high = (x.reshape(-1) - wanted for x in at_ends)
    lanes = Lanes(bank, wanted, at_work.repeat(strain, states), state, states)
    close = EXACT + _ROUNDING * absolute(wanted)
    met_low, met_high = absolute(low) <= close, absolute(high) <= close
    lane, level, met = _within(lanes, close, low, high)

    # a later state without pressure is an earlier one, which has counted it
    begins, finishes = (at_work.asarray(one)[state] for one in bank.counted)
    every = np.arange(demands * states)
    lane = at_work.concatenate([lane, every, every])
    level = at_work.concatenate([level, 0.0 * wanted, 1.0 + 0.0 * wanted])
    met = at_work.concatenate([met, met_low & begins, met_high & finishes])
    order = at_work.argsort(where(met, lane + 0.5 * level, np.inf))
    total = at_work.sum(met)
    if at_work is np:
        order = order[:total]
    lane, level = lane[order], level[order]
    owner = lane // states
    rank, count = ranked(owner, total, demands)
    slots = ROOM * states + 2
    if at_work is np:
        slots = max(slots, int(count.max(initial=0)))
    shape, where_to = (demands, slots), (owner, rank)
    table = put(0.0, shape, where_to, level, total)
    state = put(0, shape, where_to, lane % states, total)
    used = np.arange(slots) < count[:, None]
    return Found(table, state, used, count, *_nearest(lanes, count, low, high))


def _within(lanes: Lanes, close: Numbers, low: Numbers, high: Numbers) -> tuple:
    """Where lanes are met within their curves: by lane and level [-], and whether they are, in a
    jump they aren't. `low` and `high`: how far above they are at the ends [N].
    """
    if lanes.bank.guide is None:
        every = library(low).arange(len(lanes.wanted))
        return _searched(lanes, every, close, low, high)
    runs, hard = lanes.bank.guide.runs(lanes.state, lanes.strain, lanes.wanted, (low, high), close)
    level, miss = _followed(lanes, close[runs.lane], runs)
    met = absolute(miss) <= close[runs.lane]
    # what the guide has said in vain is looked for as if it had said nothing
    hard = np.union1d(hard, runs.lane[~met])
    if not len(hard):
        return runs.lane, level, met
    more = _searched(lanes, hard, close, low, high)
    met = met & ~np.isin(runs.lane, hard)
    found = zip((runs.lane, level, met), more, strict=True)
    return tuple(np.concatenate(both) for both in found)


def _searched(lanes: Lanes, some: Any, close: Numbers, low: Numbers, high: Numbers) -> tuple:
    """The same of `some` lanes, in all their stretches."""
    part, close = lanes.of(some), close[some]
    stretches = sides(part, part.ends(), _INSET)
    looked = cut(part, stretches, stretches.may_cross)
    met = (absolute(x[some]) <= close for x in (low, high))
    lane, level, met = _crossed(part, close, _ends_apart(looked, *met))
    return some[lane], level, met


def _ends_apart(looked: Cut, low: Any, high: Any) -> Cut:
    """`looked`, where a curve's end that meets the demand isn't counted as a crossing."""
    value, nodes, at_work = looked.value, looked.nodes, library(looked.value)
    begins = (nodes[:, :1] <= 0) & low[looked.lane][:, None]
    ends = (nodes[:, -2:] >= 1) & high[looked.lane][:, None]
    apart = (
        where(begins, value[:, 1:2], value[:, :1]), value[:, 1:-2],
        where(ends, value[:, -3:-2], value[:, -2:]),
    )  # fmt: skip
    return looked._replace(value=at_work.concatenate(apart, axis=1))


def _crossed(lanes: Lanes, close: Numbers, looked: Cut) -> tuple[Any, Numbers, Any]:
    """Crossings by lane and level [-], and which of them are solutions rather than jumps."""
    # so many for each state, and as many for all
    found = changes(looked, len(lanes.wanted) * ROOM + 2 * -(-len(lanes.wanted) // lanes.each))

    def refined(lane: Any, *of: Any) -> tuple[Numbers, Numbers]:
        return _met(lanes, lane, close[lane], *of)

    level, miss = worked(refined, found.total, *found[:-1])
    real = np.arange(len(found.lane)) < found.total
    met = real & (absolute(miss) <= close[found.lane])
    return found.lane, level, met


def _followed(lanes: Lanes, close: Numbers, runs: Runs) -> tuple[Numbers, Numbers]:
    """The level [-] at which each run is met and its miss [N]: by secants from near it, within
    its sides, and some bisection.
    """

    def step(n: int, entry: tuple, state: tuple) -> tuple:
        lane, sense, _ = entry
        a, b, x, before, g_before, slope, level, miss = state
        g = sense * lanes.above(lane, x[:, None])[:, 0]
        a, b = np.where(g < 0, x, a), np.where(g < 0, b, x)
        if n:
            apart = x - before
            slope = (g - g_before) / np.where(apart == 0, np.inf, apart)
        secant = x - g / np.where(slope > 0, slope, np.nan)
        inside = (a < secant) & (secant < b) & (n % _SECANTS != _SECANTS - 1)
        nearer = np.abs(g) < np.abs(miss)
        return (
            a, b, np.where(inside, secant, 0.5 * (a + b)), x, g, slope,
            np.where(nearer, x, level), np.where(nearer, g, miss),
        )  # fmt: skip

    def ended(entry: tuple, state: tuple) -> Any:
        return (np.abs(state[7]) <= entry[2]) | (state[1] - state[0] <= _ROUNDED)

    sense, nothing = np.where(runs.rises, 1.0, -1.0), 0.0 * runs.near
    begun = (runs.low, runs.high, runs.near, nothing, nothing, sense * runs.slope)
    state = repeated(
        step, (runs.lane, sense, 1e-2 * close), (*begun, runs.near, np.inf + nothing), ended, _STEPS
    )
    return state[6], sense * state[7]


def _met(
    lanes: Lanes,
    lane: Any,
    close: Numbers,
    low: Numbers,
    high: Numbers,
    value_low: Numbers,
    value_high: Numbers,
    falls: Any,
) -> tuple[Numbers, Numbers]:
    """The level [-] between `low` and `high` at which a lane is met, and its miss [N]: by secants
    in a bracket whose far end counts half when it stays again (Illinois), and some bisection.
    """

    def step(n: Any, entry: tuple, state: tuple) -> tuple:
        lane, sense, _ = entry
        a, b, g_a, g_b, level, miss, went_left = state
        secant = a + (b - a) * g_a / where(g_a == g_b, np.inf, g_a - g_b)
        inside = (a < secant) & (secant < b) & (n % _SECANTS != _SECANTS - 1)
        x = where(inside, secant, 0.5 * (a + b))
        g = sense * lanes.above(lane, x[:, None])[:, 0]
        nearer = absolute(g) < absolute(miss)
        left = g > 0
        return (
            where(left, x, a), where(left, b, x),
            where(left, g, where(went_left < 0, 0.5 * g_a, g_a)),
            where(left, where(went_left > 0, 0.5 * g_b, g_b), g),
            where(nearer, x, level), where(nearer, g, miss), where(left, 1.0, -1.0),
        )  # fmt: skip

    def ended(entry: tuple, state: tuple) -> Any:
        return (absolute(state[5]) <= entry[2]) | (state[1] - state[0] <= _ROUNDED)

    sense, nowhere = where(falls, 1.0, -1.0), 0.0 * low
    begun = (low, high, sense * value_low, sense * value_high)
    state = (*begun, 0.5 * (low + high), np.inf + nowhere, nowhere)
    state = repeated(step, (lane, sense, 1e-2 * close), state, ended, _STEPS)
    return state[4], sense * state[5]


def _nearest(lanes: Lanes, count: Any, low: Numbers, high: Numbers) -> tuple[Any, Any, Any]:
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
