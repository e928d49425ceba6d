"""Collapse laws, a module each: the moment at which the bladder folds."""

from collections.abc import Mapping

from ..law import by_class, found
from .collapse_law import AbstractCollapse as AbstractCollapse


COLLAPSE_LAWS: Mapping[str, type[AbstractCollapse]] = found(
    __name__, __path__, AbstractCollapse, first="kim2021"
)


def __getattr__(name: str) -> type[AbstractCollapse]:
    return by_class(__name__, COLLAPSE_LAWS, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *(law.__name__ for law in COLLAPSE_LAWS.values())})
