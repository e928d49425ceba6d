"""Parts of a compiled function that XLA leaves as calls of their own.

On a processor XLA merges whatever it can: what is cheap into each of its uses, once for each, and
what a loop writes with the writing, which one thread does alone. A call of its own is computed
once, and by all threads. Where XLA doesn't know the mark it merges as usual: the same numbers,
slower. A GPU merges otherwise, and is left to it.
"""

from collections.abc import Callable
from typing import Any

from .array_namespace import imported_jax, is_jax_array


def apart(function: Callable[..., Any], *arrays: Any) -> Any:
    """What a `function` of `arrays` [any unit] gives [any unit], computed apart."""
    jax = imported_jax()
    if not any(map(is_jax_array, arrays)) or jax.default_backend() != "cpu":
        return function(*arrays)
    from jax.experimental.xla_metadata import set_xla_metadata

    return set_xla_metadata(jax.jit(function)(*arrays), inlineable="false")
