"""Fields of components, checked as they are set.

Invalid values raise an error, unusual ones a warning, as for muscles. Pressures are gauge pressures
unless a name says `absolute`; the pressure of the room, `room_pressure`, is absolute.
"""

from typing import Any

import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import record
from ..core.types import Batch, Values
from ..core.validation import Range, check_interval, check_plausible, check_positive


ROOM_PRESSURE = 101325.0  # Pa, absolute: the standard atmosphere
ROOM_TEMPERATURE = 293.15  # K: ISO 6358's reference, 20 °C
_ROOM = Range("Pa", 1e4, 3e4, 2e5, 1.2e8)  # from above the highest mountain to the deepest sea
_TEMPERATURE = Range("K", 100.0, 230.0, 400.0, 1500.0)  # from liquid air to hot gas


def positive_field(name: str, limits: Range, remedy: str = "", **default: Values) -> Any:
    """Field of a positive number within plausible `limits`; `remedy` is part of its error."""

    def validate(value: Values) -> Batch:
        return check_plausible(check_positive(value, name, limits.unit, remedy), name, limits)

    return record(converter=validate, unit=limits.unit, **default)


def nonnegative_field(name: str, limits: Range, remedy: str = "", **default: Values) -> Any:
    """Field of a number from zero within plausible `limits`; `remedy` is part of its error."""

    def validate(value: Values) -> Batch:
        closed = (True, False)
        x = check_interval(value, 0.0, np.inf, name, limits.unit, closed=closed, remedy=remedy)
        return check_plausible(x, name, limits)

    return record(converter=validate, unit=limits.unit, **default)


def interval_field(
    name: str,
    low: float,
    high: float,
    closed: tuple[bool, bool] = (False, False),
    remedy: str = "",
    unit: str = "-",
    **default: Values,
) -> Any:
    """Field of a number between `low` and `high`, each end `closed` or not; `remedy` is part of its
    error.
    """

    def validate(value: Values) -> Batch:
        return check_interval(value, low, high, name, unit, "", closed, remedy)

    return record(converter=validate, unit=unit, **default)


def component_field(name: str, kinds: tuple[type, ...], **default: Values) -> Any:
    """Field of a component of one of some `kinds`, or `None` if that is its `default`."""

    def validate(value: object) -> object:
        if isinstance(value, kinds) or (value is None and default.get("default", kinds) is None):
            return value
        names = " or ".join(f"`{kind.__name__}`" for kind in kinds)
        raise InvalidInputError(name, f"must be {names}", value, shown=f"`{type(value).__name__}`")

    return record(converter=validate, **default)


def room_pressure_field(**options: Values) -> Any:
    """Field of the room's pressure, absolute [Pa]; `options` of `record`."""

    def validate(value: Values) -> Batch:
        name, why, remedy = "room_pressure", "(absolute)", "at sea level it is 101325 Pa"
        x = check_interval(value, _ROOM.least, np.inf, name, "Pa", why, (True, False), remedy)
        return check_plausible(x, name, _ROOM)

    return record(converter=validate, default=ROOM_PRESSURE, unit="Pa", **options)


def temperature_field(name: str = "room_temperature", **options: Values) -> Any:
    """Field of a temperature [K]; `options` of `record`."""
    return positive_field(name, _TEMPERATURE, default=ROOM_TEMPERATURE, **options)
