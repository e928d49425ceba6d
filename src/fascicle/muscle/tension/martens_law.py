r"""Martens and Boblan's law of Festo's muscles: a wall whose modulus follows its length.

Fibers at $\theta = \alpha_0 + \delta$ enclose the bore, of the inner radius $r_i$; with
$\rho = D/D_0 = \sqrt{1 + \varepsilon (2 - \varepsilon) \cot^2\theta}$

$$T = \pi r_i^2 P \left(3 \lambda^2 \cot^2\theta - \frac{1}{\sin^2\theta}\right)
  - 2 \pi r_i t_0 E(\lambda) \left((\lambda - 1) \rho
  + \frac{\rho - 1}{\rho} \lambda^2 \cot^2\theta\right), \quad
  E = \sum_{k=0}^3 e_k \lambda^k. \tag{MB}$$

The polynomial and the correction $\delta$ of the braid angle, in radians, are fitted to one
muscle. It is published over the length in meters; here it is one of $\lambda = L/L_0$, which is
the same at the length it was fitted at and goes with the muscle at others. The wall's axial term
has the published sign: it pulls where the muscle is shorter than at rest, and the fit of $E$ makes
up for it. The wall keeps its thickness.

**Sign:** pull and contraction positive. **Valid for** Festo's muscles, $\alpha_0$ = 28.6 deg,
$t_0$ = 1.8 mm, from rest to the free strain. Where fibers at $\theta$ are nearly straight the
wall's force is held. **Source:** Martens and Boblan (2017) and its erratum (2018), constants and
form as quoted by the public code of the Agile and Adaptive Robotics laboratory, Portland State
University; the paper itself wasn't at hand.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import minimum, sin, sqrt, tan, where
from ...core.parameters import Constant, symmetric_scale
from ...core.roots import root
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .tension_law import AbstractTension, Offset, Pull


_STRAIGHT = 0.02  # of ρ²: below it fibers are so nearly straight that the wall is held
_SOURCE = "Martens and Boblan (2017)"


def modulus_constant(power: int, published: float, length: float) -> Constant:
    """$e_k$ of the `power` $k$ [-], `published` [Pa/m^k] for a muscle of this `length` [m]."""
    value = published * length**power
    size = abs(value)
    return Constant(
        f"modulus_{power}", f"e_{power}", "pressure",
        (-1e3 * size, -10 * size, 10 * size, 1e3 * size), symmetric_scale(size), value,
        f"of the wall's modulus, times $\\lambda^{power}$", _SOURCE,
    )  # fmt: skip


def angle_constant(published: float) -> Constant:
    """$\\delta$, as `published` [rad]."""
    about = "added to the braid angle"
    return Constant("angle_correction", r"\delta", "angle", (-0.5, -0.3, 0.3, 0.5),
                    symmetric_scale(0.05), published, about, _SOURCE)  # fmt: skip


class AbstractMartens(AbstractTension):
    """An ideal mesh and a wall whose modulus follows its length, equation (MB)."""

    conservative: ClassVar[bool] = False
    linear_in_pressure: ClassVar[bool] = True

    modulus_0: ClassVar[Batch]
    modulus_1: ClassVar[Batch]
    modulus_2: ClassVar[Batch]
    modulus_3: ClassVar[Batch]
    angle_correction: ClassVar[Batch]

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and wall force [N], equation (MB)."""
        theta = bladder.braid.angle + self.angle_correction
        cot2, lam, r_i = 1 / tan(theta) ** 2, 1 - strain, bladder.inner_radius
        unit = np.pi * r_i**2 * pressure
        wall, wall_slope = self._wall(cot2, lam)
        section = 2 * np.pi * r_i * bladder.wall_thickness
        return Pull(
            mesh=unit * (3 * lam**2 * cot2 - 1 / sin(theta) ** 2),
            bladder=-section * wall,
            mesh_slope=-6 * unit * lam * cot2,
            bladder_slope=section * wall_slope + 0.0 * pressure,
        )

    def _wall(self, cot2: Batch, lam: BatchLike) -> tuple[Batch, Batch]:
        """$E$ times the bracket of (MB) [Pa], and its slope in $\\lambda$ [Pa]."""
        e0, e1, e2, e3 = self.modulus_0, self.modulus_1, self.modulus_2, self.modulus_3
        longest = sqrt(1 + (1 - _STRAIGHT) / cot2)
        held = longest < lam
        lam = minimum(lam, longest)
        E = e0 + lam * (e1 + lam * (e2 + lam * e3))
        E_slope = e1 + lam * (2 * e2 + lam * 3 * e3)
        rho = sqrt(1 + (1 - lam**2) * cot2)
        rho_slope = -lam * cot2 / rho
        bracket = (lam - 1) * rho + (1 - 1 / rho) * lam**2 * cot2
        slope = rho + (lam - 1) * rho_slope + cot2 * (
            rho_slope / rho**2 * lam**2 + 2 * lam * (1 - 1 / rho)
        )  # fmt: skip
        return E * bracket, where(held, 0.0, E_slope * bracket + E * slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The first root of $T = C_1$ [-], up to where the mesh lets go; there where it is past."""
        cot2 = 1 / tan(bladder.braid.angle + self.angle_correction) ** 2
        far = 1 - sqrt((1 + 1 / cot2) / 3) + 0.0 * pressure
        theta = (self, bladder, pressure, offset(pressure))
        return root(_remaining, theta, 0.5 * bladder.braid.straight + 0.0 * far, far, 0.5 * far)


def _remaining(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    law, bladder, pressure, c1 = theta
    pull = law.pull(bladder, pressure, strain)
    return pull.force - c1, pull.slope
