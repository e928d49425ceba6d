r"""Gas by a fitted exponent, between a perfect wall's and none's.

$$p = p_a \left(\frac{m}{V} \frac{R T_a}{p_a}\right)^n. \tag{F15}$$

It fits the pressure of one motion and is no physics: what enters has no temperature of its own,
and a cycle may make work of the room's heat without end. An audit refuses it (`physical` is
`False`).

**Source:** Andersen (1967), The Analysis and Design of Pneumatic Systems.
"""

from typing import ClassVar

from ..core.array_namespace import where
from ..core.roots import guarded
from ..core.types import Batch, BatchLike, Numbers
from .chamber import AbstractMassChamber, Balance, dead_volume, row
from .entry import between, part, room_pressure, temperature
from .media import AIR, Gas


class Polytropic(AbstractMassChamber):
    """Gas by a fitted exponent, equation (F15): no physics, and refused by an audit.

    `exponent`: $n$ [-], in [1, 2]. Other fields as those of `AdiabaticWall` [SI].
    """

    physical: ClassVar[bool] = False
    source: ClassVar[str] = "Andersen (1967)"

    exponent: Batch = between(
        "exponent", 1.0, 2.0, (True, True), "1 is isothermal, 1.4 adiabatic air"
    )
    gas: Gas = part("gas", (Gas,), default=AIR)
    dead_volume: Batch = dead_volume()
    room_pressure: Batch = room_pressure()
    room_temperature: Batch = temperature()

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure of no gas at all [Pa]."""
        return -self.room_pressure

    def start(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³], as warm as (F15) has it there: the
        room at no pressure only.
        """
        ratio = (pressure + self.room_pressure) / self.room_pressure
        rho = self.gas.density(self.room_pressure, self.room_temperature)
        return row(rho * (volume + self.dead_volume) * ratio ** (1 / self.exponent))

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
            value, row(-RT + 0.0 * value), V * slope + 0.0 * value, reduced + 0.0 * value
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

    def stored(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Exergy [J] that the gas of a `state` [SI] at gauge `pressure` [Pa] would have."""
        room, T_a = self.room_pressure, self.room_temperature
        T = self.temperature(state, pressure)
        return self.gas.stored_exergy(state[..., 0], pressure + room, T, room, T_a)
