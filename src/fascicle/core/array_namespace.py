"""Functions of an array library, chosen by the types of their arguments.

A law is written once, with these. Numbers and NumPy arrays stay with NumPy. Where a JAX array or
a tracer is among the arguments, the result is JAX's: compiled, batched and differentiated as its
caller asks.

Axes of nodes and of tables follow.
"""

import sys
from collections.abc import Callable, Sequence
from types import ModuleType

import numpy as np

from .errors import InvalidInputError
from .types import Marks, Numbers, Values


_NUMPY = (np.ndarray, np.generic, float, int)


def array_namespace(*values: Values) -> ModuleType:
    """Array library that computes with all of the `values`: NumPy or JAX's."""
    for value in values:
        if not isinstance(value, _NUMPY) and is_jax_array(value):
            return sys.modules["jax.numpy"]
    return np


def imported_jax() -> ModuleType | None:
    """The module `jax` where `fascicle.jax` has been imported, else `None`."""
    return sys.modules.get("jax") if "fascicle.jax" in sys.modules else None


def is_jax_array(value: object) -> bool:
    """True for arrays and tracers of JAX; `InvalidInputError` before `import fascicle.jax`."""
    jax = sys.modules.get("jax")
    if jax is None or isinstance(value, _NUMPY) or not isinstance(value, getattr(jax, "Array", ())):
        return False
    if "fascicle.jax" not in sys.modules:
        rule = "need `import fascicle.jax` first, which switches JAX to 64 bits"
        raise InvalidInputError("JAX arrays", rule, None)
    return True


def where(condition: Marks, x: Numbers, y: Numbers) -> Numbers:
    """Elements of `x` where the `condition` holds, else of `y`; numbers of numbers."""
    return array_namespace(condition, x, y).where(condition, x, y)[()]


def _elementwise(name: str) -> Callable[..., Numbers]:
    """NumPy's function of this name, in the array library of its arguments."""

    def call(*arrays: Numbers) -> Numbers:
        return getattr(array_namespace(*arrays), name)(*arrays)

    call.__name__ = call.__qualname__ = name
    return call


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


def node_axis(values: Numbers, template: Numbers) -> Numbers:
    """The `values` on a new first axis, ahead of all axes of the `template`."""
    return array_namespace(template).asarray(values).reshape((-1,) + (1,) * np.ndim(template))


def expand_nodes(x: Numbers, template: Numbers) -> Numbers:
    """`x` with axes of length 1 after its first, the nodes', to broadcast with the `template`."""
    missing = np.ndim(template) + 1 - np.ndim(x)
    return x if missing <= 0 else x.reshape(x.shape[:1] + (1,) * missing + x.shape[1:])


def sum_nodes(x: Numbers) -> Numbers:
    """Sum over the nodes, which lie on the first axis."""
    return array_namespace(x).sum(x, axis=0)


def min_nodes(x: Numbers) -> Numbers:
    """Minimum over the nodes, which lie on the first axis."""
    return array_namespace(x).min(x, axis=0)


def max_nodes(x: Numbers) -> Numbers:
    """Maximum over the nodes, which lie on the first axis."""
    return array_namespace(x).max(x, axis=0)


def add_table_axis(x: Numbers) -> Numbers:
    """`x` with a new last axis for the entries of a table."""
    return array_namespace(x).asarray(x)[..., None]


def sum_table(x: Numbers) -> Numbers:
    """Sum over the last axis, that of a table."""
    return array_namespace(x).sum(x, axis=-1)


def stack(rows: Sequence[Numbers], axis: int = 0) -> Numbers:
    """Broadcast arrays, stacked on a new `axis`, by default the first."""
    xp = array_namespace(*rows)
    return xp.stack(xp.broadcast_arrays(*rows), axis=axis)


def slices(count: int, size: int) -> list[slice]:
    """Slices of `size` items that cover `count` of them; a single one of no items."""
    return [slice(start, start + size) for start in range(0, max(1, count), size)]
