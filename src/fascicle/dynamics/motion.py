"""How fast everything changes, at a moment."""

from typing import NamedTuple

from ..core.array_namespace import array_namespace
from ..core.types import Batch, Numbers
from .filling import Filled, filled
from .flows import Flows, flowing
from .holding import held_rates
from .hysteresis import Slid
from .plant import Plant
from .state import State


class Anchor(NamedTuple):
    """Where friction was looked at last: its forces `kept` [N], the load's `position` [SI] and the
    units' `pressures` [Pa].
    """

    kept: Numbers
    position: Batch
    pressures: Numbers


class Moment(NamedTuple):
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
    fluid: Filled
    flows: Flows
    pressure_rates: Numbers
    volume_rates: Numbers
    chamber_rates: Numbers
    held_rates: Numbers
    pull: Batch
    rubbing: Batch
    rubbing_power: Batch
    stop_damper: Batch
    acceleration: Batch


def moment(plant: Plant, time: Batch, state: State, command: Numbers, anchor: Anchor) -> Moment:
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
    fluid = filled(plant, state.chambers, eps, state.pressures)
    P, at = fluid.pressures, fluid.at

    flows = flowing(plant, state, P, command)
    still = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, 0.0)
    P_dot = fluid.pressure_rate(still, eps_dot)
    V_dot = fluid.by_strain * eps_dot + fluid.by_pressure * P_dot
    filling = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, V_dot)

    held = held_rates(chamber, state.chambers, still, P_dot, fluid.volume)

    arm = plant.counts * plant.lengths * plant.gains
    pull = array_namespace(at.force).sum(arm * at.force, axis=-1)
    rubbing, lost = _rubbing(plant, anchor, q, v, fluid)
    stopped, damped = load.stop.force(q, v) if load.stop else (0.0 * q, 0.0 * q)
    outside = load.force(q) - load.damper * v - stopped
    a = (pull - rubbing + outside) / load.inertia
    return Moment(
        q, v, eps, eps_dot, fluid, flows, P_dot, V_dot, filling, held, pull, rubbing,
        lost, damped, a,
    )  # fmt: skip


def change(plant: Plant, state: State, now: Moment, command: Numbers) -> State:
    """How fast each number of a `state` [SI] of a `plant` [-] changes [SI], so as it is `now` [SI]
    and under a `command` [-].
    """
    add = array_namespace(now.flows.drawn).sum
    drawn, enthalpy = add(now.flows.drawn, axis=-1), add(now.flows.drawn_enthalpy, axis=-1)
    return State(
        position=now.velocity,
        velocity=0.0 * now.velocity if plant.load.moved else now.acceleration,
        spool=plant.spool.rate(command, state.spool),
        chambers=now.chamber_rates,
        pressures=now.pressure_rates,
        supply=plant.supply.rates(state.supply, -drawn, -enthalpy),
    )


def slid(plant: Plant, anchor: Anchor, position: Batch, pressures: Numbers) -> Slid:
    """Friction of each muscle of a `plant` [-] that remembers, at a `position` [SI] and `pressures`
    [Pa], reached from its `anchor` [SI] without turning.
    """
    none = 0.0 * pressures
    return _slid(plant, anchor, position, none, pressures, none)


def _slid(
    plant: Plant, anchor: Anchor, q: Batch, speed: Numbers, P: Numbers, by_pressure: Numbers
) -> Slid:
    assert plant.hysteresis is not None
    way = plant.lengths * plant.gains * (q - anchor.position)[..., None]
    return plant.hysteresis.slid(anchor.kept, way, speed, (anchor.pressures, P), by_pressure)


def _rubbing(
    plant: Plant, anchor: Anchor, q: Batch, v: Batch, fluid: Filled
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
    force = _slid(plant, anchor, q, speed, fluid.pressures, by_pressure).force
    lost = plant.hysteresis.lost_power(speed, fluid.pressures, by_pressure)
    return add(plant.counts * per * force, axis=-1), add(plant.counts * lost, axis=-1)


def rubbed(
    plant: Plant, anchor: Anchor, position: Batch, pressures: Numbers
) -> tuple[Anchor, Batch]:
    """Friction after a step to a `position` [SI] at `pressures` [Pa], from where it was looked at
    last, and the energy that it lost on the way [J].
    """
    now = slid(plant, anchor, position, pressures)
    lost = array_namespace(now.lost).sum(plant.counts * now.lost, axis=-1)
    return Anchor(now.kept, position, pressures), lost
