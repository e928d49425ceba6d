r"""The inverse of a bundle: the pressures that give a force at a strain.

A demanded force $F_d$ asks for all roots of

$$F_k(p, \varepsilon) = F_d, \qquad 0 \le p \le P_s, \quad k = 1 \dots n, \tag{B9}$$

with the force $F_k$ of recruitment state $k$ over its throttled pressure, (B8).

**Method.** Cells of the pressure grid that may hold the demand get the pressures in between at
which a muscle has a kink at the demand's strain (its free strain, onset of buckling, fold or
collapse strain), then the extrema that may reach the demand. Every change of sign between
neighbors brackets a root; a force that jumps past the demand (at some pressure collapse ends for
good) is none. If no state has a root, the nearest force is that of the nearest node or extremum.

**Choice.** The fluid energy (29) does not depend on the throttled pressure. Where the units that a
state pressurizes are among those of the next, the lowest state is the cheapest; within it the
lowest pressure is taken. At $\varepsilon \le 0$, where fluid flows back, that order holds as well.

NumPy alone works here: JAX's arrays come as numbers, by a callback.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..core.types import AnyArray, Bool, Float, Int, Numbers
from ..repr_table import with_table_repr
from .force_curves import StateCurves
from .printing import recruitment_table, solutions_table
from .states import States


REACHED, ABOVE, BELOW = 0, 1, 2
SLOTS_PER_STATE = 2  # for which a result has room: a fold gives a state two, rarely more
FEW_CELLS = 2**12  # below it all cells are searched: selecting them costs as much
BATCH = 2**16  # searches at once: their table of forces takes 40 MB
_ROOT_TOLERANCE = 2e-10  # N: a force this near to the demand meets it
_SUM_ROUNDING = 1e-13  # of a force: rounding of a sum over units
_TIE = 1e-10  # N: forces this near to each other are equal
_KINK_INSET = 1e-3  # of a cell: nodes this near to a kink show the slopes on both sides
_JUMP = 1e-7  # N, and of the force: two sides of a kink differ by less, but for a jump
_CLOSE = 1e-9  # of 1 N and the force: `_ROOT_TOLERANCE` of a unit, and the rounding of a sum
_UNREACHABLE = 1e3  # times the forces at both ends: no muscle gives as much
_EXTREMUM_WIDTH = 1e-8  # of its bracket: the value of a flat extremum is exact to its square
_GOLDEN = 0.381966  # (3 − √5)/2, the golden section

Array = np.ndarray
Residual = Callable[[Array, Array], Array]


@with_table_repr(solutions_table)
class Solutions(NamedTuple):
    """All solutions on the last axis, by state and pressure: the throttled `pressure` [Pa],
    the `state`, whether `stable`; NaN, 0 and False where there are fewer. No derivatives.
    """

    pressure: Float[AnyArray, "*points solution"]
    state: Int[AnyArray, "*points solution"]
    stable: Bool[AnyArray, "*points solution"]


@with_table_repr(recruitment_table)
class RecruitmentResult(NamedTuple):
    """Pressures for a demanded force.

    `pressures` [Pa], units on the last axis; `state`, counted from 1; `force` [N] that they give;
    `status`: 0 reached, 1 the demanded force is above what is reachable there, 2 below: then all
    this is the nearest reachable force's. `stable`: the force falls with strain at these
    pressures. `solutions`, and their `count`. `unit`: the first throttled one, counted from 1.
    """

    pressures: Numbers
    state: Int[AnyArray, "*points"]
    force: Float[AnyArray, "*points"]
    status: Int[AnyArray, "*points"]
    stable: Bool[AnyArray, "*points"]
    solutions: Solutions
    count: Int[AnyArray, "*points"]
    unit: Int[AnyArray, "*points"]


class Roots(NamedTuple):
    """Solutions in order: index of the `demand`, its `state` and `level` [-], and whether it is
    `exact`: a demand without a solution has one root, of the nearest force.
    """

    demand: Array
    state: Array
    level: Array
    exact: Array


class Searches(NamedTuple):
    """Searches, a row each, for the levels at which a `state` gives a `target` [N] at a `strain`
    [-]; `demand`: the demand that each serves.
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

    def take(self, index: Array) -> "Searches":
        """Rows by index."""
        return Searches(self.curves, *(x[index] for x in self[1:]))


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

    def insert(
        self, row: Array, level: Array, excess: Array, linked: Any = True, kink: bool = False
    ) -> "Points":
        """Points with additional ones, which are linked to their neighbors."""
        added = (row, level, excess, *(np.full(len(row), x) for x in (linked, kink)))
        columns = [np.concatenate(pair) for pair in zip(self, added, strict=True)]
        order = np.lexsort((columns[1], columns[0]))
        points = Points(*(x[order] for x in columns))
        repeats = np.zeros(len(order), bool)
        repeats[1:] = (np.diff(points.row) == 0) & (np.diff(points.level) == 0)
        points.linked[:-1] &= points.linked[1:] | ~repeats[1:]
        return Points(*(x[~repeats] for x in points))


def find_roots(
    curves: StateCurves, force: Array, strain: Array, state: Array | None = None
) -> Roots:
    """All levels of all states, or of one `state` of each demand, that give a `force` [N] at a
    `strain` [-].
    """
    size = max(1, BATCH // (curves.states if state is None else 1))
    batches = [slice(start, start + size) for start in range(0, max(1, len(force)), size)]
    parts = []
    for batch in batches:
        states = None if state is None else state[batch]
        roots = _find_roots(curves, force[batch], strain[batch], states)
        parts.append(roots._replace(demand=roots.demand + batch.start))
    return Roots(*map(np.concatenate, zip(*parts, strict=True)))


def _find_roots(curves: StateCurves, force: Array, strain: Array, state: Array | None) -> Roots:
    demand = np.arange(len(force))
    if state is None:
        demand = np.repeat(demand, curves.states)
        state = np.tile(np.arange(curves.states), len(force))
    target = force[demand] - curves.fixed_force(strain)[0][demand, state]
    searches = Searches(curves, demand, state, strain[demand], target)
    every_cell = np.ones((len(demand), len(curves.levels) - 1), bool)
    cells = every_cell if every_cell.size <= FEW_CELLS else _select_cells(searches)
    row, level, _ = _search(searches, cells, np.zeros(len(demand)))
    unreached = np.flatnonzero(~np.isin(demand, demand[row]))
    exact = np.ones(len(row), bool)
    if len(unreached):
        remaining = searches.take(unreached)
        index, levels, points = _search(remaining, every_cell[: len(unreached)], None)
        owner, distance = remaining.demand[points.row], np.abs(points.excess)
        smallest = np.full(len(force), np.inf)
        np.minimum.at(smallest, owner, distance)
        smallest[remaining.demand[index]] = -np.inf  # reached, in a cell that was not selected
        ties = np.flatnonzero(distance <= smallest[owner] + _TIE)
        nearest = ties[np.unique(owner[ties], return_index=True)[1]]
        row = np.concatenate([row, unreached[index], unreached[points.row[nearest]]])
        level = np.concatenate([level, levels, points.level[nearest]])
        exact = np.arange(len(row)) < len(row) - len(nearest)
    order = np.lexsort((level, row))
    row = row[order]
    return Roots(demand[row], state[row], level[order], exact[order])


def _select_cells(searches: Searches) -> Array:
    """Mask of the grid's cells that may hold each target, by the force table."""
    force, change = searches.curves.interpolate(searches.state, searches.strain)
    # a kink moves through the cells between two columns of the table
    slack = 0.5 * np.maximum(change[:, :-1], change[:, 1:])
    return _may_reach_zero(force - searches.target[:, None], slack)


def _search(searches: Searches, cells: Array, slack: Array | None) -> tuple[Array, Array, Points]:
    """Roots by row and level [-] in some cells, and all points that were evaluated. `slack`: how
    far from the target [N] an extremum is of interest; `None`: as far as the nearest node.
    """
    padded = np.pad(cells, ((0, 0), (1, 1)))
    # neighbors show where a curve turns
    padded[:, 1:-1] = padded[:, :-2] | padded[:, 1:-1] | padded[:, 2:]
    row, node = np.nonzero(padded[:, :-1] | padded[:, 1:])
    linked = padded[row, node + 1]
    curves = searches.curves
    force = curves.force_at_nodes(searches.state[row], node, searches.strain[row])
    excess = force - searches.target[row]
    points = Points(row, curves.levels[node], excess, linked, np.zeros(len(row), bool))
    if slack is None:
        smallest = np.full(searches.demand.max(initial=0) + 1, np.inf)
        np.minimum.at(smallest, searches.demand[row], np.abs(excess))
        slack = smallest[searches.demand]
    points = _insert_kinks(searches, points, node, slack)
    points = _insert_extrema(searches, points, slack)
    return *_collect_roots(searches, points), points


def _insert_kinks(searches: Searches, points: Points, node: Array, slack: Array) -> Points:
    """Points with the kinks in cells that come as near to the target as `slack` [N]."""
    is_near = _may_reach_zero(points.excess, slack[points.row][:-1], points.linked[:-1])
    point = np.flatnonzero(is_near)
    rows, nodes = points.row[point], node[point]
    kinks = []
    for j, muscle in enumerate(searches.curves.muscles):
        throttled = np.flatnonzero(searches.curves.throttled[searches.state[rows], j])
        strain = muscle.strain(searches.strain[rows[throttled]])
        for residual, strains in muscle.kinks:
            left, right = (strains[nodes[throttled] + i] > strain for i in (0, 1))
            cells = throttled[left != right]
            if not len(cells):
                continue
            start, end = points.level[point[cells]], points.level[point[cells] + 1]
            plates = searches.strain[rows[cells]]
            values = residual(start, plates), residual(end, plates)
            change = np.flatnonzero((values[0] > 0) != (values[1] > 0))
            row, start, end, plates = (x[change] for x in (rows[cells], start, end, plates))
            *_, left, right = _bracketed_root(
                lambda i, level, residual=residual, plates=plates: residual(level, plates[i]),
                start, end, values[0][change], values[1][change], np.full(len(row), -1.0),
            )  # fmt: skip
            kinks.append((row, left, right, start, end))
    if not any(len(row) for row, *_ in kinks):
        return points
    row, left, right, start, end = map(np.concatenate, zip(*kinks, strict=True))
    f_left, f_right = searches.excess(row, left), searches.excess(row, right)
    # but for rounding both sides are one point, unless the force jumps
    jumps = np.abs(f_right - f_left) > _JUMP * (1 + np.abs(f_left) + np.abs(f_right))
    points = points.insert(row, right, f_right, kink=True)
    points = points.insert(row, left, f_left, ~jumps, kink=True)
    for level in (left - _KINK_INSET * (left - start), right + _KINK_INSET * (end - right)):
        points = points.insert(row, level, searches.excess(row, level))
    return points


def _insert_extrema(searches: Searches, points: Points, slack: Array) -> Points:
    """Points with the extrema that come as near to the target as `slack` [N]."""
    if len(points.row) < 3:
        return points
    sign = np.where(points.excess[1:-1] > 0, 1.0, -1.0)
    windows = (slice(None, -2), slice(1, -1), slice(2, None))
    before, middle, after = (sign * points.excess[window] for window in windows)
    is_extremum = points.linked[:-2] & points.linked[1:-1] & ~points.kink[1:-1]
    is_extremum &= (middle > 0) & (before >= middle) & (after >= middle)
    span = np.maximum(before, after) - middle
    # a parabola through three nodes turns less than their span below the lowest
    is_extremum &= (span > _ROOT_TOLERANCE) & (middle - span < slack[points.row[1:-1]])
    i = np.flatnonzero(is_extremum)
    if not len(i):
        return points
    row, sign = points.row[1:-1][i], sign[i]
    level = _bracketed_minimum(
        lambda index, x: sign[index] * searches.excess(row[index], x),
        np.stack([points.level[window][i] for window in windows]),
        np.stack([before[i], middle[i], after[i]]),
    )
    return points.insert(row, level, searches.excess(row, level))


def _collect_roots(searches: Searches, points: Points) -> tuple[Array, Array]:
    """Roots by row and level [-]: points that meet the target, and changes of sign."""
    tolerance = (_ROOT_TOLERANCE + _SUM_ROUNDING * np.abs(searches.target))[points.row]
    meets = np.abs(points.excess) <= tolerance
    # a run of points that all meet it counts once, by its first
    follows = np.zeros(len(meets), bool)
    follows[1:] = meets[1:] & meets[:-1] & points.linked[:-1]
    first = meets & ~follows
    # an endpoint that is an earlier state's, too, counts there
    owns_start, owns_end = (
        x[searches.state[points.row]] for x in searches.curves.owns_endpoints
    )  # fmt: skip
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
    """Mask of cells, on the last axis, in which a curve may come as near to zero as `slack` [N], by
    its ends and by how much it changes there and in the neighboring cells.
    """
    change = np.where(linked, np.abs(np.diff(excess)), 0.0)
    padded = np.pad(change, [*[(0, 0)] * (change.ndim - 1), (1, 1)])
    margin = np.maximum(np.maximum(padded[..., :-2], padded[..., 2:]), change)
    left, right = excess[..., :-1], excess[..., 1:]
    distance = np.maximum(np.minimum(left, right), -np.maximum(left, right))
    # strictly: a plateau at the nearest force holds nothing nearer
    return linked & (distance - margin < slack)


def _bracketed_root(
    residual: Residual,
    low: Array,
    high: Array,
    f_low: Array,
    f_high: Array,
    tolerance: Array,
) -> tuple[Array, Array, Array, Array]:
    """Roots by Chandrupatla's method, all at once: the best level [-], its residual, and the ends
    of the last bracket [-]. It ends at a residual of `tolerance`, or at rounding. (SciPy's of the
    same method takes as long for one root as a whole demand takes here.)
    """
    x = np.stack([low, high, high])  # the newest, the other side of the bracket, the one before
    f = np.stack([f_low, f_high, f_high])
    index = np.arange(len(low))
    fraction = f_low / (f_low - f_high)  # the secant, exact on a straight line
    for _ in range(100):  # bisection alone would need 53
        width = np.abs(x[1, index] - x[0, index])
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


def _bracketed_minimum(residual: Residual, x: Array, f: Array) -> Array:
    """Minima [-] by parabolas and golden sections, all at once, from three points `x` each, the
    middle one lowest, with residuals `f`; or a point at which the residual is negative.
    """
    limits, index = _EXTREMUM_WIDTH * (x[2] - x[0]), np.arange(x.shape[1])
    for n in range(60):  # golden sections alone would need 38
        index = index[(f[1, index] > 0) & (x[2, index] - x[0, index] > 4 * limits[index])]
        if not len(index):
            break
        (a, m, b), (f_a, f_m, f_b), limit = x[:, index], f[:, index], limits[index]
        p, q = (m - a) * (f_m - f_b), (m - b) * (f_m - f_a)
        vertex = m - 0.5 * ((m - a) * p - (m - b) * q) / (p - q)
        right_is_wider = b - m > m - a
        inside = (a + limit < vertex) & (vertex < b - limit) & (n % 3 < 2)
        new = np.where(inside, vertex, m + _GOLDEN * np.where(right_is_wider, b - m, a - m))
        step = np.where(right_is_wider, limit, -limit)
        new = np.where(np.abs(new - m) < limit, m + step, new)
        value = residual(index, new)
        lower = value < f_m
        cuts_right = lower == (new < m)  # the higher of both points becomes an end
        for table, (low, middle, high), added in (
            (x, (a, m, b), new),
            (f, (f_a, f_m, f_b), value),
        ):
            end = np.where(lower, middle, added)
            table[0, index] = np.where(cuts_right, low, end)
            table[2, index] = np.where(cuts_right, end, high)
            table[1, index] = np.where(lower, added, middle)
    return x[1]


def solve_inverse(
    curves: StateCurves,
    force: Array,
    strain: Array,
    states: States,
    present: Array | None = None,
    volume: Array | None = None,
) -> RecruitmentResult:
    """Solve equation (B9) for each `force` [N] and `strain` [-] and choose one of its solutions.

    That is the nearest to the `present` pressures [Pa], or the one that takes least fluid, or the
    first. `volume`: fluid of each unit since rest [m³], units last, if it decides.
    """
    roots, fixed = find_roots(curves, force, strain), curves.fixed_force(strain)
    cost = np.zeros(len(roots.demand))  # they are in order of their energy already
    if present is not None:
        pressures = states.pressures(roots.state, roots.level, curves.supply)
        cost = np.sum((pressures - present[roots.demand]) ** 2, axis=-1)
    elif volume is not None:
        fluid = np.maximum(volume, 0.0) @ states.pressurized.T.astype(float)
        cost = fluid[roots.demand, roots.state]
    order = np.lexsort((cost, roots.demand))
    chosen = order[np.unique(roots.demand[order], return_index=True)[1]]
    forces, slopes = (
        x + y[roots.demand, roots.state]
        for x, y in zip(
            curves.force(roots.state, roots.level, strain[roots.demand]), fixed, strict=True
        )
    )
    count = np.bincount(roots.demand[roots.exact], minlength=len(force))
    slots = max(SLOTS_PER_STATE * curves.states + 2, int(count.max(initial=0)))
    shape = (len(force), slots)
    solutions = Solutions(np.full(shape, np.nan), np.zeros(shape, int), np.zeros(shape, bool))
    slot = np.arange(len(roots.demand)) - np.searchsorted(roots.demand, roots.demand)
    columns = (roots.level * curves.supply, roots.state + 1, slopes < 0)
    for table, column in zip(solutions, columns, strict=True):
        table[roots.demand[roots.exact], slot[roots.exact]] = column[roots.exact]
    state = roots.state[chosen]
    return RecruitmentResult(
        pressures=states.pressures(state, roots.level[chosen], curves.supply),
        state=state + 1,
        force=forces[chosen],
        status=_status(roots.exact[chosen], forces[chosen], force),
        stable=slopes[chosen] < 0,
        solutions=solutions,
        count=count,
        unit=states.throttled_unit[state] + 1,
    )


def minimum_energy_pressures(
    curves: StateCurves, force: Array, strain: Array, volume: Array, sets: States, owner: Array
) -> RecruitmentResult:
    r"""The cheapest pressures if each unit has one of its own, for each `force` [N] and `strain`.

    The forces of a set $A$ of pressurized units are independent, so together they give what lies
    between

    $$F_0 + \sum_{i \in A} (\min_p F_i - F_i(0)) \le F_d \le
      F_0 + \sum_{i \in A} (\max_p F_i - F_i(0)), \tag{B11}$$

    $F_0$ with all units vented. Of all `sets` that reach a demand (`owner`: the state of each) the
    one is taken whose units take in least `volume` [m³] since rest, units last; of equal ones that
    with fewer units, then the earlier ones. All its units but the last pull most (below $F_0$:
    resist most), and the last is throttled, at the lowest pressure that meets the demand; if its
    force jumps past that, a unit before it.
    """
    units, tolerance = len(curves.kind), _CLOSE * (1 + np.abs(force))
    unique, inverse = np.unique(strain, return_inverse=True)  # many demands may share a strain
    limits = (x[inverse][:, list(curves.kind)] for x in _unit_limits(curves, unique))
    counts = curves.throttled.sum(axis=1)
    vented, full, least_force, most_force, least_level, most_level = (
        x * scale for x, scale in zip(limits, (counts, counts, counts, counts, 1, 1), strict=True)
    )
    base = full @ sets.full.T.astype(float) + vented @ (~sets.full).T.astype(float)
    members = sets.throttled.T.astype(float)
    low, high = base + (least_force - vented) @ members, base + (most_force - vented) @ members
    miss = np.maximum(np.maximum(low - force[:, None], force[:, None] - high), 0.0)
    is_reached = miss.min(axis=1) <= _ROOT_TOLERANCE
    # fluid that flows back counts as nothing: then the fewest units are taken
    cost = np.maximum(volume, 0.0) @ sets.pressurized.T.astype(float)
    cost = np.where(miss <= _ROOT_TOLERANCE, cost, np.inf)
    choice = np.argmin(np.where(is_reached[:, None], cost, miss), axis=1)

    rows = np.arange(len(force))
    target = np.clip(force, low[rows, choice], high[rows, choice])
    in_set = sets.throttled[choice]
    pulls = (target >= base[rows, choice])[:, None]
    cases = [sets.full[choice], in_set & pulls, in_set]
    start = np.select(cases, [1.0, most_level, least_level], 0.0)
    unit_force = np.select(cases, [full, most_force, least_force], vented)
    unit = units - 1 - np.argmax(in_set[:, ::-1], axis=1)
    level, value, slope = start.copy(), np.zeros(len(force)), np.zeros(len(force))
    index = rows
    while len(index):
        arrays = (x[index] for x in (start, unit_force, unit, target, strain))
        level[index], value[index], slope[index] = _throttle(curves, *arrays)
        earlier = in_set & (np.arange(units) < unit[:, None])
        missed = is_reached & (np.abs(value - force) > tolerance)
        index = np.flatnonzero(missed & earlier.any(axis=1))
        unit[index] = units - 1 - np.argmax(earlier[index, ::-1], axis=1)
    is_reached &= np.abs(value - force) <= tolerance
    pressures, state, stable = level * curves.supply, owner[choice] + 1, slope < 0
    solutions = Solutions(
        np.where(is_reached, pressures[rows, unit], np.nan)[:, None],
        np.where(is_reached, state, 0)[:, None],
        (is_reached & stable)[:, None],
    )
    status, count = _status(is_reached, value, force), is_reached.astype(int)
    return RecruitmentResult(pressures, state, value, status, stable, solutions, count, unit + 1)


def _status(is_reached: Array, value: Array, force: Array) -> Array:
    return np.where(is_reached, REACHED, np.where(value < force, ABOVE, BELOW))


def _unit_limits(curves: StateCurves, strain: Array) -> list[Array]:
    """Force [N] of one muscle of each kind, kinds last: vented, at supply pressure, the least and
    the largest; and the levels [-] of the last two.
    """
    limits = [np.zeros((len(strain), len(curves.muscles))) for _ in range(6)]
    for k in range(len(curves.muscles)):
        unit = np.full(len(strain), curves.kind.index(k))
        count = curves.throttled[unit, k]
        for i, node in enumerate((0, -1)):
            nodes = np.full(len(strain), node)
            limits[i][:, k] = curves.force_at_nodes(unit, nodes, strain) / count
        size = 10.0 + np.abs(limits[0][:, k]) + np.abs(limits[1][:, k])
        for i, sign in ((2, -1.0), (3, 1.0)):
            level = find_roots(curves, sign * _UNREACHABLE * size * count, strain, unit).level
            limits[i][:, k] = curves.force(unit, level, strain)[0] / count
            limits[i + 2][:, k] = level
    return limits


def _throttle(
    curves: StateCurves, level: Array, unit_force: Array, unit: Array, target: Array, strain: Array
) -> tuple[Array, Array, Array]:
    """Levels [-] with that of one `unit` changed so that all together give the `target` [N], the
    lowest that does or the nearest; their force [N] and its slope in `strain` [N]. `unit_force`:
    force of each unit at its `level` [N].
    """
    rows, units = np.arange(len(unit)), level.shape[1]
    required = target - unit_force.sum(axis=1) + unit_force[rows, unit]
    roots = find_roots(curves, required, strain, unit)
    first = np.unique(roots.demand, return_index=True)[1]
    level = level.copy()
    level[rows, unit] = roots.level[first]
    state = np.tile(np.arange(units), len(unit))
    forces = curves.force(state, level.reshape(-1), np.repeat(strain, units))
    force, slope = (x.reshape(level.shape).sum(axis=1) for x in forces)
    return level, force, slope
