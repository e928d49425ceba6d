"""Functions of an array library, chosen by the types of their arguments.

A law is written once, with these. Numbers and NumPy arrays stay with NumPy. Where a JAX array or
a tracer is among the arguments, the result is JAX's: compiled, batched and differentiated as its
caller asks.

Axes of nodes and of tables follow.
"""

import importlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from .errors import InvalidInputError


# types that NumPy computes with; a set is looked up sooner than instances are checked
NUMPY_TYPES = frozenset({float, int, bool, np.float64, np.ndarray, np.bool_, np.int64, np.float32})
FLOATS = frozenset({float, np.float64})
_BOOLS = frozenset({bool, np.bool_})
NUMPY_SCALARS = NUMPY_TYPES - {np.ndarray}


def array_namespace(*values: Any) -> Any:
    """Array library that computes with all of the `values`: NumPy or JAX's."""
    xp: Any = np
    for value in values:
        if type(value) in NUMPY_TYPES:
            continue
        if is_jax_array(value):
            xp = sys.modules["jax.numpy"]
    return xp


def jax_backend() -> Any:
    """Module `core.jax_backend`, imported at the first use."""
    return importlib.import_module("fascicle.core.jax_backend")


def imported_jax() -> Any:
    """The module `jax` where `fascicle.jax` has been imported, else `None`."""
    return sys.modules.get("jax") if "fascicle.jax" in sys.modules else None


def is_jax_array(value: Any) -> bool:
    """True for arrays and tracers of JAX; `InvalidInputError` before `import fascicle.jax`."""
    jax = sys.modules.get("jax")
    if jax is None or not isinstance(value, getattr(jax, "Array", ())):
        return False
    if "fascicle.jax" not in sys.modules:
        rule = "need `import fascicle.jax` first, which switches JAX to 64 bits"
        raise InvalidInputError("JAX arrays", rule, None)
    return True


def as_jax(value: Any) -> Any:
    """A `value` [any unit] as an array of JAX; JAX must have been imported."""
    return sys.modules["jax.numpy"].asarray(value)


def is_numpy(*values: Any) -> bool:
    """True where all `values` are numbers or NumPy arrays."""
    for value in values:
        if type(value) not in NUMPY_TYPES and not isinstance(value, np.generic):
            return False
    return True


def where(condition: Any, x: Any, y: Any) -> Any:
    """Elements of `x` where the `condition` holds, else of `y`."""
    # numbers are decided at once: NumPy's own `where` takes a microsecond and more for them
    if type(condition) in _BOOLS and type(x) in NUMPY_SCALARS and type(y) in NUMPY_SCALARS:
        return x if condition else y
    return array_namespace(condition, x, y).where(condition, x, y)


def _elementwise(name: str) -> Callable[..., Any]:
    """NumPy's function of this name, in the array library of its arguments."""
    numpy_function = getattr(np, name)

    def function(*arrays: Any) -> Any:
        for array in arrays:
            if type(array) not in NUMPY_TYPES:
                return getattr(array_namespace(*arrays), name)(*arrays)
        return numpy_function(*arrays)

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
