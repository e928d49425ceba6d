"""Rare things among many: listed, and worked off for as many as there are.

NumPy lists what is marked. Compiled, a list has room for a given number; it is worked off in
blocks up to the last entry, so that cost follows what there is, not what there could be.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.module import tree_leaves, tree_map
from ..core.types import BoolBatch


_LEAST_BLOCK, _LARGEST_BLOCK = 64, 512  # entries worked on at once


def listed(marks: BoolBatch, room: int) -> tuple[tuple[Any, ...], Any]:
    """Indices of what is marked, in order, and how many there are [-], no more than `room` [-]
    of them where compiled.
    """
    if array_namespace(marks) is np:
        places = np.nonzero(marks)
        return places, len(places[0])
    from ..core.jax_backend import jnp

    total = jnp.minimum(jnp.sum(marks), room)
    return jnp.nonzero(marks, size=room, fill_value=0), total


def worked(function: Callable[..., tuple], total: Any, *entries: Any) -> tuple:
    """`function` of the first `total` of the `entries`, arrays with a first axis for them; zeros
    for the rest.
    """
    leaves = tree_leaves(entries)
    if array_namespace(*leaves) is np:
        return function(*entries)
    from ..core.jax_backend import eval_shape, jnp, lax

    size = leaves[0].shape[0]
    # a block waits for its slowest entry: small ones for few, where a step's own cost allows
    block = min(size, max(_LEAST_BLOCK, min(size // 16, _LARGEST_BLOCK)))

    def step(state: tuple) -> tuple:
        done, results = state
        # the last block reaches back over the one before it
        start = jnp.minimum(done, size - block)
        some = tree_map(lambda x: lax.dynamic_slice_in_dim(x, start, block), entries)
        results = tuple(
            lax.dynamic_update_slice_in_dim(result, new, start, 0)
            for result, new in zip(results, function(*some), strict=True)
        )
        return done + block, results

    part = eval_shape(function, *tree_map(lambda x: x[:block], entries))
    results = tuple(jnp.zeros((size, *one.shape[1:]), one.dtype) for one in part)
    return lax.while_loop(lambda state: state[0] < total, step, (jnp.zeros((), int), results))[1]


def ranked(owner: Any, total: Any, owners: int) -> tuple[Any, Any]:
    """For each entry of a list its rank among those of its `owner` [-], where these come in
    order, and how many each owner has [-].
    """
    at_work = array_namespace(owner)
    place = at_work.arange(len(owner))
    if at_work is np:
        count = np.bincount(owner, minlength=owners)
    else:
        from ..core.jax_backend import jnp

        count = jnp.zeros(owners, int).at[owner].add((place < total).astype(int))
    return place - (at_work.cumsum(count) - count)[owner], count


def put(fill: Any, shape: tuple[int, int], where: tuple[Any, Any], values: Any, total: Any) -> Any:
    """A table of `shape`, with the first `total` of the `values` at their rows and columns and
    `fill` elsewhere; what lies outside is left out.
    """
    row, column = where
    if array_namespace(values) is np:
        table, inside = np.full(shape, fill), column < shape[1]
        table[row[inside], column[inside]] = values[inside]
        return table
    from ..core.jax_backend import jnp

    column = jnp.where(jnp.arange(len(row)) < total, column, shape[1])
    return jnp.full(shape, fill).at[row, column].set(values, mode="drop")


def repeated(
    step: Callable[[Any, tuple, tuple], tuple],
    entries: tuple,
    state: tuple,
    ended: Callable[[tuple, tuple], Any],
    most: int,
) -> tuple:
    """`state` after a `step` of all `entries`, again and again until each has `ended`, at `most` so
    often; entries that have ended stay as they are, and cost nothing where not compiled.
    """
    if array_namespace(*state) is np:
        state = tuple(np.array(one) for one in state)
        open_ones = np.arange(len(state[0]))
        for n in range(most):
            entry, here = (tuple(x[open_ones] for x in xs) for xs in (entries, state))
            going = ~ended(entry, here)
            open_ones = open_ones[going]
            if not len(open_ones):
                break
            entry, here = (tuple(x[going] for x in xs) for xs in (entry, here))
            for whole, new in zip(state, step(n, entry, here), strict=True):
                whole[open_ones] = new
        return state

    from ..core.jax_backend import jnp, lax

    def one(carry: tuple) -> tuple:
        n, state = carry
        done, moved = ended(entries, state), step(n, entries, state)
        return n + 1, tuple(jnp.where(done, x, y) for x, y in zip(state, moved, strict=True))

    def unfinished(carry: tuple) -> Any:
        n, state = carry
        return (n < most) & ~jnp.all(ended(entries, state))

    return lax.while_loop(unfinished, one, (0, state))[1]
