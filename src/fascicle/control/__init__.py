"""Choosing pressures in time: crossings without a dip, policies of recruitment, a cascade of
controllers.

Names load when they are first used: dips need no JAX, whatever runs in time does.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .branches import Branches
    from .controller import Cascade, Gains, cascade
    from .crossings import Crossing, Path, crossing, crossings_on_reference, hand_over_time
    from .dip import Transition, added_force, needed_reserve, transition
    from .joint import Joint, JointPressures, JointStatus
    from .metrics import (
        ControlMetrics,
        Reachability,
        control_metrics,
        controlled_output,
        pareto_front,
        reachability,
    )
    from .policies import POLICIES
    from .step_response import LoopMargins, StepResponse, identify, loop_margins
    from .units import GasValves, OilValves, PlantValves

__all__ = [
    "POLICIES", "Branches", "Cascade", "ControlMetrics", "Crossing", "Gains", "GasValves", "Joint",
    "JointPressures", "JointStatus", "LoopMargins", "OilValves", "Path", "PlantValves",
    "Reachability", "StepResponse", "Transition", "added_force", "cascade", "control_metrics",
    "controlled_output", "crossing", "crossings_on_reference", "hand_over_time", "identify",
    "loop_margins", "needed_reserve", "pareto_front", "reachability", "transition",
]  # fmt: skip

_NAMES = {
    "branches": "Branches",
    "controller": "Cascade Gains cascade",
    "crossings": "Crossing Path crossing crossings_on_reference hand_over_time",
    "dip": "Transition added_force needed_reserve transition",
    "joint": "Joint JointPressures JointStatus",
    "metrics": "ControlMetrics Reachability control_metrics controlled_output pareto_front"
    " reachability",
    "policies": "POLICIES",
    "step_response": "LoopMargins StepResponse identify loop_margins",
    "units": "GasValves OilValves PlantValves",
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names.split()}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
