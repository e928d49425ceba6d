r"""A pump for liquids with its switch: flow, shaft power and losses.

A pump of displacement $D$ a turn at $N$ turns a second takes in liquid at the room's pressure. Its
flow and shaft power at gauge pressure $P$ are

$$\dot m = \eta_v s D N \rho_0, \qquad
  \dot W = \frac{s D N P}{\eta_m}, \qquad
  \dot W_{lost} = \dot W - \dot m\, h(P) \ge 0, \tag{F20}$$

with $s$ = 1 while it runs and 0 while it is off. It is switched on at a low pressure, off at a high
one, and stays as it is between them.

**Assumes** constant efficiencies, which real pumps don't have far from their best point; an idle
pump without pressure takes no power. **Source:** Merritt (1967), Hydraulic Control
Systems.
"""

from functools import partial
from typing import ClassVar

import numpy as np

from ..core.array_namespace import logical_and, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch
from ..core.validation import Range, is_concrete
from .fields import component_field, interval_field, positive_field
from .media import OIL, Liquid


_DISPLACEMENT = Range("m³", 1e-12, 1e-9, 1e-2, 1.0)  # of a turn: usually 1 mm³ to 10 L
_SPEED = Range("Hz", 1e-3, 0.1, 1e3, 1e5)  # usually up to 60 000 turns a minute
_efficiency_field = partial(
    interval_field, low=0.0, high=1.0, closed=(False, True), remedy="1 is without loss", default=1.0
)


_switch_field = partial(interval_field, low=0.0, high=np.inf, unit="Pa")


class FixedPump(Module):
    """A pump of fixed displacement with its switch, equation (F20); by default it always runs.

    `displacement`: $D$ of a turn [m³]. `speed`: $N$, turns a second [1/s].
    `volumetric_efficiency`, `mechanical_efficiency`: $\\eta_v$, $\\eta_m$ [-], in (0, 1]. `liquid`.
    `switch_on`, `switch_off`: gauge pressures down to which it is off, and up to which it is on
    [Pa].
    """

    source: ClassVar[str] = "Merritt (1967)"

    displacement: Batch = positive_field("displacement", _DISPLACEMENT)
    speed: Batch = positive_field("speed", _SPEED)
    volumetric_efficiency: Batch = _efficiency_field("volumetric_efficiency")
    mechanical_efficiency: Batch = _efficiency_field("mechanical_efficiency")
    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)
    switch_on: Batch = _switch_field("switch_on", closed=(True, False), default=0.0)
    switch_off: Batch = _switch_field("switch_off", closed=(False, True), default=np.inf)

    def __check_init__(self):
        on, off = self.switch_on, self.switch_off
        if is_concrete(on, off) and np.any(np.asarray(off) <= on):
            high, rule = float(np.min(off)), f"must lie above `switch_on`, {float(np.max(on)):g} Pa"
            raise InvalidInputError("switch_off", rule, high, "raise it", f"{high:g} Pa")

    def flow(self, pressure: Batch, on: Batch = 1.0) -> Batch:
        """Mass flow [kg/s] at gauge `pressure` [Pa]; `on` [-]: 1 of a pump that runs, else 0."""
        turn = on * self.displacement * self.speed
        return turn * self.volumetric_efficiency * self.liquid.reference_density + 0.0 * pressure

    def shaft_power(self, pressure: Batch, on: Batch = 1.0) -> Batch:
        """Shaft power [W] at gauge `pressure` [Pa]; `on` [-] as of `flow`."""
        return on * self.displacement * self.speed * pressure / self.mechanical_efficiency

    def lost_power(self, pressure: Batch, on: Batch = 1.0) -> Batch:
        """Lost power [W] at gauge `pressure` [Pa]; `on` [-] as of `flow`."""
        useful = self.flow(pressure, on) * self.liquid.flow_energy(pressure)
        return self.shaft_power(pressure, on) - useful

    def initial_switch(self, pressure: Batch) -> Batch:
        """Initial state of the switch [-]: 1 at a gauge `pressure` [Pa] below `switch_off`."""
        return where(pressure < self.switch_off, 1.0, 0.0)

    def update_switch(self, on: Batch, pressure: Batch) -> Batch:
        """State of the switch [-], 1 or 0, at gauge `pressure` [Pa] after the state `on` [-]."""
        between = logical_and(pressure > self.switch_on, pressure < self.switch_off)
        return where(pressure >= self.switch_off, 0.0, where(between, on, 1.0))
