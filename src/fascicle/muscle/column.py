"""A muscle as a column: what every buckling law takes, and what it gives.

A law past the free strain sees a muscle at one pressure as a column of bending stiffness
$EI$ and axial stiffness $EA$ between clamped ends, whose tension law goes on as
compression. It gives the state at a strain: the force in its components, the deflection
and the largest moment, and where that moment reaches a given one.
"""

import abc

import equinox as eqx

from .._types import Batch, BatchLike, BoolBatch
from .tuning import TunedTension


# of a strain: a kink found in another compilation may differ in its last bits, and what is
# asked for there belongs below it
ROUNDING = 1e-15


class Column(eqx.Module):
    """What a buckling law needs to know of a muscle at a pressure."""

    tension: TunedTension
    pressure: Batch
    free_strain: Batch
    bending_stiffness: Batch
    axial_stiffness: Batch

    @property
    def rest_length(self) -> Batch:
        """Length at rest $L_0$ [m]."""
        return self.tension.bladder.braid.length

    @property
    def free_length(self) -> Batch:
        """Length at free strain $L_{fs}$ [m]."""
        return self.rest_length * (1 - self.free_strain)


class Buckled(eqx.Module):
    """A state past the free strain: forces [N], deflection [m], largest moment [N·m]."""

    mesh: Batch
    bladder: Batch
    bending: Batch
    deflection: Batch
    moment: Batch
    arc_strain: Batch
    straight: BoolBatch


class Centerline(eqx.Module):
    """A muscle's axis as points [m], on the last axis: `z` along, `y` across."""

    z: Batch
    y: Batch


class AbstractBuckling(eqx.Module):
    """A law for the muscle between its free strain and its collapse."""

    name: eqx.AbstractClassVar[str]

    @abc.abstractmethod
    def buckled(self, column: Column, strain: BatchLike) -> Buckled:
        """The state at `strain` [-], at or past the free strain. Elementwise."""

    @abc.abstractmethod
    def onset(self, column: Column) -> Batch:
        """Strain [-] at which the muscle bows out; inf where it never does."""

    @abc.abstractmethod
    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which the largest moment is `moment` [N·m]; inf if never."""

    @abc.abstractmethod
    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], `points` points on a new last axis."""

    @abc.abstractmethod
    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Whether other equilibria exist at `strain` [-] beside the one followed."""
