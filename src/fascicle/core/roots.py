r"""Roots, elementwise, in the array library of their arguments.

A root is searched for with the slope that its residual gives, and without any derivative. One
more Newton step, $x - f/f'$, takes it to rounding, and its derivatives are the implicit ones of
any order, $\mathrm{d}x/\mathrm{d}\theta = -f_\theta/f'$. No iteration is ever differentiated,
and a law stays a pure function.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .array_namespace import (
    array_namespace,
    imported_jax,
    is_jax_array,
    jax_backend,
    where,
)
from .module import stop_gradient
from .types import Batch, BatchLike, BoolBatch


STEPS = 100  # at most: bisection alone would need 53 to reach float64's last bit in (0, 1)
_UNROLLED_STEPS = 18  # where steps can't be counted while they run
_TINY = 4 * 2.0**-52
_NEAR = 1e-7  # a Newton step this short leaves an error that one more takes to rounding


Residual = Callable[[Any, Batch], tuple[Batch, Batch]]


def guarded(condition: BoolBatch, value: BatchLike, safe: BatchLike = 1.0) -> Batch:
    """`value` where `condition`, else a harmless constant with no gradient.

    The inner half of the double `where`: a branch that isn't taken must still be
    finite, since its gradient is multiplied by zero, and 0 × ∞ is NaN.
    """
    return where(condition, value, safe)


def root(
    residual: Residual,
    theta: Any,
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
) -> Batch:
    """Root of an elementwise `residual` that is positive below it, negative above.

    `residual(theta, x)` gives value and slope; `theta` is all that the root depends on. It is
    searched for, and one more Newton step takes it to rounding.
    """
    return refine_root(
        residual, theta, find_root(residual, *stop_gradient((theta, low, high, start)))
    )


def find_root(
    residual: Residual,
    theta: Any,
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
) -> Batch:
    """Find the root of an elementwise `residual`, approximately and without derivatives.

    Newton's method, kept inside a shrinking bracket [`low`, `high`] and replaced by bisection
    where it leaves the bracket or fails to halve its step; to some 1e-14 where the slope is
    right, else to 1e-7.
    """
    xp = array_namespace(low, high, start)
    if xp is np:
        # what is asked about may still be JAX's
        first = residual(theta, start)
        xp = array_namespace(*first)
        if xp is np:
            return _search_numpy(residual, theta, low, high, start, first)
    jax = imported_jax()
    if jax is not None and xp is jax.numpy:
        return jax_backend().search_root(residual, theta, low, high, start)
    state = init_search(low, high, start)
    for _ in range(_UNROLLED_STEPS):
        state = search_step(state, *residual(theta, state.x))
    return xp.stop_gradient(state.x)


def refine_root(residual: Residual, theta: Any, x: Batch) -> Batch:
    """Root near `x`, to rounding, and with its derivatives by `theta`."""
    if not is_jax_array(x):
        value, slope = residual(theta, x)
        if not is_jax_array(value):
            return newton_step(value, slope, x)
    return jax_backend().implicit_root(residual, theta, x)


def newton_step(value: Batch, slope: Batch, x: Batch) -> Batch:
    """One Newton step from a root `x`."""
    moves, slope = has_slope(value, slope, x)
    return where(moves, x - value / slope, x)


def has_slope(value: Batch, slope: Batch, x: Batch) -> tuple[BoolBatch, Batch]:
    """True where a root near `x` moves with its residual's value; and a slope to divide by.

    A flat residual moves no root. A long step comes from a jump, which has no derivative.
    """
    xp = array_namespace(value, slope, x)
    sloped = slope != 0
    slope = xp.where(sloped, slope, 1.0)
    short = xp.absolute(value / slope) <= 1e-3 * (1 + xp.absolute(x))
    return xp.logical_and(sloped, short), slope


class Search(NamedTuple):
    """State of a search: its place, the last one, its bracket, and whether it has ended.

    `ended` is stored: a compiler may evaluate an
    expression once for each of its uses, and differently in the last bits.
    """

    x: Batch
    before: Batch
    low: Batch
    high: Batch
    ended: BoolBatch


def init_search(low: BatchLike, high: BatchLike, start: BatchLike) -> Search:
    """State of a search in a bracket, at `start`."""
    return Search(start, start + 4 * (high - low) + 1, low, high, start < -np.inf)


def search_step(search: Search, value: Batch, slope: Batch) -> Search:
    """The `search` a step later; `value` and `slope` are the residual's at its `x`."""
    x, before, low, high, ended = search
    xp = array_namespace(value, slope, x)
    low, high = xp.where(value > 0, x, low), xp.where(value > 0, high, x)
    # bisect where it is flat or vertical
    sloped = xp.logical_and(slope != 0, xp.absolute(slope) < np.inf)
    newton_step = xp.where(sloped, -value / xp.where(sloped, slope, 1.0), 2 * (high - low))
    step = xp.where(value == 0, 0.0, newton_step)
    length, size = xp.absolute(step), 1 + xp.absolute(x)
    halved = length < 0.5 * xp.absolute(x - before)
    inside = xp.logical_and(xp.logical_and(x + step >= low, x + step <= high), halved)
    # within rounding also where it is just outside
    newton = xp.logical_or(inside, length <= size * _TINY)
    clipped = xp.minimum(xp.maximum(x + step, low), high)
    new = xp.where(newton, clipped, 0.5 * (low + high))
    near = xp.logical_or(
        xp.logical_and(newton, length <= size * _NEAR), xp.absolute(new - x) <= size * _TINY
    )
    return Search(xp.where(ended, x, new), x, low, high, xp.logical_or(ended, near))


def _search_numpy(
    residual: Residual,
    theta: Any,
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
    first: tuple[Batch, Batch],
) -> Batch:
    value, slope = first
    zero = 0.0 * value
    low, high, start = low + zero, high + zero, start + zero
    search = search_step(init_search(low, high, start), value, slope)
    for _ in range(STEPS):
        if np.all(search.ended):
            break
        search = search_step(search, *residual(theta, search.x))
    return search.x[()]  # a scalar where all are scalars
