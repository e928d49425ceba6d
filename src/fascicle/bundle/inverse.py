r"""The inverse of a bundle: the pressures that give a force at a strain.

In recruitment state $k$ the throttled units share one pressure $p$; with $w_{kj}$ muscles of kind
$j$ among them, and the others at no or at supply pressure, the state's force is

$$F_k(p, \varepsilon) = H_k(\varepsilon) + \sum_j w_{kj} F_j(p, \varepsilon) \tag{B8}$$

and a demanded force $F_d$ asks for all roots of

$$F_k(p, \varepsilon) = F_d, \qquad 0 \le p \le P_s, \quad k = 1 \dots n. \tag{B9}$$

**Method.** Each kind's free and collapse strains are solved for once, on a grid of pressures that
is kept with the bundle; forces there are closed forms. Cells of the grid that may hold the demand
get the pressures in between at which a kind has a kink (its free strain, onset of buckling, fold or
collapse strain comes to be the demand's), then the extrema that may reach it. Every change of sign
between neighbors is a root, searched for in its bracket; a force that jumps past the demand (at
some pressure collapse ends for good) is none. Where no state has a root, the nearest force is
that of the nearest node, of which extrema are some.

**Choice.** The fluid energy (29) does not depend on the throttled pressure. Where the units that a
state feeds are among those of the next, the lowest state is the cheapest; within it the lowest
pressure is taken. At $\varepsilon \le 0$, where fluid flows back, that order holds as well.

NumPy alone works here: what JAX traces comes as numbers, by `callback`.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..core.types import AnyArray, Bool, Float, Int, Numbers
from ..repr_table import with_table_repr
from .pressurized import muscle_strain
from .printing import recruited_sheet, solutions_sheet
from .states import States


REACHED, ABOVE, BELOW = 0, 1, 2
EXACT = 2e-10  # N: a force so near to the demand meets it
ROUNDING = 1e-13  # of a force: rounding of a sum over units
ALIKE = 1e-10  # N: forces so near to each other are one
ROOM = 2  # solutions of a state for which a result has room, and as many more for all
CELLS = 64  # of pressure; nodes are dense at low pressures, where free strains change fastest
BESIDE = 1e-6  # of the supply: nodes so near to both ends show the slope there
ASIDE = 1e-3  # of a cell: nodes so near to a kink show the slopes on both sides
COLUMNS = 129  # strains of the table that selects cells
FEW = 2**12  # points below which every cell is looked at: a table costs as much
PART = 2**13  # demands at once, so that they fit into memory
_CLOSE = 1e-9  # of 1 N and the force: `EXACT` of one unit, and the rounding of a sum
_BEYOND = 1e3  # times the forces at both ends: no muscle gives as much

Residual = Callable[[Any, Any], Any]


@with_table_repr(solutions_sheet)
class Solutions(NamedTuple):
    """All solutions on the last axis, by state and pressure: the throttled `pressure` [Pa],
    the `state`, whether `stable`; NaN, 0 and False where there are fewer. No derivatives.
    """

    pressure: Float[AnyArray, "*points solution"]
    state: Int[AnyArray, "*points solution"]
    stable: Bool[AnyArray, "*points solution"]


@with_table_repr(recruited_sheet)
class Recruited(NamedTuple):
    """What to do for a demanded force. `pressures` [Pa], units on the last axis; `state`,
    counted from 1; `force` [N] that they give; `status`: 0 reached, 1 the demanded force is
    above what is reachable there, 2 below: then all this is the nearest reachable force's.
    `stable`: the force falls with strain at these pressures. `solutions`, and their `count`.
    `unit`: the one that is throttled, the first of them, counted from 1.
    """

    pressures: Numbers
    state: Int[AnyArray, "*points"]
    force: Float[AnyArray, "*points"]
    status: Int[AnyArray, "*points"]
    stable: Bool[AnyArray, "*points"]
    solutions: Solutions
    count: Int[AnyArray, "*points"]
    unit: Int[AnyArray, "*points"]


class Kind:
    """One of a bundle's unlike muscles, between no pressure and the supply's."""

    def __init__(self, muscle: Any, ratio: float | None, supply: float, levels: np.ndarray):
        """**Arguments:** `muscle`; `ratio`: $L/L_i$ [-] or None; `supply`: $P_s$ [Pa]; `levels`:
        pressures of the grid over the supply's [-].
        """
        self.law, self.ratio, self.supply, self.levels = muscle.law, ratio, supply, levels
        at = self.at = self.law.at(levels * supply)
        self.free, self.collapse = at.column.free_strain, at.collapse
        self.turns: list[tuple[Callable, np.ndarray]] = [(self._pull, self.free)]
        named: list[Callable] = [lambda at: at.onset, lambda at: at.collapse]
        folds = at.law.buckling.folds(at.column)
        named += [lambda at, i=i: at.law.buckling.folds(at.column)[i] for i in range(len(folds))]
        if at.onset is self.free:  # the same law: it buckles where it no longer pulls
            named = named[1:]
        for name in named:
            nodes = np.broadcast_to(name(at), levels.shape)
            if not np.all(np.isinf(nodes)):
                self.turns.append((self._turn(name), nodes))

    def strain(self, plates: np.ndarray) -> np.ndarray:
        """The muscle's strain [-] at the `plates`' [-]."""
        return plates if self.ratio is None else muscle_strain(self.ratio, plates)

    def at_nodes(self, node: Any, plates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] at numbered levels and the `plates`' strain [-], and its slope in that [N]."""
        return self._scaled(_picked(self.at, node, self.levels.size).force(self.strain(plates)))

    def force(self, level: np.ndarray, plates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] at `level` and the `plates`' strain [-], and its slope in that [N].

        Most of its cost is free and collapse strain at the pressure. Where the muscle surely
        pulls neither is needed; elsewhere the grid says about where the first is, and mostly that
        the second is farther than the strain.
        """
        strain, pressure = self.strain(plates), level * self.supply
        force, slope = np.zeros(level.shape), np.zeros(level.shape)
        cell = self._cell(level)
        pulls = strain < np.minimum(self.free[cell], self.free[cell + 1])
        if pulls.any():
            pull = self.law.tension.pull(pressure[pulls], strain[pulls])
            force[pulls], slope[pulls] = pull.force, pull.slope
            pulls[pulls] = pull.force > 0  # a free strain that falls with pressure within a cell
        bows = ~pulls & (strain < np.minimum(self.collapse[cell], self.collapse[cell + 1]))
        for some, collapsed in ((bows, False), (~pulls & ~bows, True)):
            if some.any():
                P = pressure[some]
                free = self._free_strain(P, level[some], cell[some])
                collapse = None if collapsed else np.full(P.shape, np.inf)
                force[some], slope[some] = self.law.at(P, free, collapse).force(strain[some])
        return self._scaled((force, slope))

    def _cell(self, level: np.ndarray) -> np.ndarray:
        place = np.searchsorted(self.levels, level, "right") - 1
        return np.clip(place, 0, self.levels.size - 2)

    def _free_strain(self, P: np.ndarray, level: np.ndarray, cell: Any) -> np.ndarray | None:
        """Free strain [-] by Newton's method from the grid's, `None` where it doesn't get there."""
        left, right = self.levels[cell], self.levels[cell + 1]
        share = (level - left) / (right - left)
        free = (1 - share) * self.free[cell] + share * self.free[cell + 1]
        for _ in range(8):
            pull = self.law.tension.pull(P, free)
            step = pull.force / pull.slope
            free = free - step
            if np.all(np.abs(step) <= 1e-9):  # the step that was just taken squares that
                return free
        return None

    def _scaled(self, found: tuple) -> tuple[np.ndarray, np.ndarray]:
        force, slope = found
        return force, slope if self.ratio is None else slope * self.ratio

    def _pull(self, level: np.ndarray, plates: np.ndarray) -> np.ndarray:
        """What has the sign [N] of the free strain less the strain, and needs no root."""
        return self.law.tension.pull(level * self.supply, self.strain(plates)).force

    def _turn(self, name: Callable) -> Callable:
        """How far the strain [-] of a kink that `name` picks is beyond the muscle's."""

        def beyond(level: np.ndarray, plates: np.ndarray) -> np.ndarray:
            pressure = level * self.supply
            at = self.law.at(pressure, self._free_strain(pressure, level, self._cell(level)))
            return np.broadcast_to(name(at), level.shape) - self.strain(plates)

        return beyond


class Points(NamedTuple):
    """Places on curves, in order of `lane` and `level` [-]: how far the curve is `above` the
    demand [N], and whether it is `joined` to the next one. `kink`: whether it is the kink's own.
    """

    lane: np.ndarray
    level: np.ndarray
    above: np.ndarray
    joined: np.ndarray
    kink: np.ndarray

    def insert(self, lane: Any, level: Any, above: Any, joined: Any = True, kink: Any = False):
        """The same with more places [-], which are joined to their neighbors."""
        more = (lane, level, above, *(np.full(len(lane), x) for x in (joined, kink)))
        every = [np.concatenate(pair) for pair in zip(self, more, strict=True)]
        order = np.lexsort((every[1], every[0]))
        points = Points(*(x[order] for x in every))
        twice = np.zeros(len(order), bool)
        twice[1:] = (np.diff(points.lane) == 0) & (np.diff(points.level) == 0)
        points.joined[:-1] &= points.joined[1:] | ~twice[1:]
        return Points(*(x[~twice] for x in points))


class Found(NamedTuple):
    """Solutions in order: whose demand it is, its `state` and `level` [-]. For each demand the
    `nearest` level [-] and state, of use where it has no solution.
    """

    owner: np.ndarray
    state: np.ndarray
    level: np.ndarray
    nearest_state: np.ndarray
    nearest: np.ndarray


class Curves:
    """Force over pressure of every state of a bundle, (B8), at any strain."""

    def __init__(self, bundle: Any, supply: float, states: States, resistance: bool):
        """**Arguments:** `bundle` of NumPy's numbers; `supply`: $P_s$ [Pa]; `states` of the scheme:
        where their units are independent each unit is a state by itself; `resistance`: whether
        muscles push.
        """
        units = bundle.motor_units
        self.supply, self.resistance, self.bundle = float(supply), resistance, bundle
        unlike: list[int] = []  # the first unit of each kind
        for i, unit in enumerate(units):
            if not any(unit.muscle == units[j].muscle for j in unlike):
                unlike.append(i)
        self.kind = [
            next(k for k, j in enumerate(unlike) if units[j].muscle == unit.muscle)
            for unit in units
        ]
        self.levels = _levels([units[i].muscle.tuning for i in unlike], self.supply)
        ratios = bundle.ratios
        self.kinds = [
            Kind(
                units[i].muscle,
                None if ratios is None else float(ratios[i]),
                self.supply,
                self.levels,
            )
            for i in unlike
        ]
        counts = np.eye(len(unlike))[self.kind] * np.reshape(bundle.counts, (-1, 1))
        masks, self.counted = (states.throttled, states.unfed, states.full), states.counted
        if states.independent:
            each = np.eye(len(units), dtype=bool)
            masks, self.counted = (each, 0 * each, 0 * each), (np.diag(each), np.diag(each))
        self.throttled, self.vented, self.full = (x.astype(float) @ counts for x in masks)
        self.states = len(self.throttled)
        self._table: tuple[np.ndarray, ...] | None = None

    def held(self, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] of the units that each state doesn't throttle, states last, and its slope."""
        total = np.zeros((2, len(strain), self.states))
        for j, kind in enumerate(self.kinds):
            for node, share in ((0, self.vented), (-1, self.full)):
                if share[:, j].any():
                    force, slope = self._counted(*kind.at_nodes(np.full(len(strain), node), strain))
                    total += np.stack([force, slope])[..., None] * share[:, j]
        return total[0], total[1]

    def force(
        self, state: np.ndarray, level: np.ndarray, strain: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] of the units that each `state` throttles, at `level` and `strain` [-], and its
        slope in strain [N].
        """
        return self._sum(state, lambda kind, i: kind.force(level[i], strain[i]))

    def at_nodes(self, state: np.ndarray, node: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """The force alone [N] at numbered levels."""
        return self._sum(state, lambda kind, i: kind.at_nodes(node[i], strain[i]))[0]

    def candidates(self, lanes: "Lanes") -> np.ndarray:
        """Which cells may hold each lane's demand [-], by a table of forces over strain."""
        low, high, table = self._tabulate(lanes.strain)
        place = (lanes.strain - low) / (high - low) * (COLUMNS - 1)
        column = np.clip(place.astype(int), 0, COLUMNS - 2)
        share = (place - column)[:, None]
        cells = np.zeros((len(lanes.target), len(self.levels) - 1), bool)
        for k in range(self.states):
            some = np.flatnonzero(lanes.state == k)
            one, other = (table[column[some] + i, k] for i in (0, 1))
            above = (1 - share[some]) * one + share[some] * other - lanes.target[some, None]
            # a kink moves through the cells between two columns
            moved = np.abs(other - one)
            slack = 0.5 * np.maximum(moved[:, :-1], moved[:, 1:])
            cells[some] = _near(above, slack)
        return cells

    def _tabulate(self, strain: np.ndarray) -> tuple:
        """The table's least and largest strain [-], and forces [N] over strain, state and node."""
        if self._table is None or strain.min() < self._table[0] or strain.max() > self._table[1]:
            known = (strain.min(), strain.max()) if self._table is None else self._table[:2]
            low, high = min(strain.min(), known[0], 0.0), max(strain.max(), known[1], 0.3)
            columns = np.linspace(low, high, COLUMNS)
            table = np.zeros((COLUMNS, self.states, len(self.levels)))
            every = np.arange(len(self.levels))
            for j, kind in enumerate(self.kinds):
                force, _ = self._counted(*kind.at_nodes(every, columns[:, None]))
                table += self.throttled[:, j, None] * force[:, None, :]
            self._table = (low, high, table)
        return self._table

    def _sum(self, state: np.ndarray, law: Callable) -> tuple[np.ndarray, np.ndarray]:
        force, slope = np.zeros(len(state)), np.zeros(len(state))
        for j, kind in enumerate(self.kinds):
            share = self.throttled[state, j]
            some = np.flatnonzero(share)
            if len(some):
                value, by = self._counted(*law(kind, some))
                force[some] += share[some] * value
                slope[some] += share[some] * by
        return force, slope

    def _counted(self, force: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.resistance:
            return force, slope
        return np.where(force > 0, force, 0.0), np.where(force > 0, slope, 0.0)


class Lanes(NamedTuple):
    """Curves that demands ask: a `state` at a `strain` [-] that is to give a `target` [N]."""

    curves: Curves
    owner: np.ndarray
    state: np.ndarray
    strain: np.ndarray
    target: np.ndarray

    def above(self, lane: np.ndarray, level: np.ndarray) -> np.ndarray:
        """How far each lane is above its target [N] at a `level` [-]."""
        return self.curves.force(self.state[lane], level, self.strain[lane])[0] - self.target[lane]

    def of(self, some: Any) -> "Lanes":
        """Some of the lanes."""
        return Lanes(self.curves, *(x[some] for x in self[1:]))

    @property
    def close(self) -> np.ndarray:
        """What counts as met [N]."""
        return EXACT + ROUNDING * np.abs(self.target)


def solve(curves: Curves, force: np.ndarray, strain: np.ndarray, which: Any = None) -> Found:
    """All levels of all states at which the bundle gives each demand's force.

    **Arguments:** `curves`; `force` [N] and `strain` [-] of each demand; `which`: the only state
    of each demand, or None for all of them.
    """
    demands, held = len(force), curves.held(strain)[0]
    if which is None:
        owner = np.repeat(np.arange(demands), curves.states)
        state = np.tile(np.arange(curves.states), demands)
    else:
        owner, state = np.arange(demands), np.asarray(which)
    lanes = Lanes(curves, owner, state, strain[owner], force[owner] - held[owner, state])
    shape = (len(owner), len(curves.levels) - 1)
    every = np.ones(shape, bool)
    cells = every if every.size <= FEW else curves.candidates(lanes)
    lane, level, _ = _search(lanes, cells, np.zeros(len(owner)))
    reached = np.zeros(demands, bool)
    reached[owner[lane]] = True

    nearest_state, nearest = np.zeros(demands, int), np.zeros(demands)
    each, lost = (curves.states if which is None else 1), np.flatnonzero(~reached)
    step = max(1, PART // each)
    for start in range(0, len(lost), step):
        part = (lost[start : start + step, None] * each + np.arange(each)).reshape(-1)
        few = lanes.of(part)
        more, at, points = _search(few, every[: len(part)], None)
        lane, level = np.append(lane, part[more]), np.append(level, at)
        whose, away = few.owner[points.lane], np.abs(points.above)
        least = np.full(demands, np.inf)
        np.minimum.at(least, whose, away)
        best = np.flatnonzero(away <= least[whose] + ALIKE)
        first = best[np.unique(whose[best], return_index=True)[1]]
        nearest_state[whose[first]] = few.state[points.lane[first]]
        nearest[whose[first]] = points.level[first]
    order = np.lexsort((level, lane))
    lane, level = lane[order], level[order]
    return Found(owner[lane], state[lane], level, nearest_state, nearest)


def _search(lanes: Lanes, cells: np.ndarray, slack: np.ndarray | None) -> tuple:
    """Solutions by lane and level [-] in some cells, and all points that were looked at. `slack`:
    how far from the demand [N] a curve's turn is of interest; `None`: as far as the nearest node.
    """
    padded = np.pad(cells, ((0, 0), (1, 1)))
    seen = padded[:, :-2] | padded[:, 1:-1] | padded[:, 2:]  # neighbors tell where a curve turns
    padded = np.pad(seen, ((0, 0), (1, 1)))
    lane, node = np.nonzero(padded[:, :-1] | padded[:, 1:])
    joined = padded[lane, node + 1]
    curves = lanes.curves
    above = curves.at_nodes(lanes.state[lane], node, lanes.strain[lane]) - lanes.target[lane]
    points = Points(lane, curves.levels[node], above, joined, np.zeros(len(lane), bool))
    if slack is None:
        least = np.full(lanes.owner.max(initial=0) + 1, np.inf)
        np.minimum.at(least, lanes.owner[lane], np.abs(above))
        slack = least[lanes.owner]
    points = _with_kinks(lanes, points, node, slack)
    points = _with_extrema(lanes, points, slack)
    return *_roots(lanes, points), points


def _with_kinks(lanes: Lanes, points: Points, node: np.ndarray, slack: np.ndarray) -> Points:
    """The same with the kinks in cells that come as near to the demand as `slack` [N]."""
    near = np.flatnonzero(_near(points.above, slack[points.lane][:-1], points.joined[:-1]))
    lane, here = points.lane[near], node[near]
    kinks = []
    for j, kind in enumerate(lanes.curves.kinds):
        own = np.flatnonzero(lanes.curves.throttled[lanes.state[lane], j])
        strain = kind.strain(lanes.strain[lane[own]])
        for turn, strains in kind.turns:
            cross = own[(strains[here[own]] > strain) != (strains[here[own] + 1] > strain)]
            whose = lane[cross]

            def residual(i: Any, level: Any, turn: Callable = turn, whose: Any = whose) -> Any:
                return turn(level, lanes.strain[whose[i]])

            start, end = points.level[near[cross]], points.level[near[cross] + 1]
            left, right, real = _bracketed(residual, start, end)
            kinks.append(tuple(x[real] for x in (whose, left, right, start, end)))
    if not any(len(kink[0]) for kink in kinks):
        return points
    lane, left, right, start, end = map(np.concatenate, zip(*kinks, strict=True))
    below, over = lanes.above(lane, left), lanes.above(lane, right)
    # rounding apart the two are one, unless the force jumps
    jumps = np.abs(over - below) > 1e-7 * (1 + np.abs(below) + np.abs(over))
    points = points.insert(lane, right, over, kink=True)
    points = points.insert(lane, left, below, ~jumps, kink=True)
    for level in (left - ASIDE * (left - start), right + ASIDE * (end - right)):
        points = points.insert(lane, level, lanes.above(lane, level))
    return points


def _with_extrema(lanes: Lanes, points: Points, slack: np.ndarray) -> Points:
    """The same with the extrema that come as near to the demand as `slack` [N]."""
    if len(points.lane) < 3:
        return points
    sense = np.where(points.above[1:-1] > 0, 1.0, -1.0)
    before, here, after = (
        sense * x for x in (points.above[:-2], points.above[1:-1], points.above[2:])
    )
    turns = points.joined[:-2] & points.joined[1:-1] & ~points.kink[1:-1]
    turns &= (here > 0) & (before >= here) & (after >= here)
    span = np.maximum(before, after) - here
    # a parabola through three nodes turns less than their span below the lowest
    turns &= (span > EXACT) & (here - span < slack[points.lane[1:-1]])
    i = np.flatnonzero(turns)
    lane, sign = points.lane[1:-1][i], sense[i]
    level = _extremum(
        lambda some, x: sign[some] * lanes.above(lane[some], x),
        *(x[i] for x in (points.level[:-2], points.level[1:-1], points.level[2:])),
        *(x[i] for x in (before, here, after)),
    )
    return points.insert(lane, level, lanes.above(lane, level)) if len(i) else points


def _roots(lanes: Lanes, points: Points) -> tuple[np.ndarray, np.ndarray]:
    """Solutions by lane and level [-]: nodes that meet the demand, and changes of sign."""
    close = lanes.close[points.lane]
    met = np.abs(points.above) <= close
    # a row of nodes that all meet it counts once, by its first
    follows = np.zeros(len(met), bool)
    follows[1:] = met[1:] & met[:-1] & points.joined[:-1]
    first = met & ~follows
    begins, ends = (x[lanes.state[points.lane]] for x in lanes.curves.counted)
    first &= ((points.level > 0) | begins) & ((points.level < 1) | ends)
    # a later state's beginning is an earlier one, which has counted it
    lane, level = points.lane[first], points.level[first]
    change = points.joined[:-1] & ~met[:-1] & ~met[1:]
    i = np.flatnonzero(change & ((points.above[:-1] > 0) != (points.above[1:] > 0)))
    whose, goal = points.lane[i], 1e-2 * close[i]
    root, miss = _root(
        lambda some, x: lanes.above(whose[some], x),
        points.level[i], points.level[i + 1], points.above[i], points.above[i + 1], goal,
    )[:2]  # fmt: skip
    real = np.abs(miss) <= close[i]  # else it jumps there
    return np.append(lane, whose[real]), np.append(level, root[real])


def _near(above: np.ndarray, slack: Any, joined: Any = True) -> np.ndarray:
    """Which cells between neighbors on the last axis may come as near to zero as `slack` [N], by
    their ends and how much the curve changes there and beside.
    """
    change = np.where(joined, np.abs(np.diff(above)), 0.0)
    before, after = _sides(change)
    margin = np.maximum(np.maximum(before[..., :-1], after[..., 1:]), change)
    left, right = above[..., :-1], above[..., 1:]
    away = np.maximum(np.minimum(left, right), -np.maximum(left, right))
    return joined & (away - margin < slack)  # a plateau at the nearest force holds nothing nearer


def _sides(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each place between the entries `x` on the last axis the one before and the one after."""
    ends = [(0, 0)] * (x.ndim - 1)
    return np.pad(x, [*ends, (1, 0)]), np.pad(x, [*ends, (0, 1)])


def _bracketed(residual: Residual, low: Any, high: Any) -> tuple[Any, Any, Any]:
    """The last bracket of a root [-] between `low` and `high` [-], and whether there is one."""
    every = np.arange(len(low))
    if not len(every):
        return low, high, every > 0
    ends = (residual(every, low), residual(every, high))
    real = (ends[0] > 0) != (ends[1] > 0)
    some, (f_low, f_high) = np.flatnonzero(real), ends
    left, right = low.copy(), high.copy()
    left[some], right[some] = _root(
        lambda i, x: residual(some[i], x), low[some], high[some], f_low[some], f_high[some], -1.0
    )[2:]
    return left, right, real


def _root(
    residual: Residual, low: Any, high: Any, f_low: Any, f_high: Any, close: Any
) -> tuple[np.ndarray, ...]:
    """Roots in brackets by Chandrupatla's method, all at once: the best place [-], its residual,
    and the ends of the last bracket [-]. It ends at a residual of `close`, or at rounding.
    """
    x = np.stack([low, high, high])  # newest, its counterpart, the one before
    f = np.stack([f_low, f_high, f_high])
    goal, every = np.broadcast_to(close, low.shape), np.arange(len(low))
    share = f_low / (f_low - f_high)  # the secant, at which a straight line ends
    for _ in range(100):
        width = np.abs(x[1, every] - x[0, every])
        least = (2e-16 * np.abs(x[0, every]) + 1e-300) / np.where(width > 0, width, 1.0)
        best = np.minimum(np.abs(f[0, every]), np.abs(f[1, every]))
        going = (best > goal[every]) & (least < 0.5) & (width > 0)
        every, share, least = every[going], share[going], least[going]
        if not len(every):
            break
        share = np.clip(np.where(np.isfinite(share), share, 0.5), least, 1 - least)
        (x1, x2, _), (f1, f2, _) = x[:, every], f[:, every]
        new = x1 + share * (x2 - x1)
        value = residual(every, new)
        same = (value > 0) == (f1 > 0)
        x[:, every] = x1, x2, x3 = new, np.where(same, x2, x1), np.where(same, x1, x2)
        f[:, every] = f1, f2, f3 = value, np.where(same, f2, f1), np.where(same, f1, f2)
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        inverse = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
        quadratic = f1 / (f2 - f1) * f3 / (f2 - f3)
        quadratic += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        share = np.where(inverse, quadratic, 0.5)
    newest = np.abs(f[0]) < np.abs(f[1])
    ends = np.minimum(x[0], x[1]), np.maximum(x[0], x[1])
    return np.where(newest, x[0], x[1]), np.where(newest, f[0], f[1]), *ends


def _extremum(
    residual: Residual, a: Any, m: Any, b: Any, f_a: Any, f_m: Any, f_b: Any
) -> np.ndarray:
    """Minima [-] between `a` and `b`, lower at `m`, by parabolas and golden sections, all at once;
    where the residual falls below zero before, the place where it does.
    """
    x, f, every = np.stack([a, m, b]), np.stack([f_a, f_m, f_b]), np.arange(len(a))
    limit = 1e-8 * (b - a)  # a minimum is flat: its value is exact to the square of this
    for n in range(60):
        width = x[2, every] - x[0, every]
        every = every[(f[1, every] > 0) & (width > 4 * limit[every])]
        if not len(every):
            break
        (a, m, b), (f_a, f_m, f_b), tiny = x[:, every], f[:, every], limit[every]
        p, q = (m - a) * (f_m - f_b), (m - b) * (f_m - f_a)
        vertex = m - 0.5 * ((m - a) * p - (m - b) * q) / (p - q)
        golden = m + 0.381966 * np.where(b - m > m - a, b - m, a - m)
        inside = (a + tiny < vertex) & (vertex < b - tiny) & (n % 3 < 2)
        new = np.where(inside, vertex, golden)
        side = np.where(b - m > m - a, tiny, -tiny)
        new = np.where(np.abs(new - m) < tiny, m + side, new)
        value = residual(every, new)
        lower, left = value < f_m, new < m
        for table, mid, fresh in ((x, m, new), (f, f_m, value)):
            low, high = table[0, every], table[2, every]
            table[0, every] = np.where(lower, np.where(left, low, mid), np.where(left, fresh, low))
            table[2, every] = np.where(
                lower, np.where(left, mid, high), np.where(left, high, fresh)
            )
            table[1, every] = np.where(lower, fresh, mid)
    return x[1]


def _levels(tunings: list, supply: float) -> np.ndarray:
    """Pressures of the grid over the supply's [-], those at which tunings have kinks among them."""
    even = (np.arange(CELLS + 1) / CELLS) ** 2
    kinks = [np.ravel((t.pressures + np.asarray(t.dead_band)[..., None]) / supply) for t in tunings]
    given = np.concatenate([*kinks, [0.0]])
    given = given[given < 1]
    every = np.concatenate([even, given, given + BESIDE, given - BESIDE, [1 - BESIDE]])
    return np.unique(every[(every >= 0) & (every <= 1)])


def _picked(part: Any, node: Any, count: int) -> Any:
    """Of what is solved for at `count` pressures on the last axis that at some of them."""
    if isinstance(part, tuple):
        picked = [_picked(x, node, count) for x in part]
        return type(part)(*picked) if hasattr(part, "_fields") else tuple(picked)
    inside = isinstance(part, np.ndarray) and part.shape[-1:] == (count,)
    return part[..., node] if inside else part


def recruited(
    curves: Curves,
    force: np.ndarray,
    strain: np.ndarray,
    states: States,
    present: np.ndarray | None = None,
    taken: np.ndarray | None = None,
) -> Recruited:
    """Equation (B9) solved, and one of its solutions chosen.

    **Arguments:**

    - `curves`: the bundle's.
    - `force`: demanded [N], one for each `strain`.
    - `strain`: the bundle's contractions [-].
    - `states`: of the scheme.
    - `present`: pressures now [Pa], units last; the nearest solution to them is taken.
    - `taken`: fluid of each unit since rest [m³], units last, where it decides.

    **Returns:** what to do for each demand, without derivatives.
    """
    found, demands = solve(curves, force, strain), len(force)
    count = np.bincount(found.owner, minlength=demands)
    rank = np.arange(len(found.owner)) - (np.cumsum(count) - count)[found.owner]
    cost = rank + 0.0  # they are in this order already
    if present is not None:
        pressures = states.pressures(found.state, found.level, curves.supply)
        cost = np.sum((pressures - present[found.owner]) ** 2, axis=-1)
    elif taken is not None:
        fluid = np.maximum(taken, 0.0) @ states.fed.T.astype(float)
        cost = fluid[found.owner, found.state]
    order = np.lexsort((rank, cost, found.owner))
    owner, first = np.unique(found.owner[order], return_index=True)
    state, level = found.nearest_state.copy(), found.nearest.copy()
    state[owner], level[owner] = (x[order[first]] for x in (found.state, found.level))
    reached = count > 0

    held, held_slope = curves.held(strain)
    every = np.arange(demands)
    value, slope = curves.force(state, level, strain)
    given, slope = value + held[every, state], slope + held_slope[every, state]
    _, own = curves.force(found.state, found.level, strain[found.owner])
    stable = own + held_slope[found.owner, found.state] < 0
    shape = (demands, max(ROOM * curves.states + 2, int(count.max(initial=0))))
    solutions = Solutions(np.full(shape, np.nan), np.zeros(shape, int), np.zeros(shape, bool))
    values = (found.level * curves.supply, found.state + 1, stable)
    for table, column in zip(solutions, values, strict=True):
        table[found.owner, rank] = column
    return Recruited(
        pressures=states.pressures(state, level, curves.supply),
        state=state + 1,
        force=given,
        status=np.where(reached, REACHED, np.where(given < force, ABOVE, BELOW)),
        stable=slope < 0,
        solutions=solutions,
        count=count,
        unit=states.leading[state] + 1,
    )


def freed(
    curves: Curves,
    force: np.ndarray,
    strain: np.ndarray,
    taken: np.ndarray,
    sets: States,
    owner: np.ndarray,
) -> Recruited:
    r"""The cheapest pressures where each unit has one of its own.

    The forces of a set $A$ of fed units are independent, so together they give what lies between

    $$F_0 + \sum_{i \in A} (\min_p F_i - F_i(0)) \le F_d \le
      F_0 + \sum_{i \in A} (\max_p F_i - F_i(0)), \tag{B11}$$

    $F_0$ with none fed. Of all sets that reach a demand the one is taken whose units take in least,
    of equal ones that with fewer units, then the earlier ones. All its units but the last pull most
    (below $F_0$: resist most), and the last is throttled, at the lowest pressure that meets the
    demand; where its force jumps past that, one before it.

    **Arguments:**

    - `curves`: of independent units.
    - `force`: demanded [N], one for each `strain`.
    - `strain`: the bundle's contractions [-].
    - `taken`: fluid of each unit since rest [m³], units last.
    - `sets`: of units that may be fed.
    - `owner`: the state that each set belongs to.

    **Returns:** what to do for each demand, without derivatives.
    """
    units, close = len(curves.kind), _CLOSE * (1 + np.abs(force))
    once, place = np.unique(strain, return_inverse=True)  # strains that many demands share
    none, full, least, most, at_least, at_most = (
        x[place][:, curves.kind] * share
        for x, share in zip(
            _limits(curves, once), (*[curves.throttled.sum(axis=1)] * 4, 1, 1), strict=True
        )
    )
    base = full @ sets.full.T.astype(float) + none @ (~sets.full).T.astype(float)
    chosen = sets.throttled.T.astype(float)
    low, high = base + (least - none) @ chosen, base + (most - none) @ chosen
    off = np.maximum(np.maximum(low - force[:, None], force[:, None] - high), 0.0)
    reached = off.min(axis=1) <= EXACT
    # what flows back counts as nothing: then the fewest units are taken
    cost = np.maximum(taken, 0.0) @ sets.fed.T.astype(float)
    choice = np.argmin(
        np.where(reached[:, None], np.where(off <= EXACT, cost, np.inf), off), axis=1
    )

    every = np.arange(len(force))
    target = np.clip(force, low[every, choice], high[every, choice])
    held, fed = sets.full[choice], sets.throttled[choice]
    more = (target >= base[every, choice])[:, None]
    begun = np.where(held, 1.0, np.where(fed, np.where(more, at_most, at_least), 0.0))
    given = np.where(held, full, np.where(fed, np.where(more, most, least), none))
    unit = units - 1 - np.argmax(fed[:, ::-1], axis=1)
    level, there, slope = begun.copy(), np.zeros(len(force)), np.zeros(len(force))
    again = every
    while len(again):
        parts = (x[again] for x in (begun, given, unit, target, strain))
        level[again], there[again], slope[again] = _throttle(curves, *parts)
        earlier = fed & (np.arange(units) < unit[:, None])
        again = np.flatnonzero(reached & (np.abs(there - force) > close) & earlier.any(axis=1))
        unit[again] = units - 1 - np.argmax(earlier[again, ::-1], axis=1)
    reached &= np.abs(there - force) <= close
    state, stable = owner[choice], slope < 0
    own = level[every, unit] * curves.supply
    return Recruited(
        pressures=level * curves.supply,
        state=state + 1,
        force=there,
        status=np.where(reached, REACHED, np.where(there < force, ABOVE, BELOW)),
        stable=stable,
        solutions=Solutions(
            pressure=np.where(reached, own, np.nan)[:, None],
            state=np.where(reached, state + 1, 0)[:, None],
            stable=(reached & stable)[:, None],
        ),
        count=np.where(reached, 1, 0),
        unit=unit + 1,
    )


def _limits(curves: Curves, strain: np.ndarray) -> list[np.ndarray]:
    """Force [N] of one muscle of each kind, kinds last, at no and at supply pressure, the least and
    the largest; and the levels [-] of these two.
    """
    shape = (len(strain), len(curves.kinds))
    every = [np.zeros(shape) for _ in range(6)]
    for k in range(len(curves.kinds)):
        unit = np.full(len(strain), curves.kind.index(k))
        count = curves.throttled[unit, k]
        ends = (curves.at_nodes(unit, np.full(len(strain), n), strain) / count for n in (0, -1))
        every[0][:, k], every[1][:, k] = ends
        size = _BEYOND * (10.0 + np.abs(every[0][:, k]) + np.abs(every[1][:, k])) * count
        for side, sense in ((2, -1.0), (3, 1.0)):
            level = solve(curves, sense * size, strain, unit).nearest
            every[side][:, k] = curves.force(unit, level, strain)[0] / count
            every[side + 2][:, k] = level
    return every


def _throttle(
    curves: Curves, level: Any, given: Any, unit: Any, target: Any, strain: Any
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Levels [-] with that of one `unit` changed so that all together give the `target` [N], the
    lowest that does or the nearest; their force [N] and its slope in `strain` [N]. `given`: what
    each unit gives at its `level` [N].
    """
    every = np.arange(len(unit))
    rest = target - given.sum(axis=1) + given[every, unit]
    found = solve(curves, rest, strain, unit)
    level = level.copy()
    level[every, unit] = found.nearest
    owner, first = np.unique(found.owner, return_index=True)
    level[owner, unit[owner]] = found.level[first]
    units = level.shape[1]
    state, flat = np.tile(np.arange(units), len(unit)), level.reshape(-1)
    force, slope = curves.force(state, flat, np.repeat(strain, units))
    return level, force.reshape(level.shape).sum(axis=1), slope.reshape(level.shape).sum(axis=1)
