"""Buckling laws, a module each: how a muscle resists past its free strain."""

from collections.abc import Mapping

from ..law import by_class, found
from .buckling_law import AbstractBuckling as AbstractBuckling
from .buckling_law import Buckled as Buckled
from .buckling_law import Push as Push


BUCKLING_LAWS: Mapping[str, type[AbstractBuckling]] = found(
    __name__, __path__, AbstractBuckling, first="kim2021"
)


def __getattr__(name: str) -> type[AbstractBuckling]:
    return by_class(__name__, BUCKLING_LAWS, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *(law.__name__ for law in BUCKLING_LAWS.values())})
