r"""Outcome of designs at the points of a task, from a table of their muscles' forces.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives, sums over units as in (B10). A demanded force within is met there, in
the lowest state that covers it, which takes least fluid; else its *shortfall* is the distance to
the nearest force that any state gives. What the largest of all states exceeds the demanded force by
is *spare*. The fluid energy is (29) with all units that the state feeds; a point that isn't met is
charged as if every unit were fed.

The least force of a state needn't be known where states are joined: vented, a state gives no more
than an earlier one does when fed, and the first, where nothing is fed, pulls nowhere. So the lowest
state whose largest force is enough covers a force that none below it reaches. Where a scheme leaves
a gap between states it is computed. Where units are independent, every choice of those that are
fed is a state here, and the one that takes least fluid is used.

**Shapes:** points first, then motor units, then designs; for a single design, that axis is missing.
**Resolution:** regions are taken over a fixed number of throttled pressures. Their edges are
exact where the force is linear in pressure, that is, wherever the muscle pulls.

**Reversal.** While a unit's pressure rises from zero, earlier ones at the supply's, the free strain
may fall: a *reversal*. It is computed on force curves at even strains and every level of the
throttled pressure, linear between two strains. The first strain at which the least force of all
levels vanishes is located first; levels are compared at that strain alone.

Where all muscles of a design are equal, its force

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon) \tag{G2}$$

with $a$ muscles at full supply, $n$ throttled and $r$ vented makes the depth one of $(a, n, r)$
alone, which many designs share.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import States, is_prefix_consistent, overlap_edges, states_of
from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.module import Module, static
from ..core.types import AnyArray, Float, Int, Marks, Numbers, Whole
from ..core.validation import LARGEST_STRAIN
from .designs import packed_radius
from .task import Task


FORCE_TOLERANCE = 1e-9  # N, a shortfall of rounding
_BATCH = 2**20  # numbers computed together, some ten megabytes
MAX_FED_SETS = 255  # sets of independent units that may be fed: all of eight


class Demand(Module):
    """Demand of a task as arrays: `force` [N], `travel`, a strain [-] or `by_stroke` a length [m],
    `weight`, `supply` [Pa]. Its methods give points on the first axis, then the axes of a length.
    """

    force: Numbers
    travel: Numbers
    weight: Numbers
    supply: Numbers
    scheme: AbstractScheme = static()
    by_stroke: bool = static()

    @classmethod
    def from_task(cls, task: Task) -> "Demand":
        """The demand of a `task`."""
        travel = task.strain if task.stroke is None else task.stroke
        supply = np.float64(task.supply_pressure)
        return cls(task.force, travel, task.weight, supply, task.scheme, task.stroke is not None)

    def strain(self, length: Numbers) -> Numbers:
        """Contractions [-] of a bundle of `length` [m]; for a stroke, at most the laws' limit."""
        travel = with_axes(self.travel, np.ndim(length))
        return minimum(travel / length, LARGEST_STRAIN) if self.by_stroke else travel

    def work(self, length: Numbers) -> Numbers:
        """Work [J] of each point, for a bundle of `length` [m]."""
        axes = np.ndim(length)
        work = with_axes(self.force, axes) * with_axes(self.travel, axes)
        return work if self.by_stroke else work * length

    def is_possible(self, length: Numbers) -> Marks:
        """True where a stroke is in the laws' domain at a `length` [m]; for strains, everywhere."""
        travel = with_axes(self.travel, np.ndim(length))
        return travel <= (LARGEST_STRAIN * length if self.by_stroke else np.inf)


class ForceTable(NamedTuple):
    """Table of muscles' forces at the task's points, points first, muscles last.

    `vented` and `full`: at no and at the supply's pressure [N]; `levels`: at each throttled level,
    or the largest over all of them alone [N], on a further axis, which is first; fluid `volume`
    taken in [m³]; `blocked` force [N] and `length` [m]. If computed, `radius` and `bulge`
    [m] at the task's largest strain.
    """

    vented: Numbers
    full: Numbers
    levels: Numbers
    volume: Numbers
    blocked: Numbers
    length: Numbers
    radius: Numbers | None = None
    bulge: Numbers | None = None

    def take(self, index: Whole) -> "ForceTable":
        """The table of the muscles with an `index` on the last axis."""
        return ForceTable(*(None if x is None else x[..., index] for x in self))

    def scale_forces(self, factor: Numbers) -> "ForceTable":
        """The table of muscles whose forces are `factor` times as large [-]."""
        names = ("vented", "full", "levels", "blocked")
        return self._replace(**{name: factor * getattr(self, name) for name in names})


class Outcome(NamedTuple):
    """Outcome of designs at the task's points, designs on the last axis.

    `force` [N], `weight` [-] and `work` [J] of each demanded point; true where it is `reached`, its
    `shortfall` [N], the force to `spare` [N], negative where it isn't reached, and the fluid
    `energy` [J] it takes. `blocked` [N]: each unit's force at rest and full supply; `units`: number
    of motor units. If computed: `size` [m], the envelope's diameter, `depth` [-] of reversal,
    `overlap` [N].
    """

    force: Numbers
    weight: Numbers
    work: Numbers
    reached: Marks
    shortfall: Numbers
    spare: Numbers
    energy: Numbers
    blocked: Numbers
    units: Whole
    size: Numbers | None = None
    depth: Numbers | None = None
    overlap: Numbers | None = None

    @property
    def reference(self) -> Numbers:
        """Force that a share of a point's force refers to [N]: the demanded force; the task's
        largest, where none is.
        """
        return where(self.force > 0, self.force, self.force.max())


class StateChoice(NamedTuple):
    """Choice of a recruitment state at each point: mask of `reached` points, their `shortfall` and
    `spare` force [N], and the `state` used, counted from 0; the last one where none reaches;
    the `largest` force of any state [N], and the `fluid` that the one used takes [m³].
    """

    reached: Marks
    shortfall: Numbers
    spare: Numbers
    state: Whole
    largest: Numbers
    fluid: Numbers


@cache
def recruitment_states(scheme: AbstractScheme, units: int) -> States:
    """Recruitment states of a bundle of `units` motor units under a `scheme`.

    With independent units a state for each set of units that the scheme can pressurize;
    `ValueError` for too many sets.
    """
    return states_of(scheme, units).sets(max_sets=MAX_FED_SETS)[0]


def existing_states(scheme: AbstractScheme, exists: Marks) -> Marks:
    """Mask of the recruitment states that each design has, states first; designs with fewer units
    than others have fewer states. `exists`: mask of their units, units first.
    """
    xp, units = array_namespace(exists), len(exists)
    states = recruitment_states(scheme, units)
    if scheme.independent or not is_prefix_consistent(scheme, units):
        # sets with a unit that doesn't exist repeat those without it
        return xp.ones((states.size, *exists.shape[1:]), bool)
    numbers = [0, *(states_of(scheme, fewer).size for fewer in range(1, units + 1))]
    size = xp.asarray(np.array(numbers))[exists.sum(axis=0)]
    return with_axes(np.arange(states.size), exists.ndim - 1) < size


def choose_states(
    counts: Whole,
    table: ForceTable,
    length: Numbers,
    demand: Demand,
    states: States,
    exists: Marks,
    gaps: bool,
) -> StateChoice:
    """Choose the recruitment state at each point of a demand, and its shortfall and spare force
    [N]: the cheapest in fluid that gives the demanded force, which is the lowest if states are
    nested.

    `counts`: muscles in each unit, units first, designs last; `table`: of a muscle of each unit, of
    every level where `states` have `gaps` between them; `length`: of the bundles at rest [m], one
    or of every design; `exists`: mask of the states that designs have.
    """
    xp, axes = array_namespace(counts, table.full), counts.ndim - 1
    vented, full, levels, volume = (
        xp.moveaxis(counts * x, -counts.ndim, -1)
        for x in (table.vented, table.full, table.levels, table.volume)
    )
    low, high = states.edges(levels, vented, full)
    F, is_possible = with_axes(demand.force, axes), with_axes(demand.is_possible(length), axes)
    high = where(exists[:, None], high, -np.inf)
    covers, miss = F - high <= FORCE_TOLERANCE, F - high
    if gaps:
        covers, miss = covers & (low - F <= FORCE_TOLERANCE), maximum(miss, low - F)
    # what flows back counts as nothing, as a set that feeds more isn't cheaper
    cost = -1.0 if states.nested else sum_pressurized(maximum(volume, 0.0), states)
    state = where(covers, cost, np.inf).argmin(0)
    top, miss = high.max(axis=0), maximum(miss.min(axis=0), 0.0)
    reached = (miss <= FORCE_TOLERANCE) & is_possible
    # where it can't be that short it is short of the force, and of what it pushes with there
    miss = where(is_possible, miss, maximum(miss, F))
    largest = where(is_possible, top, minimum(top, -2 * FORCE_TOLERANCE))
    spare = largest - F
    if gaps:  # a larger force is no help there
        spare = where(reached, spare, minimum(spare, -miss))
    last = xp.broadcast_to(exists.sum(axis=0) - 1, state.shape)
    used, miss = where(reached, state, last), where(reached, 0.0, miss)
    fluid = xp.take_along_axis(sum_pressurized(volume, states), used[None], axis=0)[0]
    return StateChoice(reached, miss, spare, used, largest, fluid)


def sum_pressurized(values: Numbers, states: States) -> Numbers:
    """Sum of `values` over the units that each of the `states` feeds [any unit]; units last, and
    states first in the result.
    """
    sums = values @ states.pressurized.T.astype(float)
    return array_namespace(sums).moveaxis(sums, -1, 0)


def outcome(
    counts: Whole,
    table: ForceTable,
    length: Numbers,
    demand: Demand,
    depth: Numbers | None = None,
    overlap: Numbers | None = None,
) -> Outcome:
    """Outcome of designs at a demand's points.

    `counts`: muscles in each unit, units first, designs last; `table`: of a muscle of each unit, or
    of one for all units; `length`: of the bundles at rest [m], one or of every design; `depth` of
    reversal [-] and `overlap` of states [N], if computed.
    """
    exists, axes = counts > 0, np.ndim(counts) - 1
    states = recruitment_states(demand.scheme, len(counts))
    existing = existing_states(demand.scheme, exists)
    choice = choose_states(counts, table, length, demand, states, existing, not states.gapless)
    units, size = exists.sum(axis=0), None
    if table.radius is not None and table.bulge is not None:
        # a lone unit is fed, and doesn't bow
        bulge = where(units > 1, where(exists, table.bulge, 0.0).max(axis=0), 0.0)
        size = 2 * (packed_radius((table.radius + 0.0 * counts).T, counts.T) + bulge)
    return Outcome(
        with_axes(demand.force, axes),
        with_axes(demand.weight, axes),
        with_axes(demand.work(length), axes),
        choice.reached,
        choice.shortfall,
        choice.spare,
        demand.supply * choice.fluid,
        counts * table.blocked,
        units,
        size,
        depth,
        overlap,
    )


def with_axes(points: Numbers | Marks, axes: int) -> Any:
    """Array `points` [any unit] with axes of length 1 appended until so many `axes` follow the
    first.
    """
    return points.reshape(points.shape + (1,) * (axes + 1 - points.ndim))


def free_strain_falls(
    other_force: Numbers, count: Numbers, force: Numbers, last_strain: Numbers
) -> Numbers:
    """Largest fall of a bundle's free strain while one unit's pressure rises from zero to the
    supply's, the other units' being constant [-]; one value for each unit that rises.

    `other_force`: of all other units at even strains [N], a row for each unit; `count`: muscles of
    the unit; `force`: of one of them at every pressure level [N], levels first, strains last;
    `last_strain`: the last of the even strains from zero [-].
    """
    xp, last = array_namespace(other_force, force), other_force.shape[-1] - 1

    def total(index: Whole, level: Numbers) -> Numbers:
        """Force at the strain with an index for each unit, levels first."""
        other_units, unit = (
            xp.take_along_axis(x, index, axis=-1)[..., 0] for x in (other_force[None], level)
        )
        return other_units + count * unit

    def first_zero(force: Numbers) -> Numbers:
        """First strain at which the force of any level vanishes, in steps of the strain."""
        right = first_push(other_force + count[:, None] * force.min(axis=0))
        ahead, behind = (total(right[None, :, None] + step, force) for step in (-1, 0))
        vanishes = (behind <= 0) | (right == last)
        return right - 1 + where(vanishes, chord_zero(ahead, behind), 1.0).min(axis=0)

    return last_strain * (first_zero(force[:1]) - first_zero(force)) / last


def reversal_depth(counts: Whole, curves: Numbers, top: Numbers, states: States) -> Numbers:
    """Reversal depth of one design [-]: unit after unit in the order of their recruitment.

    `counts`: muscles in each unit; `curves`: force of a muscle of each at every level and even
    strain [N], units last; `top`: the last of the strains [-].
    """
    xp, n = array_namespace(curves), counts[states.order]
    force = xp.moveaxis(curves, -1, 1)[:, states.order]
    vented, full = n[:, None] * force[0], n[:, None] * force[-1]
    before = full.cumsum(axis=0) - full
    after = vented.sum(axis=0) - vented.cumsum(axis=0)
    falls = free_strain_falls(before + after, n, force, top)
    later = (np.arange(len(n)) > 0) & (n > 0)
    return where(later, falls, 0.0).max()


def uniform_reversal_depths(
    counts: Int[np.ndarray, "unit design"],
    curves: Float[np.ndarray, "level strain"],
    top: float,
    states: States,
) -> Float[np.ndarray, " design"]:
    """Reversal depth of designs of one muscle [-].

    `counts`: muscles in each unit; `curves`: force of a muscle at every level and even strain [N];
    `top`: the last of the strains [-].
    """
    n = counts[states.order]
    before = n.cumsum(axis=0) - n
    vented = n.sum(axis=0) - before - n
    # a fall depends on (a, n, r) alone
    shape = (int(n.sum(axis=0).max()) + 1,) * 3
    code, index = np.unique(np.ravel_multi_index((before, n, vented), shape), return_inverse=True)
    transitions = np.stack(np.unravel_index(code, shape))
    falls = np.zeros(transitions.shape[1])
    (later,) = np.nonzero((transitions[0] > 0) & (transitions[1] > 0))
    step = max(1, _BATCH // curves.shape[1])
    for start in range(0, later.size, step):
        portion = later[start : start + step]
        a, m, r = transitions[:, portion]
        other_force = a[:, None] * curves[-1] + r[:, None] * curves[0]
        falls[portion] = free_strain_falls(other_force, m, curves[:, None], top)
    return falls[index.reshape(n.shape)].max(axis=0)


def largest_overlap(
    counts: Whole, curves: Numbers, levels: Numbers, states: States, exists: Marks
) -> Numbers:
    """Overlap of the force ranges of two successive states, of each design [N]: the largest over
    all strains and pairs of states, forces below zero left out.

    `counts`: muscles in each unit, units first, designs last; `curves`: force of a muscle of each
    unit at every level and even strain [N]; `levels`: the curves; where all units have one muscle,
    least and largest are enough [N]; `exists`: mask of the states that designs have.
    """
    xp = array_namespace(counts, curves)
    vented, full, throttled = (
        xp.moveaxis(counts * x, -counts.ndim, -1) for x in (curves[0], curves[-1], levels)
    )
    low, high = states.edges(throttled, vented, full)
    bottom, top = overlap_edges((low[:-1], high[:-1]), (low[1:], high[1:]))
    height = (top - bottom).max(axis=1, initial=0.0)
    return where(exists[1:], height, 0.0).max(axis=0, initial=0.0)


def first_push(force: Float[AnyArray, "*any strain"]) -> Int[AnyArray, "*any"]:
    """Index of the first strain after rest at which a `force` [N] over strains, on the last axis,
    doesn't pull; else of the last strain.
    """
    xp = array_namespace(force)
    index = xp.arange(force.shape[-1])
    pushes = ((force <= 0) & (index > 0)) | (index == force.shape[-1] - 1)
    return xp.argmax(pushes, axis=-1)


def chord_zero(left: Numbers, right: Numbers) -> Numbers:
    """Share of the way from a strain to the next at which a force vanishes [-]; `left`, `right`:
    the force at both [N].
    """
    # the last of all may still pull by rounding: it is the zero itself
    drop = left - minimum(right, 0.0)
    return where(left > 0, left / where(drop > 0, drop, 1.0), 0.0)
