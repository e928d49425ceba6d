"""A supply whose pressure stays: a compressor and its tank that are large enough.

**Source:** a boundary condition.
"""

from typing import ClassVar

import numpy as np

from ..core.types import Batch, BatchLike, BoolBatch, Numbers, Values
from .entry import ROOM_PRESSURE, gauge_from, room_pressure, temperature
from .supply import AbstractSupply, supply_pressure


class ConstantSupply(AbstractSupply):
    """A supply whose pressure stays, however much is drawn.

    `pressure`: gauge [Pa], above the room's. `supply_temperature` [K]; `room_pressure`, absolute
    [Pa].
    """

    source: ClassVar[str] = "a boundary condition"

    pressure: Batch = supply_pressure()
    supply_temperature: Batch = temperature("supply_temperature")
    room_pressure: Batch = room_pressure()

    @classmethod
    def from_absolute(
        cls, absolute: Values, room_pressure: Values = ROOM_PRESSURE
    ) -> "ConstantSupply":
        """A supply of `absolute` pressure [Pa] in a room of `room_pressure` [Pa, absolute]: the
        supply [-]; `ValueError` where it isn't above the room's.
        """
        return cls(gauge_from(absolute, room_pressure), room_pressure=room_pressure)

    @property
    def names(self) -> tuple[str, ...]:
        """None [-]."""
        return ()

    @property
    def units(self) -> tuple[str, ...]:
        """None [-]."""
        return ()

    def start(self) -> Numbers:
        """No numbers [-]."""
        return np.zeros((*np.shape(self.pressure), 0))

    def pressure_at(self, state: Numbers) -> Batch:
        """Its gauge pressure [Pa], with no `state` [-]."""
        del state
        return self.pressure

    def temperature_at(self, state: Numbers) -> Batch:
        """Its temperature [K], with no `state` [-]."""
        del state
        return self.supply_temperature

    def rates(self, state: Numbers, mass_in: BatchLike, energy_in: BatchLike) -> Numbers:
        """None [-] of no `state` [-], however much `mass_in` [kg/s] and `energy_in` [W]."""
        del mass_in, energy_in
        return 0.0 * state

    def stored(self, state: Numbers) -> Batch:
        """Nothing that is counted [J], in no `state` [-]: what it gives is."""
        del state
        return 0.0 * self.pressure

    def empty(self, state: Numbers) -> BoolBatch:
        """Never [-], in no `state` [-]."""
        del state
        return self.pressure <= 0
