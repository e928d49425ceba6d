r"""Buckling laws: the state of a compressed muscle at a strain.

A law past the free strain sees a muscle at one pressure as a column of bending stiffness $EI$ and
axial stiffness $EA$ between clamped ends, whose tension law goes on as compression. It gives the
state at a strain: the force in its components, the deflection and the largest moment, and the
strain at which that moment reaches a given one.

Its bending stiffness is the bladder's and, under pressure, a share $\chi$ of what the braid's
fibers hold where they don't slip, (B1):

$$EI(P) = E I + \chi\, 2 \pi r^4 P \frac{\cos^2\alpha}{\sin^4\alpha}, \tag{B2}$$

with $r$ and $\alpha$ at free strain. The paper leaves it out, as does $\chi = 0$, to the bit.

A stubby column shears as it bends, and gives way below Euler's load $N_E$, at Engesser's, which is
that of a column that bends more easily:

$$N = \frac{N_E}{1 + N_E/S}, \qquad EI \to \frac{EI}{1 + 4\pi^2 EI/(L_{fs}^2 S)}, \qquad
  S = \kappa G A + \pi r^2 P, \tag{S1}$$

with $G = E/(2(1 + \nu))$ and a thin tube's $\kappa = 1/2$; pressure resists, since a tube that
shears by $\gamma$ holds less by $1 - \cos\gamma$. `shear="engesser"` asks for it.

**Source:** for shear, Engesser (1889); derived on the theory page.
"""

import abc
from typing import ClassVar, NamedTuple

import numpy as np

from ...core.array_namespace import add_table_axis, cos, logical_not, where
from ...core.parameters import SHARE, Constant, Switch
from ...core.types import Batch, BatchLike, BoolBatch, PyTree
from ..law import AbstractLaw, LawRegistry
from ..tension import Pull
from ..tuning import PressurizedTension


BRAID_SHARE = Constant(
    "braid_share", r"\chi", "number", (0.0, 0.0, 1.0, 1.0), SHARE, 0.0,
    "share of the braid's bending stiffness under pressure", "derived here",
)  # fmt: skip
SHEAR = Switch(
    "shear", ("none", "engesser"), "whether the column shears as it bends", "Engesser (1889)"
)
_KAPPA = 0.5  # of a thin tube, whose shear flow goes as the sine around it; a solid rod has 6/7
# of a strain: compilers round a kink differently in its last bits, and a strain at it belongs below
ROUNDING = 1e-15


class BucklingColumn(NamedTuple):
    """A muscle at a `pressure` [Pa] for buckling laws: free strain [-], stiffnesses $EI$ [N·m²] and
    $EA$ [N]; `branch`: the law's results that depend on pressure alone.
    """

    tension: PressurizedTension
    pressure: Batch
    free_strain: Batch
    bending_stiffness: Batch
    axial_stiffness: Batch
    branch: PyTree = None

    @property
    def rest_length(self) -> Batch:
        """Length at rest $L_0$ [m]."""
        return self.tension.bladder.braid.length

    @property
    def free_length(self) -> Batch:
        """Length at free strain $L_{fs}$ [m]."""
        return self.rest_length * (1 - self.free_strain)

    def pull(self, strain: BatchLike) -> Pull:
        """Force [N] of the tension law in its components, with slopes, at a `strain` [-]."""
        return self.tension.pull(strain)


class Centerline(NamedTuple):
    """A muscle's axis as points [m], on the last axis: `z` along, `y` across."""

    z: Batch
    y: Batch


class Push(NamedTuple):
    """Force past the free strain: its components, negative where it pushes, and its slope in
    strain, all [N]; the strain of the arc [-], and whether the muscle is straight.
    """

    mesh: Batch
    bladder: Batch
    bending: Batch
    slope: Batch
    arc_strain: Batch
    straight: BoolBatch

    @classmethod
    def of_arc(
        cls, pull: Pull, arc_strain: Batch, bent: BoolBatch, force: Batch, slope: Batch
    ) -> "Push":
        """Push of an arc by its `pull`, where it is `bent` by the ends' `force` and `slope` [N]."""
        return cls(
            mesh=pull.mesh,
            bladder=pull.bladder + 0.0 * force,
            bending=where(bent, force - pull.force, 0.0),
            slope=where(bent, slope, pull.slope),
            arc_strain=arc_strain,
            straight=logical_not(bent),
        )


class AbstractBuckling(AbstractLaw):
    """A law for the muscle between its free strain and its collapse.

    `braid_share`: counted share of the braid's bending stiffness [-]. `shear`: field of a law of
    columns that may shear.
    """

    braid_share: ClassVar[Batch]

    def solve(self, column: BucklingColumn) -> BucklingColumn:
        """The `column` with its bending stiffness, (B2) and (S1) [N·m²], and its `branch`."""
        tension, EI = column.tension, column.bending_stiffness
        bladder, free = tension.bladder, column.free_strain * tension.strain_ratio
        EI = EI + self.braid_share * bladder.braid.bending_stiffness(tension.pressure, free)
        if getattr(self, SHEAR.name, SHEAR.options[0]) == "engesser":
            G_A = column.axial_stiffness / (2 * (1 + bladder.material.poisson_ratio))
            S = _KAPPA * G_A + np.pi * bladder.braid.radius_at(free) ** 2 * column.pressure
            euler = 4 * np.pi**2 * EI / column.free_length**2
            EI = EI / (1 + euler / S)
        column = column._replace(bending_stiffness=EI)
        return column._replace(branch=self.branch(column))

    @abc.abstractmethod
    def branch(self, column: BucklingColumn) -> PyTree:
        """Results for a `column` that depend on pressure alone, such as its onset, of a type that
        each law chooses for itself.
        """

    @abc.abstractmethod
    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Force and slope [N] at a `strain` [-] no less than the free strain, elementwise."""

    @abc.abstractmethod
    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Largest deflection [m] and bending moment [N·m] at `strain` [-], elementwise."""

    def onset(self, column: BucklingColumn) -> Batch:
        """First strain [-] at which a `column` bows, inf if it never does; of its branch."""
        return column.branch.onset

    def folds(self, column: BucklingColumn) -> tuple[Batch, ...]:
        """Strains [-] past the onset at which the force jumps, or inf; none by default."""
        return ()

    @abc.abstractmethod
    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """First strain [-] at which the bending moment reaches `moment` [N·m]; inf if never."""

    def shape(self, column: BucklingColumn, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], `points` on a new last axis: by default (8) [R4]."""
        y_max, _ = self.bow(column, strain)
        along = np.linspace(0.0, 1.0, points)
        chord = add_table_axis(column.rest_length * (1 - strain) + 0.0 * y_max)
        y = add_table_axis(y_max) / 2 * (cos(2 * np.pi * along) - 1)
        return Centerline(z=chord * along, y=y)

    def several(self, column: BucklingColumn, strain: BatchLike) -> BoolBatch:
        """True where a `column` has several equilibria at `strain` [-]; by default never."""
        return (strain + 0.0 * column.free_strain) < -np.inf


BUCKLING_LAWS = LawRegistry(AbstractBuckling, default="kim2021")
__getattr__, __dir__ = BUCKLING_LAWS.package_attributes()
