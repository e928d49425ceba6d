r"""Roots, elementwise, in the array library of their arguments.

A root is searched for with the slope that its residual gives, and without any derivative.
Two Newton steps from it, $x - f/f'$, carry every derivative up to the third: at the root the
first makes $\mathrm{d}x/\mathrm{d}\theta = -f_\theta/f'$, and each step doubles the orders
that are right. So no iteration is ever differentiated, and a law stays a pure function.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .arrays import (
    absolute,
    array_namespace,
    both,
    either,
    imported_jax,
    is_jax_array,
    jax_backend,
    maximum,
    minimum,
    where,
)
from .tree import tree_map
from .types import Batch, BatchLike, BoolBatch


STEPS = 100  # at most: bisection alone would need 53 to reach float64's last bit in (0, 1)
_WRITTEN_OUT = 18  # where steps can't be counted while they run
_TINY = 4 * 2.0**-52
_NEAR = 1e-7  # a Newton step this short leaves an error that two more take to rounding

_NEVER_MOVES = frozenset({float, np.float64, np.ndarray})  # looked at before any tree is

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
    soon: int = 0,
) -> Batch:
    """The root of an elementwise `residual` that is positive below it, negative above.

    `residual(theta, x)` gives value and slope; `theta` is all that the root depends on. It is
    searched for, and two more Newton steps take it to rounding and carry its derivatives.
    """
    found = searched(residual, *still((theta, low, high, start)), soon=soon)
    return finished(residual, theta, found)


def searched(
    residual: Residual,
    theta: Any,
    low: BatchLike,
    high: BatchLike,
    start: BatchLike,
    soon: int = 0,
) -> Batch:
    """About where the root of an elementwise `residual` is, without derivatives.

    Newton's method, kept inside a shrinking bracket [`low`, `high`] and replaced by bisection
    where it leaves the bracket or fails to halve its step; to some 1e-14 where the slope is
    right, else to 1e-7. `soon`: how many steps are mostly enough, which compiled code then tries
    without a loop.
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
        return jax_backend().search_root(residual, theta, low, high, start, soon)
    if hasattr(xp, "searched"):
        return xp.searched(partial(residual, theta), low, high, start)
    state = begun(low, high, start)
    for _ in range(_WRITTEN_OUT):
        state = stepped(state, *residual(theta, state.x))
    return xp.still(state.x)


def finished(residual: Residual, theta: Any, x: Batch) -> Batch:
    """Two Newton steps from about a root `x`: to rounding, and with its derivatives by `theta`."""
    return polished(residual, theta, polished(residual, theta, x))


def polished(residual: Residual, theta: Any, x: Batch) -> Batch:
    """One Newton step from a root `x`, which carries its derivatives by `theta`."""
    value, slope = residual(theta, x)
    some = slope != 0
    step = where(some, value / guarded(some, slope), 0.0)  # a flat residual moves no root
    # a longer step would come from a jump, which has no derivative
    return where(absolute(step) <= 1e-3 * (1 + absolute(x)), x - step, x)


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


def begun(low: BatchLike, high: BatchLike, start: BatchLike) -> Search:
    """A search that begins in a bracket, at `start`."""
    return Search(start, start + 4 * (high - low) + 1, low, high, start < -np.inf)


def stepped(search: Search, value: Batch, slope: Batch) -> Search:
    """The `search` a step later; `value` and `slope` are the residual's where it is."""
    x, before, a, b, ended = search
    a, b = where(value > 0, x, a), where(value > 0, b, x)
    sloped = both(slope != 0, absolute(slope) < np.inf)  # bisect where it is flat or vertical
    step = where(value == 0, 0.0, where(sloped, -value / guarded(sloped, slope), 2 * (b - a)))
    length = absolute(step)
    size = 1 + absolute(x)
    halved = length < 0.5 * absolute(x - before)
    inside = both(both(x + step >= a, x + step <= b), halved)
    # within rounding also where it is just outside
    newton = either(inside, length <= size * _TINY)
    new = where(newton, minimum(maximum(x + step, a), b), 0.5 * (a + b))
    near = either(both(newton, length <= size * _NEAR), absolute(new - x) <= size * _TINY)
    return Search(where(ended, x, new), x, a, b, either(ended, near))


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
    search = stepped(begun(low, high, start), value, slope)
    for _ in range(STEPS):
        if np.all(search.ended):
            break
        search = stepped(search, *residual(theta, search.x))
    return search.x


def still(values: Any) -> Any:
    """The same `values`, a tree of arrays, without derivatives."""
    if type(values) in _NEVER_MOVES:
        return values
    if type(values) is tuple:
        return tuple(map(still, values))
    return tree_map(_stopped, values)


def _stopped(x: Any) -> Any:
    xp = array_namespace(x)
    if xp is np:
        return x
    if is_jax_array(x):
        return jax_backend().stop_gradient(x)
    return xp.still(x)
