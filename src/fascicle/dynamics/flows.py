"""Flows between the supply, the chambers and the room, through open valves."""

from typing import NamedTuple

import numpy as np

from ..core.array_namespace import where
from ..core.types import Batch, Numbers
from .plant import Plant
from .state import State


class Flows(NamedTuple):
    """Flows of each unit's fluid, and what they flow between.

    `supply_pressure`, `pressures`: gauge [Pa]; `supply_temperature`, `temperatures` [K];
    openings to `supply` and `exhaust` [-]; into each chamber `mass` [kg/s] and `enthalpy` [W];
    `drawn` from the supply [kg/s] with its `drawn_enthalpy` [W]; `vented` to the room [kg/s].
    """

    supply_pressure: Numbers
    supply_temperature: Batch
    pressures: Numbers
    temperatures: Numbers
    supply: Numbers
    exhaust: Numbers
    mass: Numbers
    enthalpy: Numbers
    drawn: Numbers
    drawn_enthalpy: Numbers
    vented: Numbers


def evaluate_flows(plant: Plant, state: State, pressures: Numbers, command: Numbers) -> Flows:
    """The flows of a `plant` [-] in a `state` [SI], its units at `pressures` [Pa], under a
    `command` [-].
    """
    chamber, supply, P = plant.chamber, plant.supply, pressures
    room, T_a = chamber.room_pressure, chamber.room_temperature
    T = chamber.temperature(state.chambers, P)
    P_s = supply.pressure_at(state.supply)[..., None]
    T_s = supply.temperature_at(state.supply)
    T_s = T_s[..., None] if np.ndim(T_s) else T_s
    to_supply, to_room = plant.spool.openings(command, state.spool)
    drawn = plant.valve.flow(P_s + room, P + room, T_s, T, to_supply)
    # what is empty takes, but gives no more
    drawn = where(supply.empty(state.supply)[..., None] & (drawn > 0), 0.0, drawn)
    vented = plant.exhaust_valve.flow(P + room, room, T, T_a, to_room)
    c_p = 0.0 if plant.liquid else chamber.gas.c_p
    drawn_H = drawn * c_p * where(drawn > 0, T_s, T)
    vented_H = vented * c_p * where(vented > 0, T, T_a)
    return Flows(
        P_s, T_s, P, T, to_supply + 0.0 * P, to_room + 0.0 * P, drawn - vented,
        drawn_H - vented_H, drawn, drawn_H, vented,
    )  # fmt: skip
