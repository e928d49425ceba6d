"""Functions of an array library, chosen by the types of their arguments.

A law is written once, with these. Numbers and NumPy arrays stay with NumPy. Where a JAX array or
a tracer is among the arguments, the result is JAX's: compiled, batched and differentiated as its
caller asks.

Axes of nodes and of tables follow.
"""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from .errors import InvalidInputError


_NUMPY = (np.ndarray, np.generic, float, int)


def array_namespace(*values: Any) -> Any:
    """Array library that computes with all of the `values`: NumPy or JAX's."""
    if "jax" in sys.modules and any(map(is_jax_array, values)):
        return sys.modules["jax.numpy"]
    return np


def imported_jax() -> Any:
    """The module `jax` where `fascicle.jax` has been imported, else `None`."""
    return sys.modules.get("jax") if "fascicle.jax" in sys.modules else None


def is_jax_array(value: Any) -> bool:
    """True for arrays and tracers of JAX; `InvalidInputError` before `import fascicle.jax`."""
    jax = sys.modules.get("jax")
    if jax is None or isinstance(value, _NUMPY) or not isinstance(value, getattr(jax, "Array", ())):
        return False
    if "fascicle.jax" not in sys.modules:
        rule = "need `import fascicle.jax` first, which switches JAX to 64 bits"
        raise InvalidInputError("JAX arrays", rule, None)
    return True


def where(condition: Any, x: Any, y: Any) -> Any:
    """Elements of `x` where the `condition` holds, else of `y`; numbers of numbers."""
    return array_namespace(condition, x, y).where(condition, x, y)[()]


def _elementwise(name: str) -> Callable[..., Any]:
    """NumPy's function of this name, in the array library of its arguments."""

    def function(*arrays: Any) -> Any:
        return getattr(array_namespace(*arrays), name)(*arrays)

    function.__name__ = function.__qualname__ = name
    return function


sqrt = _elementwise("sqrt")
exp = _elementwise("exp")
expm1 = _elementwise("expm1")
log = _elementwise("log")
log1p = _elementwise("log1p")
sin = _elementwise("sin")
cos = _elementwise("cos")
tan = _elementwise("tan")
arcsin = _elementwise("arcsin")
arccos = _elementwise("arccos")
arctan = _elementwise("arctan")
absolute = _elementwise("absolute")
minimum = _elementwise("minimum")
maximum = _elementwise("maximum")
isfinite = _elementwise("isfinite")
logical_and = _elementwise("logical_and")
logical_or = _elementwise("logical_or")
logical_not = _elementwise("logical_not")


# nodes lie on a new first axis, so that the other axes broadcast as before


def node_axis(values: Any, template: Any) -> Any:
    """The `values` on a new first axis, ahead of all axes of the `template`."""
    return array_namespace(template).asarray(values).reshape((-1,) + (1,) * np.ndim(template))


def expand_nodes(x: Any, template: Any) -> Any:
    """`x` with axes of length 1 after its first, the nodes', to broadcast with the `template`."""
    missing = np.ndim(template) + 1 - np.ndim(x)
    return x if missing <= 0 else x.reshape(x.shape[:1] + (1,) * missing + x.shape[1:])


def sum_nodes(x: Any) -> Any:
    """Sum over the nodes, which lie on the first axis."""
    return array_namespace(x).sum(x, axis=0)


def min_nodes(x: Any) -> Any:
    """Minimum over the nodes, which lie on the first axis."""
    return array_namespace(x).min(x, axis=0)


def max_nodes(x: Any) -> Any:
    """Maximum over the nodes, which lie on the first axis."""
    return array_namespace(x).max(x, axis=0)


def add_table_axis(x: Any) -> Any:
    """`x` with a new last axis for the entries of a table."""
    return array_namespace(x).asarray(x)[..., None]


def sum_table(x: Any) -> Any:
    """Sum over the last axis, that of a table."""
    return array_namespace(x).sum(x, axis=-1)


def stack(rows: Any, axis: int = 0) -> Any:
    """Broadcast arrays, stacked on a new `axis`, by default the first."""
    xp = array_namespace(*rows)
    return xp.stack(xp.broadcast_arrays(*rows), axis=axis)


def slices(count: int, size: int) -> list[slice]:
    """Slices of `size` items that cover `count` of them; a single one of no items."""
    return [slice(start, start + size) for start in range(0, max(1, count), size)]
