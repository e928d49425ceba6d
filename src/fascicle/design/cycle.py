r"""Valves and hoses that fill and vent the motor units of a design within a time.

A load case is run from rest and back: the units that it feeds are all filled at once, until their
common pressure $p^*$ holds the demanded force at the demanded contraction; then they are vented,
until a twentieth of the contraction is left. Between, the strain at a pressure is that at which the
bundle's force equals the demanded one (the load), and there is none below the pressure that lifts
it. Every unit takes $V_N$, its content in normal volume and that of its hose, (G3), through a valve
(F4) and its hose (F5) in series:

$$t = \int_0^{p^*} \frac{\mathrm{d} V_N}{q(P_s, p)} + \int_{p_{1/20}}^{p^*}
      \frac{\mathrm{d} V_N}{q(p, p_a)}, \tag{G4}$$

with the flow $q$ in normal volume. The conductance $C$ that a unit's valve needs, both ways, is
that with which $t$ is the time given; without a hose $t$ is inversely proportional to it.

**Assumes** air at 20 °C throughout, a constant supply, no inertia, valves that open at once.

`run_cycle` runs a cycle in time, as a check: the units that the load case feeds are joined to the
supply until a mass that hangs on the bundle is lifted by the demanded stroke, then to the room. The
mass weighs the demanded force and rests on a stop at no contraction. It swings beyond the stroke
and comes to rest later than the sizing has it: `fit_valves` enlarges the valves until a run passes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..bundle import Bundle
from ..core.array_namespace import maximum, where
from ..core.errors import InvalidInputError
from ..core.module import Module, with_fields
from ..core.types import Batch, Bool, Float, Numbers
from ..core.validation import check_interval, distinct_texts
from ..fluid import ConstantSupply, Isothermal
from ..fluid.data_sheets import CatalogValve, catalog_valves
from ..fluid.fields import ROOM_TEMPERATURE
from ..fluid.flow_elements import REFERENCE_DENSITY, Line, SonicValve
from .designs import Designs
from .task import Task


if TYPE_CHECKING:
    from ..dynamics import Measurement

ATMOSPHERE = 100e3  # Pa, of ISO 8778
USUAL_RATIO = 0.3  # b of a valve: those of the catalog have 0.13 to 0.40
_LONGEST_TIME = 3600.0  # s; a longer cycle is a slip in the unit
_LONGEST_HOSE = 100.0  # m, as above
_LEVELS = 65  # pressures at which forces are computed: where a muscle pulls, force is linear in it
_STEPS = 40  # of the contraction: a valve's time is then known within 0.1 %
_LEFT = 2  # steps of the contraction that are left when it counts as released: a twentieth
_CASES = 64  # load cases that are run: those that take most fluid, and those with least margin
_HOSE_SHARE = 2.0  # least conductance of a hose over its valve's: then it costs a tenth of the flow
WIDEST_BORE = 20e-3  # m; wider hoses are pipes
_BORES = np.arange(1e-3, WIDEST_BORE + 1e-4, 5e-4)  # m; a tube with the next larger bore is enough
_HALVINGS = 40  # of an interval of a factor of four: leaves rounding
_RUN_STEPS = 1000  # of the cycle's time
_LONGER = 2  # times the cycle's time that is run: a slower design then has a number, too
_SAG = 0.01  # of the stroke, by which the load at rest presses the stop in
_DAMPER_DEPTH = 1e-3  # m, of (T2)
_RELEASED = _LEFT / _STEPS  # of the stroke, when the load counts as released: as in the sizing
_ENLARGEMENTS = 8  # of valves, before a run counts as failed: five do in 28 of 30 random tasks
LARGEST_OVERSHOOT = 0.1  # of the stroke; a load that swings further isn't where it was to go
_RESERVE = 0.02  # of the time, by which an enlargement aims lower: one that swings needs fewer


@dataclass(frozen=True)
class Cycle:
    """Cycle of contraction and release that a bundle must do in a time.

    - `time`: of one contraction and release [s].
    - `per_minute`: their number in a minute [-].
    - `hose_length`: length of each unit's hose [m]; `None` for valves at the muscles.
    - `b`: critical pressure ratio of the valves [-].
    """

    time: float
    per_minute: float
    hose_length: float | None = None
    b: float = USUAL_RATIO

    def __post_init__(self):
        """**Raises:** `InvalidInputError` for values off their domains, and cycles that overlap."""
        check_interval(self.time, 0.0, _LONGEST_TIME, "time", "s")
        check_interval(self.per_minute, 0.0, np.inf, "per_minute", "-")
        check_interval(self.b, 0.0, 1.0, "b", "-")
        if self.hose_length is not None:
            check_interval(self.hose_length, 0.0, _LONGEST_HOSE, "hose_length", "m")
        if self.time * self.per_minute > 60 * (1 + 1e-9):  # rounding of 60 s
            given, largest = distinct_texts(self.per_minute, 60 / self.time)
            rule = f"must be at most {largest}: each cycle takes {self.time:g} s"
            remedy = "take fewer, or less time"
            raise InvalidInputError("per_minute", rule, self.per_minute, remedy, shown=given)


@dataclass(frozen=True, eq=False)
class ValveSizing:
    """Valves of a design for a cycle.

    - `cycle`: what was demanded.
    - `case`: the load case that needs the largest conductance, counted from 0.
    - `run_case`: of those that do work, `None` without one.
    - `filled`: mask of the units that `run_case` fills.
    - `conductance`: that each unit's valve needs at the `cycle`'s b [m³/(s·Pa)]; 0 for a unit that
      is never filled; infinite where no valve is enough.
    - `fill`, `vent`: times of the unit with the largest conductance in that case [s].
    - `line`: hose of each unit, or `None` for none, or none wide enough.
    - `valves`: the smallest of the catalog that is enough for each unit, or `None`.
    - `time`: in which valves do the cycle without the load's inertia [s]; less than the `cycle`'s
      if they were enlarged.
    """

    cycle: Cycle
    case: int
    run_case: int | None
    filled: Bool[np.ndarray, " unit"]
    conductance: Float[np.ndarray, " unit"]
    fill: float
    vent: float
    line: Line | None
    valves: tuple[CatalogValve | None, ...]
    time: float

    @property
    def feasible(self) -> bool:
        """True if there are a valve and a hose that fill in time."""
        return bool(np.all(np.isfinite(self.conductance)))

    @property
    def bore(self) -> float | None:
        """Inner diameter of the hoses [m], or `None`."""
        return None if self.line is None else float(self.line.diameter)

    @property
    def hose_volume(self) -> float:
        """Volume of a unit's hose [m³]."""
        return _volume(self.line)


def _volume(line: Line | None) -> float:
    return 0.0 if line is None else float(np.pi / 4 * line.diameter**2 * line.length)


class _Contraction:
    """Contraction of a design from rest to each load case: pressure and volume of its units at
    nodes, from which `times` to fill and to vent follow for any valve (G4).

    `pressure` of all filled units [Pa], nodes first, then cases; `volume` of each unit [m³], nodes,
    cases, units; `supply`: the supply's pressure [Pa].
    """

    def __init__(self, pressure: np.ndarray, volume: np.ndarray, supply: float):
        self.pressure, self.volume, self.supply = pressure[..., None], volume, supply

    def times(self, supply: SonicValve, exhaust: SonicValve) -> tuple[np.ndarray, np.ndarray]:
        """Times to fill and to vent each unit in each case [s], with the hose of `supply`."""
        p = self.pressure
        content = ((p + ATMOSPHERE) * self.volume + p * _volume(supply.line)) / ATMOSPHERE
        rise, middle = np.diff(content, axis=0), (p[1:] + p[:-1]) / 2 + ATMOSPHERE
        T, released = ROOM_TEMPERATURE, len(p) - _STEPS + _LEFT - 1
        inflow = supply.flow(self.supply + ATMOSPHERE, middle, T, T) / REFERENCE_DENSITY
        outflow = exhaust.flow(middle, ATMOSPHERE, T, T) / REFERENCE_DENSITY
        with np.errstate(divide="ignore", invalid="ignore"):  # at rest nothing flows into nothing
            fill, vent = (np.where(rise > 0, rise / q, 0.0) for q in (inflow, outflow))
        return fill.sum(axis=0), vent[released:].sum(axis=0)


def first_level(
    force: Float[np.ndarray, "point level"],
    demanded: Float[np.ndarray, " point"],
    level: Float[np.ndarray, " level"],
) -> Float[np.ndarray, " point"]:
    """The lowest level [-] at which a force is the demanded one, linear between two; else 1.

    **Arguments:**

    - `force`: at each level [N].
    - `demanded`: force [N].
    - `level`: shares of the supply pressure, from 0 to 1 [-].

    **Returns:** the level [-].
    """
    excess = force - demanded[:, None]
    # from below or from above: a state that resists may fall before it rises
    crosses = (excess[:, :-1] * excess[:, 1:] <= 0) & (excess[:, 1:] != excess[:, :-1])
    first, points = np.argmax(crosses, axis=1), np.arange(len(force))
    before, after = excess[points, first], excess[points, first + 1]
    drop = np.where(after == before, 1.0, after - before)
    fraction = np.clip(-before / drop, 0.0, 1.0)
    crossing = level[first] + fraction * (level[first + 1] - level[first])
    # without a crossing it is within the tolerance of a state's end
    return np.where(np.any(crosses, axis=1), crossing, 1.0)


def size_valves(
    designs: Designs,
    index: int,
    task: Task,
    cycle: Cycle,
    pressurized: Bool[np.ndarray, "case unit"],
    fluid: Float[np.ndarray, " case"],
    margin: Float[np.ndarray, " case"],
    time: float | None = None,
) -> ValveSizing | None:
    """Valves and hoses with which a design does the load cases that it reaches within a time;
    `None` if it reaches none.

    **Arguments:**

    - `designs`: with the design among them.
    - `index`: of the design.
    - `task`: what is demanded.
    - `cycle`: the time, and the hoses.
    - `pressurized`: mask of the units that each load case feeds.
    - `fluid`: that each takes [m³].
    - `margin`: relative margin of each [-]; negative for one that isn't reached.
    - `time`: in which they do it without the load's inertia [s]; default: the cycle's.

    **Returns:** the sizing, or `None`. Of more than 64 load cases, those
    that take most fluid and those with the least margin are run.
    """
    (successes,) = np.nonzero((margin >= 0) & pressurized.any(axis=1))
    if not successes.size:
        return None
    hardest = [successes[np.argsort(key[successes])[:_CASES]] for key in (-fluid, margin)]
    cases = np.unique(np.concatenate(hardest))
    filled = pressurized[cases]
    contraction = _contraction(designs, index, task, cases, filled)
    time = cycle.time if time is None else time
    C, line = _conductances(contraction, replace(cycle, time=time), filled)
    case, unit = np.unravel_index(np.argmax(C), C.shape)
    needed = C.max(axis=0)
    works = (task.force * task.strain_of(float(designs.length[index])))[cases] > 0
    run_case = int(np.argmax(np.where(works, C.max(axis=1), -1.0)))
    fill = vent = np.inf
    valves: list[CatalogValve | None] = [None] * len(needed)
    if np.isfinite(needed).all():
        valve = SonicValve(np.where(needed > 0, needed, needed.max()), cycle.b, line=line)
        fill, vent = (float(t[case, unit]) for t in contraction.times(valve, valve))
        for candidate in reversed(catalog_valves()):
            supply, exhaust = (with_fields(valve, line=line) for valve in candidate[1:3])
            enough = np.all(~filled | (sum(contraction.times(supply, exhaust)) <= time), axis=0)
            valves = [candidate if ok else v for ok, v in zip(enough, valves, strict=True)]
    return ValveSizing(
        cycle, int(cases[case]), int(cases[run_case]) if works.any() else None, filled[run_case],
        needed, fill, vent, line, tuple(valves), time,
    )  # fmt: skip


def _contraction(
    designs: Designs, index: int, task: Task, cases: np.ndarray, filled: np.ndarray
) -> _Contraction:
    """Contraction of a design up to some load `cases`, whose `filled` units have one pressure."""
    counts = designs.counts[index][designs.counts[index] > 0]
    muscles = [designs.muscle(index, unit) for unit in range(len(counts))]
    if designs.uniform[index]:
        muscles = muscles[:1]
    length, F = float(designs.length[index]), task.force[cases]
    strain = np.linspace(0.0, 1.0, _STEPS + 1)[:, None] * task.strain_of(length)[cases]
    level = np.linspace(0.0, 1.0, _LEVELS)
    P = level[:, None, None] * task.supply_pressure
    forces = [np.asarray(muscle.force(P, strain)) for muscle in muscles]
    volumes = [np.asarray(muscle.volume(strain)) for muscle in muscles]
    total = sum(
        n * np.where(filled[:, unit], force, force[:1])
        for unit, n in enumerate(counts)
        for force in [forces[unit % len(forces)]]
    )
    total = np.moveaxis(np.asarray(total), 0, -1).reshape(-1, _LEVELS)
    demanded = np.broadcast_to(F, strain.shape).ravel()
    pressure = task.supply_pressure * first_level(total, demanded, level).reshape(strain.shape)
    # a load that is held at less pressure further on is let go at the pressure before
    pressure = np.maximum.accumulate(pressure, axis=0)
    volume = np.stack([n * volumes[u % len(volumes)] for u, n in enumerate(counts)], axis=-1)
    start = np.linspace(0.0, 1.0, _STEPS + 1)[:-1, None] * pressure[:1]  # before the load is lifted
    volume_at_rest = np.broadcast_to(volume[:1], (_STEPS, *volume.shape[1:]))
    return _Contraction(
        np.concatenate([start, pressure]),
        np.concatenate([volume_at_rest, volume]),
        task.supply_pressure,
    )


def _conductances(
    contraction: _Contraction, cycle: Cycle, filled: np.ndarray
) -> tuple[np.ndarray, Line | None]:
    """Conductance that each unit needs in each case [m³/(s·Pa)], and the hoses; infinite if no hose
    is wide enough.
    """
    # times are inverse to the conductance, so any will do: 1 L/(s·bar)
    unit_valve = SonicValve(1e-8, cycle.b)
    valve_conductance = np.where(
        filled, 1e-8 * sum(contraction.times(unit_valve, unit_valve)) / cycle.time, 0.0
    )
    if cycle.hose_length is None:
        return valve_conductance, None
    for bore in _BORES:
        line = Line(cycle.hose_length, float(bore))
        # a conductance half the hose's must be enough, and one without hose isn't too much
        low = valve_conductance
        high = np.broadcast_to(line.conductance / _HOSE_SHARE, low.shape)

        def time(C: np.ndarray, line: Line = line) -> np.ndarray:
            # a unit that stays empty has no time below, so any conductance will do
            valve = SonicValve(np.where(filled, C, 1e-8), cycle.b, line=line)
            return np.where(filled, sum(contraction.times(valve, valve)), 0.0)

        if np.any(low > high) or np.any(time(high) > cycle.time):
            continue
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            enough = time(middle) <= cycle.time
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return np.where(filled, high, 0.0), line
    return np.where(filled, np.inf, 0.0), None


class CycleRun(NamedTuple):
    """Result of a run: times from the start at which the load is lifted by the demanded stroke, and
    from which on it is released [s], NaN if it never is; the `highest` position [m], and the
    demanded `stroke` [m].
    """

    lifted: float
    released: float
    highest: float
    stroke: float

    @property
    def overshoot(self) -> float:
        """Largest travel beyond the stroke, over the stroke [-]; negative if it isn't reached."""
        return self.highest / self.stroke - 1

    def passes(self, time: float) -> bool:
        """True if it was lifted and released within a `time` [s] and went no more than
        `LARGEST_OVERSHOOT` too far.
        """
        return self.released <= time and self.overshoot <= LARGEST_OVERSHOOT  # NaN isn't


class _LiftAndRelease(Module):
    """Controller: supply to the `filled` units until the stroke is reached, then the room."""

    stroke: Batch
    filled: Numbers

    @property
    def memory(self) -> Batch:
        """0 before the stroke is reached, 1 from then on."""
        return np.float64(0.0)

    def __call__(
        self, memory: Batch, measurement: "Measurement", reference: Any
    ) -> tuple[Batch, Numbers]:
        """Next memory, and a valve command for each unit [-]."""
        del reference
        memory = maximum(memory, where(measurement.position >= self.stroke, 1.0, 0.0))
        return memory, where(memory > 0, -1.0, self.filled)


def fit_valves(
    sizing: ValveSizing,
    resize: Callable[[float], ValveSizing | None],
    run: Callable[[ValveSizing], CycleRun],
) -> tuple[ValveSizing, CycleRun]:
    """Enlarge valves until a run in time ends within the cycle's time.

    **Arguments:**

    - `sizing`: without the load's inertia.
    - `resize`: sizing for a time in which valves do the cycle without it [s].
    - `run`: run with a sizing.

    **Returns:** the enlarged sizing and its run; the given sizing and its run if none is in time.
    """
    first, demanded, larger = run(sizing), sizing.cycle.time, sizing
    result = first
    for _ in range(_ENLARGEMENTS):
        if result.released <= demanded:  # larger valves only swing more
            break
        released = _LONGER * demanded if np.isnan(result.released) else result.released
        candidate = resize(larger.time * (1 - _RESERVE) * demanded / released)
        if candidate is None or not candidate.feasible:
            break
        larger, result = candidate, run(candidate)
    return (larger, result) if result.released <= demanded else (sizing, first)


def run_cycle(bundle: Bundle, force: float, stroke: float, sizing: ValveSizing) -> CycleRun:
    """Times at which a bundle has lifted and released a hanging mass [s], and its highest position
    [m], from a simulation of one contraction and release.

    **Arguments:**

    - `bundle`: with its supply pressure.
    - `force`: weight of the mass [N], positive.
    - `stroke`: contraction at which the release begins [m], positive.
    - `sizing`: valves and hoses, which must be feasible.

    **Returns:** the times and positions; NaN for a time that isn't reached.

    **Raises:** `ValueError` for a load that the bundle can't hold at rest.
    """
    from ..dynamics import HangingMass, Plant, Stop, simulate  # needs JAX
    from ..dynamics.loads import GRAVITY

    C = np.where(sizing.conductance > 0, sizing.conductance, sizing.conductance.max())
    mass, stiffness = force / GRAVITY, force / (_SAG * stroke)
    # critical where the load sags to, so that it doesn't bounce: the damper acts by depth, (T2)
    damping = 2 * np.sqrt(stiffness * mass) * (1 + _DAMPER_DEPTH / (_SAG * stroke))
    stop = Stop(low=0.0, stiffness=stiffness, damping=damping)
    plant = Plant(
        bundle,
        HangingMass(mass, stop=stop),
        ConstantSupply(bundle.supply_pressure, room_pressure=ATMOSPHERE),
        Isothermal(dead_volume=sizing.hose_volume, room_pressure=ATMOSPHERE),
        SonicValve(C, sizing.cycle.b, line=sizing.line),
    )
    controller = _LiftAndRelease(np.float64(stroke), np.where(sizing.filled, 1.0, -1.0))
    reference = np.zeros((_LONGER * _RUN_STEPS, 1))
    run = simulate(plant, controller, reference, dt=sizing.cycle.time / _RUN_STEPS)
    position = np.asarray(run.outputs.position)
    arrivals = np.flatnonzero(position >= stroke)
    if not arrivals.size:
        return CycleRun(np.nan, np.nan, float(position.max()), stroke)
    first = int(arrivals[0])
    # a load that swings up again isn't released yet
    down = int(np.flatnonzero(position > _RELEASED * stroke)[-1]) + 1
    released = float(run.time[down]) if down < len(position) else np.nan
    return CycleRun(float(run.time[first]), released, float(position.max()), stroke)
