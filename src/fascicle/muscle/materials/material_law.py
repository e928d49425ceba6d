r"""What a bladder's material is: the energy of a stretched wall, and its modulus in bending.

Buckling and collapse use a modulus and a ratio of their own, which may be measured apart from
what the wall stores when it is stretched.
"""

import abc
from typing import ClassVar, NamedTuple

from ...core.types import Batch, BatchLike
from ..law import Declared


class Slopes(NamedTuple):
    """First and second derivatives of an energy density [J/m³] by $p = \\lambda_1^2$ and
    $q = \\lambda_2^2$.
    """

    p: Batch
    q: Batch
    pp: Batch
    pq: Batch
    qq: Batch


class AbstractMaterial(Declared):
    """A wall material: an energy for stretching, a modulus and a ratio for bending."""

    youngs_modulus: ClassVar[Batch]
    poisson_ratio: ClassVar[Batch]

    @abc.abstractmethod
    def energy(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Batch:
        """Energy density $W$ [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""

    @abc.abstractmethod
    def slopes(self, axial_squared: BatchLike, hoop_squared: BatchLike) -> Slopes:
        """Its derivatives [J/m³] at squared stretches $\\lambda_1^2$, $\\lambda_2^2$ [-]."""
