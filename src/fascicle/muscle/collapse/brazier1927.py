r"""Brazier's collapse moment of a tube without pressure, whose section ovalises.

**Source:** Brazier (1927).
"""

from typing import ClassVar

from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .collapse_law import FACTOR, AbstractCollapse, tube_moment


class Brazier1927(AbstractCollapse):
    """An unpressurized tube that ovalises: $0.98731\\, E r_0 t_0^2/\\sqrt{1 - \\nu^2}$."""

    name: ClassVar[str] = "brazier1927"
    source: ClassVar[str] = "Brazier (1927)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], the same at every pressure; 0.98731 is $2\\sqrt2\\pi/9$."""
        return self.factor * tube_moment(bladder, youngs_modulus, 0.0 * pressure, power=1)
