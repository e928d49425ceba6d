"""Collapse laws: the moment at which the bladder folds."""

from ..law import LawRegistry
from .collapse_law import AbstractCollapse as AbstractCollapse


COLLAPSE_LAWS = LawRegistry(__name__, __path__, AbstractCollapse, default="kim2021")
__getattr__, __dir__ = COLLAPSE_LAWS.package_attributes()
