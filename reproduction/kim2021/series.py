r"""A reading of the paper: its bowed shape, springs in series, one force through arc and bow.

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

from fascicle.core import array_namespace as xp
from fascicle.core.array_namespace import logical_and, sqrt, where
from fascicle.core.roots import guarded, root, stop_gradient
from fascicle.core.types import Batch, BatchLike, BoolBatch
from fascicle.core.validation import LARGEST_STRAIN
from fascicle.muscle.buckling import (
    BRAID_SHARE,
    ROUNDING,
    AbstractBuckling,
    BucklingColumn,
    Push,
)
from fascicle.muscle.tension import Pull


_FARTHEST_STRAIN = 0.95  # of the search for an onset or a moment: past the domain
_CELLS = 96  # of that search: enough to separate an onset from the end of a bow


class _BowState(NamedTuple):
    """Mask of the bent muscle, its arc's strain [-] and pull, the arc and the chord [m]."""

    bent: BoolBatch
    arc_strain: Batch
    pull: Pull
    arc: Batch
    chord: Batch


class SpringsInSeries(AbstractBuckling):
    """The paper's shape in series with the arc, equation (12s)."""

    name: ClassVar[str] = "kim2021_series"
    source: ClassVar[str] = "derived here from Kim, Mazzoleni and Bryant (2021), 3.2"

    braid_share: Batch = BRAID_SHARE.field()

    def branch(self, column: BucklingColumn) -> Batch:
        """Onset of a `column` [-]; inf where it never bows."""
        fixed = stop_gradient(column)
        free = fixed.free_strain + 0.0 * fixed.bending_stiffness
        bows, low, high = find_first_cell(_load_reserve, fixed, free)
        onset = root(_load_reserve, column, low, high, 0.5 * (low + high))
        return where(logical_and(bows, onset < LARGEST_STRAIN), onset, np.inf)

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Force [N] past the free strain, (12s), at `strain` [-]. Arc and bow carry one force in
        series: the components are the tension law's at the arc's strain, and `bending` is zero.
        """
        state, EI, L0 = _bow_state(column, strain), column.bending_stiffness, column.rest_length
        by_arc = state.pull.slope - 8 * np.pi**2 * EI * L0 / state.chord**3
        by_strain = 8 * np.pi**2 * EI * L0 * (3 * state.arc - state.chord) / state.chord**4
        arc_slope = -by_strain / guarded(by_arc != 0, by_arc)
        slope = state.pull.slope * arc_slope
        return Push.of_arc(state.pull, state.arc_strain, state.bent, state.pull.force, slope)

    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m], (10) with the shortened arc, and moment [N·m] at `strain` [-]."""
        state = _bow_state(column, strain)
        x = state.arc - state.chord
        bends = logical_and(state.bent, x > 0)
        y_max = where(bends, 2 / np.pi * sqrt(guarded(bends, x) * state.chord), 0.0)
        return y_max, 2 * np.pi**2 * column.bending_stiffness * y_max / state.chord**2

    def onset(self, column: BucklingColumn) -> Batch:
        """Strain [-] at which the straight muscle bows; inf where it never does."""
        return column.branch

    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """First strain [-] at which the bending moment reaches `moment` [N·m]; inf if never."""
        # the moment says by how much the arc is longer than each chord, and so its strain
        theta = (column, (moment / (4 * np.pi * column.bending_stiffness)) ** 2)
        fixed, fixed_square = stop_gradient(theta)
        free = fixed.free_strain + 0.0 * fixed.bending_stiffness + 0.0 * fixed_square
        exists, low, high = find_first_cell(_force_excess_at_moment, (fixed, fixed_square), free)
        strain = root(_force_excess_at_moment, theta, low, high, 0.5 * (low + high))
        return where(logical_and(exists, xp.isfinite(column.branch)), strain, np.inf)


def find_first_cell(function: Callable, theta: Any, free: Batch) -> tuple[BoolBatch, Batch, Batch]:
    """Mask where a `function` falls below 0 past the `free` strain, and that cell's ends [-]."""
    rank = xp.node_axis(np.arange(float(_CELLS)), free)
    step = (_FARTHEST_STRAIN - free) / _CELLS
    end_value, _ = function(theta, free + step * (rank + 1))
    cell = xp.min_nodes(where(end_value <= 0, rank, np.inf))
    low = free + step * xp.minimum(cell, _CELLS - 1.0)
    return xp.isfinite(cell), low, low + step


def _load_reserve(column: BucklingColumn, strain: Batch) -> tuple[Batch, Batch]:
    """Load that a straight muscle can take yet before it bows [N], negative past it; its slope."""
    pull, length = column.pull(strain), column.rest_length * (1 - strain)
    euler = 4 * np.pi**2 * column.bending_stiffness / length**2
    return pull.force + euler, pull.slope + 2 * euler / (1 - strain)


def _arc_residual(theta: tuple, arc_strain: Batch) -> tuple[Batch, Batch]:
    """Excess [N] of the bow's force over the arc's compression, and its slope."""
    column, chord = theta
    pull, EI, L0 = column.pull(arc_strain), column.bending_stiffness, column.rest_length
    unit = 4 * np.pi**2 * EI / chord**3
    return unit * (2 * L0 * (1 - arc_strain) - chord) + pull.force, pull.slope - 2 * unit * L0


def _bow_state(column: BucklingColumn, strain: BatchLike) -> _BowState:
    """State at `strain` [-]: bent past the onset if the straight muscle can't bear the load."""
    L0 = column.rest_length
    overloaded = _load_reserve(column, strain + 0.0 * column.free_strain)[0] < 0
    bent = logical_and(strain > column.branch + ROUNDING, overloaded)
    eps = guarded(bent, strain, LARGEST_STRAIN) + 0.0 * column.free_strain
    low, high = stop_gradient((column.free_strain + 0.0 * eps, eps))
    arc = root(_arc_residual, (column, L0 * (1 - eps)), low, high, 0.5 * (low + high))
    arc = where(bent, arc, strain)
    return _BowState(bent, arc, column.pull(arc), L0 * (1 - arc), L0 * (1 - strain) + 0.0 * arc)


def _force_excess_at_moment(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """Excess [N] of the force of a bow with a given moment over its arc's compression, (12s), at
    the muscle's `strain` [-], and its slope; `theta`: column and $(M/4\\pi EI)^2$ [1/m²].
    """
    column, square = theta
    EI, L0 = column.bending_stiffness, column.rest_length
    d = L0 * (1 - strain)
    arc, free = 1 - (d + square * d**3) / L0, column.free_strain
    # a moment whose arc is longer than the free one isn't reached there
    pull = column.pull(where(arc > free, arc, free))
    value = pull.force + 4 * np.pi**2 * EI * (1 / d**2 + 2 * square)
    slope = where(arc > free, pull.slope * (1 + 3 * square * d**2), 0.0)
    return value, slope + 8 * np.pi**2 * EI * L0 / d**3
