r"""Numbers that carry their slopes, so that NumPy differentiates a law while it evaluates it.

A `Dual` is an array and its slopes by some numbers $\theta_1 \dots \theta_n$, on a last axis.
NumPy's functions work on it as on an array, by the chain rule

$$\frac{\mathrm{d} f(x, y)}{\mathrm{d}\theta_i} = f_x \frac{\mathrm{d} x}{\mathrm{d}\theta_i}
    + f_y \frac{\mathrm{d} y}{\mathrm{d}\theta_i},$$

so a law, which takes its arguments' library, needs not know of it. What is compared, counted or
ordered is the values alone. At a kink slopes are those that JAX takes: of `maximum` of two
equals the mean, of `absolute` at zero that of larger arguments.

**Source:** forward accumulation: Wengert (1964).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin


class Dual(NDArrayOperatorsMixin):
    """An array and its slopes, which have one axis more."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: np.ndarray):
        """**Arguments:** `value` [any unit]; `slopes`: of it, on a last axis [any unit]."""
        self.value, self.slopes = np.asarray(value)[()], slopes

    @property
    def shape(self) -> tuple[int, ...]:
        """Its shape [-], as that of its value."""
        return np.shape(self.value)

    @property
    def ndim(self) -> int:
        """How many axes it has [-]."""
        return np.ndim(self.value)

    @property
    def size(self) -> int:
        """How many numbers it holds [-]."""
        return np.size(self.value)

    def is_symbolic(self) -> bool:
        """Whether it is a bare name [-]: it has numbers."""
        return False

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """An elementwise function of NumPy's."""
        if method != "__call__" or options:
            return NotImplemented  # which NumPy tells the caller
        values = [_value(x) for x in inputs]
        result = ufunc(*values)
        if result.dtype != float:
            return result
        parts = _RULES[ufunc](result, *values)
        slopes = [
            np.asarray(part)[..., None] * x.slopes
            for part, x in zip(parts, inputs, strict=True)
            if isinstance(x, Dual)
        ]
        return Dual(result, sum(slopes[1:], slopes[0]))

    def __array_function__(self, function: Any, types: Any, inputs: Any, options: Any) -> Any:
        """Another function of NumPy's: it moves, joins or sums entries, or looks at values."""
        if function in _MOVES:
            return _MOVES[function](*inputs, **options)
        if function in _LOOKS:
            return function(*map(_value, inputs), **options)
        return NotImplemented

    def __array__(self, *_: Any, **__: Any) -> np.ndarray:
        """Refused: as an array it would lose its slopes."""
        raise TypeError("a number with slopes can't become an array without them.")

    def __getitem__(self, places: Any) -> "Dual":
        """Its entries at `places` [-]."""
        of = places if isinstance(places, tuple) else (places,)
        # behind an ellipsis places count from the end, where the slopes are
        behind = any(place is Ellipsis for place in of)
        return Dual(self.value[of], _full(self)[(*of, slice(None)) if behind else of])

    def reshape(self, *shape: Any) -> "Dual":
        """The same entries in another `shape` [-]."""
        value = np.reshape(self.value, shape[0] if isinstance(shape[0], tuple) else shape)
        return Dual(value, _full(self).reshape((*value.shape, -1)))


def seeded(values: Sequence[Any]) -> list[Dual]:
    """The arrays `values` [any unit], each entry with a slope of 1 by itself: slopes of what
    follows from them are by all entries, one array after the other.
    """
    count, made, done = sum(np.size(x) for x in values), [], 0
    for x in values:
        slopes = np.zeros((np.size(x), count))
        slopes[:, done : done + np.size(x)] = np.eye(np.size(x))
        made.append(Dual(np.asarray(x, float), slopes.reshape((*np.shape(x), count))))
        done += np.size(x)
    return made


def slopes_of(x: Any, count: int) -> np.ndarray:
    """The slopes of `x` [any unit] by `count` numbers [-]: none where it depends on none."""
    return _full(x) if isinstance(x, Dual) else np.zeros((*np.shape(x), count))


def _value(x: Any) -> Any:
    return x.value if isinstance(x, Dual) else x


def _power(y: Any, x: Any, n: Any) -> tuple[Any, Any]:
    # as of a power's base alone where the exponent is a number: log(x) may not exist
    return n * x ** np.where(n == 0, 1.0, n - 1.0), y * np.log(np.where(x > 0, x, 1.0))


def _larger(y: Any, a: Any, b: Any) -> tuple[Any, Any]:
    share = np.where(a == b, 0.5, a == y)
    return share, 1 - share


# what a function's value moves with each of its arguments; `y` is the value
_RULES: Mapping[Any, Callable[..., tuple]] = {
    np.add: lambda *_: (1.0, 1.0),
    np.subtract: lambda *_: (1.0, -1.0),
    np.multiply: lambda _, a, b: (b, a),
    np.divide: lambda y, _, b: (1 / b, -y / b),
    np.negative: lambda *_: (-1.0,),
    np.power: _power,
    np.square: lambda _, a: (2 * a,),
    np.sqrt: lambda y, _: (0.5 / y,),
    np.exp: lambda y, _: (y,),
    np.expm1: lambda y, _: (y + 1,),
    np.log: lambda _, a: (1 / a,),
    np.log1p: lambda _, a: (1 / (1 + a),),
    np.sin: lambda _, a: (np.cos(a),),
    np.cos: lambda _, a: (-np.sin(a),),
    np.tan: lambda y, _: (1 + y**2,),
    np.arcsin: lambda _, a: (1 / np.sqrt(1 - a**2),),
    np.arccos: lambda _, a: (-1 / np.sqrt(1 - a**2),),
    np.arctan: lambda _, a: (1 / (1 + a**2),),
    np.absolute: lambda _, a: (np.where(a >= 0, 1.0, -1.0),),
    np.minimum: _larger,
    np.maximum: _larger,
}


def _full(x: Dual) -> np.ndarray:
    """The slopes of each entry of `x`, which may be the same for many."""
    return np.broadcast_to(x.slopes, (*x.shape, x.slopes.shape[-1]))


def _behind(axis: int) -> int:
    """Where an `axis` of values is in their slopes [-]."""
    return axis if axis >= 0 else axis - 1


def _joined(join: Callable, axis: int, pieces: Sequence[Any]) -> Dual:
    count = max(x.slopes.shape[-1] for x in pieces if isinstance(x, Dual))
    value = join([_value(x) for x in pieces], axis=axis)
    slopes = [slopes_of(x, count) for x in pieces]
    return Dual(value, join(slopes, axis=_behind(axis)))


def _where(condition: Any, this: Any, other: Any) -> Any:
    condition = _value(condition)
    if not (isinstance(this, Dual) or isinstance(other, Dual)):
        return np.where(condition, this, other)
    value = np.where(condition, _value(this), _value(other))
    zero = np.zeros(1)
    slopes = (x.slopes if isinstance(x, Dual) else zero for x in (this, other))
    return Dual(value, np.where(np.asarray(condition)[..., None], *slopes))


def _stack(pieces: Sequence[Any], axis: int = 0) -> Dual:
    return _joined(np.stack, axis, pieces)


def _concatenate(pieces: Sequence[Any], axis: int = 0) -> Dual:
    return _joined(np.concatenate, axis, pieces)


def _broadcast_to(x: Dual, shape: tuple[int, ...]) -> Dual:
    return Dual(
        np.broadcast_to(x.value, shape),
        np.expand_dims(x.slopes, tuple(range(len(shape) - x.slopes.ndim + 1))),
    )


def _broadcast_arrays(*arrays: Any) -> list[Any]:
    shape = np.broadcast_shapes(*(np.shape(_value(x)) for x in arrays))
    return [np.broadcast_to(x, shape) for x in arrays]


def _sum(x: Dual, axis: int) -> Dual:
    return Dual(np.sum(x.value, axis=axis), np.sum(_full(x), axis=_behind(axis)))


def _chosen(choose: Callable) -> Callable:
    """The least or the largest along an axis, with the slopes of the first that is it."""

    def chosen(x: Dual, axis: int) -> Dual:
        places = np.expand_dims(choose(x.value, axis=axis), axis)
        found = _take_along_axis(x, places, axis)
        return Dual(found.value.squeeze(axis), found.slopes.squeeze(_behind(axis)))

    return chosen


def _take_along_axis(x: Dual, places: Any, axis: int) -> Dual:
    slopes = np.take_along_axis(_full(x), places[..., None], axis=_behind(axis))
    return Dual(np.take_along_axis(x.value, places, axis=axis), slopes)


_MOVES: Mapping[Any, Callable] = {
    np.where: _where,
    np.stack: _stack,
    np.concatenate: _concatenate,
    np.broadcast_arrays: _broadcast_arrays,
    np.broadcast_to: _broadcast_to,
    np.sum: _sum,
    np.min: _chosen(np.argmin),
    np.max: _chosen(np.argmax),
    np.take_along_axis: _take_along_axis,
    np.reshape: lambda x, shape: x.reshape(shape),
}

_LOOKS = frozenset({np.shape, np.ndim, np.size, np.argmin, np.argmax, np.argsort})
