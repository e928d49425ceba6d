r"""All levels of throttled pressure at which a bundle gives a demanded force, and the nearest.

At each demand's strain every state's curve (B8) is smooth between the levels at which a free
strain, an onset or a collapse strain comes to be there; over these stretches its crossings of
the demanded force are looked for. A change of sign in a jump of the force (collapse for good
ends at some pressure) is no solution. Where there is none at all, the nearest force is.

Nothing here carries a derivative; the solution chosen gets it later.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ...core.arrays import absolute, library, maximum, minimum, where
from ...core.types import AnyArray, Numbers
from ..crossings import Cut, changes, cut, sides
from ..lists import put, ranked, repeated, worked
from .curves import Bank
from .guide import Runs
from .lanes import INSET, Lanes
from .line import closer
from .nearest import nearest


EXACT = 2e-10  # N, the force that counts as met
ROOM = 2  # solutions of a state for which there is room, and as many more for all
_BESIDE = 2e-6  # of the level: at least so far inside a stretch
_STEPS = 80  # at most, toward a crossing
_SECANTS = 8  # of so many steps toward a crossing one halves its bracket, come what may
_ALONE = 4  # runs that are sooner followed one by one
_ROUNDED = 1e-15  # of the level: as near as a crossing comes
ROUNDING = 1e-13  # of a force


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
    close = EXACT + ROUNDING * absolute(wanted)
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
    return Found(table, state, used, count, *nearest(lanes, count, low, high))


def _within(lanes: Lanes, close: Numbers, low: Numbers, high: Numbers) -> tuple:
    """Where lanes are met within their curves: by lane and level [-], and whether they are, in a
    jump they aren't. `low` and `high`: how far above they are at the ends [N].
    """
    if lanes.bank.guide is None:
        every = library(low).arange(len(lanes.wanted))
        return _searched(lanes, every, (0.0, 1.0), close, low, high)
    runs, parts = lanes.bank.guide.runs(lanes.state, lanes.strain, lanes.wanted, (low, high), close)
    if len(parts.lane):
        more, parts = closer(lanes.along, parts, close[parts.lane])
        runs = Runs(*map(np.append, runs, more))
    level, miss = _followed(lanes, close[runs.lane], runs)
    met = absolute(miss) <= close[runs.lane]
    if np.all(met) and not len(parts.lane):
        return runs.lane, level, met
    # what the guide has said in vain is looked for as if it had said nothing
    vain = np.unique(runs.lane[~met])
    met, left = ~np.isin(runs.lane, vain), ~np.isin(parts.lane, vain)
    some, begin, end = (
        np.append(x[left], y)
        for x, y in zip(parts, (vain, 0.0 * vain, 1.0 + 0.0 * vain), strict=True)
    )
    more = _searched(lanes, some, (begin, end), close, low, high)
    found = zip((runs.lane, level, met), more, strict=True)
    return tuple(np.concatenate(both) for both in found)


def _searched(
    lanes: Lanes, some: Any, between: tuple[Any, Any], close: Numbers, low: Numbers, high: Numbers
) -> tuple:
    """The same of `some` lanes, in all their stretches `between` two levels of each [-]."""
    part, close = lanes.of(some), close[some]
    first, last = (np.reshape(x, (-1, 1)) for x in between)
    ends = minimum(maximum(part.ends(), first), last)
    width = ends[:, 1:] - ends[:, :-1]
    inset = minimum(maximum(INSET, _BESIDE / where(width > 0, width, 1.0)), 0.25)
    stretches = sides(part, ends, inset)
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
    if len(runs.lane) <= _ALONE and lanes.bank.alone is not None:
        found = [_alone(lanes, *one) for one in zip(1e-2 * close, *runs, strict=True)]
        level, miss = np.reshape(found, (-1, 2)).T
        return level, miss

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


def _alone(
    lanes: Lanes, close: float, lane: Any, low: float, high: float, rises: Any, *near: float
) -> tuple[float, float]:
    state, strain, wanted = lanes.state[lane], lanes.strain[lane], lanes.wanted[lane]

    def above(level: float) -> float:
        return lanes.bank.single(state, level, strain)[0] - wanted

    sense, (begun, slope) = 1.0 if rises else -1.0, near
    return followed(above, close, (low, high), sense, begun, sense * slope)


def followed(
    above: Callable[[float], float],
    close: float,
    between: tuple[float, float],
    sense: float,
    near: float,
    slope: float,
) -> tuple[float, float]:
    """The same of one run, without arrays: how far it is `above` at a level [N], made to rise by
    its `sense` [-], `between` two levels and from `near` one [-] with that `slope` [N].
    """
    (low, high), x, level, miss = between, near, near, math.inf
    before = g_before = 0.0
    for n in range(_STEPS):
        g = sense * above(x)
        low, high = (x, high) if g < 0 else (low, x)
        if abs(g) < abs(miss):
            level, miss = x, g
        if abs(miss) <= close or high - low <= _ROUNDED:
            break
        if n:
            slope = (g - g_before) / (x - before) if x != before else 0.0
        secant = x - g / slope if slope > 0 else low
        before, g_before = x, g
        inside = low < secant < high and n % _SECANTS != _SECANTS - 1
        x = secant if inside else 0.5 * (low + high)
    return level, sense * miss


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
