"""Input of a policy: the present state of a bundle's units, and the demand on them."""

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
        """Units of the bundle `side` of a `plant`, counted from 0."""
        bundle, top = plant.bundles[side], plant.supply_pressure
        key = "control.units", top
        if key not in bundle.cache:
            bundle.cache[key] = Branches.of(bundle, top)
        indices = plant.unit_indices(side)
        chamber, valve, exhaust = (
            of_units(piece, indices, plant.units)
            for piece in (plant.chamber, plant.valve, plant.exhaust_valve)
        )
        return cls(
            bundle.cache[key], plant.counts[indices], chamber, valve, exhaust,
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
        room, temperature = self.chamber.room_pressure, self.chamber.room_temperature
        p = maximum(pressure, 0.0) + room
        return (
            self.valve.flow(supply + room, p, self.supply_temperature, temperature),
            self.exhaust_valve.flow(p, room, temperature, temperature),
        )


class UnitDemand(NamedTuple):
    """Present demand: a `force` [N] that changes at a `rate` [N/s], at `strains` of the units
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
    """Capability of units at their strains: each one's force when `full` and `empty` [N],
    `gains`, true where it adds force, the `onset` of each [Pa], its `dip` [N] and
    `dip_pressure` [Pa], what a state
    holds at most, `largest` [N], how long each one's valve takes to its onset, `time`, from there
    back, `vent`, and from where it is until it is near the supply's pressure, `climb` [s], at
    which mean `speed` [Pa/s], and the force that each lacks there, `near` [N], as its valve is slow
    beyond.
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


def evaluate_capability(units: Units, demand: UnitDemand) -> UnitCapability:
    """Capability of `units` for a `demand`."""
    xp, eps, n = array_namespace(demand.strains), demand.strains, units.counts
    none = 0.0 * eps
    top = minimum(demand.supply, units.branches.top) + none
    empty, full = n * units.branches.force(none, eps), n * units.branches.force(top, eps)
    gains = full > empty
    full = where(gains, full, empty)
    depth, at = units.branches.dip(eps)
    onset = units.branches.onset(eps)
    largest = xp.cumsum(full, axis=-1) + xp.sum(empty) - xp.cumsum(empty, axis=-1)
    is_near = minimum(onset, CLOSE * top)
    flow, _ = units.flows(is_near, top)
    is_close = full - n * units.branches.force(CLOSE * top, eps)
    _, out = units.flows(_LATE * is_near, top)
    holding = maximum(units.content(is_near, eps) - units.content(none, eps), 0.0)
    time, vent = holding / maximum(flow, 1e-12), holding / maximum(out, 1e-12)
    is_close = where(gains, is_close, 0.0)
    climb = _climb(units, demand, CLOSE * top)
    speed = maximum(CLOSE * top - demand.pressures, 0.0) / maximum(climb, 1e-9)
    level = minimum(maximum(demand.pressures, 0.0), _CHORD * top)
    risen = full - is_close - n * units.branches.force(level, eps)
    slope = maximum(risen / (CLOSE * top - level), _FLAT * absolute(full) / top + 1e-12)
    return UnitCapability(
        full, empty, gains, onset, n * depth, at, largest, time, vent, climb, speed, slope, is_close
    )


def _climb(units: Units, demand: UnitDemand, end: Numbers) -> Numbers:
    """How long [s] each unit's valve, wide open, takes from its pressure to an `end` [Pa]."""
    level = minimum(maximum(demand.pressures, 0.0), end)
    ends = level + _LEGS[:, None] * (end - level)
    holding = units.content(ends, demand.strains)
    flow, _ = units.flows((ends[1:] + ends[:-1]) / 2, demand.supply + 0.0 * level)
    legs = maximum(holding[1:] - holding[:-1], 0.0) / maximum(flow, 1e-12)
    return array_namespace(legs).sum(legs, axis=0)


def share_demand(
    units: Units,
    capability: UnitCapability,
    demand: UnitDemand,
    low: Numbers,
    high: Numbers,
    felt: Numbers | None = None,
) -> tuple[Numbers, Whole]:
    """Pressures [Pa] of `units` that are filled one after the other, and the status of each.

    Each unit is filled from a `low` to a `high` pressure [Pa] until together they meet the
    `demand`. `felt`: pressures [Pa] at which throttled units pull now, as long as they have not
    reached `low`.
    """
    xp, n = array_namespace(demand.strains), units.counts
    at_low = n * units.branches.force(low if felt is None else felt, demand.strains)
    at_high = where(
        capability.gains, n * units.branches.force(high, demand.strains), capability.empty
    )
    at_high = maximum(at_high, at_low)
    before = xp.cumsum(at_high, axis=-1) - at_high
    after = xp.sum(at_low, axis=-1, keepdims=True) - xp.cumsum(at_low, axis=-1)
    result = units.branches.pressure((demand.force - before - after) / n, demand.strains)
    return minimum(maximum(result.pressure, low), high), result.status


def hand_over_times(
    capability: UnitCapability, before: Numbers, unit: Numbers
) -> tuple[Batch, Batch]:
    """How long [s] a hand-over to a `unit` [-] from the one `before` it [-], both as ones among
    zeros, several in rows, takes to where the dip is deepest, and to its end, by the units'
    `capability` [SI].

    Where it is deepest the unit before must have come as near to the supply's pressure as it ever
    will: its valve, whose flow vanishes there, has until then, and no longer.
    """

    def of(index: Numbers, values: Numbers) -> Batch:
        return array_namespace(values).sum(index * values, axis=-1)

    t_c = of(unit, capability.time)
    piece = minimum(
        of(unit, capability.dip_pressure) / maximum(of(unit, capability.onset), 1.0), 1.0
    )
    deepest = maximum(piece * t_c, of(before, capability.climb))
    return deepest, deepest + (1 - piece) * t_c
