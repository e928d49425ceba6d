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
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from .._math import guarded, root
from .._types import Batch, BatchLike
from .bladder import Bladder


Offset = Callable[[Batch], Batch]
NOTHING: Mapping[str, str] = MappingProxyType({})


class AbstractTension(eqx.Module):
    """A tensile force in two components, and the strain at which it vanishes.

    `parameters` are the law's own numbers with their dimensions, as in `units.DIMENSIONS`.
    `conservative`: whether the mesh works as much as the pressure does, $P \\mathrm{d}V$.
    """

    name: eqx.AbstractClassVar[str]
    parameters: eqx.AbstractClassVar[Mapping[str, str]]
    conservative: eqx.AbstractVar[bool]

    @abc.abstractmethod
    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-]. Elementwise."""

    @abc.abstractmethod
    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Strain [-] at which the force equals `offset` of the pressure, $C_1(P)$ [N]."""


class Ideal(AbstractTension):
    """The mesh alone: Chou and Hannaford (1996), no bladder."""

    name: ClassVar[str] = "ideal"
    parameters: ClassVar[Mapping[str, str]] = NOTHING
    conservative: ClassVar[bool] = True

    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh force [N], equation (3), and zero."""
        mesh = bladder.braid.mesh_force(pressure, strain)
        return mesh, jnp.zeros_like(mesh)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The strain [-] where the mesh holds $C_1$ alone; its limit at $P = 0$."""
        P, alpha, r0 = jnp.asarray(pressure, dtype=float), bladder.braid.angle, bladder.braid.radius
        _, at_rest = jax.jvp(offset, (jnp.zeros_like(P),), (jnp.ones_like(P),))
        # C1/P is 0/0 without pressure
        per_pressure = jnp.where(P > 0, offset(P) / guarded(P > 0, P), at_rest)
        held = 1 / jnp.sin(alpha) ** 2 + per_pressure / (jnp.pi * r0**2)
        return 1 - jnp.tan(alpha) * jnp.sqrt(held / 3)


def solved_free_strain(
    law: AbstractTension, bladder: Bladder, pressure: BatchLike, offset: Offset
) -> Batch:
    """The root of $F_{mesh} + F_{bladder} = C_1$ [-], for a `law` with a bladder that resists.

    **Arguments:**

    - `law`: positive below the root, negative above [-].
    - `bladder`: inside its braid [-].
    - `pressure`: gauge pressure $P$ [Pa].
    - `offset`: $C_1$ [N] of the pressure.

    **Returns:** $\\varepsilon_f$ [-]; 0 at $P = 0$.
    """
    P = jnp.asarray(pressure, dtype=float)
    c1 = offset(P)

    def remaining(strain: Batch) -> Batch:
        mesh, wall = law.components(bladder, P, strain)
        return mesh + wall - c1

    # the fibers would be straight at twice `low`; at `high` the mesh pushes hard
    low, high = 0.5 * (1 - 1 / jnp.cos(bladder.braid.angle)), 0.8
    # the parabola that leaves rest as the force does, and meets it where the mesh lets go:
    # its zero comes too early, and Newton's steps from there don't overshoot
    far = bladder.braid.ideal_free_strain
    value, slope = jax.jvp(remaining, (jnp.zeros_like(P),), (jnp.ones_like(P),))
    bend = (remaining(jnp.broadcast_to(far, value.shape)) - value - slope * far) / far**2
    inside = jnp.sqrt(jnp.maximum(slope**2 - 4 * bend * value, 0.0))
    start = jnp.clip(-2 * value / (slope - inside), low, high)
    return root(remaining, low, high, start, steps=3)
