r"""Post-buckling from one energy: the exact elastica on a muscle that also contracts.

The muscle's axis is an arc $\ell = L_0 (1 - \varepsilon_a)$ between clamped ends a chord
$d = L_0 (1 - \varepsilon)$ apart. The tension law $T$ goes on past the free strain as
compression of the arc, and the arc bends as an inextensible clamped-clamped elastica, with
curvature counted on the length at free strain. With $m = k^2$ and complete elliptic
integrals $K$, $E$ of parameter $m$,

$$\Pi = \int_{\varepsilon_f}^{\varepsilon_a} (-T) L_0 \,\mathrm{d}\varepsilon
  + \frac{EI}{L_{fs}} 32 K^2 \left(\frac{E}{K} - 1 + k^2\right), \qquad
  \frac{2E}{K} - 1 = \frac{d}{\ell}. \tag{E1}$$

It is stationary in $\varepsilon_a$ where the arc's compression balances the end load,

$$-T(P, \varepsilon_a) = N \frac{d}{\ell}, \qquad N = \frac{16 K^2 EI}{L_{fs} \ell}, \qquad
  F = -N = -\frac{\mathrm{d}\Pi}{\mathrm{d}x}, \tag{E3}$$

and straight, $\varepsilon_a = \varepsilon$, until $-T L_{fs} \ell$ first reaches
$4\pi^2 EI$, the onset. The largest moment, at the ends and the middle, is
$8 k K EI/L_{fs}$, the deflection $\ell k/K$.

With $q = K (2E - K)$, $c = 2E/K - 1$ and the arc's load

$$G(\varepsilon_a) = -\frac{T(P, \varepsilon_a) L_{fs} \ell}{16 EI}, \qquad
  G = q(m), \qquad
  \varepsilon(\varepsilon_a) = 1 - (1 - \varepsilon_a)\, c(q^{-1}(G)) \tag{E6}$$

wherever $0 \le G \le \pi^2/4$: all bent states are one explicit curve over $\varepsilon_a$, and
$c(q^{-1})$ is a polynomial of one variable. The curve turns back, in a fold, where
$c - (1 - \varepsilon_a) c' G'/q' = 0$; just past the onset it goes on only if
$G' > \pi^2/(8 (1 - \varepsilon))$ there.

**Branch:** followed from the free strain through the first onset, along the curve. Where it
turns back (stubby or steep-fibered muscles) the force jumps: from the straight state at the
onset, if it turns back there, else at its fold, to the next state that the same strain allows.
`several` says where other equilibria exist.
**Sign:** tension positive. **Valid for** $\varepsilon \le 0.6$. **Assumes** $EI$ of the tube
at rest and (B2), no shear. Moment and deflection have an infinite slope at the onset.
**Source:** derived here; the elastica after Love (1927), sections 262-263.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.polynomial import polyder, polyval

from ...core import array_namespace as xp
from ...core.array_namespace import arcsin, expand_nodes, logical_and, node_axis, sin, sqrt, where
from ...core.roots import guarded, root, stop_gradient
from ...core.types import Batch, BatchLike, BoolBatch
from ...core.validation import LARGEST_STRAIN
from ..tension import Pull
from . import BRAID_SHARE, ROUNDING, SHEAR, AbstractBuckling, BucklingColumn, Centerline, Push


_ENDS_MEET = 0.8261147659879693  # m where 2E = K: the elastica's ends touch
_EULER = np.pi**2 / 4  # G at which a straight column begins to bend
_ONSET_CELLS = 32  # of the search for the onset: enough to separate loads that rise and fall
_CURVE_CELLS = 24  # of the curve: enough to separate its folds
_SECANT_STEPS = 4  # to the extremum of strain or load in a cell, which leave an error of 1e-12
_DEGREE = 16  # of the polynomials: right to 2e-15
_AGM_STEPS = 6  # the mean's error squares at each step: 5 suffice up to m = 0.9


class Elastica(AbstractBuckling):
    """Bending and contraction from one potential, nothing fitted: (E1) to (E6)."""

    name: ClassVar[str] = "elastica"
    source: ClassVar[str] = "derived here, the elastica after Love (1927)"

    braid_share: Batch = BRAID_SHARE.field()
    shear: str = SHEAR.field()

    def branch(self, column: BucklingColumn) -> "_ElasticaBranch":
        """Onset [-] of a `column`, and the curve (E6) from there down to the free strain."""
        onset = first_onset(column)
        fixed = stop_gradient(column)
        return _ElasticaBranch(onset, _curve(fixed, stop_gradient(onset), fixed.free_strain))

    def push(self, column: BucklingColumn, strain: BatchLike) -> Push:
        """Force by mesh, bladder, bending, its slope and the arc's strain at `strain` [-], (E3)."""
        bent, arc = _bent_arc(column, strain)
        state = bent_state(column, arc)
        # straight at its free strain, an arc has a load of 0, which gives a chord of 0
        pull, T, chord = state.pull, state.pull.force, guarded(bent, state.chord)
        # dF/dε_a over dε/dε_a, of F = T/c; vertical at a fold
        slope = (pull.slope - T * state.chord_slope / chord) / chord
        slope = slope / guarded(state.strain_slope != 0, state.strain_slope)
        return Push.of_arc(pull, arc, bent, T / chord, slope)

    def bow(self, column: BucklingColumn, strain: BatchLike) -> tuple[Batch, Batch]:
        """Deflection $\\ell k/K$ [m] and bending moment $8kK EI/L_{fs}$ [N·m] at `strain` [-]."""
        bent, arc = _bent_arc(column, strain)
        k, K = _modulus(bent, bent_state(column, arc).load)
        moment = 8 * k * K * column.bending_stiffness / column.free_length
        return column.rest_length * (1 - arc) * k / K, moment

    def folds(self, column: BucklingColumn) -> tuple[Batch, ...]:
        """One-entry tuple: strain [-] of the fold past the onset, where force jumps, or inf."""
        onset, curve = column.branch
        cut, end = expand_nodes(curve.cut.strain, 0.0), expand_nodes(curve.end.strain, 0.0)
        bracket = _first_bracket(curve, cut < curve.start.strain, end < cut)
        # the strain is flat over the arc at a fold, which needs no slope of its own
        fold = bent_state(column, bracket.start).strain
        exists = logical_and(bracket.exists, xp.isfinite(onset))
        return (where(logical_and(exists, bracket.start < stop_gradient(onset)), fold, np.inf),)

    def strain_at_moment(self, column: BucklingColumn, moment: BatchLike) -> Batch:
        """First strain [-] at which the bending moment reaches `moment` [N·m]; inf if never.

        A moment that is skipped at the onset or at a fold is reached where the jump begins.
        """
        # the moment fixes m alone, m the arc's load on the branch, and both the strain
        onset, curve = column.branch
        buckles, fits = xp.isfinite(onset), _FITS
        onset = guarded(buckles, onset, 0.0)
        bend = moment * column.free_length / (8 * column.bending_stiffness)  # kK
        reachable = logical_and(bend <= fits.largest_bend, buckles)
        square = (guarded(reachable, bend, 0.5) / fits.largest_bend) ** 2
        load = polyval(2 * square - 1, fits.load) + 0.0 * onset
        fixed = stop_gradient(load)
        bracket = _first_bracket(
            curve, *(expand_nodes(points.load, fixed) <= fixed for points in curve[1:])
        )
        arc = root(_load_residual, (column, load), bracket.stop, bracket.start, bracket.middle)
        strain = xp.maximum(1 - (1 - arc) * _chord(load)[0], onset)
        return where(reachable, xp.maximum(strain, bracket.largest_strain), np.inf)

    def shape(self, column: BucklingColumn, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] of the exact elastica at `strain` [-], evenly spaced on the arc."""
        bent, arc = _bent_arc(column, strain)
        k = xp.add_table_axis(_modulus(bent, bent_state(column, arc).load)[0])
        integrals = elliptic(k**2)
        u = 4 * integrals.K * np.linspace(0.0, 1.0, points)
        phase, epsilon = jacobi(u, integrals)
        scale = xp.add_table_axis(column.rest_length * (1 - arc)) / (4 * integrals.K)
        # below the axis, as (8) is drawn
        return Centerline(z=scale * (2 * epsilon - u), y=-2 * k * scale * (1 - xp.cos(phase)))

    def several(self, column: BucklingColumn, strain: BatchLike) -> BoolBatch:
        """True where a `column` has several equilibria at `strain` [-]."""
        # all bent states lie on (E6), between the free strain and `strain`; the straight one is an
        # equilibrium while G < π²/4. Where G is larger (E6) goes on as ε = ε_a, which crosses
        # `strain` once, as it must
        fixed, eps = stop_gradient(column), stop_gradient(strain + 0.0 * column.free_strain)
        domain_end = _curve(fixed, fixed.branch.onset, LARGEST_STRAIN)
        count = 0.0 * eps
        for curve in (fixed.branch.curve, domain_end):
            is_past = [expand_nodes(points.strain, eps) > eps for points in curve]
            for first, second in pairwise(is_past):
                count = count + xp.sum_nodes(where(first != second, 1.0, 0.0))
        straight = where(bent_state(fixed, eps).load < _EULER, 1.0, -1.0)
        # counts are whole numbers: more than the one that is followed
        return logical_and(count + straight > 1.5, eps > fixed.free_strain)


class BentState(NamedTuple):
    """Bent state at an arc's strain: load, chord over arc and strain [-], with slopes in it."""

    pull: Pull
    load: Batch
    load_slope: Batch
    chord: Batch
    chord_slope: Batch
    strain: Batch
    strain_slope: Batch


def bent_state(column: BucklingColumn, arc: Batch) -> BentState:
    """State (E6) at an arc's strain [-]; straight where the load $G$ is above $\\pi^2/4$."""
    pull = column.pull(arc)
    unit = column.free_length * column.rest_length / (16 * column.bending_stiffness)
    load = -unit * pull.force * (1 - arc)
    load_slope = unit * (pull.force - pull.slope * (1 - arc))
    chord, by_load = _chord(load)
    chord_slope = by_load * load_slope
    strain, strain_slope = 1 - (1 - arc) * chord, chord - (1 - arc) * chord_slope
    return BentState(pull, load, load_slope, chord, chord_slope, strain, strain_slope)


def _load_residual(theta: tuple, arc: Batch) -> tuple[Batch, Batch]:
    """Target load minus that of an arc [-], and its slope."""
    column, target = theta
    state = bent_state(column, arc)
    return target - state.load, -state.load_slope


def _strain_residual(theta: tuple, arc: Batch) -> tuple[Batch, Batch]:
    """Strain at an `arc`, the strain of its own length, minus its target [-], and its slope."""
    column, target = theta
    state = bent_state(column, arc)
    return state.strain - target, state.strain_slope


class _Points(NamedTuple):
    """Starts, cuts or ends of the curve's cells: arc, strain and load [-], cells first."""

    arc: Batch
    strain: Batch
    load: Batch


class _Curve(NamedTuple):
    """Part of (E6) in cells, each cut at its extremum: each half of a cell is monotone."""

    start: _Points
    cut: _Points
    end: _Points


class _ElasticaBranch(NamedTuple):
    """State at a pressure: the `onset` [-], and the `curve` from there to free strain."""

    onset: Batch
    curve: _Curve


class _Bracket(NamedTuple):
    """Half a cell, from arc `start` to `stop` [-]; the largest strain [-] at ends before it."""

    start: Batch
    stop: Batch
    largest_strain: Batch
    exists: BoolBatch

    @property
    def middle(self) -> Batch:
        return 0.5 * (self.start + self.stop)


def first_onset(column: BucklingColumn) -> Batch:
    """First strain [-] at which the straight muscle buckles, (E5); inf where it never does."""
    fixed = stop_gradient(column)
    free = fixed.free_strain
    # a free strain past the domain's end would leave cells of no length
    span = xp.maximum(LARGEST_STRAIN - free, 1e-3)
    # squares: a slender muscle buckles just past its free strain
    rank = node_axis(np.arange(float(_ONSET_CELLS)), free)
    low, high = (free + span * ((rank + i) / _ONSET_CELLS) ** 2 for i in (0.0, 1.0))
    # a load that rises and falls again within a cell may be large enough in between
    curve = _cut_cells(fixed, low, high, lambda state: state.load_slope)
    bracket = _first_bracket(curve, curve.cut.load >= _EULER, curve.end.load >= _EULER)
    buckles = logical_and(bracket.exists, free < LARGEST_STRAIN)
    theta = (column, where(buckles, _EULER, 0.0))
    strain = root(_load_residual, theta, bracket.start, bracket.stop, bracket.middle)
    return where(buckles, strain, np.inf)


def _curve(column: BucklingColumn, onset: Batch, bottom: BatchLike) -> _Curve:
    """Curve (E6) in cells from the arc strain `onset` [-], or the domain's end, to `bottom` [-]."""
    top = guarded(xp.isfinite(onset), onset, LARGEST_STRAIN)
    rank = node_axis(np.arange(float(_CURVE_CELLS)), top)
    low, high = (top - (top - bottom) * ((rank + i) / _CURVE_CELLS) for i in (0.0, 1.0))
    return _cut_cells(column, low, high, lambda state: state.strain_slope)


def _cut_cells(
    column: BucklingColumn, low: Batch, high: Batch, slope: Callable[[BentState], Batch]
) -> _Curve:
    """Cut each cell of arc strains [-] once: where `slope` changes sign, else in the middle."""
    # the error of the extremum is the square of the cut's
    start, end = bent_state(column, low), bent_state(column, high)
    a, b = (low, slope(start)), (high, slope(end))
    crosses = a[1] * b[1] < 0
    cut = 0.5 * (low + high)
    state = bent_state(column, cut)
    for _ in range(_SECANT_STEPS):
        point = (cut, slope(state))
        beside_a = (point[1] > 0) == (a[1] > 0)
        beside_b = xp.logical_not(beside_a)
        a = tuple(where(beside_a, new, old) for new, old in zip(point, a, strict=True))
        b = tuple(where(beside_b, new, old) for new, old in zip(point, b, strict=True))
        fraction = guarded(crosses, a[1]) / guarded(crosses, a[1] - b[1], 2.0)
        cut = where(crosses, a[0] + fraction * (b[0] - a[0]), cut)
        state = bent_state(column, cut)
    ends = ((low, start), (cut, state), (high, end))
    return _Curve(*(_Points(arc, point.strain, point.load) for arc, point in ends))


def _first_bracket(curve: _Curve, at_cut: BoolBatch, at_end: BoolBatch) -> _Bracket:
    """First half cell at whose end a condition holds, else the last one."""
    count = curve.start.arc.shape[0]
    rank = node_axis(np.arange(float(count)), xp.min_nodes(where(at_end, 0.0, 0.0)))
    first_cut, first_end = (xp.min_nodes(where(x, rank, np.inf)) for x in (at_cut, at_end))
    cell = xp.minimum(xp.minimum(first_cut, first_end), count - 1.0)
    ends_at_cut = first_cut <= cell
    is_cell = rank == cell
    start, cut, end = (xp.sum_nodes(where(is_cell, expand_nodes(x.arc, cell), 0.0)) for x in curve)
    cut_strain, end_strain = (expand_nodes(x.strain, cell) for x in curve[1:])
    previous = where(logical_and(is_cell, xp.logical_not(ends_at_cut)), cut_strain, -np.inf)
    largest_strain = xp.max_nodes(where(rank < cell, xp.maximum(cut_strain, end_strain), previous))
    low, high = where(ends_at_cut, start, cut), where(ends_at_cut, cut, end)
    return _Bracket(low, high, largest_strain, xp.isfinite(xp.minimum(first_cut, first_end)))


def _bent_arc(column: BucklingColumn, strain: BatchLike) -> tuple[BoolBatch, Batch]:
    """True where the muscle is bent at `strain` [-], and its arc's strain [-]."""
    onset, curve = column.branch
    bent = strain > onset + ROUNDING
    eps = guarded(bent, strain, LARGEST_STRAIN)
    fixed = stop_gradient(eps)
    bracket = _first_bracket(
        curve, *(expand_nodes(points.strain, fixed) >= fixed for points in curve[1:])
    )
    arc = root(_strain_residual, (column, eps), bracket.stop, bracket.start, bracket.middle)
    return bent, where(bent, arc, strain)


class _Fits(NamedTuple):
    """Polynomials scaled to [-1, 1]: chord, slope and $m$ of the load, load of the squared bend."""

    chord: np.ndarray
    chord_slope: np.ndarray
    parameter: np.ndarray
    load: np.ndarray
    largest_bend: float


def _fit_polynomials() -> _Fits:
    """Chord, its slope and $m$ over the load, and load over the squared bend, as polynomials."""
    # a search for m at each load would need dK/dm and dE/dm, which are 0/0 at the onset, m = 0
    low, high = -0.03, _ENDS_MEET + 0.02  # beyond both ends, where a search may step
    # many more points than the degree needs, so that nothing is aliased
    m = 0.5 * (low + high) + 0.5 * (high - low) * chebyshev.chebpts1(200)
    K, E = elliptic(m)[:2]
    largest_bend = float(np.sqrt(_ENDS_MEET) * elliptic(_ENDS_MEET).K)
    load = K * (2 * E - K)
    scaled_load, scaled_bend = load * (2 / _EULER) - 1, m * K**2 * (2 / largest_bend**2) - 1
    chord, parameter, load = (
        chebyshev.cheb2poly(chebyshev.chebfit(x, y, _DEGREE))
        for x, y in ((scaled_load, 2 * E / K - 1), (scaled_load, m), (scaled_bend, load))
    )
    return _Fits(chord, polyder(chord) * (2 / _EULER), parameter, load, largest_bend)


def _chord(load: Batch) -> tuple[Batch, Batch]:
    """Chord over arc [-] and its slope by the load $G$; 1 and 0 where no bent state exists."""
    bends = load <= _EULER * (1 + 1e-12)  # at the onset it is this, or a rounding more
    inside = xp.maximum(guarded(bends, load, _EULER), -0.05)  # its ends have met at 0
    x = inside * (2 / _EULER) - 1
    chord, slope = (polyval(x, c) for c in (_FITS.chord, _FITS.chord_slope))
    return where(bends, chord, 1.0), where(bends, slope, 0.0)


def _modulus(bent: BoolBatch, load: Batch) -> tuple[Batch, Batch]:
    """Modulus $k$ and complete integral $K$ [-] of an elastica under a load $G$ [-]."""
    m = polyval(guarded(bent, load, _EULER) * (2 / _EULER) - 1, _FITS.parameter)
    # k = √m has an infinite slope at the onset: exempt, but not a NaN when straight
    curved = logical_and(bent, m > 0)
    k = where(curved, xp.sqrt(guarded(curved, m)), 0.0)
    return k, elliptic(k**2).K


class Elliptic(NamedTuple):
    """Complete elliptic integrals by the arithmetic-geometric mean, and its steps for incomplete
    ones: Abramowitz and Stegun (1964), 17.6.
    """

    K: Batch
    E: Batch
    means: tuple[Batch, ...]
    differences: tuple[Batch, ...]


def elliptic(m: BatchLike) -> Elliptic:
    """$K(m)$ and $E(m)$ of parameter $m = k^2$ in [0, 0.9], smooth at $m = 0$."""
    a, b = 1.0 + 0.0 * m, sqrt(1.0 - m)
    means, differences, total = [a], [0.0 * m], 0.5 * m
    for n in range(_AGM_STEPS):
        a, b, c = (a + b) / 2, sqrt(a * b), (a - b) / 2
        means.append(a)
        differences.append(c)
        total = total + 2**n * c**2
    K = np.pi / (2 * a)
    return Elliptic(K, K * (1 - total), tuple(means), tuple(differences))


def jacobi(u: BatchLike, integrals: Elliptic) -> tuple[Batch, Batch]:
    r"""Jacobi's amplitude $\varphi = \mathrm{am}(u)$ and the incomplete integral $E(\varphi)$."""
    phase = 2.0**_AGM_STEPS * integrals.means[-1] * u
    epsilon = u * integrals.E / integrals.K
    for a, c in zip(integrals.means[:0:-1], integrals.differences[:0:-1], strict=True):
        epsilon = epsilon + c * sin(phase)
        phase = (phase + arcsin(c / a * sin(phase))) / 2
    return phase, epsilon


_FITS = _fit_polynomials()
