"""Functions through which a program is traced once, however often it calls them.

JAX goes through a function's Python anew at each call, operation by operation, and that takes
longer than to compile a small program. Of a function that is called again with arrays of the same
shapes it keeps what it saw, and copies that.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import jax
import jax.numpy as jnp

from .arrays import library


Function = TypeVar("Function", bound=Callable)


def traced_once(function: Function) -> Function:
    """A pure `function` of trees of arrays [-]: NumPy's are answered as ever."""
    seen = jax.jit(function, inline=True)

    @wraps(function)
    def called(*arrays: Any) -> Any:
        traced = library(*jax.tree.leaves(arrays)) is jnp
        return (seen if traced else function)(*arrays)

    return cast(Function, called)
