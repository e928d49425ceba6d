r"""Tension laws: a pull in two components, and the strain at which it vanishes.

A law $T(P, \varepsilon)$ gives a muscle's pull in two components, of the pressurized mesh
and of the bladder,

$$T(P, \varepsilon) = F_{mesh}(P, \varepsilon) + F_{bladder}(\varepsilon), \tag{4}$$

and finds the strain at which it vanishes, also where an offset force $C_1(P)$ is taken off, as
the tuning of section 5 does: $T(P, \varepsilon_f) = C_1(P)$. Past the free strain $T$ goes on as
compression, of which buckling laws tell what is real.

The default law has both, so that its free strain, the root of $T$, rises with pressure from zero;
of braids below some 11.5 deg it may fall again. The simplest law is the mesh alone,

$$T = \pi r_0^2 P \left(a (1 - \varepsilon)^2 - b\right), \qquad
  a = \frac{3}{\tan^2\alpha_0}, \qquad b = \frac{1}{\sin^2\alpha_0}, \tag{3}$$

so that its free strain $1 - \sqrt{b/a} = 1 - 1/(\sqrt3 \cos\alpha_0)$ doesn't depend on pressure.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996); Klute and Hannaford (2000); Kim, Mazzoleni and
Bryant (2021), section 2.
"""

import abc
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np

from ...core.array_namespace import array_namespace, sqrt, where
from ...core.roots import root
from ...core.types import Batch, BatchLike
from ...core.validation import HIGHEST_PRESSURE
from ..bladder import Bladder
from ..law import AbstractLaw, LawRegistry


Offset = Callable[[Batch], Batch]
# Pa: C1/P of lower pressures is taken here, lest subnormal ones divide 0 by 0. C1 is proportional
# to pressure up to the tuning's first row, so that the ratio is equal
LEAST_PRESSURE = 1e-3
SIZES = ("braid_angle", "outer_radius")  # least accurately measured, and what the mesh depends on


class Pull(NamedTuple):
    """A tensile force in its components, with their slopes in strain, all [N]."""

    mesh: Batch
    bladder: Batch
    mesh_slope: Batch
    bladder_slope: Batch

    @property
    def force(self) -> Batch:
        """Sum of both components [N]."""
        return self.mesh + self.bladder

    @property
    def slope(self) -> Batch:
        """Slope of the force in strain [N]."""
        return self.mesh_slope + self.bladder_slope


class AbstractTension(AbstractLaw):
    """Law of a tensile force in two components, and of the strain at which it vanishes.

    `conservative`: true if the mesh works as much as the pressure does, $P \\mathrm{d}V$.
    `linear_in_pressure`: true if the force is, so that it is largest at an end of any range.
    `stretches`: true if the braid does, so that a braid at rest takes up co-energy.
    `free`: default parameters of a fit: constants of the law or the rubber, or sizes.
    `reference_muscle`: the muscle of its published constants; empty for a law of any muscle.
    `reference_diameter` and `reference_length`: nominal ones of that muscle [m], if published.
    """

    conservative: ClassVar[bool]
    linear_in_pressure: ClassVar[bool] = False
    stretches: ClassVar[bool] = False
    free: ClassVar[tuple[str, ...]] = ()
    reference_muscle: ClassVar[str] = ""
    reference_diameter: ClassVar[float | None] = None
    reference_length: ClassVar[float | None] = None

    @classmethod
    def fit_parameters(cls) -> tuple[str, ...]:
        """Names of the parameters that a fit of the law adjusts by default."""
        constants = (c.name for c in cls.constants() if c.transform is not None)
        return cls.free or (*constants, *SIZES)

    @abc.abstractmethod
    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], with slopes."""

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """First strain [-] at which the force equals $C_1(P)$ [N], the function `offset`."""
        return solved_free_strain(self, bladder, pressure, offset)

    def rest_coenergy(self, bladder: Bladder, pressure: BatchLike) -> Batch:
        """Co-energy less $P V(0)$ [J] at rest and `pressure` [Pa]; zero unless it `stretches`."""
        return 0.0 * pressure * bladder.braid.length

    def highest_pressure(self, bladder: Bladder) -> Batch:
        """Highest pressure [Pa] at which the law is valid with a `bladder`, by default 1 MPa."""
        return HIGHEST_PRESSURE + 0.0 * bladder.braid.length

    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], without slopes."""
        return self.pull(bladder, pressure, strain)[:2]


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
        """Strain [-] at which the mesh holds $C_1$ alone; its limit at $P = 0$."""
        cot2, r0 = bladder.braid.cot2, bladder.braid.radius
        P = where(pressure > LEAST_PRESSURE, pressure, LEAST_PRESSURE)
        return 1 - sqrt((1 + cot2 + offset(P) / (np.pi * r0**2 * P)) / (3 * cot2))


def solved_free_strain(
    law: AbstractTension, bladder: Bladder, pressure: BatchLike, offset: Offset
) -> Batch:
    """First strain [-] of $F_{mesh} + F_{bladder} = C_1$ at `pressure` [Pa], for a `law` that pulls
    below it; `offset`: function $C_1$ of the pressure [N].
    """
    theta = (law, bladder, pressure, offset(pressure))
    # the fibers would be straight at twice `low`; at `high` the mesh pushes hard
    low, high = 0.5 * bladder.braid.straight_strain, 0.8
    # start at the zero of the parabola that leaves rest as the force does, and equals it where the
    # mesh force vanishes: it comes too early, and Newton's steps from there don't overshoot
    far = bladder.braid.ideal_free_strain
    value, slope = force_residual(theta, 0.0 * pressure)
    bend = (force_residual(theta, far)[0] - value - slope * far) / far**2
    xp = array_namespace(value, bend, low)
    inside = xp.sqrt(xp.maximum(slope**2 - 4 * bend * value, 0.0))
    start = xp.minimum(xp.maximum(-2 * value / (slope - inside), low), high)
    return root(force_residual, theta, low, high, start)


def force_residual(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """Force [N] beyond $C_1$ at `strain` [-], and its slope [N]."""
    law, bladder, pressure, c1 = theta
    mesh, wall, mesh_slope, wall_slope = law.pull(bladder, pressure, strain)
    return mesh + wall - c1, mesh_slope + wall_slope


TENSION_LAWS = LawRegistry(AbstractTension, default="klute_hannaford")
__getattr__, __dir__ = TENSION_LAWS.package_attributes()
