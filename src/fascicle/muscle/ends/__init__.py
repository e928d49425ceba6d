"""Laws of a muscle's ends: inactive length and compliance."""

from ..law import LawRegistry
from .ends_law import AbstractEnds as AbstractEnds


ENDS_LAWS = LawRegistry(__name__, __path__, AbstractEnds, default="rigid")
__getattr__ = ENDS_LAWS.get_class


def __dir__() -> list[str]:
    return sorted({*globals(), *ENDS_LAWS.class_names()})
