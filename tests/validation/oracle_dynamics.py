"""The oracle, part 10: a bundle of ideal muscles in time, in plain numbers.

Its states aren't the library's: a gas is told by pressure and mass, a liquid by pressure, so that
no equation of state is solved. SciPy's DOP853 at its finest tolerance goes from command to command.
Muscles are ideal meshes up to their free strain: past it, or without pressure, it gives up.
"""

import math
from dataclasses import dataclass

import numpy as np
import oracle_fluid as fluid
import oracle_muscle
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


GRAVITY = 9.80665


@dataclass(frozen=True)
class Unit:
    """Muscles, how many [-], which side of a joint they pull to [-], and their chamber."""

    muscle: oracle_muscle.Muscle
    count: int
    dead_volume: float = 0.0
    side: int = 1
    compliance: float = 0.0


@dataclass(frozen=True)
class Air:
    """Behind a wall of conductance [W/K], infinite for an isothermal one; valves' C [m³/(s·Pa)]
    and b [-].
    """

    conductance: float
    C: float
    b: float


@dataclass(frozen=True)
class Oil:
    """Bulk modulus [Pa], density [kg/m³], valves' area [m²]."""

    modulus: float
    density: float
    area: float
    discharge: float = 0.611
    transition: float = 1e3


@dataclass(frozen=True)
class Load:
    """Inertia [kg or kg·m²], spring [N/m], its rest [m], weight [N], damper, and of a joint the
    pulley's radius [m], contraction in the middle [m] and pendulum's moment [N·m].
    """

    inertia: float
    stiffness: float = 0.0
    rest: float = 0.0
    weight: float = 0.0
    damping: float = 0.0
    radius: float = 1.0
    contraction: float = 0.0
    pendulum: float = 0.0

    def force(self, q):
        spring = self.stiffness * (q - self.rest)
        return -spring - self.weight - self.pendulum * math.sin(q)


@dataclass(frozen=True)
class Plant:
    units: tuple[Unit, ...]
    filling: Air | Oil
    load: Load
    supply: float  # gauge [Pa]


def strain(plant, unit, q):
    return (plant.load.contraction + unit.side * plant.load.radius * q) / unit.muscle.length


def pull(plant, pressures, q):
    """On the load's coordinate."""
    total = 0.0
    for unit, P in zip(plant.units, pressures, strict=True):
        e = strain(plant, unit, q)
        arm = unit.count * unit.side * plant.load.radius
        total += arm * oracle_muscle.mesh_untuned(unit.muscle, P, e)
    return total


def rest(plant, pressures):
    """The coordinate at which the load rests, of an ideal mesh that pulls."""
    ends = [oracle_muscle.ideal_free_strain(unit.muscle) for unit in plant.units]
    half = min(end * unit.muscle.length for end, unit in zip(ends, plant.units, strict=True))
    low, high = sorted(
        ((x - plant.load.contraction) / plant.load.radius) for x in (-0.3 * half, half)
    )
    if any(unit.side < 0 for unit in plant.units):
        high = (half - plant.load.contraction) / plant.load.radius
        low = -high
    return brentq(lambda q: pull(plant, pressures, q) + plant.load.force(q), low, high, xtol=1e-16)


def volume(plant, unit, q):
    inside = unit.count * oracle_muscle.volume(unit.muscle, strain(plant, unit, q))
    return inside + unit.dead_volume


def _flows(plant, p, T, command):
    """Drawn from the supply and vented [kg/s], at an absolute pressure."""
    room, high = fluid.ROOM, plant.supply + fluid.ROOM
    to_supply, to_room = max(command, 0.0), max(-command, 0.0)
    if isinstance(plant.filling, Air):
        valve = plant.filling.C, plant.filling.b

        def passed(p1, p2, T1, T2):
            if p1 >= p2:
                return fluid.sonic(*valve, p1, p2, T1)
            return -fluid.sonic(*valve, p2, p1, T2)

        drawn = passed(high, p, fluid.WARM, T)
        return to_supply * drawn, to_room * passed(p, room, T, fluid.WARM)
    oil = plant.filling

    def passed(drop):
        root = math.sqrt(math.hypot(drop, oil.transition))
        return oil.discharge * oil.area * math.sqrt(2 * oil.density) * drop / root

    return to_supply * passed(high - p), to_room * passed(p - room)


def _rates(plant, command, y):
    """Of q, v, and for each unit absolute pressure, mass, what was drawn, and ∫ P dV."""
    q, v = y[0], y[1]
    units, gas = y[2:].reshape(-1, 4), plant.filling
    out = np.empty_like(y)
    out[0] = v
    pressures = units[:, 0] - fluid.ROOM
    force = pull(plant, pressures, q) + plant.load.force(q) - plant.load.damping * v
    out[1] = force / plant.load.inertia
    for k, (unit, (p, m, _, _)) in enumerate(zip(plant.units, units, strict=True)):
        V = volume(plant, unit, q)
        # πr²L's slope is that of the ideal mesh's force per pressure: PdV = −F dL
        swept = unit.count * unit.side * plant.load.radius * v
        V_dot = swept * oracle_muscle.mesh_untuned(unit.muscle, 1.0, strain(plant, unit, q))
        if isinstance(gas, Oil):
            P, rho = p - fluid.ROOM, gas.density * math.exp((p - fluid.ROOM) / gas.modulus)
            drawn, vented = _flows(plant, p, fluid.WARM, command[k])
            gives = rho * ((V + unit.compliance * P) / gas.modulus + unit.compliance)
            p_dot = (drawn - vented - rho * V_dot) / gives
        elif math.isinf(gas.conductance):
            drawn, vented = _flows(plant, p, fluid.WARM, command[k])
            p_dot = ((drawn - vented) * fluid.R * fluid.WARM - p * V_dot) / V
        else:
            T = p * V / (m * fluid.R)
            drawn, vented = _flows(plant, p, T, command[k])
            brought = fluid.CP * drawn * (fluid.WARM if drawn > 0 else T)
            taken = fluid.CP * vented * (T if vented > 0 else fluid.WARM)
            heat = brought - taken - gas.conductance * (T - fluid.WARM)
            p_dot = ((fluid.GAMMA - 1) * heat - fluid.GAMMA * p * V_dot) / V
        out[2 + 4 * k : 6 + 4 * k] = p_dot, drawn - vented, drawn, (p - fluid.ROOM) * V_dot
    return out


def mass(plant, unit, P, q):
    """In a chamber at gauge pressure, as warm as the room."""
    V = volume(plant, unit, q)
    if isinstance(plant.filling, Oil):
        rho = plant.filling.density * math.exp(P / plant.filling.modulus)
        return rho * (V + unit.compliance * P)
    return (P + fluid.ROOM) * V / (fluid.R * fluid.WARM)


@dataclass(frozen=True)
class Run:
    """At each time: q, v; for each unit gauge pressure, mass, drawn mass, work ∫ P dV."""

    position: np.ndarray
    velocity: np.ndarray
    pressures: np.ndarray
    masses: np.ndarray
    drawn: np.ndarray
    works: np.ndarray


def run(plant, schedule, times, pressures, position=None):
    """`schedule`: ((time, commands), ...), from 0; `times` from 0 on; from `pressures` [Pa]."""
    q = rest(plant, pressures) if position is None else position
    y = [q, 0.0]
    for unit, P in zip(plant.units, pressures, strict=True):
        y += [P + fluid.ROOM, mass(plant, unit, P, q), 0.0, 0.0]
    y, times = np.array(y), np.asarray(times)
    rows = [y[None]]
    starts = [start for start, _ in schedule]
    for (low, command), high in zip(schedule, [*starts[1:], times[-1]], strict=True):
        inside = times[(times > low) & (times <= high)]
        asked = np.unique(np.append(inside, high))
        # of pressures 1e-6 Pa, of lengths 1e-13 m, of masses and energies 1e-15
        size = np.array([1e-13, 1e-12] + [1e-6, 1e-16, 1e-16, 1e-12] * len(plant.units))
        leg = solve_ivp(
            lambda _, y, u=command: _rates(plant, u, y), (low, high), y, "DOP853", asked,
            rtol=1e-11, atol=size,
        )  # fmt: skip
        if not leg.success:
            raise RuntimeError(leg.message)
        y = leg.y[:, -1]
        rows.append(leg.y.T[np.isin(asked, inside)])
    rows = np.concatenate(rows)
    units = rows[:, 2:].reshape(len(rows), -1, 4)
    for k, unit in enumerate(plant.units):
        e = strain(plant, unit, rows[:, 0])
        if np.any(e >= oracle_muscle.ideal_free_strain(unit.muscle)) or np.any(
            units[:, k, 0] <= fluid.ROOM
        ):
            raise RuntimeError(f"unit {k} leaves where its mesh alone pulls")
    return Run(
        rows[:, 0], rows[:, 1], units[..., 0] - fluid.ROOM, *units[..., 1:].transpose(2, 0, 1)
    )
