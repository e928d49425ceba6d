"""What is written with its unit: text, and pint's quantities, as SI numbers.

Laws see SI alone. Where a value is checked, `"2 bar"` and `2 * ureg.bar` become the number that
they are; a bare number is in the SI unit that the argument's docstring gives.
"""

from typing import Any

import numpy as np

from ..units import DIMENSIONS, sample
from ..units import parse as parsed
from .refused import Refused


_PLAIN = frozenset({float, int, bool, np.float64, np.int64, np.bool_, np.float32})
_SPELLED = str.maketrans({"·": "*", "²": "^2", "³": "^3"})
# of several with one unit, the first
_DIMENSIONS = {
    kind.si: name for name, kind in reversed(list(DIMENSIONS.items())) if not kind.unitless
}  # fmt: skip


def in_si(value: Any, name: str, unit: str) -> Any:
    """A value as SI numbers, where it is written with its unit; anything else as it is.

    **Arguments:**

    - `value`: text such as `"34.5 kPa"`, a pint quantity, or lists and arrays of them [-].
    - `name`: what to call it in an error [-].
    - `unit`: the SI unit that bare numbers have [-].

    **Returns:** numbers [SI].

    **Raises:** `ValueError`, one line, for another kind of quantity and for no quantity.
    """
    if type(value) in _PLAIN:
        return value
    dimension = "strain" if name == "strain" else _DIMENSIONS.get(unit.translate(_SPELLED))
    if dimension is None or not is_written(value):
        return value
    return _numbers(value, name, dimension)


def is_written(value: Any) -> bool:
    """Whether a `value` [-] is text or a quantity, or holds one."""
    if isinstance(value, list | tuple):
        # the kinds first: a long list of numbers is passed over in a glance
        return not {type(one) for one in value} <= _PLAIN and any(map(is_written, value))
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "UO" and any(map(is_written, value.flat))
    return isinstance(value, str) or hasattr(value, "m_as")


def _numbers(value: Any, name: str, dimension: str) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, str):
        return parsed(value, dimension, name)
    if isinstance(value, list | tuple):
        return [_numbers(one, name, dimension) for one in value]
    if not hasattr(value, "m_as"):
        return value
    kind = DIMENSIONS[dimension]
    try:
        return value.m_as(kind.si or "dimensionless")
    except (TypeError, ValueError, AttributeError):  # pint's own is a TypeError
        rule = f"must be {kind.article}, such as {sample(dimension)}"
        raise Refused(name, rule, value, shown=f"{value}") from None
