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
from math import isnan
from typing import Any, NamedTuple

import numpy as np

from .types import Batch, BatchLike


_PLAIN = frozenset({float, int, bool, np.float64, np.ndarray, np.bool_, np.int64, np.float32})
_TRUTHS = frozenset({bool, np.bool_})
_SCALARS = frozenset({float, int, bool, np.float64, np.int64, np.bool_})
FLOATS = frozenset({float, np.float64})
_OTHERS: dict[type, Any] = {}


def register_namespace(kind: type, functions: Any) -> None:
    """Let arrays of a `kind` [-] be worked on by `functions` [-], named as NumPy's are."""
    _OTHERS[kind] = functions


def array_namespace(*values: Any) -> Any:
    """The library [-] that computes with all of `values` [-], single arrays or numbers."""
    xp: Any = np
    for value in values:
        if type(value) in _PLAIN:
            continue
        if type(value) in _OTHERS:
            return _OTHERS[type(value)]
        if is_jax_array(value):
            xp = sys.modules["jax.numpy"]
    return xp


def jax_backend() -> Any:
    """The JAX side of the core [-], loaded where it is first needed."""
    return importlib.import_module("fascicle.core.jax_backend")


def imported_jax() -> Any:
    """JAX [-], if it has been imported completely; else `None`."""
    jax = sys.modules.get("jax")
    return jax if hasattr(jax, "jit") else None


def is_jax_array(value: Any) -> bool:
    """Whether a `value` [-] is an array or a tracer of JAX's."""
    jax = imported_jax()
    return jax is not None and isinstance(value, jax.Array)


def as_jax(value: Any) -> Any:
    """A `value` [any unit] as an array of JAX's, which has been imported."""
    return sys.modules["jax.numpy"].asarray(value)


def is_numpy(*values: Any) -> bool:
    """Whether all `values` [-] are numbers or NumPy's arrays."""
    return all(type(value) in _PLAIN or isinstance(value, np.generic) for value in values)


def where(condition: Any, this: Any, other: Any) -> Any:
    """Where the `condition` holds `this`, else the `other`, elementwise."""
    # numbers are decided at once: NumPy's own `where` takes a microsecond and more for them
    if type(condition) in _TRUTHS and type(this) in _SCALARS and type(other) in _SCALARS:
        return this if condition else other
    return array_namespace(condition, this, other).where(condition, this, other)


# symbols have no `&`, `|` and `~`


def logical_and(this: Any, other: Any) -> Any:
    """Whether two conditions hold, elementwise."""
    xp = array_namespace(this, other)
    return xp.logical_and(this, other) if type(this) in _OTHERS else this & other


def logical_or(this: Any, other: Any) -> Any:
    """Whether one of two conditions holds, elementwise."""
    xp = array_namespace(this, other)
    return xp.logical_or(this, other) if type(this) in _OTHERS else this | other


def logical_not(condition: Any) -> Any:
    """Whether a condition doesn't hold, elementwise."""
    if type(condition) in _OTHERS:
        return array_namespace(condition).logical_not(condition)
    return not condition if isinstance(condition, bool) else ~condition


def sqrt(x: Any) -> Any:
    """Square root."""
    return array_namespace(x).sqrt(x)


def exp(x: Any) -> Any:
    """Exponential."""
    return array_namespace(x).exp(x)


def expm1(x: Any) -> Any:
    """Exponential less one, exact near zero."""
    return array_namespace(x).expm1(x)


def log(x: Any) -> Any:
    """Natural logarithm."""
    return array_namespace(x).log(x)


def log1p(x: Any) -> Any:
    """Natural logarithm of one and `x`, exact near zero."""
    return array_namespace(x).log1p(x)


def sin(x: Any) -> Any:
    """Sine of an angle [rad]."""
    return array_namespace(x).sin(x)


def cos(x: Any) -> Any:
    """Cosine of an angle [rad]."""
    return array_namespace(x).cos(x)


def tan(x: Any) -> Any:
    """Tangent of an angle [rad]."""
    return array_namespace(x).tan(x)


def arcsin(x: Any) -> Any:
    """The angle [rad] of a sine."""
    return array_namespace(x).arcsin(x)


def arccos(x: Any) -> Any:
    """The angle [rad] of a cosine."""
    return array_namespace(x).arccos(x)


def arctan(x: Any) -> Any:
    """The angle [rad] of a tangent."""
    return array_namespace(x).arctan(x)


def absolute(x: Any) -> Any:
    """Size without sign."""
    return array_namespace(x).absolute(x)


def minimum(x: Any, y: Any) -> Any:
    """The smaller of two, elementwise."""
    if type(x) in FLOATS and type(y) in FLOATS:  # as for `where`; NaN if one of them is
        return np.float64(x if x < y or isnan(x) else y)
    return array_namespace(x, y).minimum(x, y)


def maximum(x: Any, y: Any) -> Any:
    """The larger of two, elementwise."""
    if type(x) in FLOATS and type(y) in FLOATS:
        return np.float64(x if x > y or isnan(x) else y)
    return array_namespace(x, y).maximum(x, y)


def isfinite(x: Any) -> Any:
    """Whether it is neither infinite nor NaN."""
    return array_namespace(x).isfinite(x)


# nodes lie on a first axis of their own, so that everything else broadcasts as it did


def node_axis(values: Any, like: Any) -> Any:
    """The `values` on a first axis, ahead of all those that `like` has."""
    xp = array_namespace(like)
    if type(like) in _OTHERS:
        return xp.asarray(values)
    return xp.asarray(values).reshape((-1,) + (1,) * np.ndim(like))


def expand_nodes(x: Any, like: Any) -> Any:
    """What has nodes on its first axis, laid over all axes that `like` has."""
    if type(x) in _OTHERS:
        return x
    more = np.ndim(like) + 1 - np.ndim(x)
    return x if more <= 0 else x.reshape(x.shape[:1] + (1,) * more + x.shape[1:])


def sum_nodes(x: Any) -> Any:
    """Sum over the nodes."""
    return array_namespace(x).sum(x, axis=0)


def min_nodes(x: Any) -> Any:
    """The smallest of the nodes."""
    return array_namespace(x).min(x, axis=0)


def max_nodes(x: Any) -> Any:
    """The largest of the nodes."""
    return array_namespace(x).max(x, axis=0)


def add_table_axis(x: Any) -> Any:
    """`x` with a new last axis, along which a table goes."""
    if type(x) in _OTHERS:
        return x
    return array_namespace(x).asarray(x)[..., None]


def sum_table(x: Any) -> Any:
    """Sum over that last axis."""
    return array_namespace(x).sum(x, axis=0 if type(x) in _OTHERS else -1)


def stack(rows: Any) -> Any:
    """Several arrays, made equally large, on a new first axis."""
    xp = array_namespace(*rows)
    return xp.stack(xp.broadcast_arrays(*rows))


def running_max(x: Any, axis: int) -> Any:
    """The largest so far, along an axis."""
    if is_jax_array(x):
        return jax_backend().cummax(x, axis)
    return np.maximum.accumulate(x, axis)


def polynomial(coefficients: Sequence[float], x: BatchLike) -> tuple[Batch, Batch]:
    """A polynomial of `x`, lowest power first, and its slope, by Horner's scheme."""
    value, slope = coefficients[-1] + 0.0 * x, 0.0 * x
    for term in coefficients[-2::-1]:
        value, slope = value * x + term, slope * x + value
    return value, slope


def chebyshev_sum(coefficients: Sequence[float], x: BatchLike) -> Batch:
    """The sum of Chebyshev polynomials of `x`, by Clenshaw's recurrence."""
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
    """An elementwise `function` of two of NumPy's arrays, chunk by chunk along one axis.

    **Arguments:**

    - `function`: of both [-]; what it solves for `first` alone is then solved for once.
    - `first`, `second`: arrays that broadcast [any unit].

    **Returns:** what it gives for the whole [any unit]; memory holds one chunk's temporaries.
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
