"""The JAX side of the core: compilation, loops and derivatives; loaded where JAX's arrays come.

No other module of the core, of muscles, bundles and energetics imports JAX at its top.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import eval_shape, jit, lax  # noqa: F401 others take them from here

from .array_namespace import absolute, logical_and, logical_or, where
from .roots import _NEAR, _TINY, STEPS, Residual, guarded, init_search, search_step
from .types import Batch, BatchLike, BoolBatch


@cache
def compile_law(law: Callable[..., Any], static: tuple = ()) -> Any:
    """A `law` [-] compiled by JAX, with its `static` arguments [-] bound."""
    return jax.jit(lambda part, *arrays: law(part, *arrays, *static))


def derivative(function: Callable[[Any], Any], x: Any) -> tuple[Any, Any]:
    """What an elementwise `function` gives at `x` [any unit], and its slopes [any unit]."""
    x = jnp.asarray(x)
    return jax.jvp(function, (x,), (jnp.ones_like(x),))


def cummax(x: Any, axis: int) -> Any:
    """The largest of `x` so far along an axis [any unit]."""
    return lax.cummax(x, axis)


def stop_gradient(x: Any) -> Any:
    """The same `x` [any unit] without derivatives."""
    return lax.stop_gradient(x)


def search_root(
    residual: Residual, theta: Any, low: BatchLike, high: BatchLike, start: BatchLike, soon: int
) -> Batch:
    """The root of an elementwise `residual`, as `roots.searched` finds it, in a compiled loop."""
    shape = jax.eval_shape(lambda x: residual(theta, x)[0] + low + high, jnp.asarray(start, float))
    low, high, start = (
        jnp.broadcast_to(jnp.asarray(x, float), shape.shape) for x in (low, high, start)
    )
    state = init_search(low, high, start)
    if soon:
        x, ended = _newton_steps(residual, theta, low, high, start, soon)
        state = state._replace(x=where(ended, x, start), ended=ended)

    def step(state: tuple) -> tuple:
        n, search = state
        return n + 1, search_step(search, *residual(theta, search.x))

    def keep_going(state: tuple) -> BoolBatch:
        n, search = state
        return (n < STEPS) & ~jnp.all(search.ended)

    return lax.while_loop(keep_going, step, (0, state))[1].x


def _newton_steps(
    residual: Residual, theta: Any, low: Batch, high: Batch, start: Batch, steps: int
) -> tuple[Batch, BoolBatch]:
    """Where a search would be after so many steps, and whether all were Newton's, and it ended.

    A search is five numbers a point, and a compiler computes each with all that they share.
    Newton's steps alone are one number: it goes out of the bracket, and stays there, where the
    search would have done anything else: halved steps on a falling residual don't leave the
    bracket of signs.
    """
    lost = high + 1.0

    def step(_: Any, state: tuple[Batch, Batch]) -> tuple[Batch, Batch]:
        before, x = state
        value, slope = residual(theta, x)
        step = -value / guarded(slope != 0, slope)
        new, length = x + step, absolute(step)
        halved = logical_or(
            length < 0.5 * absolute(x - before), length <= (1 + absolute(x)) * _TINY
        )
        inside = logical_and(logical_and(new >= low, new <= high), x <= high)
        sloped = logical_and(slope < 0, slope > -np.inf)
        return x, where(logical_and(logical_and(sloped, inside), halved), new, lost)

    before, x = lax.fori_loop(0, steps, step, (init_search(low, high, start).before, start))
    return x, logical_and(absolute(x - before) <= (1 + absolute(before)) * _NEAR, x <= high)
