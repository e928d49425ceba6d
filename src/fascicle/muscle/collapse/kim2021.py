r"""The default collapse moment: (17) as printed, which made the paper's figures [R8].

**Source:** Kim, Mazzoleni and Bryant (2021), (17).
"""

from typing import ClassVar

from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .collapse_law import FACTOR, AbstractCollapse, tube_moment


class Kim2021Collapse(AbstractCollapse):
    """Equation (17) as printed: pressure counts with $r_0/t_0$."""

    name: ClassVar[str] = "kim2021"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (17)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], (17)."""
        return self.factor * tube_moment(bladder, youngs_modulus, pressure, power=1)
