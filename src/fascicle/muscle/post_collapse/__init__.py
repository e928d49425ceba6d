"""Post-collapse laws: readings of (25), how a folded muscle pushes."""

from ..law import LawRegistry
from .post_collapse_law import AbstractPostCollapse as AbstractPostCollapse


POST_COLLAPSE_LAWS = LawRegistry(__name__, __path__, AbstractPostCollapse, default="derived")
__getattr__ = POST_COLLAPSE_LAWS.get_class


def __dir__() -> list[str]:
    return sorted({*globals(), *POST_COLLAPSE_LAWS.class_names()})
