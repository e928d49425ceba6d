"""Choosing pressures in time: crossings without a dip, policies of recruitment, a cascade of
controllers.
"""

from .branches import Branches as Branches
from .cascade import Cascade as Cascade
from .cascade import Gains as Gains
from .crossing import Crossing as Crossing
from .crossing import Path as Path
from .crossing import crossing as crossing
from .crossing import hand_over_time as hand_over_time
from .identify import LoopMargins as LoopMargins
from .identify import StepResponse as StepResponse
from .identify import identify as identify
from .identify import loop_margins as loop_margins
from .metrics import ControlMetrics as ControlMetrics
from .metrics import Reachability as Reachability
from .metrics import control_metrics as control_metrics
from .metrics import controlled_output as controlled_output
from .metrics import pareto_front as pareto_front
from .metrics import reachability as reachability
from .policies import POLICIES as POLICIES
from .policies import cascade as cascade
from .policies import crossings_on_reference as crossings_on_reference
from .transition import Transition as Transition
from .transition import added_force as added_force
from .transition import needed_reserve as needed_reserve
from .transition import transition as transition
from .valves import GasValves as GasValves
from .valves import OilValves as OilValves
from .valves import PlantValves as PlantValves
