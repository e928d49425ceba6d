"""What a policy knows: a bundle's units as they are now, and what is asked of them."""

from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import absolute, array_namespace, maximum, minimum, where
from ..core.module import Module
from ..core.types import Batch, Numbers, Whole
from ..dynamics import Plant
from .branches import Branches
from .valves import of_units


CLOSE = 0.95  # of the supply: nearer a gas hardly flows, and a hand-over would be endless
SLACK = 1.2  # of a valve's time: a ramp at its limit couldn't be followed
_CHORD = 0.85  # of the supply: where a chord up to `CLOSE` begins at the latest
_FLAT = 0.01  # of a unit's mean slope, which no chord is taken to be below
_LEGS = np.linspace(0.0, 1.0, 5)  # of a climb, each at its own flow: within 2 % up to `CLOSE`
_LATE = 0.25  # of the onset, where a unit that is vented is slow, but not yet hardly flows


class Units(Module):
    """One bundle's units with their chambers and valves, on the last axis.

    `branches`: their feedforward [-]. `counts`: their muscles [-]. `chamber`, `valve`,
    `exhaust_valve`: the plant's, of these units [-]. `supply_temperature` [K].
    """

    branches: Branches
    counts: Numbers
    chamber: Any
    valve: Any
    exhaust_valve: Any
    supply_temperature: Batch

    @classmethod
    def of(cls, plant: Plant, side: int) -> "Units":
        """Those of a `plant`'s [-] bundle `side` [-], counted from 0."""
        bundle, top = plant.bundles[side], plant.supply_pressure
        key = "control.units", top
        if key not in bundle.store:
            bundle.store[key] = Branches.of(bundle, top)
        places = plant.places(side)
        chamber, valve, exhaust = (
            of_units(part, places, plant.units)
            for part in (plant.chamber, plant.valve, plant.exhaust_valve)
        )
        return cls(
            bundle.store[key], plant.counts[places], chamber, valve, exhaust,
            np.float64(plant.supply.temperature_at(plant.supply.start())),
        )  # fmt: skip

    @property
    def many(self) -> int:
        """How many units there are [-]."""
        return len(self.counts)

    def content(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Mass [kg] in each unit's chamber at a `pressure` [Pa] and `strain` [-]."""
        V = self.counts * self.branches.muscles.at(pressure, strain).volume
        return self.chamber.start(pressure, V)[..., 0]

    def flows(self, pressure: Numbers, supply: Numbers) -> tuple[Numbers, Numbers]:
        """Into and out of each chamber at a `pressure` [Pa] below its `supply` [Pa], wide open
        [kg/s].
        """
        room, warm = self.chamber.room_pressure, self.chamber.room_temperature
        p = maximum(pressure, 0.0) + room
        return (
            self.valve.flow(supply + room, p, self.supply_temperature, warm),
            self.exhaust_valve.flow(p, room, warm, warm),
        )


class UnitDemand(NamedTuple):
    """What is asked now: a `force` [N] that changes at a `rate` [N/s], at `strains` of the units
    [-], with their `pressures` [Pa] and the supply's [Pa], which come `lag` after they are wanted
    [s]; `dt` since it was asked last [s].
    """

    force: Batch
    rate: Batch
    strains: Numbers
    pressures: Numbers
    supply: Batch
    lag: Batch
    dt: Batch


class UnitCapability(NamedTuple):
    """What units can do at their strains: each one's force when `full` and `empty` [N], whether it
    `gains` [-], the `onset` of each [Pa], its `dip` [N] and `dip_pressure` [Pa], what a state
    holds at most, `largest` [N], how long each one's valve takes to its onset, `time`, from there
    back, `vent`, and from where it is until it is `near` the supply's pressure, `climb` [s], at
    which mean `speed` [Pa/s], and what each lacks there, `near`, as its valve is slow beyond [N].
    """

    full: Numbers
    empty: Numbers
    gains: Any
    onset: Numbers
    dip: Numbers
    dip_pressure: Numbers
    largest: Numbers
    time: Numbers
    vent: Numbers
    climb: Numbers
    speed: Numbers
    slope: Numbers
    near: Numbers


def evaluate_capability(units: Units, asked: UnitDemand) -> UnitCapability:
    """What `units` [-] can do of what is `asked` [-]."""
    xp, eps, n = array_namespace(asked.strains), asked.strains, units.counts
    none = 0.0 * eps
    top = minimum(asked.supply, units.branches.top) + none
    empty, full = n * units.branches.force(none, eps), n * units.branches.force(top, eps)
    gains = full > empty
    full = where(gains, full, empty)
    depth, at = units.branches.dip(eps)
    onset = units.branches.onset(eps)
    largest = xp.cumsum(full, axis=-1) + xp.sum(empty) - xp.cumsum(empty, axis=-1)
    near = minimum(onset, CLOSE * top)
    flow, _ = units.flows(near, top)
    close = full - n * units.branches.force(CLOSE * top, eps)
    _, out = units.flows(_LATE * near, top)
    held = maximum(units.content(near, eps) - units.content(none, eps), 0.0)
    time, vent = held / maximum(flow, 1e-12), held / maximum(out, 1e-12)
    close = where(gains, close, 0.0)
    climb = _climb(units, asked, CLOSE * top)
    speed = maximum(CLOSE * top - asked.pressures, 0.0) / maximum(climb, 1e-9)
    here = minimum(maximum(asked.pressures, 0.0), _CHORD * top)
    risen = full - close - n * units.branches.force(here, eps)
    slope = maximum(risen / (CLOSE * top - here), _FLAT * absolute(full) / top + 1e-12)
    return UnitCapability(
        full, empty, gains, onset, n * depth, at, largest, time, vent, climb, speed, slope, close
    )


def _climb(units: Units, asked: UnitDemand, end: Numbers) -> Numbers:
    """How long [s] each unit's valve, wide open, takes from its pressure to an `end` [Pa]."""
    here = minimum(maximum(asked.pressures, 0.0), end)
    ends = here + _LEGS[:, None] * (end - here)
    held = units.content(ends, asked.strains)
    flow, _ = units.flows((ends[1:] + ends[:-1]) / 2, asked.supply + 0.0 * here)
    legs = maximum(held[1:] - held[:-1], 0.0) / maximum(flow, 1e-12)
    return array_namespace(legs).sum(legs, axis=0)


def share_demand(
    units: Units,
    now: UnitCapability,
    asked: UnitDemand,
    low: Numbers,
    high: Numbers,
    felt: Numbers | None = None,
) -> tuple[Numbers, Whole]:
    """Pressures of `units` [-] that are filled in turn between a `low` and a `high` pressure [Pa]
    of each, so that together they pull as is `asked` [-]; and each one's status [-]. Where they
    aren't there yet, what is `felt` of those that are throttled last is given instead of `low`
    [Pa].
    """
    xp, n = array_namespace(asked.strains), units.counts
    at_low = n * units.branches.force(low if felt is None else felt, asked.strains)
    at_high = where(now.gains, n * units.branches.force(high, asked.strains), now.empty)
    at_high = maximum(at_high, at_low)
    before = xp.cumsum(at_high, axis=-1) - at_high
    after = xp.sum(at_low, axis=-1, keepdims=True) - xp.cumsum(at_low, axis=-1)
    found = units.branches.pressure((asked.force - before - after) / n, asked.strains)
    return minimum(maximum(found.pressure, low), high), found.status


def hand_over_times(now: UnitCapability, before: Numbers, unit: Numbers) -> tuple[Batch, Batch]:
    """How long [s] a hand-over to a `unit` [-] from the one `before` it [-], both as ones among
    zeros, several in rows, takes to where the dip is deepest, and to its end, from what units can
    do `now` [SI].

    Where it is deepest the unit before must have come as near to the supply's pressure as it ever
    will: its valve, whose flow vanishes there, has until then, and no longer.
    """

    def of(which: Numbers, values: Numbers) -> Batch:
        return array_namespace(values).sum(which * values, axis=-1)

    t_c = of(unit, now.time)
    part = minimum(of(unit, now.dip_pressure) / maximum(of(unit, now.onset), 1.0), 1.0)
    deepest = maximum(part * t_c, of(before, now.climb))
    return deepest, deepest + (1 - part) * t_c
