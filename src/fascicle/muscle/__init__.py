"""One muscle, quasi-static: braid, bladder, tension, buckling, collapse, tuning.

Laws stand in the folders of their kinds; `LAWS` has them all.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy
from ..core.parameters import Constant as Constant
from ..core.parameters import Switch as Switch
from . import buckling as buckling
from . import collapse as collapse
from . import ends as ends
from . import materials as materials
from . import post_collapse as post_collapse
from . import tension as tension
from .laws import LAWS as LAWS
from .materials import MooneyRivlin as MooneyRivlin
from .muscle import AtPressure as AtPressure
from .muscle import Muscle as Muscle
from .piecewise import Response as Response
from .tuning import Tuning as Tuning


if TYPE_CHECKING:
    from .surface import Surface as Surface
    from .surface import UnitSurface as UnitSurface

__getattr__, __dir__ = attach_lazy(__name__, {"Surface": "surface", "UnitSurface": "surface"})
