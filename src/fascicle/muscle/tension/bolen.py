"""Bolen's law with the numbers published for Festo muscles of 10 mm.

**Source:** as (BF)'s.
"""

from typing import ClassVar

from ...core.types import Batch
from .bolen_law import AbstractBolen, bolen_constant


class Bolen(AbstractBolen):
    """(BF) for Festo muscles of 10 mm."""

    name: ClassVar[str] = "bolen"
    title: ClassVar[str] = "Bolen, 10 mm"
    source: ClassVar[str] = "Bolen, as public code of the Agile and Adaptive Robotics laboratory"
    made_for: ClassVar[str] = "Festo muscles of 10 mm"
    made_diameter: ClassVar[float | None] = 10e-3

    bladder_share: Batch = bolen_constant("bladder_share", 0.5682).field()
    bladder_rate: Batch = bolen_constant("bladder_rate", 4.254).field()
    pressure_rate: Batch = bolen_constant("pressure_rate", 0.5597).field()
    # the muscle's own: 0.149 to 0.175 in muscles of 153 to 281 mm (Hunt et al. 2017, in that code)
    largest_strain: Batch = bolen_constant("largest_strain", 0.17).field()
    force_scale: Batch = bolen_constant("force_scale", 0.4895).field()
    length_scale: Batch = bolen_constant("length_scale", 1 / 0.03068).field()
    end_length: Batch = bolen_constant("end_length", 7.5e-3).field()
