"""Methods that `jax.jit` takes as they are: `jax.jit(muscle.force)`.

Equinox binds a module's methods as modules, which are hashed by their arrays, and arrays
have no hash. Bound as plain functions, by identity, they can be compiled.
"""

from functools import update_wrapper, wraps
from typing import Any


class _Compilable:
    def __init__(self, function: Any):
        self.function = function
        update_wrapper(self, function)  # pyright: ignore[reportArgumentType] a callable's stand-in

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        function = self.function
        if instance is None:
            return function

        @wraps(function)
        def bound(*arguments: Any, **options: Any) -> Any:
            return function(instance, *arguments, **options)

        return bound


def compilable(method: Any) -> Any:
    """Decorate a public method of an `equinox` module so that it can be compiled."""
    return _Compilable(method)
