"""What changes in time, as one row of numbers, and the account of where energy went.

An integrator adds rows. `Layout` knows which of their numbers is what.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..core.arrays import library
from ..core.types import Batch, Numbers
from .plant import Plant


class State(NamedTuple):
    """Where a plant is.

    `position` [m or rad], `velocity` [m/s or rad/s]; `spool`: of its valves [-]; `chambers`: state
    of each unit's [SI], on the last axis; `pressures`: about the units' [Pa], from which a search
    for them begins; `supply`: its state [SI]; `account`: of energies so far [J] and mass [kg],
    named in `ACCOUNT`.
    """

    position: Batch
    velocity: Batch
    spool: Numbers
    chambers: Numbers
    pressures: Numbers
    supply: Numbers
    account: Numbers


# each is an integral of its own power; none is what the others leave
ACCOUNT = (
    "supplied",  # exergy of the gas that was drawn, energy of the liquid [J]
    "valve",  # lost in throttling, on the way in and out [J]
    "exhaust",  # what is left in a gas that leaves: its temperature [J]
    "mixing",  # of gases of unlike temperature in a chamber [J]
    "wall",  # of heat that leaves at a temperature above or below the room's [J]
    "fluid_work",  # ∫ P dV of the fluid on the muscles [J]
    "mismatch",  # of it what a volume that isn't the conjugate one makes [J]
    "mass",  # of fluid that flowed into the chambers [kg]
    "enthalpy",  # that it brought along, less what was taken out [J]
    "heat",  # through the walls [J]
    "displaced",  # ∫ p dV, absolute [J]
    "pull",  # ∫ F dx of the muscles on the load [J]
    "damper",  # lost in the load's damper [J]
    "stop",  # lost in its stop's [J]
    "friction",  # lost in the muscles' [J]
    "motor",  # work of a motion that is given [J]
)


class Layout(NamedTuple):
    """Which numbers of a row are what: how many `units`, numbers of a chamber, of spools, of the
    supply [-].
    """

    units: int
    chamber: int
    spool: int
    supply: int

    @classmethod
    def of(cls, plant: Plant) -> "Layout":
        """That of a `plant` [-]."""
        spool = plant.spool.states(plant.units)
        return cls(plant.units, plant.chamber.count, spool, plant.supply.count)

    def joined(self, state: State) -> Numbers:
        """A `state` [SI] as a row."""
        at_work = library(*state)
        parts = (
            state.position[..., None],
            state.velocity[..., None],
            state.spool,
            state.chambers.reshape((*np.shape(state.chambers)[:-2], -1)),
            state.pressures,
            state.supply,
            state.account,
        )
        return at_work.concatenate(parts, axis=-1)

    def apart(self, row: Numbers) -> State:
        """A `row` [SI] as a state."""
        sizes = (self.spool, self.units * self.chamber, self.units, self.supply, len(ACCOUNT))
        ends = 2 + np.cumsum([0, *sizes])
        spool, chambers, pressures, supply, account = (row[..., a:b] for a, b in pairwise(ends))
        chambers = chambers.reshape((*np.shape(row)[:-1], self.units, self.chamber))
        return State(row[..., 0], row[..., 1], spool, chambers, pressures, supply, account)
