r"""The piecewise law that joins tension, buckling and collapse.

$$F(P, \varepsilon) = \begin{cases}
  T(P, \varepsilon)
    & \varepsilon \le \varepsilon_f(P) \\
  F'_{mesh} + F_{bladder}(\varepsilon_f) - F'_b
    & \varepsilon_f < \varepsilon \le \varepsilon_c(P) \\
  -F_c + (F(\varepsilon_c) + F_c) e^{-\beta (\varepsilon - \varepsilon_c)}
    & \varepsilon > \varepsilon_c(P)
\end{cases} \tag{27}$$

with the free strain $\varepsilon_f$, where the force vanishes, and the collapse strain
$\varepsilon_c$, where the buckled bladder's moment first reaches $M_{collapse}$. The middle
line is the paper's; another buckling law puts its own there. The force is continuous
[R12]; its slope jumps at both strains, which is physics. Both strains depend on pressure
alone, and are solved for at the pressure's own shape, before strain broadcasts.

**Components:** after collapse mesh and bladder force keep their values at $\varepsilon_c$
times the same exponential, and bending is the rest.
**Sign:** pulling force and contraction positive, gauge pressure. **Valid for**
$0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Kim, Mazzoleni and Bryant (2021), (26) and (27).
"""

import equinox as eqx
import jax.numpy as jnp

from .._math import guarded
from .._types import Batch, BoolBatch, IntBatch
from .collapse import AbstractCollapse, AbstractPostCollapse, hinge_moment
from .column import ROUNDING, AbstractBuckling, Buckled, Centerline, Column
from .entry import LARGEST_STRAIN
from .tuning import TunedTension


TENSION, POST_BUCKLING, POST_COLLAPSE, STRAIGHT = 0, 1, 2, 3


class Response(eqx.Module):
    """What a muscle does at a pressure and strain; all of one shape.

    `force` = `mesh` + `bladder` + `bending`, all [N]. `region`: 0 tension, 1 post-buckling,
    2 post-collapse, 3 straight compression. `several`: other equilibria exist there too.
    """

    force: Batch
    mesh: Batch
    bladder: Batch
    bending: Batch
    region: IntBatch
    several: BoolBatch


class Piecewise(eqx.Module):
    """Equation (27) for one choice of laws; `at` a pressure it can be evaluated."""

    tension: TunedTension
    buckling: AbstractBuckling
    collapse: AbstractCollapse
    post_collapse: AbstractPostCollapse
    transition_rate: Batch

    @property
    def youngs_modulus(self) -> Batch:
        """$E$ [Pa] with its factor, as bending, collapse and hinge see it."""
        factor = self.tension.tuning.youngs_modulus_factor
        return self.tension.bladder.material.youngs_modulus * factor

    @property
    def rate(self) -> Batch:
        r"""$\beta$ [-]: the tuning's where it has one."""
        tuned = self.tension.tuning.transition_rate
        return self.transition_rate if tuned is None else tuned

    def collapse_moment(self, pressure: Batch) -> Batch:
        """$M_{collapse}$ [N·m] with its factor at `pressure` [Pa]."""
        moment = self.collapse.moment(self.tension.bladder, self.youngs_modulus, pressure)
        return self.tension.tuning.collapse_moment_factor * moment

    def at(self, pressure: Batch) -> "Pressurized":
        """The muscle at `pressure` [Pa], its free and collapse strain solved for."""
        E, bladder = self.youngs_modulus, self.tension.bladder
        column = Column(
            tension=self.tension,
            pressure=pressure,
            free_strain=self.tension.free_strain(pressure),
            bending_stiffness=E * bladder.second_moment,
            axial_stiffness=E * bladder.area,
        )
        stiffness = self.tension.tuning.hinge_stiffness_at(pressure)
        return Pressurized(
            law=self,
            column=column,
            hinge=stiffness * hinge_moment(bladder, E),
            collapse=self.buckling.strain_at_moment(column, self.collapse_moment(pressure)),
        )


class Pressurized(eqx.Module):
    """A muscle at one pressure: elementwise in strain. `hinge` is $M_h$ [N·m]."""

    law: Piecewise
    column: Column
    hinge: Batch
    collapse: Batch

    @property
    def kinks(self) -> Batch:
        """Free strain, onset of buckling and collapse strain [-], on a new first axis."""
        onset = self.law.buckling.onset(self.column)
        return jnp.stack([self.column.free_strain, onset, self.collapse])

    def response(self, strain: Batch) -> Response:
        """Force and components [N] at `strain` [-], (26) and (27)."""
        eps_f, eps_c, rate = self.column.free_strain, self.collapse, self.law.rate
        pulled, collapsed, buckled = self._state(strain)
        pull_mesh, pull_bladder = self.column.tension.components(
            self.column.pressure, jnp.where(pulled, strain, eps_f)
        )
        past = jnp.where(collapsed, strain - guarded(collapsed, eps_c), 0.0)
        gone = -jnp.expm1(-rate * past)  # nothing has decayed before collapse
        hinged = self.law.post_collapse.force(self.column, self.hinge, _safe(collapsed, strain))
        F_c = jnp.where(collapsed, hinged, 0.0)

        mesh = jnp.where(pulled, pull_mesh, buckled.mesh * (1 - gone))
        bladder = jnp.where(pulled, pull_bladder, buckled.bladder * (1 - gone))
        bending = jnp.where(pulled, 0.0, buckled.bending * (1 - gone) - F_c * gone)
        bowed = jnp.where(buckled.straight, STRAIGHT, POST_BUCKLING)
        region = jnp.where(pulled, TENSION, jnp.where(collapsed, POST_COLLAPSE, bowed))
        several = self.law.buckling.several(self.column, strain) & ~collapsed & ~pulled
        return Response(mesh + bladder + bending, mesh, bladder, bending, region, several)

    def deflection(self, strain: Batch) -> Batch:
        """How far the axis bows out [m] at `strain` [-]."""
        pulled, collapsed, buckled = self._state(strain)
        hinged = self.law.post_collapse.deflection(self.column, _safe(collapsed, strain))
        return jnp.where(pulled, 0.0, jnp.where(collapsed, hinged, buckled.deflection))

    def moment(self, strain: Batch) -> Batch:
        """Largest moment [N·m] at `strain` [-]."""
        pulled, collapsed, buckled = self._state(strain)
        return jnp.where(pulled, 0.0, jnp.where(collapsed, self.hinge, buckled.moment))

    def shape(self, strain: Batch, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], points on a new last axis."""
        pulled, collapsed, _ = self._state(strain)
        strain = jnp.broadcast_to(strain, pulled.shape)
        held = jnp.where(pulled | collapsed, self.column.free_strain, strain)
        bowed = self.law.buckling.shape(self.column, held, points)
        hinged = self.law.post_collapse.shape(self.column, _safe(collapsed, strain), points)
        chord = (self.column.rest_length * (1 - strain))[..., None]
        straight = chord * jnp.linspace(0.0, 1.0, points)
        pulled, collapsed = pulled[..., None], collapsed[..., None]
        return Centerline(
            z=jnp.where(pulled, straight, jnp.where(collapsed, hinged.z, bowed.z)),
            y=jnp.where(pulled, 0.0, jnp.where(collapsed, hinged.y, bowed.y)),
        )

    def _state(self, strain: Batch) -> tuple[BoolBatch, BoolBatch, Buckled]:
        """Whether pulled, whether collapsed, and the buckled state, held at collapse."""
        eps_f, eps_c = self.column.free_strain, self.collapse
        pulled, collapsed = strain <= eps_f + ROUNDING, strain > eps_c + ROUNDING
        held = jnp.where(pulled, eps_f, jnp.where(collapsed, eps_c, strain))
        return pulled, collapsed, self.law.buckling.buckled(self.column, held)


def _safe(collapsed: BoolBatch, strain: Batch) -> Batch:
    """A strain [-] at which the hinged shape exists, also where it isn't asked for."""
    return guarded(collapsed, strain, LARGEST_STRAIN)
