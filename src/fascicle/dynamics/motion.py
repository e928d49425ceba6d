"""How fast everything changes, at a moment."""

from typing import NamedTuple

from ..core.array_namespace import array_namespace
from ..core.types import Batch, Numbers
from .chamber_pressure import ChamberEvaluation, evaluate_chambers
from .conservative_update import conserved_rates
from .flows import Flows, evaluate_flows
from .hysteresis import FrictionStep
from .plant import Plant
from .state import State


class FrictionMemory(NamedTuple):
    """Memory of friction from the last step: its `spring_forces` [N], the load's
    `position` [SI] and the units' `pressures` [Pa].
    """

    spring_forces: Numbers
    position: Batch
    pressures: Numbers


class PlantEvaluation(NamedTuple):
    """Everything at a moment.

    `position` and `velocity` of the load [SI]; of each unit `strains` [-], `strain_rates` [1/s],
    `fluid`, `flows`, rates of pressure [Pa/s] and volume [m³/s], of the chamber's state and of what
    it holds, (T6) [SI];
    on the load [N or N·m] the muscles' `pull`, `rubbing` against it and the damper of its stop,
    and the power that rubbing loses beyond its way [W]; the load's `acceleration` [SI].
    """

    position: Batch
    velocity: Batch
    strains: Numbers
    strain_rates: Numbers
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
    plant: Plant, time: Batch, state: State, command: Numbers, anchor: FrictionMemory
) -> PlantEvaluation:
    """A plant at a moment.

    **Arguments:**

    - `plant`: it [-].
    - `time`: now [s].
    - `state`: now [SI], its pressures those that go with its chambers.
    - `command`: to its valves [-].
    - `anchor`: of its friction [N], [SI].

    **Returns:** a `Moment` [SI].
    """
    load, chamber = plant.load, plant.chamber
    q, v = load.placed(time, state.position, state.velocity)
    eps, eps_dot = plant.strains(q[..., None]), plant.gains * v[..., None]
    fluid = evaluate_chambers(plant, state.chambers, eps, state.pressures)
    P, at = fluid.pressures, fluid.at

    flows = evaluate_flows(plant, state, P, command)
    fixed_volume_rate = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, 0.0)
    P_dot = fluid.pressure_rate(fixed_volume_rate, eps_dot)
    V_dot = fluid.by_strain * eps_dot + fluid.by_pressure * P_dot
    filling = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, V_dot)

    conserved = conserved_rates(chamber, state.chambers, fixed_volume_rate, P_dot, fluid.volume)

    arm = plant.counts * plant.lengths * plant.gains
    pull = array_namespace(at.force).sum(arm * at.force, axis=-1)
    rubbing, lost = _friction_force(plant, anchor, q, v, fluid)
    stopped, damped = load.stop.force(q, v) if load.stop else (0.0 * q, 0.0 * q)
    outside = load.force(q) - load.damper * v - stopped
    a = (pull - rubbing + outside) / load.inertia
    return PlantEvaluation(
        q, v, eps, eps_dot, fluid, flows, P_dot, V_dot, filling, conserved, pull, rubbing,
        lost, damped, a,
    )  # fmt: skip


def time_derivative(
    plant: Plant, state: State, evaluation: PlantEvaluation, command: Numbers
) -> State:
    """Time derivative of a `state` [SI] of a `plant` [SI], with its `evaluation` [SI], under a
    `command` [-].
    """
    add = array_namespace(evaluation.flows.drawn).sum
    drawn, enthalpy = (
        add(evaluation.flows.drawn, axis=-1),
        add(evaluation.flows.drawn_enthalpy, axis=-1),
    )
    return State(
        position=evaluation.velocity,
        velocity=0.0 * evaluation.velocity if plant.load.moved else evaluation.acceleration,
        spool=plant.spool.rate(command, state.spool),
        chambers=evaluation.chamber_rates,
        pressures=evaluation.pressure_rates,
        supply=plant.supply.rates(state.supply, -drawn, -enthalpy),
    )


def friction_step(
    plant: Plant, anchor: FrictionMemory, position: Batch, pressures: Numbers
) -> FrictionStep:
    """Friction of each muscle of a `plant` [-] that remembers, at a `position` [SI] and `pressures`
    [Pa], reached from its `anchor` [SI] without turning.
    """
    none = 0.0 * pressures
    return _advance_friction(plant, anchor, position, none, pressures, none)


def _advance_friction(
    plant: Plant, anchor: FrictionMemory, q: Batch, speed: Numbers, P: Numbers, by_pressure: Numbers
) -> FrictionStep:
    assert plant.hysteresis is not None
    displacement = plant.lengths * plant.gains * (q - anchor.position)[..., None]
    return plant.hysteresis.slid(
        anchor.spring_forces, displacement, speed, (anchor.pressures, P), by_pressure
    )


def _friction_force(
    plant: Plant, anchor: FrictionMemory, q: Batch, v: Batch, fluid: ChamberEvaluation
) -> tuple[Batch, Batch]:
    """Friction against the load's coordinate [N or N·m], and heat that its way doesn't tell [W]."""
    if plant.hysteresis is None:
        return 0.0 * q, 0.0 * q
    add, per, by_pressure = (
        array_namespace(q).sum,
        plant.lengths * plant.gains,
        fluid.at.force_by_pressure,
    )
    speed = per * v[..., None]
    force = _advance_friction(plant, anchor, q, speed, fluid.pressures, by_pressure).force
    lost = plant.hysteresis.lost_power(speed, fluid.pressures, by_pressure)
    return add(plant.counts * per * force, axis=-1), add(plant.counts * lost, axis=-1)


def update_friction(
    plant: Plant, anchor: FrictionMemory, position: Batch, pressures: Numbers
) -> tuple[FrictionMemory, Batch]:
    """Friction after a step to a `position` [SI] at `pressures` [Pa], from where it was looked at
    last, and the energy that it lost on the way [J].
    """
    step = friction_step(plant, anchor, position, pressures)
    lost = array_namespace(step.lost).sum(plant.counts * step.lost, axis=-1)
    return FrictionMemory(step.spring_forces, position, pressures), lost
