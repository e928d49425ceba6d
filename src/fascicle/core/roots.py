r"""Roots, elementwise, in the array library of their arguments.

A root is searched for with the slope that its residual gives, and without any derivative. One
more Newton step, $x - f/f'$, takes it to rounding, and its derivatives are the implicit ones of
any order, $\mathrm{d}x/\mathrm{d}\theta = -f_\theta/f'$. No iteration is ever differentiated,
and a law stays a pure function.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .array_namespace import (
    absolute,
    array_namespace,
    imported_jax,
    is_jax_array,
    jax_backend,
    logical_and,
    logical_or,
    maximum,
    minimum,
    where,
)
from .module import stop_gradient
from .types import Batch, BatchLike, BoolBatch


STEPS = 100  # at most: bisection alone would need 53 to reach float64's last bit in (0, 1)
_WRITTEN_OUT = 18  # where steps can't be counted while they run
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
    """The root of an elementwise `residual` that is positive below it, negative above.

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
    """About where the root of an elementwise `residual` is, without derivatives.

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
            return _searched(residual, theta, low, high, start, first)
    jax = imported_jax()
    if jax is not None and xp is jax.numpy:
        return jax_backend().search_root(residual, theta, low, high, start)
    if hasattr(xp, "searched"):
        return xp.searched(partial(residual, theta), low, high, start)
    state = init_search(low, high, start)
    for _ in range(_WRITTEN_OUT):
        state = search_step(state, *residual(theta, state.x))
    return xp.still(state.x)


def refine_root(residual: Residual, theta: Any, x: Batch) -> Batch:
    """The root near `x`, to rounding, and with its derivatives by `theta`."""
    if not is_jax_array(x):
        value, slope = residual(theta, x)
        if not is_jax_array(value):
            return newton_step(value, slope, x)
    return jax_backend().implicit_root(residual, theta, x)


def newton_step(value: Batch, slope: Batch, x: Batch) -> Batch:
    """A root after one Newton step from about it, `x`."""
    moves, slope = has_slope(value, slope, x)
    return where(moves, x - value / slope, x)


def has_slope(value: Batch, slope: Batch, x: Batch) -> tuple[BoolBatch, Batch]:
    """Whether a root near `x` moves with its residual's value, and a slope to divide by.

    A flat residual moves no root. A long step comes from a jump, which has no derivative.
    """
    sloped = slope != 0
    slope = guarded(sloped, slope)
    return logical_and(sloped, absolute(value / slope) <= 1e-3 * (1 + absolute(x))), slope


class Search(NamedTuple):
    """Where a search is, where it was, its bracket, and whether it has ended.

    Whether it has ended is asked of numbers that are stored: a compiler may evaluate an
    expression once for each of its uses, and differently in the last bits.
    """

    x: Batch
    before: Batch
    low: Batch
    high: Batch
    ended: BoolBatch


def init_search(low: BatchLike, high: BatchLike, start: BatchLike) -> Search:
    """A search that begins in a bracket, at `start`."""
    return Search(start, start + 4 * (high - low) + 1, low, high, start < -np.inf)


def search_step(search: Search, value: Batch, slope: Batch) -> Search:
    """The `search` a step later; `value` and `slope` are the residual's where it is."""
    x, before, a, b, ended = search
    a, b = where(value > 0, x, a), where(value > 0, b, x)
    sloped = logical_and(
        slope != 0, absolute(slope) < np.inf
    )  # bisect where it is flat or vertical
    step = where(value == 0, 0.0, where(sloped, -value / guarded(sloped, slope), 2 * (b - a)))
    length = absolute(step)
    size = 1 + absolute(x)
    halved = length < 0.5 * absolute(x - before)
    inside = logical_and(logical_and(x + step >= a, x + step <= b), halved)
    # within rounding also where it is just outside
    newton = logical_or(inside, length <= size * _TINY)
    new = where(newton, minimum(maximum(x + step, a), b), 0.5 * (a + b))
    near = logical_or(
        logical_and(newton, length <= size * _NEAR), absolute(new - x) <= size * _TINY
    )
    return Search(where(ended, x, new), x, a, b, logical_or(ended, near))


def _searched(
    residual: Residual,
    theta: Any,
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
    first: tuple[Batch, Batch],
) -> Batch:
    value, slope = first
    low, high, start = (x + 0.0 * value for x in (low, high, start))
    search = search_step(init_search(low, high, start), value, slope)
    for _ in range(STEPS):
        if np.all(search.ended):
            break
        search = search_step(search, *residual(theta, search.x))
    return search.x
