r"""Force over pressure of every recruitment state of a bundle, and the pressures of a given force.

In recruitment state $k$ the throttled units share one pressure $p$; with $w_{kj}$ muscles of kind
$j$ among them, and the other units at no or at supply pressure, the state's force is

$$F_k(p, \varepsilon) = H_k(\varepsilon) + \sum_j w_{kj} F_j(p, \varepsilon). \tag{B8}$$

A *level* is a pressure over the supply's. Free and collapse strains of each kind of muscle are
solved once, at nodes over level.

**Search for the levels of a force.** Of the nodes, those of all cells that may hold the demanded
force are taken. The levels at which a muscle has a kink at the demand's strain (its free strain,
onset of buckling, fold or collapse strain) join them, with a level on each side, as do then the
smooth extrema between them that may reach the force. Every change of sign between neighbors
brackets a root; a force that jumps past the demand is none. If no state has a root, the nearest
force is that of the nearest node, kink or extremum.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.array_namespace import slices
from ..core.module import unique_indices
from ..core.roots import find_root, refine_root
from .pressurized import muscle_strain
from .states import States


if TYPE_CHECKING:
    from ..muscle import Muscle
    from ..muscle.piecewise import PressurizedMuscle

_CELLS = 64  # of the grid, dense at low pressures, where free strains change fastest
# a cell of common muscles changes the free strain by less; steep fibers on a soft bladder by 0.1
_MAX_STRAIN_STEP, _MAX_PIECES = 0.02, 16
_END_INSET = 1e-6  # of the supply: nodes this near to both ends show the slope there
_BATCH = 2**13  # searches at once: their forces at all nodes take 40 MB
ROOT_TOLERANCE = 2e-10  # N: a force this near to the demand meets it
_SUM_ROUNDING = 1e-13  # of a force: rounding of a sum over units
_STEP = 1e-8  # of the supply: the root of rounding, for a difference quotient
_LEVEL_ROUNDING = 4 * 2.0**-52  # of a level: where the search for a jump ends
_KINK_SHARE = 1e-11  # of a kink's distance at the end of its cell: it is at the kink
TIE = 1e-10  # N: forces this near to each other are equal
_SIDE = 1e-9  # of the supply: levels this far apart give forces that differ by more than rounding
_KINK_INSET = 1e-2  # of a cell: nodes this far from a kink show the slopes on its two sides

Array = np.ndarray


class ForceOverLevel:
    """Force of one kind of muscle, by its law, over level: its pressure over the supply's, from 0
    to 1. A grid of levels says which region a muscle is in and where searches start.

    `kinks`: for each kind of kink, by number, the muscle's strain there [-] at the grid's nodes.
    """

    def __init__(self, muscle: "Muscle", ratio: float | None, supply: float, levels: Array):
        """`ratio`: $L/L_i$ [-] or `None`; `supply`: $P_s$ [Pa]; `levels`: nodes of the grid [-]."""
        self.law, self.ratio, self.supply, self.levels = muscle.law, ratio, supply, levels
        self.nodes = self.law.at(levels * supply)
        self.free_strain = self.nodes.column.free_strain
        # most laws buckle at the free strain itself, and some strains are infinite: no kinks
        self.kinks = {
            i: np.broadcast_to(strains, levels.shape)
            for i, strains in enumerate(_kink_strains(self.nodes))
            if i == 0 or not (strains is self.free_strain or np.all(np.isinf(strains)))
        }

    def strain(self, plates: Array) -> Array:
        """Strain of the muscle [-] at the `plates`' [-]."""
        return plates if self.ratio is None else muscle_strain(self.ratio, plates)

    def force_at_nodes(self, plates: Array) -> Array:
        """As `force` at all nodes, by the plates' strain [-] and node."""
        strain = self.strain(plates)[:, None]
        pull = self.law.tension.pull(self.levels * self.supply, strain)
        shape = (len(plates), len(self.levels))
        force, slope = (np.array(np.broadcast_to(x, shape)) for x in (pull.force, pull.slope))
        row, node = np.nonzero(strain > self.free_strain)
        if len(row):
            force[row, node], slope[row, node] = self.nodes.take(node).force(strain[row, 0])
        return self._between_plates(force, slope)

    def force(self, level: Array, plates: Array) -> Array:
        """Force at `level` and the `plates`' strain [-], and its slope in that strain, both [N].

        Free and collapse strain at a pressure are most of its cost: a muscle that surely pulls, by
        the grid, needs neither.
        """
        strain, pressure = self.strain(plates), level * self.supply
        pull = self.law.tension.pull(pressure, strain)
        force, slope = (np.array(np.broadcast_to(x, level.shape)) for x in (pull.force, pull.slope))
        cell = np.searchsorted(self.levels[1:-1], level, "right")
        free_strain = np.minimum(self.free_strain[:-1], self.free_strain[1:])[cell]
        # without a force: a free strain that falls with pressure within a cell
        resists = (strain >= free_strain) | (force <= 0)
        if resists.any():
            muscle = self.law.at(pressure[resists])
            force[resists], slope[resists] = muscle.force(strain[resists])
        return self._between_plates(force, slope)

    def _between_plates(self, force: Array, slope: Array) -> Array:
        """Force and its slope in the plates' strain [N]."""
        return np.array([force, slope if self.ratio is None else slope * self.ratio])

    def kink_distance(self, kink: int, level: Array, plates: Array) -> Array:
        """Distance from the `plates`' strain [-] to a `kink`, by number, at `level` [-], to zero
        of which a search for the kink goes.
        """
        strain, pressure = self.strain(plates), level * self.supply
        if kink == 0:  # the force of tension vanishes at the free strain, and is found at once
            return self.law.tension.pull(pressure, strain).force
        return _kink_strains(self.law.at(pressure))[kink] - strain


class StateCurves:
    """Force over level of every state of a bundle, (B8), at any strain, by the muscles' laws."""

    def __init__(self, bundle: Any, supply: float, states: States, resistance: bool):
        """`supply`: $P_s$ [Pa]. Each of independent units is a state by itself."""
        units = bundle.motor_units
        self.supply, self.resistance = supply, resistance
        unique, self.kind = unique_indices([unit.muscle for unit in units])
        self.muscles = _muscle_curves(bundle, unique, supply)
        self.levels = self.muscles[0].levels
        masks = states.throttled, states.vented, states.full
        self.owns_endpoints = states.owns_endpoints
        if states.independent:
            identity = np.eye(len(units), dtype=bool)
            masks = identity, 0 * identity, 0 * identity
            self.owns_endpoints = np.diag(identity), np.diag(identity)
        counts = np.eye(len(unique))[list(self.kind)] * np.reshape(bundle.counts, (-1, 1))
        self.throttled, self.vented, self.full = (x.astype(float) @ counts for x in masks)
        self.states = len(self.throttled)

    def force_at_nodes(self, strain: Array) -> Array:
        """Force of one muscle of each kind and its slope [N], by `strain` [-], node and kind."""
        forces = [self._resisting(muscle.force_at_nodes(strain)) for muscle in self.muscles]
        return np.stack(forces, axis=-1)

    def force(self, state: Array, level: Array, strain: Array) -> Array:
        """Force of the units that each `state` throttles, and its slope in strain, both [N]."""
        total = np.zeros((2, len(state)))
        for j, muscle in enumerate(self.muscles):
            count = self.throttled[state, j]
            if len(i := np.flatnonzero(count)):
                total[:, i] += count[i] * self._resisting(muscle.force(level[i], strain[i]))
        return total

    def _resisting(self, forces: Array) -> Array:
        """Force and slope [N] of muscles, which may not push if resistance is neglected."""
        return forces if self.resistance else np.where(forces[0] > 0, forces, 0.0)


def _muscle_curves(bundle: Any, unique: list[int], supply: float) -> list[ForceOverLevel]:
    """Curves of each kind of muscle, by its first unit; the bundle keeps those of one supply, as
    their nodes take longer than a demand.
    """
    curves = bundle.cache.get("muscle curves")
    if curves is None or curves[0].supply != supply:
        muscles = [bundle.motor_units[i].muscle for i in unique]
        levels = _add_kink_ends(pressure_grid(muscles, supply), muscles, supply)
        ratios = bundle.ratios
        curves = [
            ForceOverLevel(muscle, None if ratios is None else float(ratios[i]), supply, levels)
            for i, muscle in zip(unique, muscles, strict=True)
        ]
        bundle.cache["muscle curves"] = curves  # whole: other threads may look at it
    return curves


def _add_kink_ends(levels: Array, muscles: "list[Muscle]", supply: float) -> Array:
    """Nodes `levels` [-] with those at whose sides kinks of `muscles` begin or end, as collapse
    does at some pressure: there the force jumps.
    """
    from scipy.optimize import elementwise  # 0.25 s that a force doesn't need

    ends = [levels]
    for law in (muscle.law for muscle in muscles):
        for number, strains in enumerate(_kink_strains(law.at(levels * supply))):
            exists = np.broadcast_to(np.isfinite(strains), levels.shape)
            if len(i := np.flatnonzero(exists[1:] != exists[:-1])):

                def side(level: Array, law: Any = law, number: int = number) -> Array:
                    strain = _kink_strains(law.at(level * supply))[number]
                    return np.where(np.isfinite(strain), -1.0, 1.0) + 0.0 * level

                end = elementwise.find_root(side, (levels[i], levels[i + 1])).x
                ends += [end - _SIDE, end + _SIDE]
    levels = np.clip(np.sort(np.concatenate(ends)), 0.0, 1.0)
    return levels[run_starts(levels)]


def _kink_strains(muscle: "PressurizedMuscle") -> list[Array]:
    """Strains [-] at which the force of a muscle has kinks, the free strain first."""
    folds = muscle.law.buckling.folds(muscle.column)
    return [muscle.column.free_strain, muscle.onset, muscle.collapse_strain, *folds]


def pressure_grid(muscles: "list[Muscle]", supply: float) -> Array:
    """Levels of the grid [-], those of the tunings' kinks among them; more of them in cells in
    which the free strain of a muscle rises steeply.
    """
    tunings = [muscle.tuning for muscle in muscles]
    kinks = [np.ravel((t.pressures + np.asarray(t.dead_band)[..., None]) / supply) for t in tunings]
    kinks = np.concatenate([*kinks, [0.0]])
    kinks = kinks[kinks < 1]
    even = (np.arange(_CELLS + 1) / _CELLS) ** 2
    levels = np.concatenate([even, kinks, kinks + _END_INSET, kinks - _END_INSET, [1 - _END_INSET]])
    levels = np.sort(levels[(levels >= 0) & (levels <= 1)])
    levels = levels[run_starts(levels)]
    for muscle in muscles:  # the force may rise and fall again in a steep cell
        change = np.abs(np.diff(muscle.law.tension.free_strain(levels * supply)))
        pieces = np.minimum(np.ceil(change / _MAX_STRAIN_STEP), _MAX_PIECES).astype(int)
        inner = [
            np.linspace(levels[i], levels[i + 1], pieces[i] + 1)[1:-1]
            for i in np.flatnonzero(pieces > 1)
        ]
        levels = np.sort(np.concatenate([levels, *inner]))
    return levels


def run_starts(values: Array) -> Array:
    """Index of the first of each run of equal `values` [any unit] that rise from zero or more."""
    return np.flatnonzero(np.diff(values, prepend=-1))  # `np.unique` imports masked arrays


class Roots(NamedTuple):
    """Solutions in order: index of the `demand`, its `state` and `level` [-], and whether it is
    `exact`: a demand without a solution has one root, of the nearest force. `force` there and
    `slope` in strain [N].
    """

    demand: Array
    state: Array
    level: Array
    exact: Array
    force: Array
    slope: Array


class Searches(NamedTuple):
    """Searches, a row each, for the levels at which a `state` gives a `target` [N] at a `strain`
    [-]; `demand`: index of the demand that each serves.
    """

    curves: StateCurves
    demand: Array
    state: Array
    strain: Array
    target: Array

    def excess(self, row: Array, level: Array) -> Array:
        """Force beyond the target [N] at a `level` [-]."""
        state, strain = self.state[row], self.strain[row]
        force, _ = self.curves.force(*(x.ravel() for x in (state, level, strain)))
        return force.reshape(row.shape) - self.target[row]


class Points(NamedTuple):
    """Points on force curves, in order of `row` and `level` [-]: force beyond the target
    (`excess` [N]), whether the curve goes on to the next point (`linked`), and whether it has a
    kink there (`kinked`).
    """

    row: Array
    level: Array
    excess: Array
    linked: Array
    kinked: Array

    def insert(self, row: Array, level: Array, excess: Array, kinked: Array) -> "Points":
        """Points with additional ones, which are linked to their neighbors."""
        added = (row, level, excess, np.ones(len(row), bool), kinked)
        columns = [np.concatenate(pair) for pair in zip(self, added, strict=True)]
        order = np.lexsort((columns[1], columns[0]))
        is_new = [np.diff(x[order], prepend=-1) != 0 for x in columns[:2]]
        order = order[is_new[0] | is_new[1]]
        return Points(*(x[order] for x in columns))


def find_roots(
    curves: StateCurves, force: Array, strain: Array, state: Array | None = None
) -> Roots:
    """All levels of all states, or of one a demand, that give a `force` [N] at a `strain` [-]."""
    states = np.arange(curves.states) if state is None else state[:, None]
    states = np.broadcast_to(states, (len(force), states.shape[-1]))
    parts = []
    for batch in slices(len(force), max(1, _BATCH // states.shape[-1])):
        demand, column = np.indices(states[batch].shape).reshape(2, -1)
        F, eps, state = force[batch], strain[batch], states[batch][demand, column]
        forces = curves.force_at_nodes(eps)
        fixed = forces[:, :, 0] @ curves.vented.T + forces[:, :, -1] @ curves.full.T
        target = F[demand] - fixed[0, demand, state]
        excess = (forces[0] @ curves.throttled.T)[demand, :, state] - target[:, None]
        searches = Searches(curves, demand, state, eps[demand], target)
        row, level, exact = _search_levels(searches, len(F), excess)
        demand, state = demand[row], state[row]
        forces = curves.force(state, level, eps[demand]) + fixed[:, demand, state]
        parts.append((demand + batch.start, state, level, exact, *forces))
    return Roots(*map(np.concatenate, zip(*parts, strict=True)))


def _search_levels(searches: Searches, count: int, excess: Array) -> tuple[Array, Array, Array]:
    """Row, level [-] and exactness of each root; `excess`: at all nodes [N]."""
    curves, demand = searches.curves, searches.demand

    def nearest_of(distance: Array, row: Array) -> Array:
        """Least `distance` [N] among the rows of each demand."""
        nearest = np.full(count, np.inf)
        np.minimum.at(nearest, demand[row], distance)
        return nearest

    slack = nearest_of(np.abs(excess).min(axis=1), np.arange(len(demand)))[demand]
    cells = _may_reach_zero(excess, slack[:, None] + TIE)
    padded = np.pad(cells, ((0, 0), (1, 1)))
    # neighbors show where a curve turns
    padded[:, 1:-1] = padded[:, :-2] | padded[:, 1:-1] | padded[:, 2:]
    row, node = np.nonzero(padded[:, :-1] | padded[:, 1:])
    level, linked = curves.levels[node], padded[row, node + 1]
    points = Points(row, level, excess[row, node], linked, np.zeros(len(row), bool))
    points = _insert_kinks(searches, points, node, slack)
    points = _insert_extrema(searches, points, slack)
    row, level = _collect_roots(searches, points)

    owner, distance = demand[points.row], np.abs(points.excess)
    nearest = nearest_of(distance, points.row)
    nearest[demand[row]] = -np.inf  # a reached one
    ties = np.flatnonzero(distance <= nearest[owner] + TIE)
    first = ties[run_starts(owner[ties])]
    exact = np.arange(len(row) + len(first)) < len(row)
    row, level = np.append(row, points.row[first]), np.append(level, points.level[first])
    order = np.lexsort((level, row))
    return row[order], level[order], exact[order]


def _insert_kinks(searches: Searches, points: Points, node: Array, slack: Array) -> Points:
    """Points, all at a `node`, with the kinks in cells as near to the target as `slack` [N], and a
    point on each side of them.
    """
    curves, plates = searches.curves, searches.strain[points.row]
    is_near = _may_reach_zero(points.excess, slack[points.row][:-1], points.linked[:-1])
    throttled = curves.throttled[searches.state[points.row]]
    rows, levels, kinked = [], [], []
    for j, muscle in enumerate(curves.muscles):
        strain, is_candidate = muscle.strain(plates), is_near & (throttled[:-1, j] > 0)
        for kink, strains in muscle.kinks.items():
            miss = strains[node] - strain
            finite = np.isfinite(miss)
            is_cell = is_candidate & finite[1:] & finite[:-1] & (miss[1:] * miss[:-1] < 0)
            if len(i := np.flatnonzero(is_cell)):
                left, right = points.level[i], points.level[i + 1]
                distance = partial(muscle.kink_distance, kink)
                ends = (left, right), (miss[i], miss[i + 1])
                level, _ = _find_level(distance, plates[i], *ends, _KINK_SHARE * np.abs(miss[i]))
                rows.append(np.tile(points.row[i], 3))
                levels += [level + _KINK_INSET * (end - level) for end in (left, level, right)]
                kinked.append(np.repeat([False, True, False], len(i)))
    if not rows:
        return points
    row, level = np.concatenate(rows), np.concatenate(levels)
    return points.insert(row, level, searches.excess(row, level), np.concatenate(kinked))


def _insert_extrema(searches: Searches, points: Points, slack: Array) -> Points:
    """Points with the extrema that come as near to the target as `slack` [N]."""
    row, level = find_extrema(
        searches.excess, points.row, points.level, points.excess, points.linked, slack[points.row],
        ~points.kinked,
    )  # fmt: skip
    if not len(row):
        return points
    return points.insert(row, level, searches.excess(row, level), np.zeros(len(row), bool))


def find_extrema(
    function: Callable[[Array, Array], Array], row: Array, x: Array, excess: Array, linked: Array,
    slack: Any, smooth: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Extrema of curves between points, by row and `x` [-], that may come as near to zero as
    `slack` [N]; `function`: of rows and x, whose values at the points are `excess` [N]; `linked`:
    where a curve goes on to the next point; `smooth`: false at a known kink, which is an extremum
    itself, or none.
    """
    sign = np.where(excess[1:-1] > 0, 1.0, -1.0)
    windows = (slice(None, -2), slice(1, -1), slice(2, None))
    before, middle, after = (sign * excess[window] for window in windows)
    left, right = np.diff(x)[:-1], np.diff(x)[1:]
    # a convex curve stays above the chords of both sides, extended beyond the middle
    depth = np.maximum((before - middle) * right / left, (after - middle) * left / right)
    is_turn = (
        linked[:-2]
        & linked[1:-1]
        & (middle > 0)
        & (before >= middle)
        & (after >= middle)
        & smooth[1:-1]
    )
    is_turn &= (depth > ROOT_TOLERANCE) & (middle - depth < np.broadcast_to(slack, x.shape)[1:-1])
    i = np.flatnonzero(is_turn)
    if not len(i):
        return row[i], x[i]
    from scipy.optimize import elementwise  # 0.25 s that a force doesn't need

    turn = elementwise.find_minimum(
        lambda x, row, sign: sign * function(row, x),
        tuple(x[window][i] for window in windows),
        args=(row[i + 1], sign[i]),
        tolerances={"xrtol": _LEVEL_ROUNDING, "fatol": 0.25 * ROOT_TOLERANCE},
    ).x
    exists = np.isfinite(turn)  # else, to rounding, a neighbor is lower
    return row[i + 1][exists], turn[exists]


def _collect_roots(searches: Searches, points: Points) -> tuple[Array, Array]:
    """Roots by row and level [-]: points that meet the target, and changes of sign."""
    tolerance = (ROOT_TOLERANCE + _SUM_ROUNDING * np.abs(searches.target))[points.row]
    meets = np.abs(points.excess) <= tolerance
    # a run of points that all meet it counts once, by its first
    follows = np.zeros(len(meets), bool)
    follows[1:] = meets[1:] & meets[:-1] & points.linked[:-1]
    first = meets & ~follows
    # an endpoint that is an earlier state's, too, counts there
    state = searches.state[points.row]
    owns_start, owns_end = (x[state] for x in searches.curves.owns_endpoints)
    first &= ((points.level > 0) | owns_start) & ((points.level < 1) | owns_end)
    change = points.linked[:-1] & ~meets[:-1] & ~meets[1:]
    i = np.flatnonzero(change & ((points.excess[:-1] > 0) != (points.excess[1:] > 0)))
    row = points.row[i]
    level, excess = ((x[i], x[i + 1]) for x in (points.level, points.excess))
    tolerance = tolerance[i]
    level, miss = _find_level(lambda x, row: searches.excess(row, x), row, level, excess, tolerance)
    crosses = np.abs(miss) <= tolerance  # else the force jumps past the target
    return (
        np.append(points.row[first], row[crosses]),
        np.append(points.level[first], level[crosses]),
    )


def _find_level(
    function: Callable[..., Array], argument: Array, ends: tuple[Array, Array],
    values: tuple[Array, Array], tolerance: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Levels [-] between two `ends` [-] at which a `function` of level and `argument` changes sign,
    and its values there; `values`: at the ends; `tolerance`: of a value that is zero.

    Newton's method, by difference quotients, takes half as many values as one without slopes. It
    ends short of a root that lies beside a kink, for which the slower one is there.
    """
    sign = np.where(values[0] > 0, 1.0, -1.0)

    def falling(argument: Array, level: Array) -> tuple[Array, Array]:
        value, beyond = function(np.stack([level, level + _STEP]), np.stack([argument, argument]))
        return sign * value, sign * (beyond - value) / _STEP

    secant = ends[0] + (ends[1] - ends[0]) * values[0] / (values[0] - values[1])
    level = refine_root(falling, argument, find_root(falling, argument, *ends, secant))
    level = np.clip(level, *ends)
    value = function(level, argument)
    if len(i := np.flatnonzero(np.abs(value) > tolerance)):
        from scipy.optimize import elementwise  # 0.25 s that a force doesn't need

        bracket = ends[0][i], ends[1][i]
        result = elementwise.find_root(function, bracket, args=(argument[i],))
        level[i], value[i] = result.x, result.f_x
    return level, value


def _may_reach_zero(excess: Array, slack: Array, linked: Array | bool = True) -> Array:
    """Mask of cells, on the last axis, in which a curve may come as near to zero as `slack` [N]."""
    left, right = excess[..., :-1], excess[..., 1:]
    # between its ends a curve goes no farther than it changes there and in the neighboring cells
    change = np.abs(right - left) * linked
    margin = change.copy()
    margin[..., 1:] = np.maximum(margin[..., 1:], change[..., :-1])
    margin[..., :-1] = np.maximum(margin[..., :-1], change[..., 1:])
    distance = 0.5 * (np.abs(left + right) - change)
    # strictly: a plateau at the nearest force holds nothing nearer
    return linked & (distance - margin < slack)
