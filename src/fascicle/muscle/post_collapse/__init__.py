r"""Post-collapse laws: two clamped halves and a hinge that push the ends apart.

After collapse two clamped halves meet at a hinge, $y_c = y_{c,max} (1 - \cos(\pi z/L))$ (22),
whose stiffness $k_r = E I_r/(2\theta_r t_0)$, $I_r = \pi r_0 t_0^3/4$ (23), makes its moment
$M_h = 2\theta_r k_r$ a constant, so that its force is $M_h/\sqrt{x (L_{fs} - x)}$ [R11]:

$$F_c = B(x) + \frac{M_h}{\sqrt{x (L_{fs} - x)}}. \tag{25}$$

The first term, the halves' bending, has the unit of a moment in the text that we read; three
readings $B$ are offered by name [R10]. The muscle goes over to it at the rate $\beta$,

$$F = -F_c + (F(\varepsilon_c) + F_c) e^{-\beta (\varepsilon - \varepsilon_c)}. \tag{26}$$

**Sign:** moments and $F_c$ positive, $F_c$ pushes the ends apart.
**Source:** Kim, Mazzoleni and Bryant (2021), 3.3.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import add_table_axis, cos, minimum, sqrt
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from ..buckling import BucklingColumn, Centerline
from ..law import AbstractLaw, LawRegistry


def hinge_moment(bladder: Bladder, youngs_modulus: BatchLike) -> Batch:
    """Constant moment of the folded wall $M_h = \\pi E r_0 t_0^2/4$ [N·m], (23) [R11]."""
    return np.pi / 4 * youngs_modulus * bladder.braid.radius * bladder.wall_thickness**2


class AbstractPostCollapse(AbstractLaw):
    """A reading of (25): two clamped halves and a hinge that push the ends apart. `slope_factor`:
    $f$ of their slope at the hinge, $f \\sqrt{x/(L_{fs} - x)}$.
    """

    slope_factor: ClassVar[float]

    def bending_force(self, column: BucklingColumn, compression: Batch) -> tuple[Batch, Batch]:
        """Bending force $B$ of both halves [N] at `compression` $x$ [m], and its slope [N/m]; by
        default $EI\\pi^2 f^2 (L_{fs} + x)/(4 (L_{fs} - x)^3)$, as the square of their slope.
        """
        EI, L, x = column.bending_stiffness, column.free_length, compression
        unit = EI * np.pi**2 / (L - x) ** 3 * (self.slope_factor**2 / 4)
        return unit * (L + x), unit * (4 * L + 2 * x) / (L - x)

    def push(
        self, column: BucklingColumn, hinge: BatchLike, compression: Batch
    ) -> tuple[Batch, Batch]:
        """Push $F_c$ [N] at a `compression` $x$ [m], and its slope [N/m]; `hinge`: $M_h$ [N·m]."""
        x, chord = compression, column.free_length - compression
        bending, slope = self.bending_force(column, x)
        fold = hinge / sqrt(x * chord)
        return bending + fold, slope - 0.5 * fold * (1 / x - 1 / chord)

    def deflection(self, column: BucklingColumn, strain: Batch) -> Batch:
        """Deflection of the hinge $y_{c,max}$ [m] at `strain` [-]."""
        # from the slope at the hinge, π y_max/L
        x = (strain - column.free_strain) * column.rest_length
        return self.slope_factor / np.pi * sqrt(x * (column.free_length - x))

    def shape(self, column: BucklingColumn, strain: Batch, points: int) -> Centerline:
        """Centerline [m] of (22), mirrored at the hinge, at `strain` [-]."""
        y_max = self.deflection(column, strain)
        along = np.linspace(0.0, 1.0, points)
        chord = add_table_axis(column.rest_length * (1 - strain) + 0.0 * y_max)
        # below the axis, as (8) is drawn
        y = -add_table_axis(y_max) * (1 - cos(np.pi * minimum(along, 1 - along)))
        return Centerline(z=chord * along, y=y)


class Derived(AbstractPostCollapse):
    """The term that (24) leads to: halves whose slope at the hinge is $\\sqrt{x/(L_{fs} - x)}$."""

    name: ClassVar[str] = "derived"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25), derived from (24)"
    slope_factor: ClassVar[float] = 1.0


class Consistent(AbstractPostCollapse):
    """Inextensible halves, as (10) has it: a slope of $2\\sqrt{x/(L_{fs} - x)}$ at the hinge."""

    name: ClassVar[str] = "consistent"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25), with inextensible halves"
    slope_factor: ClassVar[float] = 2.0


class Printed(AbstractPostCollapse):
    """(25) as in the text that we read, without the right units: for comparison only."""

    name: ClassVar[str] = "printed"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021), (25), as in the text that we read"
    slope_factor: ClassVar[float] = 1.0

    def bending_force(self, column: BucklingColumn, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 L_{fs}/(4 (L_{fs} - x)^2)$, in truth a moment [N·m], counted as a force [N]
        as in the text that we read; and its slope by $x$.
        """
        EI, L, x = column.bending_stiffness, column.free_length, compression
        B = EI * np.pi**2 * L / (4 * (L - x) ** 2)
        return B, 2 * B / (L - x)


POST_COLLAPSE_LAWS = LawRegistry(AbstractPostCollapse, default="derived")
__getattr__, __dir__ = POST_COLLAPSE_LAWS.package_attributes()
