r"""Braid kinematics, enclosed volume, and the mesh force of a McKibben muscle.

Braid fibers can't stretch. A fiber that lies at $\alpha_0$ from the axis at rest turns
as the muscle of length $L = \lambda L_0$, $\lambda = 1 - \varepsilon$, shortens, and the
radius follows it:

$$r(\varepsilon) = r_0 \frac{\sqrt{1 - \cos^2\alpha_0 \lambda^2}}{\sin\alpha_0}. \tag{2}$$

The volume inside is the potential of the pressure,

$$V(\varepsilon) = \pi r^2 L, \tag{V}$$

and virtual work gives the tension that the pressurized mesh holds,

$$F_{mesh} = -P \frac{\mathrm{d}V}{\mathrm{d}L}. \tag{3}$$

**Sign:** tension and contraction are positive. **Valid for**
$1 - 1/\cos\alpha_0 < \varepsilon < 1$: at the lower end the fibers are straight.
**Assumes** inextensible, frictionless, thin fibers and a cylinder right to its ends.
**Source:** Chou and Hannaford (1996); Kim, Mazzoleni and Bryant (2021), (1)-(3). (3) is
printed there without the factor 3 of $3\lambda^2/\tan^2\alpha_0$ [R1]: see the theory pages.
"""

import equinox as eqx
import jax
import jax.numpy as jnp

from .._types import Batch, BatchLike


class Braid(eqx.Module):
    """The ideal braid: every fiber a perfect helix on a cylinder."""

    length: Batch
    radius: Batch
    angle: Batch

    def swell(self, strain: BatchLike) -> Batch:
        """Square of the radial stretch, $(r/r_0)^2$ [-], at `strain` [-], from (2)."""
        eps, alpha = jnp.asarray(strain, dtype=float), self.angle
        # cos² and sin² taken together: exactly 1 at rest, where forces must vanish
        return 1 + eps * (2 - eps) / jnp.tan(alpha) ** 2

    def radius_at(self, strain: BatchLike) -> Batch:
        """Radius $r$ [m] at `strain` $\\varepsilon$ [-], equation (2)."""
        return self.radius * jnp.sqrt(self.swell(strain))

    def angle_at(self, strain: BatchLike) -> Batch:
        """Braid angle $\\alpha$ [rad] at `strain` [-]: $\\cos\\alpha = \\lambda\\cos\\alpha_0$."""
        return jnp.arccos((1 - jnp.asarray(strain, dtype=float)) * jnp.cos(self.angle))

    def volume(self, strain: BatchLike) -> Batch:
        """Volume $V$ [m³] inside the braid at `strain` [-]: a cubic, smooth everywhere."""
        L = self.length * (1 - jnp.asarray(strain, dtype=float))
        return jnp.pi * self.radius**2 * self.swell(strain) * L

    def mesh_force(self, pressure: BatchLike, strain: BatchLike) -> Batch:
        """Tension of the pressurized braid, equation (3).

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa].
        - `strain`: contraction $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** tension $F_{mesh}$ [N], positive when the muscle pulls.
        """
        P, eps = jnp.asarray(pressure, dtype=float), jnp.asarray(strain, dtype=float)
        _, dV_deps = jax.jvp(self.volume, (eps,), (jnp.ones_like(eps),))
        return P * dV_deps / self.length  # dL = −L0 dε

    @property
    def ideal_free_strain(self) -> Batch:
        """Strain [-] at which the mesh force vanishes: fibers at 54.7356°, V largest."""
        return 1 - 1 / (jnp.sqrt(3) * jnp.cos(self.angle))
