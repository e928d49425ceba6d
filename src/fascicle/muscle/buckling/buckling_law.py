r"""What a buckling law is: the state of a compressed muscle at a strain.

A law past the free strain takes a muscle at one pressure as a column. It gives the state at a
strain: the force in its components, the deflection and the largest moment, and where that moment
reaches a given one.

Its bending stiffness is the bladder's and, under pressure, a share $\chi$ of what the braid's
fibers hold where they don't slip, (B1):

$$EI(P) = E I + \chi\, 2 \pi r^4 P \frac{\cos^2\alpha}{\sin^4\alpha}, \tag{B2}$$

with $r$ and $\alpha$ at free strain. The paper leaves it out, as does $\chi = 0$, to the bit.
"""

import abc
from typing import Any, NamedTuple

import equinox as eqx

from ...core.constant import SHARE, Constant
from ...core.types import Batch, BatchLike, BoolBatch
from ..column import Centerline, Column
from ..law import AbstractLaw


BRAID_SHARE = Constant(
    "braid_share", r"\chi", "number", (0.0, 0.0, 1.0, 1.0), SHARE, 0.0,
    "of the braid's bending stiffness under pressure", "derived here",
)  # fmt: skip


class Push(NamedTuple):
    """A state past the free strain: its force in components, negative where it pushes, and the
    force's slope in strain, all [N]; the strain of its arc [-], whether it is straight.
    """

    mesh: Batch
    bladder: Batch
    bending: Batch
    slope: Batch
    arc_strain: Batch
    straight: BoolBatch


class Buckled(NamedTuple):
    """A state past the free strain: forces [N], deflection [m], largest moment [N·m]."""

    mesh: Batch
    bladder: Batch
    bending: Batch
    deflection: Batch
    moment: Batch
    arc_strain: Batch
    straight: BoolBatch


class AbstractBuckling(AbstractLaw):
    """A law for the muscle between its free strain and its collapse; `braid_share` [-] is how much
    of the braid's bending stiffness it counts.
    """

    braid_share: eqx.AbstractVar[Batch]

    def solved(self, column: Column) -> Column:
        """The `column` [-] with its braid's stiffness, (B2), and its `branch` [-]."""
        tension, free = column.tension, column.free_strain
        # what of the pressure reaches the braid
        P = tension.tuning.effective_pressure(column.pressure)
        braid = self.braid_share * tension.bladder.braid.bending_stiffness(
            P, free * tension.stretch
        )
        stiffer = column._replace(bending_stiffness=column.bending_stiffness + braid)
        return stiffer._replace(branch=self.branch(stiffer))

    @abc.abstractmethod
    def branch(self, column: Column) -> Any:
        """What of a `column` [-] depends on pressure alone, solved for once [-]."""

    @abc.abstractmethod
    def push(self, column: Column, strain: BatchLike) -> Push:
        """The force [N] at `strain` [-], at or past the free strain. Elementwise."""

    @abc.abstractmethod
    def bow(self, column: Column, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m] and largest moment [N·m] at `strain` [-]. Elementwise."""

    @abc.abstractmethod
    def onset(self, column: Column) -> Batch:
        """Strain [-] at which a `column` [-] bows out; inf where it never does."""

    @abc.abstractmethod
    def folds(self, column: Column) -> tuple[Batch, ...]:
        """Strains [-] past the onset at which the force of a `column` [-] may jump; inf where it
        doesn't.
        """

    @abc.abstractmethod
    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which the largest moment is `moment` [N·m]; inf if never."""

    @abc.abstractmethod
    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], `points` points on a new last axis."""

    @abc.abstractmethod
    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Whether [-] other equilibria exist at `strain` [-] beside the one followed."""

    def buckled(self, column: Column, strain: BatchLike) -> Buckled:
        """Forces [N], deflection [m] and moment [N·m] at `strain` [-], at or past free strain."""
        push, (deflection, moment) = self.push(column, strain), self.bow(column, strain)
        return Buckled(
            push.mesh, push.bladder, push.bending, deflection, moment,
            push.arc_strain, push.straight,
        )  # fmt: skip
