"""Bolen's law with the numbers published for Festo muscles of 20 mm.

**Source:** as (BF)'s.
"""

from typing import ClassVar

from ...core.types import Batch
from .bolen_law import AbstractBolen, bolen_constant


class Bolen20(AbstractBolen):
    """(BF) for Festo muscles of 20 mm."""

    name: ClassVar[str] = "bolen_20"
    title: ClassVar[str] = "Bolen, 20 mm"
    source: ClassVar[str] = "Bolen, as public code of the Agile and Adaptive Robotics laboratory"
    made_for: ClassVar[str] = "Festo muscles of 20 mm"
    made_diameter: ClassVar[float | None] = 20e-3

    bladder_share: Batch = bolen_constant("bladder_share", 0.2579).field()
    bladder_rate: Batch = bolen_constant("bladder_rate", 6.477).field()
    pressure_rate: Batch = bolen_constant("pressure_rate", 1.321).field()
    # the muscle's own: a quarter, as that code takes it
    largest_strain: Batch = bolen_constant("largest_strain", 0.25).field()
    force_scale: Batch = bolen_constant("force_scale", 1.4877).field()
    length_scale: Batch = bolen_constant("length_scale", 1 / 0.0248).field()
    end_length: Batch = bolen_constant("end_length", 7.5e-3).field()
