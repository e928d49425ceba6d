r"""Gas as warm as the room: the wall takes whatever heat keeps it so.

$$p V = m R T_a. \tag{F14}$$

**Assumes** an ideal gas and motion slower than its heat leaves. **Source:** the first law.
"""

from typing import ClassVar

from ..core.types import Batch, BatchLike, Numbers
from .chamber import AbstractMassChamber, Balance, dead_volume, row
from .entry import part, room_pressure, temperature
from .media import AIR, Gas


class Isothermal(AbstractMassChamber):
    """Gas as warm as the room, equation (F14). Fields as those of `AdiabaticWall` [SI]."""

    physical: ClassVar[bool] = True
    source: ClassVar[str] = "ideal gas at one temperature"

    gas: Gas = part("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume()
    room_pressure: Batch = room_pressure()
    room_temperature: Batch = temperature()

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure of no gas at all [Pa]."""
        return -self.room_pressure

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³]."""
        rho = self.gas.density(pressure + self.room_pressure, self.room_temperature)
        return row(rho * (volume + self.dead_volume))

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
        return Balance(value, row(-RT + 0.0 * value), V + 0.0 * value, p + 0.0 * value)

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
        """What the wall must take so that $U = m c_v T_a$ stays.

        **Arguments:** those of `rates`.

        **Returns:** heat flow [W].
        """
        work = (pressure + self.room_pressure) * volume_rate
        kept = self.gas.c_v * self.room_temperature * mass_in
        return energy_in - work - kept + 0.0 * state[..., 0]

    def stored(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Exergy [J] of a `state` [SI] at gauge `pressure` [Pa]."""
        room, T_a = self.room_pressure, self.room_temperature
        T = self.temperature(state, pressure)
        return self.gas.stored_exergy(state[..., 0], pressure + room, T, room, T_a)
