r"""The simplest tension law: the mesh alone.

Without a bladder the force is proportional to pressure,

$$T = \pi r_0^2 P \left(a (1 - \varepsilon)^2 - b\right), \qquad
  a = \frac{3}{\tan^2\alpha_0}, \qquad b = \frac{1}{\sin^2\alpha_0}, \tag{3}$$

so that its free strain $1 - \sqrt{b/a} = 1 - 1/(\sqrt3 \cos\alpha_0)$ doesn't depend on it.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996).
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import sqrt, where
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .tension_law import SIZES, AbstractTension, Offset, Pull


# Pa: below this, C1/P is taken here. C1 is proportional to pressure up to the tuning's first row,
# so the ratio is the same, and subnormal pressures don't divide 0 by 0
_LEAST_PRESSURE = 1e-3


class Ideal(AbstractTension):
    """The mesh alone: Chou and Hannaford (1996), no bladder."""

    name: ClassVar[str] = "ideal"
    source: ClassVar[str] = "Chou and Hannaford (1996)"
    conservative: ClassVar[bool] = True
    linear_in_pressure: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = SIZES

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (3), and zero."""
        mesh, slope = bladder.braid.mesh(pressure, strain)
        return Pull(mesh, 0.0 * mesh, slope, 0.0 * slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The strain [-] where the mesh holds $C_1$ alone; its limit at $P = 0$."""
        cot2, r0 = bladder.braid.cot2, bladder.braid.radius
        P = where(pressure > _LEAST_PRESSURE, pressure, _LEAST_PRESSURE)
        held = 1 + cot2 + offset(P) / (np.pi * r0**2 * P)
        return 1 - sqrt(held / (3 * cot2))
