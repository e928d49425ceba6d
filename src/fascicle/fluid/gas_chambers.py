r"""Chambers of gas: behind a wall that conducts heat, or as warm as the room.

`AdiabaticWall`: its state is its mass and its internal energy $U = m c_v T$; at an
absolute pressure $p = P + p_a$,

$$\dot m = \dot m_{in}, \qquad \dot U = \dot H_{in} - p \dot V - G (T - T_a), \qquad
  p V = (\gamma - 1) U: \tag{F13}$$

adiabatic where $G = 0$, ever closer to isothermal as $G$ rises (and ever stiffer).

`Isothermal`: the wall takes the heat that keeps the gas as warm as the room,

$$p V = m R T_a. \tag{F14}$$

**Assumes** an ideal gas, mixed at once; (F14) motion slower than its heat leaves. **Source:** the
first law.
"""

from typing import ClassVar

from ..core.array_namespace import where
from ..core.roots import guarded
from ..core.types import Batch, BatchLike, Numbers
from ..core.validation import Range
from .chamber import AbstractChamber, AbstractMassChamber, StateResidual, stack_last
from .fields import component_field, nonnegative_field
from .media import AIR, Gas


class AbstractGasChamber(AbstractChamber):
    """Chamber of gas in a volume that moves. `gas`, and the fields of `AbstractChamber`, by
    keyword.
    """

    gas: Gas = component_field("gas", (Gas,), default=AIR, kw_only=True)

    @property
    def _RT(self) -> Batch:
        """$R T$ at the room's temperature [J/kg]."""
        return self.gas.specific_gas_constant * self.room_temperature

    def _room_mass(self, pressure: BatchLike, volume: BatchLike) -> Batch:
        """Mass [kg] at gauge `pressure` [Pa] and the room's temperature in a `volume` [m³] and the
        dead volume.
        """
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        return rho * (volume + self.dead_volume)

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure at which there is no gas at all [Pa]."""
        return -self.room_pressure

    def stored_energy(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Exergy [J] of a `state` [SI] at gauge `pressure` [Pa]."""
        room, T_a = self.room_pressure, self.room_temperature
        T = self.temperature(state, pressure)
        return self.gas.stored_exergy(state[..., 0], pressure + room, T, room, T_a)


class AdiabaticWall(AbstractGasChamber):
    """Chamber of gas behind a wall that conducts heat, or none by default, equation (F13).

    `conductance`: $G$, of the wall [W/K]; left out, zero.
    """

    names: ClassVar[tuple[str, ...]] = ("mass", "internal_energy")
    units: ClassVar[tuple[str, ...]] = ("kg", "J")
    source: ClassVar[str] = "first law of an ideal gas"

    conductance: Batch = nonnegative_field(
        "conductance", Range("W/K", 0.0, 0.0, 1e3, 1e9), default=0.0
    )

    def state_at(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] and internal energy [J] at gauge `pressure` [Pa] and `volume` [m³]."""
        m = self._room_mass(pressure, volume)
        return stack_last(m, m * self.gas.c_v * self.room_temperature)

    def temperature(self, state: Numbers, pressure: BatchLike = 0.0) -> Batch:
        """Temperature $U/(m c_v)$ of a `state` [K], the room's without any gas; `pressure` [Pa]
        doesn't count.
        """
        m, U = state[..., 0], state[..., 1]
        T = U / (guarded(m > 0, m) * self.gas.c_v)
        return where(m > 0, T, self.room_temperature + 0.0 * pressure)

    def state_residual(
        self, state: Numbers, pressure: BatchLike, volume: BatchLike
    ) -> StateResidual:
        """Residual $p V - (\\gamma - 1) U$ and its slopes [SI] for a `state` [SI] at gauge
        `pressure` [Pa] in a `volume` [m³].
        """
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        ratio = self.gas.heat_capacity_ratio - 1
        value = p * V - ratio * state[..., 1]
        zero = 0.0 * value
        return StateResidual(value, stack_last(zero, -ratio + zero), V + zero, p + zero)

    def static_pressure(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""
        V = volume + self.dead_volume
        return (self.gas.heat_capacity_ratio - 1) * state[..., 1] / V - self.room_pressure

    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        """Rates of mass [kg/s] and internal energy [W] on the last axis, equation (F13); arguments
        [SI] as of `AbstractChamber.rates`.
        """
        work = (pressure + self.room_pressure) * volume_rate
        return stack_last(mass_in, energy_in - work - self.heat_flow(state))

    def per_volume_rate(self, state: Numbers, pressure: BatchLike) -> Numbers:
        """Slope of the rates [SI] of a `state` [SI] at gauge `pressure` [Pa] by the volume's."""
        p = pressure + self.room_pressure + 0.0 * state[..., 0]
        return stack_last(0.0 * p, -p)

    def heat_flow(
        self,
        state: Numbers,
        pressure: BatchLike = 0.0,
        mass_in: BatchLike = 0.0,
        energy_in: BatchLike = 0.0,
        volume_rate: BatchLike = 0.0,
    ) -> Batch:
        """Heat flow $G (T - T_a)$ [W] of a `state` [SI]; other arguments don't count."""
        del pressure, mass_in, energy_in, volume_rate
        return self.conductance * (self.temperature(state) - self.room_temperature)


class Isothermal(AbstractGasChamber, AbstractMassChamber):
    """Chamber of gas as warm as the room, equation (F14)."""

    source: ClassVar[str] = "ideal gas at one temperature"

    def state_at(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³]."""
        return stack_last(self._room_mass(pressure, volume))

    def temperature(self, state: Numbers, pressure: BatchLike = 0.0) -> Batch:
        """Temperature of the room [K], for any `state` [SI] and `pressure` [Pa]."""
        return self.room_temperature + 0.0 * (state[..., 0] + pressure)

    def state_residual(
        self, state: Numbers, pressure: BatchLike, volume: BatchLike
    ) -> StateResidual:
        """Residual $p V - m R T_a$ and its slopes [SI] for a `state` [SI] at gauge `pressure`
        [Pa] in a `volume` [m³].
        """
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        value = p * V - self._RT * state[..., 0]
        zero = 0.0 * value
        return StateResidual(value, stack_last(-self._RT + zero), V + zero, p + zero)

    def static_pressure(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""
        return state[..., 0] * self._RT / (volume + self.dead_volume) - self.room_pressure

    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Heat flow out [W] that keeps $U = m c_v T_a$; arguments [SI] as of `rates`."""
        work = (pressure + self.room_pressure) * volume_rate
        stored = self.gas.c_v * self.room_temperature * mass_in
        return energy_in - work - stored + 0.0 * state[..., 0]
