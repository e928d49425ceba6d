r"""Pumps for liquids: flow, shaft power and losses.

A pump of displacement $D$ a turn at $N$ turns a second takes in liquid at the room's pressure. Its
flow and shaft power at gauge pressure $P$ are

$$\dot m = \eta_v s D N \rho_0, \qquad
  \dot W = \frac{s D N P}{\eta_m}, \qquad
  \dot W_{lost} = \dot W - \dot m\, h(P) \ge 0, \tag{F20}$$

with $s$ the used fraction of the displacement. A `FixedPump` has $s = 1$, or 0 when it is switched
off, as by a `PressureBand`: on at its low pressure, off at its high one, unchanged between them. A
`VariablePump` swivels back as the pressure comes up to its setting,

$$s = \frac{P_{set} - P}{\Delta P}, \quad 0 \le s \le 1. \tag{F21}$$

The flow of a relief valve is

$$\dot m = k (P - P_{crack})^+, \tag{F22}$$

and all of its power $\dot m\, h(P)$ is lost.

**Assumes** constant efficiencies, which real pumps don't have far from their best point; an idle
pump without pressure takes no power. **Source:** Merritt (1967), Hydraulic Control
Systems.
"""

import abc
from typing import Any, ClassVar

import numpy as np

from ..core.array_namespace import logical_and, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.types import Batch, BatchLike
from ..core.validation import Range, is_concrete
from .fields import component_field, interval_field, nonnegative_field, positive_field
from .media import OIL, Liquid


_DISPLACEMENT = Range("m³", 1e-12, 1e-9, 1e-2, 1.0)  # of a turn: usually 1 mm³ to 10 L
_SPEED = Range("1/s", 1e-3, 0.1, 1e3, 1e5)  # usually up to 60 000 turns a minute
_PRESSURE = Range("Pa", 1.0, 1e3, 1e8, 1e9)  # usually up to 1000 bar


def _efficiency_field(name: str) -> Any:
    """Field of an efficiency in (0, 1], by default without loss."""
    return interval_field(name, 0.0, 1.0, (False, True), "1 is without loss", default=1.0)


class _Pump(Module):
    """Pump at a used fraction of its displacement, equation (F20)."""

    source: ClassVar[str] = "Merritt (1967)"

    displacement: Batch = positive_field("displacement", _DISPLACEMENT)
    speed: Batch = positive_field("speed", _SPEED)

    volumetric_efficiency: ClassVar[Batch]
    mechanical_efficiency: ClassVar[Batch]
    liquid: ClassVar[Liquid]

    @abc.abstractmethod
    def fraction(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Used fraction $s$ of the displacement [-] at gauge `pressure` [Pa]; `on` [-]: 1 of a
        pump that runs, else 0.
        """

    def flow(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Mass flow [kg/s] at gauge `pressure` [Pa]; `on` [-] as of `fraction`."""
        turn = self.fraction(pressure, on) * self.displacement * self.speed
        return turn * self.volumetric_efficiency * self.liquid.reference_density + 0.0 * pressure

    def shaft_power(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Shaft power [W] at gauge `pressure` [Pa]; `on` [-] as of `fraction`."""
        turn = self.fraction(pressure, on) * self.displacement * self.speed
        return turn * pressure / self.mechanical_efficiency

    def lost_power(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Lost power [W] at gauge `pressure` [Pa]; `on` [-] as of `fraction`."""
        useful = self.flow(pressure, on) * self.liquid.flow_energy(pressure)
        return self.shaft_power(pressure, on) - useful


class FixedPump(_Pump):
    """A pump of fixed displacement, equation (F20).

    `displacement`: $D$ of a turn [m³]. `speed`: $N$, turns a second [1/s].
    `volumetric_efficiency`, `mechanical_efficiency`: $\\eta_v$, $\\eta_m$ [-], in (0, 1]. `liquid`.
    """

    volumetric_efficiency: Batch = _efficiency_field("volumetric_efficiency")
    mechanical_efficiency: Batch = _efficiency_field("mechanical_efficiency")
    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)

    def fraction(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Used fraction of the displacement [-], which is `on` [-], at any `pressure` [Pa]."""
        del pressure
        return on


class VariablePump(_Pump):
    """Pump that swivels back as the pressure comes up to its setting: (F20) with (F21).

    `displacement`: $D$ of a turn, at most [m³]. `speed`: $N$, turns a second [1/s]. `pressure`:
    gauge, at which its flow vanishes [Pa]. `band`: $\\Delta P$ [Pa], over which it swivels.
    `volumetric_efficiency`, `mechanical_efficiency`: $\\eta_v$, $\\eta_m$ [-], in (0, 1]. `liquid`.
    """

    pressure: Batch = positive_field("pressure", _PRESSURE)
    band: Batch = positive_field("band", Range("Pa", 1.0, 100.0, 1e7, 1e9))
    volumetric_efficiency: Batch = _efficiency_field("volumetric_efficiency")
    mechanical_efficiency: Batch = _efficiency_field("mechanical_efficiency")
    liquid: Liquid = component_field("liquid", (Liquid,), default=OIL)

    def fraction(self, pressure: BatchLike, on: BatchLike = 1.0) -> Batch:
        """Used fraction $s$ of the displacement [-] at gauge `pressure` [Pa], equation (F21);
        it always runs, `on` [-] doesn't count.
        """
        del on
        return minimum(maximum((self.pressure - pressure) / self.band, 0.0), 1.0)


class PressureBand(Module):
    """A switch between two pressures, with hysteresis. `low`, `high`: gauge [Pa]."""

    source: ClassVar[str] = "a switch"

    low: Batch = nonnegative_field("low", _PRESSURE._replace(least=0.0, low=0.0))
    high: Batch = positive_field("high", _PRESSURE)

    def __check_init__(self):
        if is_concrete(self.low, self.high) and np.any(np.asarray(self.high) <= self.low):
            high = float(np.min(self.high))
            rule = f"must lie above `low`, {float(np.max(self.low)):g} Pa"
            raise InvalidInputError("high", rule, high, "widen the band", f"{high:g} Pa")

    def initial_state(self, pressure: BatchLike) -> Batch:
        """Initial state of the switch [-]: 1 at a gauge `pressure` [Pa] below `high`, else 0."""
        return where(pressure < self.high, 1.0, 0.0)

    def update(self, on: BatchLike, pressure: BatchLike) -> Batch:
        """State of the switch [-], 1 or 0, at gauge `pressure` [Pa] after the state `on` [-]."""
        unchanged = where(logical_and(pressure > self.low, pressure < self.high), on, 1.0)
        return where(pressure >= self.high, 0.0, unchanged)


class Relief(Module):
    """A relief valve, equation (F22).

    `crack`: gauge pressure at which it opens [Pa]. `slope`: $k$ [kg/(s·Pa)].
    """

    source: ClassVar[str] = "Merritt (1967)"

    crack: Batch = positive_field("crack", _PRESSURE)
    slope: Batch = positive_field("slope", Range("kg/(s·Pa)", 1e-15, 1e-11, 1e-2, 1e3))

    def flow(self, pressure: BatchLike) -> Batch:
        """Mass flow through the valve [kg/s] at gauge `pressure` [Pa], equation (F22)."""
        return self.slope * maximum(pressure - self.crack, 0.0)

    def lost_power(self, pressure: BatchLike, liquid: Liquid = OIL) -> Batch:
        """Power lost by a `liquid` [W] at gauge `pressure` [Pa]."""
        return self.flow(pressure) * liquid.flow_energy(pressure)
