"""The JAX side of the core: compilation, loops and derivatives; loaded where JAX's arrays come.

No other module of the core, of muscles, bundles and energetics imports JAX at its top.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import eval_shape, jit, lax  # noqa: F401 others take them from here

from .array_namespace import where
from .roots import STEPS, Residual, has_slope, init_search, newton_step, search_step
from .types import Batch, BatchLike, BoolBatch


@cache
def compile_law(law: Callable[..., Any], static: tuple = ()) -> Any:
    """A `law` compiled by JAX, with its `static` arguments bound."""
    return jax.jit(lambda part, *arrays: law(part, *arrays, *static))


def derivative(function: Callable[[Any], Any], x: Any) -> tuple[Any, Any]:
    """Values of an elementwise `function` at `x` [any unit], and its slopes [any unit]."""
    x = jnp.asarray(x)
    return jax.jvp(function, (x,), (jnp.ones_like(x),))


def cummax(x: Any, axis: int) -> Any:
    """The largest of `x` so far along an axis [any unit]."""
    return lax.cummax(x, axis)


def stop_gradient(x: Any) -> Any:
    """`x` [any unit] without derivatives."""
    return lax.stop_gradient(x)


def search_root(
    residual: Residual, theta: Any, low: BatchLike, high: BatchLike, start: BatchLike
) -> Batch:
    """The root of an elementwise `residual`, as `roots.searched` finds it, in a compiled loop."""
    shape = jax.eval_shape(lambda x: residual(theta, x)[0] + low + high, jnp.asarray(start, float))
    low, high, start = (
        jnp.broadcast_to(jnp.asarray(x, float), shape.shape) for x in (low, high, start)
    )
    state = init_search(low, high, start)

    def step(state: tuple) -> tuple:
        n, search = state
        return n + 1, search_step(search, *residual(theta, search.x))

    def keep_going(state: tuple) -> BoolBatch:
        n, search = state
        return (n < STEPS) & ~jnp.all(search.ended)

    return lax.while_loop(keep_going, step, (0, state))[1].x


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def implicit_root(residual: Residual, theta: Any, x: Batch) -> Batch:
    """The root of a residual near `x`, with its implicit derivatives by `theta`."""
    return newton_step(*residual(theta, x), x)


@implicit_root.defjvp
def _implicit_derivative(residual: Residual, primals: tuple, tangents: tuple) -> tuple:
    root = implicit_root(residual, *primals)

    def at_root(theta: Any) -> tuple[Batch, tuple[Batch, Batch]]:
        value, slope = residual(theta, root)
        return value, (value, slope)

    _, change, (value, slope) = jax.jvp(at_root, primals[:1], tangents[:1], has_aux=True)
    moves, slope = has_slope(value, slope, root)
    return root, where(moves, -change / slope, 0.0)
