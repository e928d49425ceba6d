"""Sárosi's law with the numbers published for a Festo muscle of 20 mm, 400 mm long.

**Source:** Sárosi (2017), 20 mm, 400 mm long.
"""

from typing import ClassVar

from ...core.types import Batch
from .sarosi_law import AbstractSarosi, sarosi_constant


class Sarosi20Long(AbstractSarosi):
    """(S) for a Festo muscle of 20 mm, 400 mm long."""

    name: ClassVar[str] = "sarosi_20_400"
    title: ClassVar[str] = "Sárosi, DMSP-20-400"
    source: ClassVar[str] = "Sárosi (2017), 20 mm, 400 mm long"
    made_for: ClassVar[str] = "a Festo muscle of 20 mm, 400 mm long"
    made_diameter: ClassVar[float | None] = 20e-3
    made_length: ClassVar[float | None] = 0.4

    exponential_slope: Batch = sarosi_constant("exponential_slope", -4.35573).field()
    exponential_force: Batch = sarosi_constant("exponential_force", 281.2237).field()
    exponent: Batch = sarosi_constant("exponent", -0.32866).field()
    strain_slope: Batch = sarosi_constant("strain_slope", -9.27035).field()
    pressure_slope: Batch = sarosi_constant("pressure_slope", 302.20107).field()
    force_offset: Batch = sarosi_constant("force_offset", -263.69185).field()
