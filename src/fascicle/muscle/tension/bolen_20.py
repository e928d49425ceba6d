"""Bolen's law with the numbers published for Festo muscles of 20 mm.

**Source:** as (BF)'s.
"""

from typing import ClassVar

from ...core.types import Batch
from .bolen_law import AbstractBolen, bolen_constants


# the last one, the largest strain, is the muscle's own: a quarter, as that code takes it
_OF = bolen_constants(0.2579, 6.477, 1.321, 1.4877, 0.0248, 0.25)


class Bolen20(AbstractBolen):
    """(BF) for Festo muscles of 20 mm."""

    name: ClassVar[str] = "bolen_20"
    title: ClassVar[str] = "Bolen, 20 mm"
    source: ClassVar[str] = "Bolen, as public code of the Agile and Adaptive Robotics laboratory"
    made_for: ClassVar[str] = "Festo muscles of 20 mm"

    bladder_share: Batch = _OF["bladder_share"].field()
    bladder_rate: Batch = _OF["bladder_rate"].field()
    pressure_rate: Batch = _OF["pressure_rate"].field()
    largest_strain: Batch = _OF["largest_strain"].field()
    force_scale: Batch = _OF["force_scale"].field()
    length_scale: Batch = _OF["length_scale"].field()
    end_length: Batch = _OF["end_length"].field()
