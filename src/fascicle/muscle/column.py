"""A muscle as a column: what laws past the free strain take.

A law past the free strain sees a muscle at one pressure as a column of bending stiffness
$EI$ and axial stiffness $EA$ between clamped ends, whose tension law goes on as compression.
"""

from typing import Any, NamedTuple

from ..core.types import Batch, BatchLike
from .tension.tension_law import Pull
from .tuning import TunedTension


# of a strain: a kink found in another compilation may differ in its last bits, and what is
# asked for there belongs below it
ROUNDING = 1e-15


class Column(NamedTuple):
    """What a buckling law needs to know of a muscle at a pressure; `branch`: what the law itself
    solves for once, before any strain.
    """

    tension: TunedTension
    pressure: Batch
    free_strain: Batch
    bending_stiffness: Batch
    axial_stiffness: Batch
    branch: Any = None

    @property
    def rest_length(self) -> Batch:
        """Length at rest $L_0$ [m]."""
        return self.tension.bladder.braid.length

    @property
    def free_length(self) -> Batch:
        """Length at free strain $L_{fs}$ [m]."""
        return self.rest_length * (1 - self.free_strain)

    def pull(self, strain: BatchLike) -> Pull:
        """What the tension law says at the column's pressure and a `strain` [-], [N]."""
        return self.tension.pull(self.pressure, strain)


class Centerline(NamedTuple):
    """A muscle's axis as points [m], on the last axis: `z` along, `y` across."""

    z: Batch
    y: Batch
