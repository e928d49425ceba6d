"""Large arrays in chunks, so that NumPy's temporaries fit into memory and the cache."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np


_CHUNK = 2**16  # points: half a megabyte an array, so that a law's passes stay in the cache


def map_in_chunks(function: Callable[..., Any], first: Any, second: Any) -> Any:
    """An elementwise `function` of two of NumPy's arrays, chunk by chunk along one axis.

    **Arguments:**

    - `function`: of both [-]; what it solves for `first` alone is then solved for once.
    - `first`, `second`: arrays that broadcast [any unit].

    **Returns:** what it gives for the whole [any unit]; memory holds one chunk's temporaries.
    """
    shape = np.broadcast_shapes(np.shape(first), np.shape(second))
    if (size := math.prod(shape)) <= _CHUNK:
        return function(first, second)
    pair = [np.reshape(x, (1,) * (len(shape) - np.ndim(x)) + np.shape(x)) for x in (first, second)]
    axis = int(np.argmax(pair[0].shape if pair[0].size > 1 else shape))
    step = max(1, _CHUNK * shape[axis] // size)
    parts = []
    for start in range(0, shape[axis], step):
        index = (slice(None),) * axis + (slice(start, start + step),)
        parts.append(function(*(x if x.shape[axis] == 1 else x[index] for x in pair)))
    if isinstance(parts[0], tuple):
        return type(parts[0])(*(np.concatenate(x, axis) for x in zip(*parts, strict=True)))
    return np.concatenate(parts, axis)
