"""Sárosi's law with the numbers published for a Festo DMSP-20-200N.

**Source:** Sárosi (2012), 20 mm, 200 mm long.
"""

from typing import ClassVar

from ...core.types import Batch
from .sarosi_law import AbstractSarosi, sarosi_constant


class Sarosi(AbstractSarosi):
    """(S) for a Festo DMSP-20-200N."""

    name: ClassVar[str] = "sarosi"
    title: ClassVar[str] = "Sárosi, DMSP-20-200"
    source: ClassVar[str] = "Sárosi (2012), 20 mm, 200 mm long"
    made_for: ClassVar[str] = "a Festo DMSP-20-200N"
    made_diameter: ClassVar[float | None] = 20e-3
    made_length: ClassVar[float | None] = 0.2

    exponential_slope: Batch = sarosi_constant("exponential_slope", -4.00180705).field()
    exponential_force: Batch = sarosi_constant("exponential_force", 292.4620246).field()
    exponent: Batch = sarosi_constant("exponent", -0.32930845).field()
    strain_slope: Batch = sarosi_constant("strain_slope", -9.33564098).field()
    pressure_slope: Batch = sarosi_constant("pressure_slope", 294.0538256).field()
    force_offset: Batch = sarosi_constant("force_offset", -280.498151).field()
