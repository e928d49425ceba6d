r"""The default tension law: mesh and hyperelastic bladder.

$$T(P, \varepsilon) = F_{mesh}(P, \varepsilon) + F_{bladder}(\varepsilon). \tag{4}$$

Both terms are kept, so that the free strain, the root of $T$, rises with pressure from zero; of
braids below some 11.5 deg it may fall again.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996); Klute and Hannaford (2000); Kim, Mazzoleni and
Bryant (2021), section 2.
"""

from typing import ClassVar

from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from .tension_law import SIZES, AbstractTension, Offset, Pull, solved_free_strain


class KluteHannaford(AbstractTension):
    """Mesh and hyperelastic bladder: Klute and Hannaford (2000)."""

    name: ClassVar[str] = "klute_hannaford"
    title: ClassVar[str] = "Klute-Hannaford"
    source: ClassVar[str] = "Klute and Hannaford (2000)"
    conservative: ClassVar[bool] = True
    linear_in_pressure: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = ("c10", "c01", *SIZES)

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N], equations (3) and (4)."""
        mesh, mesh_slope = bladder.braid.mesh(pressure, strain)
        wall, wall_slope = bladder.pull(strain)
        return Pull(mesh, wall, mesh_slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of $F_{mesh} + F_{bladder} = C_1$ [-]; 0 at $P = 0$, from there rising."""
        return solved_free_strain(self, bladder, pressure, offset)
