r"""A column whose section ovalizes as it bends: its end load over its shortening.

A clamped-clamped column of length 1 and bending stiffness 1 has the slope $\theta(\sigma)$ and
the ovality $\zeta(\sigma)$, both even about its middle, the latter none at its ends. They make

$$\int_0^1 \tfrac12 \theta'^2 \bigl(1 - \tfrac32 \zeta + \tfrac58 \zeta^2\bigr)
  + \alpha \zeta^2 + \beta \zeta'^2 + \gamma \zeta''^2 \,\mathrm{d}\sigma, \qquad
  \int_0^1 \cos\theta \,\mathrm{d}\sigma = 1 - w, \qquad \zeta \le \zeta_t, \tag{O1}$$

stationary at a given shortening $w$; the multiplier of the chord is the load $n$. Slopes are
sines and ovality is cosines, each state is found by Newton's method from the one before, and the
load is a spline over $w$. Walls that touch are held by a spring $10^4$ times $\alpha$.

It depends on $\alpha, \beta, \gamma, \zeta_t$ alone. Compiled, two more of Newton's steps carry
derivatives by them up to the third.

**Resolved** are layers of ovality some $1/40$ of the length thick. **Source:** derived here.
"""

from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...core.array_namespace import array_namespace, expand_nodes, node_axis, sum_nodes, where
from ...core.roots import stop_gradient
from ...core.types import Batch


_SINES, _COSINES, _POINTS = 24, 40, 112  # resolve layers of ovality 1/40 of the length thick
_FARTHEST, _NODES = 0.66, 45  # past all strains of the domain, splines to 1e-6
STEP = _FARTHEST / (_NODES - 1)  # of w, from node to node
_STEPS = 100  # at most: a few do, and a dozen to fifty where walls touch one after the other
_TOLERANCE = 1e-9  # of a state's largest number: one more Newton step reaches rounding
_WALL_PENALTY = 1e4  # times α: the load is some 1e-4 off that of walls that don't sink
_LARGEST_SLOPE_STEP = 0.25  # rad in a Newton step: longer ones leave the branch
# columns that are followed; more are interpolated between these, which leaves some 1e-6 of a state,
# and corrected, each time to a tenth of the error or less. Twice as many take twice as long
_FOLLOWED = 24
_GROUP_SIZE = 48  # products this small are done by one thread, sooner than by several
_CORRECTIONS = 6  # at most: where the touching walls are not the neighbor's, none converges
_ERROR_RATIO = 0.1  # of a correction, that remains after it


class Oval(NamedTuple):
    """Dimensionless numbers of the section's ovality: $\\alpha, \\beta, \\gamma, \\zeta_t$ [-]."""

    alpha: Batch
    beta: Batch
    gamma: Batch
    touch: Batch


class ColumnStates(NamedTuple):
    """Load at the nodes of $w$ [-]; over $\\sqrt w$ deflection, end's curvature and sines [-]."""

    load: Batch
    bow: Batch
    bend: Batch
    sines: Batch


class _Basis(NamedTuple):
    """Sines S and 1 - cosines Z at the points, their slopes, and the weight of a point."""

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
    s, z = 2 * np.pi * k * sigma, 2 * np.pi * j * sigma
    return _Basis(
        np.sin(s) / k, 2 * np.pi * np.cos(s),
        (1 - np.cos(z)) / j**2, 2 * np.pi * np.sin(z) / j, 4 * np.pi**2 * np.cos(z),
        0.5 / _POINTS,
    )  # fmt: skip


def shortenings() -> np.ndarray:
    """Shortenings $w$ [-] of the nodes, evenly spaced from zero."""
    return np.linspace(0.0, _FARTHEST, _NODES)


def states(oval: Oval) -> ColumnStates:
    """Bent states at all shortenings of columns with `oval` sections [-], nodes first."""
    fixed = Oval(*(stop_gradient(x) for x in oval))
    xp: Any = array_namespace(*fixed)
    # the four numbers, then an axis of points
    P = xp.stack(xp.broadcast_arrays(*fixed), axis=-1)[..., None]
    shape = P.shape[:-2]
    w = shortenings()[1:].reshape(-1, *(1,) * (len(shape) + 1))
    if xp is np:
        x = _solve_states(P.tobytes()).reshape(_NODES - 1, *shape, -1)
    else:
        x, _ = _follow(xp, P)
        P = xp.stack(xp.broadcast_arrays(*oval), axis=-1)[..., None]
        for _ in range(2):  # each doubles the order to which derivatives are right
            value, slopes = _gradient(xp, P, x, w), _jacobian(xp, P, x)
            x = x - xp.linalg.solve(slopes, value[..., None])[..., 0]
    # load, bow, bend and sines on the last axis
    basis, root_w = _basis(), np.sqrt(w)
    slopes = x[..., :_SINES]
    bow = basis.weight * xp.sum(xp.sin(slopes @ basis.S.T), axis=-1, keepdims=True)
    rows = xp.concatenate([
        -x[..., -1:], bow / root_w, 2 * np.pi * xp.sum(slopes, axis=-1, keepdims=True) / root_w,
        slopes / np.arange(1, _SINES + 1) / root_w,
    ], axis=-1)  # fmt: skip
    # the straight column: Euler's load, and bows that grow as the root of w
    straight = np.zeros(3 + _SINES)
    straight[:4] = 4 * np.pi**2, 2 / np.pi, 4 * np.pi, 2.0
    first = xp.broadcast_to(xp.asarray(straight), (1, *shape, 3 + _SINES))
    rows = xp.concatenate([first, rows])
    return ColumnStates(rows[..., 0], rows[..., 1], rows[..., 2], xp.moveaxis(rows[..., 3:], -1, 1))


@lru_cache(maxsize=8)  # of 12 MB for 500 columns: a search asks for the same pressures again
def _solve_states(numbers: bytes) -> np.ndarray:
    """States at all nodes but the first, columns on the second axis; `numbers`: those of `Oval` for
    each column, as bytes. Some columns are followed, the others interpolated between them.
    """
    P = np.frombuffer(numbers).reshape(-1, 4, 1)
    order = np.argsort(P[:, 0, 0], kind="stable")
    P = P[order]
    steps = np.linalg.norm(np.diff(np.log(P[..., 0]), axis=0), axis=-1)
    distance = np.append(0.0, np.cumsum(steps))
    even = np.searchsorted(distance, np.linspace(0.0, distance[-1], _FOLLOWED)[:-1])
    indices = np.arange(len(P))
    if len(P) > _FOLLOWED:
        indices = np.unique(np.append(even, len(P) - 1))
    x, slopes = _follow(np, P[indices])
    if len(indices) < len(P):
        with np.errstate(all="ignore"):  # of corrections that diverge, after which Newton's begins
            x = _interpolate_and_correct(P, distance, indices, x, slopes)
    x = x[:, np.argsort(order, kind="stable")]
    x.setflags(write=False)  # it is cached
    return x


def _interpolate_and_correct(
    P: np.ndarray, distance: np.ndarray, indices: np.ndarray, x: np.ndarray, slopes: np.ndarray
) -> np.ndarray:
    """States of all columns at each shortening: interpolated by `distance` along a line between the
    states `x` of those at `indices`, then corrected by Newton's method. `P`: numbers of each
    column.
    """
    # cubics along the line between two neighbors, linear off it; then corrected with the inverse
    # Jacobian of the nearer neighbor
    numbers, columns = P[..., 0], np.arange(len(P))
    left = np.minimum(np.searchsorted(indices, columns, "right"), len(indices) - 1) - 1
    along, length = np.diff(numbers[indices], axis=0), np.diff(distance[indices])[left]
    u = ((distance - distance[indices][left]) / np.where(length > 0, length, 1.0))[:, None]
    neighbor = left + (u[:, 0] > 0.5)
    off = numbers - numbers[indices][left] - u * along[left]
    weights = (1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2, u**2 * (3 - 2 * u), u**2 * (u - 1)
    edges = (np.diff(neighbor) > 0) | (columns[1:] % _GROUP_SIZE == 0)
    groups = np.split(columns, np.flatnonzero(edges) + 1)
    rows, error = [], np.zeros((2, len(P), x.shape[-1]))
    for x_w, slopes_w, w in zip(x, slopes[..., :4], shortenings()[1:], strict=True):
        first, last = ((s @ along[..., None])[..., 0] for s in (slopes_w[:-1], slopes_w[1:]))
        ends = x_w[left], first[left], x_w[left + 1], last[left]
        guess = sum(weight * end for weight, end in zip(weights, ends, strict=True))
        guess = guess + (slopes_w[neighbor] @ off[..., None])[..., 0]
        state = guess + 2 * error[0] - error[1]  # cubics err alike from node to node
        inverse = np.linalg.inv(_jacobian(np, P[indices], x_w))
        for group in groups:
            active = group
            for _ in range(_CORRECTIONS):
                step = _gradient(np, P[active], state[active], w) @ inverse[neighbor[group[0]]].T
                state[active] -= step
                active = active[_is_large(np, _ERROR_RATIO * step, state[active])[:, 0]]
                if not len(active):
                    break
            else:
                state[active], _ = _newton(np, P[active], guess[active], w)
        rows.append(state)
        error = np.stack([state - guess, error[0]])
    return np.stack(rows)


def _follow(xp: Any, P: Any) -> tuple[Any, Any]:
    """Follow the oval column by Newton's method from one shortening to the next: states at all
    nodes but the first, and their slopes in the numbers `P` of the column and in the shortening.
    """

    def advance(x: Any, w: Any) -> tuple[Any, tuple[Any, Any]]:
        x, jacobian = _newton(xp, P, x, w)
        slopes = xp.linalg.solve(jacobian, _gradient_by_numbers(xp, P, x))
        return x + slopes[..., -1] * STEP, (x, slopes)

    w = shortenings()[1:]
    start = np.zeros(_SINES + _COSINES + 1)
    start[0], start[-1] = 2 * np.sqrt(w[0]), -4 * np.pi**2 * (1 + w[0] / 2)
    x = xp.broadcast_to(xp.asarray(start), (*P.shape[:-2], start.size))
    if xp is not np:
        from ...core.jax_backend import lax

        return lax.scan(advance, x, xp.asarray(w))[1]
    rows = []
    for shortening in w:
        x, row = advance(x, shortening)
        rows.append(row)
    all_states, all_slopes = (np.stack(field) for field in zip(*rows, strict=True))
    return all_states, all_slopes


def _is_large(xp: Any, step: Any, x: Any) -> Any:
    """True where a `step` of a state `x` is larger than rounding."""
    size = xp.max(xp.abs(x), axis=-1, keepdims=True)
    return ~xp.all(xp.abs(step) < _TOLERANCE * size, axis=-1, keepdims=True)  # NaN is large


def _newton(xp: Any, P: Any, x: Any, w: Any) -> tuple[Any, Any]:
    """State at a shortening `w`, by Newton's method from a close one, and its Jacobian."""

    def step(i: Any, x: Any) -> Any:
        jacobian = _jacobian(xp, P, x)
        step = xp.linalg.solve(jacobian, _gradient(xp, P, x, w)[..., None])[..., 0]
        longest = xp.max(xp.abs(step[..., :_SINES]), axis=-1, keepdims=True)
        # a step of zero is not divided by
        step = step * xp.minimum(1.0, _LARGEST_SLOPE_STEP / xp.maximum(longest, 1e-300))
        return i + 1, x - step, step, jacobian

    def is_unfinished(state: Any) -> Any:
        i, x, last_step, _ = state
        return (i < _STEPS) & xp.any(_is_large(xp, last_step, x))

    state = step(0, x)
    if xp is not np:
        from ...core.jax_backend import lax

        state = lax.while_loop(is_unfinished, lambda state: step(*state[:2]), state)
    else:
        while is_unfinished(state):
            state = step(*state[:2])
    return state[1], state[3]


class _Section(NamedTuple):
    """A state at the points; `soft`: relative stiffness in bending, `sunk`: of touching walls."""

    theta: Any
    kappa: Any
    oval: Any
    soft: Any
    soft_slope: Any
    sunk: Any


def _middle_section(xp: Any, P: Any, x: Any) -> _Section:
    """Column in the middle of the section at the points, from its sines and cosines `x`."""
    b = _basis()
    t, z = x[..., :_SINES], x[..., _SINES:-1]
    oval = z @ b.Z.T
    return _Section(
        t @ b.S.T, t @ b.S1.T, oval, 1 - 1.5 * oval + 0.625 * oval**2, -1.5 + 1.25 * oval,
        xp.maximum(oval - P[..., 3, :], 0.0),
    )  # fmt: skip


def _gradient(xp: Any, P: Any, x: Any, w: Any) -> Any:
    """Gradient of (O1) for half the column, with its multiplier."""
    b, section = _basis(), _middle_section(xp, P, x)
    h, alpha, beta, gamma = b.weight, *(P[..., i, :] for i in range(3))
    z, load = x[..., _SINES:-1], x[..., -1:]
    bending = 0.5 * section.kappa**2 * section.soft_slope
    pressure = bending + 2 * alpha * (section.oval + _WALL_PENALTY * section.sunk)
    return xp.concatenate([
        h * ((section.soft * section.kappa) @ b.S1 + load * (xp.sin(section.theta) @ b.S)),
        h * (pressure @ b.Z + 2 * (beta * (z @ b.Z1.T) @ b.Z1 + gamma * (z @ b.Z2.T) @ b.Z2)),
        (1 - w) / 2 - h * xp.sum(xp.cos(section.theta), axis=-1, keepdims=True),
    ], axis=-1)  # fmt: skip


def _jacobian(xp: Any, P: Any, x: Any) -> Any:
    """Jacobian of the gradient."""
    b, section = _basis(), _middle_section(xp, P, x)
    h, alpha, beta, gamma = b.weight, *(P[..., i, :] for i in range(3))
    load = x[..., -1:]
    sine = (h * xp.sin(section.theta) @ b.S)[..., None]
    stiff = 2 * h * (beta[..., None] * (b.Z1.T @ b.Z1) + gamma[..., None] * (b.Z2.T @ b.Z2))
    cos, cross = load * xp.cos(section.theta), section.soft_slope * section.kappa
    tt = h * (b.S1.T @ (section.soft[..., None] * b.S1) + b.S.T @ (cos[..., None] * b.S))
    tz = h * b.S1.T @ (cross[..., None] * b.Z)
    local = 0.625 * section.kappa**2 + 2 * alpha * (1 + _WALL_PENALTY * (section.sunk > 0))
    zz = h * b.Z.T @ (local[..., None] * b.Z) + stiff
    zero, corner = (xp.zeros((*x.shape[:-1], size, 1)) for size in (_COSINES, 1))
    zt, sine_row, zero_row = (xp.swapaxes(block, -1, -2) for block in (tz, sine, zero))
    blocks = ((tt, tz, sine), (zt, zz, zero), (sine_row, zero_row, corner))
    return xp.concatenate([xp.concatenate(row, axis=-1) for row in blocks], axis=-2)


def _gradient_by_numbers(xp: Any, P: Any, x: Any) -> Any:
    """Negative slopes of the gradient in the numbers of `Oval`, and in the shortening, last."""
    b, section = _basis(), _middle_section(xp, P, x)
    h, alpha, z = b.weight, P[..., 0, :], x[..., _SINES:-1]
    rows = [
        2 * h * (section.oval + _WALL_PENALTY * section.sunk) @ b.Z,
        2 * h * (z @ b.Z1.T) @ b.Z1,
        2 * h * (z @ b.Z2.T) @ b.Z2,
        -2 * h * (_WALL_PENALTY * alpha * (section.sunk > 0)) @ b.Z,
    ]
    sines, multiplier = (xp.zeros((*x.shape[:-1], size)) for size in (_SINES, 1))
    columns = [xp.concatenate([sines, -row, multiplier], axis=-1) for row in rows]
    shortening = xp.zeros_like(columns[0]) + np.eye(1, x.shape[-1], x.shape[-1] - 1)[0] * 0.5
    return xp.stack([*columns, shortening], axis=-1)


@cache
def _spline() -> np.ndarray:
    """Matrix of the slopes of a spline through numbers at the nodes: numbers first."""
    from scipy.interpolate import CubicSpline  # which other laws don't need

    spline = CubicSpline(shortenings(), np.eye(_NODES), axis=0)
    return np.ascontiguousarray(spline(shortenings(), 1).T)


def spline_slopes(values: Batch) -> Batch:
    """Slopes [-] at the nodes of the spline through `values` [-] of the nodes, nodes first."""
    return sum_nodes(_spline().reshape(_NODES, _NODES, *(1,) * (values.ndim - 1)) * values[:, None])


def interpolate_spline(values: Any, slopes: Any, cell: Batch, w: Batch) -> tuple[Batch, Batch]:
    """Value and slope of a spline [-] at a shortening `w` [-] in a `cell` [-]."""
    u = w / STEP - cell
    rank = node_axis(np.arange(float(_NODES)), cell)
    values, slopes = expand_nodes(values, cell), expand_nodes(slopes, cell)
    ends = [where(rank == cell + i, 1.0, 0.0) for i in (0, 1)]
    (y0, y1), (m0, m1) = ([sum_nodes(x * end) for end in ends] for x in (values, STEP * slopes))
    c2, c3 = 3 * (y1 - y0) - 2 * m0 - m1, 2 * (y0 - y1) + m0 + m1
    return ((c3 * u + c2) * u + m0) * u + y0, ((3 * c3 * u + 2 * c2) * u + m0) / STEP
