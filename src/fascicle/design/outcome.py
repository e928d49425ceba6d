r"""Outcome of designs at the points of a task, from a table of their muscles' forces.

A recruitment state covers, at one strain, the forces between the least and the largest that
its throttled pressure gives, sums over units as in (B10). A demanded force within is met there, in
the lowest state that covers it, which takes least fluid; else its *shortfall* is the distance to
the nearest force that any state gives. What the largest of all states exceeds the demanded force by
is *spare*. The fluid energy is (29) with all units that the state feeds; a point that isn't met is
charged as if every unit were fed.

The least force of a state needn't be known where states are joined: vented, a state gives no more
than an earlier one does when fed, and the first pulls nowhere. So the lowest state whose largest
force is enough covers a force that none below it reaches. Where a scheme leaves a gap between
states it is computed. Where units are independent, every choice of those that are fed is a state.

**Shapes:** points first, then motor units, then designs. Regions are taken over a fixed number of
throttled pressures; their edges are exact where the force is linear in pressure, that is, wherever
the muscle pulls.

**Reversal.** While a unit's pressure rises from zero, earlier ones at the supply's, the free strain
may fall. It is computed on force curves at even strains and every level of the throttled pressure,
linear between two strains: the first strain at which the least force of all levels vanishes is
located first; levels are compared at that strain alone.

Where all muscles of a design are equal, its force

$$F = a F_{full}(\varepsilon) + n F(p, \varepsilon) + r F_{none}(\varepsilon) \tag{G2}$$

with $a$ muscles at full supply, $n$ throttled and $r$ vented makes the depth one of $(a, n, r)$
alone, which many designs share.
"""

from typing import NamedTuple

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..bundle.states import States, is_prefix_consistent, overlap_edges, states_of
from ..core.array_namespace import slices
from ..core.types import Bool, Float, Int
from ..core.validation import LARGEST_STRAIN
from .designs import packed_radius
from .task import Task


FORCE_TOLERANCE = 1e-9  # N, a shortfall of rounding
_BATCH = 2**20  # numbers computed together, some ten megabytes
MAX_FED_SETS = 255  # sets of independent units that may be fed: all of eight

PerDesign = Float[np.ndarray, " design"]
Points = Float[np.ndarray, "point design"]
Counts = Int[np.ndarray, "unit design"]
Curves = Float[np.ndarray, "level strain muscle"]


class ForceTable(NamedTuple):
    """Table of muscles' forces at the task's points, points first, muscles last.

    `vented` and `full`: at no and at the supply's pressure [N]; `levels`: at each throttled level,
    or the largest over all of them alone [N], levels first; fluid `volume` taken in [m³]; `blocked`
    force [N]. If computed, `radius` and `bulge` [m] at the task's largest strain.
    """

    vented: np.ndarray
    full: np.ndarray
    levels: np.ndarray
    volume: np.ndarray
    blocked: np.ndarray
    radius: np.ndarray | None = None
    bulge: np.ndarray | None = None

    def take(self, index: Int[np.ndarray, "unit design"], factor: PerDesign) -> "ForceTable":
        """The table of muscles with an `index`, with forces `factor` times as large [-]."""
        forces = (self.vented, self.full, self.levels, self.blocked)
        vented, full, levels, blocked = (factor * x[..., index] for x in forces)
        radius, bulge = (x if x is None else x[..., index] for x in (self.radius, self.bulge))
        return ForceTable(vented, full, levels, self.volume[..., index], blocked, radius, bulge)


class Outcome(NamedTuple):
    """Outcome of designs at the task's points, designs on the last axis.

    `force` [N], `weight` [-] and `work` [J] of each demanded point; true where it is `reached`, its
    `shortfall` and the force to `spare` [N], negative where it isn't reached, and the fluid
    `energy` [J] it takes. `blocked`: each unit's force at rest and full supply [N]; number of
    motor `units`. If computed: `size` [m], the envelope's diameter, `depth` [-] of reversal,
    `overlap` [N].
    """

    force: Float[np.ndarray, "point 1"]
    weight: Float[np.ndarray, "point 1"]
    work: Points
    reached: Bool[np.ndarray, "point design"]
    shortfall: Points
    spare: Points
    energy: Points
    blocked: Float[np.ndarray, "unit design"]
    units: Int[np.ndarray, " design"]
    size: PerDesign | None = None
    depth: PerDesign | None = None
    overlap: PerDesign | None = None

    @property
    def reference(self) -> Float[np.ndarray, "point 1"]:
        """Force that shares refer to [N]: the demanded one, or the task's largest if none is."""
        return np.where(self.force > 0, self.force, self.force.max())


class Recruitment(NamedTuple):
    """Recruitment `states` of designs, and `numbers` of them that 0, 1, … motor units have."""

    states: States
    numbers: Int[np.ndarray, " unit"]

    def existing(self, counts: Counts) -> Bool[np.ndarray, "state design"]:
        """Mask of the states that each design has: fewer units have fewer states."""
        return np.arange(self.states.size)[:, None] < self.numbers[np.sum(counts > 0, axis=0)]


def recruitment_of(scheme: AbstractScheme, units: int) -> Recruitment:
    """Recruitment of so many `units`; of independent ones by the sets that can be pressurized,
    `ValueError` for too many.
    """

    def states(units: int) -> States:
        return states_of(scheme, units).sets(max_sets=MAX_FED_SETS)[0]

    every = states(units)
    if scheme.independent or not is_prefix_consistent(scheme, units):
        # sets with a unit that doesn't exist repeat those without it
        return Recruitment(every, np.full(units + 1, every.size))
    return Recruitment(every, np.array([0, *(states(n).size for n in range(1, units + 1))]))


def outcome(
    counts: Counts,
    table: ForceTable,
    length: PerDesign,
    task: Task,
    recruitment: Recruitment,
    depth: PerDesign | None = None,
    overlap: PerDesign | None = None,
) -> Outcome:
    """Outcome of designs at a task's points, each in the state that takes least fluid of those that
    give the demanded force, which is the lowest if states are nested.

    `counts`: muscles in each unit; `table`: of a muscle of each unit, or of one for all units;
    `length`: of the bundles at rest [m]; `recruitment` of the task's scheme; `depth` of reversal
    [-] and `overlap` of states [N], if computed.
    """
    states, existing, has_state = recruitment.states, counts > 0, recruitment.existing(counts)
    vented, full, levels, volume = (
        np.moveaxis(counts * x, -2, -1)
        for x in (table.vented, table.full, table.levels, table.volume)
    )

    def pressurized_sum(values: np.ndarray) -> np.ndarray:
        return np.moveaxis(values @ states.pressurized.T.astype(float), -1, 0)

    if len(levels) == 1:  # the largest alone
        low = high = states.sums(levels[0], vented, full)
    else:
        low, high = states.edges(levels, vented, full)
    high = np.where(has_state[:, None], high, -np.inf)
    F, stroke = task.force[:, None], task.stroke_of(length)
    is_possible = stroke <= LARGEST_STRAIN * length
    covers, miss = F - high <= FORCE_TOLERANCE, F - high
    if not states.gapless:
        covers, miss = covers & (low - F <= FORCE_TOLERANCE), np.maximum(miss, low - F)
    state = covers.argmax(axis=0)
    if not states.nested:
        # what flows back counts as nothing, as a set that feeds more isn't cheaper
        state = np.where(covers, pressurized_sum(np.maximum(volume, 0.0)), np.inf).argmin(axis=0)
    top, miss = high.max(axis=0), np.maximum(miss.min(axis=0), 0.0)
    reached = (miss <= FORCE_TOLERANCE) & is_possible
    # where it can't be that short it is short of the force, and of what it pushes with there
    miss = np.where(is_possible, miss, np.maximum(miss, F))
    spare = np.where(is_possible, top, np.minimum(top, -2 * FORCE_TOLERANCE)) - F
    if not states.gapless:  # a larger force is no help there
        spare = np.where(reached, spare, np.minimum(spare, -miss))
    state = np.where(reached, state, has_state.sum(axis=0) - 1)
    fluid = np.take_along_axis(pressurized_sum(volume), state[None], axis=0)[0]
    work = (
        F * stroke if task.strain is None else np.multiply.outer(task.force * task.strain, length)
    )
    units, size = existing.sum(axis=0), None
    if table.radius is not None and table.bulge is not None:
        # a lone unit is fed, and doesn't bow
        bulge = np.where(units > 1, np.where(existing, table.bulge, 0.0).max(axis=0), 0.0)
        size = 2 * (packed_radius((table.radius + 0.0 * counts).T, counts.T) + bulge)
    return Outcome(
        *(F, task.weight[:, None], work, reached, np.where(reached, 0.0, miss), spare),
        *(task.supply_pressure * fluid, counts * table.blocked, units, size, depth, overlap),
    )


def _free_strain_falls(
    other_force: np.ndarray, count: np.ndarray, force: np.ndarray, last_strain: float
) -> Float[np.ndarray, " unit"]:
    """Largest fall of a bundle's free strain while one unit's pressure rises from zero to the
    supply's [-], for each unit that rises; `other_force`: of all other units at even strains up to
    `last_strain` [N]; `count`: muscles of the unit; `force`: of one, by level and strain [N].
    """
    last = other_force.shape[-1] - 1

    def first_zero(force: np.ndarray) -> np.ndarray:
        """First strain at which the force of any level vanishes, in steps of the strain."""
        pushes = other_force + count[:, None] * force.min(axis=0) <= 0
        pushes[:, 0], pushes[:, -1] = False, True  # after rest; else the last
        right = pushes.argmax(axis=1)
        ahead, behind = (
            np.take_along_axis(other_force[None], index, axis=-1)[..., 0]
            + count * np.take_along_axis(force, index, axis=-1)[..., 0]
            for index in (right[None, :, None] - 1, right[None, :, None])
        )
        # along the chord; the last of all may still pull by rounding: it is the zero itself
        drop = ahead - np.minimum(behind, 0.0)
        chord = np.where(ahead > 0, ahead / np.where(drop > 0, drop, 1.0), 0.0)
        vanishes = (behind <= 0) | (right == last)
        return right - 1 + np.where(vanishes, chord, 1.0).min(axis=0)

    return last_strain * (first_zero(force[:1]) - first_zero(force)) / last


def reversal_depths(counts: Counts, curves: Curves, top: float, states: States) -> PerDesign:
    """Reversal depth of designs of the same muscles [-]; `curves`: force of each unit's, or of one
    for all units, at every level and even strain up to `top` [N].
    """
    n = counts[states.order]
    before = n.cumsum(axis=0) - n
    if curves.shape[-1] > 1:
        force, depths = np.moveaxis(curves, -1, 1)[:, states.order], []
        for number, earlier in zip(n.T, before.T, strict=True):
            vented, full = number[:, None] * force[0], number[:, None] * force[-1]
            other_force = full.cumsum(axis=0) - full + vented.sum(axis=0) - vented.cumsum(axis=0)
            falls = _free_strain_falls(other_force, number, force, top)
            depths.append(np.where((earlier > 0) & (number > 0), falls, 0.0).max())
        return np.array(depths)
    # a fall depends on the (a, n, r) of (G2) alone
    vented = n.sum(axis=0) - before - n
    shape = (int(n.sum(axis=0).max()) + 1,) * 3
    code, index = np.unique(np.ravel_multi_index((before, n, vented), shape), return_inverse=True)
    transitions = np.stack(np.unravel_index(code, shape))
    falls, force = np.zeros(len(code)), np.moveaxis(curves, -1, 1)
    (later,) = np.nonzero((transitions[0] > 0) & (transitions[1] > 0))
    for block in slices(later.size, max(1, _BATCH // curves.shape[1])):
        a, m, r = transitions[:, later[block]]
        other_force = a[:, None] * force[-1] + r[:, None] * force[0]
        falls[later[block]] = _free_strain_falls(other_force, m, force, top)
    return falls[index.reshape(n.shape)].max(axis=0)


def overlaps(counts: Counts, curves: Curves, recruitment: Recruitment) -> PerDesign:
    """Overlap of the force ranges of two successive states [N]: the largest over all strains and
    pairs of states, forces below zero left out; else as `reversal_depths`.
    """
    states, has_state = recruitment.states, recruitment.existing(counts)
    # of one muscle the least and the largest force are enough
    levels = curves
    if curves.shape[-1] == 1:
        levels = np.stack([curves.min(axis=0), curves.max(axis=0)])
    widths = np.empty(counts.shape[1])
    for block in slices(len(widths), max(1, _BATCH // (levels[..., 0].size * len(counts)))):
        vented, full, throttled = (
            np.moveaxis(counts[:, block] * x[..., None], -2, -1)
            for x in (curves[0], curves[-1], levels)
        )
        low, high = states.edges(throttled, vented, full)
        bottom, top = overlap_edges((low[:-1], high[:-1]), (low[1:], high[1:]))
        height = (top - bottom).max(axis=1, initial=0.0)
        widths[block] = np.where(has_state[1:, block], height, 0.0).max(axis=0, initial=0.0)
    return widths
