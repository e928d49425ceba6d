"""The JAX side of the core: loops and derivatives.

No other module of the core, of muscles and bundles imports JAX at its top.
"""

from collections.abc import Callable
from functools import partial

import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.lax import stop_gradient

from ..jax import jax
from .array_namespace import array_namespace, where
from .roots import STEPS, Residual, init_search, polish_root, safe_slope, search_step
from .types import Batch, BatchLike, BoolBatch, PyTree


def array_spec(kind: type, shape: tuple[int, ...]) -> "jax.ShapeDtypeStruct":
    """Shape and type of an array of a `kind` of numbers."""
    return jax.ShapeDtypeStruct(shape, jax.dtypes.canonicalize_dtype(kind))


def call_numpy(function: Callable[..., PyTree], result: PyTree, *arguments: PyTree) -> PyTree:
    """Tree that a NumPy `function` gives for `arguments` [any unit] that may be traced, without
    derivatives; `result`: a tree of its arrays' `array_spec`.
    """

    def call(*values: PyTree) -> PyTree:
        values = jax.tree.map(np.asarray, values)
        return jax.tree.map(lambda x, spec: np.asarray(x, spec.dtype), function(*values), result)

    return jax.pure_callback(call, result, *stop_gradient(arguments), vmap_method="sequential")


def iterate(step: Callable[[Batch], Batch], x: Batch, times: int) -> Batch:
    """Apply a `step` to `x` [any unit] so many `times`; in JAX a loop, compiled once."""
    if array_namespace(x) is not np:
        return lax.fori_loop(0, times, lambda _, x: step(x), x)
    for _ in range(times):
        x = step(x)
    return x


def derivative(function: Callable[[Batch], Batch], x: Batch) -> tuple[Batch, Batch]:
    """Values of an elementwise `function` at `x` [any unit], and its slopes [any unit]."""
    x = jnp.asarray(x)
    return jax.jvp(function, (x,), (jnp.ones_like(x),))


@partial(jax.jit, static_argnums=0)  # else a caller without `jit` would compile each search anew
def search_root(
    residual: Residual, theta: PyTree, low: BatchLike, high: BatchLike, start: BatchLike
) -> Batch:
    """Root of an elementwise `residual`, as `roots.find_root` finds it, in a compiled loop."""
    shape = jax.eval_shape(lambda x: residual(theta, x)[0] + low + high, jnp.asarray(start, float))
    low, high, start = (
        jnp.broadcast_to(jnp.asarray(x, float), shape.shape) for x in (low, high, start)
    )

    def step(state: tuple) -> tuple:
        n, search = state
        return n + 1, search_step(jnp, search, *residual(theta, search.x))

    def is_unfinished(state: tuple) -> BoolBatch:
        n, search = state
        return (n < STEPS) & ~jnp.all(search.done)

    search = init_search(low, high, start)
    return lax.while_loop(is_unfinished, step, (0, search))[1].x


@partial(jax.jit, static_argnums=0)
def refine_root(residual: Residual, theta: PyTree, x: Batch) -> Batch:
    """Root of a residual near `x`, with its implicit derivatives by `theta`."""
    return _implicit_root(residual, theta, x)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _implicit_root(residual: Residual, theta: PyTree, x: Batch) -> Batch:
    return polish_root(*residual(theta, x), x)


@_implicit_root.defjvp
def _implicit_derivative(residual: Residual, primals: tuple, tangents: tuple) -> tuple:
    """The root and its tangent, by `theta` alone; zero where it doesn't depend on the residual."""
    root = _implicit_root(residual, *primals)

    def value_and_slope(theta: PyTree) -> tuple[Batch, tuple[Batch, Batch]]:
        value, slope = residual(theta, root)
        return value, (value, slope)

    _, change, (value, slope) = jax.jvp(value_and_slope, primals[:1], tangents[:1], has_aux=True)
    regular, slope = safe_slope(value, slope, root)
    return root, where(regular, -change / slope, 0.0)
