r"""The ideal law with a factor on strain and one on force: Meller et al. (2014).

A muscle contracts less and pulls less than the ideal law says. Two constants correct both,

$$T = f_F\, \pi r_0^2 P \left(a (1 - f_\varepsilon \varepsilon)^2 - b\right), \tag{M}$$

with $a = 3/\tan^2\alpha_0$, $b = 1/\sin^2\alpha_0$: a measured free strain gives
$f_\varepsilon$, a measured blocked force $f_F$ (`Meller2014.from_measured`). Left out, both
factors are 1 and the law is the ideal one, to the bit.

**Sign:** pull and contraction positive. **Assumes** what `Ideal` does; the factors stand
for the rest. Where one isn't 1 the force is no longer $-P\,dV/dL$ of the braid's volume.
**Source:** Meller, Bryant and Garcia (2014), derived here from the two quantities that its
factors restore.
"""

from typing import ClassVar

from ...core.parameters import POSITIVE, Constant
from ...core.types import Batch, BatchLike, Values
from ...core.validation import check_positive
from ..bladder import Bladder
from ..braid import Braid
from .ideal import Ideal
from .tension_law import AbstractTension, Offset, Pull


class Meller2014(AbstractTension):
    """The ideal law with a factor on strain and one on force, equation (M)."""

    name: ClassVar[str] = "meller2014"
    title: ClassVar[str] = "Meller"
    source: ClassVar[str] = "Meller, Bryant and Garcia (2014)"
    conservative: ClassVar[bool] = False
    linear_in_pressure: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = ("strain_factor", "force_factor")

    strain_factor: Batch = Constant(
        # 1 to 1.6 in muscles
        "strain_factor", r"f_\varepsilon", "number", (0.01, 0.2, 5.0, 100.0), POSITIVE, 1.0,
        "on the strain: ideal over measured free strain",
    ).field()  # fmt: skip
    force_factor: Batch = Constant(
        "force_factor", "f_F", "number", (1e-4, 0.1, 10.0, 1e4), POSITIVE, 1.0,
        "on the force: measured over ideal blocked force",
    ).field()  # fmt: skip

    @classmethod
    def from_measured(
        cls, braid: Braid, pressure: Values, free_strain: Values, blocked_force: Values
    ) -> "Meller2014":
        """The law that meets a measured free strain and a measured blocked force.

        **Arguments:**

        - `braid`: the muscle's [-].
        - `pressure`: $P$ [Pa] at which the force was measured, positive.
        - `free_strain`: measured [-], positive.
        - `blocked_force`: measured [N], positive.

        **Returns:** the law [-].

        **Raises:** `ValueError` where a measured value isn't positive.
        """
        P, eps_f = (
            check_positive(pressure, "pressure", "Pa"),
            check_positive(free_strain, "free_strain", "-"),
        )
        blocked = check_positive(blocked_force, "blocked_force", "N")
        return cls(braid.ideal_free_strain / eps_f, blocked / braid.mesh_force(P, 0.0))

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (M), and zero."""
        f_eps, f_F = self.strain_factor, self.force_factor
        mesh, wall, slope, wall_slope = Ideal().pull(bladder, pressure, f_eps * strain)
        return Pull(f_F * mesh, wall, f_F * f_eps * slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The ideal one [-] under $C_1/f_F$, over $f_\\varepsilon$."""

        def ideal_offset(pressure: Batch) -> Batch:
            return offset(pressure) / self.force_factor

        return Ideal().free_strain(bladder, pressure, ideal_offset) / self.strain_factor
