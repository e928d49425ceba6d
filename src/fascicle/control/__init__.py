"""Choosing pressures in time: crossings without a dip, policies of recruitment, a cascade of
controllers.

Dips and step responses need no JAX; whatever runs in time does.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .branches import Branches as Branches
    from .controller import Cascade as Cascade
    from .controller import Gains as Gains
    from .crossings import Crossing as Crossing
    from .crossings import Path as Path
    from .crossings import crossing as crossing
    from .crossings import hand_over_time as hand_over_time
    from .dip import Transition as Transition
    from .dip import added_force as added_force
    from .dip import needed_reserve as needed_reserve
    from .dip import transition as transition
    from .metrics import ControlMetrics as ControlMetrics
    from .metrics import Reachability as Reachability
    from .metrics import control_metrics as control_metrics
    from .metrics import controlled_output as controlled_output
    from .metrics import pareto_front as pareto_front
    from .metrics import reachability as reachability
    from .policies import POLICIES as POLICIES
    from .policies import cascade as cascade
    from .policies import crossings_on_reference as crossings_on_reference
    from .step_response import LoopMargins as LoopMargins
    from .step_response import StepResponse as StepResponse
    from .step_response import identify as identify
    from .step_response import loop_margins as loop_margins
    from .valves import GasValves as GasValves
    from .valves import OilValves as OilValves
    from .valves import PlantValves as PlantValves

__all__ = [
    "Branches",
    "Cascade",
    "ControlMetrics",
    "Crossing",
    "Gains",
    "GasValves",
    "LoopMargins",
    "OilValves",
    "POLICIES",
    "Path",
    "PlantValves",
    "Reachability",
    "StepResponse",
    "Transition",
    "added_force",
    "cascade",
    "control_metrics",
    "controlled_output",
    "crossing",
    "crossings_on_reference",
    "hand_over_time",
    "identify",
    "loop_margins",
    "needed_reserve",
    "pareto_front",
    "reachability",
    "transition",
]

_HOMES = {
    "Branches": "branches",
    "Cascade": "controller",
    "ControlMetrics": "metrics",
    "Crossing": "crossings",
    "Gains": "controller",
    "GasValves": "valves",
    "LoopMargins": "step_response",
    "OilValves": "valves",
    "POLICIES": "policies",
    "Path": "crossings",
    "PlantValves": "valves",
    "Reachability": "metrics",
    "StepResponse": "step_response",
    "Transition": "dip",
    "added_force": "dip",
    "cascade": "policies",
    "control_metrics": "metrics",
    "controlled_output": "metrics",
    "crossing": "crossings",
    "crossings_on_reference": "policies",
    "hand_over_time": "crossings",
    "identify": "step_response",
    "loop_margins": "step_response",
    "needed_reserve": "dip",
    "pareto_front": "metrics",
    "reachability": "metrics",
    "transition": "dip",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
