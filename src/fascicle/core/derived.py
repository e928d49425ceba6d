"""Derivatives at once: what JAX asks of a law while it differentiates its caller, step by step.

Outside of `jax.jit`, `jax.grad` and `jax.jvp` hand in numbers that they follow. Their values are
known, so NumPy can evaluate the law and its slopes together, without a compiler. Derivatives of
these slopes are asked for with values that are followed again; those are compiled.
"""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jax.dtypes import float0

from .checks import concrete
from .dual import Dual, seeded, slopes_of
from .modules import numbers


def followed(*things: Any) -> int:
    """How many numbers of `things`, modules and arrays [any unit], are traced [-]."""
    return sum(np.size(x) for x in jax.tree.leaves(things) if isinstance(x, Tracer))


def derived(law: Callable, compiled: Callable, *things: Any) -> Any:
    """`law(*things)`, with derivatives by whatever is followed among them.

    **Arguments:**

    - `law`: elementwise, of the package's own [-].
    - `compiled`: the same, compiled [-].
    - `things`: modules and arrays, followed for their derivatives alone [any unit].

    **Returns:** what the law gives [any unit], JAX's.
    """
    leaves, structure = jax.tree.flatten(things)
    places = [i for i, leaf in enumerate(leaves) if isinstance(leaf, Tracer)]

    def put(moved: Sequence[Any]) -> Any:
        every = numbers([None if isinstance(leaf, Tracer) else leaf for leaf in leaves])
        for i, leaf in zip(places, moved, strict=True):
            every[i] = leaf
        return jax.tree.unflatten(structure, every)

    @jax.custom_jvp
    def value(*moved: Any) -> Any:
        return compiled(*put(moved))

    @value.defjvp
    def slopes(moved: Sequence[Any], directions: Sequence[Any]) -> tuple[Any, Any]:
        if not concrete(moved):
            return jax.jvp(lambda *again: compiled(*put(again)), moved, directions)
        with np.errstate(all="ignore"):  # of branches that aren't taken
            found = law(*put(seeded(numbers(moved))))
        parts, form = jax.tree.flatten(found)
        values = [jnp.asarray(getattr(part, "value", part)) for part in parts]
        moves = [_moved(part, directions) for part in parts]
        return jax.tree.unflatten(form, values), jax.tree.unflatten(form, moves)

    return value(*(leaves[i] for i in places))


def along(function: Callable, x: Any, direction: Any) -> Any:
    """How an elementwise `function` of an array `x` changes [any unit] as that moves in a
    `direction` [-].
    """
    if isinstance(x, np.ndarray):
        return slopes_of(function(Dual(x, direction[..., None])), 1)[..., 0]
    return jax.jvp(function, (x,), (direction,))[1]


def _moved(part: Any, directions: Sequence[Any]) -> Any:
    """How a `part` of a result [any unit] moves with what is followed."""
    if not jnp.issubdtype(jnp.result_type(getattr(part, "value", part)), float):
        return np.zeros(np.shape(part), float0)
    rows, done = slopes_of(part, sum(map(np.size, directions))), 0
    moves = jnp.zeros(np.shape(part))
    for step in directions:
        own = rows[..., done : done + np.size(step)]
        done += np.size(step)
        if np.ndim(step) == 0:  # a product needs no transposed one for each of many numbers
            moves = moves + own[..., 0] * step
        else:
            own = own.reshape((*np.shape(part), *np.shape(step)))
            moves = moves + jnp.tensordot(own, step, np.ndim(step))
    return moves
