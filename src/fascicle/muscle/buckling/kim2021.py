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

from typing import ClassVar

import numpy as np

from ...core.array_namespace import add_table_axis, cos, sqrt, where
from ...core.types import Batch, BatchLike, BoolBatch
from ..column import Centerline, Column
from ..tension.tension_law import Pull
from .buckling_law import BRAID_SHARE, SHEAR, AbstractBuckling, Push
from .fixed_mode import compression_at_moment, left_over, left_over_slope, unshortened


class Kim2021(AbstractBuckling):
    """The paper's law: a fixed mode shape and equivalent springs, equations (8)-(16)."""

    name: ClassVar[str] = "kim2021"
    source: ClassVar[str] = "Kim, Mazzoleni and Bryant (2021)"

    braid_share: Batch = BRAID_SHARE.field()
    shear: str = SHEAR.field()

    def branch(self, column: Column) -> Pull:
        """What the tension law says at the free strain [N]."""
        return column.pull(column.free_strain)

    def push(self, column: Column, strain: BatchLike) -> Push:
        """Force in its components at `strain` [-], (16) and (27)."""
        eps_f, EA, c = column.free_strain, column.axial_stiffness, _slenderness(column)
        # a quotient by what all strains share would be a division for each of them
        xi = (strain - eps_f) * (1 / (1 - eps_f))
        v = unshortened(c, xi)
        shortening = xi * (1 - xi * v)  # ξ w = 2l/L_fs
        arc = eps_f + shortening * (1 - eps_f)
        taut, free = column.pull(arc), column.branch
        bending = -EA * shortening * (1 - xi) / (1 - shortening)
        # slopes in ξ, v's from the equation that it solves
        per_xi = c * (1 - xi) ** 4 / (1 + xi)
        fall = -c * (1 - xi) ** 3 * (5 + 3 * xi) / (1 + xi) ** 2
        v_slope = -left_over_slope(per_xi, fall, xi, v) / left_over(per_xi, xi, v)[1]
        growth = 1 - xi * (2 * v + xi * v_slope)
        stiffening = growth * (1 - xi) / (1 - shortening) ** 2 - shortening / (1 - shortening)
        return Push(
            mesh=taut.mesh,
            bladder=free.bladder + 0.0 * shortening,
            bending=bending,
            slope=taut.mesh_slope * growth - EA * stiffening / (1 - eps_f),
            arc_strain=arc,
            straight=shortening < -np.inf,  # never
        )

    def bow(self, column: Column, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m], (10) with the shortened arc, and moment [N·m] at `strain` [-]."""
        eps_f = column.free_strain
        xi = (strain - eps_f) / (1 - eps_f)
        v = unshortened(_slenderness(column), xi)
        y_max = 2 / np.pi * column.free_length * xi * sqrt(v * (1 - xi))
        return y_max, _moment_unit(column) * xi * sqrt(v / (1 - xi) ** 3)

    def onset(self, column: Column) -> Batch:
        """The free strain [-]: the law lets the bladder bow at once."""
        return column.free_strain

    def folds(self, column: Column) -> tuple[Batch, ...]:
        """None [-] for any `column` [-]: one state follows the other."""
        del column
        return ()

    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which $M_b$ reaches `moment` [N·m]; inf if its peak is lower [R7]."""
        xi, reached = compression_at_moment(_slenderness(column), moment / _moment_unit(column))
        return where(reached, column.free_strain + xi * (1 - column.free_strain), np.inf)

    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] of equation (8) [R4] at `strain` [-]."""
        y_max, _ = self.bow(column, strain)
        along = np.linspace(0.0, 1.0, points)
        chord = add_table_axis(column.rest_length * (1 - strain) + 0.0 * y_max)
        y = add_table_axis(y_max) / 2 * (cos(2 * np.pi * along) - 1)
        return Centerline(z=chord * along, y=y)

    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Never: the law gives one state at each strain [-]."""
        return (strain + 0.0 * column.free_strain) < -np.inf


def _slenderness(column: Column) -> Batch:
    """$c = EA L_{fs}^2/(4\\pi^2 EI)$ [-]."""
    EA, EI = column.axial_stiffness, column.bending_stiffness
    return EA * column.free_length**2 / (4 * np.pi**2 * EI)


def _moment_unit(column: Column) -> Batch:
    """What $\\hat m$ counts, $4\\pi EI/L_{fs}$ [N·m]."""
    return 4 * np.pi * column.bending_stiffness / column.free_length
