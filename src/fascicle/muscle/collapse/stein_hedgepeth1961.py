r"""The moment at which a pressurized membrane is wrinkled all around.

Its slopes are infinite at $P = 0$, where it is zero: exempt.

**Source:** Stein and Hedgepeth (1961).
"""

from typing import ClassVar

import numpy as np

from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .collapse_law import FACTOR, AbstractCollapse


class SteinHedgepeth1961(AbstractCollapse):
    """A wrinkled membrane without stiffness: $\\pi P r_0^3$, zero at zero pressure."""

    name: ClassVar[str] = "stein_hedgepeth1961"
    source: ClassVar[str] = "Stein and Hedgepeth (1961)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:  # noqa: ARG002 a membrane has no modulus
        """$M_{collapse}$ [N·m], proportional to pressure."""
        return self.factor * np.pi * pressure * bladder.braid.radius**3
