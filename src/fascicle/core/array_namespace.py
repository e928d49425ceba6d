"""Functions of an array library, chosen by the types of their arguments.

A law is written once, with these. Numbers and NumPy arrays stay with NumPy. Where a JAX array or
a tracer is among the arguments, the result is JAX's: compiled, batched and differentiated as its
caller asks. `register_namespace` adds other libraries, such as symbols from which C is written.

Sums of powers and of Chebyshev polynomials, elliptic integrals and evaluation in chunks follow.
"""

import importlib
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .types import Batch, BatchLike


NUMPY_TYPES = frozenset({float, int, bool, np.float64, np.ndarray, np.bool_, np.int64, np.float32})
FLOATS = frozenset({float, np.float64})
_BOOLS = frozenset({bool, np.bool_})
_SCALARS = NUMPY_TYPES - {np.ndarray}
_REGISTERED: dict[type, Any] = {}


def register_namespace(kind: type, functions: Any) -> None:
    """Compute with arrays of a `kind` by `functions`, an object with NumPy's names."""
    _REGISTERED[kind] = functions


def array_namespace(*values: Any) -> Any:
    """Library that computes with all of the `values`, single arrays or numbers."""
    xp: Any = np
    for value in values:
        if type(value) in NUMPY_TYPES:
            continue
        if type(value) in _REGISTERED:
            return _REGISTERED[type(value)]
        if is_jax_array(value):
            xp = sys.modules["jax.numpy"]
    return xp


def jax_backend() -> Any:
    """JAX side of the core, imported where it is first needed."""
    return importlib.import_module("fascicle.core.jax_backend")


def imported_jax() -> Any:
    """JAX, if it has been imported completely; else `None`."""
    jax = sys.modules.get("jax")
    return jax if hasattr(jax, "jit") else None


def is_jax_array(value: Any) -> bool:
    """True for arrays and tracers of JAX."""
    jax = imported_jax()
    return jax is not None and isinstance(value, jax.Array)


def as_jax(value: Any) -> Any:
    """A `value` [any unit] as an array of JAX, which has been imported."""
    return sys.modules["jax.numpy"].asarray(value)


def is_numpy(*values: Any) -> bool:
    """True where all `values` are numbers or NumPy arrays."""
    for value in values:
        if type(value) not in NUMPY_TYPES and not isinstance(value, np.generic):
            return False
    return True


def where(condition: Any, this: Any, other: Any) -> Any:
    """Choose `this` where the `condition` holds, else the `other`, elementwise."""
    # numbers are decided at once: NumPy's own `where` takes a microsecond and more for them
    if type(condition) in _BOOLS and type(this) in _SCALARS and type(other) in _SCALARS:
        return this if condition else other
    return array_namespace(condition, this, other).where(condition, this, other)


def _elementwise(name: str) -> Callable[..., Any]:
    """NumPy's function of this name, in the array library of its arguments."""
    of_numpy = getattr(np, name)

    def function(*arrays: Any) -> Any:
        for array in arrays:
            if type(array) not in NUMPY_TYPES:
                return getattr(array_namespace(*arrays), name)(*arrays)
        return of_numpy(*arrays)

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


def node_axis(values: Any, like: Any) -> Any:
    """The `values` on a first axis, ahead of all axes of `like`."""
    xp = array_namespace(like)
    if type(like) in _REGISTERED:
        return xp.asarray(values)
    return xp.asarray(values).reshape((-1,) + (1,) * np.ndim(like))


def expand_nodes(x: Any, like: Any) -> Any:
    """An array with nodes on its first axis, with as many axes more as `like` has."""
    if type(x) in _REGISTERED:
        return x
    more = np.ndim(like) + 1 - np.ndim(x)
    return x if more <= 0 else x.reshape(x.shape[:1] + (1,) * more + x.shape[1:])


def sum_nodes(x: Any) -> Any:
    """Sum over the nodes."""
    return array_namespace(x).sum(x, axis=0)


def min_nodes(x: Any) -> Any:
    """Minimum over the nodes."""
    return array_namespace(x).min(x, axis=0)


def max_nodes(x: Any) -> Any:
    """Maximum over the nodes."""
    return array_namespace(x).max(x, axis=0)


def add_table_axis(x: Any) -> Any:
    """`x` with a new last axis, for the entries of a table."""
    if type(x) in _REGISTERED:
        return x
    return array_namespace(x).asarray(x)[..., None]


def sum_table(x: Any) -> Any:
    """Sum over the last axis, that of a table."""
    return array_namespace(x).sum(x, axis=0 if type(x) in _REGISTERED else -1)


def stack(rows: Any) -> Any:
    """Several arrays, broadcast, on a new first axis."""
    xp = array_namespace(*rows)
    return xp.stack(xp.broadcast_arrays(*rows))


def running_max(x: Any, axis: int) -> Any:
    """Running maximum along an axis."""
    if is_jax_array(x):
        return jax_backend().cummax(x, axis)
    return np.maximum.accumulate(x, axis)


def polynomial(coefficients: Sequence[float], x: BatchLike) -> tuple[Batch, Batch]:
    """Polynomial of `x`, lowest power first, and its slope, by Horner's scheme."""
    value, slope = coefficients[-1] + 0.0 * x, 0.0 * x
    for term in coefficients[-2::-1]:
        value, slope = value * x + term, slope * x + value
    return value, slope


def chebyshev_sum(coefficients: Sequence[float], x: BatchLike) -> Batch:
    """Sum of Chebyshev polynomials of `x`, by Clenshaw's recurrence."""
    last, before, twice = 0.0 * x, 0.0 * x, 2 * x
    for term in coefficients[:0:-1]:
        last, before = twice * last - (before - term), last
    return x * last - before + coefficients[0]


_AGM_STEPS = 6  # the mean's error squares at each step: 5 suffice up to m = 0.9


class Elliptic(NamedTuple):
    """Complete elliptic integrals, and the mean's steps that give the incomplete ones."""

    K: Batch
    E: Batch
    means: tuple[Batch, ...]
    differences: tuple[Batch, ...]


def elliptic(m: BatchLike) -> Elliptic:
    """$K(m)$ and $E(m)$ of parameter $m = k^2$ in [0, 0.9], smooth at $m = 0$."""
    a, b = 1.0 + 0.0 * m, sqrt(1.0 - m)
    means, differences, total = [a], [0.0 * m], 0.5 * m
    for n in range(_AGM_STEPS):
        a, b, c = (a + b) / 2, sqrt(a * b), (a - b) / 2
        means.append(a)
        differences.append(c)
        total = total + 2**n * c**2
    K = np.pi / (2 * a)
    return Elliptic(K, K * (1 - total), tuple(means), tuple(differences))


def jacobi(u: BatchLike, integrals: Elliptic) -> tuple[Batch, Batch]:
    r"""Amplitude $\varphi = \mathrm{am}(u)$ and incomplete integral $E(\varphi)$ at $u$."""
    phase = 2.0**_AGM_STEPS * integrals.means[-1] * u
    epsilon = u * integrals.E / integrals.K
    for a, c in zip(integrals.means[:0:-1], integrals.differences[:0:-1], strict=True):
        epsilon = epsilon + c * sin(phase)
        phase = (phase + arcsin(c / a * sin(phase))) / 2
    return phase, epsilon


_CHUNK = 2**16  # points: half a megabyte an array, so that a law's passes stay in the cache


def map_in_chunks(function: Callable[..., Any], first: Any, second: Any) -> Any:
    """Evaluate an elementwise `function` of two NumPy arrays chunk by chunk along one axis.

    **Arguments:**

    - `function`: of both arrays.
    - `first`, `second`: arrays that broadcast [any unit].

    **Returns:** the function's result for both arrays [any unit]; memory holds one chunk's
    temporaries.
    """
    shape = np.broadcast_shapes(np.shape(first), np.shape(second))
    if (size := math.prod(shape)) <= _CHUNK:
        return function(first, second)
    pair = [np.reshape(x, (1,) * (len(shape) - np.ndim(x)) + np.shape(x)) for x in (first, second)]
    axis = int(np.argmax(pair[0].shape if pair[0].size > 1 else shape))
    step = max(1, _CHUNK * shape[axis] // size)
    parts = []
    for start in range(0, shape[axis], step):
        index = (slice(None),) * axis + (slice(start, start + step),)
        parts.append(function(*(x if x.shape[axis] == 1 else x[index] for x in pair)))
    if isinstance(parts[0], tuple):
        return type(parts[0])(*(np.concatenate(x, axis) for x in zip(*parts, strict=True)))
    return np.concatenate(parts, axis)
