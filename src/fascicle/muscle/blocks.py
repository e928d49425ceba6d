"""Many points in blocks that fit the processor's cache.

A law is a chain of some hundred operations. Compiled for a processor it becomes several
passes over the points, each of which would read and write whole arrays; in blocks these
stay in the cache, and a root that converges late holds up its own block alone. Few points,
and points with a muscle each, are left as they are.

Blocks are a loop: its body is compiled once, and run backward again block by block, with
nothing kept between, so that a gradient needs no more memory than the force.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from .._types import Batch


_POINTS = 2**16  # half a megabyte an array


def in_blocks(function: Callable[[Batch, Batch], Any], first: Batch, second: Batch) -> Any:
    """`function` [any unit] of two arrays that broadcast [any unit], block by block.

    It must be elementwise: each of its results has the arrays' common shape.
    """
    shape = np.broadcast_shapes(first.shape, second.shape)
    axis, rows = _cut(shape)
    if rows == 0:
        return function(first, second)
    count = -(-shape[axis] // rows)
    spare = count * rows - shape[axis]

    def cut(x: Array) -> tuple[Array, bool]:
        x = x.reshape((1,) * (len(shape) - x.ndim) + x.shape)
        if x.shape[axis] == 1:
            return x, False
        x = jnp.pad(x, [(0, spare * (i == axis)) for i in range(x.ndim)], mode="edge")
        x = x.reshape(*x.shape[:axis], count, rows, *x.shape[axis + 1 :])
        return jnp.moveaxis(x, axis, 0), True

    (a, a_cut), (b, b_cut) = cut(first), cut(second)

    @jax.checkpoint
    def one(block: tuple) -> Any:
        return function(block[0] if a_cut else a, block[1] if b_cut else b)

    def joined(x: Array) -> Array:
        x = jnp.moveaxis(x, 0, axis)
        x = x.reshape(*x.shape[:axis], count * rows, *x.shape[axis + 2 :])
        return jax.lax.slice_in_dim(x, 0, shape[axis], axis=axis)

    blocks = jax.lax.map(one, (a if a_cut else None, b if b_cut else None))
    return jax.tree.map(joined, blocks)


def _cut(shape: tuple[int, ...]) -> tuple[int, int]:
    """The axis to cut, and how many of its rows make a block; 0 where it isn't worth it."""
    points = int(np.prod(shape))
    if points < 2 * _POINTS:
        return 0, 0
    # the first axis that is long enough: a field's pressures, each solved for once
    long = [i for i, size in enumerate(shape) if size * _POINTS >= points]
    axis = long[0] if long else int(np.argmax(shape))
    rows = max(1, shape[axis] * _POINTS // points)
    # without a remainder nothing is padded or copied
    even = [n for n in range(rows, rows // 2, -1) if shape[axis] % n == 0]
    return axis, (even or [rows])[0]
