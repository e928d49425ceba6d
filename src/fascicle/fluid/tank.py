r"""A tank of gas that empties.

It is a chamber whose volume stays, with that chamber's wall and room:

$$\dot s = f(s, P, \dot m_{in}, \dot H_{in}, \dot V = 0), \qquad g(s, P, V) = 0. \tag{F17}$$

**Source:** the chamber's.
"""

from typing import ClassVar

from ..core.types import Batch, BatchLike, BoolBatch, Numbers
from ..core.validation import Range
from .adiabatic_wall import AdiabaticWall
from .entry import above_zero, part
from .isothermal import Isothermal
from .polytropic import Polytropic
from .supply import AbstractSupply, supply_pressure


_NEARLY = 100.0  # Pa


class Tank(AbstractSupply):
    """Gas in a volume that stays, equation (F17).

    `chamber`: of gas, with the tank's wall and room [-]. `volume` [m³]. `pressure`: gauge, that it
    begins with, as warm as the room [Pa].
    """

    source: ClassVar[str] = "the chamber's"

    chamber: AdiabaticWall | Isothermal | Polytropic = part(
        "chamber", (AdiabaticWall, Isothermal, Polytropic)
    )
    volume: Batch = above_zero("volume", Range("m³", 1e-9, 1e-6, 10.0, 1e6))
    pressure: Batch = supply_pressure()

    @property
    def names(self) -> tuple[str, ...]:
        """The chamber's [-]."""
        return self.chamber.names

    @property
    def units(self) -> tuple[str, ...]:
        """The chamber's [-]."""
        return self.chamber.units

    def start(self) -> Numbers:
        """The chamber's state [SI] at the pressure that it begins with."""
        return self.chamber.start(self.pressure, self.volume)

    def pressure_at(self, state: Numbers) -> Batch:
        """Gauge pressure [Pa] in a `state` [SI]."""
        return self.chamber.guess(state, self.volume)

    def temperature_at(self, state: Numbers) -> Batch:
        """Temperature [K] in a `state` [SI]."""
        return self.chamber.temperature(state, self.pressure_at(state))

    def rates(self, state: Numbers, mass_in: BatchLike, energy_in: BatchLike) -> Numbers:
        """Equation (F17) [SI] for a `state` [SI] where `mass_in` [kg/s] and `energy_in` [W] flow
        in; drawn from, both are negative.
        """
        return self.chamber.rates(state, self.pressure_at(state), mass_in, energy_in, 0.0)

    def stored(self, state: Numbers) -> Batch:
        """Exergy [J] of a `state` [SI]."""
        return self.chamber.stored(state, self.pressure_at(state))

    def empty(self, state: Numbers) -> BoolBatch:
        """Whether a `state` [SI] has fallen to the room's pressure, which it only nears, within a
        thousandth of an atmosphere: yes or no [-].
        """
        return self.pressure_at(state) <= _NEARLY
