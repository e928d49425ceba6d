"""Tension laws, a module each: the pull of a muscle up to its free strain."""

from collections.abc import Mapping

from ..law import by_class, found
from .tension_law import AbstractTension as AbstractTension
from .tension_law import Offset as Offset
from .tension_law import Pull as Pull
from .tension_law import solved_free_strain as solved_free_strain


TENSION_LAWS: Mapping[str, type[AbstractTension]] = found(
    __name__, __path__, AbstractTension, first="klute_hannaford"
)


def __getattr__(name: str) -> type[AbstractTension]:
    return by_class(__name__, TENSION_LAWS, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *(law.__name__ for law in TENSION_LAWS.values())})
