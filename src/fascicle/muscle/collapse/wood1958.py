r"""Wood's collapse moment of a pressurized tube: (17) with the cube of $r_0/t_0$ [R8].

**Source:** Wood (1958), whom (17) cites.
"""

from typing import ClassVar

from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .collapse_law import FACTOR, AbstractCollapse, tube_moment


class Wood1958(AbstractCollapse):
    """Wood's moment: pressure counts with $(r_0/t_0)^3$."""

    name: ClassVar[str] = "wood1958"
    source: ClassVar[str] = "Wood (1958)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], (17) with the cube."""
        return self.factor * tube_moment(bladder, youngs_modulus, pressure, power=3)
