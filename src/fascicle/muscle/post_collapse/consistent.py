r"""A reading of (25) whose halves are inextensible, as (10) has it [R10].

**Source:** Kim, Mazzoleni and Bryant (2021), (25).
"""

from typing import ClassVar

from ...core.types import Batch
from ..column import Column
from .post_collapse_law import AbstractPostCollapse, bent_halves


class Consistent(AbstractPostCollapse):
    """Inextensible halves, as (10) has it: a slope of $2\\sqrt{x/(L_{fs} - x)}$ at the hinge."""

    name: ClassVar[str] = "consistent"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25)"
    slope_factor: ClassVar[float] = 2.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 (L_{fs} + x)/(L_{fs} - x)^3$ [N], and its slope [N/m]."""
        return bent_halves(column, compression)
