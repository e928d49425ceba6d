"""The default ends: all of the muscle contracts, and nothing gives."""

from typing import ClassVar

from ...core.types import Batch, BatchLike
from ..tension.tension_law import Pull
from .ends_law import AbstractEnds, Tension


class Rigid(AbstractEnds):
    """Ends that take no length and don't give: the bladder's strain is the muscle's."""

    name: ClassVar[str] = "rigid"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021)"
    gives: ClassVar[bool] = False

    @property
    def compliance(self) -> Batch:
        """None [m/N]."""
        return 0.0

    def stretch(self, length: BatchLike) -> Batch:
        """1 [-] at any `length` [m]."""
        del length
        return 1.0

    def pull(self, tension: Tension, pressure: BatchLike, strain: BatchLike) -> Pull:
        """The `tension` law [-] itself [N] at `pressure` [Pa] and `strain` [-]."""
        return tension.bladder_pull(pressure, strain)

    def coenergy_at_rest(self, tension: Tension, pressure: BatchLike) -> Batch:
        """None [J] at any `pressure` [Pa]."""
        del tension
        return 0.0 * pressure
