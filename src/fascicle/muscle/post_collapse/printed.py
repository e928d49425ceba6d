r"""(25) as printed, for comparison only [R10].

**Source:** Kim, Mazzoleni and Bryant (2021), (25).
"""

from typing import ClassVar

import numpy as np

from ...core.types import Batch
from ..column import Column
from .post_collapse_law import AbstractPostCollapse


class Printed(AbstractPostCollapse):
    """(25) as printed: a number without the right units, for comparison only."""

    name: ClassVar[str] = "printed"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25)"
    slope_factor: ClassVar[float] = 1.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 L_{fs}/(4 (L_{fs} - x)^2)$, printed as [N], in truth [N·m]; its slope."""
        EI, L, x = column.bending_stiffness, column.free_length, compression
        B = EI * np.pi**2 * L / (4 * (L - x) ** 2)
        return B, 2 * B / (L - x)
