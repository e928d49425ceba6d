r"""All levels of throttled pressure at which a bundle gives a demanded force.

At each demand's strain every state's curve (B8) is laid over a grid of levels, dense at low
pressure where collapse and free strain change fastest. A demanded force is met at a node,
or once between two neighbors on either side of it. Where neither holds, but the curve
turns toward the demand at a node, it may be met twice before and after the turn: there the
extremum is searched for, smooth or a kink. So none is missed unless a curve turns twice
between two nodes. A change of sign in a jump of the force (collapse for good ends at some
pressure) is no solution, and isn't counted.

Roots and extrema are rare among the cells of a batch. They are listed, over the whole
batch, and the lists worked off in blocks: cost follows what there is, not what there could
be. Nothing here carries a derivative; the solution chosen gets it later.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .curves import Bank


CELLS = 32  # of the grid
EXACT = 2e-10  # N, the force that counts as met
_LEAST_BLOCK, _LARGEST_BLOCK = 64, 512  # lanes worked on at once
_PART = 4096  # demands tabled at once
_STEPS = 100
_NARROW = 1e-14  # a bracket that is a kink's or a jump's place

Row = Float[Array, " lane"]
Over = Float[Array, "demand state node"]
Marks = Bool[Array, "demand state node"]


class Found(eqx.Module):
    """Levels [-] in the order of states and pressures, unused slots last. `met`: whether they
    give what is demanded; those that don't are the nearest there are. `miss` [N]: how much
    more than that they give, inf in unused slots. `falls` [N]: the force's slope in strain.
    `lost`: how many had no room.
    """

    level: Float[Array, "demand slot"]
    state: Int[Array, "demand slot"]
    miss: Float[Array, "demand slot"]
    falls: Float[Array, "demand slot"]
    met: Bool[Array, "demand slot"]
    lost: Int[Array, " demand"]


class Lanes(eqx.Module):
    """Searches, each in a `state` at a `strain` [-] for `wanted` [N] of its curve, between the
    levels `low` and `high` [-], from `level` on. `sense`: 1 where the curve is above what is
    wanted at `low`, else -1. `turning`: it is on the same side at both ends, and the search is
    for its turn first, then, if that is beyond, for the crossing `after` it or before.
    """

    state: Int[Array, " lane"]
    strain: Row
    wanted: Row
    sense: Row
    low: Row
    high: Row
    level: Row
    turning: Bool[Array, " lane"]
    after: Bool[Array, " lane"]


def solve(bank: Bank, force: Float[Array, " demand"], strain: Float[Array, " demand"]) -> Found:
    """All levels of all states at which the bundle's force is `force` [N] at `strain` [-]."""
    grid = (jnp.arange(CELLS + 1) / CELLS) ** 2
    table, ends, slopes = _tabled(bank, grid, strain)
    wanted = force[:, None] - bank.held(ends).T
    over = jnp.moveaxis(bank.curves(table), 0, 1) - wanted[..., None]

    events, crossed = _events(over)
    none = ~jnp.any(events, axis=(1, 2))[:, None, None]
    nearest = none & _nearest(over)
    turns = _turns(over, nearest)
    states = over.shape[1]
    met = _List.of((events | nearest) & ~turns, 2 * states + 2)
    turned = _List.of(turns, states)

    # the crossings, then two lanes for each turn, without gaps
    lane = jnp.arange(met.node.shape[0] + 2 * turned.node.shape[0])
    total = met.total + 2 * turned.total
    turning, after = lane >= met.total, (lane - met.total) % 2 == 1
    at = jnp.where(
        turning, jnp.clip(lane - met.total, 0) // 2 % turned.node.shape[0], lane % met.node.shape[0]
    )
    n, state, node = (
        jnp.where(turning, two[at % two.shape[0]], one[at % one.shape[0]])
        for one, two in (
            (met.demand, turned.demand),
            (met.state, turned.state),
            (met.node, turned.node),
        )
    )
    here = over[n, state, node]
    first = jnp.where(turning, jnp.maximum(node - 1, 0), node)
    last = jnp.where(turning | crossed[n, state, node], jnp.minimum(node + 1, CELLS), node)
    low, high = grid[first], grid[last]
    rest = over[n, state, last]
    share = jnp.where(turning, 0.5, here / jnp.where(here == rest, 1.0, here - rest))
    lanes = Lanes(
        state=state,
        strain=strain[n],
        wanted=wanted[n, state],
        sense=jnp.where(here > 0, 1.0, -1.0),
        low=low,
        high=high,
        level=low + share * (high - low),
        turning=turning,
        after=after,
    )
    level, miss, falls, alone = _in_blocks(lambda some: _search(bank, some), total, lanes)

    slot, used, lost = _slots(met, turned, len(strain))
    state = state[slot]
    falls = falls[slot] + jnp.take_along_axis(bank.held(slopes).T, state, axis=1)
    # a turn that isn't beyond is one place, not two
    used &= ~(alone & turning & after)[slot]
    miss, size = jnp.where(used, miss[slot], jnp.inf), jnp.abs(lanes.wanted[slot])
    close = jnp.abs(miss) <= EXACT + 1e-13 * size
    return _in_order(Found(level[slot], state, miss, falls, close, lost))


def _tabled(
    bank: Bank, grid: Float[Array, " node"], strain: Float[Array, " demand"]
) -> tuple[Array, Array, Array]:
    """`bank.table`, part by part: a loop's result is stored, and so computed once only, where
    the compiler would else compute it again for each of its uses.
    """
    parts = max(2, -(-len(strain) // _PART))
    size = -(-len(strain) // parts)
    padded = jnp.pad(strain, (0, parts * size - len(strain)), mode="edge")
    tables = lax.map(lambda eps: bank.table(grid, eps[:, None]), padded.reshape(parts, size))

    def whole(part: Array) -> Array:
        joined = jnp.moveaxis(part, 0, 1)
        return joined.reshape(joined.shape[0], parts * size, -1)[:, : len(strain)]

    return jax.tree.map(whole, tables)


class _List(eqx.Module):
    """Nodes that are marked, in order: lanes up to `total`; `count` of each demand."""

    demand: Int[Array, " lane"]
    state: Int[Array, " lane"]
    node: Int[Array, " lane"]
    total: Int[Array, ""]
    count: Int[Array, " demand"]
    room: int = eqx.field(static=True)

    @classmethod
    def of(cls, marks: Marks, room: int) -> "_List":
        demands, states, nodes = marks.shape
        (flat,) = jnp.nonzero(marks.reshape(-1), size=demands * room, fill_value=0)
        demand, rest = flat // (states * nodes), flat % (states * nodes)
        count = jnp.sum(marks, axis=(1, 2))
        total = jnp.minimum(jnp.sum(count), demands * room)
        return cls(demand, rest // nodes, rest % nodes, total, count, room)


def _events(over: Over) -> tuple[Marks, Marks]:
    """Nodes that meet the demand, or before which and whose next it is crossed; the latter."""
    sign = jnp.where(jnp.abs(over) <= EXACT, 0, jnp.sign(over)).astype(jnp.int8)
    one = jnp.ones_like(sign[..., :1])
    # a stretch that meets it, of no more than rounding's width, counts once
    met = (sign == 0) & (jnp.concatenate([one, sign[..., :-1]], axis=-1) != 0)
    # a later state without pressure is an earlier one, which has counted it
    met = met.at[:, 1:, 0].set(False)
    crossed = jnp.concatenate([sign[..., :-1] * sign[..., 1:] < 0, one < 0], axis=-1)
    return met | crossed, crossed


def _nearest(over: Over) -> Marks:
    """The node of each demand that misses it least."""
    gap = jnp.abs(over).reshape(len(over), -1)
    place = jnp.argmin(gap, axis=1)
    return (jnp.arange(gap.shape[1]) == place[:, None]).reshape(over.shape)


def _turns(over: Over, nearest: Marks) -> Marks:
    """Nodes near which a curve turns toward the demand, and may reach it unseen."""
    gap = jnp.abs(over)
    edge = ((0, 0), (0, 0), (1, 1))
    around = jnp.pad(over, edge, mode="reflect")
    before, after = around[..., :-2], around[..., 2:]
    same = (before * over > 0) & (after * over > 0)
    turns = same & (gap <= jnp.abs(before)) & (gap < jnp.abs(after))
    # the parabola through the last three nodes says whether an end is the end of the matter
    steps = jnp.abs(jnp.diff(over, axis=-1))
    first, last = steps[..., 1] > 6 * steps[..., 0], steps[..., -2] > 2 * steps[..., -1]
    bent = jnp.ones_like(turns).at[..., 0].set(first).at[..., -1].set(last)
    # a kink lies no deeper than the curve changes nearby
    change = jnp.pad(steps, ((0, 0), (0, 0), (2, 2)))
    reach = sum((change[..., i : i + over.shape[-1]] for i in range(4)), start=jnp.zeros(()))
    return turns & bent & ((gap <= reach) | nearest)


def _search(bank: Bank, lanes: Lanes) -> tuple[Row, Row, Row, Bool[Array, " lane"]]:
    """Each lane's level [-], its miss [N], its curve's slope in strain [N], and whether it is a
    turn that doesn't reach what is wanted.

    Newton's steps in a bracket for a crossing. For a turn, where the slope has a root or
    jumps: the secant of the slopes, for one that is smooth, the tangents' intersection, for
    a kink, and bisection take turns. As soon as a turn is seen to be beyond what is wanted,
    the crossing in question is bracketed.
    """
    blank = jnp.full(lanes.low.shape, jnp.nan)
    start = _Progress(
        x=lanes.level, a=lanes.low, b=lanes.high, at_a=(blank, blank), at_b=(blank, blank),
        sense=lanes.sense, seeks=lanes.turning, last=4 * (lanes.high - lanes.low) + 1,
        miss=blank, slope=blank, falls=blank,
    )  # fmt: skip

    def step(carry: tuple[Array, _Progress]) -> tuple[Array, _Progress]:
        n, now = carry
        stays = (n == 0) | _done(lanes, now)  # at first nothing is known where it begins
        moved = _advance(lanes, now, n - 1)
        now = jax.tree.map(lambda old, new: jnp.where(stays, old, new), now, moved)
        force, change = jax.linearize(
            lambda u, eps: bank.curve(lanes.state, u, eps), now.x, lanes.strain
        )
        one, zero = jnp.ones_like(force), jnp.zeros_like(force)
        known = (force - lanes.wanted, change(one, zero), change(zero, one))
        return n + 1, eqx.tree_at(lambda p: (p.miss, p.slope, p.falls), now, known)

    def unfinished(carry: tuple[Array, _Progress]) -> Array:
        n, now = carry
        return (n == 0) | ((n < _STEPS) & ~jnp.all(_done(lanes, now)))

    end = lax.while_loop(unfinished, step, (jnp.zeros((), int), start))[1]
    return end.x, end.miss, end.falls, end.seeks & ~_crosses(end)


class _Progress(eqx.Module):
    """Where a search is: a bracket from `a` to `b` with the curve's height above what is
    wanted and slope at its ends, and the miss and the slopes in level and strain at `x`.

    What is decided is decided by these stored numbers: the compiler may evaluate a force once
    for each of its uses, and differently in the last bits.
    """

    x: Row
    a: Row
    b: Row
    at_a: tuple[Row, Row]
    at_b: tuple[Row, Row]
    sense: Row
    seeks: Bool[Array, " lane"]
    last: Row
    miss: Row
    slope: Row
    falls: Row


def _crosses(now: _Progress) -> Bool[Array, " lane"]:
    """Whether a turn that is sought is seen to be beyond what is wanted."""
    return now.seeks & (now.sense * now.miss < -0.5 * EXACT)


def _done(lanes: Lanes, now: _Progress) -> Bool[Array, " lane"]:
    tight = jnp.abs(now.miss) <= 1e-2 * EXACT + 1e-15 * jnp.abs(lanes.wanted)
    narrow = (now.b - now.a <= _NARROW) | (now.seeks & (now.slope == 0))
    return tight | (narrow & ~_crosses(now))


def _advance(lanes: Lanes, now: _Progress, n: Array) -> _Progress:
    """The `n`th step of every search, from what its curve is at its level."""
    x, miss, slope = now.x, now.miss, now.slope
    crosses = _crosses(now)
    seeks = now.seeks & ~crosses
    # the crossing before the turn begins where the search began, the one behind it ends there
    fresh_a, fresh_b = jnp.where(lanes.after, x, lanes.low), jnp.where(lanes.after, lanes.high, x)
    sense = jnp.where(crosses & lanes.after, -now.sense, now.sense)

    here = (now.sense * miss, now.sense * slope)
    left = jnp.where(seeks, here[1] < 0, here[0] > 0)  # what is sought lies above x
    a = jnp.where(crosses, fresh_a, jnp.where(left, x, now.a))
    b = jnp.where(crosses, fresh_b, jnp.where(left, now.b, x))
    at_a = (jnp.where(left, here[0], now.at_a[0]), jnp.where(left, here[1], now.at_a[1]))
    at_b = (jnp.where(left, now.at_b[0], here[0]), jnp.where(left, now.at_b[1], here[1]))

    newton = jnp.where(slope == 0, jnp.nan, x - miss / jnp.where(slope == 0, 1.0, slope))
    (g_a, s_a), (g_b, s_b) = at_a, at_b
    bend = jnp.where(s_b == s_a, jnp.nan, s_b - s_a)
    secant = a - s_a * (b - a) / bend
    tangents = (g_a - g_b + s_b * b - s_a * a) / bend
    turn = jnp.where(n % 3 == 0, secant, jnp.where(n % 3 == 1, tangents, jnp.nan))
    guess = jnp.where(seeks, turn, newton)
    # a crossing's steps must halve, a turn's bisections come by themselves
    good = (a < guess) & (guess < b) & (seeks | (jnp.abs(guess - x) < 0.5 * now.last))
    new = jnp.where(good & ~crosses, guess, 0.5 * (a + b))
    return _Progress(
        x=new, a=a, b=b, at_a=at_a, at_b=at_b, sense=sense, seeks=seeks,
        last=jnp.where(crosses, 4 * (b - a) + 1, jnp.abs(new - x)),
        miss=miss, slope=slope, falls=now.falls,
    )  # fmt: skip


def _slots(
    met: _List, turns: _List, demands: int
) -> tuple[Int[Array, "demand slot"], Bool[Array, "demand slot"], Int[Array, " demand"]]:
    """The lanes of each demand, whether they are, and how many had no room."""
    first, second = (jnp.cumsum(lanes.count) - lanes.count for lanes in (met, turns))
    room = jnp.arange(met.room)
    pair = jnp.arange(2 * turns.room)
    at = jnp.concatenate([first[:, None] + room, met.total + 2 * second[:, None] + pair], axis=1)
    used = jnp.concatenate([room < met.count[:, None], pair < 2 * turns.count[:, None]], axis=1)
    size = demands * (met.room + 2 * turns.room)
    lost = jnp.clip(met.count - met.room, 0) + jnp.clip(turns.count - turns.room, 0)
    return jnp.clip(at, 0, size - 1), used, lost


def _in_order(found: Found) -> Found:
    """`found` with those that are met first, by state and level, and the empty slots last."""
    key = jnp.where(found.met, found.state + 0.5 * found.level, jnp.inf)
    slots = key.shape[1]
    # few slots: counting those before each is faster than to sort
    ahead = key[:, None, :] < key[:, :, None]
    tied = (key[:, None, :] == key[:, :, None]) & (jnp.arange(slots) < jnp.arange(slots)[:, None])
    rank = jnp.sum(ahead | tied, axis=-1)
    place = jnp.argmax(rank[:, None, :] == jnp.arange(slots)[:, None], axis=-1)
    level, state, miss, falls, met = (
        jnp.take_along_axis(x, place, axis=1)
        for x in (found.level, found.state, found.miss, found.falls, found.met)
    )
    return Found(level, state, miss, falls, met, found.lost)


def _in_blocks(
    function: Callable[[Lanes], tuple[Array, ...]], total: Array, lanes: Lanes
) -> tuple[Array, ...]:
    """`function` of the first `total` of `lanes`, a block at a time; zeros for the rest."""
    size = lanes.low.shape[0]
    # a block waits for its slowest lane: small ones for few, where a step's own cost allows
    block = min(size, max(_LEAST_BLOCK, min(size // 16, _LARGEST_BLOCK)))
    # what fills the last block has nothing to search for
    idle = jnp.arange(size) >= total
    high, turning = jnp.where(idle, lanes.low, lanes.high), lanes.turning & ~idle
    lanes = eqx.tree_at(
        lambda some: (some.level, some.high, some.turning),
        lanes,
        (jnp.minimum(lanes.level, high), high, turning),
    )

    def step(state: tuple[Array, tuple[Array, ...]]) -> tuple[Array, tuple[Array, ...]]:
        done, results = state
        # the last block reaches back over the one before it
        start = jnp.minimum(done, size - block)
        part = function(
            jax.tree.map(lambda lane: lax.dynamic_slice(lane, (start,), (block,)), lanes)
        )
        results = tuple(
            lax.dynamic_update_slice(result, new, (start,))
            for result, new in zip(results, part, strict=True)
        )
        return done + block, results

    part = jax.eval_shape(function, jax.tree.map(lambda lane: lane[:block], lanes))
    results = tuple(jnp.zeros(size, one.dtype) for one in part)
    return lax.while_loop(lambda state: state[0] < total, step, (jnp.zeros((), int), results))[1]
