r"""Chambers: fluid in a volume that moves.

No motion of the wall changes the state at once, whose numbers are on the last axis: mass, and
energy if heat takes its time. The pressure follows from it and the volume by an equation of state,
of which a chamber gives the residual and its slopes in closed form, so that it can be solved
together with a muscle's volume, which depends on the pressure:

$$g(s, P, V(P)) = 0, \qquad
  \frac{\mathrm{d}g}{\mathrm{d}P} = g_P + g_V \frac{\mathrm{d}V}{\mathrm{d}P} > 0. \tag{F12}$$

The residual rises with pressure and with volume. The rates of the state are affine in that of the
volume, so that a volume that moves with the pressure can be brought to the other side.

`AdiabaticWall`: its state is its mass and its internal energy $U = m c_v T$; at an
absolute pressure $p = P + p_a$,

$$\dot m = \dot m_{in}, \qquad \dot U = \dot H_{in} - p \dot V - G (T - T_a), \qquad
  p V = (\gamma - 1) U: \tag{F13}$$

adiabatic where $G = 0$, ever closer to isothermal as $G$ rises (and ever stiffer).

`Isothermal`: the wall takes the heat that keeps the gas as warm as the room,

$$p V = m R T_a. \tag{F14}$$

`LiquidChamber`: with the compliance $c$ of bladder, hose and fittings, volume over pressure,

$$m = \rho(P) \left(V + c P\right). \tag{F16}$$

Its energy, $m\,e(P) + c P^2/2$, and what flows in at $h(P)$ and out as $P\,\mathrm{d}V$ balance
exactly.

**Assumes** an ideal gas, mixed at once; (F14) motion slower than its heat leaves; (F16) one
temperature and no vapor: below `lowest_pressure` the liquid boils. **Source:** the first law;
(F16) Merritt (1967), Hydraulic Control Systems.
"""

import abc
from typing import ClassVar, NamedTuple

from ..core.array_namespace import array_namespace, where
from ..core.module import Module
from ..core.roots import guarded
from ..core.types import Batch, Numbers
from ..core.validation import Range
from .fields import component_field, nonnegative_field, room_pressure_field, temperature_field
from .media import AIR, OIL, Gas, Liquid


_DEAD = Range("m³", 0.0, 0.0, 1e-2, 1e3)  # usual hoses and fittings hold less than 10 L


class StateResidual(NamedTuple):
    """Residual of a chamber's equation of state (F12): its `value`, and its slopes `by_state` (on
    the last axis), `by_pressure` and `by_volume`; in J, or in kg for a liquid [SI].
    """

    value: Batch
    by_state: Numbers
    by_pressure: Batch
    by_volume: Batch


class AbstractChamber(Module):
    """Chamber of fluid in a volume that moves; its fields here are given by keyword.

    - `dead_volume`: of hose and fittings, in addition to the volume of each method [m³].
    - `room_pressure`: absolute [Pa]. `room_temperature`: of room and wall [K].
    - `names`, `units`: of the state variables, and `count`, their number.
    - `gas` of a gas, `liquid` of a liquid.
    """

    names: ClassVar[tuple[str, ...]]
    units: ClassVar[tuple[str, ...]]
    gas: ClassVar[Gas]
    liquid: ClassVar[Liquid]
    newton_steps: ClassVar[int] = 1  # to the pressure: a gas's residual is linear in it

    dead_volume: Batch = nonnegative_field(
        "dead_volume", _DEAD, "leave it out if there is none", default=0.0, kw_only=True
    )
    room_pressure: Batch = room_pressure_field(kw_only=True)
    room_temperature: Batch = temperature_field(kw_only=True)

    @property
    def count(self) -> int:
        """Number of state variables."""
        return len(self.names)

    @property
    @abc.abstractmethod
    def lowest_pressure(self) -> Batch:
        """Gauge pressure [Pa] at which there is no gas, or a liquid boils."""

    @abc.abstractmethod
    def state_at(self, pressure: Batch, volume: Batch) -> Numbers:
        """State [SI] at gauge `pressure` [Pa] and `volume` [m³], as warm as the room."""

    @abc.abstractmethod
    def temperature(self, state: Numbers, pressure: Batch) -> Batch:
        """Temperature [K] of a `state` [SI] at gauge `pressure` [Pa]."""

    @abc.abstractmethod
    def state_residual(self, state: Numbers, pressure: Batch, volume: Batch) -> StateResidual:
        """Residual (F12) [SI] of a `state` [SI] at gauge `pressure` [Pa] in a `volume` [m³]."""

    def static_pressure(self, state: Numbers, volume: Batch) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a fixed `volume` [m³], by Newton's method."""
        P = 0.0 * (state[..., 0] + volume)
        for _ in range(self.newton_steps):
            residual = self.state_residual(state, P, volume)
            P = P - residual.value / residual.by_pressure
        return P

    @abc.abstractmethod
    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        """Rates [SI] of a `state` [SI] at gauge `pressure` [Pa], affine in `volume_rate` [m³/s],
        with an inflow `mass_in` [kg/s] and its enthalpy `energy_in`, a gas's $c_p T$ upstream [W].
        """

    @abc.abstractmethod
    def per_volume_rate(self, state: Numbers, pressure: Batch) -> Numbers:
        """Slope [SI] of a `state`'s rates [SI] at gauge `pressure` [Pa] by the rate of volume."""

    @abc.abstractmethod
    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Heat flow out through the wall [W]; arguments [SI] as of `rates`."""

    @abc.abstractmethod
    def stored_energy(self, state: Numbers, pressure: Batch) -> Batch:
        """Exergy of a gas, energy of a liquid [J] in a `state` [SI] at gauge `pressure` [Pa]."""


class AbstractMassChamber(AbstractChamber):
    """A chamber whose state is the mass in it alone."""

    names: ClassVar[tuple[str, ...]] = ("mass",)
    units: ClassVar[tuple[str, ...]] = ("kg",)

    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        return stack_last(mass_in + 0.0 * state[..., 0])

    def temperature(self, state: Numbers, pressure: Batch = 0.0) -> Batch:
        return self.room_temperature + 0.0 * (state[..., 0] + pressure)

    def per_volume_rate(self, state: Numbers, pressure: Batch) -> Numbers:
        return stack_last(0.0 * (state[..., 0] + pressure))


def stack_last(*numbers: Batch) -> Numbers:
    """Several `numbers` [SI], broadcast, on a new last axis [SI]."""
    xp = array_namespace(*numbers)
    return xp.stack(xp.broadcast_arrays(*numbers), axis=-1)


class AbstractGasChamber(AbstractChamber):
    """Chamber of gas in a volume that moves."""

    gas: Gas = component_field("gas", (Gas,), default=AIR, kw_only=True)

    def _room_mass(self, pressure: Batch, volume: Batch) -> Batch:
        """Mass [kg] at gauge `pressure` [Pa], as warm as the room, in a `volume` [m³] of muscles
        and the dead volume.
        """
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        return rho * (volume + self.dead_volume)

    @property
    def lowest_pressure(self) -> Batch:
        return -self.room_pressure

    def stored_energy(self, state: Numbers, pressure: Batch) -> Batch:
        T, room = self.temperature(state, pressure), self.room_pressure
        exergy = self.gas.stored_exergy
        return exergy(state[..., 0], pressure + room, T, room, self.room_temperature)


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

    def state_at(self, pressure: Batch, volume: Batch) -> Numbers:
        m = self._room_mass(pressure, volume)
        return stack_last(m, m * self.gas.c_v * self.room_temperature)

    def temperature(self, state: Numbers, pressure: Batch = 0.0) -> Batch:
        m, U = state[..., 0], state[..., 1]
        T = U / (guarded(m > 0, m) * self.gas.c_v)
        return where(m > 0, T, self.room_temperature + 0.0 * pressure)

    def state_residual(self, state: Numbers, pressure: Batch, volume: Batch) -> StateResidual:
        """Residual $p V - (\\gamma - 1) U$ [SI] of a `state` [SI]."""
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        ratio = self.gas.heat_capacity_ratio - 1
        value = p * V - ratio * state[..., 1]
        zero = 0.0 * value
        return StateResidual(value, stack_last(zero, -ratio + zero), V + zero, p + zero)

    def rates(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Numbers:
        """Rates of mass [kg/s] and internal energy [W], equation (F13)."""
        work = (pressure + self.room_pressure) * volume_rate
        heat = self.heat_flow(state, pressure, mass_in, energy_in, volume_rate)
        return stack_last(mass_in, energy_in - work - heat)

    def per_volume_rate(self, state: Numbers, pressure: Batch) -> Numbers:
        p = pressure + self.room_pressure + 0.0 * state[..., 0]
        return stack_last(0.0 * p, -p)

    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Heat flow $G (T - T_a)$ [W] of a `state` [SI]."""
        return self.conductance * (self.temperature(state, pressure) - self.room_temperature)


class Isothermal(AbstractMassChamber, AbstractGasChamber):
    """Chamber of gas as warm as the room, equation (F14)."""

    source: ClassVar[str] = "ideal gas at one temperature"

    def state_at(self, pressure: Batch, volume: Batch) -> Numbers:
        return stack_last(self._room_mass(pressure, volume))

    def state_residual(self, state: Numbers, pressure: Batch, volume: Batch) -> StateResidual:
        """Residual $p V - m R T_a$ [SI] of a `state` [SI]."""
        p, V = pressure + self.room_pressure, volume + self.dead_volume
        RT = self.gas.specific_gas_constant * self.room_temperature
        value = p * V - RT * state[..., 0]
        zero = 0.0 * value
        return StateResidual(value, stack_last(-RT + zero), V + zero, p + zero)

    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Heat flow out [W] that keeps $U = m c_v T_a$ of a `state` [SI]."""
        work = (pressure + self.room_pressure) * volume_rate
        stored = self.gas.c_v * self.room_temperature * mass_in
        return energy_in - work - stored + 0.0 * state[..., 0]


class LiquidChamber(AbstractMassChamber):
    """Chamber of liquid with a compliance, equation (F16).

    `liquid`. `compliance`: $c$ [m³/Pa]; left out, zero.
    """

    source: ClassVar[str] = "Merritt (1967)"
    newton_steps: ClassVar[int] = 4  # each squares the error: from P/K of some 1e-3 two would do

    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)
    compliance: Batch = nonnegative_field(
        "compliance", Range("m³/Pa", 0.0, 0.0, 1e-9, 1e-3), default=0.0
    )

    @property
    def lowest_pressure(self) -> Batch:
        return self.liquid.vapor_pressure - self.room_pressure

    def state_at(self, pressure: Batch, volume: Batch) -> Numbers:
        V = volume + self.dead_volume + self.compliance * pressure
        return stack_last(self.liquid.density(pressure) * V)

    def state_residual(self, state: Numbers, pressure: Batch, volume: Batch) -> StateResidual:
        """Residual $\\rho (V + c P) - m$ [SI] of a `state` [SI]."""
        rho, c = self.liquid.density(pressure), self.compliance
        V = volume + self.dead_volume + c * pressure
        value = rho * V - state[..., 0]
        by_pressure = rho * (V / self.liquid.bulk_modulus + c)
        return StateResidual(value, stack_last(-1.0 + 0.0 * value), by_pressure, rho + 0.0 * value)

    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        return 0.0 * (state[..., 0] + pressure + mass_in + energy_in + volume_rate)

    def stored_energy(self, state: Numbers, pressure: Batch) -> Batch:
        """Energy of liquid and compliance [J] in a `state` [SI]."""
        liquid_energy = state[..., 0] * self.liquid.stored_energy(pressure)
        return liquid_energy + self.compliance * pressure**2 / 2
