r"""Tension laws: the pull of a muscle up to its free strain, in its two components.

$$T(P, \varepsilon) = F_{mesh}(P, \varepsilon) + F_{bladder}(\varepsilon). \tag{4}$$

`KluteHannaford`, the default, keeps both terms, so that the free strain, the root of $T$,
rises with pressure from zero; of braids below some 11.5 deg it may fall again. Past the free
strain $T$ goes on as compression: buckling laws say what of it is real.

Beside it, by name: `ideal`, the mesh alone; `tondu_lopez` and `meller2014`, the ideal law
with measured factors; `kothera2009`, a balance of forces with a thinning wall.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996); Klute and Hannaford (2000); Kim, Mazzoleni and
Bryant (2021), section 2.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from .._types import Batch, BatchLike
from .bladder import Bladder
from .corrected import Meller2014, TonduLopez
from .force_balance import Kothera2009
from .ideal import NOTHING, AbstractTension, Ideal, Offset, Pull, solved_free_strain


class KluteHannaford(AbstractTension):
    """Mesh and hyperelastic bladder: Klute and Hannaford (2000)."""

    name: ClassVar[str] = "klute_hannaford"
    parameters: ClassVar[Mapping[str, str]] = NOTHING
    conservative: ClassVar[bool] = True

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N], equations (3) and (4)."""
        mesh, mesh_slope = bladder.braid.mesh(pressure, strain)
        wall, wall_slope = bladder.pull(strain)
        return Pull(mesh, wall, mesh_slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of $F_{mesh} + F_{bladder} = C_1$ [-]; 0 at $P = 0$, from there rising."""
        return solved_free_strain(self, bladder, pressure, offset)


TENSION_LAWS: Mapping[str, type[AbstractTension]] = MappingProxyType(
    {law.name: law for law in (KluteHannaford, Ideal, TonduLopez, Meller2014, Kothera2009)}
)
