"""An array library's functions, chosen by what they are given.

A law is written once, with these. Numbers and NumPy arrays stay NumPy's, and are answered at
once; where a JAX array or a tracer is among the arguments the result is JAX's, compiled,
batched and differentiated as its caller asks. Other libraries (symbols, from which C is
written) are made known by `register`.
"""

import importlib
import sys
from math import isnan
from typing import Any

import numpy as np


_PLAIN = frozenset({float, int, bool, np.float64, np.ndarray, np.bool_, np.int64, np.float32})
_TRUTHS = frozenset({bool, np.bool_})
_SCALARS = frozenset({float, int, bool, np.float64, np.int64, np.bool_})
FLOATS = frozenset({float, np.float64})
_OTHERS: dict[type, Any] = {}


def register(kind: type, functions: Any) -> None:
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


library, given = array_namespace, is_numpy  # names that modules not yet renamed use


def where(condition: Any, this: Any, other: Any) -> Any:
    """Where the `condition` holds `this`, else the `other`, elementwise."""
    # numbers are decided at once: NumPy's own `where` takes a microsecond and more for them
    if type(condition) in _TRUTHS and type(this) in _SCALARS and type(other) in _SCALARS:
        return this if condition else other
    return array_namespace(condition, this, other).where(condition, this, other)


# symbols have no `&`, `|` and `~`


def both(this: Any, other: Any) -> Any:
    """Whether two conditions hold, elementwise."""
    xp = array_namespace(this, other)
    return xp.logical_and(this, other) if type(this) in _OTHERS else this & other


def either(this: Any, other: Any) -> Any:
    """Whether one of two conditions holds, elementwise."""
    xp = array_namespace(this, other)
    return xp.logical_or(this, other) if type(this) in _OTHERS else this | other


def no(condition: Any) -> Any:
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


def nodes(values: Any, like: Any) -> Any:
    """The `values` on a first axis, ahead of all those that `like` has."""
    xp = array_namespace(like)
    if type(like) in _OTHERS:
        return xp.asarray(values)
    return xp.asarray(values).reshape((-1,) + (1,) * np.ndim(like))


def over(x: Any, like: Any) -> Any:
    """What has nodes on its first axis, laid over all axes that `like` has."""
    if type(x) in _OTHERS:
        return x
    more = np.ndim(like) + 1 - np.ndim(x)
    return x if more <= 0 else x.reshape(x.shape[:1] + (1,) * more + x.shape[1:])


def total(x: Any) -> Any:
    """Sum over the nodes."""
    return array_namespace(x).sum(x, axis=0)


def least(x: Any) -> Any:
    """The smallest of the nodes."""
    return array_namespace(x).min(x, axis=0)


def most(x: Any) -> Any:
    """The largest of the nodes."""
    return array_namespace(x).max(x, axis=0)


def spread(x: Any) -> Any:
    """`x` with a new last axis, along which a table goes."""
    if type(x) in _OTHERS:
        return x
    return array_namespace(x).asarray(x)[..., None]


def along_table(x: Any) -> Any:
    """Sum over that last axis."""
    return array_namespace(x).sum(x, axis=0 if type(x) in _OTHERS else -1)


def stack(rows: Any) -> Any:
    """Several arrays, made equally large, on a new first axis."""
    xp = array_namespace(*rows)
    return xp.stack(xp.broadcast_arrays(*rows))


def running_most(x: Any, axis: int) -> Any:
    """The largest so far, along an axis."""
    if is_jax_array(x):
        return jax_backend().cummax(x, axis)
    return np.maximum.accumulate(x, axis)
