r"""What a collapse law is: the moment at which the buckled bladder folds for good.

Two of them, and the tube without pressure, are one equation with a power $n$,

$$M_{collapse} = \frac{2\sqrt2}{9} \pi E r_0 t_0^2
  \sqrt{\frac{1}{1 - \nu^2} + \frac{4P}{E} \Bigl(\frac{r_0}{t_0}\Bigr)^n}. \tag{17}$$

**Sign:** moments positive. **Source:** Kim, Mazzoleni and Bryant (2021), 3.2; Wood (1958); a
factor on the moment after Wielgosz and Thomas (2002), who use π/4.
"""

import abc
from typing import ClassVar

import numpy as np

from ...core.array_namespace import sqrt
from ...core.parameters import Constant
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from ..law import AbstractLaw


# no fit moves it: what is measured of it is the tuning's `collapse_moment_factor`
FACTOR = Constant(
    # a large one is how to say that a muscle doesn't collapse
    "factor", "", "number", (1e-6, 0.01, 1e6, 1e9), None, 1.0,
    "on the moment", "Wielgosz and Thomas (2002)",
)  # fmt: skip


class AbstractCollapse(AbstractLaw):
    """A moment at which a pressurized tube collapses; `factor` [-] is on top of it."""

    factor: ClassVar[Batch]

    @abc.abstractmethod
    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m] at `youngs_modulus` $E$ [Pa] and `pressure` [Pa]."""


def tube_moment(bladder: Bladder, E: BatchLike, pressure: BatchLike, power: int) -> Batch:
    """Equation (17) [N·m] with `power` on $r_0/t_0$."""
    r0, t0, nu = bladder.braid.radius, bladder.wall_thickness, bladder.material.poisson_ratio
    stiffening = 1 / (1 - nu**2) + 4 * pressure / E * (r0 / t0) ** power
    return 2 * np.sqrt(2) / 9 * np.pi * E * r0 * t0**2 * sqrt(stiffening)
