r"""Ends that take some of the length, and give under load.

Of the length $L_0$ the fittings hold $l$ still, and the ends, their fittings and threads give by
$c F$, as a spring in series. A pulled muscle's bladder has contracted more than its ends tell:

$$F = T(P, \varepsilon_b), \qquad
  \varepsilon_b = s \Bigl(\varepsilon + \frac{c F}{L_0}\Bigr), \qquad s = \frac{L_0}{L_0 - l}.
  \tag{E8}$$

Where $T$ falls with strain there is one $\varepsilon_b$, between $s \varepsilon$ and
$s (\varepsilon + c\, T(P, s \varepsilon)/L_0)$; where it rises there is still one as long as
$c\, s\, \mathrm{d}T/\mathrm{d}\varepsilon_b < L_0$. The free strain is the bladder's over $s$:
without a force nothing gives. Both are in series with all that the tension law is asked for, the
arc of a bowed muscle too; the hinge after collapse is not.

Both left out are zero, and the muscle is the one of rigid ends.

The bladder does the work that the ends take and the spring stores,

$$\Pi^*(P, \varepsilon) = P V(0) + (L_0 - l) \int_0^{\varepsilon_b} T \,\mathrm{d}\varepsilon'
  - \tfrac12 c F^2, \tag{E9}$$

so that the fluid fills $V(0) + (V(\varepsilon_b) - V(0))/s$.

**Sign:** pulling force and contraction positive. **Valid for** strains at which the bladder's own
is in its domain. **Source:** derived here.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import maximum, minimum, node_axis, sum_nodes, where
from ...core.parameters import Constant, log1p_scale
from ...core.roots import root
from ...core.types import Batch, BatchLike
from ..tension.tension_law import Pull
from .ends_law import AbstractEnds, Tension


# up to the free strain a force is smooth: 16 points leave 1e-12 of its integral
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_FARTHEST = 0.95  # of the bladder's strain: past all that can be asked for
_NEARLY = 0.999  # of the strain that straightens the fibers


class Compliant(AbstractEnds):
    """An inactive length at the fittings and a spring in series, equation (E8)."""

    name: ClassVar[str] = "compliant"
    source: ClassVar[str] = "derived here"

    inactive_length: Batch = Constant(
        "inactive_length", "l", "length", (0.0, 0.0, 0.1, 1.0), log1p_scale(5e-3), 0.0,
        "of the muscle's length, held still by its fittings",
    ).field()  # fmt: skip
    end_compliance: Batch = Constant(
        # ends that give a tenth of a meter per kilonewton are none
        "end_compliance", "c", "axial_compliance", (0.0, 0.0, 1e-4, 1e-2), log1p_scale(1e-5), 0.0,
        "of both ends in series with the bladder",
    ).field()  # fmt: skip

    @property
    def compliance(self) -> Batch:
        """$c$ [m/N]."""
        return self.end_compliance

    def stretch(self, length: BatchLike) -> Batch:
        """$s$ [-] of a muscle of `length` $L_0$ [m]."""
        return length / (length - self.inactive_length)

    def bladder_strain(self, tension: Tension, pressure: BatchLike, strain: BatchLike) -> Batch:
        """$\\varepsilon_b$ [-], (E8), of a `tension` law [-] at `pressure` [Pa] and the ends'
        `strain` [-].
        """
        L0, braid = tension.bladder.braid.length, tension.bladder.braid
        s = self.stretch(L0)
        unloaded = s * strain
        given = s * self.end_compliance / L0
        theta = (tension, pressure, unloaded, given)
        # ends that give keep fibers from being straight, where a bladder's pull has no bound
        begin = where(given > 0, maximum(unloaded, _NEARLY * braid.straight), unloaded)
        # where T falls, the bladder's strain lies between both
        most = unloaded + given * tension.bladder_pull(pressure, begin).force
        low = minimum(begin, maximum(most, _NEARLY * braid.straight))
        high = maximum(begin, minimum(most, _FARTHEST))
        return root(_apart, theta, low, high, begin)

    def pull(self, tension: Tension, pressure: BatchLike, strain: BatchLike) -> Pull:
        """What the `tension` law [-] says [N] at `pressure` [Pa] and the ends' `strain` [-]."""
        L0 = tension.bladder.braid.length
        at = tension.bladder_pull(pressure, self.bladder_strain(tension, pressure, strain))
        s = self.stretch(L0)
        # dε_b/dε, from (E8)
        share = s / (1 - s * self.end_compliance / L0 * at.slope)
        return Pull(at.mesh, at.bladder, share * at.mesh_slope, share * at.bladder_slope)

    def coenergy_at_rest(self, tension: Tension, pressure: BatchLike) -> Batch:
        """(E9) at rest length [J] and `pressure` [Pa], less $P V(0)$."""
        strain = self.bladder_strain(tension, pressure, 0.0 * pressure)
        node, weight = (node_axis(x, strain) for x in (_NODES, _WEIGHTS))
        force = tension.bladder_pull(pressure, 0.5 * strain * (1 + node)).force
        work = 0.5 * strain * sum_nodes(weight * force)
        F = tension.bladder_pull(pressure, strain).force
        active = tension.bladder.braid.length - self.inactive_length
        return active * work - 0.5 * self.end_compliance * F**2


def _apart(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """By how much the bladder has contracted less than (E8) says [-], and its slope."""
    tension, pressure, unloaded, given = theta
    pull = tension.bladder_pull(pressure, strain)
    return unloaded + given * pull.force - strain, given * pull.slope - 1
