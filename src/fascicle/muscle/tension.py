r"""Tension laws: the pull of a muscle up to its free strain, in its two components.

$$T(P, \varepsilon) = F_{mesh}(P, \varepsilon) + F_{bladder}(\varepsilon). \tag{4}$$

`KluteHannaford` keeps both terms, so that the free strain, the root of $T$, rises with
pressure from zero; `Ideal` keeps the mesh alone, and its free strain
$1 - 1/(\sqrt3 \cos\alpha_0)$ doesn't depend on pressure. Past the free strain $T$ goes on
as compression: buckling laws say what of it is real.

Each finds its own free strain, also where an offset force $C_1(P)$ is taken off, as the
tuning of section 5 does: $T(P, \varepsilon_f) = C_1(P)$.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Chou and Hannaford (1996); Klute and Hannaford (2000); Kim, Mazzoleni and
Bryant (2021), section 2.
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


class AbstractTension(eqx.Module):
    """A tensile force in two components, and the strain at which it vanishes."""

    name: eqx.AbstractClassVar[str]

    @abc.abstractmethod
    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-]. Elementwise."""

    @abc.abstractmethod
    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Strain [-] at which the force equals `offset` of the pressure, $C_1(P)$ [N]."""


class KluteHannaford(AbstractTension):
    """Mesh and hyperelastic bladder: Klute and Hannaford (2000)."""

    name: ClassVar[str] = "klute_hannaford"

    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N], equations (3) and (4)."""
        return bladder.braid.mesh_force(pressure, strain), bladder.force(strain)

    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """The root of $F_{mesh} + F_{bladder} = C_1$ [-]; 0 at $P = 0$, rising with $P$."""
        P = jnp.asarray(pressure, dtype=float)
        c1 = offset(P)

        def remaining(strain: Batch) -> Batch:
            mesh, wall = self.components(bladder, P, strain)
            return mesh + wall - c1

        # the fibers would be straight at twice `low`; at `high` the mesh pushes hard
        low, high = 0.5 * (1 - 1 / jnp.cos(bladder.braid.angle)), 0.8
        return root(remaining, low, high, start=jnp.zeros_like(P))


class Ideal(AbstractTension):
    """The mesh alone: Chou and Hannaford (1996), no bladder."""

    name: ClassVar[str] = "ideal"

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


TENSION_LAWS: Mapping[str, type[AbstractTension]] = MappingProxyType(
    {law.name: law for law in (KluteHannaford, Ideal)}
)
