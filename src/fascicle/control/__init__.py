"""Choosing pressures in time: crossings without a dip, policies of recruitment, a cascade of
controllers.
"""

from .branches import Branches as Branches
from .cascade import Cascade as Cascade
from .cascade import Gains as Gains
from .choice import Choice as Choice
from .choice import choose as choose
from .crossing import Crossing as Crossing
from .crossing import Path as Path
from .crossing import crossing as crossing
from .crossing import hand_over_time as hand_over_time
from .front import front as front
from .metrics import Reach as Reach
from .metrics import Worth as Worth
from .metrics import done as done
from .metrics import reachable as reachable
from .metrics import worth as worth
from .policies import POLICIES as POLICIES
from .policies import cascade as cascade
from .power_units import POWER_UNITS as POWER_UNITS
from .power_units import shaft_work as shaft_work
from .sines import Sines as Sines
from .sines import sines as sines
from .transition import Transition as Transition
from .transition import gain as gain
from .transition import needed_reserve as needed_reserve
from .transition import transition as transition
from .valves import GasValves as GasValves
from .valves import OilValves as OilValves
from .valves import PlantValves as PlantValves
