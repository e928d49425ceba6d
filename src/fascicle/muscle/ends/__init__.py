r"""Laws of a muscle's ends: an inactive length at the fittings, and compliance under load.

A muscle of length $L_0$ between its fittings may have parts that don't contract, and ends that
yield. Its tension law is that of the bladder, at the bladder's strain $\varepsilon_b$:

$$F(P, \varepsilon) = T(P, \varepsilon_b(P, \varepsilon)). \tag{E7}$$

Of the length $L_0$ the fittings hold $l$ still, and ends, fittings and threads yield by $c F$, as a
spring in series. The bladder of a loaded muscle has contracted more than the muscle:

$$F = T(P, \varepsilon_b), \qquad
  \varepsilon_b = s \Bigl(\varepsilon + \frac{c F}{L_0}\Bigr), \qquad s = \frac{L_0}{L_0 - l}.
  \tag{E8}$$

Where $T$ falls with strain there is one $\varepsilon_b$, between $s \varepsilon$ and
$s (\varepsilon + c\, T(P, s \varepsilon)/L_0)$; where it rises there is still one as long as
$c\, s\, \mathrm{d}T/\mathrm{d}\varepsilon_b < L_0$. The free strain is the bladder's over $s$:
without a force nothing yields. Both are in series with the whole tension law, the
arc of a bowed muscle too; the hinge after collapse is not. With both zero the ends are rigid.

The bladder does the work that the ends take and the spring stores,

$$\Pi^*(P, \varepsilon) = P V(0) + (L_0 - l) \int_0^{\varepsilon_b} T \,\mathrm{d}\varepsilon'
  - \tfrac12 c F^2, \tag{E9}$$

so that the fluid fills $V(0) + (V(\varepsilon_b) - V(0))/s$.

**Sign:** pulling force and contraction positive. **Valid for** strains at which the bladder's own
is in its domain. **Source:** derived here.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...core.array_namespace import maximum, minimum, node_axis, sum_nodes, where
from ...core.parameters import Constant, log1p_scale
from ...core.roots import root
from ...core.types import Batch, BatchLike
from ..law import AbstractLaw, LawRegistry
from ..tension import Pull


if TYPE_CHECKING:
    from ..tuning import PressurizedTension

_FARTHEST = 0.95  # of the bladder's strain: beyond the domain of strains
_NEARLY_STRAIGHT = 0.999  # share of the strain of straight fibers, where the pull has no bound


def integrate_pieces(
    force: Callable[[Batch], Batch], start: Batch, end: Batch, points: int = 16
) -> Batch:
    """Integrals [N] of a `force` [N] between strains `start` and `end` [-] with no kink between,
    by Gauss's rule: 16 `points` leave 1e-11 of an integral, 8 leave 1e-8.
    """
    middle, half = (start + end) / 2, (end - start) / 2
    node, weight = (node_axis(x, middle) for x in np.polynomial.legendre.leggauss(points))
    return half * sum_nodes(weight * force(middle + half * node))


class AbstractEnds(AbstractLaw):
    """Law of a muscle's ends; its methods are those of rigid ends unless a law overrides them.
    `compliance`: of both ends [m/N].
    """

    compliance: ClassVar[Batch] = 0.0

    def strain_ratio(self, length: BatchLike) -> Batch:
        """Bladder's over muscle's strain [-], unloaded; `length` $L_0$ [m]."""
        del length
        return 1.0

    def pull(self, tension: "PressurizedTension", strain: BatchLike) -> Pull:
        """Force and slope [N] at the muscle's `strain` [-], by default the bladder's."""
        return tension.bladder_pull(strain)

    def coenergy_at_rest(self, tension: "PressurizedTension") -> Batch:
        """Co-energy [J] beyond $P V(0)$ at rest; zero unless ends yield."""
        return 0.0 * tension.pressure


class Rigid(AbstractEnds):
    """Ends of no length and no compliance: the bladder's strain is the muscle's."""

    name: ClassVar[str] = "rigid"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021)"


class Compliant(AbstractEnds):
    """An inactive length at the fittings and a spring in series, equation (E8)."""

    name: ClassVar[str] = "compliant"
    source: ClassVar[str] = "derived here"

    inactive_length: Batch = Constant(
        "inactive_length", "l", "length", (0.0, 0.0, 0.1, 1.0), log1p_scale(5e-3), 0.0,
        "part of the length that the fittings hold",
    ).field()  # fmt: skip
    end_compliance: Batch = Constant(
        # ends that give a tenth of a meter per kilonewton are none
        "end_compliance", "c", "axial_compliance", (0.0, 0.0, 1e-4, 1e-2), log1p_scale(1e-5), 0.0,
        "compliance of both ends in series with the bladder",
    ).field()  # fmt: skip

    @property
    def compliance(self) -> Batch:
        """Compliance $c$ of both ends together [m/N]."""
        return self.end_compliance

    def strain_ratio(self, length: BatchLike) -> Batch:
        """Ratio $s$ of the bladder's strain to the muscle's [-] of `length` $L_0$ [m]."""
        return length / (length - self.inactive_length)

    def bladder_strain(self, tension: "PressurizedTension", strain: BatchLike) -> Batch:
        """Strain of the bladder [-], (E8), at the muscle's `strain` [-]."""
        L0, braid = tension.bladder.braid.length, tension.bladder.braid
        s = self.strain_ratio(L0)
        unloaded, rise = s * strain, s * self.end_compliance / L0
        # compliant ends keep fibers from being straight, where a bladder's pull has no bound
        straight = _NEARLY_STRAIGHT * braid.straight_strain
        start = where(rise > 0, maximum(unloaded, straight), unloaded)
        pull = tension.bladder_pull(start)
        # where T falls, the bladder's strain lies between both
        loaded = unloaded + rise * pull.force
        low = minimum(start, maximum(loaded, straight))
        high = maximum(start, minimum(loaded, _FARTHEST))
        # a step of Newton's from there; a bound where T rises too steeply for one
        fall = maximum(1 - rise * pull.slope, 1.0)
        start = minimum(maximum(start + (loaded - start) / fall, low), high)
        return root(_strain_residual, (tension, unloaded, rise), low, high, start)

    def pull(self, tension: "PressurizedTension", strain: BatchLike) -> Pull:
        """Force and slope [N] at the muscle's `strain` [-], by (E8)."""
        L0 = tension.bladder.braid.length
        pull = tension.bladder_pull(self.bladder_strain(tension, strain))
        s = self.strain_ratio(L0)
        # dε_b/dε, from (E8)
        slope = s / (1 - s * self.end_compliance / L0 * pull.slope)
        return Pull(pull.mesh, pull.bladder, slope * pull.mesh_slope, slope * pull.bladder_slope)

    def coenergy_at_rest(self, tension: "PressurizedTension") -> Batch:
        """Co-energy (E9) [J] besides $P V(0)$ at rest length."""
        strain = self.bladder_strain(tension, 0.0 * tension.pressure)

        def force(strain: Batch) -> Batch:
            return tension.bladder_pull(strain).force

        active = tension.bladder.braid.length - self.inactive_length
        work = active * integrate_pieces(force, 0.0 * strain, strain)
        return work - 0.5 * self.end_compliance * force(strain) ** 2


def _strain_residual(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """Strain that the bladder lacks for (E8) [-], and its slope."""
    tension, unloaded, rise = theta
    pull = tension.bladder_pull(strain)
    return unloaded + rise * pull.force - strain, rise * pull.slope - 1


ENDS_LAWS = LawRegistry(AbstractEnds, default="rigid")
__getattr__, __dir__ = ENDS_LAWS.package_attributes()
