"""What control of a run was worth, in words and with units for a reader."""

from typing import TYPE_CHECKING

from ..control import control_metrics, controlled_output, reachability
from ..plot.trajectory import Demand, display_unit


if TYPE_CHECKING:
    from ..control import ControlMetrics
    from ..dynamics import Plant, Trajectory
    from ..files import Scenario
    from ..files.controlled import Controlled

_FORCE = {"m": "N", "rad": "N·m"}


def judged(made: "Controlled", run: "Trajectory") -> "ControlMetrics":
    """What a `run` [SI] was worth that was controlled as is `made` [-]: a `ControlMetrics` [SI]."""
    return control_metrics(made.controller, run, made.reference)


def demanded(scenario: "Scenario", run: "Trajectory") -> Demand | None:
    """What a `run` [SI] of a `scenario` [-] was to follow [SI], or none where it was commanded."""
    made = scenario.controlled
    if made is None:
        return None
    can = reachability(made.controller, run.seen, made.reference).can
    return Demand(made.controller.of, made.reference, controlled_output(made.controller, run), can)


def told(plant: "Plant", of: str, what: "ControlMetrics") -> list[tuple[str, str]]:
    """What a run was `what` [SI] worth, of a `plant` [-] that is controlled `of` [-]: words with
    their unit, and figures [-].
    """
    factor, unit = display_unit(plant, of)
    rows = [
        (f"drawdown while the demand rises, {unit}", factor * what.drawdown),
        ("deepest dip of a unit on the way, N", what.dip),
        (f"root mean square of the error, {unit}", factor * what.rms),
        (f"largest error, {unit}", factor * what.largest_error),
        ("lag, ms", 1e3 * what.lag),
        ("energy from the supply, J", what.supply_energy),
        ("fluid from the supply, g", 1e3 * what.fluid),
        ("times that a unit was recruited", what.recruited),
        (f"demands that can't be reached, of {what.moments}", what.unreachable),
    ]
    return [(words, f"{value:.4g}") for words, value in rows]


def beyond(plant: "Plant", of: str, what: "ControlMetrics") -> str:
    """What was out of reach, with figures, of a run that was `what` [SI] worth, of a `plant` [-]
    that is controlled `of` [-]; empty where nothing was.
    """
    if not what.unreachable:
        return ""
    lack = f"they lack up to {what.short:.4g} {_FORCE[plant.load.unit]}"
    if of == "position" and what.short == 0:
        lack = "they lie off the load's way"
    return (
        f"{what.unreachable} of {what.moments} demands, from {what.first:.4g} s to"
        f" {what.last:.4g} s, can't be reached at the supply's pressure, whatever the policy:"
        f" {lack}; errors and lag are of the others"
    )
