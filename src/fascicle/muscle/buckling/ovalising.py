r"""Post-buckling and collapse in one: an elastica whose section ovalizes and softens as it bends.

The elastica with Brazier's softening at each place, pressure, and what it costs that ovality
changes along the axis. With the mid radius $r = r_0 - t_0/2$, $D = E t_0^3/(12 (1 - \nu^2))$ and
$S$ along the axis at free strain,

$$U_b = \int \tfrac12 EI \kappa^2 \bigl(1 - \tfrac32 \zeta + \tfrac58 \zeta^2\bigr)
  + a \zeta^2 + b \zeta'^2 + g \zeta''^2 \,\mathrm{d}S, \tag{O2}$$

$$a = \frac{3 \pi E t_0^3}{8 (1 - \nu^2) r} + \frac{3 \pi}{2} P r^2, \qquad
  b = \frac94 \pi r D (1 - \nu), \qquad
  g = \frac{\pi E t_0 r^5}{32} + \frac{\pi r^3 D}{2}. \tag{O3}$$

Ends are clamped and round. Walls touch at $\zeta = 1 - t_0/2r$. As in the elastica the arc is
compressed by the tension law; at a shortening $w$ of the bent arc, whose load is
$n(w)\, EI/(L_{fs} \ell)$,

$$-T(P, \varepsilon_a) (1 - \varepsilon_a) = n(w) (1 - w) \frac{EI}{L_{fs} L_0}, \qquad
  1 - \varepsilon = (1 - \varepsilon_a) (1 - w), \qquad F = -n \frac{EI}{L_{fs} \ell}.
  \tag{O4}$$

There is no collapse moment, no hinge and no rate: the muscle softens gradually. Whatever collapse
law the muscle has is never asked. Without $b$ and $g$ all of the bending would gather in one place
of no length: the problem would be ill-posed.

**Branch:** followed from the free strain; where it turns back the force jumps to the next state of
the same strain, as in the elastica. **Sign:** tension positive. **Valid for**
$\varepsilon \le 0.6$, $L_0/r_0$ from some 8 to 60. **Assumes** a thin wall that ovalizes without
stretching, rubber that stays linear. **Derivatives:** of a compiled muscle up to third ones by what
the section is, by strain of all orders. **Source:** derived here; Brazier (1927) for the softening;
pressure as in Wood (1958).
"""

from typing import ClassVar, NamedTuple

import numpy as np

from ...core import array_namespace as xp
from ...core.array_namespace import expand_nodes, logical_and, node_axis, sqrt, sum_nodes, where
from ...core.roots import find_root, guarded, root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch
from ...core.validation import LARGEST_STRAIN
from ..tension import Pull
from . import BRAID_SHARE, ROUNDING, AbstractBuckling, BucklingColumn, Centerline, Push
from .oval_column import (
    STEP,
    ColumnStates,
    Oval,
    interpolate_spline,
    shortenings,
    spline_slopes,
    states,
)


_FARTHEST_STRAIN = 0.95  # of the search for an arc: past the domain of strains


class _OvalBranch(NamedTuple):
    """Onset [-]; states over $w$, their slopes, and the ends' `strain` [-], nodes first."""

    onset: Batch
    states: ColumnStates
    slopes: ColumnStates
    strain: Batch


class _OvalState(NamedTuple):
    """Mask of the bent muscle, its cell and shortening $w$, the arc's $1 - \\varepsilon_a$, its
    pull by the tension law.
    """

    bent: BoolBatch
    cell: Batch
    w: Batch
    arc: Batch
    pull: Pull

    @property
    def root_w(self) -> Batch:
        """Root of the shortening $\\sqrt w$ [-], without a slope where it vanishes."""
        bends = logical_and(self.bent, self.w > 0)
        return where(bends, sqrt(guarded(bends, self.w)), 0.0)


class Ovalising(AbstractBuckling):
    """An elastica whose section ovalizes: (O2) to (O4), without a collapse moment."""

    name: ClassVar[str] = "ovalising"
    source: ClassVar[str] = "derived here, after Brazier (1927) and Wood (1958)"
    collapses: ClassVar[bool] = False

    braid_share: Batch = BRAID_SHARE.field()

    def branch(self, column: BucklingColumn) -> _OvalBranch:
        """Onset of a `column` [-], and all of its bent states."""
        nodes = states(_oval(column))
        n, bow, bend = map(spline_slopes, nodes[:3])
        slopes = ColumnStates(n, bow, bend, nodes.sines)
        free = column.free_strain
        theta = (column, 4 * np.pi**2 * _force_unit(column))
        onset = root(_arc_residual, theta, free, _FARTHEST_STRAIN + 0.0 * free, free)
        fixed, load = stop_gradient(column), stop_gradient(nodes.load)
        w = node_axis(shortenings(), load[0])
        target = load * (1 - w) * _force_unit(fixed)
        low = fixed.free_strain + 0.0 * target
        arc = find_root(_arc_residual, (fixed, target), low, _FARTHEST_STRAIN + 0.0 * low, low)
        onset = where(onset < 0.999 * _FARTHEST_STRAIN, onset, np.inf)
        return _OvalBranch(onset, nodes, slopes, 1 - (1 - arc) * (1 - w))

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Components of the force [N], negative where it pushes, at `strain` [-], (O4)."""
        bent, _, w, arc, pull = state = _state_at_strain(column, strain)
        unit, chord, T = _force_unit(column), 1 - w, pull.force
        n, n_slope = _interpolate_load(column, state.cell, w)
        # h(w, ε) = -T (1 - ε_a) - n (1 - w) u is zero: how w and the arc move with strain
        by_arc = pull.slope * arc - T
        by_w = by_arc * arc / chord - unit * (n_slope * chord - n)
        w_slope = by_arc / chord / guarded(by_w != 0, by_w)
        arc_slope = (arc * w_slope - 1) / chord
        F = -n * unit / arc
        slope = -unit * n_slope * w_slope / arc - F * arc_slope / arc
        return Push.of_arc(pull, 1 - arc, bent, F, slope)

    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection [m] and largest bending moment [N·m], at the ends or in the middle."""
        state, branch = _state_at_strain(column, strain), column.branch
        n, bow, bend = (
            interpolate_spline(x, slope, state.cell, state.w)[0]
            for x, slope in zip(branch.states[:3], branch.slopes[:3], strict=True)
        )
        moment = xp.maximum(bend, n * bow - bend) * state.root_w
        length = column.rest_length * state.arc
        return length * bow * state.root_w, moment * column.bending_stiffness / column.free_length

    def folds(self, column: BucklingColumn) -> tuple[Batch, ...]:
        """Strain [-] of the first fold past the onset, rounded to a node; inf without one."""
        start, end = column.branch.strain[:-1], column.branch.strain[1:]
        rank = node_axis(np.arange(float(end.shape[0])), end[0])
        first = xp.min_nodes(where(end < start, rank, np.inf))
        fold = sum_nodes(where(rank == first, start, 0.0))
        # a branch that turns back at its first node, the onset, has no fold past it
        past_onset = logical_and(first > 0, xp.isfinite(column.branch.onset))
        exists = logical_and(xp.isfinite(first), past_onset)
        return (where(exists, fold, np.inf),)

    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """Infinite strain [-] for any `moment` [N·m]: the section softens instead of collapsing."""
        return where(0.0 * (moment + column.free_strain) < 0, 0.0, np.inf)

    def shape(self, column: BucklingColumn, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] at `strain` [-], evenly spaced on the arc, by its sines."""
        state, sines = _state_at_strain(column, strain), column.branch.states.sines
        root_w, node = state.root_w, state.w / STEP
        # linear between nodes
        weight = xp.maximum(1 - xp.absolute(node - node_axis(np.arange(len(sines)), node)), 0.0)
        middle = (np.arange(points - 1) + 0.5) / (points - 1)
        theta = xp.add_table_axis(0.0 * root_w)
        for k in range(sines.shape[1]):
            sine = root_w * sum_nodes(weight * expand_nodes(sines[:, k], node))
            theta = theta + xp.add_table_axis(sine) * np.sin(2 * np.pi * (k + 1) * middle)
        # from point to point: sums of all steps before
        before = np.arange(points)[:, None] > np.arange(points - 1)
        length = xp.add_table_axis(column.rest_length * state.arc) / (points - 1)
        z, y = ((length * x) @ before.T for x in (xp.cos(theta), xp.sin(theta)))
        chord = xp.add_table_axis(column.rest_length * (1 - strain))
        return Centerline(z=z * chord / z[..., -1:], y=-y)

    def several(self, column: BucklingColumn, strain: BatchLike) -> BoolBatch:
        """True where a `column` has several bent states at `strain` [-]."""
        eps = stop_gradient(strain + 0.0 * column.free_strain)
        is_past = expand_nodes(column.branch.strain, eps) > eps
        count = sum_nodes(where(is_past[1:] != is_past[:-1], 1.0, 0.0))
        return logical_and(count > 1.5, eps > stop_gradient(column.free_strain))


def _force_unit(column: BucklingColumn) -> Batch:
    """Unit of forces, $EI/(L_{fs} L_0)$ [N]."""
    return column.bending_stiffness / (column.free_length * column.rest_length)


def _interpolate_load(column: BucklingColumn, cell: Batch, w: Batch) -> tuple[Batch, Batch]:
    """Load $n$ [-] of the oval column and its slope at a shortening `w` [-] in a `cell`."""
    return interpolate_spline(column.branch.states.load, column.branch.slopes.load, cell, w)


def _oval(column: BucklingColumn) -> Oval:
    """Coefficients of the section's ovality, (O3), over those of the column [-]."""
    bladder, EI, L = column.tension.bladder, column.bending_stiffness, column.free_length
    E, t = column.axial_stiffness / bladder.area, bladder.wall_thickness
    nu, r = bladder.material.poisson_ratio, bladder.braid.radius - t / 2
    D = E * t**3 / (12 * (1 - nu**2))
    a = 3 * np.pi * E * t**3 / (8 * (1 - nu**2) * r) + 1.5 * np.pi * column.pressure * r**2
    b = 9 / 4 * np.pi * r * D * (1 - nu)
    g = np.pi * E * t * r**5 / 32 + np.pi * r**3 * D / 2
    return Oval(a * L**2 / EI, b / EI, g / (EI * L**2), 1 - t / (2 * r))


def _arc_residual(theta: tuple, arc: Batch) -> tuple[Batch, Batch]:
    """Load [N] beyond the compression of the arc, and its slope [N]."""
    column, target = theta
    pull = column.pull(arc)
    return target + pull.force * (1 - arc), pull.slope * (1 - arc) - pull.force


def _equilibrium_residual(theta: tuple, w: Batch) -> tuple[Batch, Batch]:
    """Compression of the arc less the load [N] at a shortening `w` [-], (O4), and its slope."""
    column, strain, cell = theta
    chord, unit = 1 - w, _force_unit(column)
    arc = (1 - strain) / chord
    pull = column.pull(1 - arc)
    n, n_slope = _interpolate_load(column, cell, w)
    by_arc = pull.slope * arc - pull.force
    slope = by_arc * arc / chord - unit * (n_slope * chord - n)
    return -pull.force * arc - n * chord * unit, slope


def _state_at_strain(column: BucklingColumn, strain: BatchLike) -> _OvalState:
    """State at `strain` [-]: straight up to the onset, then the branch's first state there."""
    branch = column.branch
    bent = strain > branch.onset + ROUNDING
    eps = guarded(bent, strain, LARGEST_STRAIN) + 0.0 * column.free_strain
    target = stop_gradient(eps)
    ends = expand_nodes(branch.strain, target)[1:]
    rank = node_axis(np.arange(float(ends.shape[0])), target)
    first = xp.min_nodes(where(ends >= target, rank, np.inf))
    cell = xp.minimum(first, ends.shape[0] - 1.0)
    low = STEP * cell
    w = root(_equilibrium_residual, (column, eps, cell), low, low + STEP, low + 0.5 * STEP)
    arc = where(bent, (1 - eps) / (1 - w), 1 - strain)
    return _OvalState(bent, cell, where(bent, w, 0.0), arc, column.pull(1 - arc))
