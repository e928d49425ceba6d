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
  F = -N = -\frac{\mathrm{d}\Pi}{\mathrm{d}x}, \tag{E2}$$

and straight, $\varepsilon_a = \varepsilon$, until $-T L_{fs} \ell$ first reaches
$4\pi^2 EI$, the onset. The largest moment, at the ends and the middle, is
$8 k K EI/L_{fs}$, the deflection $\ell k/K$.

**Branch:** followed from the free strain through the first onset. Where the buckled
branch turns back there (stubby or steep-fibered muscles), the straight state is kept up to
the onset and the force jumps; `several` says where other equilibria exist.
**Sign:** tension positive. **Valid for** $\varepsilon \le 0.6$. **Assumes** $EI$ of the tube
at rest, no shear. Moment and deflection have an infinite slope at the onset.
**Source:** derived here; the elastica after Love (1927), sections 262-263.
"""

from typing import ClassVar

import jax.numpy as jnp
from jax import lax

from .._math import Elliptic, elliptic, guarded, jacobi, root
from .._types import Batch, BatchLike, BoolBatch, IntBatch
from .column import ROUNDING, AbstractBuckling, Buckled, Centerline, Column


_ENDS_MEET = 0.8261147659879693  # 2E = K: the elastica's ends touch
_FARTHEST = 0.6  # strain, the end of the model's domain
_BRANCH = 16  # points that look for the first of several bent states
_SCAN = 64  # points that look for the first onset, and for other equilibria


class Elastica(AbstractBuckling):
    """Bending and contraction from one potential, nothing fitted: (E1) and (E2)."""

    name: ClassVar[str] = "elastica"

    def buckled(self, column: Column, strain: BatchLike) -> Buckled:
        """Forces, deflection and moment at `strain` [-], (E2)."""
        eps = jnp.asarray(strain, dtype=float)
        bent, m, arc = _state(column, self.onset(column), eps)
        mesh, bladder = column.tension.components(column.pressure, arc)
        chord = _chord(elliptic(m))
        thrust = -(mesh + bladder) / chord  # N, from the arc's balance
        length = column.rest_length * (1 - arc)
        # k = √m has an infinite slope at the onset: exempt, but not a NaN when straight
        k = jnp.where(bent, jnp.sqrt(guarded(bent, m)), 0.0)
        K = elliptic(m).K
        return Buckled(
            mesh=mesh,
            bladder=bladder,
            bending=-thrust * (1 - chord),
            deflection=length * k / K,
            moment=8 * k * K * column.bending_stiffness / column.free_length,
            arc_strain=arc,
            straight=~bent,
        )

    def onset(self, column: Column) -> Batch:
        """First strain [-] at which the straight muscle buckles; inf where it never does."""
        euler = 4 * jnp.pi**2 * column.bending_stiffness
        eps_f = column.free_strain

        def place(i: BatchLike) -> Batch:
            # squares: a slender muscle buckles just past its free strain
            return eps_f + (_FARTHEST - eps_f) * (i / _SCAN) ** 2

        def look(i: IntBatch, first: IntBatch) -> IntBatch:
            over = _arc_load(column, place(i)) >= euler
            return jnp.where(over & (first == 0), i, first)

        none = jnp.zeros(jnp.broadcast_shapes(eps_f.shape, jnp.shape(euler)), int)
        first = lax.fori_loop(1, _SCAN + 1, look, none)
        ever = first > 0
        target = guarded(ever, euler, 0.0)
        strain = root(
            lambda arc: target - _arc_load(column, arc),
            place(first - 1),
            place(first),
            start=place(first - 0.5),
        )
        return jnp.where(ever, strain, jnp.inf)

    def strain_at_moment(self, column: Column, moment: BatchLike) -> Batch:
        """First strain [-] at which the largest moment is `moment` [N·m]; inf if never.

        The moment fixes $k$ alone, $k$ the arc's compression on the branch, and both the
        strain. A moment jumped over at the onset is reached at the onset.
        """
        onset = self.onset(column)
        wanted = jnp.asarray(moment) * column.free_length / column.bending_stiffness
        largest = jnp.sqrt(_ENDS_MEET)
        reached = (wanted <= 8 * largest * elliptic(_ENDS_MEET).K) & jnp.isfinite(onset)
        k = root(
            lambda k: guarded(reached, wanted, 1.0) - 8 * k * elliptic(k**2).K,
            0.0,
            largest,
            start=jnp.full(jnp.shape(reached), 0.5),
        )
        integrals = elliptic(k**2)
        top = guarded(reached, onset, _FARTHEST)
        held = guarded(reached, _end_load(column, integrals), 0.0)
        arc = root(
            lambda arc: held - _arc_load(column, arc),
            column.free_strain,
            top,
            start=0.5 * (column.free_strain + top),
        )
        strain = jnp.maximum(1 - (1 - arc) * _chord(integrals), onset)
        return jnp.where(reached, strain, jnp.inf)

    def shape(self, column: Column, strain: BatchLike, points: int) -> Centerline:
        """Centerline [m] of the exact elastica at `strain` [-], evenly spaced on the arc."""
        eps = jnp.asarray(strain, dtype=float)
        bent, m, arc = _state(column, self.onset(column), eps)
        integrals = elliptic(m[..., None])
        u = 4 * integrals.K * jnp.linspace(0.0, 1.0, points)
        phase, epsilon = jacobi(u, integrals)
        scale = (column.rest_length * (1 - arc))[..., None] / (4 * integrals.K)
        # below the axis, as (8) is drawn
        k = jnp.where(bent, jnp.sqrt(guarded(bent, m)), 0.0)[..., None]
        return Centerline(z=scale * (2 * epsilon - u), y=-2 * k * scale * (1 - jnp.cos(phase)))

    def several(self, column: Column, strain: BatchLike) -> BoolBatch:
        """Whether other equilibria exist at `strain` [-], looked for on a fixed grid."""
        eps = jnp.asarray(strain, dtype=float)
        shape = jnp.broadcast_shapes(eps.shape, column.free_strain.shape)
        first = jnp.broadcast_to(_surplus(column, eps, jnp.zeros(shape)), shape)
        last = _modulus((1 - eps) / (1 - column.free_strain))

        def look(i: IntBatch, seen: tuple[IntBatch, Batch]) -> tuple[IntBatch, Batch]:
            count, before = seen
            # squares: equilibria crowd toward the straight end
            here = _surplus(column, eps, last * (i / _SCAN) ** 2)
            return count + ((here > 0) != (before > 0)), here

        # the straight state is stable while bending would cost more than it yields
        count, _ = lax.fori_loop(1, _SCAN + 1, look, ((first > 0).astype(int), first))
        return (count > 1) & (eps > column.free_strain)


def _chord(integrals: Elliptic) -> Batch:
    """$d/\\ell = 2E/K - 1$ [-]."""
    return 2 * integrals.E / integrals.K - 1


def _modulus(chord: BatchLike) -> Batch:
    """The parameter $m$ [-] of the elastica whose ends are `chord` of its length apart."""
    c = jnp.asarray(chord, dtype=float)
    return root(lambda m: _chord(elliptic(m)) - c, -0.5, _ENDS_MEET, start=1 - c)


def _end_load(column: Column, integrals: Elliptic) -> Batch:
    """$N L_{fs} \\ell \\cdot d/\\ell$ [N·m²], what bending asks of the arc."""
    return 16 * integrals.K**2 * _chord(integrals) * column.bending_stiffness


def _arc_load(column: Column, arc: Batch) -> Batch:
    """$-T L_{fs} \\ell$ [N·m²], what the arc at strain `arc` [-] gives."""
    length = column.rest_length * (1 - arc)
    return -column.tension.force(column.pressure, arc) * column.free_length * length


def _surplus(column: Column, strain: Batch, m: Batch) -> Batch:
    """What bending to `m` asks beyond what the arc, at the same chord, gives [N·m²]."""
    integrals = elliptic(m)
    arc = 1 - (1 - strain) / _chord(integrals)
    return _end_load(column, integrals) - _arc_load(column, arc)


def _state(column: Column, onset: Batch, strain: Batch) -> tuple[BoolBatch, Batch, Batch]:
    """Whether the muscle is bent at `strain` [-], its $m$ [-] and its arc's strain [-]."""
    eps_f = column.free_strain
    bent = strain > onset + ROUNDING
    eps = jnp.where(bent, strain, 0.5 * (eps_f + _FARTHEST))
    # on the branch from the first onset the arc lies between free strain and onset
    least = _modulus((1 - eps) / (1 - jnp.where(bent, onset, eps)))
    most = jnp.where(bent, _modulus((1 - eps) / (1 - eps_f)), least)

    def place(i: BatchLike) -> Batch:
        return least + (most - least) * (i / _BRANCH)

    def look(i: IntBatch, first: IntBatch) -> IntBatch:
        over = _surplus(column, eps, place(i)) >= 0
        return jnp.where(over & (first == 0), i, first)

    # a folded branch reaches this strain more than once: the first of them is followed
    first = lax.fori_loop(1, _BRANCH, look, jnp.zeros(jnp.shape(most), int))
    first = jnp.where(first == 0, _BRANCH, first)
    low, high = place(first - 1), place(first)
    m = root(lambda m: -_surplus(column, eps, m), low, high, start=0.5 * (low + high))
    arc = 1 - (1 - eps) / _chord(elliptic(m))
    return bent, jnp.where(bent, m, 0.0), jnp.where(bent, arc, strain)
