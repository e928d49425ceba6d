r"""Braid kinematics, enclosed volume, and the mesh force of a McKibben muscle.

Braid fibers can't stretch. A fiber that lies at $\alpha_0$ from the axis at rest turns
as the muscle of length $L = \lambda L_0$, $\lambda = 1 - \varepsilon$, shortens, and the
radius follows it:

$$r(\varepsilon) = r_0 \frac{\sqrt{1 - \cos^2\alpha_0 \lambda^2}}{\sin\alpha_0}. \tag{2}$$

The volume inside is the potential of the pressure,

$$V(\varepsilon) = \pi r^2 L, \tag{V}$$

and virtual work gives the tension that the pressurized mesh holds,

$$F_{mesh} = -P \frac{\mathrm{d}V}{\mathrm{d}L}. \tag{3}$$

Bent to the curvature $\kappa$, its fibers hold $P r$ around the section, and along it
$P r \cot^2\alpha$ by the angle at which they then lie, where the axis is stretched by
$\kappa r \cos\varphi$: $\cot^2\alpha$ rises by $2 \cot^2\alpha (1 + \cot^2\alpha)$ times
this, and the moment is

$$\frac{M}{\kappa} = \int_0^{2\pi} 2 P r^4 \cot^2\alpha (1 + \cot^2\alpha) \cos^2\varphi
    \,\mathrm{d}\varphi = 2 \pi r^4 P \frac{\cos^2\alpha}{\sin^4\alpha}. \tag{B1}$$

**Sign:** tension and contraction are positive. **Valid for**
$1 - 1/\cos\alpha_0 < \varepsilon < 1$: at the lower end the fibers are straight.
**Assumes** inextensible, frictionless, thin fibers and a cylinder right to its ends.
**Source:** Chou and Hannaford (1996); Kim, Mazzoleni and Bryant (2021), (1)-(3). (3) is
printed there without the factor 3 of $3\lambda^2/\tan^2\alpha_0$ [R1]: see the theory pages.
"""

import numpy as np

from ..core.array_namespace import arccos, cos, sqrt, tan
from ..core.module import Module
from ..core.types import Batch, BatchLike


class Braid(Module):
    """The ideal braid: every fiber a perfect helix on a cylinder."""

    length: Batch
    radius: Batch
    angle: Batch

    @property
    def cot2(self) -> Batch:
        """Squared cotangent of the braid angle [-], one less than $1/\\sin^2\\alpha_0$."""
        return 1 / tan(self.angle) ** 2

    @property
    def straight_strain(self) -> Batch:
        """Strain [-] at which its fibers are straight, $1 - 1/\\cos\\alpha_0$."""
        return 1 - 1 / cos(self.angle)

    def squared_stretch(self, strain: BatchLike) -> Batch:
        """Square of the radial stretch, $(r/r_0)^2$ [-], at `strain` [-], from (2)."""
        # cos² and sin² taken together: exactly 1 at rest, where forces must vanish
        return 1 + strain * (2 - strain) * self.cot2

    def radius_at(self, strain: BatchLike) -> Batch:
        """Radius $r$ [m] at `strain` $\\varepsilon$ [-], equation (2)."""
        return self.radius * sqrt(self.squared_stretch(strain))

    def angle_at(self, strain: BatchLike) -> Batch:
        """Braid angle $\\alpha$ [rad] at `strain` [-]: $\\cos\\alpha = \\lambda\\cos\\alpha_0$."""
        return arccos((1 - strain) * cos(self.angle))

    def volume(self, strain: BatchLike) -> Batch:
        """Volume $V$ [m³] inside the braid at `strain` [-], equation (V)."""
        return np.pi * self.radius**2 * self.squared_stretch(strain) * self.length * (1 - strain)

    def mesh_force(self, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Tension $F_{mesh}$ [N] of the braid at `pressure` [Pa] and `strain` [-], equation (3)."""
        return self.mesh(pressure, strain)[0]

    def mesh(self, pressure: BatchLike, strain: BatchLike) -> tuple[Batch, Batch]:
        """Mesh force [N] and its slope in strain [N], at `pressure` [Pa] and `strain` [-]."""
        free, cot2 = self.ideal_free_strain, self.cot2
        pull = 3 * np.pi * self.radius**2 * pressure * cot2
        # L0 dV/dε P = π r0² P (3 λ²/tan²α0 − 1/sin²α0), whose two parts would round apart where
        # they cancel
        return pull * (free - strain) * (2 - free - strain), -2 * pull * (1 - strain)

    def bending_stiffness(self, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Bending stiffness [N·m²] without slip at `pressure` [Pa] and `strain` [-], (B1)."""
        # r² and sin²α have one factor in strain: r/sin α is constant
        angles = self.cot2 * (1 + self.cot2)
        return 2 * np.pi * self.radius**4 * pressure * angles * (1 - strain) ** 2

    @property
    def ideal_free_strain(self) -> Batch:
        """Strain [-] at which the mesh force vanishes: fibers at 54.7356°, V largest."""
        return 1 - 1 / (np.sqrt(3) * cos(self.angle))
