"""Outputs of a plant at a time, with a status of their reliability."""

from typing import Any, NamedTuple

from ..core.array_namespace import array_namespace
from ..core.types import Batch, Numbers
from .energy_ledger import stored_energies
from .motion import FrictionMemory, PlantEvaluation, State
from .plant import Plant


# events of a run, and reasons not to trust it from then on; an output's status has a bit for each
STATUS = (
    "folded",  # a muscle's volume falls with pressure by more than hose and fluid expand
    "cavitates",  # a fluid at a pressure below its vapor's
    "off_table",  # a strain or pressure outside the muscles' tables
    "unsettled",  # a pressure that did not converge
    "supply_empty",
    "stop",  # the load is at its stop
    "stiff",  # a step that needed more substeps
    "broken",  # numbers that are not finite
)
_NEARLY_EMPTY = 100.0  # Pa above no fluid: a thousandth of an atmosphere


class PlantOutputs(NamedTuple):
    """Outputs of a plant at a time: what a sensor or a report could show.

    `position`, `velocity` [SI]; of each unit: `pressures` [Pa], `temperatures` [K], `strains` [-],
    `forces` of all its muscles [N], `volumes` [m³], `masses` [kg], openings to `supply` and
    `exhaust` [-], flows `drawn` and `vented` [kg/s]; `supply_pressure` [Pa]; energies in `store`:
    of fluid, muscles, motion, load, stop and friction [J]; `status`: bits of `STATUS`;
    `reserve`: the supply's own state [SI].
    """

    position: Batch
    velocity: Batch
    pressures: Numbers
    temperatures: Numbers
    strains: Numbers
    forces: Numbers
    volumes: Numbers
    masses: Numbers
    supply: Numbers
    exhaust: Numbers
    drawn: Numbers
    vented: Numbers
    supply_pressure: Batch
    store: Numbers
    status: Any
    reserve: Numbers


def observe(
    plant: Plant, state: State, friction_memory: FrictionMemory, evaluation: PlantEvaluation
) -> PlantOutputs:
    """Outputs of a `plant` in a `state` [SI], with its `friction_memory` and `evaluation` [SI]."""
    flows, store = evaluation.flows, stored_energies(plant, state, friction_memory, evaluation)
    return PlantOutputs(
        evaluation.position,
        evaluation.velocity,
        flows.pressures,
        flows.temperatures,
        evaluation.strains,
        plant.counts * evaluation.fluid.muscles.force,
        evaluation.fluid.volume,
        state.chambers[..., 0],
        flows.supply,
        flows.exhaust,
        flows.drawn,
        flows.vented,
        flows.supply_pressure[..., 0] + 0.0 * evaluation.position,
        store,
        _status_bits(plant, state, evaluation, store),
        state.supply,
    )


def _status_bits(plant: Plant, state: State, evaluation: PlantEvaluation, energies: Numbers) -> Any:
    """Bits of `STATUS` of a plant; a unit's bit is set if any unit has it. `energies`: stored
    ones [J], checked for being finite.
    """
    q, P, eps = evaluation.position, evaluation.fluid.pressures, evaluation.strains
    xp = array_namespace(q, P)
    flags, stop = xp.any, plant.load.stop
    low, high = plant.muscles.strains
    is_outside = (eps < low) | (eps > high) | (plant.muscles.highest_pressure < P)
    bits = (
        flags(evaluation.fluid.is_folded, axis=-1),
        flags(plant.chamber.lowest_pressure + _NEARLY_EMPTY >= P, axis=-1),
        flags(is_outside, axis=-1),
        flags(evaluation.fluid.is_unsolved, axis=-1),
        plant.supply.empty(state.supply),
        False if stop is None else stop.is_touched(q),
        False,  # stiffness is known to `simulate`
        ~xp.isfinite(xp.sum(energies, axis=-1) + xp.sum(P, axis=-1)),
    )
    return sum(xp.where(flag, 1 << bit, 0) for bit, flag in enumerate(bits))
