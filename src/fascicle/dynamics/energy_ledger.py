r"""Energy ledger of a plant: powers of its parts, and stored energies.

Each energy is the integral of its own power; none is the remainder of others. Of a gas
they are exergies: a kilogram that is throttled from $p_1$ to $p_2$ loses $R T_a \ln(p_1/p_2)$; one
that comes at $T_{in}$ into a chamber at $T$ loses
$c_p T_a (\ln(T/T_{in}) + T_{in}/T - 1)$; heat $\dot Q$ that leaves at $T$ takes
$(1 - T_a/T)\,\dot Q$ along. The fluid's work is taken by parts, $P V - \int V\,\mathrm{d}P$: the
slope of a muscle's volume jumps where it collapses, the volume doesn't.

**Source:** first and second law for open systems: Bejan (2016).
"""

from ..core.array_namespace import array_namespace, log, maximum, where
from ..core.roots import guarded
from ..core.types import Numbers
from ..fluid.chamber import stack_last
from .motion import Flows, FrictionMemory, PlantEvaluation, State, friction_step
from .plant import Plant


_FLUID = (  # entries of each unit's fluid, in the order of `ledger_rates`
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
)
_LOAD = (  # entries of the load, in the order of `ledger_rates`
    "pull",  # ∫ F dx of the muscles on the load [J]
    "damper",  # lost in the load's damper [J]
    "stop",  # lost in its stop's damper [J]
    "friction",  # lost in the muscles [J]
    "motor",  # work of a prescribed motion [J]
)
LEDGER = (*_FLUID, *_LOAD)  # keys of files and JSON
# places that store energy, keys of files and JSON
STORES = ("fluid", "muscles", "motion", "load", "stop", "friction")


def ledger_rates(plant: Plant, state: State, evaluation: PlantEvaluation) -> Numbers:
    """Rates of all entries of the `LEDGER` [W or kg/s], without their `pressure_volume_term`.

    `plant`, its `state` [SI] and the `evaluation` of that state [SI].
    """
    load, P, flows = plant.load, evaluation.fluid.pressures, evaluation.flows
    V, v = evaluation.fluid.volume, evaluation.velocity
    V_dot, P_dot = evaluation.volume_rates, evaluation.pressure_rates
    heat = plant.chamber.heat_flow(state.chambers, P, flows.mass, flows.enthalpy, V_dot)
    fluid_powers = (
        *_fluid_powers(plant, flows, heat),
        -V * P_dot,
        -(V - plant.counts * evaluation.fluid.muscles.volume) * P_dot,
        flows.mass,
        flows.enthalpy,
        heat,
        -V * P_dot,
    )
    xp = array_namespace(v, P)
    # one sum over all units takes a fraction of the time
    fluid_total = xp.sum(stack_last(*fluid_powers), axis=-2)
    load_powers = stack_last(
        evaluation.pull * v,
        load.damper * v**2,
        evaluation.stop_damper * v,
        evaluation.friction_power,
        -(evaluation.pull - evaluation.friction_force) * v if load.prescribed else 0.0 * v,
    )
    return xp.concatenate([fluid_total, load_powers], axis=-1)


def pressure_volume_term(plant: Plant, evaluation: PlantEvaluation) -> Numbers:
    """Boundary term $P V$ of works that are integrated by parts [J], one for each entry of the
    `LEDGER` on the last axis, of all units.

    It is zero for the other entries.
    """
    P, V = evaluation.fluid.pressures, evaluation.fluid.volume
    terms = {
        "fluid_work": P * V,
        "mismatch": P * (V - plant.counts * evaluation.fluid.muscles.volume),
        "displaced": (P + plant.chamber.room_pressure) * V,
    }
    none = 0.0 * P
    return array_namespace(P, V).sum(
        stack_last(*(terms.get(name, none) for name in LEDGER)), axis=-2
    )


def _fluid_powers(plant: Plant, flows: Flows, heat: Numbers) -> tuple[Numbers, ...]:
    """Powers of each unit's fluid [W], of a gas's exergy or a liquid's energy: supplied, lost in
    valves, at the exhaust, in mixing and through the wall.
    """
    chamber, P, P_s = plant.chamber, flows.pressures, flows.supply_pressure
    if plant.liquid:
        h = chamber.liquid.flow_energy
        valve = flows.drawn * (h(P_s) - h(P)) + flows.vented * h(P)
        none = 0.0 * P
        return flows.drawn * h(P_s), valve, none, none, none
    gas, room, T_a = chamber.gas, chamber.room_pressure, chamber.room_temperature
    T, T_s, p = flows.temperatures, flows.supply_temperature, P + room
    unit, c_p = gas.specific_gas_constant * T_a, gas.c_p
    # logarithms over the room's values: they take longest, and are each used twice
    ln_p, ln_T = log(guarded(p > 0, p, room) / room), log(T / T_a)
    ln_P, ln_T_s = log((P_s + room) / room), log(T_s / T_a)
    valve = unit * (flows.drawn * (ln_P - ln_p) + flows.vented * ln_p)

    def warmth(T: Numbers, ln_T: Numbers) -> Numbers:
        """Exergy of a kilogram for its temperature [J/kg]."""
        return c_p * (T - T_a - T_a * ln_T)

    def lost_in_mixing(inflow: Numbers, T_in: Numbers, ln_T_in: Numbers) -> Numbers:
        """Exergy that an inflow loses in the chamber [W]; none of an outflow."""
        return maximum(inflow, 0.0) * c_p * T_a * (ln_T - ln_T_in + T_in / T - 1)

    drawn_warmth = where(flows.drawn > 0, warmth(T_s, ln_T_s), warmth(T, ln_T))
    return (
        flows.drawn * (unit * ln_P + drawn_warmth),  # (F1)
        valve,
        maximum(flows.vented, 0.0) * warmth(T, ln_T),
        lost_in_mixing(flows.drawn, T_s, ln_T_s) + lost_in_mixing(-flows.vented, T_a, 0.0),
        (1 - T_a / T) * heat,
    )


def stored_energies(
    plant: Plant, state: State, friction_memory: FrictionMemory, evaluation: PlantEvaluation
) -> Numbers:
    """Energies [J] stored in fluid, muscles, motion, load, stop and friction (`STORES`), without
    the supply's, of a `plant` in a `state` [SI], with its `friction_memory` [SI] and the
    `evaluation` of that state [SI].
    """
    q, v, load = evaluation.position, evaluation.velocity, plant.load
    P, muscles = evaluation.fluid.pressures, evaluation.fluid.muscles
    xp = array_namespace(q, P)
    add, friction_energy = xp.sum, 0.0 * q
    if plant.hysteresis is not None:
        forces = friction_step(plant, friction_memory, q, P).spring_forces
        friction_energy = add(plant.counts * plant.hysteresis.stored(forces), axis=-1)
    parts = (
        add(plant.chamber.stored_energy(state.chambers, P), axis=-1),
        add(plant.counts * (P * muscles.volume - muscles.coenergy), axis=-1),
        0.0 * v if load.prescribed else load.inertia * v**2 / 2,
        load.potential(q),
        load.stop.energy(q) if load.stop else 0.0 * q,
        friction_energy,
    )
    return xp.stack(xp.broadcast_arrays(*parts), axis=-1)
