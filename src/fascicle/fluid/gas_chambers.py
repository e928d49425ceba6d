r"""Chambers of gas: walls that let heat through or keep the gas as warm as the room, and a fit.

`AdiabaticWall`: its mass and its internal energy $U = m c_v T$ change; at an absolute pressure
$p = P + p_a$,

$$\dot m = \dot m_{in}, \qquad \dot U = \dot H_{in} - p \dot V - G (T - T_a), \qquad
  p V = (\gamma - 1) U: \tag{F13}$$

adiabatic where $G = 0$, ever closer to isothermal as $G$ rises (and ever stiffer).

`Isothermal`: the wall takes the heat that keeps the gas as warm as the room,

$$p V = m R T_a. \tag{F14}$$

`Polytropic`: a fitted exponent,

$$p = p_a \left(\frac{m}{V} \frac{R T_a}{p_a}\right)^n. \tag{F15}$$

It fits the pressure of one motion and is no physics: what enters has no temperature of its own,
and a cycle may make work of the room's heat without end. An audit refuses it (`physical` is
`False`).

**Assumes** an ideal gas, mixed at once; (F14) motion slower than its heat leaves. **Source:** the
first law; (F15) Andersen (1967), The Analysis and Design of Pneumatic Systems.
"""

from typing import ClassVar

from ..core.array_namespace import where
from ..core.roots import guarded
from ..core.types import Batch, BatchLike, Numbers
from ..core.validation import Range
from .chamber import AbstractChamber, AbstractMassChamber, Balance, dead_volume_field, stack_last
from .fields import (
    component_field,
    interval_field,
    nonnegative_field,
    room_pressure_field,
    temperature_field,
)
from .media import AIR, Gas


class AbstractGasChamber(AbstractChamber):
    """Gas in a volume that moves; `gas`, and `room_temperature` [K] of the wall."""

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure of no gas at all [Pa]."""
        return -self.room_pressure

    def stored(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Exergy [J] of a `state` [SI] at gauge `pressure` [Pa]."""
        room, T_a = self.room_pressure, self.room_temperature
        T = self.temperature(state, pressure)
        return self.gas.stored_exergy(state[..., 0], pressure + room, T, room, T_a)


class AdiabaticWall(AbstractGasChamber):
    """Gas behind a wall that lets heat through, equation (F13).

    `conductance`: $G$, of the wall [W/K]; left out, none. `gas`, `dead_volume` [m³],
    `room_pressure`, absolute [Pa], and `room_temperature` [K] as everywhere.
    """

    names: ClassVar[tuple[str, ...]] = ("mass", "internal_energy")
    units: ClassVar[tuple[str, ...]] = ("kg", "J")
    physical: ClassVar[bool] = True
    source: ClassVar[str] = "first law of an ideal gas"

    conductance: Batch = nonnegative_field(
        "conductance", Range("W/K", 0.0, 0.0, 1e3, 1e9), default=0.0
    )
    gas: Gas = component_field("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume_field()
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] and energy [J] at gauge `pressure` [Pa] and `volume` [m³], as warm as the
        room.
        """
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        m = rho * (volume + self.dead_volume)
        return stack_last(m, m * self.gas.c_v * self.room_temperature)

    def temperature(self, state: Numbers, pressure: BatchLike = 0.0) -> Batch:
        """$U/(m c_v)$ of a `state` [K]; `pressure` [Pa] doesn't count. Nothing is as warm as the
        room.
        """
        m, U = state[..., 0], state[..., 1]
        some = m > 0
        T = U / (guarded(some, m) * self.gas.c_v)
        return where(some, T, self.room_temperature + 0.0 * pressure)

    def balance(self, state: Numbers, pressure: BatchLike, volume: BatchLike) -> Balance:
        """$p V - (\\gamma - 1) U$ and its slopes [SI] for a `state` [SI] at gauge `pressure` [Pa]
        in a `volume` [m³].
        """
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        share = self.gas.heat_capacity_ratio - 1
        value = p * V - share * state[..., 1]
        return Balance(
            value, stack_last(0.0 * value, -share + 0.0 * value), V + 0.0 * value, p + 0.0 * value
        )

    def guess(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""
        V = volume + self.dead_volume
        return (self.gas.heat_capacity_ratio - 1) * state[..., 1] / V - self.room_pressure

    def rates(
        self,
        state: Numbers,
        pressure: BatchLike,
        mass_in: BatchLike,
        energy_in: BatchLike,
        volume_rate: BatchLike,
    ) -> Numbers:
        """Equation (F13).

        **Arguments:**

        - `state`: it [SI].
        - `pressure`: that goes with it, gauge [Pa].
        - `mass_in`: mass flow into it [kg/s].
        - `energy_in`: enthalpy that comes along [W].
        - `volume_rate`: of the volume [m³/s].

        **Returns:** rates of mass and energy [kg/s], [W], on the last axis.
        """
        work = (pressure + self.room_pressure) * volume_rate
        return stack_last(mass_in, energy_in - work - self._through_wall(state))

    def per_volume_rate(self, state: Numbers, pressure: BatchLike) -> Numbers:
        """Slope of the rates [SI] of a `state` [SI] at gauge `pressure` [Pa] by the volume's."""
        p = pressure + self.room_pressure + 0.0 * state[..., 0]
        return stack_last(0.0 * p, -p)

    def heat(
        self,
        state: Numbers,
        pressure: BatchLike = 0.0,
        mass_in: BatchLike = 0.0,
        energy_in: BatchLike = 0.0,
        volume_rate: BatchLike = 0.0,
    ) -> Batch:
        """$G (T - T_a)$, which depends on the state alone.

        **Arguments:** those of `rates`.

        **Returns:** heat flow [W].
        """
        del pressure, mass_in, energy_in, volume_rate
        return self._through_wall(state)

    def _through_wall(self, state: Numbers) -> Batch:
        return self.conductance * (self.temperature(state) - self.room_temperature)


class Isothermal(AbstractGasChamber, AbstractMassChamber):
    """Gas as warm as the room, equation (F14). Fields as those of `AdiabaticWall` [SI]."""

    physical: ClassVar[bool] = True
    source: ClassVar[str] = "ideal gas at one temperature"

    gas: Gas = component_field("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume_field()
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³]."""
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        return stack_last(rho * (volume + self.dead_volume))

    def temperature(self, state: Numbers, pressure: BatchLike = 0.0) -> Batch:
        """The room's [K], in any `state` [SI] and at any `pressure` [Pa]."""
        return self.room_temperature + 0.0 * (state[..., 0] + pressure)

    def balance(self, state: Numbers, pressure: BatchLike, volume: BatchLike) -> Balance:
        """$p V - m R T_a$ and its slopes [SI] for a `state` [SI] at gauge `pressure` [Pa] in a
        `volume` [m³].
        """
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        RT = self.gas.specific_gas_constant * self.room_temperature
        value = p * V - RT * state[..., 0]
        return Balance(value, stack_last(-RT + 0.0 * value), V + 0.0 * value, p + 0.0 * value)

    def guess(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""
        RT = self.gas.specific_gas_constant * self.room_temperature
        return state[..., 0] * RT / (volume + self.dead_volume) - self.room_pressure

    def heat(
        self,
        state: Numbers,
        pressure: BatchLike,
        mass_in: BatchLike,
        energy_in: BatchLike,
        volume_rate: BatchLike,
    ) -> Batch:
        """Heat flow through the wall that keeps $U = m c_v T_a$ stays.

        **Arguments:** those of `rates`.

        **Returns:** heat flow [W].
        """
        work = (pressure + self.room_pressure) * volume_rate
        kept = self.gas.c_v * self.room_temperature * mass_in
        return energy_in - work - kept + 0.0 * state[..., 0]


class Polytropic(AbstractGasChamber, AbstractMassChamber):
    """Gas by a fitted exponent, equation (F15): no physics, and refused by an audit.

    `exponent`: $n$ [-], in [1, 2]. Other fields as those of `AdiabaticWall` [SI].
    """

    physical: ClassVar[bool] = False
    source: ClassVar[str] = "Andersen (1967)"

    exponent: Batch = interval_field(
        "exponent", 1.0, 2.0, (True, True), "1 is isothermal, 1.4 adiabatic air"
    )
    gas: Gas = component_field("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume_field()
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³], as warm as (F15) has it there: the
        room at no pressure only.
        """
        ratio = (pressure + self.room_pressure) / self.room_pressure
        rho = self.gas.density(self.room_pressure, self.room_temperature)
        return stack_last(rho * (volume + self.dead_volume) * ratio ** (1 / self.exponent))

    def temperature(self, state: Numbers, pressure: BatchLike) -> Batch:
        """$T_a (p/p_a)^{1 - 1/n}$ [K] of a `state` [SI] at gauge `pressure` [Pa]."""
        p = pressure + self.room_pressure
        ratio = guarded(p > 0, p, self.room_pressure) / self.room_pressure
        return self.room_temperature * ratio ** (1 - 1 / self.exponent) + 0.0 * state[..., 0]

    def balance(self, state: Numbers, pressure: BatchLike, volume: BatchLike) -> Balance:
        """$p_a V (p/p_a)^{1/n} - m R T_a$ and its slopes [SI] for a `state` [SI] at gauge
        `pressure` [Pa] in a `volume` [m³].
        """
        V, p_a, n = volume + self.dead_volume, self.room_pressure, self.exponent
        p = pressure + p_a
        some = p > 0
        ratio = guarded(some, p, p_a) / p_a
        # without gas a straight line goes on, so that a search comes back
        reduced = where(some, p_a * ratio ** (1 / n), p)
        slope = where(some, ratio ** (1 / n - 1) / n, 1.0)
        RT = self.gas.specific_gas_constant * self.room_temperature
        value = reduced * V - RT * state[..., 0]
        return Balance(
            value, stack_last(-RT + 0.0 * value), V * slope + 0.0 * value, reduced + 0.0 * value
        )

    def guess(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move."""
        RT = self.gas.specific_gas_constant * self.room_temperature
        ratio = state[..., 0] * RT / ((volume + self.dead_volume) * self.room_pressure)
        some = ratio > 0
        raised = where(some, guarded(some, ratio) ** self.exponent, 0.0)
        return self.room_pressure * (raised - 1)

    def heat(
        self,
        state: Numbers,
        pressure: BatchLike,
        mass_in: BatchLike,
        energy_in: BatchLike,
        volume_rate: BatchLike,
    ) -> Batch:
        """NaN: a fit knows no heat.

        **Arguments:** those of `rates`.

        **Returns:** heat flow [W].
        """
        return float("nan") * (state[..., 0] + pressure + mass_in + energy_in + volume_rate)
