r"""What a tension law is, and the simplest one: the mesh alone.

A law $T(P, \varepsilon)$ gives a muscle's pull in two components, of the pressurized mesh
and of the bladder, and finds the strain at which it vanishes, also where an offset force
$C_1(P)$ is taken off, as the tuning of section 5 does: $T(P, \varepsilon_f) = C_1(P)$.

`Ideal` has no bladder. Its force is proportional to pressure,

$$T = \pi r_0^2 P \left(a (1 - \varepsilon)^2 - b\right), \qquad
  a = \frac{3}{\tan^2\alpha_0}, \qquad b = \frac{1}{\sin^2\alpha_0}, \tag{3}$$

so that its free strain $1 - \sqrt{b/a} = 1 - 1/(\sqrt3 \cos\alpha_0)$ doesn't depend on it.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996).
"""

import abc
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import ClassVar, NamedTuple

import equinox as eqx
import numpy as np

from .._arrays import cos, maximum, minimum, sqrt, where
from .._math import root
from .._methods import Module
from .._types import Batch, BatchLike
from .bladder import Bladder


Offset = Callable[[Batch], Batch]
NOTHING: Mapping[str, str] = MappingProxyType({})
_A_LITTLE = 1e-3  # Pa: what a force over pressure tends to at none, seen from here


class Pull(NamedTuple):
    """A tensile force in its two components, with their slopes in strain, all [N]."""

    mesh: Batch
    bladder: Batch
    mesh_slope: Batch
    bladder_slope: Batch

    @property
    def force(self) -> Batch:
        """Both together [N]."""
        return self.mesh + self.bladder

    @property
    def slope(self) -> Batch:
        """Its slope in strain [N]."""
        return self.mesh_slope + self.bladder_slope


class AbstractTension(Module):
    """A tensile force in two components, and the strain at which it vanishes.

    `parameters` are the law's own numbers with their dimensions, as in `units.DIMENSIONS`.
    `conservative`: whether the mesh works as much as the pressure does, $P \\mathrm{d}V$.
    """

    name: eqx.AbstractClassVar[str]
    parameters: eqx.AbstractClassVar[Mapping[str, str]]
    conservative: eqx.AbstractVar[bool]

    @abc.abstractmethod
    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], with slopes."""

    @abc.abstractmethod
    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Strain [-] at which the force equals `offset` of the pressure, $C_1(P)$ [N]."""

    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-]. Elementwise."""
        pull = self.pull(bladder, pressure, strain)
        return pull.mesh, pull.bladder


class Ideal(AbstractTension):
    """The mesh alone: Chou and Hannaford (1996), no bladder."""

    name: ClassVar[str] = "ideal"
    parameters: ClassVar[Mapping[str, str]] = NOTHING
    conservative: ClassVar[bool] = True

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh force [N], equation (3), and zero."""
        mesh, slope = bladder.braid.mesh(pressure, strain)
        return Pull(mesh, 0.0 * mesh, slope, 0.0 * slope)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The strain [-] where the mesh holds $C_1$ alone; its limit at $P = 0$."""
        cot2, r0 = bladder.braid.cot2, bladder.braid.radius
        P = where(pressure > 0, pressure, _A_LITTLE)  # C1/P is 0/0 without pressure
        held = 1 + cot2 + offset(P) / (np.pi * r0**2 * P)
        return 1 - sqrt(held / (3 * cot2))


def solved_free_strain(
    law: AbstractTension, bladder: Bladder, pressure: BatchLike, offset: Offset
) -> Batch:
    """The first root of $F_{mesh} + F_{bladder} = C_1$ [-], for a `law` with a bladder.

    **Arguments:**

    - `law`: positive below the root [-].
    - `bladder`: inside its braid [-].
    - `pressure`: gauge pressure $P$ [Pa].
    - `offset`: $C_1$ [N] of the pressure.

    **Returns:** $\\varepsilon_f$ [-]; 0 at $P = 0$.
    """
    theta = (law, bladder, pressure, offset(pressure))
    # the fibers would be straight at twice `low`; at `high` the mesh pushes hard
    low, high = 0.5 * (1 - 1 / cos(bladder.braid.angle)), 0.8
    # the parabola that leaves rest as the force does, and meets it where the mesh lets go:
    # its zero comes too early, and Newton's steps from there don't overshoot
    far = bladder.braid.ideal_free_strain
    value, slope = _remaining(theta, 0.0 * pressure)
    bend = (_remaining(theta, far)[0] - value - slope * far) / far**2
    inside = sqrt(maximum(slope**2 - 4 * bend * value, 0.0))
    start = minimum(maximum(-2 * value / (slope - inside), low), high)
    return root(_remaining, theta, low, high, start)


def _remaining(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """What is left of the force [N] after $C_1$, and its slope [N]."""
    law, bladder, pressure, c1 = theta
    pull = law.pull(bladder, pressure, strain)
    return pull.force - c1, pull.slope
