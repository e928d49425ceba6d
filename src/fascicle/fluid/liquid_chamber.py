r"""Liquid in a volume that moves, with a compliant hose.

$$m = \rho(P) \left(V + c P\right), \tag{F16}$$

where $c$ is the compliance of bladder, hose and fittings, volume over pressure. Its energy,
$m\,e(P) + c P^2/2$, and what flows in at $h(P)$ and out as $P\,\mathrm{d}V$ balance exactly.

**Assumes** one temperature and no vapor: below `lowest_pressure` the liquid boils, and (F16) no
longer holds. **Source:** Merritt (1967), Hydraulic Control Systems.
"""

from typing import ClassVar

from ..core.types import Batch, BatchLike, Numbers
from ..core.validation import Range
from .chamber import AbstractMassChamber, StateResidual, stack_last
from .fields import component_field, nonnegative_field
from .media import OIL, Liquid


_STEPS = 4  # of Newton's method, each squares the error: from P/K of some 1e-3 two would do


class LiquidChamber(AbstractMassChamber):
    """Chamber of liquid with a compliance, equation (F16).

    `liquid`. `compliance`: $c$ [m³/Pa]; left out, zero.
    """

    source: ClassVar[str] = "Merritt (1967)"

    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)
    compliance: Batch = nonnegative_field(
        "compliance", Range("m³/Pa", 0.0, 0.0, 1e-9, 1e-3), default=0.0
    )

    @property
    def lowest_pressure(self) -> Batch:
        """Gauge pressure at which the liquid boils [Pa]."""
        return self.liquid.vapor_pressure - self.room_pressure

    def state_at(self, pressure: BatchLike, volume: BatchLike) -> Numbers:
        """Mass [kg] at gauge `pressure` [Pa] and `volume` [m³]."""
        V = volume + self.dead_volume + self.compliance * pressure
        return stack_last(self.liquid.density(pressure) * V)

    def temperature(self, state: Numbers, pressure: BatchLike = 0.0) -> Batch:
        """Temperature of the room [K], for any `state` [SI] and `pressure` [Pa]."""
        return self.room_temperature + 0.0 * (state[..., 0] + pressure)

    def state_residual(
        self, state: Numbers, pressure: BatchLike, volume: BatchLike
    ) -> StateResidual:
        """Residual $\\rho (V + c P) - m$ and its slopes [SI] for a `state` [SI] at gauge
        `pressure` [Pa] in a `volume` [m³].
        """
        rho, c = self.liquid.density(pressure), self.compliance
        V = volume + self.dead_volume + c * pressure
        value = rho * V - state[..., 0]
        by_pressure = rho * (V / self.liquid.bulk_modulus + c)
        return StateResidual(value, stack_last(-1.0 + 0.0 * value), by_pressure, rho + 0.0 * value)

    def static_pressure(self, state: Numbers, volume: BatchLike) -> Batch:
        """Gauge pressure [Pa] of a `state` [SI] in a `volume` [m³] that doesn't move, by Newton's
        method: exact to rounding where it is above the vapor pressure, not limited to it.
        """
        P = 0.0 * (state[..., 0] + volume)
        for _ in range(_STEPS):
            residual = self.state_residual(state, P, volume)
            P = P - residual.value / residual.by_pressure
        return P

    def heat_flow(
        self, state: Numbers, pressure: Batch, mass_in: Batch, energy_in: Batch, volume_rate: Batch
    ) -> Batch:
        """Zero [W]: a liquid at one temperature is a spring; arguments [SI] as of `rates`."""
        return 0.0 * (state[..., 0] + pressure + mass_in + energy_in + volume_rate)

    def stored_energy(self, state: Numbers, pressure: BatchLike) -> Batch:
        """Energy of liquid and compliance [J] in a `state` [SI] at gauge `pressure` [Pa]."""
        liquid_energy = state[..., 0] * self.liquid.stored_energy(pressure)
        return liquid_energy + self.compliance * pressure**2 / 2
