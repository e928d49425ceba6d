r"""Collapse of the buckled bladder: the moment it takes, and the hinge that remains.

When the largest moment reaches $M_{collapse}$ the tube folds for good. The paper's moment,

$$M_{collapse} = \frac{2\sqrt2}{9} \pi E r_0 t_0^2
  \sqrt{\frac{1}{1 - \nu^2} + \frac{4P}{E} \Bigl(\frac{r_0}{t_0}\Bigr)^n}, \tag{17}$$

stands there with $n = 1$ (`kim2021`, which made its figures); Wood (1958), whom it cites,
has $n = 3$ (`wood1958`) [R8]. Afterwards two clamped halves meet at a hinge,
$y_c = y_{c,max} (1 - \cos(\pi z/L))$ (22), whose stiffness
$k_r = E I_r/(2\theta_r t_0)$, $I_r = \pi r_0 t_0^3/4$ (23), makes its moment
$M_h = 2\theta_r k_r$ a constant, so that its force is $M_h/\sqrt{x (L_{fs} - x)}$ [R11]:

$$F_c = B(x) + \frac{M_h}{\sqrt{x (L_{fs} - x)}}. \tag{25}$$

The first term, the halves' bending, has the units of a moment in print; three readings
$B$ are offered by name [R10]. The muscle goes over to it at the rate $\beta$,

$$F = -F_c + (F(\varepsilon_c) + F_c) e^{-\beta (\varepsilon - \varepsilon_c)}. \tag{26}$$

**Sign:** moments and $F_c$ positive, $F_c$ pushes the ends apart.
**Source:** Kim, Mazzoleni and Bryant (2021), 3.2-3.3; Wood (1958); Brazier (1927); Stein
and Hedgepeth (1961); a factor on the moment after Wielgosz and Thomas (2002), who use π/4.
"""

import abc
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import equinox as eqx
import numpy as np

from .._arrays import cos, minimum, spread, sqrt
from .._limits import size
from .._methods import Module
from .._types import Batch, BatchLike, Values
from .bladder import Bladder
from .column import Centerline, Column


def _factor(value: Values) -> Batch:
    return size(value, "factor")


class AbstractCollapse(Module):
    """A moment at which a pressurized tube collapses; `factor` [-] is on top of it."""

    name: eqx.AbstractClassVar[str]
    factor: eqx.AbstractVar[Batch]

    @abc.abstractmethod
    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m] at `youngs_modulus` $E$ [Pa] and `pressure` [Pa]."""


class Kim2021Collapse(AbstractCollapse):
    """Equation (17) as printed: pressure counts with $r_0/t_0$."""

    name: ClassVar[str] = "kim2021"
    factor: Batch = eqx.field(default=1.0, converter=_factor)

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], (17)."""
        return self.factor * _wood(bladder, youngs_modulus, pressure, power=1)


class Wood1958(AbstractCollapse):
    """Wood's moment: pressure counts with $(r_0/t_0)^3$."""

    name: ClassVar[str] = "wood1958"
    factor: Batch = eqx.field(default=1.0, converter=_factor)

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], (17) with the cube."""
        return self.factor * _wood(bladder, youngs_modulus, pressure, power=3)


class Brazier1927(AbstractCollapse):
    """An unpressurized tube that ovalises: $0.98731\\, E r_0 t_0^2/\\sqrt{1 - \\nu^2}$."""

    name: ClassVar[str] = "brazier1927"
    factor: Batch = eqx.field(default=1.0, converter=_factor)

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """$M_{collapse}$ [N·m], the same at every pressure; 0.98731 is $2\\sqrt2\\pi/9$."""
        return self.factor * _wood(bladder, youngs_modulus, 0.0 * pressure, power=1)


class SteinHedgepeth1961(AbstractCollapse):
    """A wrinkled membrane without stiffness: $\\pi P r_0^3$, zero at zero pressure."""

    name: ClassVar[str] = "stein_hedgepeth1961"
    factor: Batch = eqx.field(default=1.0, converter=_factor)

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:  # noqa: ARG002 a membrane has no modulus
        """$M_{collapse}$ [N·m], proportional to pressure."""
        return self.factor * np.pi * pressure * bladder.braid.radius**3


def _wood(bladder: Bladder, E: BatchLike, pressure: BatchLike, power: int) -> Batch:
    """Equation (17) [N·m] with `power` on $r_0/t_0$."""
    r0, t0, nu = bladder.braid.radius, bladder.wall_thickness, bladder.material.poisson_ratio
    stiffening = 1 / (1 - nu**2) + 4 * pressure / E * (r0 / t0) ** power
    return 2 * np.sqrt(2) / 9 * np.pi * E * r0 * t0**2 * sqrt(stiffening)


def hinge_moment(bladder: Bladder, youngs_modulus: BatchLike) -> Batch:
    """The folded wall's constant moment $M_h = \\pi E r_0 t_0^2/4$ [N·m], (23) [R11]."""
    return np.pi / 4 * youngs_modulus * bladder.braid.radius * bladder.wall_thickness**2


class AbstractPostCollapse(Module):
    """A reading of (25): two clamped halves and a hinge that push the ends apart."""

    name: eqx.AbstractClassVar[str]
    slope_factor: eqx.AbstractClassVar[float]

    @abc.abstractmethod
    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """The halves' bending force $B$ [N] at `compression` $x$ [m], and its slope [N/m]."""

    def force(self, column: Column, hinge: BatchLike, strain: Batch) -> Batch:
        """$F_c$ [N] at a `strain` [-] past the free strain, (25); `hinge` is $M_h$ [N·m]."""
        return self.push(column, hinge, (strain - column.free_strain) * column.rest_length)[0]

    def push(self, column: Column, hinge: BatchLike, compression: Batch) -> tuple[Batch, Batch]:
        """The same [N] at a `compression` $x$ [m], and its slope [N/m]."""
        x, rest = compression, column.free_length - compression
        halves, slope = self.halves(column, x)
        folded = hinge / sqrt(x * rest)
        return halves + folded, slope - 0.5 * folded * (1 / x - 1 / rest)

    def deflection(self, column: Column, strain: Batch) -> Batch:
        """$y_{c,max}$ [m] at `strain` [-], from the slope at the hinge, $\\pi y_{c,max}/L$."""
        x = (strain - column.free_strain) * column.rest_length
        return self.slope_factor / np.pi * sqrt(x * (column.free_length - x))

    def shape(self, column: Column, strain: Batch, points: int) -> Centerline:
        """Centerline [m] of (22), mirrored at the hinge, at `strain` [-]."""
        y_max = self.deflection(column, strain)
        along = np.linspace(0.0, 1.0, points)
        chord = spread(column.rest_length * (1 - strain) + 0.0 * y_max)
        # below the axis, as (8) is drawn
        y = -spread(y_max) * (1 - cos(np.pi * minimum(along, 1 - along)))
        return Centerline(z=chord * along, y=y)


class Derived(AbstractPostCollapse):
    """What (24) leads to: halves whose slope at the hinge is $\\sqrt{x/(L_{fs} - x)}$."""

    name: ClassVar[str] = "derived"
    slope_factor: ClassVar[float] = 1.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 (L_{fs} + x)/(4 (L_{fs} - x)^3)$ [N], and its slope [N/m]."""
        B, slope = _bent(column, compression)
        return B / 4, slope / 4


class Consistent(AbstractPostCollapse):
    """Inextensible halves, as (10) has it: a slope of $2\\sqrt{x/(L_{fs} - x)}$ at the hinge."""

    name: ClassVar[str] = "consistent"
    slope_factor: ClassVar[float] = 2.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 (L_{fs} + x)/(L_{fs} - x)^3$ [N], and its slope [N/m]."""
        return _bent(column, compression)


class Printed(AbstractPostCollapse):
    """(25) as printed: a number without the right units, for comparison only."""

    name: ClassVar[str] = "printed"
    slope_factor: ClassVar[float] = 1.0

    def halves(self, column: Column, compression: Batch) -> tuple[Batch, Batch]:
        """$B = EI\\pi^2 L_{fs}/(4 (L_{fs} - x)^2)$, printed as [N], in truth [N·m]; its slope."""
        EI, L, x = column.bending_stiffness, column.free_length, compression
        B = EI * np.pi**2 * L / (4 * (L - x) ** 2)
        return B, 2 * B / (L - x)


def _bent(column: Column, x: Batch) -> tuple[Batch, Batch]:
    """$EI\\pi^2 (L_{fs} + x)/(L_{fs} - x)^3$ [N] at a compression of `x` [m], and its slope."""
    EI, L = column.bending_stiffness, column.free_length
    unit = EI * np.pi**2 / (L - x) ** 3
    return unit * (L + x), unit * (4 * L + 2 * x) / (L - x)


COLLAPSE_LAWS: Mapping[str, type[AbstractCollapse]] = MappingProxyType(
    {law.name: law for law in (Kim2021Collapse, Wood1958, Brazier1927, SteinHedgepeth1961)}
)
POST_COLLAPSE_LAWS: Mapping[str, type[AbstractPostCollapse]] = MappingProxyType(
    {law.name: law for law in (Derived, Consistent, Printed)}
)
