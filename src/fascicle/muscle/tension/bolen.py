"""Bolen's law with the numbers published for Festo muscles of 10 mm.

**Source:** as (BF)'s.
"""

from typing import ClassVar

from ...core.types import Batch
from .bolen_law import AbstractBolen, bolen_constants


# the last one, the largest strain, is the muscle's own: 0.149 to 0.175 in muscles of 153 to
# 281 mm (Hunt et al. 2017, as that code quotes it)
_OF = bolen_constants(0.5682, 4.254, 0.5597, 0.4895, 0.03068, 0.17)


class Bolen(AbstractBolen):
    """(BF) for Festo muscles of 10 mm."""

    name: ClassVar[str] = "bolen"
    title: ClassVar[str] = "Bolen, 10 mm"
    source: ClassVar[str] = "Bolen, as public code of the Agile and Adaptive Robotics laboratory"
    made_for: ClassVar[str] = "Festo muscles of 10 mm"

    bladder_share: Batch = _OF["bladder_share"].field()
    bladder_rate: Batch = _OF["bladder_rate"].field()
    pressure_rate: Batch = _OF["pressure_rate"].field()
    largest_strain: Batch = _OF["largest_strain"].field()
    force_scale: Batch = _OF["force_scale"].field()
    length_scale: Batch = _OF["length_scale"].field()
    end_length: Batch = _OF["end_length"].field()
