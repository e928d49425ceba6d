"""Many points in tiles of one size: compiled once, whatever the length, and kept in the cache."""

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import jax
import numpy as np

from .modules import Module


_POINTS = 2**16  # half a megabyte an array, so that a law's passes stay in the cache
_ROWS = (1, 2**6, 2**12, _POINTS)  # what depends on pressure alone is solved for once a row
_LANES = 2**12  # of points that each have several numbers
_AHEAD = 3  # tiles that are computed while results are copied

Work = tuple[tuple[slice, ...], tuple[np.ndarray, ...]]


def fields(function: Callable, part: Module, first: np.ndarray, second: np.ndarray) -> Any:
    """`function` of `part` and two arrays that broadcast [SI]; where they have no axis in common
    each tile keeps `first` down and `second` across.
    """
    shape = np.broadcast_shapes(first.shape, second.shape)
    n = len(shape)
    sizes = [(1,) * (n - x.ndim) + x.shape for x in (first, second)]
    if any(a > 1 and b > 1 for a, b in zip(*sizes, strict=True)):
        both = (np.broadcast_to(x, shape).reshape(-1) for x in (first, second))
        return jax.tree.map(lambda leaf: leaf.reshape(shape), _rows(function, part, _POINTS, *both))
    down = [i for i in range(n) if sizes[0][i] > 1]
    order = [*down, *(i for i in range(n) if i not in down)]
    one, other = first.reshape(-1), second.reshape(-1)
    rows = min(_ROWS, key=lambda r: _covered(one.size, r) * _covered(other.size, _POINTS // r))
    columns = _POINTS // rows
    a, b = _padded(one, rows)[:, None], _padded(other, columns)[None]

    def work() -> Iterator[Work]:
        for i in range(0, one.size, rows):
            for j in range(0, other.size, columns):
                place = (slice(i, i + rows), slice(j, j + columns))
                yield place, (a[place[0]], b[:, place[1]])

    out = _done(function, part, (one.size, other.size), work())
    spread = [shape[axis] for axis in order]
    return jax.tree.map(lambda leaf: leaf.reshape(spread).transpose(np.argsort(order)), out)


def scattered(function: Callable, part: Module, *arrays: np.ndarray) -> Any:
    """`function` of `part` and of points that each have numbers of their own [SI], one axis."""
    return _rows(function, part, _POINTS, *arrays)


def rows(function: Callable, part: Module, *arrays: np.ndarray) -> Any:
    """`function` of `part` and arrays [SI] that all have the same first axis."""
    return _rows(function, part, _LANES, *arrays)


def _rows(function: Callable, part: Module, step: int, *arrays: np.ndarray) -> Any:
    count = len(arrays[0])
    padded = [_padded(x, step) for x in arrays]
    places = (slice(i, i + step) for i in range(0, count, step))
    work = (((place,), tuple(x[place] for x in padded)) for place in places)
    return _done(function, part, (count,), work)


def _done(function: Callable, part: Module, shape: tuple[int, ...], work: Iterator[Work]) -> Any:
    """`function` of every tile, put where it belongs in arrays of `shape`."""
    out: Any = None
    waiting: deque = deque()

    def put() -> None:
        nonlocal out
        place, tile = waiting.popleft()
        tile = jax.tree.map(np.asarray, tile)
        if out is None:
            out = jax.tree.map(lambda x: np.empty(shape + x.shape[len(shape) :], x.dtype), tile)
        for whole, new in zip(jax.tree.leaves(out), jax.tree.leaves(tile), strict=True):
            part_of_it = whole[place]
            part_of_it[...] = new[tuple(map(slice, part_of_it.shape))]

    for place, arrays in work:
        waiting.append((place, function(part, *arrays)))
        if len(waiting) > _AHEAD:
            put()
    while waiting:
        put()
    return out


def _covered(size: int, step: int) -> int:
    return -(-size // step) * step


def _padded(x: np.ndarray, step: int) -> np.ndarray:
    edges = [(0, -len(x) % step)] + [(0, 0)] * (x.ndim - 1)
    return np.pad(x, edges, mode="edge")
