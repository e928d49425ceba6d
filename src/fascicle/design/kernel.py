r"""The one kernel that judges designs: what they do, from a table of their muscles' forces.

What a state's units give is a sum over them, (B10). Where a design's muscles are all alike it is a
number of muscles times what one gives, (G2); where every unit has a muscle of its own it is added
up unit by unit, (B1). That is all that the two kinds of design differ in here.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..bundle.states import States
from ..core.array_namespace import array_namespace, maximum, where
from ..core.types import Bool, Numbers, Whole
from .designs import bowed_diameter
from .outcome import Demand, Outcome, existing, laid, states_for, visited
from .tables import Table


Mask = Bool[np.ndarray, " unit"]
Masks = Bool[np.ndarray, "state unit"]


class Alike(NamedTuple):
    """Designs of one muscle: `counts` of it in each unit [-], units first."""

    counts: Whole

    def adder(self, values: Numbers) -> Callable[[Mask], Numbers]:
        """What gives, for the units of a mask, the sum of what all their muscles give; `values`:
        one's at each point [any unit].
        """
        each = values[:, None]
        return lambda mask: (mask.astype(int) @ self.counts) * each

    def up_to(self, state: Whole, values: Numbers, masks: Masks) -> Numbers:
        """The same of all masks up to the one of each design's `state` at a point [any unit]."""
        # few states: a sum over them is faster than to look the state up
        muscles = sum(
            where(state >= k, mask @ self.counts, 0) for k, mask in enumerate(masks.astype(int))
        )
        return muscles * values[:, None]

    def at(self, state: Whole, values: Numbers, masks: Masks) -> Numbers:
        """The same of the one mask of each design's `state` at a point [any unit]."""
        muscles = masks.astype(int) @ self.counts
        return (
            array_namespace(muscles, state).take_along_axis(muscles, state, axis=0)
            * values[:, None]
        )

    def cost(self, _: Numbers, masks: Masks) -> Numbers:
        """What tells masks apart, which are first: all muscles take the same, the fewest least."""
        return 1.0 * (masks.astype(int) @ self.counts)[:, None]


class Unlike(NamedTuple):
    """Designs whose units have muscles of their own: `counts` of them [-], units first."""

    counts: Whole

    def adder(self, values: Numbers) -> Callable[[Mask], Numbers]:
        """What gives, for the units of a mask, the sum of what all their muscles give; `values`:
        of a muscle of each unit, points ahead of units [any unit].
        """
        every = self.counts * values
        return lambda mask: every[:, _run(mask)].sum(axis=1)

    def up_to(self, state: Whole, values: Numbers, masks: Masks) -> Numbers:
        """The same of all masks up to the one of each design's `state` at a point [any unit]."""
        each = self.adder(values)
        return sum(where(state >= k, each(mask), 0.0) for k, mask in enumerate(masks))

    def at(self, state: Whole, values: Numbers, masks: Masks) -> Numbers:
        """The same of the one mask of each design's `state` at a point [any unit]."""
        every = self.counts * values
        at_work = array_namespace(every, state)
        fed = at_work.moveaxis(at_work.asarray(masks)[state], -1, 1)
        return where(fed, every, 0.0).sum(axis=1)

    def cost(self, values: Numbers, masks: Masks) -> Numbers:
        """What tells masks apart, which are first: what is taken in [any unit]."""
        # what flows back counts as nothing, as a set that feeds more isn't cheaper
        every = maximum(self.counts * values, 0.0)
        at_work = array_namespace(every)
        return at_work.moveaxis(at_work.moveaxis(every, 1, -1) @ masks.T.astype(float), -1, 0)


def highest(units: Alike | Unlike, table: Table, states: States) -> list[Numbers]:
    """Largest force of each state.

    **Arguments:**

    - `units`: of the designs [-].
    - `table`: of their muscles [-].
    - `states`: of the scheme [-]; where two units share a pressure, they must be alike.

    **Returns:** forces [N], of each state in turn.
    """
    full, unfed, largest = map(units.adder, (table.full, table.unfed, table.largest))
    # not stacked: states are looked at in turn, and needn't be written to memory
    return [
        full(at_full) + unfed(none) + largest(throttled)
        for at_full, throttled, none in zip(
            states.full, states.throttled, states.unfed, strict=True
        )
    ]


def outcome(
    units: Alike | Unlike,
    table: Table,
    length: Numbers,
    demand: Demand,
    high: Sequence[Numbers] | Numbers | None = None,
    low: Numbers | None = None,
    depth: Numbers | None = None,
    overlap: Numbers | None = None,
) -> Outcome:
    """What designs do.

    **Arguments:**

    - `units`: of the designs, which are last [-]; of a single one there is no axis for them.
    - `table`: of their muscles [-].
    - `length`: of the bundles at rest [m], one or of every design.
    - `demand`: the task's [-].
    - `high`: largest force of each state in turn [N]; left out, as the table has it.
    - `low`: least force of each state [N]; left out where no gap is between states.
    - `depth`: of reversal [-], or none.
    - `overlap`: of states [N], or none.

    **Returns:** the outcome [-].
    """
    n = units.counts
    there, axes = n > 0, np.ndim(n) - 1
    states, exist = states_for(demand.scheme, len(n)), existing(demand.scheme, there)
    high = highest(units, table, states) if high is None else high
    if states.nested:
        visit = visited(demand, length, high, exist, low)
        new = np.diff(states.fed, axis=0, prepend=False)
        taken = units.up_to(visit.state, table.volume, new)
    else:
        cost = units.cost(table.volume, states.fed)
        visit = visited(demand, length, high, exist, low, cost)
        taken = units.at(visit.state, table.volume, states.fed)
    size = None
    if table.radius is not None and table.bulge is not None:
        bulge = where(there, table.bulge, 0.0).max(axis=0)
        size = bowed_diameter((table.radius + 0.0 * n).T, n.T, bulge)
    return Outcome(
        force=laid(demand.force, axes),
        weight=laid(demand.weight, axes),
        work=laid(demand.work(length), axes),
        reached=visit.reached,
        shortfall=visit.shortfall,
        spare=visit.spare,
        energy=demand.supply * taken,
        blocked=n * table.blocked,
        units=there.sum(axis=0),
        size=size,
        depth=depth,
        overlap=overlap,
    )


def _run(mask: Mask) -> Any:
    """The places that are marked [-]: a slice if they follow one another, which copies nothing."""
    places = np.flatnonzero(mask)
    if not places.size:
        return slice(0, 0)
    first, last = int(places[0]), int(places[-1])
    return slice(first, last + 1) if last - first + 1 == places.size else places
