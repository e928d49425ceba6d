r"""Sárosi's empirical law of Festo's muscles: six numbers for a muscle of one size.

$$F = (a P + b)\, e^{c \varepsilon} + d P \varepsilon + e P + f \tag{S}$$

with an exponential that dies out after a few percent and a plane. Of the muscle it takes nothing,
so its sizes say only how it buckles. The numbers are published for $P$ in bar and the contraction
in percent; here they carry SI units. What grows with pressure is counted as the mesh's, the rest
as the bladder's.

**Sign:** pull and contraction positive. **Assumes** nothing: it is a fit, of muscles that pull.
**Valid for** the muscle it was fitted to, above some 0.5 bar, from rest to its free strain;
without pressure it says small forces that aren't zero.
**Source:** Sárosi (2012, 2017), constants as quoted by the public code of the Agile and Adaptive
Robotics laboratory, Portland State University; the papers themselves weren't at hand.
"""

from typing import ClassVar

from ...core.array_namespace import exp
from ...core.parameters import Constant, symmetric_scale
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .tension_law import AbstractTension, Offset, Pull, solved_free_strain


_BAR, _PERCENT = 1e5, 1e-2
_WIDE = 1e6
# symbol, dimension, its unit in the papers over SI's, what it is
_SIX = {
    "exponential_slope": ("a", "slip", 1 / _BAR, "of the exponential, with pressure"),
    "exponential_force": ("b", "force", 1.0, "of the exponential, without pressure"),
    "exponent": ("c", "number", 1 / _PERCENT, "of the exponential, over the strain"),
    "strain_slope": ("d", "slip", 1 / (_BAR * _PERCENT), "of the plane, with pressure and strain"),
    "pressure_slope": ("e", "slip", 1 / _BAR, "of the plane, with pressure"),
    "force_offset": ("f", "force", 1.0, "of the plane"),
}


def sarosi_constant(name: str, published: float) -> Constant:
    """One of the six by its `name` [-], `published` for bar and percent [-]."""
    symbol, dimension, unit, about = _SIX[name]
    value = published * unit
    size = abs(value)
    bounds = (-_WIDE * size, -100 * size, 100 * size, _WIDE * size)
    return Constant(
        name, symbol, dimension, bounds, symmetric_scale(size), value, about, "Sárosi (2012)"
    )


class AbstractSarosi(AbstractTension):
    """Six numbers for a muscle of one size, equation (S)."""

    conservative: ClassVar[bool] = False
    linear_in_pressure: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = tuple(_SIX)

    exponential_slope: ClassVar[Batch]
    exponential_force: ClassVar[Batch]
    exponent: ClassVar[Batch]
    strain_slope: ClassVar[Batch]
    pressure_slope: ClassVar[Batch]
    force_offset: ClassVar[Batch]

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:  # noqa: ARG002 of one size
        """What grows with pressure, and the rest [N], equation (S)."""
        a, b, c = self.exponential_slope, self.exponential_force, self.exponent
        d, e, f = self.strain_slope, self.pressure_slope, self.force_offset
        fading = exp(c * strain)
        return Pull(
            mesh=pressure * (a * fading + d * strain + e),
            bladder=b * fading + f,
            mesh_slope=pressure * (a * c * fading + d),
            bladder_slope=b * c * fading + 0.0 * pressure,
        )

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of $F = C_1$ [-]."""
        return solved_free_strain(self, bladder, pressure, offset)
