r"""A braid whose fibers stretch, around a hyperelastic bladder.

A fiber that bears the tension $T_f$ is $b (1 + T_f/EA)$ long. With $u$ the fibers' strain, all $n$
of them alike, the length alone doesn't determine the braid's radius,

$$\frac{r^2}{r_0^2} = \frac{(1 + u)^2 - \cos^2\alpha_0 \lambda^2}{\sin^2\alpha_0}, \tag{EB1}$$

and the muscle takes the $u$ at which its potential is least,

$$\Pi(P, \varepsilon) = \min_u \left[\tfrac12 k_f \pi r_0^2 \frac{L_0}{\cos\alpha_0} u^2
  + V_b W(\lambda^2, r^2/r_0^2) - P \pi r^2 L\right], \qquad
  k_f = \frac{n EA}{\pi r_0^2}, \qquad
  T = -\frac{1}{L_0} \frac{\partial \Pi}{\partial\varepsilon}. \tag{EB2}$$

Where $\Pi$ is stationary in $u$ it is least: its second derivative there is
$k_f \pi r_0^2 L_0/(\cos\alpha_0 (1 + u))$ and what the wall adds, positive, so that there is one
such $u$ at most. It moves the energy no further: the force is that of (3) and (4) at this $u$.
As $k_f \to \infty$ it is `klute_hannaford`, to the bit.

**Held fibers:** Hooke's fiber runs away at a pressure of some $k_f \tan\alpha_0 \sin\alpha_0/2$,
and a braid that has come to $1 + u = \sqrt3 \cos\alpha_0$ at rest length contracts no more. Fibers
are held half-way there, $1 + u \le (1 + \sqrt3 \cos\alpha_0)/2$, 1.226 at 33 deg. A muscle that
comes so far at rest length below 1 MPa warns as it is made, and says at which pressure.

**Sign:** pull and contraction positive; $u$ is negative where the bladder draws the braid in.
**Assumes** fibers that are Hooke's, in push as in pull (as those that can't stretch are), and
free of friction. **Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** derived here; that fibers of soft braids stretch, and what it costs: Chambers and
Wereley (2022).
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import cos, logical_not, minimum, sqrt, where
from ...core.parameters import POSITIVE, Constant
from ...core.roots import guarded, root
from ...core.types import Batch, BatchLike, BoolBatch, Values
from ...core.validation import check_positive
from ..bladder import Bladder
from ..braid import Braid
from ..materials import Slopes
from . import SIZES, AbstractTension, Pull


class ElasticBraid(AbstractTension):
    """Stretching fibers and a hyperelastic bladder, equation (EB2)."""

    name: ClassVar[str] = "elastic_braid"
    title: ClassVar[str] = "Elastic braid"
    source: ClassVar[str] = "derived here; Chambers and Wereley (2022)"
    conservative: ClassVar[bool] = False  # of the unstretched braid's volume
    stretches: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = ("fiber_stiffness", "c10", "c01", *SIZES)

    fiber_stiffness: Batch = Constant(
        # soft nylon braids are some 20 MPa, aramid ones some GPa; no double feels the largest
        "fiber_stiffness",
        "k_f",
        "pressure",
        (1e5, 1e7, 1e11, 1e300),
        POSITIVE,
        1e9,
        "stiffness of all fibers, EA times their number, over the section inside the braid at rest",
    ).field()

    @classmethod
    def from_fibers(cls, braid: Braid, stiffness: Values, count: Values = 1) -> "ElasticBraid":
        """Law of a `braid` from a fiber's `stiffness` $EA$ [N], its tension over strain, and the
        `count` $n$ [-] of fibers in both directions together.
        """
        EA = check_positive(stiffness, "stiffness", "N")
        n = check_positive(count, "count", "-")
        return cls(n * EA / (np.pi * braid.radius**2))

    def fiber_strain(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Strain of the fibers $u$ [-] at `pressure` [Pa] and `strain` [-]."""
        return self._solve(bladder, pressure, strain)[0]

    def radius(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Outer radius of the straight muscle [m] at `pressure` [Pa] and `strain` [-], (EB1)."""
        u = self.fiber_strain(bladder, pressure, strain)
        return bladder.braid.radius * sqrt(_swell(bladder.braid, strain, u))

    def potential(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Potential $\\Pi$ [J] at `pressure` [Pa] and `strain` [-], (EB2)."""
        braid, u = bladder.braid, self.fiber_strain(bladder, pressure, strain)
        q, lam = _swell(braid, strain, u), 1 - strain
        bore = np.pi * braid.radius**2 * braid.length
        fibers = 0.5 * self.fiber_stiffness / cos(braid.angle) * u**2
        wall = bladder.volume * bladder.material.energy(lam**2, q)
        return bore * (fibers - pressure * q * lam) + wall

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] with slopes, (3) and (4) at the fibers' stretch."""
        braid, lam, ratio = bladder.braid, 1 - strain, _section_ratio(bladder)
        u, W, limited = self._solve(bladder, pressure, strain)
        cot2, q_slope = braid.cot2, 2 * (1 + braid.cot2) * (1 + u)  # dq/du
        # the least energy moves with the strain: its slope in u stays zero
        c = self._compliance(braid)
        load = pressure * lam - ratio * W.q
        by_strain = -pressure + 2 * lam * ratio * (W.pq - cot2 * W.qq)
        by_u = 1 - c * load + c * (1 + u) * ratio * W.qq * q_slope
        u_slope = where(limited, 0.0, c * (1 + u) * by_strain / by_u)

        mesh, mesh_slope = braid.mesh(pressure, strain)
        wall, wall_slope = bladder.pull(strain, W)
        pull, q_change = np.pi * braid.radius**2 * pressure, q_slope * u_slope
        return Pull(
            mesh=mesh - pull * (1 + cot2) * u * (2 + u),
            bladder=wall,
            mesh_slope=mesh_slope - pull * q_change,
            bladder_slope=wall_slope + 2 * bladder.area * lam * (W.pq - cot2 * W.qq) * q_change,
        )

    def rest_coenergy(self, bladder: Bladder, pressure: BatchLike) -> Batch:
        """Co-energy less $P V(0)$ [J] at rest length and `pressure` [Pa]."""
        zero = 0.0 * pressure
        return -self.potential(bladder, pressure, zero) - pressure * bladder.braid.volume(zero)

    def highest_pressure(self, bladder: Bladder) -> Batch:
        """Pressure [Pa] up to which fibers around the `bladder` stretch freely at rest length."""
        u = _largest_stretch(bladder.braid)
        W = bladder.material.slopes(1.0, _swell(bladder.braid, 0.0, u))
        return u / (1 + u) / self._compliance(bladder.braid) + _section_ratio(bladder) * W.q

    def _compliance(self, braid: Braid) -> Batch:
        """Slope of the fibers' strain in the pressure on them [1/Pa]."""
        return 2 * cos(braid.angle) * (1 + braid.cot2) / self.fiber_stiffness

    def _solve(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Slopes, BoolBatch]:
        """Fibers' strain $u$ [-], the rubber's slopes [J/m³], and true where $u$ is limited."""
        braid, c, lam = bladder.braid, self._compliance(bladder.braid), 1 - strain
        top = _largest_stretch(braid) + 0.0 * lam
        limited = _stretch_residual((bladder, c, pressure, strain), top)[0] > 0
        P = guarded(logical_not(limited), pressure, 0.0)
        # a braid whose fibers shrink more has no room inside
        low = cos(braid.angle) * lam - 1
        ideal = c * P * lam
        start = minimum(ideal / (1 + ideal), top)
        u = root(_stretch_residual, (bladder, c, P, strain), low, top, start)
        u = where(limited, top, u)
        return u, bladder.material.slopes(lam**2, _swell(braid, strain, u)), limited


def _largest_stretch(braid: Braid) -> Batch:
    """Limit of the fibers' strain [-]: half-way to a braid that doesn't contract."""
    return 0.5 * (np.sqrt(3) * cos(braid.angle) - 1)


def _section_ratio(bladder: Bladder) -> Batch:
    """Section of the wall over that inside the braid, at rest [-]."""
    return bladder.area / (np.pi * bladder.braid.radius**2)


def _swell(braid: Braid, strain: BatchLike, u: BatchLike) -> Batch:
    """Square of $r/r_0$ [-] at `strain` [-] and a fibers' strain `u` [-], (EB1)."""
    return braid.squared_stretch(strain) + (1 + braid.cot2) * u * (2 + u)


def _stretch_residual(theta: tuple, u: Batch) -> tuple[Batch, Batch]:
    """Residual of the fibers' strain `u` [-], and its slope."""
    bladder, c, pressure, strain = theta
    braid, lam, ratio = bladder.braid, 1 - strain, _section_ratio(bladder)
    W = bladder.material.slopes(lam**2, _swell(braid, strain, u))
    load = pressure * lam - ratio * W.q
    stiffening = 2 * (1 + braid.cot2) * (1 + u) ** 2 * ratio * W.qq
    return c * (1 + u) * load - u, c * load - c * stiffening - 1
