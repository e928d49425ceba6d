r"""The ideal law with factors on strain and force: Tondu and Lopez (2000), Meller et al. (2014).

A muscle's ends don't swell, its threads rub, its bladder takes force: it contracts less
than the ideal law says. One factor on the strain stands for all of it,

$$T = \pi r_0^2 P \left(a (1 - k \varepsilon)^2 - b\right), \qquad
  k(P) = a_k e^{-P/P_k} + b_k, \tag{TL}$$

with $a = 3/\tan^2\alpha_0$, $b = 1/\sin^2\alpha_0$. Meller's law has constant factors, on the
strain and on the force,

$$T = f_F\, \pi r_0^2 P \left(a (1 - f_\varepsilon \varepsilon)^2 - b\right), \tag{M}$$

where a measured free strain gives $f_\varepsilon$ and a measured blocked force $f_F$
(`Meller2014.from_measured`). Left out, all factors are 1 and the law is the ideal one, to the bit.

**Sign:** pull and contraction positive. **Assumes** the same as `Ideal`; the factors stand for the
rest. Where one isn't 1 the force is no longer $-P\,dV/dL$ of the braid's volume.
**Valid for** $k \varepsilon < 1$, past which (TL) would turn upward.
**Source:** Tondu and Lopez (2000), with $P_k$ = 1 bar; Meller, Bryant and Garcia (2014), derived
here from the two quantities that its factors restore.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import exp
from ...core.errors import InvalidInputError
from ...core.parameters import POSITIVE, Constant, symmetric_scale
from ...core.types import Batch, BatchLike, Values
from ...core.validation import check_positive, is_concrete
from ..bladder import Bladder
from ..braid import Braid
from . import AbstractTension, Ideal, Offset, Pull


class TonduLopez(AbstractTension):
    """The ideal law at $k$ times the strain, equation (TL)."""

    name: ClassVar[str] = "tondu_lopez"
    title: ClassVar[str] = "Tondu-Lopez"
    source: ClassVar[str] = "Tondu and Lopez (2000)"
    conservative: ClassVar[bool] = False
    free: ClassVar[tuple[str, ...]] = ("strain_factor", "outer_radius")

    strain_factor: Batch = Constant(
        "strain_factor",
        "b_k",
        "number",
        (0.01, 0.2, 5.0, 100.0),
        POSITIVE,
        1.0,
        "factor on the strain at high pressures",
    ).field()
    strain_factor_rise: Batch = Constant(
        "strain_factor_rise",
        "a_k",
        "number",
        (-100.0, -5.0, 5.0, 100.0),
        symmetric_scale(1.0),
        0.0,
        "rise of the strain factor at zero pressure",
    ).field()
    decay_pressure: Batch = Constant(
        # for pressures up to 1 MPa
        "decay_pressure",
        "P_k",
        "pressure",
        (1.0, 1e3, 1e7, 1e9),
        POSITIVE,
        1e5,
        "pressure over which the rise falls to 1/e",
    ).field()

    def __check_init__(self):
        if is_concrete(self.strain_factor, self.strain_factor_rise):
            lowest = np.min(np.asarray(self.strain_factor + self.strain_factor_rise))
            if lowest <= 0:
                rule = "must leave the factor positive at zero pressure"
                text = f"a factor of {lowest:g} there"
                raise InvalidInputError("strain_factor_rise", rule, lowest, shown=text)

    def factor_at(self, pressure: BatchLike) -> Batch:
        """Strain factor $k$ [-] at `pressure` [Pa], equation (TL)."""
        a_k, b_k = self.strain_factor_rise, self.strain_factor
        return a_k * exp(-pressure / self.decay_pressure) + b_k

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (TL), and zero for the bladder, with slopes."""
        k = self.factor_at(pressure)
        mesh, wall, slope, wall_slope = Ideal().pull(bladder, pressure, k * strain)
        return Pull(mesh, wall, k * slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Free strain [-] of the ideal law over $k(P)$."""
        return Ideal().free_strain(bladder, pressure, offset) / self.factor_at(pressure)


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
        "strain_factor",
        r"f_\varepsilon",
        "number",
        (0.01, 0.2, 5.0, 100.0),
        POSITIVE,
        1.0,
        "factor on the strain: ideal over measured free strain",
    ).field()
    force_factor: Batch = Constant(
        "force_factor",
        "f_F",
        "number",
        (1e-4, 0.1, 10.0, 1e4),
        POSITIVE,
        1.0,
        "factor on the force: measured over ideal blocked force",
    ).field()

    @classmethod
    def from_measured(
        cls, braid: Braid, pressure: Values, free_strain: Values, blocked_force: Values
    ) -> "Meller2014":
        """Law of a muscle with this `braid` from a `free_strain` [-] and a `blocked_force` [N] that
        were measured at `pressure` [Pa].
        """
        P = check_positive(pressure, "pressure", "Pa")
        eps_f = check_positive(free_strain, "free_strain", "-")
        blocked = check_positive(blocked_force, "blocked_force", "N")
        return cls(braid.ideal_free_strain / eps_f, blocked / braid.mesh_force(P, 0.0))

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (M), and zero for the bladder, with slopes."""
        f_eps, f_F = self.strain_factor, self.force_factor
        mesh, wall, slope, wall_slope = Ideal().pull(bladder, pressure, f_eps * strain)
        return Pull(f_F * mesh, wall, f_F * f_eps * slope, wall_slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Free strain [-] of the ideal law with $C_1/f_F$, over $f_\\varepsilon$."""
        ideal = Ideal().free_strain(bladder, pressure, lambda P: offset(P) / self.force_factor)
        return ideal / self.strain_factor
