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
    own = [np.ndim(x) for x in (*leaves, *arrays)]

    def answer(*values: Any) -> Any:
        values = tuple(map(np.asarray, values))
        ahead = [x.shape[: x.ndim - n] for x, n in zip(values, own, strict=True)]
        batch = np.broadcast_shapes(*ahead)
        several = np.broadcast_shapes(*ahead[: len(leaves)])
        count = int(np.prod(several))
        full = [
            np.broadcast_to(x, (*batch, *x.shape[len(front) :]))
            for x, front in zip(values, ahead, strict=True)
        ]
        if count == 1:  # one bundle, whatever it is asked
            one = [
                x.reshape(x.shape[len(front) :]) for x, front in zip(values, ahead, strict=False)
            ][: len(leaves)]
            return _plain(function(jax.tree.unflatten(structure, one), *full[len(leaves) :]))
        results = [
            jax.tree.leaves(
                _plain(
                    function(
                        jax.tree.unflatten(structure, [x[i] for x in full[: len(leaves)]]),
                        *(x[i] for x in full[len(leaves) :]),
                    )
                )
            )
            for i in np.ndindex(batch)
        ]
        stacked = [np.reshape(x, (*batch, *np.shape(x[0]))) for x in zip(*results, strict=True)]
        return jax.tree.unflatten(jax.tree.structure(shapes), stacked)

    return jax.pure_callback(answer, shapes, *leaves, *arrays, vmap_method="expand_dims")


def _plain(result: Any) -> Any:
    if isinstance(result, tuple):
        return type(result)(*map(_plain, result))
    return np.asarray(result)
