r"""A column whose section ovalizes as it bends: its end load over its shortening, once and for all.

A clamped-clamped column of length 1 and bending stiffness 1 has the slope $\theta(\sigma)$ and
the ovality $\zeta(\sigma)$, both even about its middle, the latter none at its ends. They make

$$\int_0^1 \tfrac12 \theta'^2 \bigl(1 - \tfrac32 \zeta + \tfrac58 \zeta^2\bigr)
  + \alpha \zeta^2 + \beta \zeta'^2 + \gamma \zeta''^2 \,\mathrm{d}\sigma, \qquad
  \int_0^1 \cos\theta \,\mathrm{d}\sigma = 1 - w, \qquad \zeta \le \zeta_t, \tag{O1}$$

stationary at a given shortening $w$; the multiplier of the chord is the load $n$. Slopes are
sines and ovality is cosines, each state is found by Newton's method from the one before, and the
load is a spline over $w$. Walls that touch are held by a spring $10^4$ times $\alpha$.

What it depends on is $\alpha, \beta, \gamma, \zeta_t$. Derivatives by them go along with the
numbers: compiled, two more of Newton's steps carry those up to the third; at once, first ones come
from the same equations.

**Resolved** are layers of ovality some $1/40$ of the length thick. **Source:** derived here.
"""

from functools import cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ...core.arrays import library, nodes, over, total, where
from ...core.roots import still
from ...core.types import Batch


_SINES, _COSINES, _POINTS = 24, 40, 112
_FARTHEST, _NODES = 0.66, 45  # past all strains of the domain
STEP = _FARTHEST / (_NODES - 1)  # of w, from node to node
_STEPS = 100  # at most: a few do, and a dozen to fifty where walls touch place after place
_DONE = 1e-9  # of the largest number of a state
_HARD = 1e4  # times α: the load is some 1e-4 off that of walls that don't sink
_LONGEST = 0.25  # of a slope, in a step


class Oval(NamedTuple):
    """What the section's ovality has and is: $\\alpha, \\beta, \\gamma, \\zeta_t$ [-]."""

    alpha: Batch
    beta: Batch
    gamma: Batch
    touch: Batch


class States(NamedTuple):
    """Of the column at each node of $w$, nodes first [-]: its load $n$; over $\\sqrt w$ how far its
    middle is off, its curvature at the end, and its sines.
    """

    load: Batch
    bow: Batch
    bend: Batch
    sines: Batch


class _Basis(NamedTuple):
    S: np.ndarray
    S1: np.ndarray
    Z: np.ndarray
    Z1: np.ndarray
    Z2: np.ndarray
    weight: float


@cache
def _basis() -> _Basis:
    """Functions and slopes at points of half the column."""
    sigma = (np.arange(_POINTS) + 0.5)[:, None] / (2 * _POINTS)
    k, j = np.arange(1, _SINES + 1), np.arange(1, _COSINES + 1)
    at, around = 2 * np.pi * k * sigma, 2 * np.pi * j * sigma
    return _Basis(
        np.sin(at) / k, 2 * np.pi * np.cos(at),
        (1 - np.cos(around)) / j**2, 2 * np.pi * np.sin(around) / j, 4 * np.pi**2 * np.cos(around),
        0.5 / _POINTS,
    )  # fmt: skip


def shortenings() -> np.ndarray:
    """The nodes $w$ [-], even; none at the first."""
    return np.linspace(0.0, _FARTHEST, _NODES)


def states(oval: Oval) -> States:
    """All states of columns with that `oval` section [-], nodes first."""
    here = Oval(*(still(x) for x in oval))
    at_work: Any = library(*here)
    at_work = jnp if at_work is jnp else np
    shape = np.broadcast_shapes(*(np.shape(x) for x in here))
    numbers = [at_work.broadcast_to(at_work.asarray(x, dtype=float), shape) for x in here]
    P = at_work.stack(numbers, axis=-1)[..., None]  # parameter, then a place for points
    x, by = _followed(at_work, P)
    w = shortenings()[1:].reshape(-1, *(1,) * (len(shape) + 1))
    if at_work is jnp:
        P = jnp.stack([jnp.broadcast_to(n, shape) for n in oval], axis=-1)[..., None]
        for _ in range(2):  # each doubles the order to which derivatives are right
            value, slopes = _residual(jnp, P, x, w)
            x = x - jnp.linalg.solve(slopes, value[..., None])[..., 0]
    rows = _kept(at_work, x, w)
    # the straight column: Euler's load, and bows that grow as the root of w
    first = np.zeros(3 + _SINES)
    first[:3] = 4 * np.pi**2, 2 / np.pi, 4 * np.pi
    first[3] = 2.0
    begun = at_work.broadcast_to(at_work.asarray(first), (1, *shape, 3 + _SINES))
    rows = at_work.concatenate([begun, rows])
    sines = at_work.moveaxis(rows[..., 3:], -1, 1)
    if at_work is jnp:
        return States(rows[..., 0], rows[..., 1], rows[..., 2], sines)
    slopes = _moved(x, by, w)
    slopes = np.concatenate([np.zeros((1, *slopes.shape[1:])), slopes])
    # each number moves with what it depends on, to first order
    moved = [x - h for x, h in zip(oval, here, strict=True)]

    def of(i: int) -> Batch:
        parts = (slopes[..., i, p] * step for p, step in enumerate(moved))
        return sum(parts, rows[..., i])

    return States(of(0), of(1), of(2), sines)


def _followed(at_work: Any, P: Any) -> tuple[Any, Any]:
    """The states at all nodes but the first, and how they move with the four numbers of `P` and
    with the shortening.
    """
    w = shortenings()[1:]
    shape = P.shape[:-2]
    start = np.zeros(_SINES + _COSINES + 1)
    start[0], start[-1] = 2 * np.sqrt(w[0]), -4 * np.pi**2 * (1 + w[0] / 2)
    x = at_work.broadcast_to(at_work.asarray(start), (*shape, start.size))
    if at_work is jnp:
        done = jax.lax.scan(lambda x, w: _next(jnp, P, x, w), x, jnp.asarray(w))[1]
        return done[0], done[1]
    rows = []
    for shortening in w:
        x, row = _next(np, P, x, shortening)
        rows.append(row)
    return tuple(np.stack(part) for part in zip(*rows, strict=True))  # type: ignore[return-value]


def _next(at_work: Any, P: Any, x: Any, w: Any) -> tuple[Any, tuple[Any, Any]]:
    """The state at a shortening `w` from one nearby, moved on to the next; itself, and how it
    moves.
    """

    def step(x: Any) -> Any:
        value, slopes = _residual(at_work, P, x, w)
        move = at_work.linalg.solve(slopes, value[..., None])[..., 0]
        long = at_work.max(at_work.abs(move[..., :_SINES]), axis=-1, keepdims=True)
        return x - move * at_work.minimum(1.0, _LONGEST / at_work.maximum(long, 1e-300))

    def on(state: Any) -> Any:
        i, x, before = state
        moving = at_work.abs(x - before) >= _DONE * at_work.max(at_work.abs(x), -1, keepdims=True)
        return (i < _STEPS) & at_work.any(moving)

    state = (1, step(x), x)
    if at_work is jnp:
        x = jax.lax.while_loop(on, lambda state: (state[0] + 1, step(state[1]), state[1]), state)[1]
    else:
        while on(state):
            state = (state[0] + 1, step(state[1]), state[1])
        x = state[1]
    _, slopes = _residual(at_work, P, x, w)
    by = at_work.linalg.solve(slopes, _by_numbers(at_work, P, x))
    return x + by[..., -1] * STEP, (x, by)


def _kept(at_work: Any, x: Any, w: Any) -> Any:
    """Load, bow, bend and sines of states `x` at shortenings `w`, on the last axis."""
    basis, root = _basis(), np.sqrt(w)
    theta = x[..., :_SINES] @ basis.S.T
    bow = basis.weight * at_work.sum(at_work.sin(theta), axis=-1, keepdims=True)
    return at_work.concatenate([
        -x[..., -1:], bow / root,
        2 * np.pi * at_work.sum(x[..., :_SINES], axis=-1, keepdims=True) / root,
        x[..., :_SINES] / np.arange(1, _SINES + 1) / root,
    ], axis=-1)  # fmt: skip


def _moved(x: Any, by: Any, w: Any) -> Any:
    """How load, bow and bend of states `x` at shortenings `w` move with the four numbers."""
    basis, root = _basis(), np.sqrt(w)
    off = basis.weight * np.cos(x[..., :_SINES] @ basis.S.T) @ basis.S  # by the sines
    sines = by[..., :_SINES, :-1]
    return np.stack([
        -by[..., -1, :-1],
        np.sum(off[..., None] * sines, axis=-2) / root,
        2 * np.pi * np.sum(sines, axis=-2) / root,
    ], axis=-2)  # fmt: skip


def _residual(at_work: Any, P: Any, x: Any, w: Any) -> tuple[Any, Any]:
    """The gradient of (O1) for half the column, with its multiplier, and the gradient's slopes."""
    b = _basis()
    h, alpha, beta, gamma, touch = b.weight, *(P[..., i, :] for i in range(4))
    t, z, load = x[..., :_SINES], x[..., _SINES:-1], x[..., -1:]
    theta, kappa, oval = t @ b.S.T, t @ b.S1.T, z @ b.Z.T
    soft, soft1 = 1 - 1.5 * oval + 0.625 * oval**2, -1.5 + 1.25 * oval
    sunk, hard = at_work.maximum(oval - touch, 0.0), _HARD * alpha
    sine = h * at_work.sin(theta) @ b.S
    stiff = 2 * h * (beta[..., None] * (b.Z1.T @ b.Z1) + gamma[..., None] * (b.Z2.T @ b.Z2))
    pressed = 0.5 * kappa**2 * soft1 + 2 * alpha * oval + 2 * hard * sunk
    value = at_work.concatenate([
        h * (soft * kappa) @ b.S1 + load * sine,
        h * pressed @ b.Z + (stiff @ z[..., None])[..., 0],
        (1 - w) / 2 - h * at_work.sum(at_work.cos(theta), axis=-1, keepdims=True),
    ], axis=-1)  # fmt: skip
    cos, cross = load * at_work.cos(theta), soft1 * kappa
    tt = h * (b.S1.T @ (soft[..., None] * b.S1) + b.S.T @ (cos[..., None] * b.S))
    tz = h * b.S1.T @ (cross[..., None] * b.Z)
    own = 0.625 * kappa**2 + 2 * alpha + 2 * hard * (sunk > 0)
    zz = h * b.Z.T @ (own[..., None] * b.Z) + stiff
    none = at_work.zeros((*x.shape[:-1], _COSINES, 1))
    last, corner = sine[..., None], at_work.zeros((*x.shape[:-1], 1, 1))
    flip = at_work.swapaxes
    slopes = at_work.concatenate([
        at_work.concatenate([tt, tz, last], axis=-1),
        at_work.concatenate([flip(tz, -1, -2), zz, none], axis=-1),
        at_work.concatenate([flip(last, -1, -2), flip(none, -1, -2), corner], axis=-1),
    ], axis=-2)  # fmt: skip
    return value, slopes


def _by_numbers(at_work: Any, P: Any, x: Any) -> Any:
    """How the gradient falls with each of the four numbers, and with the shortening, last."""
    b = _basis()
    h, alpha, touch = b.weight, P[..., 0, :], P[..., 3, :]
    z = x[..., _SINES:-1]
    oval = z @ b.Z.T
    sunk = at_work.maximum(oval - touch, 0.0)
    rows = [
        2 * h * (oval + _HARD * sunk) @ b.Z,
        2 * h * (z @ b.Z1.T) @ b.Z1,
        2 * h * (z @ b.Z2.T) @ b.Z2,
        -2 * h * (_HARD * alpha * (sunk > 0)) @ b.Z,
    ]
    at_rest = at_work.zeros((*x.shape[:-1], _SINES))
    none = at_work.zeros((*x.shape[:-1], 1))
    every = [at_work.concatenate([at_rest, -row, none], axis=-1) for row in rows]
    shorter = at_work.zeros_like(every[0]) + np.eye(1, x.shape[-1], x.shape[-1] - 1)[0] * 0.5
    return at_work.stack([*every, shorter], axis=-1)


@cache
def _spline() -> np.ndarray:
    """Slopes of a spline through numbers at the nodes, as a matrix: numbers first."""
    from scipy.interpolate import CubicSpline  # which other laws needn't wait for

    return np.ascontiguousarray(
        CubicSpline(shortenings(), np.eye(_NODES), axis=0)(shortenings(), 1).T
    )


def splined(values: Batch) -> Batch:
    """Slopes [-] at the nodes of the spline through `values` there [-], nodes first."""
    return total(_spline().reshape(_NODES, _NODES, *(1,) * (values.ndim - 1)) * values[:, None])


def between(values: Any, slopes: Any, cell: Batch, w: Batch) -> tuple[Batch, Batch]:
    """A spline's value [-] and slope [-] at a shortening `w` [-] in a `cell` [-]."""
    u = w / STEP - cell
    rank = nodes(np.arange(float(_NODES)), cell)
    values, slopes = over(values, cell), over(slopes, cell)
    ends = [where(rank == cell + i, 1.0, 0.0) for i in (0, 1)]
    (y0, y1), (m0, m1) = ([total(x * end) for end in ends] for x in (values, STEP * slopes))
    c2, c3 = 3 * (y1 - y0) - 2 * m0 - m1, 2 * (y0 - y1) + m0 + m1
    return ((c3 * u + c2) * u + m0) * u + y0, ((3 * c3 * u + 2 * c2) * u + m0) / STEP
