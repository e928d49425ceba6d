"""Outputs of a plant at a moment, with a status that says if they can be trusted."""

from typing import Any, NamedTuple

from ..core.array_namespace import array_namespace
from ..core.types import Batch, Numbers
from .energy_ledger import stored_energies
from .motion import FrictionMemory, PlantEvaluation
from .plant import Plant
from .state import State


# why a run can't be trusted from then on, or what happened in it
STATUS = (
    "folded",  # a muscle's volume falls with pressure more than hose and fluid give
    "cavitates",  # a fluid sucked to where it can't be
    "off_table",  # a strain or pressure that the muscles aren't known at
    "unsettled",  # a pressure that wasn't found
    "supply_empty",
    "stop",  # the load is at its stop
    "stiff",  # it would have needed more substeps
    "broken",  # numbers that are none
)
_NEARLY_ATMOSPHERE = 100.0  # Pa: within a thousandth of an atmosphere of no fluid


class PlantOutputs(NamedTuple):
    """Outputs of a plant at a moment.

    `position`, `velocity` [SI]; of each unit: `pressures` [Pa], `temperatures` [K], `strains` [-],
    `forces` of its muscles together [N], `volumes` [m³], `masses` [kg], openings to `supply` and
    `exhaust` [-], flows `drawn` and `vented` [kg/s]; `supply_pressure` [Pa]; energies in `store`:
    of fluid, muscles, motion, load, stop and friction [J]; `status`: bits of `STATUS` [-];
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
    plant: Plant, state: State, anchor: FrictionMemory, evaluation: PlantEvaluation
) -> PlantOutputs:
    """Outputs of a `plant` in a `state` [SI], with friction's `anchor` and `evaluation` [SI]."""
    flows, store = evaluation.flows, stored_energies(plant, state, anchor, evaluation)
    return PlantOutputs(
        evaluation.position,
        evaluation.velocity,
        flows.pressures,
        flows.temperatures,
        evaluation.strains,
        plant.counts * evaluation.fluid.at.force,
        evaluation.fluid.volume,
        state.chambers[..., 0],
        flows.supply,
        flows.exhaust,
        flows.drawn,
        flows.vented,
        flows.supply_pressure[..., 0] + 0.0 * evaluation.position,
        store,
        _status(plant, state, evaluation, store),
        state.supply,
    )


def _status(plant: Plant, state: State, evaluation: PlantEvaluation, store: Numbers) -> Any:
    """Bits of `STATUS`."""
    q, P, eps = evaluation.position, evaluation.fluid.pressures, evaluation.strains
    xp = array_namespace(q, P)
    flags, stop = xp.any, plant.load.stop
    low, high = plant.muscles.strains
    off = (eps < low) | (eps > high) | (plant.muscles.highest_pressure < P)
    true = (
        flags(evaluation.fluid.is_folded, axis=-1),
        flags(plant.chamber.lowest_pressure + _NEARLY_ATMOSPHERE >= P, axis=-1),
        flags(off, axis=-1),
        flags(evaluation.fluid.is_unsolved, axis=-1),
        plant.supply.empty(state.supply),
        False if stop is None else stop.touched(q),
        False,  # `simulate` tells whether it is too stiff
        ~xp.isfinite(xp.sum(store, axis=-1) + xp.sum(P, axis=-1)),
    )
    return sum(xp.where(flag, 1 << bit, 0) for bit, flag in enumerate(true))
