r"""Bolen's law of Festo's muscles: a largest force that grows with length, and two exponentials.

$$F = F_m \left(a_0 (e^{-a_1 \varepsilon/\varepsilon_m} - 1)
  + \frac{P}{P_m} e^{-a_3 (\varepsilon/\varepsilon_m)^2}\right), \qquad
  F_m = F_\infty \arctan\frac{L_0 - l_0}{l_1}, \tag{BF}$$

with $P_m$ = 620 kPa. Short muscles hold less at rest than long ones. $\varepsilon_m$ is the
largest contraction at $P_m$, measured on the muscle. Only the muscle's length is used of its
sizes. The first term is counted as the bladder's.

**Sign:** pull and contraction positive. **Assumes** nothing: it is a fit, to pulling muscles.
**Valid for** 0 to 620 kPa, rest to the free strain, some 0.1 to 0.5 m.
**Source:** the public code of the Agile and Adaptive Robotics laboratory, Portland State
University (functions f_festo and maxBPAforce, whose comparison calls the law Bolen's); no paper
was at hand.
"""

from typing import ClassVar

from ...core.array_namespace import arctan, exp, where
from ...core.parameters import POSITIVE, Constant, log1p_scale
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .tension_law import AbstractTension, Offset, Pull, solved_free_strain


_HIGHEST = 620e3  # Pa, P_m
_LEAST = 1e-6  # of an arc: a muscle too short to hold anything still has a free strain
_SOURCE = "Agile and Adaptive Robotics laboratory, public code"
_DIMENSIONLESS = (1e-3, 1e-2, 30.0, 100.0)
# symbol, dimension, the code's unit over SI's, bounds, what it is
_SEVEN = {
    "bladder_share": ("a_0", "number", 1.0, _DIMENSIONLESS,
                      "of the largest force, that the bladder takes"),
    "bladder_rate": ("a_1", "number", 1.0, _DIMENSIONLESS, "of the bladder's rise"),
    "pressure_rate": ("a_3", "number", 1.0, _DIMENSIONLESS, "of the mesh's fall"),
    "largest_strain": (r"\varepsilon_m", "number", 1.0, (0.01, 0.05, 0.4, 0.6),
                       "at 620 kPa, measured"),
    "force_scale": (r"F_\infty", "force", _HIGHEST / 1e3, (1e-2, 1.0, 1e5, 1e6),
                    "of the largest force"),
    "length_scale": ("l_1", "length", 1e3 / _HIGHEST, (1e-4, 1e-3, 1.0, 10.0),
                     "over which the largest force rises"),
    "end_length": ("l_0", "length", 1.0, (0.0, 0.0, 0.1, 1.0), "of a muscle that holds nothing"),
}  # fmt: skip


def bolen_constant(name: str, published: float) -> Constant:
    """One of the seven by its `name` [-], `published` [-] in SI units, but for the largest
    force over kPa, and its length times kPa.
    """
    symbol, dimension, unit, bounds, about = _SEVEN[name]
    scale = POSITIVE if bounds[0] > 0 else log1p_scale(5e-3)
    return Constant(name, symbol, dimension, bounds, scale, published * unit, about, _SOURCE)


class AbstractBolen(AbstractTension):
    """A largest force that grows with length, and two exponentials, equation (BF)."""

    conservative: ClassVar[bool] = False
    linear_in_pressure: ClassVar[bool] = True

    bladder_share: ClassVar[Batch]
    bladder_rate: ClassVar[Batch]
    pressure_rate: ClassVar[Batch]
    largest_strain: ClassVar[Batch]
    force_scale: ClassVar[Batch]
    length_scale: ClassVar[Batch]
    end_length: ClassVar[Batch]

    def largest_force(self, length: BatchLike) -> Batch:
        """$F_m$ [N] of a muscle of `length` [m]."""
        over = (length - self.end_length) / self.length_scale
        return self.force_scale * arctan(where(over > _LEAST, over, _LEAST))

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """What grows with pressure, and the rest [N], equation (BF)."""
        a0, a1, a3 = self.bladder_share, self.bladder_rate, self.pressure_rate
        F_m, x = self.largest_force(bladder.braid.length), strain / self.largest_strain
        rising, falling = exp(-a1 * x), exp(-a3 * x**2)
        share = F_m * pressure / _HIGHEST
        per_strain = 1 / self.largest_strain
        return Pull(
            mesh=share * falling,
            bladder=F_m * a0 * (rising - 1) + 0.0 * pressure,
            mesh_slope=-2 * a3 * x * share * falling * per_strain,
            bladder_slope=-a1 * F_m * a0 * rising * per_strain + 0.0 * pressure,
        )

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of $F = C_1$ [-]; 0 at $P = 0$, from there rising."""
        return solved_free_strain(self, bladder, pressure, offset)
