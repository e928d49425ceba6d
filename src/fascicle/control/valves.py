r"""Valves of motor units, and the time to fill a unit to its onset pressure.

The content $m$ of a chamber is a gas's mass or a liquid's volume. At the strain $\varepsilon$,
with the volume $V^*$ that is conjugate to the force,

$$t_c = \frac{m\left(p_{on}, n V^*(p_{on}, \varepsilon)\right)
    - m\left(0, n V^*(0, \varepsilon)\right)}{\dot m}, \qquad
  m = \frac{(p + p_a)\, V}{R T_a} \text{ of a gas},\quad V \text{ of a liquid}. \tag{X4}$$

With the straight braid's $V(\varepsilon)$ in its place a gas would seem to come a quarter to a
third sooner, a liquid at once. `PlantValves` adds hose and compliance of a plant's chamber, and
takes the flow of its valve at the pressure, wide open.

**Assumes** gas as warm as the room: gas that heats up as it is compressed comes sooner.
**Source:** derived here.
"""

import abc
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch, Numbers
from ..core.validation import Range
from ..dynamics import Plant
from ..fluid import AIR, AbstractChamber, Gas
from ..fluid.fields import component_field, positive_field, room_pressure_field, temperature_field


class AbstractValves(Module):
    """Model of one motor unit's filling: content of its chamber, and flow of its valve."""

    @abc.abstractmethod
    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Content [kg or m³] at gauge `pressure` [Pa] in a `volume` [m³] of muscles."""

    @abc.abstractmethod
    def flow(self, pressure: Numbers) -> Batch:
        """Flow through the open valve [kg/s or m³/s] at gauge `pressure` [Pa] of the unit [SI]."""


class GasValves(AbstractValves):
    """Valve for gas at a `mass_flow`, $\\dot m$ [kg/s], that does not depend on the pressure.

    `gas`; `room_pressure`, absolute [Pa]; `room_temperature` [K].
    """

    mass_flow: Batch = positive_field("mass_flow", Range("kg/s", 1e-12, 1e-8, 1.0, 1e3))
    gas: Gas = component_field("gas", (Gas,), default=AIR)
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Mass [kg] at gauge `pressure` [Pa] in a `volume` [m³]."""
        return self.gas.density(pressure + self.room_pressure, self.room_temperature) * volume

    def flow(self, pressure: Numbers) -> Batch:
        """Mass flow `mass_flow` [kg/s] into the unit, at any `pressure` [Pa]."""
        return self.mass_flow + 0.0 * pressure


class OilValves(AbstractValves):
    """Valve for liquid at a `flow_rate`, $Q$ [m³/s], that does not depend on the pressure."""

    flow_rate: Batch = positive_field("flow_rate", Range("m³/s", 1e-12, 1e-9, 1.0, 1e3))

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Volume [m³], at any `pressure` [Pa], of a `volume` [m³] of muscles."""
        return volume + 0.0 * pressure

    def flow(self, pressure: Numbers) -> Batch:
        """Volume flow `flow_rate` [m³/s] into the unit, at any `pressure` [Pa]."""
        return self.flow_rate + 0.0 * pressure


class PlantValves(AbstractValves):
    """Valve and chamber of one motor unit in a plant: mass of gas or liquid.

    `chamber` and `valve`: the plant's, with the unit's numbers alone; `supply_pressure`: gauge
    [Pa], and `supply_temperature` [K], at the start of a run.
    """

    chamber: AbstractChamber
    valve: Any
    supply_pressure: Batch
    supply_temperature: Batch

    @classmethod
    def of(cls, plant: Plant) -> tuple["PlantValves", ...]:
        """Valves of each motor unit of a `plant`, in its order."""
        temperature = float(plant.supply.temperature_at(plant.supply.initial_state()))
        return tuple(
            cls(
                select_units(plant.chamber, i, plant.units),
                select_units(plant.valve, i, plant.units),
                plant.supply_pressure,
                temperature,
            )
            for i in range(plant.units)
        )

    def content(self, pressure: Numbers, volume: Numbers) -> Batch:
        """Mass [kg] at gauge `pressure` [Pa] with a `volume` [m³] in its muscles."""
        return self.chamber.state_at(pressure, volume)[..., 0]

    def flow(self, pressure: Numbers) -> Batch:
        """Mass flow [kg/s] into the unit at gauge `pressure` [Pa], valve wide open."""
        room, temperature = self.chamber.room_pressure, self.chamber.room_temperature
        top = self.supply_pressure + room
        return self.valve.flow(top, pressure + room, self.supply_temperature, temperature)


def valves_of_units(valves: Any, units: int) -> tuple[AbstractValves, ...]:
    """Valves of each of so many `units`; `valves`: a plant, one for all units, or a list."""
    if isinstance(valves, Plant):
        per_unit: tuple[Any, ...] = PlantValves.of(valves)
    elif isinstance(valves, AbstractValves):
        per_unit = (valves,) * units
    else:
        per_unit = tuple(valves) if isinstance(valves, Sequence) else (valves,)
    for valve in per_unit:
        if not isinstance(valve, AbstractValves):
            rule = "must be GasValves, OilValves, a Plant, or a list of one for each unit"
            raise InvalidInputError("valves", rule, valve, shown=type(valve).__name__)
    if len(per_unit) != units:
        rule = f"must be one for each of the {units} motor units"
        raise InvalidInputError("valves", rule, len(per_unit))
    return per_unit


def select_units(component: Module, index: Any, units: int) -> Any:
    """Copy of a plant's `component` with the numbers of the units of an `index` alone; `units`: the
    plant's number of units.
    """
    return jax.tree.map(
        lambda x: np.asarray(x)[..., index] if np.shape(x)[-1:] == (units,) else x, component
    )
