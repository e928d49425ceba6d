"""Post-collapse laws, a module each: readings of (25), how a folded muscle pushes."""

from collections.abc import Mapping

from ..law import by_class, found
from .post_collapse_law import AbstractPostCollapse as AbstractPostCollapse


POST_COLLAPSE_LAWS: Mapping[str, type[AbstractPostCollapse]] = found(
    __name__, __path__, AbstractPostCollapse, first="derived"
)


def __getattr__(name: str) -> type[AbstractPostCollapse]:
    return by_class(__name__, POST_COLLAPSE_LAWS, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *(law.__name__ for law in POST_COLLAPSE_LAWS.values())})
