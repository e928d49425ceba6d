"""Many points in blocks, inside a compiled function: what a law passes over stays in the cache.

A compiler makes many passes of a law, each over all points. A million of them go to memory and
back each time; in blocks they don't, and a search ends where a block's points have it. A GPU has
other caches, and wants all points at once.
"""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from .apart import apart
from .arrays import library
from .types import Batch


_POINTS = 2**16  # half a megabyte an array: fewer are over before a second thread is at work


def in_blocks(function: Callable[..., Batch], *arrays: Any) -> Batch:
    """An elementwise `function` of arrays that broadcast, block by block along one axis.

    **Arguments:**

    - `function`: that solves for something for all but the last of its arguments [-].
    - `arrays`: in blocks where they are many, and JAX's on a processor [SI].

    **Returns:** what it gives for the whole [SI].
    """
    shapes = [np.shape(x) for x in arrays]
    shape = np.broadcast_shapes(*shapes)
    many = math.prod(shape) > 2 * _POINTS
    if not (many and library(*arrays) is jnp and jax.default_backend() == "cpu"):
        return function(*arrays)
    wide = [jnp.asarray(x).reshape((1,) * (len(shape) - np.ndim(x)) + np.shape(x)) for x in arrays]
    # cut across any other axis, it would solve for the same in each block
    solved = np.broadcast_shapes((1,) * len(shape), *shapes[:-1])
    axis = int(np.argmax(solved if math.prod(solved) > 1 else shape))
    count = shape[axis]
    step = _step(count, math.prod(shape) // count)
    blocks = -(-count // step)

    def block(n: jax.Array) -> jax.Array:
        begin = jnp.minimum(n * step, count - step)  # the last one reaches back
        # merged with the writing of its result it would be one thread's
        return apart(lambda *some: jnp.asarray(function(*some)), *(
            x if x.shape[axis] == 1 else lax.dynamic_slice_in_dim(x, begin, step, axis)
            for x in wide
        ))  # fmt: skip

    # backwards a block is gone through once more: what it would keep for that doesn't fit a cache
    found = lax.map(jax.checkpoint(block), jnp.arange(blocks))
    made = jnp.moveaxis(found, 0, axis)
    joined = made.reshape((*shape[:axis], blocks * step, *shape[axis + 1 :]))
    over = blocks * step - count
    if not over:
        return joined
    last = (blocks - 1) * step
    parts = (lax.slice_in_dim(joined, begin, end, axis=axis) for begin, end in (
        (0, last), (last + over, count + over)))  # fmt: skip
    return jnp.concatenate(list(parts), axis)


def _step(count: int, each: int) -> int:
    """How many of `count` lines of `each` points are a block: evenly, where that can be."""
    most = max(1, _POINTS // each)
    even = (n for n in range(most, most // 2, -1) if count % n == 0)
    return next(even, most)
