"""NumPy's answers inside of what JAX traces: searches that a compiler would gain nothing from."""

from collections.abc import Callable
from typing import Any

import numpy as np


def called_back(function: Callable[..., Any], shapes: Any, single: Any, *arrays: Any) -> Any:
    """`function(single, *arrays)` by NumPy, without derivatives, also under `jit` and `vmap`.

    **Arguments:**

    - `function`: of modules and arrays of NumPy's; elementwise in `arrays`.
    - `shapes`: a tree of `jax.ShapeDtypeStruct`, as the result is for these arguments.
    - `single`: a tree of modules and arrays, one at a time.
    - `arrays`: that may have more axes in front, where `vmap` adds them.

    **Returns:** the result, JAX's.
    """
    import jax

    leaves, structure = jax.tree.flatten(single)
    # in single precision results are, too; the search itself is not
    shapes = jax.tree.map(
        lambda x: jax.ShapeDtypeStruct(x.shape, jax.dtypes.canonicalize_dtype(x.dtype)), shapes
    )
    own = [np.ndim(x) for x in (*leaves, *arrays)]

    def answer(*values: Any) -> Any:
        numbers = [np.asarray(x, float if x.dtype.kind == "f" else None) for x in values]
        fronts = [x.shape[: x.ndim - n] for x, n in zip(numbers, own, strict=True)]
        batch, several = (
            np.broadcast_shapes(*some) for some in (fronts, fronts[: len(leaves)] or [()])
        )
        tails = [x.shape[len(front) :] for x, front in zip(numbers, fronts, strict=True)]
        asked = [
            np.broadcast_to(x, (*batch, *tail)) for x, tail in zip(numbers, tails, strict=True)
        ]
        if np.prod(several) == 1:  # one module, whatever it is asked
            one = [x.reshape(tail) for x, tail in zip(numbers[: len(leaves)], tails, strict=False)]
            found = function(jax.tree.unflatten(structure, one), *asked[len(leaves) :])
            return jax.tree.map(lambda x, like: np.asarray(x, like.dtype), found, shapes)
        rows = []
        for i in np.ndindex(batch):
            module = jax.tree.unflatten(structure, [x[i] for x in asked[: len(leaves)]])
            rows.append(function(module, *(x[i] for x in asked[len(leaves) :])))
        return jax.tree.map(
            lambda like, *x: np.reshape(x, (*batch, *like.shape)).astype(like.dtype), shapes, *rows
        )

    return jax.pure_callback(answer, shapes, *leaves, *arrays, vmap_method="expand_dims")
