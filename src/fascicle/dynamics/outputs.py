r"""Outputs of a plant at a time: what a sensor shows, its energies, and a status.

Each entry of the ledger is the integral of its own power; none is the remainder of others. Of a gas
they are exergies: a kilogram that is throttled from $p_1$ to $p_2$ loses $R T_a \ln(p_1/p_2)$; one
that comes at $T_{in}$ into a chamber at $T$ loses
$c_p T_a (\ln(T/T_{in}) + T_{in}/T - 1)$; heat $\dot Q$ that leaves at $T$ takes
$(1 - T_a/T)\,\dot Q$ along. The fluid's work is taken by parts, $P V - \int V\,\mathrm{d}P$: the
slope of a muscle's volume jumps where it collapses, the volume doesn't.

**Source:** first and second law for open systems: Bejan (2016).
"""

from typing import NamedTuple

from ..core.array_namespace import array_namespace, log, maximum, where
from ..core.roots import guarded
from ..core.types import Batch, Numbers, Whole
from ..fluid.chamber import stack_last
from .motion import Flows, FrictionMemory, PlantEvaluation, State, muscle_motion
from .plant import Plant


LEDGER = (  # of all units, in the order of `ledger_rates`; keys of files and JSON
    "supplied",  # exergy of the gas that was drawn, energy of the liquid [J]
    "valve",  # lost in throttling, on the way in and out [J]
    "exhaust",  # left in a gas that leaves by its temperature [J]
    "mixing",  # of gases of unlike temperature in a chamber [J]
    "wall",  # of heat that leaves at a temperature above or below the room's [J]
    "fluid_work",  # of the fluid on the muscles, ∫ P dV = P V − ∫ V dP [J]
    "mismatch",  # made of it by a volume that isn't the conjugate one [J]
    "mass",  # of fluid that flowed into the chambers [kg]
    "enthalpy",  # that this fluid brought, less that of outflow [J]
    "heat",  # through the walls [J]
    "displaced",  # ∫ p dV, absolute [J]
    "pull",  # ∫ F dx of the muscles on the load [J]
    "damper",  # lost in the load's damper [J]
    "stop",  # lost in its stop's damper [J]
    "friction",  # lost in the muscles [J]
    "motor",  # work of a prescribed motion [J]
)
# places that store energy, keys of files and JSON
STORES = ("fluid", "muscles", "motion", "load", "stop", "friction")
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
    """Outputs of a plant at a time: `position`, `velocity` [SI]; of each unit: `pressures` [Pa],
    `temperatures` [K], `strains` [-], `forces` of all its muscles [N], `volumes` [m³], `masses`
    [kg], openings to `supply` and `exhaust` [-], flows `drawn` and `vented` [kg/s];
    `supply_pressure` [Pa]; energies in `store`, those of `STORES` [J]; `status`: bits of `STATUS`;
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
    status: Whole
    reserve: Numbers


def observe(
    plant: Plant, state: State, friction_memory: FrictionMemory, evaluation: PlantEvaluation
) -> PlantOutputs:
    """Outputs of a `plant` in a `state` [SI], with its `friction_memory` and `evaluation` [SI]."""
    at, flows, fluid = evaluation, evaluation.flows, evaluation.fluid
    store = _stored_energies(plant, state, friction_memory, at)
    muscles = at.strains, plant.counts * fluid.muscles.force, fluid.volume, state.chambers[..., 0]
    valves = flows.supply, flows.exhaust, flows.drawn, flows.vented
    supply = flows.supply_pressure[..., 0] + 0.0 * at.position
    places = at.position, at.velocity, flows.pressures, flows.temperatures
    status = _status_bits(plant, state, at, store)
    return PlantOutputs(*places, *muscles, *valves, supply, store, status, state.supply)


def _status_bits(
    plant: Plant, state: State, evaluation: PlantEvaluation, energies: Numbers
) -> Whole:
    """Bits of `STATUS`; a unit's bit is set if any unit has it. `energies`: stored ones [J]."""
    q, P, eps = evaluation.position, evaluation.fluid.pressures, evaluation.strains
    xp, stop = array_namespace(q, P), plant.load.stop
    low, high = plant.muscles.strains
    bits = (
        xp.any(evaluation.fluid.is_folded, axis=-1),
        xp.any(plant.chamber.lowest_pressure + _NEARLY_EMPTY >= P, axis=-1),
        xp.any((eps < low) | (eps > high) | (plant.muscles.highest_pressure < P), axis=-1),
        xp.any(evaluation.fluid.is_unsolved, axis=-1),
        plant.supply.empty(state.supply),
        False if stop is None else (q > stop.high) | (q < stop.low),
        False,  # stiffness is known to `simulate`
        ~xp.isfinite(xp.sum(energies, axis=-1) + xp.sum(P, axis=-1)),
    )
    return sum(xp.where(flag, 1 << bit, 0) for bit, flag in enumerate(bits))


def ledger_rates(plant: Plant, state: State, evaluation: PlantEvaluation) -> Numbers:
    """Rates of all entries of the `LEDGER` [W or kg/s], without their `pressure_volume_term`, of a
    `plant` in a `state` [SI] with its `evaluation` [SI].
    """
    P, flows, V = evaluation.fluid.pressures, evaluation.flows, evaluation.fluid.volume
    v, P_dot, brought = evaluation.velocity, evaluation.pressure_rates, (flows.mass, flows.enthalpy)
    heat = plant.chamber.heat_flow(state.chambers, P, *brought, evaluation.volume_rates)
    mismatch = -(V - plant.counts * evaluation.fluid.muscles.volume) * P_dot
    work = -V * P_dot
    powers = *_fluid_powers(plant, flows, heat), work, mismatch, *brought, heat, work
    load, pull = plant.load, evaluation.pull
    load_powers = stack_last(
        pull * v,
        load.damping * v**2,
        evaluation.stop_damper * v,
        evaluation.friction_power,
        -(pull - evaluation.friction_force) * v if load.prescribed else 0.0 * v,
    )
    xp = array_namespace(v, P)
    # one sum over all units takes a fraction of the time
    return xp.concatenate([xp.sum(stack_last(*powers), axis=-2), load_powers], axis=-1)


def pressure_volume_term(plant: Plant, evaluation: PlantEvaluation) -> Numbers:
    """Boundary term $P V$ of works that are integrated by parts [J], one for each entry of the
    `LEDGER` on the last axis, of all units; zero for the other entries.
    """
    P, V = evaluation.fluid.pressures, evaluation.fluid.volume
    terms = {
        "fluid_work": P * V,
        "mismatch": P * (V - plant.counts * evaluation.fluid.muscles.volume),
        "displaced": (P + plant.chamber.room_pressure) * V,
    }
    rows = stack_last(*(terms.get(name, 0.0 * P) for name in LEDGER))
    return array_namespace(P, V).sum(rows, axis=-2)


def _fluid_powers(plant: Plant, flows: Flows, heat: Numbers) -> tuple[Numbers, ...]:
    """Powers of each unit's fluid [W], of a gas's exergy or a liquid's energy: supplied, lost in
    valves, at the exhaust, in mixing and through the wall.
    """
    chamber, P, P_s = plant.chamber, flows.pressures, flows.supply_pressure
    if plant.liquid:
        h, none = chamber.liquid.flow_energy, 0.0 * P
        valve = flows.drawn * (h(P_s) - h(P)) + flows.vented * h(P)
        return flows.drawn * h(P_s), valve, none, none, none
    gas, room, T_a = chamber.gas, chamber.room_pressure, chamber.room_temperature
    T, T_s, p = flows.temperatures, flows.supply_temperature, P + room
    unit, c_p = gas.specific_gas_constant * T_a, gas.c_p
    # logarithms over the room's values: they take longest, and are each used twice
    ln_p, ln_T = log(guarded(p > 0, p, room) / room), log(T / T_a)
    ln_P, ln_T_s = log((P_s + room) / room), log(T_s / T_a)

    def warmth(T: Numbers, ln_T: Numbers) -> Numbers:
        """Exergy of a kilogram for its temperature [J/kg]."""
        return c_p * (T - T_a - T_a * ln_T)

    def lost_in_mixing(inflow: Numbers, T_in: Numbers, ln_T_in: Numbers) -> Numbers:
        """Exergy that an inflow loses in the chamber [W]; none of an outflow."""
        return maximum(inflow, 0.0) * c_p * T_a * (ln_T - ln_T_in + T_in / T - 1)

    drawn_warmth = where(flows.drawn > 0, warmth(T_s, ln_T_s), warmth(T, ln_T))
    return (
        flows.drawn * (unit * ln_P + drawn_warmth),  # (F1)
        unit * (flows.drawn * (ln_P - ln_p) + flows.vented * ln_p),
        maximum(flows.vented, 0.0) * warmth(T, ln_T),
        lost_in_mixing(flows.drawn, T_s, ln_T_s) + lost_in_mixing(-flows.vented, T_a, 0.0),
        (1 - T_a / T) * heat,
    )


def _stored_energies(
    plant: Plant, state: State, friction_memory: FrictionMemory, evaluation: PlantEvaluation
) -> Numbers:
    """Energies [J] stored in the places of `STORES`, without the supply's."""
    q, v, load = evaluation.position, evaluation.velocity, plant.load
    P, muscles = evaluation.fluid.pressures, evaluation.fluid.muscles
    xp, friction_energy = array_namespace(q, P), 0.0 * q
    if plant.hysteresis is not None:
        motion = muscle_motion(plant, friction_memory, q, P)
        forces = plant.hysteresis.advance(friction_memory.spring_forces, motion).spring_forces
        friction_energy = xp.sum(plant.counts * plant.hysteresis.stored(forces), axis=-1)
    return stack_last(
        xp.sum(plant.chamber.stored_energy(state.chambers, P), axis=-1),
        xp.sum(plant.counts * (P * muscles.volume - muscles.coenergy), axis=-1),
        0.0 * v if load.prescribed else load.inertia * v**2 / 2,
        load.potential(q),
        load.stop.energy(q) if load.stop else 0.0 * q,
        friction_energy,
    )
