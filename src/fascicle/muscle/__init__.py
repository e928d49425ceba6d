"""One muscle, quasi-static: braid, bladder, tension, buckling, collapse, tuning."""

from . import materials as materials
from .materials import MooneyRivlin as MooneyRivlin
from .muscle import Muscle as Muscle
from .piecewise import Response as Response
from .tuning import Tuning as Tuning
