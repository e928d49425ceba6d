r"""The bladder: a rubber tube inside the braid, its section and its axial force.

Stretched by $\lambda_1 = 1 - \varepsilon$ along the axis, and around it by the braid that
it follows, $\lambda_2 = r/r_0$, its wall of volume $V_b = A L_0$ stores $U = V_b W$, and
virtual work gives

$$F_{bladder} = V_b \frac{\mathrm{d}W}{\mathrm{d}L}
  = 2 A \lambda \Bigl(\frac{\partial W}{\partial \lambda_1^2}
    - \frac{1}{\tan^2\alpha_0} \frac{\partial W}{\partial \lambda_2^2}\Bigr), \qquad
  A = \pi (r_0^2 - r_i^2), \qquad I = \tfrac{\pi}{4} (r_0^4 - r_i^4). \tag{4b}$$

**Sign:** tension is positive, so it is negative in contraction, zero at rest. The paper's
(4) counts $\mathrm{d}L$ as shortening [R2]. **Assumes** an incompressible wall that keeps
to the braid. **Source:** Klute and Hannaford (2000); Kim, Mazzoleni and Bryant (2021), (4).
"""

import numpy as np

from ..core.module import Module
from ..core.types import Batch, BatchLike
from .braid import Braid
from .materials import AbstractMaterial, Slopes


class Bladder(Module):
    """A tube of `wall_thickness` [m] and a `material`, on the inside of a `braid`."""

    braid: Braid
    wall_thickness: Batch
    material: AbstractMaterial

    @property
    def inner_radius(self) -> Batch:
        """Inner radius at rest $r_i$ [m]."""
        return self.braid.radius - self.wall_thickness

    @property
    def area(self) -> Batch:
        """Section area at rest $A$ [m²]."""
        return np.pi * (self.braid.radius**2 - self.inner_radius**2)

    @property
    def second_moment(self) -> Batch:
        """Second moment of area at rest $I$ [m⁴]."""
        return np.pi / 4 * (self.braid.radius**4 - self.inner_radius**4)

    @property
    def volume(self) -> Batch:
        """Volume of the wall $V_b$ [m³], equal at every strain."""
        return self.area * self.braid.length

    def energy(self, strain: BatchLike) -> Batch:
        """Stored energy $U = V_b W$ [J] at `strain` $\\varepsilon$ [-]."""
        lam = 1 - strain
        return self.volume * self.material.energy(lam**2, self.braid.squared_stretch(strain))

    def force(self, strain: BatchLike) -> Batch:
        """Axial force $F_{bladder}$ [N] at `strain` $\\varepsilon$ [-], equation (4b)."""
        return self.pull(strain)[0]

    def pull(self, strain: BatchLike, slopes: Slopes | None = None) -> tuple[Batch, Batch]:
        """Axial force [N] and its slope in strain [N], at `strain` [-]; `slopes`: of the material
        at other hoop stretches, which are held constant.
        """
        lam, cot2 = 1 - strain, self.braid.cot2
        W = slopes or self.material.slopes(lam**2, 1 + strain * (2 - strain) * cot2)
        stress = W.p - cot2 * W.q
        bend = W.pp - 2 * cot2 * W.pq + cot2**2 * W.qq
        pull = 2 * self.area
        # dλ1²/dε = −2 λ, dλ2²/dε = 2 λ/tan²α0
        return pull * lam * stress, -pull * (stress + 2 * lam**2 * bend)
