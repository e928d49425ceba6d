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
[R12]; its slope jumps at both strains: at collapse since the wall folds, at the free strain since
the law goes over from the bladder's to a column's, which is the model's and no physics. Both
strains depend on pressure alone, and are solved for at the pressure's own shape, before strain
broadcasts.

**Components:** after collapse mesh and bladder force keep their values at $\varepsilon_c$
times the same exponential, and bending is the rest.
**Sign:** pulling force and contraction positive, gauge pressure. **Valid for**
$0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Kim, Mazzoleni and Bryant (2021), (26) and (27).
"""

from typing import NamedTuple

import numpy as np

from ..core import array_namespace as xp
from ..core.array_namespace import add_table_axis, array_namespace, exp, stack, where
from ..core.module import Module
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch, IntBatch, PyTree
from ..repr_table import ReprTable, format_number, title_with_shape, with_table_repr
from .buckling import ROUNDING, AbstractBuckling, BucklingColumn, Centerline
from .collapse import AbstractCollapse
from .post_collapse import AbstractPostCollapse, hinge_moment
from .tuning import TunedTension


_untaken = np.errstate(all="ignore")  # of branches that aren't taken
TENSION, POST_BUCKLING, POST_COLLAPSE, STRAIGHT = 0, 1, 2, 3  # as results and files count them
REGIONS = ("tension", "post-buckling", "post-collapse", "straight compression")


def _response_table(response: "Response") -> ReprTable:
    """Forces [N] and the region's name, a row for each point."""
    forces = (response.force, response.mesh, response.bladder, response.bending)
    columns = [np.ravel(x) for x in (*forces, response.region, response.several)]
    rows = [
        [*map(format_number, forces), REGIONS[int(region)] + (" *" if several else "")]
        for *forces, region, several in zip(*columns, strict=True)
    ]
    notes = ["* other equilibria exist there, too"] if np.any(response.several) else []
    heads = ("force N", "mesh N", "bladder N", "bending N", "region")
    return ReprTable(title_with_shape("Response", response.force), (), heads, rows, notes)


@with_table_repr(_response_table)
class Response(NamedTuple):
    """Forces of a muscle at a pressure and strain; all of one shape.

    `force` = `mesh` + `bladder` + `bending`, all [N]. `region`: 0 tension, 1 post-buckling,
    2 post-collapse, 3 straight compression. `several`: true where other equilibria exist, too.
    """

    force: Batch
    mesh: Batch
    bladder: Batch
    bending: Batch
    region: IntBatch
    several: BoolBatch


class Piecewise(Module):
    """Force law (27) of a muscle with one choice of laws; `at` gives it at a pressure."""

    tension: TunedTension
    buckling: AbstractBuckling
    collapse: AbstractCollapse
    post_collapse: AbstractPostCollapse
    transition_rate: Batch

    @property
    def youngs_modulus(self) -> Batch:
        """Young's modulus $E$ [Pa] of bending, collapse and hinge, with the tuning's factor."""
        factor = self.tension.tuning.youngs_modulus_factor
        return self.tension.bladder.material.youngs_modulus * factor

    @property
    def rate(self) -> Batch:
        r"""Transition rate $\beta$ [-]: the tuning's, or else the muscle's."""
        tuned = self.tension.tuning.transition_rate
        return self.transition_rate if tuned is None else tuned

    def collapse_moment(self, pressure: Batch) -> Batch:
        """Collapse moment $M_{collapse}$ [N·m] at `pressure` [Pa], with the tuning's factor."""
        moment = self.collapse.moment(self.tension.bladder, self.youngs_modulus, pressure)
        return self.tension.tuning.collapse_moment_factor * moment

    @_untaken
    def free_strain(self, pressure: Batch) -> Batch:
        """Strain [-] of no force at `pressure` [Pa]."""
        return self.tension.free_strain(pressure)

    def blocked_force(self, pressure: Batch) -> Batch:
        """Force [N] at rest length and `pressure` [Pa]."""
        # a law may have its free strain before rest length, as Sárosi's without pressure
        return self.at(pressure).pulling_force(0.0 * pressure)

    def collapse_strain(self, pressure: Batch) -> Batch:
        """Strain [-] at which the bladder collapses at `pressure` [Pa]; inf where it never does."""
        return self.at(pressure).collapse_strain

    @_untaken
    def at(self, pressure: Batch, free_strain: Batch | None = None) -> "PressurizedMuscle":
        """Laws at `pressure` [Pa]; the `free_strain` [-] is computed if it is left out."""
        E, bladder = self.youngs_modulus, self.tension.bladder
        if free_strain is None:
            free_strain = self.tension.free_strain(pressure)
        stiffness = E * bladder.second_moment, E * bladder.area  # in bending, along the axis
        column = BucklingColumn(self.tension.at(pressure), pressure, free_strain, *stiffness)
        column = self.buckling.solve(column)
        collapse = self.buckling.strain_at_moment(column, self.collapse_moment(pressure))
        hinge = self.tension.tuning.hinge_stiffness_at(pressure) * hinge_moment(bladder, E)
        return PressurizedMuscle(self, column, hinge, collapse)


class PressurizedMuscle(NamedTuple):
    """Force, shape and moment of a muscle at given pressures, as functions of strain, elementwise.

    `law`: of all pressures. `column`: the muscle as a column at these. `hinge_moment`: $M_h$ of the
    folded wall [N·m]. `collapse_strain`: at which it folds [-], inf where it never does.
    """

    law: Piecewise
    column: BucklingColumn
    hinge_moment: Batch
    collapse_strain: Batch

    def take(self, index: IntBatch) -> "PressurizedMuscle":
        """The muscle at the pressures of each `index`, which are on the last axis."""
        count = np.shape(self.column.pressure)[-1:]

        def pick(value: PyTree) -> PyTree:
            if isinstance(value, tuple):
                values = map(pick, value)
                return type(value)(*values) if hasattr(value, "_fields") else tuple(values)
            if isinstance(value, Module) or np.shape(value)[-1:] != count:
                return value
            return value[..., index]

        return pick(self)

    @property
    def onset(self) -> Batch:
        """Strain [-] at which the muscle buckles; inf where it never does."""
        return self.law.buckling.onset(self.column)

    @property
    def kinks(self) -> Batch:
        """Free strain, onset of buckling and collapse strain [-], on a new first axis."""
        return stack([self.column.free_strain, self.onset, self.collapse_strain])

    @_untaken
    def force_and_slope(self, strain: Batch) -> tuple[Batch, Batch]:
        """Force [N] and its slope in strain [N], at `strain` [-]."""
        (mesh, bladder, bending), slope, _ = self._forces(strain)
        return mesh + bladder + bending, slope

    def pulling_force(self, strain: Batch) -> Batch:
        """Force [N] at `strain` [-], without its slope."""
        return self.force_and_slope(strain)[0]

    def stiffness(self, strain: Batch) -> Batch:
        """Stiffness $-(\\partial F/\\partial\\varepsilon)/L_0$ [N/m] at `strain` [-]."""
        return -self.force_and_slope(strain)[1] / self.column.rest_length

    @_untaken
    def response(self, strain: Batch) -> Response:
        """Force, its components [N] and the region at `strain` [-], (26) and (27)."""
        (mesh, bladder, bending), _, (in_tension, collapsed, straight) = self._forces(strain)
        bowed = where(straight, STRAIGHT, POST_BUCKLING)
        region = where(in_tension, TENSION, where(collapsed, POST_COLLAPSE, bowed))
        buckled = xp.logical_not(xp.logical_or(collapsed, in_tension))
        several = xp.logical_and(self.law.buckling.several(self.column, strain), buckled)
        return Response(mesh + bladder + bending, mesh, bladder, bending, region, several)

    @_untaken
    def deflection(self, strain: Batch) -> Batch:
        """Deflection of the axis [m] at `strain` [-]."""
        in_tension, collapsed, buckled_strain = self._regions(strain)
        bowed, _ = self.law.buckling.bow(self.column, buckled_strain)
        hinge_strain = self._hinge_strain(collapsed, strain)
        hinged = self.law.post_collapse.deflection(self.column, hinge_strain)
        return where(in_tension, 0.0, where(collapsed, hinged, bowed))

    @_untaken
    def moment(self, strain: Batch) -> Batch:
        """Bending moment [N·m] at `strain` [-]: zero in tension, the hinge's after collapse."""
        in_tension, collapsed, buckled_strain = self._regions(strain)
        _, moment = self.law.buckling.bow(self.column, buckled_strain)
        return where(in_tension, 0.0, where(collapsed, self.hinge_moment, moment))

    @_untaken
    def shape(self, strain: Batch, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], points on a new last axis."""
        strain = strain + 0.0 * self.column.free_strain
        in_tension, collapsed, buckled_strain = self._regions(strain)
        bowed = self.law.buckling.shape(self.column, buckled_strain, points)
        hinge_strain = self._hinge_strain(collapsed, strain)
        hinged = self.law.post_collapse.shape(self.column, hinge_strain, points)
        length = add_table_axis(self.column.rest_length * (1 - strain))
        straight = length * np.linspace(0, 1, points)
        in_tension, collapsed = add_table_axis(in_tension), add_table_axis(collapsed)
        return Centerline(
            z=where(in_tension, straight, where(collapsed, hinged.z, bowed.z)),
            y=where(in_tension, 0.0, where(collapsed, hinged.y, bowed.y)),
        )

    def _forces(
        self, strain: Batch
    ) -> tuple[tuple[Batch, Batch, Batch], Batch, tuple[BoolBatch, BoolBatch, BoolBatch]]:
        """Components and slope of the force [N], and masks of tension, collapse, straightness."""
        rate, L0 = self.law.rate, self.column.rest_length
        in_tension, collapsed, buckled_strain = self._regions(strain)
        # arrays throughout, also of numbers; [()] at the end makes an array without axes a number
        where = array_namespace(in_tension, collapsed).where
        pull = self.column.pull(where(in_tension, strain, self.column.free_strain))
        push = self.law.buckling.push(self.column, buckled_strain)
        past = strain - where(collapsed, self.collapse_strain, 1.0)
        decay = exp(-rate * where(collapsed, past, 0.0))  # 1 before collapse
        growth = 1 - decay
        x = (self._hinge_strain(collapsed, strain) - self.column.free_strain) * L0
        F_c, F_c_slope = self.law.post_collapse.push(self.column, self.hinge_moment, x)

        mesh = where(in_tension, pull.mesh, push.mesh * decay)[()]
        bladder = where(in_tension, pull.bladder, push.bladder * decay)[()]
        hinge = where(collapsed, F_c, 0.0) * growth
        bending = where(in_tension, 0.0, push.bending * decay - hinge)[()]
        force_at_collapse = push.mesh + push.bladder + push.bending
        slope = -rate * decay * (force_at_collapse + F_c) - growth * F_c_slope * L0
        slope = where(in_tension, pull.slope, where(collapsed, slope, push.slope))[()]
        return (mesh, bladder, bending), slope, (in_tension, collapsed, push.straight)

    def _regions(self, strain: Batch) -> tuple[BoolBatch, BoolBatch, Batch]:
        """Masks of tension and collapse, and the buckled state's strain [-], up to collapse."""
        eps_f, eps_c = self.column.free_strain, self.collapse_strain
        in_tension, collapsed = strain <= eps_f + ROUNDING, strain > eps_c + ROUNDING
        where = array_namespace(in_tension, collapsed).where
        return in_tension, collapsed, where(in_tension, eps_f, where(collapsed, eps_c, strain))

    def _hinge_strain(self, collapsed: BoolBatch, strain: Batch) -> Batch:
        """The `strain` [-] after collapse; before it, one at which the hinged shape exists."""
        return guarded(collapsed, strain, 0.5 * (1 + self.column.free_strain))
