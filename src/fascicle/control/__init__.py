"""Choosing pressures in time: when the next motor unit can be recruited without a dip."""

from .branches import Branches as Branches
from .crossing import Crossing as Crossing
from .crossing import Path as Path
from .crossing import crossing as crossing
from .crossing import hand_over_time as hand_over_time
from .transition import Transition as Transition
from .transition import gain as gain
from .transition import needed_reserve as needed_reserve
from .transition import transition as transition
from .valves import GasValves as GasValves
from .valves import OilValves as OilValves
from .valves import PlantValves as PlantValves
