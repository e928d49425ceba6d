r"""Supplies: sources of fluid at a pressure, one of constant pressure, and a tank that empties.

A supply has a state, its numbers on the last axis, and a gauge pressure and a temperature that
follow from it. A kilogram of gas at $p_s$, as warm as the room, has the exergy
$R T_a \ln(p_s/p_a)$ (`Gas.flow_exergy`), one of liquid the energy $h(P_s)$ (`Liquid.flow_energy`).

A tank is a chamber of constant volume, with that chamber's wall and room:

$$\dot s = f(s, P, \dot m_{in}, \dot H_{in}, \dot V = 0), \qquad g(s, P, V) = 0. \tag{F17}$$
"""

import abc
from typing import Any, ClassVar

import numpy as np

from ..core.module import Module
from ..core.types import Batch, BoolBatch, Numbers
from ..core.validation import Range
from .chamber import AdiabaticWall, Isothermal
from .fields import component_field, positive_field, room_pressure_field, temperature_field


# Pa, a thousandth of an atmosphere: a tank only nears the room's pressure
_EMPTY_PRESSURE = 100.0


class AbstractSupply(Module):
    """Supply of fluid with a state: `names`, `units` and `count` of its variables."""

    names: ClassVar[tuple[str, ...]]
    units: ClassVar[tuple[str, ...]]

    @property
    def count(self) -> int:
        """Number of state variables."""
        return len(self.names)

    @abc.abstractmethod
    def initial_state(self) -> Numbers:
        """Initial state [SI]."""

    @abc.abstractmethod
    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] in a `state` [SI]."""

    @abc.abstractmethod
    def temperature_at(self, state: Numbers) -> Batch:
        """Temperature [K] in a `state` [SI]."""

    @abc.abstractmethod
    def rates(self, state: Numbers, mass_in: Batch, energy_in: Batch) -> Numbers:
        """Rates of a `state` [SI] with an inflow `mass_in` [kg/s] and its enthalpy `energy_in`
        [W], both negative for an outflow.
        """

    def update_switch(self, state: Numbers) -> Numbers:
        """State [SI] after a `state` [SI] whose pressure switches a pump, if there is one."""
        return state

    def drive_energies(self, state: Numbers) -> dict[str, Batch]:
        """Work of a pump's shaft and losses [J] from the start to a `state` [SI], by name."""
        return {}

    @abc.abstractmethod
    def stored_energy(self, state: Numbers) -> Batch:
        """Stored energy [J] of a `state` [SI]: exergy of a gas, energy of a liquid."""

    @abc.abstractmethod
    def empty(self, state: Numbers) -> BoolBatch:
        """True where the supply is empty in a `state` [SI]."""


def supply_pressure_field() -> Any:
    """Field of a supply's gauge pressure [Pa], above the room's."""
    limits = Range("Pa", 1.0, 1e3, 1e8, 1e9)  # usually up to 1000 bar
    return positive_field("pressure", limits, "raise it above the room's, which is 0 Pa gauge")


class ConstantSupply(AbstractSupply):
    """A supply of constant pressure.

    `pressure`: gauge [Pa], above the room's. `supply_temperature` [K]; `room_pressure`, absolute
    [Pa].
    """

    source: ClassVar[str] = "a boundary condition"
    names: ClassVar[tuple[str, ...]] = ()
    units: ClassVar[tuple[str, ...]] = ()

    pressure: Batch = supply_pressure_field()
    supply_temperature: Batch = temperature_field("supply_temperature")
    room_pressure: Batch = room_pressure_field()

    def initial_state(self) -> Numbers:
        return np.zeros((*np.shape(self.pressure), 0))

    def pressure_at(self, state: Numbers) -> Batch:
        return self.pressure

    def temperature_at(self, state: Numbers) -> Batch:
        return self.supply_temperature

    def rates(self, state: Numbers, mass_in: Batch, energy_in: Batch) -> Numbers:
        return 0.0 * state

    def stored_energy(self, state: Numbers) -> Batch:
        return 0.0 * self.pressure

    def empty(self, state: Numbers) -> BoolBatch:
        return self.pressure <= 0


class Tank(AbstractSupply):
    """Tank of gas whose pressure falls, without a regulator, equation (F17).

    `chamber`: of gas, with the tank's wall and room. `volume` [m³]. `pressure`: initial, gauge, as
    warm as the room [Pa].
    """

    source: ClassVar[str] = "the chamber's"

    chamber: AdiabaticWall | Isothermal = component_field("chamber", (AdiabaticWall, Isothermal))
    volume: Batch = positive_field("volume", Range("m³", 1e-9, 1e-6, 10.0, 1e6))
    pressure: Batch = supply_pressure_field()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the chamber's state variables."""
        return self.chamber.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the chamber's state variables."""
        return self.chamber.units

    def initial_state(self) -> Numbers:
        return self.chamber.state_at(self.pressure, self.volume)

    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] in a `state` [SI]."""
        return self.chamber.static_pressure(state, self.volume)

    def temperature_at(self, state: Numbers) -> Batch:
        return self.chamber.temperature(state, self.pressure_at(state))

    def rates(self, state: Numbers, mass_in: Batch, energy_in: Batch) -> Numbers:
        """Rates, equation (F17) [SI], of a `state` [SI] with inflows [kg/s] and [W]."""
        return self.chamber.rates(state, self.pressure_at(state), mass_in, energy_in, 0.0)

    def stored_energy(self, state: Numbers) -> Batch:
        return self.chamber.stored_energy(state, self.pressure_at(state))

    def empty(self, state: Numbers) -> BoolBatch:
        return self.pressure_at(state) <= _EMPTY_PRESSURE
