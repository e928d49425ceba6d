"""Laws of a muscle's ends, a module each: what of its length doesn't contract, and what gives."""

from collections.abc import Mapping

from ..law import by_class, found
from .ends_law import AbstractEnds as AbstractEnds


ENDS_LAWS: Mapping[str, type[AbstractEnds]] = found(__name__, __path__, AbstractEnds, first="rigid")


def __getattr__(name: str) -> type[AbstractEnds]:
    return by_class(__name__, ENDS_LAWS, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *(law.__name__ for law in ENDS_LAWS.values())})
