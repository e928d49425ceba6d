r"""Roots, elementwise, in the array library of their arguments.

A root is searched for with the slope that its residual gives, and without any derivative. One
more Newton step, $x - f/f'$, takes it to rounding, and its derivatives are the implicit ones of
any order, $\mathrm{d}x/\mathrm{d}\theta = -f_\theta/f'$. No iteration is ever differentiated,
and a law stays a pure function.
"""

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import NamedTuple

import numpy as np

from .array_namespace import array_namespace, is_jax_array, where
from .module import tree_leaves, tree_map
from .types import Batch, BatchLike, BoolBatch, PyTree


STEPS = 100  # at most: bisection alone would need 53 to reach float64's last bit in (0, 1)
_ROUNDING = 4 * 2.0**-52  # of a root: a Newton step this short changes its last bits alone
SHORT_STEP = 1e-7  # a Newton step this short leaves an error that one more takes to rounding
_LONGEST_STEP = 1e-3  # of a root's size: after a search a longer step comes from a jump


Residual = Callable[[PyTree, Batch], tuple[Batch, Batch]]


def guarded(condition: BoolBatch, value: BatchLike, safe: BatchLike = 1.0) -> Batch:
    """`value` where the `condition` holds, else the constant `safe`, which has no gradient."""
    # the inner half of a double `where`: a branch that isn't taken must still be finite, since its
    # gradient is multiplied by zero, and 0 × ∞ is NaN
    return where(condition, value, safe)


def root(
    residual: Residual, theta: PyTree, low: BatchLike, high: BatchLike, start: BatchLike
) -> Batch:
    """Root of an elementwise `residual` that is positive below it, negative above.

    `residual(theta, x)` gives value and slope; `theta` is all that the root depends on. It is
    searched for, and one more Newton step takes it to rounding.
    """
    return refine_root(residual, theta, find_root(residual, theta, low, high, start))


def find_root(
    residual: Residual, theta: PyTree, low: BatchLike, high: BatchLike, start: BatchLike
) -> Batch:
    """Root of an elementwise `residual` in a bracket, to some 1e-14 and without derivatives."""
    # Newton's method, confined to a shrinking bracket and replaced by bisection where it leaves the
    # bracket or fails to halve its step; to 1e-7 only where the slope is wrong
    value, slope = residual(theta, start)
    if array_namespace(value, slope, low, high, start) is not np:
        return _jax_backend().search_root(residual, *stop_gradient((theta, low, high, start)))
    zero = 0.0 * value
    search = init_search(low + zero, high + zero, start + zero)
    search = search_step(np, search, value, slope)
    for _ in range(STEPS):
        if np.all(search.done):
            break
        search = search_step(np, search, *residual(theta, search.x))
    return search.x


def refine_root(residual: Residual, theta: PyTree, x: Batch) -> Batch:
    """Root near `x` to rounding, by one more Newton step, with its derivatives by `theta`."""
    value, slope = residual(theta, x)
    if array_namespace(value, slope, x) is np:
        return polish_root(value, slope, x)
    return _jax_backend().refine_root(residual, theta, x)


def _jax_backend() -> ModuleType:
    """Module `core.jax_backend`, which imports this one."""
    return importlib.import_module("fascicle.core.jax_backend")


def stop_gradient(tree: PyTree) -> PyTree:
    """Copy of a `tree` of arrays [any unit] that is constant for derivatives."""
    if not any(map(is_jax_array, tree_leaves(tree))):
        return tree
    stop = _jax_backend().stop_gradient
    return tree_map(lambda x: stop(x) if is_jax_array(x) else x, tree)


def polish_root(value: Batch, slope: Batch, x: Batch) -> Batch:
    """A nearly exact root `x` after one more Newton step, or as it is where the step would be long
    or the residual flat. In JAX, this step carries the root's derivatives.
    """
    regular, slope = safe_slope(value, slope, x)
    return where(regular, x - value / slope, x)


def safe_slope(value: Batch, slope: Batch, x: Batch) -> tuple[BoolBatch, Batch]:
    """True where a root near `x` depends on the residual's value, and a slope to divide by."""
    # a flat residual moves no root; a long step comes from a jump, which has no derivative
    xp = array_namespace(value, slope, x)
    nonzero = slope != 0
    slope = xp.where(nonzero, slope, 1.0)
    short = xp.absolute(value / slope) <= _LONGEST_STEP * (1 + xp.absolute(x))
    return xp.logical_and(nonzero, short), slope


class Search(NamedTuple):
    """State of a search: point `x`, `previous` point, bracket, and whether it is `done`."""

    x: Batch
    previous: Batch
    low: Batch
    high: Batch
    # a compiler may evaluate an expression for each use, and differently in its last bits
    done: BoolBatch


def init_search(low: BatchLike, high: BatchLike, start: BatchLike) -> Search:
    """Initial state of a search in a bracket, at `start`."""
    return Search(start, start + 4 * (high - low) + 1, low, high, start < -np.inf)


def search_step(xp: ModuleType, search: Search, value: Batch, slope: Batch) -> Search:
    """Next state of a `search`; `value` and `slope`: of the residual at its `x`; `xp`: its arrays'
    library.
    """
    x, previous, low, high, done = search
    absolute, logical_and, logical_or = xp.absolute, xp.logical_and, xp.logical_or
    where = xp.where
    low, high = where(value > 0, x, low), where(value > 0, high, x)
    # bisect where it is flat or vertical
    sloped = logical_and(slope != 0, absolute(slope) < np.inf)
    step = where(sloped, -value / where(sloped, slope, 1.0), 2 * (high - low) * (value != 0))
    target, length, size = x + step, absolute(step), 1 + absolute(x)
    inside = logical_and(target >= low, target <= high)
    halved = length < 0.5 * absolute(x - previous)
    # within rounding also where it is just outside
    accepted = logical_or(logical_and(inside, halved), length <= size * _ROUNDING)
    clipped = xp.minimum(xp.maximum(target, low), high)
    new = where(accepted, clipped, 0.5 * (low + high))
    converged = logical_or(
        logical_and(accepted, length <= size * SHORT_STEP), absolute(new - x) <= size * _ROUNDING
    )
    return Search(where(done, x, new), x, low, high, logical_or(done, converged))
