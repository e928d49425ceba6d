r"""Gas behind a wall that lets heat through.

Its mass and its internal energy $U = m c_v T$ change; at an absolute pressure $p = P + p_a$,

$$\dot m = \dot m_{in}, \qquad \dot U = \dot H_{in} - p \dot V - G (T - T_a), \qquad
  p V = (\gamma - 1) U: \tag{F13}$$

adiabatic where $G = 0$, ever closer to isothermal as $G$ rises (and ever stiffer).

**Assumes** an ideal gas, mixed at once. **Source:** the first law.
"""

from typing import ClassVar

from ..core.array_namespace import where
from ..core.roots import guarded
from ..core.types import Batch, BatchLike, Numbers
from ..core.validation import Range
from .chamber import AbstractChamber, Balance, dead_volume, row
from .entry import from_zero, part, room_pressure, temperature
from .media import AIR, Gas


class AdiabaticWall(AbstractChamber):
    """Gas behind a wall that lets heat through, equation (F13).

    `conductance`: $G$, of the wall [W/K]; left out, none. `gas`, `dead_volume` [m³],
    `room_pressure`, absolute [Pa], and `room_temperature` [K] as everywhere.
    """

    names: ClassVar[tuple[str, ...]] = ("mass", "internal_energy")
    units: ClassVar[tuple[str, ...]] = ("kg", "J")
    physical: ClassVar[bool] = True
    source: ClassVar[str] = "first law of an ideal gas"

    conductance: Batch = from_zero("conductance", Range("W/K", 0.0, 0.0, 1e3, 1e9), default=0.0)
    gas: Gas = part("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume()
    room_pressure: Batch = room_pressure()
    room_temperature: Batch = temperature()

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure of no gas at all [Pa]."""
        return -self.room_pressure

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] and energy [J] at gauge `pressure` [Pa] and `volume` [m³], as warm as the
        room.
        """
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        m = rho * (volume + self.dead_volume)
        return row(m, m * self.gas.c_v * self.room_temperature)

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
            value, row(0.0 * value, -share + 0.0 * value), V + 0.0 * value, p + 0.0 * value
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
        return row(mass_in, energy_in - work - self._through_wall(state))

    def per_volume_rate(self, state: Numbers, pressure: BatchLike) -> Numbers:
        """Slope of the rates [SI] of a `state` [SI] at gauge `pressure` [Pa] by the volume's."""
        p = pressure + self.room_pressure + 0.0 * state[..., 0]
        return row(0.0 * p, -p)

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

    def stored(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Exergy [J] of a `state` [SI] at gauge `pressure` [Pa]."""
        room, T_a = self.room_pressure, self.room_temperature
        T = self.temperature(state, pressure)
        return self.gas.stored_exergy(state[..., 0], pressure + room, T, room, T_a)

    def _through_wall(self, state: Numbers) -> Batch:
        return self.conductance * (self.temperature(state) - self.room_temperature)
