"""Rates of change of a plant: flows through its valves, chambers, friction and its load."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, where
from ..core.types import Batch, Numbers
from ..muscle.hysteresis import Motion
from .chamber_pressure import ChamberEvaluation, conserved_rates, evaluate_chambers


if TYPE_CHECKING:
    from .plant import Plant


class State(NamedTuple):
    """State of a plant: `position` and `velocity` of the load [SI]; its valves' `spool` [-]; state
    of each unit's chamber on the last axis of `chambers` [SI]; the units' `pressures` [Pa], or a
    first guess of them; the `supply`'s state [SI].
    """

    position: Batch
    velocity: Batch
    spool: Numbers
    chambers: Numbers
    pressures: Numbers
    supply: Numbers


class Flows(NamedTuple):
    """Flows of each unit's fluid through valves: pressures, gauge [Pa], and temperatures [K] of
    supply and units; openings to `supply` and `exhaust` [-]; into each chamber `mass` [kg/s] and
    `enthalpy` [W]; `drawn` from the supply and `vented` to the room [kg/s]; `drawn_enthalpy` [W].
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


def evaluate_flows(plant: "Plant", state: State, pressures: Numbers, command: Numbers) -> Flows:
    """Flows of a `plant` in a `state` [SI] at units' `pressures` [Pa], under a `command` [-]."""
    chamber, supply, P = plant.chamber, plant.supply, pressures
    room, T_a = chamber.room_pressure, chamber.room_temperature
    T = chamber.temperature(state.chambers, P)
    P_s = supply.pressure_at(state.supply)[..., None]
    T_s = supply.temperature_at(state.supply)
    T_s = T_s[..., None] if np.ndim(T_s) else T_s
    to_supply, to_room = plant.spool.openings(command, state.spool)
    drawn = plant.valve.flow(P_s + room, P + room, T_s, T, to_supply)
    # an empty supply takes fluid, but gives none
    drawn = where(supply.empty(state.supply)[..., None] & (drawn > 0), 0.0, drawn)
    vented = plant.exhaust_valve.flow(P + room, room, T, T_a, to_room)
    c_p = 0.0 if plant.liquid else chamber.gas.c_p
    drawn_H = drawn * c_p * where(drawn > 0, T_s, T)
    vented_H = vented * c_p * where(vented > 0, T, T_a)
    openings, total = (to_supply + 0.0 * P, to_room + 0.0 * P), (drawn - vented, drawn_H - vented_H)
    return Flows(P_s, T_s, P, T, *openings, *total, drawn, drawn_H, vented)


class FrictionMemory(NamedTuple):
    """Memory of friction from the last step: its `spring_forces` [N], the load's
    `position` [SI] and the units' `pressures` [Pa].
    """

    spring_forces: Numbers
    position: Batch
    pressures: Numbers


def relaxed_friction(plant: "Plant", state: State) -> FrictionMemory:
    """Memory of relaxed friction of a `plant` in a `state` [SI]."""
    springs = 0 if plant.hysteresis is None else plant.hysteresis.count
    forces = array_namespace(state.pressures).zeros((plant.units, springs))
    return FrictionMemory(forces, state.position, state.pressures)


class PlantEvaluation(NamedTuple):
    """Evaluation of a plant at one time: `position` and `velocity` of the load [SI]; of each unit
    `strains` [-], `fluid`, `flows`, and rates of pressure, volume, the chamber's state and its
    conserved one, (T6) [SI]; on the load [N or N·m] the muscles' `pull`, the friction against it
    and its stop's damper; power of friction without memory [W]; the load's `acceleration` [SI].
    """

    position: Batch
    velocity: Batch
    strains: Numbers
    fluid: ChamberEvaluation
    flows: Flows
    pressure_rates: Numbers
    volume_rates: Numbers
    chamber_rates: Numbers
    conserved_rates: Numbers
    pull: Batch
    friction_force: Batch
    friction_power: Batch
    stop_damper: Batch
    acceleration: Batch


def evaluate_plant(
    plant: "Plant", time: Batch, state: State, command: Numbers, friction_memory: FrictionMemory
) -> PlantEvaluation:
    """Evaluation of a `plant` at a `time` [s] in a `state` [SI], whose pressures aren't solved for,
    under a `command` [-], with the last step's `friction_memory` [SI].
    """
    load, chamber = plant.load, plant.chamber
    q, v = load.motion_at(time, state.position, state.velocity)
    eps, eps_dot = plant.strains(q[..., None]), plant.gains * v[..., None]
    fluid = evaluate_chambers(plant, state.chambers, eps, state.pressures)
    P = fluid.pressures

    flows = evaluate_flows(plant, state, P, command)
    state_rates = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, 0.0)
    P_dot = fluid.pressure_rate(state_rates, eps_dot)
    V_dot = fluid.by_strain * eps_dot + fluid.by_pressure * P_dot
    filling = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, V_dot)
    conserved = conserved_rates(chamber, state.chambers, state_rates, P_dot, fluid.volume)

    arm = plant.counts * plant.lengths * plant.gains
    pull = array_namespace(fluid.muscles.force).sum(arm * fluid.muscles.force, axis=-1)
    friction, friction_power = _friction_force(plant, friction_memory, q, v, fluid)
    stop_force, stop_damper = load.stop.force(q, v) if load.stop else (0.0 * q, 0.0 * q)
    outside = load.force(q) - load.damping * v - stop_force
    a = (pull - friction + outside) / load.inertia
    rates, forces = (P_dot, V_dot, filling, conserved), (pull, friction, friction_power)
    return PlantEvaluation(q, v, eps, fluid, flows, *rates, *forces, stop_damper, a)


def time_derivative(
    plant: "Plant", state: State, evaluation: PlantEvaluation, command: Numbers
) -> State:
    """Time derivative of a `state` [SI] with its `evaluation` [SI], under a `command` [-]."""
    add, flows = array_namespace(evaluation.flows.drawn).sum, evaluation.flows
    drawn, enthalpy = (add(x, axis=-1) for x in (flows.drawn, flows.drawn_enthalpy))
    return State(
        position=evaluation.velocity,
        velocity=0.0 * evaluation.velocity if plant.load.prescribed else evaluation.acceleration,
        spool=plant.spool.rate(command, state.spool),
        chambers=evaluation.chamber_rates,
        pressures=evaluation.pressure_rates,
        supply=plant.supply.rates(state.supply, -drawn, -enthalpy),
    )


def muscle_motion(
    plant: "Plant",
    friction_memory: FrictionMemory,
    position: Batch,
    pressures: Numbers,
    speed: Numbers = 0.0,
    pressure_slope: Numbers = 0.0,
) -> Motion:
    """Motion of each muscle of a `plant` to a `position` [SI] and `pressures` [Pa] from those of
    the `friction_memory` [SI], with `speed` [m/s] and `pressure_slope` [m²] now.
    """
    displacement = plant.lengths * plant.gains * (position - friction_memory.position)[..., None]
    both, zero = (friction_memory.pressures, pressures), 0.0 * pressures
    return Motion(displacement, zero + speed, both, zero + pressure_slope)


def _friction_force(
    plant: "Plant", friction_memory: FrictionMemory, q: Batch, v: Batch, fluid: ChamberEvaluation
) -> tuple[Batch, Batch]:
    """Friction against the load [N or N·m], and the power lost by laws that have no memory [W]."""
    if plant.hysteresis is None and plant.damping is None:
        return 0.0 * q, 0.0 * q
    add, by_pressure = array_namespace(q).sum, fluid.muscles.force_by_pressure
    lever = plant.lengths * plant.gains
    speed = lever * v[..., None]
    force = power = 0.0 * speed
    if plant.hysteresis is not None:
        motion = muscle_motion(plant, friction_memory, q, fluid.pressures, speed, by_pressure)
        force = plant.hysteresis.advance(friction_memory.spring_forces, motion).force
        power = plant.hysteresis.lost_power(motion)
    if plant.damping is not None:
        damping = plant.damping.force(speed, fluid.pressures)
        force, power = force + damping, power + damping * speed
    return add(plant.counts * lever * force, axis=-1), add(plant.counts * power, axis=-1)


def update_friction(
    plant: "Plant", friction_memory: FrictionMemory, position: Batch, pressures: Numbers
) -> tuple[FrictionMemory, Batch]:
    """Advance `friction_memory` [SI] by a step to a `position` [SI] and `pressures` [Pa]: the new
    memory, and the energy that laws with a memory lost in the step [J].
    """
    assert plant.hysteresis is not None
    motion = muscle_motion(plant, friction_memory, position, pressures)
    step = plant.hysteresis.advance(friction_memory.spring_forces, motion)
    loss = array_namespace(step.loss).sum(plant.counts * step.loss, axis=-1)
    return FrictionMemory(step.spring_forces, position, pressures), loss
