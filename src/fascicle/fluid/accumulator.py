r"""Accumulators: a liquid that presses on a gas, alone and with a pump that charges it.

With $x = \ln(V_0/(V_0 - V_l))$, of a gas that fills $V_0$ at its precharge $p_0$ and leaves $V_l$
to the liquid, absolute pressure, mass and energy over the empty one's are

$$p = p_0 e^{n x}, \qquad m = \rho(P)\, V_0 (1 - e^{-x}), \tag{F18}$$
$$E = m\, e(P) + p_0 V_0 \frac{e^{(n - 1) x} - 1}{n - 1} - p_a V_0 (1 - e^{-x}), \tag{F19}$$

where the second term of (F19) is $p_0 V_0 x$ for $n = 1$. $n = 1$ is a slow one, $n = \gamma$ a
fast one; the gas is a spring, so that what it takes it gives back.

With a pump,

$$\dot m_{acc} = \dot m_{pump}(P) - \dot m_{drawn}, \tag{F23}$$

the pump driven, and wasting, as (F20) says; its switch is updated after each step. Energies are
integrated beside the mass, so that the work of the shaft is the energy that the bundle gets, the
energy stored, and the losses.

**Valid for** up to 0.99 of $V_0$ taken by the liquid. **Source:** Merritt (1967), Hydraulic Control
Systems.
"""

from typing import ClassVar

import numpy as np

from ..core.array_namespace import absolute, exp, expm1, log, log1p, logical_not, minimum, where
from ..core.errors import InvalidInputError
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch, Numbers
from ..core.validation import Range, is_concrete
from .chamber import stack_last
from .fields import (
    component_field,
    interval_field,
    positive_field,
    room_pressure_field,
    temperature_field,
)
from .media import OIL, Liquid
from .pumps import FixedPump
from .supply import AbstractSupply, supply_pressure_field


_FULL = 0.99  # share of the volume up to which (F18) is valid: the last gas is never a spring
_STEPS = 4  # of Newton's method: from P/K of some 1e-3 two would do


class Accumulator(AbstractSupply):
    """Supply of liquid from an accumulator, equations (F18) and (F19).

    `volume`: $V_0$ of the gas when there is no liquid [m³]. `precharge`: gauge pressure of the gas
    then [Pa]. `pressure`: initial, gauge, above the precharge [Pa]. `exponent`: $n$
    [-], in [1, 2]. `liquid`; `room_pressure`, absolute [Pa], and `room_temperature` [K].
    """

    source: ClassVar[str] = "Merritt (1967)"
    names: ClassVar[tuple[str, ...]] = ("mass",)
    units: ClassVar[tuple[str, ...]] = ("kg",)

    volume: Batch = positive_field("volume", Range("m³", 1e-9, 1e-6, 10.0, 1e6))
    precharge: Batch = positive_field("precharge", Range("Pa", 1.0, 1e3, 1e8, 1e9))
    pressure: Batch = supply_pressure_field()
    exponent: Batch = interval_field(
        "exponent", 1.0, 2.0, (True, True), "1 is isothermal, 1.4 adiabatic nitrogen", default=1.4
    )
    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)
    room_pressure: Batch = room_pressure_field()
    room_temperature: Batch = temperature_field()

    def __check_init__(self):
        if not is_concrete(self.pressure, self.precharge, self.exponent):
            return
        P, P_0 = np.broadcast_arrays(self.pressure, self.precharge)
        if np.any(P <= P_0):
            low = float(P[P <= P_0].flat[0])
            rule = f"must lie above the `precharge` of {float(np.max(P_0)):g} Pa"
            remedy = "below it there is no liquid"
            raise InvalidInputError("pressure", rule, low, remedy, f"{low:g} Pa")
        fill = float(np.max(-expm1(-self._log_volume_ratio(P))))
        if fill > _FULL:
            rule = f"must leave the gas 0.01 of `volume`, got a share of {1 - fill:.3g}"
            raise InvalidInputError("pressure", rule, fill, "raise the `precharge`", shown="")

    def stored_volume(self, pressure: Batch) -> Batch:
        """Volume $V_l$ of liquid [m³] at gauge `pressure` [Pa]; negative below the precharge."""
        return -self.volume * expm1(-self._log_volume_ratio(pressure))

    def initial_state(self) -> Numbers:
        return stack_last(self.liquid.density(self.pressure) * self.stored_volume(self.pressure))

    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI], the mass of liquid; (F18) by Newton's method."""
        m, n, room = state[..., 0], self.exponent, self.room_pressure
        p_0 = self.precharge + room
        fill = minimum(m / (self.liquid.reference_density * self.volume), _FULL)
        P = p_0 * exp(-n * log1p(-fill)) - room  # of an incompressible liquid
        for _ in range(_STEPS):
            rho, V = self.liquid.density(P), self.stored_volume(P)
            slope = rho * (V / self.liquid.bulk_modulus + (self.volume - V) / (n * (P + room)))
            P = P - (rho * V - m) / slope
        return P

    def temperature_at(self, state: Numbers) -> Batch:
        """The room's temperature [K], in every `state` [SI]."""
        return self.room_temperature + 0.0 * state[..., 0]

    def rates(self, state: Numbers, mass_in: Batch, energy_in: Batch) -> Numbers:
        return stack_last(mass_in + 0.0 * state[..., 0])

    def energy(self, pressure: Batch) -> Batch:
        """Energy [J] at gauge `pressure` [Pa] over the empty one's, equation (F19)."""
        x = self._log_volume_ratio(pressure)
        V_l = -self.volume * expm1(-x)
        z = (self.exponent - 1) * x
        # (e^z - 1)/z, whose limit at z = 0, an isothermal gas, is 1
        small = absolute(z) < 1e-4
        s, far = guarded(small, z, 0.0), guarded(logical_not(small), z, 1.0)
        growth = where(small, 1 + s * (1 / 2 + s * (1 / 6 + s / 24)), expm1(far) / far)
        gas = (self.precharge + self.room_pressure) * self.volume * x * growth
        mass = self.liquid.density(pressure) * V_l
        return mass * self.liquid.stored_energy(pressure) + gas - self.room_pressure * V_l

    def stored_energy(self, state: Numbers) -> Batch:
        """Energy [J] of a `state` [SI], the mass of liquid, over the empty one's, (F19)."""
        return self.energy(self.pressure_at(state))

    def empty(self, state: Numbers) -> BoolBatch:
        return state[..., 0] <= 0

    def _log_volume_ratio(self, pressure: Batch) -> Batch:
        """Logarithm $x$ of (F18) [-] at gauge `pressure` [Pa]."""
        p, p_0 = pressure + self.room_pressure, self.precharge + self.room_pressure
        return log(guarded(p > 0, p, p_0) / p_0) / self.exponent


class PumpedAccumulator(AbstractSupply):
    """Supply from an accumulator that a pump fills, equation (F23).

    `accumulator`: with its initial pressure. `pump`: with its switch.
    """

    source: ClassVar[str] = "Merritt (1967)"
    # energies are those since the start
    names: ClassVar[tuple[str, ...]] = ("mass", "pump_on", "shaft_work", "pump_lost")
    units: ClassVar[tuple[str, ...]] = ("kg", "1", "J", "J")

    accumulator: Accumulator = component_field("accumulator", (Accumulator,))
    pump: FixedPump = component_field("pump", (FixedPump,))

    def __check_init__(self):
        pumped, stored = self.pump.liquid, self.accumulator.liquid
        pairs = (
            (pumped.bulk_modulus, stored.bulk_modulus),
            (pumped.reference_density, stored.reference_density),
        )
        if any(is_concrete(a, b) and np.any(np.asarray(a) != np.asarray(b)) for a, b in pairs):
            rule = "must be for the accumulator's liquid"
            raise InvalidInputError("pump", rule, pumped, shown="another")

    def initial_state(self) -> Numbers:
        P = self.accumulator.pressure
        none = 0.0 * P
        mass, on = self.accumulator.initial_state()[..., 0], self.pump.initial_switch(P)
        return stack_last(mass, on + none, none, none)

    def pressure_at(self, state: Numbers) -> Batch:
        return self.accumulator.pressure_at(state)

    def temperature_at(self, state: Numbers) -> Batch:
        return self.accumulator.temperature_at(state)

    def rates(self, state: Numbers, mass_in: Batch, energy_in: Batch) -> Numbers:
        """Rates, equation (F23) [SI], of a `state` [SI] with an inflow [kg/s] from the bundle."""
        P, on, pump = self.pressure_at(state), state[..., 1], self.pump
        shaft, losses = pump.shaft_power(P, on), pump.lost_power(P, on)
        return stack_last(mass_in + pump.flow(P, on), 0.0 * P, shaft, losses)

    def update_switch(self, state: Numbers) -> Numbers:
        on = self.pump.update_switch(state[..., 1], self.pressure_at(state))
        return stack_last(state[..., 0], on, state[..., 2], state[..., 3])

    def stored_energy(self, state: Numbers) -> Batch:
        return self.accumulator.stored_energy(state)

    def drive_energies(self, state: Numbers) -> dict[str, Batch]:
        return {"shaft_work": state[..., 2], "pump_lost": state[..., 3]}

    def empty(self, state: Numbers) -> BoolBatch:
        return self.accumulator.empty(state)
