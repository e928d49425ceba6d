r"""The ideal law at a multiple of the strain: Tondu and Lopez (2000).

A muscle's ends don't swell, its threads rub, its bladder takes force: it contracts less
than the ideal law says. One factor on the strain stands for all of it,

$$T = \pi r_0^2 P \left(a (1 - k \varepsilon)^2 - b\right), \qquad
  k(P) = a_k e^{-P/P_k} + b_k, \tag{TL}$$

with $a = 3/\tan^2\alpha_0$, $b = 1/\sin^2\alpha_0$. Left out, it is 1 and the law is the ideal
one, to the bit.

**Sign:** pull and contraction positive. **Assumes** what `Ideal` does; the factor stands for the
rest. Where $k \ne 1$ the force is no longer $-P\,dV/dL$ of the braid's volume.
**Valid for** $k \varepsilon < 1$, past which (TL) would turn upward.
**Source:** Tondu and Lopez (2000), with $P_k$ = 1 bar.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import exp
from ...core.errors import InvalidInputError
from ...core.parameters import POSITIVE, Constant, symmetric_scale
from ...core.types import Batch, BatchLike
from ...core.validation import is_concrete
from ..bladder import Bladder
from .ideal import Ideal
from .tension_law import AbstractTension, Offset, Pull


class TonduLopez(AbstractTension):
    """The ideal law at $k$ times the strain, equation (TL)."""

    name: ClassVar[str] = "tondu_lopez"
    title: ClassVar[str] = "Tondu-Lopez"
    source: ClassVar[str] = "Tondu and Lopez (2000)"
    conservative: ClassVar[bool] = False
    free: ClassVar[tuple[str, ...]] = ("strain_factor", "outer_radius")

    strain_factor: Batch = Constant(
        "strain_factor", "b_k", "number", (0.01, 0.2, 5.0, 100.0), POSITIVE, 1.0,
        "on the strain at high pressures",
    ).field()  # fmt: skip
    strain_factor_rise: Batch = Constant(
        "strain_factor_rise", "a_k", "number", (-100.0, -5.0, 5.0, 100.0), symmetric_scale(1.0),
        0.0, "by how much it is larger at zero pressure",
    ).field()  # fmt: skip
    decay_pressure: Batch = Constant(
        # for pressures up to 1 MPa
        "decay_pressure", "P_k", "pressure", (1.0, 1e3, 1e7, 1e9), POSITIVE, 1e5,
        "over which the rise falls to 1/e",
    ).field()  # fmt: skip

    def __check_init__(self):
        if is_concrete(self.strain_factor, self.strain_factor_rise):
            lowest = np.min(np.asarray(self.strain_factor + self.strain_factor_rise))
            if lowest <= 0:
                raise InvalidInputError(
                    "strain_factor_rise",
                    "must leave the factor positive at zero pressure",
                    lowest,
                    shown=f"a factor of {lowest:g} there",
                )

    def factor_at(self, pressure: BatchLike) -> Batch:
        """$k$ [-] at `pressure` [Pa], equation (TL)."""
        a_k, b_k = self.strain_factor_rise, self.strain_factor
        return a_k * exp(-pressure / self.decay_pressure) + b_k

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (TL), and zero."""
        k = self.factor_at(pressure)
        mesh, wall, slope, wall_slope = Ideal().pull(bladder, pressure, k * strain)
        return Pull(mesh, wall, k * slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The ideal one [-] over $k(P)$."""
        return Ideal().free_strain(bladder, pressure, offset) / self.factor_at(pressure)
