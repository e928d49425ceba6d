"""Laws of a muscle's ends: inactive length and compliance."""

from ..law import LawRegistry
from .ends_law import AbstractEnds as AbstractEnds


ENDS_LAWS = LawRegistry(__name__, __path__, AbstractEnds, default="rigid")
__getattr__, __dir__ = ENDS_LAWS.package_attributes()
