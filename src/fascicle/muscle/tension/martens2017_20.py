"""Martens and Boblan's law with the numbers published for a Festo DMSP-20-300.

**Source:** Martens and Boblan (2017), DMSP-20-300.
"""

from typing import ClassVar

from ...core.types import Batch
from .martens_law import AbstractMartens, angle_constant, modulus_constant


class Martens201720(AbstractMartens):
    """(MB) for a Festo DMSP-20-300."""

    name: ClassVar[str] = "martens2017_20"
    title: ClassVar[str] = "Martens-Boblan, DMSP-20-300"
    source: ClassVar[str] = "Martens and Boblan (2017), DMSP-20-300"
    made_for: ClassVar[str] = "a Festo DMSP-20-300"
    made_diameter: ClassVar[float | None] = 20e-3
    made_length: ClassVar[float | None] = 0.3

    modulus_0: Batch = modulus_constant(0, 9.3232e07, 0.3).field()
    modulus_1: Batch = modulus_constant(1, -7.1529e08, 0.3).field()
    modulus_2: Batch = modulus_constant(2, 1.5483e09, 0.3).field()
    modulus_3: Batch = modulus_constant(3, -5.0295e08, 0.3).field()
    angle_correction: Batch = angle_constant(-0.073).field()
