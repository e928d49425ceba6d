"""Martens and Boblan's law with the numbers published for a Festo DMSP-10-250.

**Source:** Martens and Boblan (2017), DMSP-10-250.
"""

from typing import ClassVar

from ...core.types import Batch
from .martens_law import AbstractMartens, angle_constant, modulus_constant


class Martens2017(AbstractMartens):
    """(MB) for a Festo DMSP-10-250."""

    name: ClassVar[str] = "martens2017"
    title: ClassVar[str] = "Martens-Boblan, DMSP-10-250"
    source: ClassVar[str] = "Martens and Boblan (2017), DMSP-10-250"
    made_for: ClassVar[str] = "a Festo DMSP-10-250"
    made_diameter: ClassVar[float | None] = 10e-3
    made_length: ClassVar[float | None] = 0.25

    modulus_0: Batch = modulus_constant(0, 7.4085e07, 0.25).field()
    modulus_1: Batch = modulus_constant(1, -6.892e08, 0.25).field()
    modulus_2: Batch = modulus_constant(2, 1.837e09, 0.25).field()
    modulus_3: Batch = modulus_constant(3, -8.4879e08, 0.25).field()
    angle_correction: Batch = angle_constant(-0.1).field()
