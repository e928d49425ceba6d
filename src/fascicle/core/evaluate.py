"""Evaluate a law with NumPy or with JAX: the types of its arguments alone decide."""

from collections.abc import Callable
from functools import cache
from typing import Any

import jax
import numpy as np

from .arrays import given
from .checks import concrete
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
    if not (part.is_numpy and given(*arrays)):
        return compiled(law, static)(part, *arrays)
    with np.errstate(all="ignore"):  # of branches that aren't taken
        return _numpy(law(part, *arrays, *static))


@cache
def compiled(law: Callable[..., Any], static: tuple = ()) -> Any:
    """A `law` [-] compiled by JAX, with its `static` arguments [-] bound."""
    return jax.jit(lambda part, *arrays: law(part, *arrays, *static))


def at_rest(*things: Any) -> tuple | None:
    """The same as NumPy's where they are traced for their derivatives alone, else `None`.

    **Arguments:** `things`: modules and arrays [SI].

    **Returns:** them without derivatives [SI].
    """
    if concrete(things) or not concrete(stopped := still(things)):
        return None
    return numbers(stopped)


def _numpy(result: Any) -> Any:
    """The same `result` as NumPy's arrays and scalars."""
    if isinstance(result, tuple):
        return type(result)(*map(_numpy, result))
    return np.asarray(result)[()]
