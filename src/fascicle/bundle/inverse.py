r"""The inverse of a bundle: the pressures that give a force at a strain.

A demanded force $F_d$ has as solutions all roots of

$$F_k(p, \varepsilon) = F_d, \qquad 0 \le p \le P_s, \quad k = 1 \dots n, \tag{B9}$$

with the force $F_k$ of recruitment state $k$ over its throttled pressure, (B8), whose module
searches for the roots.

**Choice.** The fluid energy (29) does not depend on the throttled pressure. Where the units that a
state pressurizes are among those of the next, the lowest state is the cheapest; within it the
lowest pressure is taken. At $\varepsilon \le 0$, where fluid flows back, that order holds as well.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.array_namespace import slices
from ..core.errors import InvalidInputError
from ..core.module import to_numpy, tree_map, unique_indices
from ..core.types import AnyArray, Bool, Float, Int, Numbers, Values
from ..core.validation import broadcast_shape, check_choice, check_finite, is_concrete
from ..repr_table import with_table_repr
from .force_curves import ROOT_TOLERANCE, Array, Roots, StateCurves, find_roots, run_starts
from .pressurized import unit_volume_change
from .printing import recruitment_table
from .schemes import AbstractScheme
from .states import States, resolve_scheme, resolve_supply_pressure, states_of


if TYPE_CHECKING:
    from .bundle import Bundle


PREFERENCES = ("efficiency", "nearest")  # values of the argument `prefer`
REACHED, ABOVE, BELOW = 0, 1, 2  # statuses, as files and JSON have them
_SLOTS_PER_STATE = 2  # for which a result has room: a fold gives a state two, rarely more
_PAIRS = 2**22  # of a set of units and a demand at once: some 0.2 GB
_BATCH = 2**13  # demands at once, of independent units
CLOSE = 1e-9  # of 1 N and the force: `ROOT_TOLERANCE` of a unit, and the rounding of a sum
_UNREACHABLE = 1e3  # times the forces at both ends: no muscle gives as much


class Solutions(NamedTuple):
    """All pressures that give a demanded force, by state and pressure on the last axis.

    `pressure`: the throttled pressure [Pa]; `state`, counted from 1; `stable`: the force falls
    with strain. NaN, 0 and False where there are fewer. Without derivatives.
    """

    pressure: Float[AnyArray, "*points solution"]
    state: Int[AnyArray, "*points solution"]
    stable: Bool[AnyArray, "*points solution"]


@with_table_repr(recruitment_table)
class RecruitmentResult(NamedTuple):
    """Pressures for a demanded force.

    `pressures` [Pa], units on the last axis; `state`, counted from 1; `force` [N] that they give;
    `status`: 0 reached, 1 the demand is above what is reachable, 2 below: then the result is that
    of the nearest reachable force. `stable`: the force falls with strain at these pressures.
    `solutions`, and their `count`. `unit`: the first throttled unit, counted from 1.
    """

    pressures: Numbers
    state: Int[AnyArray, "*points"]
    force: Float[AnyArray, "*points"]
    status: Int[AnyArray, "*points"]
    stable: Bool[AnyArray, "*points"]
    solutions: Solutions
    count: Int[AnyArray, "*points"]
    unit: Int[AnyArray, "*points"]


def recruit(
    bundle: "Bundle",
    force: Values,
    strain: Values,
    supply: Values = None,
    scheme: AbstractScheme | str | None = None,
    prefer: str = "efficiency",
    *,
    present: Values = None,
    resistance: bool = True,
) -> RecruitmentResult:
    """State and pressures that give a force at a strain, equation (B9).

    - `force`: the demanded pulling force [N]; `strain`: the bundle's contraction [-]; they
      broadcast.
    - `supply`: the supply's pressure [Pa], one for all, and `scheme`: one of `fascicle.schemes`, by
      name or as an object; by default the bundle's own.
    - `prefer`: of several solutions, "efficiency" for the one that takes least fluid, or
      "nearest" for the one nearest to the `present` pressures of the units [Pa], on the last
      axis.
    - `resistance`: units past their own free strain push back.

    For a demand out of reach the result is that of the nearest force, with a status. `ValueError`
    for values off the domain, unknown names, no supply pressure, "nearest" without `present`, and
    arrays that JAX traces: the search is NumPy's alone.
    """
    scheme = resolve_scheme(bundle, scheme)
    nearest = check_choice(prefer, PREFERENCES, "prefer") == "nearest"
    if not is_concrete(bundle, force, strain, supply, present):
        rule = "and all other arguments must be numbers, not traced by JAX,"
        remedy = "call `recruit` outside of jit, grad and vmap"
        raise InvalidInputError("force", rule, force, remedy, shown="a traced one")
    bundle, units = to_numpy(bundle), len(bundle.motor_units)
    F, eps = check_finite(force, "force", "N"), bundle._check_strain(strain)
    supply = resolve_supply_pressure(bundle, supply, "supply")
    if nearest and scheme.independent:
        rule = f"must be 'efficiency' with scheme {scheme.name!r}"
        remedy = "pressures of its units are free: there is no list of solutions to choose from"
        raise InvalidInputError("prefer", rule, prefer, remedy)
    if nearest and present is None:
        remedy = f"pass a pressure for each of the {units} motor units"
        rule = "must be given in Pa with `prefer` 'nearest'"
        raise InvalidInputError("present", rule, None, remedy)
    P = bundle._check_pressures(present, "present") if nearest else np.zeros(units)
    shape = broadcast_shape(force=np.shape(F), strain=np.shape(eps), present=np.shape(P)[:-1])
    F, eps = (np.broadcast_to(x, shape).ravel() + 0.0 for x in (F, eps))
    states = states_of(scheme, units)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        curves = StateCurves(bundle, supply, states, bool(resistance))
        if states.independent:
            sets, owner = states.sets(unique_indices(bundle.motor_units)[1])
            volume = unit_volume_change(bundle, eps)
            parts = [
                _least_energy(curves, F[i], eps[i], volume[i], sets, owner)
                for i in slices(F.size, max(1, min(_BATCH, _PAIRS // sets.size)))
            ]
            result = tree_map(lambda *x: np.concatenate(x), *parts)
        else:
            roots = find_roots(curves, F, eps)
            pressures = states.pressures(roots.state, roots.level * supply, supply)
            # sorted by state and level already: the first of nested states takes least energy
            cost = np.zeros(len(roots.demand))
            if nearest:
                present = np.broadcast_to(P, (*shape, units)).reshape(-1, units)
                cost = np.sum((pressures - present[roots.demand]) ** 2, axis=-1)
            elif not states.nested:
                volume = np.maximum(unit_volume_change(bundle, eps), 0.0)
                cost = (volume @ states.pressurized.T.astype(float))[roots.demand, roots.state]
            result = _best_solution(F, roots, cost, pressures, states)
    return tree_map(lambda x: x.reshape((*shape, *x.shape[1:]))[()], result)


def _best_solution(
    force: Array, roots: Roots, cost: Array, pressures: Array, states: States
) -> RecruitmentResult:
    """Result for each `force` [N]: of its `roots` of (B9) the first one of the least `cost` [any
    unit], and a table of all exact ones; `pressures`: of all units at the roots [Pa].
    """
    order = np.lexsort((cost, roots.demand))
    best = order[run_starts(roots.demand[order])]
    count = np.bincount(roots.demand[roots.exact], minlength=len(force))
    shape = (len(force), max(_SLOTS_PER_STATE * states.size + 2, int(count.max(initial=0))))
    solutions = Solutions(np.full(shape, np.nan), np.zeros(shape, int), np.zeros(shape, bool))
    slot = np.arange(len(roots.demand)) - np.searchsorted(roots.demand, roots.demand)
    throttled = pressures[np.arange(len(slot)), states.throttled_unit[roots.state]]
    for table, column in zip(solutions, (throttled, roots.state + 1, roots.slope < 0), strict=True):
        table[roots.demand[roots.exact], slot[roots.exact]] = column[roots.exact]
    _, state, _, exact, value, slope = (column[best] for column in roots)
    unit, status = states.throttled_unit[state] + 1, _demand_status(exact, value, force)
    return RecruitmentResult(
        pressures[best], state + 1, value, status, slope < 0, solutions, count, unit
    )


def _least_energy(
    curves: StateCurves, force: Array, strain: Array, volume: Array, sets: States, owner: Array
) -> RecruitmentResult:
    r"""Pressures of least fluid energy for each `force` [N] and `strain` [-], if each unit has a
    pressure of its own.

    The forces of a set $A$ of pressurized units are independent, so together they give what lies
    between

    $$F_0 + \sum_{i \in A} (\min_p F_i - F_i(0)) \le F_d \le
      F_0 + \sum_{i \in A} (\max_p F_i - F_i(0)), \tag{B11}$$

    $F_0$ with all units vented. Of all `sets` that reach a demand (`owner`: the state of each),
    it takes that whose units take in least `volume` [m³] since rest, units last; of equal ones that
    with fewer units, then the earlier ones. All its units but the last pull most (below $F_0$:
    resist most), and the last is throttled, at the lowest pressure that meets the demand; if its
    force jumps past that, a unit before it.
    """
    units, rows, tolerance = len(curves.kind), np.arange(len(force)), CLOSE * (1 + np.abs(force))
    unique, inverse = np.unique(strain, return_inverse=True)  # many demands may share a strain
    limits = (x[inverse] for x in _unit_limits(curves, unique))
    vented, full, least_force, least_level, most_force, most_level = limits
    base = full @ sets.full.T.astype(float) + vented @ (~sets.full).T.astype(float)
    members = sets.throttled.T.astype(float)
    low, high = base + (least_force - vented) @ members, base + (most_force - vented) @ members
    target = np.clip(force[:, None], low, high)
    miss = np.abs(target - force[:, None])
    is_reached = miss.min(axis=1) <= ROOT_TOLERANCE
    # fluid that flows back counts as nothing: then the fewest units are taken
    cost = np.maximum(volume, 0.0) @ sets.pressurized.T.astype(float)
    cost = np.where(miss <= ROOT_TOLERANCE, cost, np.inf)
    choice = np.argmin(np.where(is_reached[:, None], cost, miss), axis=1)
    target, base = target[rows, choice], base[rows, choice]

    in_set = sets.throttled[choice]
    cases = [sets.full[choice], in_set & (target >= base)[:, None], in_set]
    level = np.select(cases, [1.0, most_level, least_level], 0.0)
    unit_force = np.select(cases, [full, most_force, least_force], vented)
    start, value, slope = level.copy(), np.zeros(len(force)), np.zeros(len(force))
    candidates, unit, index = in_set.copy(), np.zeros(len(force), int), rows
    while len(index):
        # the last of the units that haven't been tried
        throttled = unit[index] = units - 1 - np.argmax(candidates[index, ::-1], axis=1)
        candidates[index, throttled] = False
        required = target[index] - unit_force[index].sum(axis=1) + unit_force[index, throttled]
        roots = find_roots(curves, required, strain[index], throttled)
        level[index] = start[index]
        # the lowest level that gives the force, or the nearest one
        level[index, throttled] = roots.level[run_starts(roots.demand)]
        all_units = np.tile(np.arange(units), len(index))
        forces = curves.force_and_slope(
            all_units, level[index].ravel(), np.repeat(strain[index], units)
        )
        value[index], slope[index] = forces.reshape(2, -1, units).sum(axis=2)
        missed = is_reached & (np.abs(value - force) > tolerance)
        index = np.flatnonzero(missed & candidates.any(axis=1))
    is_reached &= np.abs(value - force) <= tolerance
    pressures, state, stable = level * curves.supply, owner[choice] + 1, slope < 0
    solutions = Solutions(
        np.where(is_reached, pressures[rows, unit], np.nan)[:, None],
        np.where(is_reached, state, 0)[:, None],
        (is_reached & stable)[:, None],
    )
    status, count = _demand_status(is_reached, value, force), is_reached.astype(int)
    return RecruitmentResult(pressures, state, value, status, stable, solutions, count, unit + 1)


def _demand_status(is_reached: Array, value: Array, force: Array) -> Array:
    """Status of each demand of a `force` [N], by the nearest `value` [N] that is reached."""
    return np.where(is_reached, REACHED, np.where(value < force, ABOVE, BELOW))


def _unit_limits(curves: StateCurves, strain: Array) -> list[Array]:
    """Force [N] of each unit, units last: vented, at supply pressure, the least and its level [-],
    the largest and its level [-].
    """
    # once for each kind of muscle, by its first unit
    first, kind = [curves.kind.index(k) for k in range(len(curves.muscles))], list(curves.kind)
    unit, eps = np.tile(first, len(strain)), np.repeat(strain, len(first))
    counts = curves.throttled.sum(axis=1)
    ends = curves.force_at_nodes(strain)[0][:, [0, -1]]
    limits = [ends[:, 0], ends[:, 1]]
    unreachable = _UNREACHABLE * (10.0 + np.abs(ends).sum(axis=1)).ravel() * counts[unit]
    for sign in (-1.0, 1.0):  # the nearest to a force out of reach is the least or the largest
        roots = find_roots(curves, sign * unreachable, eps, unit)
        columns = (roots.force / counts[unit], roots.level)
        limits += [column.reshape(limits[0].shape) for column in columns]
    scales = (counts, counts, counts, 1, counts, 1)
    return [x[:, kind] * scale for x, scale in zip(limits, scales, strict=True)]
