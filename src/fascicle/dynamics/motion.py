r"""How fast everything changes, and where each watt goes.

A unit's chamber of state $s$ is joined to its muscles by their volume, which depends on strain and
pressure. With $g(s, P, V) = 0$ and $\dot s$ affine in $\dot V$,

$$\dot P = - \frac{g_s \cdot \dot s|_{\dot V = 0}
  + (g_s \cdot \dot s_{\dot V} + g_V)\, V_\varepsilon \dot\varepsilon}
  {g_P + (g_s \cdot \dot s_{\dot V} + g_V)\, V_P}, \qquad
  \dot V = V_\varepsilon \dot\varepsilon + V_P \dot P. \tag{T4}$$

The pressure itself is the root of $g$, which Newton's method takes from where the rates led.

Energies are powers of their own, integrated beside the motion; none is what others leave. Of a gas
they are exergies: a kilogram that is throttled from $p_1$ to $p_2$ loses $R T_a \ln(p_1/p_2)$; one
that comes at $T_{in}$ into a chamber at $T$ loses
$c_p T_a (\ln(T/T_{in}) + T_{in}/T - 1)$; heat $\dot Q$ that leaves at $T$ takes
$(1 - T_a/T)\,\dot Q$ along.

**Source:** first and second law for open systems: Bejan (2016).
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import library, log, maximum, where
from ..core.roots import guarded
from ..core.types import Batch, BoolBatch, Numbers
from ..fluid.chamber import row
from ..muscle.surface import Surface
from .muscles import volumes
from .plant import Plant
from .state import State


_NEWTON = 2  # from where the rates led: two steps leave 1e-12 of a pressure


class Anchor(NamedTuple):
    """Where friction was looked at last: its forces `kept` [N], the load's `position` [SI] and the
    units' `pressures` [Pa].
    """

    kept: Numbers
    position: Batch
    pressures: Numbers


class Seen(NamedTuple):
    """What a plant shows at a moment.

    `position`, `velocity` [SI]; of each unit: `pressures` [Pa], `temperatures` [K], `strains` [-],
    `forces` of its muscles together [N], `volumes` [m³], `masses` [kg], openings to `supply` and
    `exhaust` [-], flows `drawn` and `vented` [kg/s]; `supply_pressure` [Pa]; energies in `store`:
    of fluid, muscles, motion, load, stop and friction [J]; `status`: bits of `STATUS` [-].
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


STORES = ("fluid", "muscles", "motion", "load", "stop", "friction")

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


class Filled(NamedTuple):
    """Chambers at their pressures: those [Pa], what muscles do there, the volume they fill [m³]
    with its slopes by strain [m³] and pressure [m³/Pa], whether it is stiff enough to be found, and
    whether it was.
    """

    pressures: Numbers
    at: Surface
    volume: Numbers
    by_strain: Numbers
    by_pressure: Numbers
    folded: BoolBatch
    unsettled: BoolBatch


def filled(plant: Plant, chambers: Numbers, strains: Numbers, near: Numbers, steps: int) -> Filled:
    """The pressures [Pa] of `chambers` [SI] at `strains` [-], from `near` [Pa], in so many `steps`
    [-] of Newton's method.
    """
    n, chamber, lowest = plant.counts, plant.chamber, plant.chamber.lowest_pressure

    def looked(P: Numbers) -> tuple[Surface, Numbers, Numbers, Numbers, Numbers, BoolBatch]:
        at = plant.muscles.at(P, strains)
        V, by_strain, by_pressure = volumes(plant.muscles, at, strains, plant.lengths)
        g = chamber.balance(chambers, P, n * V)
        slope = g.by_pressure + g.by_volume * n * by_pressure
        folded = slope <= 0
        step = -g.value / guarded(folded == 0, slope, g.by_pressure)
        return at, n * V, n * by_strain, n * by_pressure, step, folded

    P, last = near, 0.0 * near
    for _ in range(steps):
        last = looked(P)[4]
        # half of the way to no fluid at all at most
        P = maximum(P + last, (P + lowest) / 2)
    at, V, by_strain, by_pressure, step, folded = looked(P)
    far = library(step).absolute(step) > 1.0 + 1e-4 * library(P).absolute(P)
    return Filled(P, at, V, by_strain, by_pressure, folded, far)


def rates(
    plant: Plant, time: Batch, state: State, command: Numbers, anchor: Anchor, steps: int = _NEWTON
) -> tuple[State, Seen]:
    """How a plant changes, and what it shows.

    **Arguments:**

    - `plant`: it [-].
    - `time`: now [s].
    - `state`: now [SI].
    - `command`: to its valves [-].
    - `anchor`: of its friction [N], [SI].
    - `steps`: of Newton's method [-].

    **Returns:** rates [SI] of everything in `state`, and a `Seen` [SI].
    """
    load, chamber, n, L = plant.load, plant.chamber, plant.counts, plant.lengths
    at_work = library(state.position, state.pressures)
    q, v = load.motion(time) if load.moved else (state.position, state.velocity)
    eps, eps_dot = plant.strains(q[..., None]), plant.gains * v[..., None]
    fluid = filled(plant, state.chambers, eps, state.pressures, steps)
    P, at = fluid.pressures, fluid.at

    # fluid
    flows = _flows(plant, state, P, command)
    g = chamber.balance(state.chambers, P, fluid.volume)
    still = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, 0.0)
    along = at_work.sum(g.by_state * chamber.per_volume_rate(state.chambers, P), axis=-1)
    moved = along + g.by_volume
    slope = g.by_pressure + moved * fluid.by_pressure
    push = at_work.sum(g.by_state * still, axis=-1) + moved * fluid.by_strain * eps_dot
    P_dot = -push / guarded(slope > 0, slope, g.by_pressure)
    V_dot = fluid.by_strain * eps_dot + fluid.by_pressure * P_dot
    filling = chamber.rates(state.chambers, P, flows.mass, flows.enthalpy, V_dot)
    heat = chamber.heat(state.chambers, P, flows.mass, flows.enthalpy, V_dot)

    # motion
    arm = n * L * plant.gains
    pull = at_work.sum(arm * at.force, axis=-1)
    rubbed, lost = _friction(plant, anchor, q, v, P, at)
    stopped, damped = load.stop.force(q, v) if load.stop else (0.0 * q, 0.0 * q)
    outside = load.force(q) - load.damper * v - stopped
    a = (pull - rubbed + outside) / load.inertia

    V_star_dot = n * (L * at.force_by_pressure * eps_dot + at.volume_by_pressure * P_dot)
    # of all units in one sum, which takes a fraction of the time
    powers = at_work.sum(
        row(
            *_fluid_powers(plant, state, P, flows, heat),
            P * V_dot,
            P * (V_dot - V_star_dot),
            flows.mass,
            flows.enthalpy,
            heat,
            (P + chamber.room_pressure) * V_dot,
            -flows.drawn,
            -flows.drawn_enthalpy,
        ),
        axis=-2,
    )
    of_load = row(
        pull * v,
        load.damper * v**2,
        damped * v,
        lost,
        -(pull - rubbed) * v if load.moved else 0.0 * v,
    )
    account = at_work.concatenate([powers[..., :11], of_load], axis=-1)
    moving = State(
        position=v,
        velocity=0.0 * v if load.moved else a,
        spool=plant.spool.rate(command, state.spool),
        chambers=filling,
        pressures=P_dot,
        supply=plant.supply.rates(state.supply, powers[..., 11], powers[..., 12]),
        account=account,
    )
    store = _stores(plant, state, anchor, q, v, fluid)
    seen = Seen(
        q, v, P, chamber.temperature(state.chambers, P), eps, n * at.force, fluid.volume,
        state.chambers[..., 0], *flows.openings, flows.drawn, flows.vented,
        plant.supply.pressure_at(state.supply), store, _status(plant, state, q, eps, fluid, store),
    )  # fmt: skip
    return moving, seen


class _Flows(NamedTuple):
    """Openings; into each chamber: mass [kg/s] and enthalpy [W]; from the supply, and its enthalpy;
    to the room.
    """

    openings: tuple[Numbers, Numbers]
    mass: Numbers
    enthalpy: Numbers
    drawn: Numbers
    drawn_enthalpy: Numbers
    vented: Numbers


def _flows(plant: Plant, state: State, P: Numbers, command: Numbers) -> _Flows:
    chamber, supply = plant.chamber, plant.supply
    room, T_a = chamber.room_pressure, chamber.room_temperature
    T = chamber.temperature(state.chambers, P)
    p_s = supply.pressure_at(state.supply)[..., None] + room
    T_s = supply.temperature_at(state.supply)
    T_s = T_s[..., None] if np.ndim(T_s) else T_s
    to_supply, to_room = plant.spool.openings(command, state.spool)
    drawn = plant.valve.flow(p_s, P + room, T_s, T, to_supply)
    # what is empty takes, but gives no more
    drawn = where(supply.empty(state.supply)[..., None] & (drawn > 0), 0.0, drawn)
    vented = plant.exhaust_valve.flow(P + room, room, T, T_a, to_room)
    c_p = 0.0 if plant.liquid else chamber.gas.c_p
    drawn_H = drawn * c_p * where(drawn > 0, T_s, T)
    vented_H = vented * c_p * where(vented > 0, T, T_a)
    opened = (to_supply + 0.0 * P, to_room + 0.0 * P)
    return _Flows(opened, drawn - vented, drawn_H - vented_H, drawn, drawn_H, vented)


def _fluid_powers(
    plant: Plant, state: State, P: Numbers, flows: _Flows, heat: Numbers
) -> tuple[Numbers, ...]:
    """Powers of each unit's fluid [W], of a gas's exergy or a liquid's energy: supplied, lost in
    valves, at the exhaust, in mixing and through the wall.
    """
    chamber = plant.chamber
    P_s = plant.supply.pressure_at(state.supply)[..., None]
    if plant.liquid:
        h = chamber.liquid.flow_energy
        valve = flows.drawn * (h(P_s) - h(P)) + flows.vented * h(P)
        none = 0.0 * P
        return flows.drawn * h(P_s), valve, none, none, none
    gas, room, T_a = chamber.gas, chamber.room_pressure, chamber.room_temperature
    T, p = chamber.temperature(state.chambers, P), P + room
    T_s = plant.supply.temperature_at(state.supply)
    T_s = T_s[..., None] if np.ndim(T_s) else T_s
    unit = gas.specific_gas_constant * T_a
    some = p > 0
    p = guarded(some, p, room)
    valve = unit * (flows.drawn * log((P_s + room) / p) + flows.vented * log(p / room))

    def mixed(inflow: Numbers, T_in: Numbers) -> Numbers:
        warm = gas.c_p * T_a * (log(T / T_in) + T_in / T - 1)
        return maximum(inflow, 0.0) * warm

    leaving = gas.c_p * (T - T_a - T_a * log(T / T_a))
    drawn_T = where(flows.drawn > 0, T_s, T)
    return (
        flows.drawn * gas.flow_exergy(P_s + room, drawn_T, room, T_a),
        valve,
        maximum(flows.vented, 0.0) * leaving,
        mixed(flows.drawn, T_s) + mixed(-flows.vented, T_a),
        (1 - T_a / T) * heat,
    )


def _friction(
    plant: Plant, anchor: Anchor, q: Batch, v: Batch, P: Numbers, at: Surface
) -> tuple[Batch, Batch]:
    """Friction against the load's coordinate [N or N·m], and heat that its way doesn't tell [W]."""
    if plant.hysteresis is None:
        return 0.0 * q, 0.0 * q
    add, per = library(q).sum, plant.lengths * plant.gains
    way, speed = per * (q - anchor.position)[..., None], per * v[..., None]
    slid = plant.hysteresis.slid(
        anchor.kept, way, speed, (anchor.pressures, P), at.force_by_pressure
    )
    lost = plant.hysteresis.lost_power(speed, P, at.force_by_pressure)
    return add(plant.counts * per * slid.force, axis=-1), add(plant.counts * lost, axis=-1)


def rubbed(
    plant: Plant, anchor: Anchor, position: Batch, pressures: Numbers
) -> tuple[Anchor, Batch]:
    """Friction after a step to a `position` [SI] at `pressures` [Pa], from where it was looked at
    last, and the energy that it lost on the way [J].
    """
    assert plant.hysteresis is not None
    per = plant.lengths * plant.gains
    way, none = per * (position - anchor.position)[..., None], 0.0 * pressures
    slid = plant.hysteresis.slid(anchor.kept, way, none, (anchor.pressures, pressures), none)
    lost = library(slid.lost).sum(plant.counts * slid.lost, axis=-1)
    return Anchor(slid.kept, position, pressures), lost


def _stores(
    plant: Plant, state: State, anchor: Anchor, q: Batch, v: Batch, fluid: Filled
) -> Numbers:
    """Energies [J] named in `STORES`."""
    at_work = library(q, fluid.pressures)
    add, load, P, at = at_work.sum, plant.load, fluid.pressures, fluid.at
    kept = 0.0 * q
    if plant.hysteresis is not None:
        per = plant.lengths * plant.gains
        way = per * (q - anchor.position)[..., None]
        now = plant.hysteresis.slid(anchor.kept, way, 0.0 * P, (anchor.pressures, P), 0.0 * P).kept
        kept = add(plant.counts * plant.hysteresis.stored(now), axis=-1)
    parts = (
        add(plant.chamber.stored(state.chambers, P), axis=-1),
        add(plant.counts * (P * at.volume - at.coenergy), axis=-1),
        0.0 * v if load.moved else load.inertia * v**2 / 2,
        load.potential(q),
        load.stop.energy(q) if load.stop else 0.0 * q,
        kept,
    )
    return at_work.stack(at_work.broadcast_arrays(*parts), axis=-1)


def _status(
    plant: Plant, state: State, q: Batch, eps: Numbers, fluid: Filled, store: Numbers
) -> Any:
    """Bits of `STATUS`."""
    at_work = library(q, fluid.pressures)
    some = at_work.any
    low, high = plant.muscles.strains
    P, lowest = fluid.pressures, plant.chamber.lowest_pressure
    off = (eps < low) | (eps > high) | (plant.muscles.highest_pressure < P)
    true = (
        some(fluid.folded, axis=-1),
        # within a thousandth of an atmosphere of it
        some(lowest + 100.0 >= P, axis=-1),
        some(off, axis=-1),
        some(fluid.unsettled, axis=-1),
        plant.supply.empty(state.supply),
        load_stopped(plant, q),
        False,  # `simulate` tells whether it is too stiff
        ~at_work.isfinite(at_work.sum(store, axis=-1) + at_work.sum(P, axis=-1)),
    )
    return sum(at_work.where(here, 1 << place, 0) for place, here in enumerate(true))


def load_stopped(plant: Plant, position: Batch) -> BoolBatch:
    """Whether the load is at its stop [-] at `position` [SI]."""
    stop = plant.load.stop
    return position < -np.inf if stop is None else stop.touched(position)
