r"""Post-buckling, the paper's law: how a muscle resists when pushed past its free strain.

Compressed by $x = (\varepsilon - \varepsilon_f) L_0$ from its length $L_{fs}$ at free
strain, the bladder bows out between its clamped ends, $y = \tfrac12 y_{max} (\cos(2\pi z/L) - 1)$
with $L = L_{fs} - x$. If its axis kept its length,

$$y_{max} = \frac{\sqrt{4 x (L_{fs} - x)}}{\pi}, \qquad
  F_b = \frac{4 \pi^2 E I (L_{fs} + x)}{(L_{fs} - x)^3}. \tag{10, 12}$$

The axis shortens by $2l$ (equivalent springs, (13)-(16), closed by (10) with the
shortened arc [R5]). With $\xi = x/L_{fs}$ and $w = 2l/x$,

$$w = \frac{a h}{1 + a h}, \quad a = \frac{F_b}{E A \xi (1 - \xi)}, \quad
  h(w) = \frac{\sqrt{1 - w \xi/(2 - \xi)}}{1 - w \xi}, \quad
  F'_b = E A \xi w \frac{1 - \xi}{1 - \xi w}, \tag{16}$$

and the mesh, which follows the arc, pulls with its force at
$\varepsilon_{arc} = \varepsilon_f + 2l/L_0$. $F'_b$ opposes contraction [R6]:

$$F = F'_{mesh} + F_{bladder}(\varepsilon_f) - F'_b. \tag{27}$$

**Sign:** tension positive. **Valid for** $\varepsilon \ge \varepsilon_f$.
**Assumes** the first mode's shape, small slopes; against the exact elastica (12) is 1.4
times too stiff at $\xi = 0.1$, twice at 0.2. **Source:** Kim, Mazzoleni and Bryant (2021), 3.2.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import jax.numpy as jnp

from .._types import Batch, BatchLike, BoolBatch
from .column import AbstractBuckling, Buckled, Centerline, Column
from .elastica import Elastica
from .fixed_mode import IN_DOMAIN, compression_at_moment, unshortened


class Kim2021(AbstractBuckling):
    """The paper's law: a fixed mode shape and equivalent springs, equations (8)-(16)."""

    name: ClassVar[str] = "kim2021"

    def buckled(self, column: Column, strain: BatchLike) -> Buckled:
        """Forces, deflection and moment at `strain` [-], (16) and (27)."""
        eps_f, EA = column.free_strain, column.axial_stiffness
        xi = (jnp.asarray(strain, dtype=float) - eps_f) / (1 - eps_f)
        bowed = unshortened(_slenderness(column), xi, IN_DOMAIN)
        w = 1 - xi * bowed
        arc = eps_f + xi * w * (1 - eps_f)
        mesh, _ = column.tension.components(column.pressure, arc)
        _, bladder = column.tension.components(column.pressure, eps_f)
        bending = -EA * xi * w * (1 - xi) / (1 - xi * w)
        return Buckled(
            mesh=mesh,
            bladder=jnp.broadcast_to(bladder, mesh.shape),
            bending=bending,
            # (10) with the shortened arc
            deflection=2 / jnp.pi * column.free_length * xi * jnp.sqrt(bowed * (1 - xi)),
            moment=_moment_unit(column) * xi * jnp.sqrt(bowed / (1 - xi) ** 3),
            arc_strain=arc,
            straight=jnp.zeros(mesh.shape, bool),
        )

    def onset(self, column: Column) -> Batch:
        """The free strain [-]: the law lets the bladder bow at once."""
        return column.free_strain

    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which $M_b$ reaches `moment` [N·m]; inf if its peak is lower [R7]."""
        target = jnp.asarray(moment, dtype=float) / _moment_unit(column)
        xi, reached = compression_at_moment(_slenderness(column), target)
        strain = column.free_strain + xi * (1 - column.free_strain)
        return jnp.where(reached, strain, jnp.inf)

    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] of equation (8) [R4] at `strain` [-]."""
        eps = jnp.asarray(strain, dtype=float)
        y_max = self.buckled(column, eps).deflection[..., None]
        along = jnp.linspace(0.0, 1.0, points)
        chord = jnp.asarray(column.rest_length * (1 - eps))[..., None]
        y = y_max / 2 * (jnp.cos(2 * jnp.pi * along) - 1)
        return Centerline(z=jnp.broadcast_to(chord * along, y.shape), y=y)

    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Never: the law gives one state at each strain [-]."""
        shape = jnp.broadcast_shapes(jnp.shape(strain), column.free_strain.shape)
        return jnp.zeros(shape, bool)


def _slenderness(column: Column) -> Batch:
    """$c = EA L_{fs}^2/(4\\pi^2 EI)$ [-]."""
    EA, EI = column.axial_stiffness, column.bending_stiffness
    return EA * column.free_length**2 / (4 * jnp.pi**2 * EI)


def _moment_unit(column: Column) -> Batch:
    """What $\\hat m$ counts, $4\\pi EI/L_{fs}$ [N·m]."""
    return 4 * jnp.pi * column.bending_stiffness / column.free_length


BUCKLING_LAWS: Mapping[str, type[AbstractBuckling]] = MappingProxyType(
    {law.name: law for law in (Kim2021, Elastica)}
)
