"""One muscle, quasi-static: braid, bladder, tension, buckling, collapse, tuning.

Laws stand in the folders of their kinds; `LAWS` has them all.
"""

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
from .table import MuscleState as MuscleState
from .table import MuscleTable as MuscleTable
from .tuning import Tuning as Tuning
