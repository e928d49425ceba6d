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

from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...core.array_namespace import array_namespace, expand_nodes, node_axis, sum_nodes, where
from ...core.roots import stop_gradient
from ...core.types import Batch


_SINES, _COSINES, _POINTS = 24, 40, 112
_FARTHEST, _NODES = 0.66, 45  # past all strains of the domain
STEP = _FARTHEST / (_NODES - 1)  # of w, from node to node
_STEPS = 100  # at most: a few do, and a dozen to fifty where walls touch place after place
_TOLERANCE = 1e-9  # of the largest number of a state
_WALL_PENALTY = 1e4  # times α: the load is some 1e-4 off that of walls that don't sink
_LARGEST_SLOPE_STEP = 0.25  # of a slope, in a step
# columns that are followed; more are interpolated between these, which leaves some 1e-6 of a state,
# and corrected, each time to a tenth of the error or less. Twice as many take twice as long
_FOLLOWED = 24
_TOGETHER = 48
_CORRECTIONS = 6  # at most: where walls touch in other places than a neighbor's do, none converges
_CORRECTED = 0.1  # of a correction is left


class Oval(NamedTuple):
    """Dimensionless numbers of the section's ovality: $\\alpha, \\beta, \\gamma, \\zeta_t$ [-]."""

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
    here = Oval(*(stop_gradient(x) for x in oval))
    xp: Any = array_namespace(*here)
    shape = np.broadcast_shapes(*(np.shape(x) for x in here))
    numbers = [xp.broadcast_to(xp.asarray(x, dtype=float), shape) for x in here]
    P = xp.stack(numbers, axis=-1)[..., None]  # parameter, then a place for points
    w = shortenings()[1:].reshape(-1, *(1,) * (len(shape) + 1))
    if xp is np:
        x = _solve_states(P.tobytes()).reshape(_NODES - 1, *shape, -1)
    else:
        x, _ = _follow(xp, P)
        P = xp.stack([xp.broadcast_to(n, shape) for n in oval], axis=-1)[..., None]
        for _ in range(2):  # each doubles the order to which derivatives are right
            value, slopes = _gradient(xp, P, x, w), _jacobian(xp, P, x)
            x = x - xp.linalg.solve(slopes, value[..., None])[..., 0]
    rows = _kept(xp, x, w)
    # the straight column: Euler's load, and bows that grow as the root of w
    first = np.zeros(3 + _SINES)
    first[:3] = 4 * np.pi**2, 2 / np.pi, 4 * np.pi
    first[3] = 2.0
    begun = xp.broadcast_to(xp.asarray(first), (1, *shape, 3 + _SINES))
    rows = xp.concatenate([begun, rows])
    sines = xp.moveaxis(rows[..., 3:], -1, 1)
    return States(rows[..., 0], rows[..., 1], rows[..., 2], sines)


@lru_cache(maxsize=8)  # of 12 MB for 500 columns: a search asks for the same pressures again
def _solve_states(numbers: bytes) -> np.ndarray:
    """States at all nodes but the first, of many columns on the second axis; `numbers`: the four
    of each column, as bytes.

    Some columns, evenly spread along the line of all, are followed from node to node; the others
    are found between them.
    """
    P = np.frombuffer(numbers).reshape(-1, 4, 1)
    order = np.argsort(P[:, 0, 0], kind="stable")
    P = P[order]
    steps = np.linalg.norm(np.diff(np.log(P[..., 0]), axis=0), axis=-1)
    place = np.append(0.0, np.cumsum(steps))
    even = np.searchsorted(place, np.linspace(0.0, place[-1], _FOLLOWED)[:-1])
    some = np.unique(np.append(even, len(P) - 1)) if len(P) > _FOLLOWED else np.arange(len(P))
    x, by = _follow(np, P[some])
    if len(some) < len(P):
        with np.errstate(all="ignore"):  # of corrections that diverge, after which Newton's begins
            x = _fill(P, place, some, x, by)
    x = x[:, np.argsort(order, kind="stable")]
    x.setflags(write=False)  # it is cached
    return x


def _fill(
    P: np.ndarray, place: np.ndarray, some: np.ndarray, x: np.ndarray, by: np.ndarray
) -> np.ndarray:
    """States of all columns, at their `place` on a line, from the states `x` of `some` of them and
    their slopes `by`: by cubics along the straight line between the numbers of two neighbors, and
    off it by slopes; then corrected with the inverse Jacobian of the nearer neighbor.
    """
    numbers, every = P[..., 0], np.arange(len(P))
    left = np.minimum(np.searchsorted(some, every, "right"), len(some) - 1) - 1
    along, length = np.diff(numbers[some], axis=0), np.diff(place[some])[left]
    u = ((place - place[some][left]) / np.where(length > 0, length, 1.0))[:, None]
    near = left + (u[:, 0] > 0.5)
    off = numbers - numbers[some][left] - u * along[left]
    weights = (1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2, u**2 * (3 - 2 * u), u**2 * (u - 1)
    # products this small are done by one thread, sooner than by several
    edges = (np.diff(near) > 0) | (every[1:] % _TOGETHER == 0)
    groups = np.split(every, np.flatnonzero(edges) + 1)
    rows, error = [], np.zeros((2, len(P), x.shape[-1]))
    for x_w, by_w, w in zip(x, by[..., :4], shortenings()[1:], strict=True):
        first, last = ((slope @ along[..., None])[..., 0] for slope in (by_w[:-1], by_w[1:]))
        ends = x_w[left], first[left], x_w[left + 1], last[left]
        guess = sum(weight * end for weight, end in zip(weights, ends, strict=True))
        guess = guess + (by_w[near] @ off[..., None])[..., 0]
        found = guess + 2 * error[0] - error[1]  # cubics err alike from node to node
        inverse = np.linalg.inv(_jacobian(np, P[some], x_w))
        for group in groups:
            rest = group
            for _ in range(_CORRECTIONS):
                move = _gradient(np, P[rest], found[rest], w) @ inverse[near[group[0]]].T
                found[rest] -= move
                rest = rest[_moves(np, _CORRECTED * move, found[rest])[:, 0]]
                if not len(rest):
                    break
            else:
                found[rest], _ = _newton(np, P[rest], guess[rest], w)
        rows.append(found)
        error = np.stack([found - guess, error[0]])
    return np.stack(rows)


def _follow(xp: Any, P: Any) -> tuple[Any, Any]:
    """The states at all nodes but the first, and how they move with the four numbers of `P` and
    with the shortening.
    """
    w = shortenings()[1:]
    shape = P.shape[:-2]
    start = np.zeros(_SINES + _COSINES + 1)
    start[0], start[-1] = 2 * np.sqrt(w[0]), -4 * np.pi**2 * (1 + w[0] / 2)
    x = xp.broadcast_to(xp.asarray(start), (*shape, start.size))
    if xp is not np:
        from ...core.jax_backend import lax

        done = lax.scan(lambda x, w: _next(xp, P, x, w), x, xp.asarray(w))[1]
        return done[0], done[1]
    rows = []
    for shortening in w:
        x, row = _next(np, P, x, shortening)
        rows.append(row)
    return tuple(np.stack(part) for part in zip(*rows, strict=True))  # type: ignore[return-value]


def _next(xp: Any, P: Any, x: Any, w: Any) -> tuple[Any, tuple[Any, Any]]:
    """The state at a shortening `w` from one nearby, moved on to the next; itself, and how it
    moves.
    """
    x, slopes = _newton(xp, P, x, w)
    by = xp.linalg.solve(slopes, _gradient_by_numbers(xp, P, x))
    return x + by[..., -1] * STEP, (x, by)


def _moves(xp: Any, move: Any, x: Any) -> Any:
    """True where a `move` of a state `x` is larger than rounding."""
    size = xp.max(xp.abs(x), axis=-1, keepdims=True)
    return ~xp.all(xp.abs(move) < _TOLERANCE * size, axis=-1, keepdims=True)  # NaN moves


def _newton(xp: Any, P: Any, x: Any, w: Any) -> tuple[Any, Any]:
    """The state at a shortening `w`, by Newton's method from one nearby; and the Jacobian."""

    def step(i: Any, x: Any) -> Any:
        slopes = _jacobian(xp, P, x)
        move = xp.linalg.solve(slopes, _gradient(xp, P, x, w)[..., None])[..., 0]
        long = xp.max(xp.abs(move[..., :_SINES]), axis=-1, keepdims=True)
        short = move * xp.minimum(1.0, _LARGEST_SLOPE_STEP / xp.maximum(long, 1e-300))
        return i + 1, x - short, short, slopes

    def on(state: Any) -> Any:
        i, x, move, _ = state
        return (i < _STEPS) & xp.any(_moves(xp, move, x))

    state = step(0, x)
    if xp is not np:
        from ...core.jax_backend import lax

        state = lax.while_loop(on, lambda state: step(*state[:2]), state)
    else:
        while on(state):
            state = step(*state[:2])
    return state[1], state[3]


def _kept(xp: Any, x: Any, w: Any) -> Any:
    """Load, bow, bend and sines of states `x` at shortenings `w`, on the last axis."""
    basis, root = _basis(), np.sqrt(w)
    theta = x[..., :_SINES] @ basis.S.T
    bow = basis.weight * xp.sum(xp.sin(theta), axis=-1, keepdims=True)
    return xp.concatenate([
        -x[..., -1:], bow / root,
        2 * np.pi * xp.sum(x[..., :_SINES], axis=-1, keepdims=True) / root,
        x[..., :_SINES] / np.arange(1, _SINES + 1) / root,
    ], axis=-1)  # fmt: skip


class _Section(NamedTuple):
    """A state at the points: slope, curvature, ovality, how soft that makes the section and its
    slope, and how far touching walls have sunk.
    """

    theta: Any
    kappa: Any
    oval: Any
    soft: Any
    soft_slope: Any
    sunk: Any


def _section(xp: Any, P: Any, x: Any) -> _Section:
    b = _basis()
    t, z = x[..., :_SINES], x[..., _SINES:-1]
    oval = z @ b.Z.T
    return _Section(
        t @ b.S.T, t @ b.S1.T, oval, 1 - 1.5 * oval + 0.625 * oval**2, -1.5 + 1.25 * oval,
        xp.maximum(oval - P[..., 3, :], 0.0),
    )  # fmt: skip


def _gradient(xp: Any, P: Any, x: Any, w: Any) -> Any:
    """The gradient of (O1) for half the column, with its multiplier."""
    b, here = _basis(), _section(xp, P, x)
    h, alpha, beta, gamma = b.weight, *(P[..., i, :] for i in range(3))
    z, load = x[..., _SINES:-1], x[..., -1:]
    squashing = 0.5 * here.kappa**2 * here.soft_slope
    pressed = squashing + 2 * alpha * (here.oval + _WALL_PENALTY * here.sunk)
    return xp.concatenate([
        h * ((here.soft * here.kappa) @ b.S1 + load * (xp.sin(here.theta) @ b.S)),
        h * (pressed @ b.Z + 2 * (beta * (z @ b.Z1.T) @ b.Z1 + gamma * (z @ b.Z2.T) @ b.Z2)),
        (1 - w) / 2 - h * xp.sum(xp.cos(here.theta), axis=-1, keepdims=True),
    ], axis=-1)  # fmt: skip


def _jacobian(xp: Any, P: Any, x: Any) -> Any:
    """The slopes of the gradient."""
    b, here = _basis(), _section(xp, P, x)
    h, alpha, beta, gamma = b.weight, *(P[..., i, :] for i in range(3))
    load = x[..., -1:]
    sine = h * xp.sin(here.theta) @ b.S
    stiff = 2 * h * (beta[..., None] * (b.Z1.T @ b.Z1) + gamma[..., None] * (b.Z2.T @ b.Z2))
    cos, cross = load * xp.cos(here.theta), here.soft_slope * here.kappa
    tt = h * (b.S1.T @ (here.soft[..., None] * b.S1) + b.S.T @ (cos[..., None] * b.S))
    tz = h * b.S1.T @ (cross[..., None] * b.Z)
    own = 0.625 * here.kappa**2 + 2 * alpha * (1 + _WALL_PENALTY * (here.sunk > 0))
    zz = h * b.Z.T @ (own[..., None] * b.Z) + stiff
    none = xp.zeros((*x.shape[:-1], _COSINES, 1))
    last, corner = sine[..., None], xp.zeros((*x.shape[:-1], 1, 1))
    flip = xp.swapaxes
    return xp.concatenate([
        xp.concatenate([tt, tz, last], axis=-1),
        xp.concatenate([flip(tz, -1, -2), zz, none], axis=-1),
        xp.concatenate([flip(last, -1, -2), flip(none, -1, -2), corner], axis=-1),
    ], axis=-2)  # fmt: skip


def _gradient_by_numbers(xp: Any, P: Any, x: Any) -> Any:
    """Negative slopes of the gradient by each of the four numbers, and by the shortening, last."""
    b = _basis()
    h, alpha, touch = b.weight, P[..., 0, :], P[..., 3, :]
    z = x[..., _SINES:-1]
    oval = z @ b.Z.T
    sunk = xp.maximum(oval - touch, 0.0)
    rows = [
        2 * h * (oval + _WALL_PENALTY * sunk) @ b.Z,
        2 * h * (z @ b.Z1.T) @ b.Z1,
        2 * h * (z @ b.Z2.T) @ b.Z2,
        -2 * h * (_WALL_PENALTY * alpha * (sunk > 0)) @ b.Z,
    ]
    at_rest = xp.zeros((*x.shape[:-1], _SINES))
    none = xp.zeros((*x.shape[:-1], 1))
    every = [xp.concatenate([at_rest, -row, none], axis=-1) for row in rows]
    shorter = xp.zeros_like(every[0]) + np.eye(1, x.shape[-1], x.shape[-1] - 1)[0] * 0.5
    return xp.stack([*every, shorter], axis=-1)


@cache
def _spline() -> np.ndarray:
    """Slopes of a spline through numbers at the nodes, as a matrix: numbers first."""
    from scipy.interpolate import CubicSpline  # which other laws needn't wait for

    return np.ascontiguousarray(
        CubicSpline(shortenings(), np.eye(_NODES), axis=0)(shortenings(), 1).T
    )


def spline_slopes(values: Batch) -> Batch:
    """Slopes [-] at the nodes of the spline through `values` there [-], nodes first."""
    return sum_nodes(_spline().reshape(_NODES, _NODES, *(1,) * (values.ndim - 1)) * values[:, None])


def interpolate_spline(values: Any, slopes: Any, cell: Batch, w: Batch) -> tuple[Batch, Batch]:
    """A spline's value [-] and slope [-] at a shortening `w` [-] in a `cell` [-]."""
    u = w / STEP - cell
    rank = node_axis(np.arange(float(_NODES)), cell)
    values, slopes = expand_nodes(values, cell), expand_nodes(slopes, cell)
    ends = [where(rank == cell + i, 1.0, 0.0) for i in (0, 1)]
    (y0, y1), (m0, m1) = ([sum_nodes(x * end) for end in ends] for x in (values, STEP * slopes))
    c2, c3 = 3 * (y1 - y0) - 2 * m0 - m1, 2 * (y0 - y1) + m0 + m1
    return ((c3 * u + c2) * u + m0) * u + y0, ((3 * c3 * u + 2 * c2) * u + m0) / STEP
