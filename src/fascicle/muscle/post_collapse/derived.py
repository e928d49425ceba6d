r"""The default reading of (25): the term that (24) leads to [R10].

**Source:** Kim, Mazzoleni and Bryant (2021), (25).
"""

from typing import ClassVar

from ...core.types import Batch
from ..column import Column
from .post_collapse_law import AbstractPostCollapse, bent_halves


class Derived(AbstractPostCollapse):
    """What (24) leads to: halves whose slope at the hinge is $\\sqrt{x/(L_{fs} - x)}$."""

    name: ClassVar[str] = "derived"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25)"
    slope_factor: ClassVar[float] = 1.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 (L_{fs} + x)/(4 (L_{fs} - x)^3)$ [N], and its slope [N/m]."""
        B, slope = bent_halves(column, compression)
        return B / 4, slope / 4
