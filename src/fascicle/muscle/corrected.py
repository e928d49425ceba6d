r"""The ideal law with measured factors: Tondu and Lopez (2000), Meller et al. (2014).

A muscle's ends don't swell, its threads rub, its bladder takes force: it contracts less
than the ideal law says. `TonduLopez` scales the strain,

$$T = \pi r_0^2 P \left(a (1 - k \varepsilon)^2 - b\right), \qquad
  k(P) = a_k e^{-P/P_k} + b_k, \tag{TL}$$

`Meller2014` strain and force, each by a constant,

$$T = f_F\, \pi r_0^2 P \left(a (1 - f_\varepsilon \varepsilon)^2 - b\right), \tag{M}$$

with $a = 3/\tan^2\alpha_0$, $b = 1/\sin^2\alpha_0$: a measured free strain gives
$f_\varepsilon$, a measured blocked force $f_F$ (`Meller2014.from_measured`). Left out, all
factors are 1 and the law is the ideal one, to the bit.

**Sign:** pull and contraction positive. **Assumes** what `Ideal` does; the factors stand
for the rest. Where $f_F \ne 1$, or $k \ne 1$, the force is no longer $-P\,dV/dL$ of the
braid's volume. **Valid for** $k \varepsilon < 1$, past which (TL) would turn upward.
**Source:** Tondu and Lopez (2000), with $P_k$ = 1 bar; Meller, Bryant and Garcia (2014),
derived here from the two quantities that its factors restore.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from .._arrays import exp
from .._checks import concrete, positive
from .._limits import signed, size
from .._refused import Refused
from .._types import Batch, BatchLike, Values
from .bladder import Bladder
from .braid import Braid
from .ideal import AbstractTension, Ideal, Offset, Pull


class TonduLopez(AbstractTension):
    """The ideal law at $k$ times the strain, equation (TL)."""

    name: ClassVar[str] = "tondu_lopez"
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"strain_factor": "number", "strain_factor_rise": "number", "decay_pressure": "pressure"}
    )
    conservative: ClassVar[bool] = False

    strain_factor: Batch
    strain_factor_rise: Batch
    decay_pressure: Batch

    def __init__(
        self,
        strain_factor: Values = 1.0,
        strain_factor_rise: Values = 0.0,
        decay_pressure: Values = 1e5,
    ):
        """**Arguments:**

        - `strain_factor`: $b_k$ [-], that of high pressures, positive.
        - `strain_factor_rise`: $a_k$ [-], by how much $k$ is larger at zero pressure.
        - `decay_pressure`: $P_k$ [Pa], over which the rise falls to 1/e.

        **Raises:** `ValueError` where $k$ isn't positive at every pressure.
        """
        self.strain_factor = size(strain_factor, "strain_factor")
        self.strain_factor_rise = signed(strain_factor_rise, "strain_factor_rise")
        self.decay_pressure = size(decay_pressure, "decay_pressure")
        if concrete(self.strain_factor, self.strain_factor_rise):
            lowest = np.min(np.asarray(self.strain_factor + self.strain_factor_rise))
            if lowest <= 0:
                raise Refused(
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


class Meller2014(AbstractTension):
    """The ideal law with a factor on strain and one on force, equation (M)."""

    name: ClassVar[str] = "meller2014"
    parameters: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"strain_factor": "number", "force_factor": "number"}
    )
    conservative: ClassVar[bool] = False

    strain_factor: Batch
    force_factor: Batch

    def __init__(self, strain_factor: Values = 1.0, force_factor: Values = 1.0):
        """**Arguments:**

        - `strain_factor`: $f_\\varepsilon$ [-], ideal over measured free strain, positive.
        - `force_factor`: $f_F$ [-], measured over ideal blocked force, positive.

        **Raises:** `ValueError` where a factor isn't positive.
        """
        self.strain_factor = size(strain_factor, "strain_factor")
        self.force_factor = size(force_factor, "force_factor")

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
        P, eps_f = positive(pressure, "pressure", "Pa"), positive(free_strain, "free_strain", "-")
        blocked = positive(blocked_force, "blocked_force", "N")
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
