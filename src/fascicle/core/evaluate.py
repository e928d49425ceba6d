"""Evaluate a law with NumPy or with JAX: the types of its arguments alone decide."""

from collections.abc import Callable
from typing import Any

import numpy as np

from .arrays import is_numpy
from .checks import is_concrete
from .modules import Module, numbers
from .roots import still


def evaluate(law: Callable[..., Any], part: Module, *arrays: Any, static: tuple = ()) -> Any:
    """`law(part, *arrays, *static)`, computed by NumPy, or compiled by JAX.

    **Arguments:**

    - `law`: a pure function of the package's own [-].
    - `part`: the muscle or bundle that it is evaluated for [-].
    - `arrays`: numbers or arrays that broadcast [SI].
    - `static`: hashable arguments that decide the result's shape [-].

    **Returns:** what the law gives [SI]: NumPy's where all arguments are NumPy's, else JAX's.
    """
    if not (part.is_numpy and is_numpy(*arrays)):
        from .jax_backend import compiled

        return compiled(law, static)(part, *arrays)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return _numpy(law(part, *arrays, *static))


def at_rest(*things: Any) -> tuple | None:
    """The same as NumPy's where they are traced for their derivatives alone, else `None`.

    **Arguments:** `things`: modules and arrays [SI].

    **Returns:** them without derivatives [SI].
    """
    if is_concrete(things) or not is_concrete(stopped := still(things)):
        return None
    return numbers(stopped)


def _numpy(result: Any) -> Any:
    """The same `result` as NumPy's arrays and scalars."""
    if isinstance(result, tuple):
        return type(result)(*map(_numpy, result))
    return np.asarray(result)[()]
