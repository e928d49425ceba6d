"""Sárosi's law with the numbers published for a Festo DMSP-10.

**Source:** Sárosi (2012), 10 mm.
"""

from typing import ClassVar

from ...core.types import Batch
from .sarosi_law import AbstractSarosi, sarosi_constant


class Sarosi10(AbstractSarosi):
    """(S) for a Festo DMSP-10."""

    name: ClassVar[str] = "sarosi_10"
    title: ClassVar[str] = "Sárosi, DMSP-10"
    source: ClassVar[str] = "Sárosi (2012), 10 mm"
    made_for: ClassVar[str] = "a Festo DMSP-10"
    made_diameter: ClassVar[float | None] = 10e-3

    exponential_slope: Batch = sarosi_constant("exponential_slope", -9.2194029).field()
    exponential_force: Batch = sarosi_constant("exponential_force", 203.7012413).field()
    exponent: Batch = sarosi_constant("exponent", -0.34221042).field()
    strain_slope: Batch = sarosi_constant("strain_slope", -3.2255991).field()
    pressure_slope: Batch = sarosi_constant("pressure_slope", 109.2038216).field()
    force_offset: Batch = sarosi_constant("force_offset", -208.372034).field()
