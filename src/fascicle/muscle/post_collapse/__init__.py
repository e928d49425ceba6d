"""Post-collapse laws: readings of (25), how a folded muscle pushes."""

from ..law import LawRegistry
from .post_collapse_law import AbstractPostCollapse as AbstractPostCollapse


POST_COLLAPSE_LAWS = LawRegistry(__name__, __path__, AbstractPostCollapse, default="derived")
__getattr__, __dir__ = POST_COLLAPSE_LAWS.package_attributes()
