r"""Valves and hoses that lift and release a load within given times, and the run in time.

Each load case is lifted from rest and released: the units that it pressurizes are filled at once,
each in proportion to its pressure $p_i^*$ that holds the demanded force at the demanded contraction
(as `recruit` gives it), then vented until a twentieth of the contraction is left. On the way, the
share of these pressures at a strain is that at which the bundle's force equals the demanded one
(the load). Every unit takes $V_N$, its content in normal volume and that of its hose, (G3), through
a valve (F4) and its hose (F5) in series:

$$t_{lift} = \int_0^{p^*} \frac{\mathrm{d} V_N}{q(P_s, p)}, \qquad
  t_{release} = \int_{p_{1/20}}^{p^*} \frac{\mathrm{d} V_N}{q(p, p_a)}, \tag{G4}$$

with the flow $q$ in normal volume. The conductance $C$ that a unit's valve needs, both ways, is the
least with which both times are kept; without a hose they are inversely proportional to it.

**Assumes** air at 20 °C throughout, a constant supply, no inertia, valves that open at once.

`run_cycle` checks a cycle in time: proportional valves, as named, raise the units to the
pressures that are printed, hold them, and vent them; a mass that weighs the demanded force hangs on
the bundle, rests on a stop at no contraction, and swings: nothing but the valves slows it down.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..bundle import Bundle
from ..bundle.states import resolve_supply_pressure
from ..core.array_namespace import maximum, minimum
from ..core.errors import InvalidInputError
from ..core.module import Module, with_fields
from ..core.types import Batch, Float, Numbers
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
_RUN_STEPS = 400  # of the shorter of lift and release
_SAG = 0.01  # of the stroke, by which the load at rest presses the stop in
_RELEASED = _LEFT / _STEPS  # of the stroke, when the load counts as released: as in the sizing
_THROTTLING = 0.05  # of the supply's pressure: closer to its target a proportional valve throttles
BAND = 0.1  # of the stroke on either side, in which a lifted load must stay


@dataclass(frozen=True)
class Cycle:
    """Cycle of contraction and release that a bundle must do: times to `lift` and to `release` [s],
    their number `per_minute`, `hose_length` of each unit [m], `None` for valves at the muscles, and
    the critical pressure ratio `b` of the valves [-].
    """

    lift: float
    release: float
    per_minute: float
    hose_length: float | None = None
    b: float = USUAL_RATIO

    def __post_init__(self):
        """**Raises:** `InvalidInputError` for values off their domains, and cycles that overlap."""
        for name, largest, unit in (
            ("lift", _LONGEST_TIME, "s"),
            ("release", _LONGEST_TIME, "s"),
            ("per_minute", np.inf, "-"),
            ("b", 1.0, "-"),
            ("hose_length", _LONGEST_HOSE, "m"),
        ):
            if (value := getattr(self, name)) is not None:
                check_interval(value, 0.0, largest, name, unit)
        time, number = self.lift + self.release, self.per_minute
        if time * number > 60 * (1 + 1e-9):  # rounding of 60 s
            shown, largest = distinct_texts(number, 60 / time)
            rule = f"must be at most {largest}: each cycle takes {time:g} s"
            remedy = "take fewer, or less time"
            raise InvalidInputError("per_minute", rule, number, remedy, shown=shown)


@dataclass(frozen=True, eq=False)
class ValveSizing:
    """Valves of a design for a `cycle`.

    - `case`: the load case that needs the largest conductance, counted from 0; `run_case`: of those
      that do work, `None` without one.
    - `pressures`: of the units in `run_case` [Pa]; `start`: the share of them that balances the
      load at rest [-].
    - `conductance`: that each unit's valve needs at the `cycle`'s b [m³/(s·Pa)]; 0 for a unit that
      is never filled; infinite where no valve is enough.
    - `fill`, `vent`: times of the unit with the largest conductance in that case [s].
    - `line`: hose of each unit, or `None` for none, or none wide enough.
    - `valves`: the smallest of the catalog that is enough for each unit, or `None`.
    """

    cycle: Cycle
    case: int
    run_case: int | None
    pressures: Float[np.ndarray, " unit"]
    start: float
    conductance: Float[np.ndarray, " unit"]
    fill: float
    vent: float
    line: Line | None
    valves: tuple[CatalogValve | None, ...]

    @property
    def feasible(self) -> bool:
        """True if there are a valve and a hose that fill in time."""
        return bool(np.all(np.isfinite(self.conductance)))

    @property
    def bore(self) -> float | None:
        """Inner diameter of the hoses [m], or `None`."""
        return None if self.line is None else float(self.line.diameter)


def hose_volume(line: Line | None) -> float:
    """Volume of a hose [m³]."""
    return 0.0 if line is None else float(np.pi / 4 * line.diameter**2 * line.length)


class _Contraction(NamedTuple):
    """`pressure` [Pa] and `volume` [m³] of a design's units from rest to each load case, nodes
    first, then cases, then units; `supply`: the supply's pressure [Pa].
    """

    pressure: np.ndarray
    volume: np.ndarray
    supply: float

    def times(self, supply: SonicValve, exhaust: SonicValve) -> tuple[np.ndarray, np.ndarray]:
        """Times to fill and to vent each unit in each case [s], with the hose of `supply`."""
        p = self.pressure
        content = ((p + ATMOSPHERE) * self.volume + p * hose_volume(supply.line)) / ATMOSPHERE
        content = np.where(p[-1] > 0, content, 0.0)  # a vented unit breathes with the room
        rise, middle = np.diff(content, axis=0), (p[1:] + p[:-1]) / 2 + ATMOSPHERE
        T, released = ROOM_TEMPERATURE, len(p) - _STEPS + _LEFT - 1
        inflow = supply.flow(self.supply + ATMOSPHERE, middle, T, T) / REFERENCE_DENSITY
        outflow = exhaust.flow(middle, ATMOSPHERE, T, T) / REFERENCE_DENSITY
        with np.errstate(divide="ignore", invalid="ignore"):  # at rest nothing flows into nothing
            fill, vent = (np.where(rise > 0, rise / q, 0.0) for q in (inflow, outflow))
        return fill.sum(axis=0), vent[released:].sum(axis=0)

    def share_of_time(self, cycle: Cycle, supply: SonicValve, exhaust: SonicValve) -> np.ndarray:
        """The larger share of its time that lift or release of each unit takes in each case [-]."""
        fill, vent = self.times(supply, exhaust)
        return np.maximum(fill / cycle.lift, vent / cycle.release)


def size_valves(
    design: Designs,
    task: Task,
    cycle: Cycle,
    pressures: Float[np.ndarray, "case unit"],
    fluid: Float[np.ndarray, " case"],
    margin: Float[np.ndarray, " case"],
) -> ValveSizing | None:
    """Valves and hoses with which a single design does the load cases that it reaches within the
    times of a `cycle`; `None` if it reaches none. Of more than 64 load cases, those that take most
    fluid and those with the least margin are run. By load case, `pressures` of the units [Pa],
    `fluid` [m³], and relative `margin` [-], negative for one that isn't reached.
    """
    (successes,) = np.nonzero((margin >= 0) & (pressures > 0).any(axis=1))
    if not successes.size:
        return None
    hardest = [successes[np.argsort(key[successes])[:_CASES]] for key in (-fluid, margin)]
    cases = np.unique(np.concatenate(hardest))
    pressures, F = pressures[cases], task.force[cases]
    filled, strain = pressures > 0, task.strain_of(float(design.length[0]))[cases]
    contraction, start = _contraction(design, strain, F, pressures, task.supply_pressure)
    C, line = _conductances(contraction, cycle, filled)
    case, unit = np.unravel_index(np.argmax(C), C.shape)
    needed, works = C.max(axis=0), F * strain > 0
    run = int(np.argmax(np.where(works, C.max(axis=1), -1.0)))
    fill = vent = np.inf
    valves: list[CatalogValve | None] = [None] * len(needed)
    if np.isfinite(needed).all():
        valve = SonicValve(np.where(needed > 0, needed, needed.max()), cycle.b, line=line)
        fill, vent = (float(t[case, unit]) for t in contraction.times(valve, valve))
        for candidate in reversed(catalog_valves()):
            ends = (with_fields(x, line=line) for x in (candidate.supply, candidate.exhaust))
            enough = np.all(~filled | (contraction.share_of_time(cycle, *ends) <= 1), axis=0)
            valves = [candidate if ok else v for ok, v in zip(enough, valves, strict=True)]
    return ValveSizing(
        *(cycle, int(cases[case]), int(cases[run]) if works.any() else None, pressures[run]),
        *(float(start[run]), needed, fill, vent, line, tuple(valves)),
    )


def _contraction(
    design: Designs, strain: np.ndarray, force: np.ndarray, pressures: np.ndarray, supply: float
) -> tuple[_Contraction, np.ndarray]:
    """Contraction of a single design up to load cases, to whose `pressures` [Pa] units rise in
    proportion, and the share of these that balances each load at rest [-].
    """
    progress, level = np.linspace(0.0, 1.0, _STEPS + 1)[:, None], np.linspace(0.0, 1.0, _LEVELS)
    path = progress * strain
    total, volumes = np.zeros((_LEVELS, *path.shape)), []
    for unit in range(pressures.shape[1]):
        muscle, n = design.muscle(0, unit), design.counts[0, unit]
        total += n * np.asarray(muscle.force(level[:, None, None] * pressures[:, unit], path))
        volumes.append(n * np.asarray(muscle.volume(path)))
    # a load that is held at less pressure further on is let go at the pressure before
    share = np.maximum.accumulate(_first_level(total - force, level), axis=0)
    ramp, volume = progress[:-1] * share[:1], np.stack(volumes, axis=-1)  # before it is lifted
    pressure = np.concatenate([ramp, share])[..., None] * pressures
    volume = np.concatenate([np.repeat(volume[:1], _STEPS, axis=0), volume])
    return _Contraction(pressure, volume, supply), share[0]


def _first_level(excess: np.ndarray, level: np.ndarray) -> np.ndarray:
    """The lowest level [-] at which the excess of a force over a load [N], levels first, vanishes,
    linear between two; else 1. `level`: rising, from 0 to 1 [-].
    """
    before, after = excess[:-1], excess[1:]
    # from below or from above: a state that resists may fall before it rises
    crosses = (before * after <= 0) & (after != before)
    first = np.argmax(crosses, axis=0)
    before, after = (np.take_along_axis(x, first[None], axis=0)[0] for x in (before, after))
    drop = np.where(after == before, 1.0, after - before)
    fraction = np.clip(-before / drop, 0.0, 1.0)
    crossing = level[first] + fraction * (level[first + 1] - level[first])
    # without a crossing it is within the tolerance of a state's end
    return np.where(crosses.any(axis=0), crossing, 1.0)


def _conductances(
    contraction: _Contraction, cycle: Cycle, filled: np.ndarray
) -> tuple[np.ndarray, Line | None]:
    """Conductance that each unit needs in each case [m³/(s·Pa)], and the hoses; infinite if no hose
    is wide enough.
    """
    # times are inverse to the conductance, so any will do: 1 L/(s·bar)
    unit_valve = SonicValve(1e-8, cycle.b)
    share = contraction.share_of_time(cycle, unit_valve, unit_valve)
    valve_conductance = np.where(filled, 1e-8 * share, 0.0)
    if cycle.hose_length is None:
        return valve_conductance, None

    def is_enough(C: np.ndarray, line: Line) -> np.ndarray:
        # a unit that stays empty takes no time, so any conductance will do
        valve = SonicValve(np.where(filled, C, 1e-8), cycle.b, line=line)
        return ~filled | (contraction.share_of_time(cycle, valve, valve) <= 1)

    for bore in _BORES:
        line = Line(cycle.hose_length, float(bore))
        # a conductance half the hose's must be enough, and one without hose isn't too much
        low = valve_conductance
        high = np.broadcast_to(line.conductance / _HOSE_SHARE, low.shape)
        if np.any(low > high) or not np.all(is_enough(high, line)):
            continue
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            enough = is_enough(middle, line)
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return np.where(filled, high, 0.0), line
    return np.where(filled, np.inf, 0.0), None


class CycleRun(NamedTuple):
    """Times of a run until the load is within the band about the `stroke` [m], `lifted`, and from
    the end of the hold until it is `released` [s], NaN if it never is; its `highest` position, and
    the `lowest` one between its arrival and the end of the hold [m]; the bundle's largest force on
    the way, `peak_force` [N].
    """

    lifted: float
    released: float
    highest: float
    lowest: float
    stroke: float
    peak_force: float

    @property
    def overshoot(self) -> float:
        """Largest travel beyond the stroke, over the stroke [-]; negative if it isn't reached."""
        return self.highest / self.stroke - 1

    def passes(self, cycle: Cycle) -> bool:
        """True if the load arrives and returns in time, and stays within the band between."""
        stays = self.overshoot <= BAND and self.lowest >= (1 - BAND) * self.stroke
        return self.lifted <= cycle.lift and self.released <= cycle.release and stays  # NaN isn't


class _PressureControl(Module):
    """Proportional valves that follow pressures [Pa], and throttle within `band` [Pa] of them."""

    band: Numbers

    @property
    def memory(self) -> Batch:
        """Nothing to remember."""
        return np.float64(0.0)

    def __call__(
        self, memory: Batch, measurement: "Measurement", reference: Numbers
    ) -> tuple[Batch, Numbers]:
        """Memory, and a valve command for each unit [-]."""
        command = (reference - measurement.pressures) / self.band
        return memory, maximum(minimum(command, 1.0), -1.0)


def run_cycle(bundle: Bundle, force: float, stroke: float, sizing: ValveSizing) -> CycleRun:
    """Times in which a bundle lifts and releases a hanging mass of weight `force` [N] by a `stroke`
    [m], and how far it swings, from a simulation with the valves and pressures of a feasible
    `sizing`; NaN for a time that isn't reached. `ValueError` for a load that can't be held at rest.
    """
    from ..dynamics import HangingMass, Plant, Stop, simulate  # needs JAX
    from ..dynamics.loads import DAMPER_DEPTH, GRAVITY

    cycle = sizing.cycle
    needed = np.where(sizing.conductance > 0, sizing.conductance, sizing.conductance.max())
    # C and b of each unit's valve to the supply, and of that to the room
    ends = [
        [(C, cycle.b)] * 2 if valve is None else [(x.C, x.b) for x in (valve.supply, valve.exhaust)]
        for C, valve in zip(needed, sizing.valves, strict=True)
    ]
    supply_valve, exhaust_valve = (
        SonicValve(C, b, line=sizing.line) for C, b in np.transpose(ends, (1, 2, 0))
    )
    supply = resolve_supply_pressure(bundle, None)
    mass, stiffness = force / GRAVITY, force / (_SAG * stroke)
    # critical where the load sags to, so that it doesn't bounce: the damper acts by depth, (T2)
    damping = 2 * np.sqrt(stiffness * mass) * (1 + DAMPER_DEPTH / (_SAG * stroke))
    plant = Plant(
        bundle,
        HangingMass(mass, stop=Stop(low=0.0, stiffness=stiffness, damping=damping)),
        ConstantSupply(supply, room_pressure=ATMOSPHERE),
        Isothermal(dead_volume=hose_volume(sizing.line), room_pressure=ATMOSPHERE),
        supply_valve,
        exhaust_valve,
    )
    end = 2 * cycle.lift  # held as long as it was lifted
    dt = min(cycle.lift, cycle.release) / _RUN_STEPS
    volume = np.array([unit.count * float(unit.muscle.volume(0.0)) for unit in bundle.motor_units])
    # of an open valve [Pa/s]: it throttles from so far on that a step doesn't overshoot the target
    rate = np.asarray(supply_valve.C) * (supply + ATMOSPHERE) * ATMOSPHERE
    band = np.maximum(_THROTTLING * supply, 2 * dt * rate / (volume + hose_volume(sizing.line)))
    # up along half a wave, held, and vented
    time = dt * np.arange(round((end + 2 * cycle.release) / dt))[:, None]
    wave = (1 - np.cos(np.pi * np.minimum(time / cycle.lift, 1.0))) / 2
    share = np.where(time < end, sizing.start + (1 - sizing.start) * wave, 0.0)
    run = simulate(plant, _PressureControl(band), share * sizing.pressures, dt=dt)
    position, time = np.asarray(run.outputs.position), np.asarray(run.time)
    held = time <= end
    (near,), highest = np.nonzero(held & (position >= (1 - BAND) * stroke)), float(position.max())
    peak = float(np.asarray(run.outputs.forces).sum(axis=-1).max())
    if not near.size:
        return CycleRun(np.nan, np.nan, highest, np.nan, stroke, peak)
    lowest = float(position[near[0] : held.sum()].min())
    down = int(np.flatnonzero(position > _RELEASED * stroke)[-1]) + 1  # it may swing up again
    released = float(time[down] - end) if down < len(position) else np.nan
    return CycleRun(float(time[near[0]]), released, highest, lowest, stroke, peak)
