"""Buckling laws: how a muscle resists past its free strain."""

from ..law import LawRegistry
from .buckling_law import AbstractBuckling as AbstractBuckling
from .buckling_law import BucklingColumn as BucklingColumn
from .buckling_law import Centerline as Centerline
from .buckling_law import Push as Push


BUCKLING_LAWS = LawRegistry(__name__, __path__, AbstractBuckling, default="kim2021")
__getattr__, __dir__ = BUCKLING_LAWS.package_attributes()
