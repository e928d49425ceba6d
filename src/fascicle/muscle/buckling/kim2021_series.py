r"""Post-buckling, the paper's shape with its springs in series: one force through arc and bow.

The paper compresses its axis by springs $EA/L_{fs}$ and lets the mesh along the arc push beside
them: both forces add, and the push is up to twice what a column holds. In series the arc, whose
compression is the tension law's, passes on the force that the bow holds. With the
arc $\ell = L_0 (1 - \varepsilon_a)$ and the chord $d = L_0 (1 - \varepsilon)$, (12) is

$$F_b = \frac{4 \pi^2 E I (2 \ell - d)}{d^3}, \qquad -T(P, \varepsilon_a) = F_b = -F, \tag{12s}$$

and straight, $\varepsilon_a = \varepsilon$, wherever $-T \ell^2 < 4\pi^2 EI$: a stubby muscle may
bow, and be straight again once it is so short that it holds what presses it. Deflection and moment
are (10)'s and (8)'s with the shortened arc. No axial stiffness $EA$ is left in it.

**Sign:** tension positive. **Valid for** $\varepsilon \ge \varepsilon_f$, tension laws that fall
with strain. **Assumes** the first mode's shape, small slopes: too stiff as (12) is.
**Source:** derived here from Kim, Mazzoleni and Bryant (2021), 3.2.
"""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...core.array_namespace import (
    add_table_axis,
    cos,
    isfinite,
    logical_and,
    logical_not,
    min_nodes,
    minimum,
    node_axis,
    sqrt,
    where,
)
from ...core.roots import guarded, root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch
from ...core.validation import LARGEST_STRAIN
from ..tension.tension_law import Pull
from .buckling_law import BRAID_SHARE, ROUNDING, SHEAR, AbstractBuckling, Centerline, Column, Push


_LARGEST_STRAIN = 0.95  # of strains that are looked at
_CELLS = 96  # cells in which an onset, or a moment, is first looked for


class _BowState(NamedTuple):
    """Mask of the bent muscle, its arc's strain [-] and pull, the arc and the chord [m]."""

    bent: BoolBatch
    arc_strain: Batch
    pull: Pull
    arc: Batch
    chord: Batch


class Kim2021Series(AbstractBuckling):
    """The paper's shape in series with the arc, equation (12s)."""

    name: ClassVar[str] = "kim2021_series"
    source: ClassVar[str] = "derived here from Kim, Mazzoleni and Bryant (2021), 3.2"

    braid_share: Batch = BRAID_SHARE.field()
    shear: str = SHEAR.field()

    def branch(self, column: Column) -> Batch:
        """The onset [-]: inf where it never bows."""
        here = stop_gradient(column)
        free = here.free_strain + 0.0 * here.bending_stiffness
        ever, low, high = _first_cell(_load_reserve, here, free)
        found = root(_load_reserve, column, low, high, 0.5 * (low + high))
        return where(logical_and(ever, found < LARGEST_STRAIN), found, np.inf)

    def push(self, column: Column, strain: BatchLike) -> Push:
        """Force in its components at `strain` [-], (12s)."""
        at, EI, L0 = _bow_state(column, strain), column.bending_stiffness, column.rest_length
        T = at.pull.force
        by_arc = at.pull.slope - 8 * np.pi**2 * EI * L0 / at.chord**3
        by_strain = 8 * np.pi**2 * EI * L0 * (3 * at.arc - at.chord) / at.chord**4
        moves = -by_strain / guarded(by_arc != 0, by_arc)
        return Push(
            mesh=at.pull.mesh,
            bladder=at.pull.bladder + 0.0 * T,
            bending=0.0 * T,
            slope=where(at.bent, at.pull.slope * moves, at.pull.slope),
            arc_strain=at.arc_strain,
            straight=logical_not(at.bent),
        )

    def bow(self, column: Column, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m], (10) with the shortened arc, and moment [N·m] at `strain` [-]."""
        at = _bow_state(column, strain)
        x = at.arc - at.chord
        bends = logical_and(at.bent, x > 0)
        y_max = where(bends, 2 / np.pi * sqrt(guarded(bends, x) * at.chord), 0.0)
        return y_max, 2 * np.pi**2 * column.bending_stiffness * y_max / at.chord**2

    def onset(self, column: Column) -> Batch:
        """Strain [-] at which the straight muscle bows; inf where it never does."""
        return column.branch

    def folds(self, column: Column) -> tuple[Batch, ...]:
        """No strains [-] for any `column`: one state follows the other."""
        del column
        return ()

    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which $M_b$ reaches `moment` [N·m]; inf if it never does.

        The moment says by how much the arc is longer than each chord, and so its strain.
        """
        theta = (column, (moment / (4 * np.pi * column.bending_stiffness)) ** 2)
        here, more = stop_gradient(theta)
        free = here.free_strain + 0.0 * here.bending_stiffness + 0.0 * more
        ever, low, high = _first_cell(_moment_residual, (here, more), free)
        strain = root(_moment_residual, theta, low, high, 0.5 * (low + high))
        return where(logical_and(ever, isfinite(column.branch)), strain, np.inf)

    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] of equation (8) [R4] at `strain` [-]."""
        y_max, _ = self.bow(column, strain)
        along = np.linspace(0.0, 1.0, points)
        chord = add_table_axis(column.rest_length * (1 - strain) + 0.0 * y_max)
        return Centerline(
            z=chord * along, y=add_table_axis(y_max) / 2 * (cos(2 * np.pi * along) - 1)
        )

    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Never: the law gives one state at each strain [-]."""
        return (strain + 0.0 * column.free_strain) < -np.inf


def _first_cell(function: Callable, theta: Any, free: Batch) -> tuple[BoolBatch, Batch, Batch]:
    """Mask where a `function` of `theta` and strain falls below 0 past the `free` one [-], and the
    ends [-] of the first of `_CELLS` cells at whose end it is; all in the shape of `free`.
    """
    rank = node_axis(np.arange(float(_CELLS)), free)
    step = (_LARGEST_STRAIN - free) / _CELLS
    ahead, _ = function(theta, free + step * (rank + 1))
    cell = min_nodes(where(ahead <= 0, rank, np.inf))
    low = free + step * minimum(cell, _CELLS - 1.0)
    return isfinite(cell), low, low + step


def _load_reserve(column: Column, strain: Batch) -> tuple[Batch, Batch]:
    """Load reserve of a straight muscle before it bows [N], and its slope [N]."""
    pull, length = column.pull(strain), column.rest_length * (1 - strain)
    euler = 4 * np.pi**2 * column.bending_stiffness / length**2
    return pull.force + euler, pull.slope + 2 * euler / (1 - strain)


def _arc_residual(theta: tuple, arc_strain: Batch) -> tuple[Batch, Batch]:
    """By how much the bow holds more than presses the arc [N], and its slope [N]."""
    column, chord = theta
    pull, EI, L0 = column.pull(arc_strain), column.bending_stiffness, column.rest_length
    unit = 4 * np.pi**2 * EI / chord**3
    return unit * (2 * L0 * (1 - arc_strain) - chord) + pull.force, pull.slope - 2 * unit * L0


def _bow_state(column: Column, strain: BatchLike) -> _BowState:
    """The state at `strain` [-]."""
    L0 = column.rest_length
    # past the onset, and where it doesn't hold straight what presses it
    presses = _load_reserve(column, strain + 0.0 * column.free_strain)[0] < 0
    bent = logical_and(strain > column.branch + ROUNDING, presses)
    eps = guarded(bent, strain, 0.6) + 0.0 * column.free_strain
    low = stop_gradient(column.free_strain + 0.0 * eps)
    arc = root(
        _arc_residual,
        (column, L0 * (1 - eps)),
        low,
        stop_gradient(eps),
        0.5 * (low + stop_gradient(eps)),
    )
    own = where(bent, arc, strain)
    return _BowState(bent, own, column.pull(own), L0 * (1 - own), L0 * (1 - strain) + 0.0 * own)


def _moment_residual(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """Excess of the bow's force over the compression of the arc [N], at a moment, and its slope
    [N].
    """
    column, share = theta
    EI, L0 = column.bending_stiffness, column.rest_length
    d = L0 * (1 - strain)
    own, free = 1 - (d + share * d**3) / L0, column.free_strain
    # a moment that asks for an arc longer than the free one isn't reached there
    pull = column.pull(where(own > free, own, free))
    value = pull.force + 4 * np.pi**2 * EI * (1 / d**2 + 2 * share)
    pressed = where(own > free, pull.slope * (1 + 3 * share * d**2), 0.0)
    return value, pressed + 8 * np.pi**2 * EI * L0 / d**3
