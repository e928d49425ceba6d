r"""Collapse laws: the moment at which the buckled bladder folds for good.

Three of them are one equation with a power $n$ of $r_0/t_0$: 1 in the paper as we read it [R8],
3 after Wood, and without pressure Brazier's, whose section ovalizes,

$$M_{collapse} = \frac{2\sqrt2}{9} \pi E r_0 t_0^2
  \sqrt{\frac{1}{1 - \nu^2} + \frac{4P}{E} \Bigl(\frac{r_0}{t_0}\Bigr)^n}. \tag{17}$$

Stein and Hedgepeth's membrane is wrinkled all around; its slopes are infinite at $P = 0$, where it
is zero: exempt.

**Sign:** moments positive. **Source:** Kim, Mazzoleni and Bryant (2021), 3.2; Wood (1958); Brazier
(1927); Stein and Hedgepeth (1961); a factor on the moment after Wielgosz and Thomas (2002), who
use π/4.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import sqrt
from ...core.parameters import Constant
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from ..law import AbstractLaw, LawRegistry


# no fit moves it: a measured factor is the tuning's `collapse_moment_factor`
FACTOR = Constant(
    # a large one makes a muscle that doesn't collapse
    "factor", "", "number", (1e-6, 0.01, 1e6, 1e9), None, 1.0,
    "factor on the moment", "Wielgosz and Thomas (2002)",
)  # fmt: skip


class AbstractCollapse(AbstractLaw):
    """Law of the collapse moment with a `factor` [-]: by default (17), `power` on $r_0/t_0$."""

    power: ClassVar[int] = 1
    factor: ClassVar[Batch]

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """Collapse moment [N·m] at `youngs_modulus` $E$ [Pa] and `pressure` [Pa]."""
        E, t0, nu = youngs_modulus, bladder.wall_thickness, bladder.material.poisson_ratio
        r0 = bladder.braid.radius
        stiffening = 1 / (1 - nu**2) + 4 * pressure / E * (r0 / t0) ** self.power
        return self.factor * (2 * np.sqrt(2) / 9 * np.pi * E * r0 * t0**2 * sqrt(stiffening))


class Kim2021Collapse(AbstractCollapse):
    """Equation (17) as we read it: pressure counts with $r_0/t_0$."""

    name: ClassVar[str] = "kim2021"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (17)"

    factor: Batch = FACTOR.field()


class Wood1958(AbstractCollapse):
    """Wood's collapse moment: its pressure term grows with $(r_0/t_0)^3$."""

    name: ClassVar[str] = "wood1958"
    source: ClassVar[str] = "Wood (1958)"
    power: ClassVar[int] = 3

    factor: Batch = FACTOR.field()


class Brazier1927(AbstractCollapse):
    """Moment that collapses an unpressurized tube: $0.98731\\, E r_0 t_0^2/\\sqrt{1 - \\nu^2}$."""

    name: ClassVar[str] = "brazier1927"
    source: ClassVar[str] = "Brazier (1927)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """Collapse moment [N·m], equal at every pressure; 0.98731 is $2\\sqrt2\\pi/9$."""
        return super().moment(bladder, youngs_modulus, 0.0 * pressure)


class SteinHedgepeth1961(AbstractCollapse):
    """A wrinkled membrane without stiffness: $\\pi P r_0^3$, zero at zero pressure."""

    name: ClassVar[str] = "stein_hedgepeth1961"
    source: ClassVar[str] = "Stein and Hedgepeth (1961)"

    factor: Batch = FACTOR.field()

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """Collapse moment $\\pi P r_0^3$ [N·m] times `factor`; `youngs_modulus` doesn't count."""
        return self.factor * np.pi * pressure * bladder.braid.radius**3


COLLAPSE_LAWS = LawRegistry(AbstractCollapse, default="kim2021")
__getattr__, __dir__ = COLLAPSE_LAWS.package_attributes()
