r"""Force over pressure of every recruitment state of a bundle, and the pressures of a given force.

In recruitment state $k$ the throttled units share one pressure $p$; with $w_{kj}$ muscles of kind
$j$ among them, and the other units at no or at supply pressure, the state's force is

$$F_k(p, \varepsilon) = H_k(\varepsilon) + \sum_j w_{kj} F_j(p, \varepsilon). \tag{B8}$$

A *level* is a pressure over the supply's. The force is taken at nodes over level, to which the
muscles' kinks at the demand's strain (free strain, onset of buckling, fold, collapse) and the
smooth extrema are added where they may reach the demand. Every change of sign between neighbors
brackets a root; a force that jumps past the demand is none. If no state has a root, the nearest
force is that of the nearest node, kink or extremum.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.array_namespace import slices
from ..core.module import unique_indices
from .pressurized import muscle_strain
from .states import States


if TYPE_CHECKING:
    from ..muscle import Muscle
    from ..muscle.piecewise import Piecewise, PressurizedMuscle
    from .bundle import Bundle

_CELLS = 64  # of the grid, dense at low pressures, where free strains change fastest
# a cell of common muscles changes the free strain by less; steep fibers on a soft bladder by 0.1
_MAX_STRAIN_STEP, _MAX_PIECES = 0.02, 16
_END_INSET = 1e-6  # of the supply: nodes this near to both ends show the slope there
_BATCH = 2**13  # searches at once: their forces at all nodes take 40 MB
ROOT_TOLERANCE = 2e-10  # N: a force this near to the demand meets it
_SUM_ROUNDING = 1e-13  # of a force: rounding of a sum over units
_LEVEL_ROUNDING = 4 * 2.0**-52  # of a level
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
        self.free_strain = free_strain = self.nodes.column.free_strain
        # most laws buckle at the free strain itself, and some strains are infinite: no kinks
        self.kinks = {
            kink: np.where(np.isfinite(strains), strains, np.nan) + 0.0 * levels
            for kink, strains in enumerate(_kink_strains(self.nodes))
            if kink == 0 or strains is not free_strain
        }

    def strain(self, plates: Array) -> Array:
        """Strain of the muscle [-] at the `plates`' [-]."""
        return plates if self.ratio is None else muscle_strain(self.ratio, plates)

    def force_and_slope(self, level: Array, plates: Array, node: Array | None = None) -> Array:
        """Force at `level` and the `plates`' strain [-], and its slope in that strain, both [N];
        `node`: index of a level that is one of the grid's.

        Free and collapse strain at a pressure are most of its cost: a muscle that surely pulls, by
        the grid, needs neither.
        """
        pressure, strain = np.broadcast_arrays(level * self.supply, self.strain(plates))
        pull = self.law.tension.pull(pressure, strain)
        force, slope = (
            np.array(np.broadcast_to(x, strain.shape)) for x in (pull.force, pull.slope)
        )
        cell = np.searchsorted(self.levels[1:-1], level, "right")
        free_strain = np.minimum(self.free_strain[:-1], self.free_strain[1:])[cell]
        # without a force: a free strain that falls with pressure within a cell
        resists = (strain >= free_strain) | (force <= 0)
        if resists.any():
            if node is None:
                muscle = self.law.at(pressure[resists])
            else:
                muscle = self.nodes.take(np.broadcast_to(node, strain.shape)[resists])
            force[resists], slope[resists] = muscle.force_and_slope(strain[resists])
        return np.array([force, slope if self.ratio is None else slope * self.ratio])

    def kink_distance(self, kink: int, level: Array, plates: Array) -> Array:
        """A number that is zero at the `level` [-] whose `kink` is at the `plates`' strain [-]."""
        strain, pressure = self.strain(plates), level * self.supply
        if kink == 0:  # the force of tension vanishes at the free strain, and is known at once
            return self.law.tension.pull(pressure, strain).force
        return _kink_strains(self.law.at(pressure))[kink] - strain


class StateCurves:
    """Force over level of every state of a bundle, (B8), at any strain, by the muscles' laws."""

    def __init__(self, bundle: "Bundle", supply: float, states: States, resistance: bool):
        """`supply`: $P_s$ [Pa]. Each of independent units is a state by itself."""
        units = bundle.motor_units
        self.supply, self.resistance = supply, resistance
        unique, self.kind = unique_indices([unit.muscle for unit in units])
        curves: list[ForceOverLevel] | None = bundle.cache.get("muscle curves")
        if curves is None or curves[0].supply != supply:
            muscles = [units[i].muscle for i in unique]
            ratios = [None if bundle.ratios is None else float(bundle.ratios[i]) for i in unique]
            levels = _grid([muscle.law for muscle in muscles], supply)
            curves = [
                ForceOverLevel(muscle, ratio, supply, levels)
                for muscle, ratio in zip(muscles, ratios, strict=True)
            ]
            bundle.cache["muscle curves"] = curves  # whole: other threads may look at it
        self.muscles = curves
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
        """Force of one muscle of each kind and its slope [N], by [2, `strain` [-], node, kind]."""
        arguments = self.levels, strain[:, None], np.arange(len(self.levels))
        return np.stack([self._push(x.force_and_slope(*arguments)) for x in self.muscles], axis=-1)

    def force_and_slope(self, state: Array, level: Array, strain: Array) -> Array:
        """Force of the units that each `state` throttles, and its slope in strain, both [N]."""
        total = np.zeros((2, len(state)))
        for j, muscle in enumerate(self.muscles):
            count = self.throttled[state, j]
            if len(i := np.flatnonzero(count)):
                total[:, i] += count[i] * self._push(muscle.force_and_slope(level[i], strain[i]))
        return total

    def _push(self, forces: Array) -> Array:
        """Force and slope [N] of muscles, which don't push if resistance is neglected."""
        return forces if self.resistance else np.where(forces[0] > 0, forces, 0.0)


def _grid(laws: "list[Piecewise]", supply: float) -> Array:
    """One row of levels [-] for all `laws`, those of the tunings' kinks among them; more in cells
    in which the free strain of a muscle rises steeply, and on both sides of a level where one of
    its kinks begins or ends, as collapse does at some pressure: there the force jumps.
    """
    from scipy.optimize import elementwise  # 0.25 s that a force doesn't need

    tunings = [law.tension.tuning for law in laws]
    kinks = [np.ravel(t.pressures + np.asarray(t.dead_band)[..., None]) / supply for t in tunings]
    kinks = np.concatenate([*kinks, [0.0, 1.0]])
    even = (np.arange(_CELLS + 1) / _CELLS) ** 2
    levels = _rising(even, kinks, kinks + _END_INSET, kinks - _END_INSET)
    for law in laws:  # the force may rise and fall again in a steep cell
        change = np.abs(np.diff(law.tension.free_strain(levels * supply)))
        pieces = np.clip(np.ceil(change / _MAX_STRAIN_STEP), 1, _MAX_PIECES)
        position = np.concatenate([[0], np.cumsum(pieces)])
        levels = np.interp(np.arange(position[-1] + 1), position, levels)
    ends = [levels]
    for law in laws:
        for kink, strains in enumerate(_kink_strains(law.at(levels * supply))):

            def presence(level: Array, law: "Piecewise" = law, kink: int = kink) -> Array:
                # changes its sign where the kink begins or ends
                exists = np.isfinite(_kink_strains(law.at(level * supply))[kink])
                return np.where(exists, -1.0, 1.0) + 0.0 * level

            exists = np.isfinite(strains + 0.0 * levels)
            if len(i := np.flatnonzero(exists[1:] != exists[:-1])):
                end = elementwise.find_root(presence, (levels[i], levels[i + 1])).x
                ends += [end - _SIDE, end + _SIDE]
    return _rising(*ends)


def _rising(*levels: Array) -> Array:
    """All levels [-] from 0 to 1, in order, each once."""
    rising = np.sort(np.concatenate(levels))
    rising = rising[(rising >= 0) & (rising <= 1)]
    return rising[run_starts(rising)]


def _kink_strains(muscle: "PressurizedMuscle") -> list[Array]:
    """Strains [-] at which the force of a muscle has kinks, the free strain first."""
    folds = muscle.law.buckling.folds(muscle.column)
    return [muscle.column.free_strain, muscle.onset, muscle.collapse_strain, *folds]


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


def find_roots(
    curves: StateCurves, force: Array, strain: Array, state: Array | None = None
) -> Roots:
    """All levels of all states, or of one a demand, that give a `force` [N] at a `strain` [-]."""
    states = np.arange(curves.states) if state is None else state[:, None]
    states = np.broadcast_to(states, (len(force), states.shape[-1]))
    parts = []
    for i in slices(len(force), max(1, _BATCH // states.shape[-1])):
        roots = _roots_of_batch(curves, force[i], strain[i], states[i])
        parts.append(roots._replace(demand=roots.demand + i.start))
    return Roots(*map(np.concatenate, zip(*parts, strict=True)))


class _Searches:
    """One search for each of the `states` of each demand: of the levels at which the force of the
    units that it throttles is the `target` [N]. Arrays are by search; `fixed`: force and slope [N]
    of the other units, `on_grid`: force beyond the target at the grid's nodes [N].
    """

    def __init__(self, curves: StateCurves, force: Array, strain: Array, states: Array):
        self.curves, self.demands = curves, len(force)
        self.demand, column = np.indices(states.shape).reshape(2, -1)
        self.state, self.plates = states[self.demand, column], strain[self.demand]
        forces = curves.force_at_nodes(strain)
        fixed = forces[:, :, 0] @ curves.vented.T + forces[:, :, -1] @ curves.full.T
        self.fixed = fixed[:, self.demand, self.state]
        self.target = force[self.demand] - self.fixed[0]
        throttled = (forces[0] @ curves.throttled.T)[self.demand, :, self.state]
        self.on_grid = throttled - self.target[:, None]

    def forces(self, level: Array, search: Array) -> Array:
        """Force and its slope [N] of the units that each search throttles, at its `level` [-]."""
        return self.curves.force_and_slope(self.state[search], level, self.plates[search])

    def excess(self, level: Array, search: Array) -> Array:
        """Force beyond the target [N] at the `level` [-] of each search."""
        return self.forces(level, search)[0] - self.target[search]

    def least(self, distance: Array, search: Array) -> Array:
        """Least `distance` [N] among the searches of each demand."""
        distances = np.full(self.demands, np.inf)
        np.minimum.at(distances, self.demand[search], distance)
        return distances

    def nodes(self) -> tuple[Array, Array, Array]:
        """Nodes of all searches, in order, between two of which the force has one root at most:
        index of the search, level [-], and force beyond the target [N].
        """
        count, levels = len(self.demand), self.curves.levels
        every = np.arange(count)
        slack = TIE + self.least(np.abs(self.on_grid).min(axis=1), every)[self.demand]
        near = _may_reach_zero(self.on_grid, slack[:, None])
        kink_search, kink_level, is_kink = _kinks_near(self.curves, self.state, self.plates, near)
        position = kink_search * len(levels) + np.searchsorted(levels, kink_level)
        search = np.insert(np.repeat(every, len(levels)), position, kink_search)
        level = np.insert(np.tile(levels, count), position, kink_level)
        excess = self.excess(kink_level, kink_search)
        excess = np.insert(self.on_grid.ravel(), position, excess)
        smooth = ~np.insert(np.zeros(self.on_grid.size, bool), position, is_kink)
        return insert_extrema(self.excess, search, level, excess, slack[search], smooth)


def _roots_of_batch(curves: StateCurves, force: Array, strain: Array, states: Array) -> Roots:
    """Roots of demands that fit the memory, of a row of `states` each."""
    searches = _Searches(curves, force, strain, states)
    search, level, excess = searches.nodes()
    exact_search, exact_level = _exact_roots(searches, search, level, excess)

    distance, owner = np.abs(excess), searches.demand[search]
    nearest = searches.least(distance, search)
    nearest[searches.demand[exact_search]] = -np.inf  # a demand that is met
    ties = np.flatnonzero(distance <= nearest[owner] + TIE)
    first = ties[run_starts(owner[ties])]
    exact = np.arange(len(exact_search) + len(first)) < len(exact_search)
    search, level = np.append(exact_search, search[first]), np.append(exact_level, level[first])
    order = np.lexsort((level, search))
    search, level = search[order], level[order]
    forces = searches.forces(level, search) + searches.fixed[:, search]
    return Roots(searches.demand[search], searches.state[search], level, exact[order], *forces)


def _exact_roots(
    searches: _Searches, search: Array, level: Array, excess: Array
) -> tuple[Array, Array]:
    """Search and level [-] of each root, by the nodes of all searches: nodes that meet the demand,
    and changes of sign between two that don't.
    """
    from scipy.optimize import elementwise

    tolerance = (ROOT_TOLERANCE + _SUM_ROUNDING * np.abs(searches.target))[search]
    meets, linked = np.abs(excess) <= tolerance, search[1:] == search[:-1]
    # a run of nodes that all meet the demand counts once, by its first
    first = meets.copy()
    first[1:] &= ~(meets[:-1] & linked)
    # an endpoint that is an earlier state's, too, counts there
    owns_start, owns_end = (x[searches.state[search]] for x in searches.curves.owns_endpoints)
    first &= ((level > 0) | owns_start) & ((level < 1) | owns_end)
    changes = linked & ~meets[:-1] & ~meets[1:] & ((excess[:-1] > 0) != (excess[1:] > 0))
    i = np.flatnonzero(changes)
    crossing = elementwise.find_root(searches.excess, (level[i], level[i + 1]), args=(search[i],))
    crosses = np.abs(crossing.f_x) <= tolerance[i]  # else the force jumps past the demand
    roots = np.append(search[first], search[i[crosses]])
    return roots, np.append(level[first], crossing.x[crosses])


def _kinks_near(
    curves: StateCurves, state: Array, plates: Array, near: Array
) -> tuple[Array, Array, Array]:
    """Kinks of throttled muscles in the cells `near` of each search, each between a point on both
    of its sides: search and level [-], in order, and whether it is the kink itself.
    """
    from scipy.optimize import elementwise

    columns = [np.zeros((3, 0))]
    for j, muscle in enumerate(curves.muscles):
        candidate, cell = np.nonzero(near & (curves.throttled[state, j] > 0)[:, None])
        strain = muscle.strain(plates)[candidate]
        for kink, strains in muscle.kinks.items():
            i = np.flatnonzero((strains[cell] - strain) * (strains[cell + 1] - strain) < 0)
            if not len(i):
                continue
            ends, search = (curves.levels[cell[i]], curves.levels[cell[i] + 1]), candidate[i]
            distance = partial(muscle.kink_distance, kink)
            level = elementwise.find_root(distance, ends, args=(plates[search],)).x
            for side, is_kink in zip((ends[0], level, ends[1]), (0, 1, 0), strict=True):
                x = level + _KINK_INSET * (side - level)
                columns.append(np.array([search, x, np.full(len(i), is_kink)])[:, level > 0])
    search, level, is_kink = np.concatenate(columns, axis=1)
    order = np.lexsort((level, search))
    search, level, is_kink = search[order].astype(int), level[order], is_kink[order] > 0
    new = (np.diff(search, prepend=-1) > 0) | (np.diff(level, prepend=-1) > 0)
    return search[new], level[new], is_kink[new]


def insert_extrema(
    function: Callable[[Array, Array], Array],
    row: Array,
    x: Array,
    excess: Array,
    slack: Array | float,
    smooth: Array,
) -> tuple[Array, Array, Array]:
    """Nodes of curves with the extrema that may come as near to zero as `slack` [N]: `row` of the
    curve, `x` [-], and `excess` [N], the `function` of x and row; `smooth`: false at a known kink,
    which is an extremum itself, or none.
    """
    sign = np.where(excess[1:-1] > 0, 1.0, -1.0)
    windows = (slice(None, -2), slice(1, -1), slice(2, None))
    before, middle, after = (sign * excess[window] for window in windows)
    is_turn = (row[2:] == row[:-2]) & smooth[1:-1] & (middle > 0)
    i = np.flatnonzero(is_turn & (middle <= np.minimum(before, after)))
    before, middle, after = before[i], middle[i], after[i]
    left, right = x[i + 1] - x[i], x[i + 2] - x[i + 1]
    # a convex curve stays above the chords of both sides, extended beyond the middle
    depth = np.maximum((before - middle) * right / left, (after - middle) * left / right)
    slack = np.broadcast_to(slack, x.shape)[i + 1]
    i = i[(depth > ROOT_TOLERANCE) & (middle - depth < slack)]
    if not len(i):
        return row, x, excess
    from scipy.optimize import elementwise  # 0.25 s that a force doesn't need

    turn = elementwise.find_minimum(
        lambda x, row, sign: sign * function(x, row),
        tuple(x[window][i] for window in windows),
        args=(row[i + 1], sign[i]),
        tolerances={"xrtol": _LEVEL_ROUNDING, "fatol": 0.25 * ROOT_TOLERANCE},
    )
    depth = sign[i] * turn.f_x
    exists = np.isfinite(turn.x)  # else, to rounding, a neighbor is lower
    i, added = i[exists] + 1, (row[i[exists] + 1], turn.x[exists], depth[exists])
    position = i + (added[1] > x[i])
    row, x, excess = map(np.insert, (row, x, excess), [position] * 3, added)
    return row, x, excess


def _may_reach_zero(excess: Array, slack: Array) -> Array:
    """Mask of cells, on the last axis, in which a curve may come as near to zero as `slack` [N]."""
    left, right = excess[:, :-1], excess[:, 1:]
    # between its ends a curve goes no farther than it changes there and in the neighboring cells
    change = np.abs(right - left)
    margin = change.copy()
    margin[:, 1:] = np.maximum(margin[:, 1:], change[:, :-1])
    margin[:, :-1] = np.maximum(margin[:, :-1], change[:, 1:])
    # strictly: a plateau at the nearest force holds nothing nearer
    return 0.5 * (np.abs(left + right) - change) - margin < slack
