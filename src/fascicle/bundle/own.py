"""The scheme and the supply pressure that hold: those asked for, else the bundle's own."""

from typing import Any

from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, check_interval, check_plausible
from .bundle import Bundle
from .schemes import AbstractScheme, scheme_of


def scheme_used(bundle: Bundle, scheme: AbstractScheme | str | None) -> AbstractScheme:
    """The scheme that is asked for, or the bundle's own.

    **Arguments:** `bundle` [-]; `scheme`: by name or as an object [-], or `None`.

    **Returns:** the scheme [-].

    **Raises:** `ValueError` for an unknown name, and for a row of bundles.
    """
    _single(bundle)
    return bundle.scheme if scheme is None else scheme_of(scheme)


def supply_of(bundle: Bundle, supply_pressure: Values = None) -> float:
    """The supply pressure that holds: the one given, else the bundle's own.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `supply_pressure`: the one given [Pa], or None.

    **Returns:** supply pressure [Pa].

    **Raises:** `ValueError` where there is neither, and for a row of bundles.
    """
    _single(bundle)
    supply = bundle.supply_pressure if supply_pressure is None else supply_pressure
    if supply is None:
        raise InvalidInputError(
            "supply_pressure", "must be given in Pa", None, "the bundle has none of its own"
        )
    P = check_interval(
        supply, 0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa", "(gauge)", (False, True)
    )
    return float(check_plausible(P, "supply_pressure"))


def _single(bundle: Any) -> None:
    if not isinstance(bundle, Bundle):
        remedy = "make one of it: fs.Bundle([fs.MotorUnit(muscle)])"
        raise InvalidInputError(
            "bundle", "must be a Bundle", bundle, remedy, shown=type(bundle).__name__
        )
    if shape := bundle._batch:
        raise InvalidInputError(
            "bundle",
            "must be a single one here",
            None,
            "make a bundle of each row of its muscles",
            shown=f"rows of the shape {shape}",
        )
