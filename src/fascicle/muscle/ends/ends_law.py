r"""What a law of the ends is: the bladder's strain, where the muscle's own is told by its ends.

A muscle of length $L_0$ between its fittings may have parts that don't contract, and ends that
give. Its tension law is that of the bladder, at the bladder's strain $\varepsilon_b$:

$$F(P, \varepsilon) = T(P, \varepsilon_b(P, \varepsilon)). \tag{E7}$$

**Sign:** pulling force and contraction positive. **Source:** derived here.
"""

import abc
from typing import Any, ClassVar

from ...core.types import Batch, BatchLike
from ..law import AbstractLaw
from ..tension.tension_law import Pull


Tension = Any  # the tuned one, which asks these


class AbstractEnds(AbstractLaw):
    """The ends of a muscle; `gives`: whether the bladder's strain may depend on its force."""

    gives: ClassVar[bool] = True

    @property
    @abc.abstractmethod
    def compliance(self) -> Batch:
        """By how much both ends together give [m/N]."""

    @abc.abstractmethod
    def stretch(self, length: BatchLike) -> Batch:
        """The bladder's strain over the ends' [-] without a force; `length` $L_0$ [m]."""

    @abc.abstractmethod
    def pull(self, tension: Tension, pressure: BatchLike, strain: BatchLike) -> Pull:
        """What the `tension` law [-] says [N] at `pressure` [Pa] and the ends' `strain` [-]."""

    @abc.abstractmethod
    def coenergy_at_rest(self, tension: Tension, pressure: BatchLike) -> Batch:
        """What a muscle at rest length has of co-energy [J] at `pressure` [Pa], besides that of
        its volume at rest: none where the bladder is at rest, too.
        """
