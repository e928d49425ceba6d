"""Tension laws: the pull of a muscle up to its free strain."""

from ..law import LawRegistry
from .tension_law import AbstractTension as AbstractTension
from .tension_law import Offset as Offset
from .tension_law import Pull as Pull
from .tension_law import solved_free_strain as solved_free_strain


TENSION_LAWS = LawRegistry(__name__, __path__, AbstractTension, default="klute_hannaford")
__getattr__, __dir__ = TENSION_LAWS.package_attributes()
