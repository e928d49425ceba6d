"""State of a plant."""

from typing import NamedTuple

from ..core.types import Batch, Numbers


class State(NamedTuple):
    """State of a plant.

    `position` [m or rad], `velocity` [m/s or rad/s]; `spool`: of its valves [-]; `chambers`: state
    of each unit's [SI], on the last axis; `pressures`: the units' [Pa], or about them, where a
    search for them begins; `supply`: its state [SI].
    """

    position: Batch
    velocity: Batch
    spool: Numbers
    chambers: Numbers
    pressures: Numbers
    supply: Numbers
