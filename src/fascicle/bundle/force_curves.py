r"""Force over pressure of every recruitment state of a bundle, and the pressures of a given force.

In recruitment state $k$ the throttled units share one pressure $p$; with $w_{kj}$ muscles of kind
$j$ among them, and the other units at no or at supply pressure, the state's force is

$$F_k(p, \varepsilon) = H_k(\varepsilon) + \sum_j w_{kj} F_j(p, \varepsilon). \tag{B8}$$

Free and collapse strains of each kind of muscle are solved once, on a grid of pressures; forces at
the grid's nodes are closed forms. A *level* is a pressure over the supply's.

**Search for the levels of a force.** Cells of the grid that may hold the demanded force get the
levels at which a muscle has a kink at the demand's strain (its free strain, onset of buckling, fold
or collapse strain), then the extrema that may reach the demand. Every change of sign between
neighbors brackets a root; a force that jumps past the demand (at some pressure collapse ends for
good) is none. If no state has a root, the nearest force is that of the nearest node or extremum.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.array_namespace import slices
from ..core.module import unique_indices
from .pressurized import muscle_strain
from .states import States


if TYPE_CHECKING:
    from ..muscle import Muscle
    from ..muscle.piecewise import PressurizedMuscle

_CELLS = 64  # of the grid, dense at low pressures, where free strains change fastest
# a cell of common muscles changes the free strain by less; steep fibers on a soft bladder by 0.1
_MAX_STRAIN_STEP, _MAX_PIECES = 0.02, 16
_COLUMNS = 129  # strains of the force table: a step is some 0.002, as fine as a transition
_END_INSET = 1e-6  # of the supply: nodes this near to both ends show the slope there
_NEWTON_STEPS = 8  # at most: from the grid's free strain three are enough
_NEWTON_TOLERANCE = 1e-9  # of strain: the step after it is within rounding
FEW_CELLS = 2**12  # below it all cells are searched: selecting them costs as much
_BATCH = 2**16  # searches at once: their table of forces takes 40 MB
ROOT_TOLERANCE = 2e-10  # N: a force this near to the demand meets it
_SUM_ROUNDING = 1e-13  # of a force: rounding of a sum over units
TIE = 1e-10  # N: forces this near to each other are equal
_KINK_INSET = 1e-3  # of a cell: nodes this near to a kink show the slopes on both sides
_ZOOM_POINTS, _ZOOMS = 9, 5  # to 1e-3 of a bracket, where a parabola is exact to 1e-6

Array = np.ndarray
Residual = Callable[[Array, Array], Array]


class ForceOverLevel:
    """Force of one kind of muscle, by its law, over level: its pressure over the supply's, from 0
    to 1. A grid of levels says which region a muscle is in and where searches start.

    `kinks`: for each kind of kink, by number, the muscle's strain there [-] at the grid's nodes.
    """

    def __init__(
        self, muscle: "Muscle", ratio: float | None, supply: float, levels: Array, resistance: bool
    ):
        """`ratio`: $L/L_i$ [-] or `None`; `supply`: $P_s$ [Pa]; `levels`: nodes of the grid [-]."""
        self.law, self.ratio, self.supply, self.levels = muscle.law, ratio, supply, levels
        self.resistance, self.nodes = resistance, self.law.at(levels * supply)
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

    def force_at_nodes(self, node: Array, plates: Array) -> Array:
        """As `force` at a `node` of the grid, whose free and collapse strains are stored."""
        return self._between_plates(*self.nodes.take(node).force(self.strain(plates)))

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
            muscle = self.law.at(pressure[resists], self._free_strain(level[resists]))
            force[resists], slope[resists] = muscle.force(strain[resists])
        return self._between_plates(force, slope)

    def _between_plates(self, force: Array, slope: Array) -> Array:
        """Force, which may not push, and its slope in the plates' strain [N]."""
        forces = np.array([force, slope if self.ratio is None else slope * self.ratio])
        return forces if self.resistance else np.where(force > 0, forces, 0.0)

    def _free_strain(self, level: Array) -> Array:
        """Free strain [-] by Newton's method from the grid's, or by the law where that fails."""
        free = np.interp(level, self.levels, self.free_strain)
        for _ in range(_NEWTON_STEPS):
            pull = self.law.tension.pull(level * self.supply, free)
            step = pull.force / pull.slope
            free = free - step
            if np.all(np.abs(step) <= _NEWTON_TOLERANCE):
                return free
        return self.law.tension.free_strain(level * self.supply)

    def kink_residual(self, kink: int, level: Array, plates: Array) -> Array:
        """Strain of a `kink`, by number, less that of the muscle [-] at `level` and the plates'."""
        strain = self._free_strain(level)
        if kink > 0:
            strain = _kink_strains(self.law.at(level * self.supply, strain))[kink]
        return np.broadcast_to(strain, level.shape) - self.strain(plates)


class StateCurves:
    """Force over level of every state of a bundle, (B8), at any strain, by the muscles' laws."""

    def __init__(self, bundle: Any, supply: float, states: States, resistance: bool):
        """`supply`: $P_s$ [Pa]. Each of independent units is a state by itself."""
        units = bundle.motor_units
        self.supply = supply
        unique, self.kind = unique_indices([unit.muscle for unit in units])
        muscles = [units[i].muscle for i in unique]
        self.levels = pressure_grid(muscles, supply)
        ratios = [None] * len(units) if bundle.ratios is None else [float(x) for x in bundle.ratios]
        self.muscles = [
            ForceOverLevel(units[i].muscle, ratios[i], supply, self.levels, resistance)
            for i in unique
        ]
        masks = states.throttled, states.vented, states.full
        self.owns_endpoints = states.owns_endpoints
        if states.independent:
            identity = np.eye(len(units), dtype=bool)
            masks = identity, 0 * identity, 0 * identity
            self.owns_endpoints = np.diag(identity), np.diag(identity)
        counts = np.eye(len(unique))[list(self.kind)] * np.reshape(bundle.counts, (-1, 1))
        self.throttled, self.vented, self.full = (x.astype(float) @ counts for x in masks)
        self.states = len(self.throttled)
        self._table = np.array([np.inf, -np.inf]), np.zeros(0)

    def force_at_nodes(self, strain: Array, node: Array) -> Array:
        """Force of one muscle of each kind and its slope [N], by `strain` [-], `node` and kind."""
        forces = [muscle.force_at_nodes(node, strain[:, None]) for muscle in self.muscles]
        return np.stack(forces, axis=-1)

    def force(self, state: Array, level: Array, strain: Array) -> Array:
        """Force of the units that each `state` throttles, and its slope in strain, both [N]."""
        total = np.zeros((2, len(state)))
        for j, muscle in enumerate(self.muscles):
            count = self.throttled[state, j]
            if len(i := np.flatnonzero(count)):
                total[:, i] += count[i] * muscle.force(level[i], strain[i])
        return total

    def interpolate(self, state: Array, strain: Array) -> tuple[Array, Array]:
        """Force [N] of the units that each `state` throttles at every node, nodes last, linear
        between the columns of a table over `strain` [-], and its change between both columns [N].
        """
        columns, table = self._table  # read and replaced as one: threads share the curves
        low, high = min(strain.min(), columns[0]), max(strain.max(), columns[-1])
        if (low, high) != (columns[0], columns[-1]):
            columns = np.linspace(low, high, _COLUMNS)
            forces = self.force_at_nodes(columns, np.arange(len(self.levels)))[0]
            # nodes last: each state's row is read as one piece
            table = np.ascontiguousarray(np.moveaxis(forces @ self.throttled.T, -1, 1))
            self._table = columns, table
        position = np.interp(strain, columns, np.arange(_COLUMNS))
        column = np.minimum(position.astype(int), _COLUMNS - 2)
        weight = (position - column)[:, None]
        left, right = table[column, state], table[column + 1, state]
        return (1 - weight) * left + weight * right, np.abs(right - left)


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
        force, _ = self.curves.force(self.state[row], level, self.strain[row])
        return force - self.target[row]


class Points(NamedTuple):
    """Points on force curves, in order of `row` and `level` [-]: force beyond the target
    (`excess` [N]), whether the curve is continuous to the next point (`linked`), and whether the
    point is a kink.
    """

    row: Array
    level: Array
    excess: Array
    linked: Array
    kink: Array

    def insert(self, row: Array, level: Array, excess: Array, kink: Any = False) -> "Points":
        """Points with additional ones, which are linked to their neighbors."""
        added = (row, level, excess, *(np.full(len(row), x) for x in (True, kink)))
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
    nodes = np.arange(len(curves.levels))
    parts = []
    for batch in slices(len(force), max(1, _BATCH // states.shape[-1])):
        demand, column = np.indices(states[batch].shape).reshape(2, -1)
        F, eps, state = force[batch], strain[batch], states[batch][demand, column]
        is_few = len(demand) * len(nodes) <= FEW_CELLS
        forces = curves.force_at_nodes(eps, nodes if is_few else nodes[[0, -1]])
        fixed = forces[:, :, 0] @ curves.vented.T + forces[:, :, -1] @ curves.full.T
        target = F[demand] - fixed[0, demand, state]
        throttled = forces[0] @ curves.throttled.T
        excess = throttled[demand, :, state] - target[:, None] if is_few else None
        searches = Searches(curves, demand, state, eps[demand], target)
        row, level, exact = _search_levels(searches, len(F), excess)
        demand, state = demand[row], state[row]
        forces = curves.force(state, level, eps[demand]) + fixed[:, demand, state]
        parts.append((demand + batch.start, state, level, exact, *forces))
    return Roots(*map(np.concatenate, zip(*parts, strict=True)))


def _search_levels(
    searches: Searches, count: int, excess: Array | None
) -> tuple[Array, Array, Array]:
    """Row, level [-] and exactness of each root; `excess`: at all nodes [N], if it is known."""
    curves, demand, state, strain, target = searches

    def nearest_of(distance: Array, row: Array) -> Array:
        """Least `distance` [N] among the rows of each demand."""
        nearest = np.full(count, np.inf)
        np.minimum.at(nearest, demand[row], distance)
        return nearest

    if excess is None:  # cells that may hold the target or the nearest force, by the table
        forces, change = curves.interpolate(state, strain)
        forces -= target[:, None]
        nearest = nearest_of((np.abs(forces) + change).min(axis=1), np.arange(len(demand)))
        # a kink moves through the cells between two columns of the table
        slack = 0.5 * np.maximum(change[:, :-1], change[:, 1:])
        cells = _may_reach_zero(forces, slack + nearest[demand, None] + TIE)
    else:
        cells = np.ones((len(demand), len(curves.levels) - 1), bool)
    padded = np.pad(cells, ((0, 0), (1, 1)))
    # neighbors show where a curve turns
    padded[:, 1:-1] = padded[:, :-2] | padded[:, 1:-1] | padded[:, 2:]
    row, node = np.nonzero(padded[:, :-1] | padded[:, 1:])
    level, linked = curves.levels[node], padded[row, node + 1]
    value = searches.excess(row, level) if excess is None else excess[row, node]
    points = Points(row, level, value, linked, np.zeros(len(row), bool))
    slack = nearest_of(np.abs(value), row)[demand]
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
    """Points, all at a `node`, with the kinks in cells as near to the target as `slack` [N]."""
    is_near = _may_reach_zero(points.excess, slack[points.row][:-1], points.linked[:-1])
    plates = searches.strain[points.row]
    count = searches.curves.throttled[searches.state[points.row]]
    kinks = []
    for j, muscle in enumerate(searches.curves.muscles):
        strain, is_candidate = muscle.strain(plates), is_near & (count[:-1, j] > 0)
        for kink, strains in muscle.kinks.items():
            miss = strains[node] - strain
            i = np.flatnonzero(is_candidate & ((miss[1:] > 0) != (miss[:-1] > 0)))
            if not len(i):
                continue
            *_, left, right = _bracketed_root(
                lambda index, level, muscle=muscle, kink=kink, plates=plates[i]: (
                    muscle.kink_residual(kink, level, plates[index])
                ),
                points.level[i], points.level[i + 1], miss[i], miss[i + 1], np.full(len(i), -1.0),
            )  # fmt: skip
            kinks.append((i, left, right))
    if not kinks:
        return points
    i, left, right = map(np.concatenate, zip(*kinks, strict=True))
    before = left - _KINK_INSET * (left - points.level[i])
    after = right + _KINK_INSET * (points.level[i + 1] - right)
    # a force that jumps has two sides
    rows, levels = np.tile(points.row[i], 4), np.concatenate([left, right, before, after])
    is_kink = np.repeat([True, True, False, False], len(i))
    return points.insert(rows, levels, searches.excess(rows, levels), is_kink)


def _insert_extrema(searches: Searches, points: Points, slack: Array) -> Points:
    """Points with the extrema that come as near to the target as `slack` [N]."""
    sign = np.where(points.excess[1:-1] > 0, 1.0, -1.0)
    windows = (slice(None, -2), slice(1, -1), slice(2, None))
    before, middle, after = (sign * points.excess[window] for window in windows)
    is_extremum = points.linked[:-2] & points.linked[1:-1] & ~points.kink[1:-1]
    is_extremum &= (middle > 0) & (before >= middle) & (after >= middle)
    span = np.maximum(before, after) - middle
    # a parabola through three nodes turns less than their span below the lowest
    is_extremum &= (span > ROOT_TOLERANCE) & (middle - span < slack[points.row[1:-1]])
    i = np.flatnonzero(is_extremum)
    if not len(i):
        return points
    row, sign = points.row[1:-1][i], sign[i]
    level = _bracketed_minimum(
        lambda index, x: sign[index] * searches.excess(row[index], x),
        points.level[:-2][i], points.level[2:][i],
    )  # fmt: skip
    return points.insert(row, level, searches.excess(row, level))


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
    level, miss, *_ = _bracketed_root(
        lambda index, x: searches.excess(row[index], x),
        points.level[i], points.level[i + 1], points.excess[i], points.excess[i + 1],
        1e-2 * tolerance[i],
    )  # fmt: skip
    crosses = np.abs(miss) <= tolerance[i]  # else the force jumps past the target
    return (
        np.append(points.row[first], row[crosses]),
        np.append(points.level[first], level[crosses]),
    )


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


def _bracketed_root(
    residual: Residual, low: Array, high: Array, f_low: Array, f_high: Array, tolerance: Array
) -> tuple[Array, Array, Array, Array]:
    """Roots by Chandrupatla's method, all at once, to a residual of `tolerance` or to rounding: the
    best level [-], its residual, and the ends of the last bracket [-].
    """
    # SciPy's of the same method takes as long for one root as a whole demand takes here
    x = np.stack([low, high, high])  # the newest, the other side of the bracket, the one before
    f = np.stack([f_low, f_high, f_high])
    index = np.arange(len(low))
    fraction = f_low / (f_low - f_high)  # the secant, exact on a straight line
    for _ in range(100):  # bisection alone would need 53
        width = np.abs(x[1, index] - x[0, index])
        # rounding of x as a share of the bracket; never zero, for a root at 0
        smallest = (2e-16 * np.abs(x[0, index]) + 1e-300) / np.where(width > 0, width, 1.0)
        best = np.minimum(np.abs(f[0, index]), np.abs(f[1, index]))
        active = (best > tolerance[index]) & (smallest < 0.5) & (width > 0)
        index, fraction, smallest = index[active], fraction[active], smallest[active]
        if not len(index):
            break
        fraction = np.clip(np.where(np.isfinite(fraction), fraction, 0.5), smallest, 1 - smallest)
        (x1, x2, _), (f1, f2, _) = x[:, index], f[:, index]
        new = x1 + fraction * (x2 - x1)
        value = residual(index, new)
        keeps_side = (value > 0) == (f1 > 0)
        x1, x2, x3 = new, np.where(keeps_side, x2, x1), np.where(keeps_side, x1, x2)
        f1, f2, f3 = value, np.where(keeps_side, f2, f1), np.where(keeps_side, f1, f2)
        x[:, index], f[:, index] = (x1, x2, x3), (f1, f2, f3)
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        inverse = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
        quadratic = f1 / (f2 - f1) * f3 / (f2 - f3)
        quadratic += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        fraction = np.where(inverse, quadratic, 0.5)
    newest = np.abs(f[0]) < np.abs(f[1])
    ends = np.minimum(x[0], x[1]), np.maximum(x[0], x[1])
    return np.where(newest, x[0], x[1]), np.where(newest, f[0], f[1]), *ends


def _bracketed_minimum(residual: Residual, low: Array, high: Array) -> Array:
    """Levels [-] of the least residuals between `low` and `high` [-], all at once, each by a
    parabola on the last of ever finer grids; or a level at which the residual is negative.
    """
    x, f = np.stack([low, 0.5 * (low + high), high]), np.zeros((3, len(low)))
    index = np.arange(len(low))
    for _ in range(_ZOOMS):
        if not len(index):
            break
        grid = np.linspace(x[0, index], x[2, index], _ZOOM_POINTS)
        value = residual(np.tile(index, _ZOOM_POINTS), grid.reshape(-1)).reshape(grid.shape)
        middle = np.clip(value.argmin(axis=0), 1, _ZOOM_POINTS - 2)
        triple = middle + np.array([[-1], [0], [1]]), np.arange(len(index))
        x[:, index], f[:, index] = grid[triple], value[triple]
        index = index[f[1, index] > 0]
    bend = f[0] - 2 * f[1] + f[2]
    vertex = 0.5 * (f[0] - f[2]) / np.where(bend > 0, bend, np.inf)
    return np.where(f[1] > 0, x[1] + np.clip(vertex, -1, 1) * (x[1] - x[0]), x[1])
