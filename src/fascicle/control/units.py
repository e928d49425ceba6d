r"""Motor units as a controller knows them: their forces, chambers, valves and times.

The content $m$ of a chamber is a gas's mass or a liquid's volume. At the strain $\varepsilon$,
with the volume $V^*$ that is conjugate to the force, a valve fills a unit to its onset in

$$t_c = \frac{m\left(p_{on}, n V^*(p_{on}, \varepsilon)\right)
    - m\left(0, n V^*(0, \varepsilon)\right)}{\dot m}, \qquad
  m = \frac{(p + p_a)\, V}{R T_a} \text{ of a gas},\quad V \text{ of a liquid}. \tag{X4}$$

With the straight braid's $V(\varepsilon)$ in its place a gas would seem to come a quarter to a
third sooner, a liquid at once.

**Assumes** gas as warm as the room: gas that heats up as it is compressed comes sooner.
**Source:** derived here.
"""

import abc
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch, Marks, Numbers, PyTree
from ..core.validation import Range
from ..dynamics import Plant
from ..fluid import AIR, AbstractChamber, Gas, Orifice, SonicValve
from ..fluid.fields import component_field, positive_field, room_pressure_field, temperature_field
from .branches import Branches


CLOSE = 0.95  # of the supply: nearer a gas hardly flows, and a hand-over would take forever
SLACK = 1.2  # of a valve's time: pressures couldn't follow a ramp at the valve's limit
ABOVE = 0.01  # of the supply over the onset, at which a recruited unit is parked: no less force
CHORD = 0.85  # of the supply: the highest beginning of a chord up to `CLOSE`
_LEGS = np.linspace(0.0, 1.0, 5)  # of a climb, each at its own flow: within 2 % up to `CLOSE`
LATE = 0.25  # of the onset, where venting is slow, but does not yet stop


class AbstractValves(Module):
    """Model of one motor unit's filling: content of its chamber, and flow of its valve."""

    @abc.abstractmethod
    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Content [kg or m³] at gauge `pressure` [Pa] in a `volume` [m³] of muscles."""

    @abc.abstractmethod
    def flow(self, pressure: Numbers) -> Batch:
        """Flow [kg/s or m³/s] from the supply into a unit of gauge `pressure` [Pa]."""


class GasValves(AbstractValves):
    """Valve for gas at a `mass_flow`, $\\dot m$ [kg/s], that does not depend on the pressure.

    `gas`; `room_pressure`, absolute [Pa]; `room_temperature` [K].
    """

    mass_flow: Batch = positive_field("mass_flow", Range("kg/s", 1e-12, 1e-8, 1.0, 1e3))
    gas: Gas = component_field("gas", (Gas,), default=AIR)
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        return self.gas.density(pressure + self.room_pressure, self.room_temperature) * volume

    def flow(self, pressure: Numbers) -> Batch:
        return self.mass_flow + 0.0 * pressure


class OilValves(AbstractValves):
    """Valve for liquid at a `flow_rate`, $Q$ [m³/s], that does not depend on the pressure."""

    flow_rate: Batch = positive_field("flow_rate", Range("m³/s", 1e-12, 1e-9, 1.0, 1e3))

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Volume of liquid [m³]: the muscles' `volume` [m³], at any `pressure` [Pa]."""
        return volume + 0.0 * pressure

    def flow(self, pressure: Numbers) -> Batch:
        return self.flow_rate + 0.0 * pressure


class PlantValves(AbstractValves):
    """Valve and chamber of one motor unit in a plant: mass of gas or liquid.

    `chamber` and `valve`: the plant's, with the unit's numbers alone; `supply_pressure`: gauge
    [Pa], and `supply_temperature` [K], at the start of a run.
    """

    chamber: AbstractChamber
    valve: SonicValve | Orifice
    supply_pressure: Batch
    supply_temperature: Batch

    @classmethod
    def of(cls, plant: Plant) -> tuple["PlantValves", ...]:
        """Valves of each motor unit of a `plant`, in its order."""
        n, pressure = plant.units, plant.supply_pressure
        temperature = float(plant.supply.temperature_at(plant.supply.initial_state()))
        chambers = (_select_units(plant.chamber, i, n) for i in range(n))
        valves = (_select_units(plant.valve, i, n) for i in range(n))
        return tuple(cls(*x, pressure, temperature) for x in zip(chambers, valves, strict=True))

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        return self.chamber.state_at(pressure, volume)[..., 0]

    def flow(self, pressure: Numbers) -> Batch:
        room, temperature = self.chamber.room_pressure, self.chamber.room_temperature
        top = self.supply_pressure + room
        return self.valve.flow(top, pressure + room, self.supply_temperature, temperature)


Valves = Plant | AbstractValves | Sequence[AbstractValves]


def valves_of_units(
    valves: Plant | AbstractValves | Sequence[AbstractValves], units: int
) -> tuple[AbstractValves, ...]:
    """Valves of each of so many `units`; `valves`: a plant, one for all units, or a list."""
    per_unit: Any = PlantValves.of(valves) if isinstance(valves, Plant) else valves
    if not isinstance(per_unit, Sequence):
        per_unit = (per_unit,) * units
    for valve in per_unit:
        if not isinstance(valve, AbstractValves):
            rule = "must be GasValves, OilValves, a Plant, or a list of one for each unit"
            raise InvalidInputError("valves", rule, valve, shown=type(valve).__name__)
    if len(per_unit) != units:
        rule = f"must be one for each of the {units} motor units"
        raise InvalidInputError("valves", rule, len(per_unit))
    return tuple(per_unit)


def _select_units(component: Module, index: int | slice, units: int) -> PyTree:
    """Copy of a `component` of a plant with so many `units`, with those of an `index` alone."""
    return jax.tree.map(
        lambda x: np.asarray(x)[..., index] if np.shape(x)[-1:] == (units,) else x, component
    )


class ControlledUnits(Module):
    """Model of one bundle's motor units in a controller, on the last axis: `branches` from forces
    to pressures, (K1); `counts` of muscles [-]; `chamber`, `valve`, `exhaust_valve`: the plant's,
    of these units; `supply_temperature` [K].
    """

    branches: Branches
    counts: Numbers
    chamber: AbstractChamber
    valve: Any
    exhaust_valve: Any
    supply_temperature: Batch

    @classmethod
    def from_plant(cls, plant: Plant, side: int) -> "ControlledUnits":
        """Model of the units of the bundle `side` of a `plant`, counted from 0."""
        branches = Branches.of(plant.bundles[side], plant.supply_pressure)
        indices = plant.unit_indices(side)
        parts = (plant.chamber, plant.valve, plant.exhaust_valve)
        chamber, valve, exhaust = (_select_units(part, indices, plant.units) for part in parts)
        temperature = np.float64(plant.supply.temperature_at(plant.supply.initial_state()))
        return cls(branches, plant.counts[indices], chamber, valve, exhaust, temperature)

    @property
    def count(self) -> int:
        """Number of units."""
        return len(self.counts)

    def fluid_mass(self, pressure: Numbers, strain: Numbers) -> Numbers:
        """Mass [kg] in each unit's chamber at a `pressure` [Pa] and `strain` [-]."""
        V = self.counts * self.branches.muscles.at(pressure, strain).volume
        return self.chamber.state_at(pressure, V)[..., 0]

    def valve_flows(self, pressure: Numbers, supply: Numbers) -> tuple[Numbers, Numbers]:
        """Flows into and out of each chamber [kg/s] at a `pressure` [Pa] below the `supply` [Pa],
        valves wide open.
        """
        room, temperature = self.chamber.room_pressure, self.chamber.room_temperature
        p = maximum(pressure, 0.0) + room
        return (
            self.valve.flow(supply + room, p, self.supply_temperature, temperature),
            self.exhaust_valve.flow(p, room, temperature, temperature),
        )


class UnitDemand(NamedTuple):
    """Demand on a bundle in one step of a controller.

    `force` [N] and its `rate` [N/s]; `strains` of the units [-] and their `pressures` [Pa], which
    follow the `supply`'s [Pa] after a `lag` [s]; `correction`: time in which the controller sees
    and corrects what its model gets wrong [s]; `dt` since the last demand [s].
    """

    force: Batch
    rate: Batch
    strains: Numbers
    pressures: Numbers
    supply: Batch
    lag: Batch
    correction: Batch
    dt: Batch


class UnitCapability(NamedTuple):
    """Capability of units at their strains: forces, transition, and times of valves.

    Of each unit: pressure at the `top`, and at which it is `parked` once it is recruited [Pa];
    force when `full` and when `empty` [N]; `adds_force`, true if pressure adds force; `onset` [Pa],
    `dip` [N] and `dip_pressure` [Pa]; `largest` force of the state that ends with it [N]. Of its
    valve: `time` up to the onset, `vent` from the onset down [s]; `growth` of its force with its
    valve wide open, on the way to near the supply's pressure [N/s]; `shortfall`: force that is
    missing there, where the valve is slow [N].
    """

    top: Numbers
    parked: Numbers
    full: Numbers
    empty: Numbers
    adds_force: Marks
    onset: Numbers
    dip: Numbers
    dip_pressure: Numbers
    largest: Numbers
    time: Numbers
    vent: Numbers
    growth: Numbers
    shortfall: Numbers


def evaluate_capability(units: ControlledUnits, demand: UnitDemand) -> UnitCapability:
    """Forces and times that `units` are capable of at the strains and pressures of a `demand`."""
    xp, eps, n = array_namespace(demand.strains), demand.strains, units.counts
    zero = 0.0 * eps
    top = minimum(demand.supply, units.branches.top) + zero
    empty, full = n * units.branches.force(zero, eps), n * units.branches.force(top, eps)
    adds_force = full > empty
    full = where(adds_force, full, empty)
    depth, dip_pressure = units.branches.dip(eps)
    onset = units.branches.onset(eps)
    largest = xp.cumsum(full, axis=-1) + xp.sum(empty) - xp.cumsum(empty, axis=-1)
    end = minimum(onset, CLOSE * top)
    flow, _ = units.valve_flows(end, top)
    shortfall = where(adds_force, full - n * units.branches.force(CLOSE * top, eps), 0.0)
    _, out = units.valve_flows(LATE * end, top)
    content = maximum(units.fluid_mass(end, eps) - units.fluid_mass(zero, eps), 0.0)
    # floors against division by zero: a valve without flow fills no unit
    time, vent = content / maximum(flow, 1e-12), content / maximum(out, 1e-12)
    level = minimum(maximum(demand.pressures, 0.0), CHORD * top)
    climb = level + _LEGS[:, None] * (CLOSE * top - level)
    contents = units.fluid_mass(climb, eps)
    flow, _ = units.valve_flows((climb[1:] + climb[:-1]) / 2, demand.supply + zero)
    legs = maximum(contents[1:] - contents[:-1], 0.0) / maximum(flow, 1e-12)
    rise = maximum(full - shortfall - n * units.branches.force(level, eps), 0.0)
    growth = rise / maximum(xp.sum(legs, axis=0), 1e-9)  # s: without a supply it takes no time
    parked, dip = minimum(onset + ABOVE * top, top), (onset, n * depth, dip_pressure)
    times = time, vent, growth, shortfall
    return UnitCapability(top, parked, full, empty, adds_force, *dip, largest, *times)


def share_demand(
    units: ControlledUnits,
    capability: UnitCapability,
    demand: UnitDemand,
    low: Numbers,
    high: Numbers,
    throttled: Numbers | None = None,
) -> Numbers:
    """Pressures [Pa] with which `units` share a demand: one unit after the other is filled from a
    `low` to a `high` pressure [Pa], until they meet the `demand` together.

    `throttled`: present pressures [Pa] of units that have not reached `low`.
    """
    xp, n, branches = array_namespace(demand.strains), units.counts, units.branches
    at_low = n * branches.force(low if throttled is None else throttled, demand.strains)
    at_high = n * branches.force(high, demand.strains)
    at_high = maximum(where(capability.adds_force, at_high, capability.empty), at_low)
    before = xp.cumsum(at_high, axis=-1) - at_high
    after = xp.sum(at_low, axis=-1, keepdims=True) - xp.cumsum(at_low, axis=-1)
    pressures = branches.pressure((demand.force - before - after) / n, demand.strains)
    return minimum(maximum(pressures, low), high)


def select_unit(index: Numbers, values: Numbers) -> Batch:
    """Value of the unit that a one-hot `index` marks; several rows mark several units."""
    return array_namespace(values).sum(index * values, axis=-1)
