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

**Assumes** air at 20 °C throughout, a constant supply, no inertia (`cycle_run` has both load and
inertia), valves that open at once.
"""

from dataclasses import dataclass

import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.types import Bool, Float
from ..core.validation import check_interval
from ..fluid.fields import ROOM_TEMPERATURE
from ..fluid.flow_elements import REFERENCE_DENSITY, Line, SonicValve
from ..fluid.valve_catalog import CatalogValve, catalog_valves
from .designs import Designs
from .task import Task


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


@dataclass(frozen=True)
class Cycle:
    """Contractions and releases of a bundle.

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
            largest_rate = 60 / self.time
            rule = f"must be at most {largest_rate:.4g}: each cycle takes {self.time:g} s"
            raise InvalidInputError("per_minute", rule, self.per_minute, "take fewer, or less time")


@dataclass(frozen=True, eq=False)
class ValveSizing:
    """Valves of a design for a cycle.

    - `cycle`: what was demanded.
    - `case`: the load case that needs the largest conductance, counted from 0.
    - `filled`: mask of the units that it fills.
    - `conductance`: that each unit's valve needs at the `cycle`'s b [m³/(s·Pa)]; 0 for a unit that
      is never filled; infinite where no valve is enough.
    - `fill`, `vent`: times of the unit with the largest conductance in that case [s].
    - `bore`: of the hoses [m], or `None` for none, or none wide enough.
    - `valves`: the smallest of the catalog that is enough for each unit, or `None`.
    """

    cycle: Cycle
    case: int
    filled: Bool[np.ndarray, " unit"]
    conductance: Float[np.ndarray, " unit"]
    fill: float
    vent: float
    bore: float | None
    valves: tuple[CatalogValve | None, ...]

    @property
    def feasible(self) -> bool:
        """True if there are a valve and a hose that fill in time."""
        return bool(np.all(np.isfinite(self.conductance)))

    @property
    def line(self) -> Line | None:
        """Hose of each unit, or `None`."""
        if self.bore is None or self.cycle.hose_length is None:
            return None
        return Line(self.cycle.hose_length, self.bore)

    @property
    def hose_volume(self) -> float:
        """Volume of a unit's hose [m³]."""
        if self.bore is None or self.cycle.hose_length is None:
            return 0.0
        return np.pi / 4 * self.bore**2 * self.cycle.hose_length


class _Contraction:
    """Pressure and volume of a design's units from rest to each load case, at nodes, from which
    `times` to fill and to vent follow for any valve (G4).

    `pressure` of all filled units [Pa], nodes first, then cases; `volume` of each unit [m³], nodes,
    cases, units; `supply`: the supply's pressure [Pa].
    """

    def __init__(self, pressure: np.ndarray, volume: np.ndarray, supply: float):
        self.pressure, self.volume, self.supply = pressure[..., None], volume, supply

    def times(
        self, supply: SonicValve, exhaust: SonicValve, hose_volume: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Times to fill and to vent each unit in each case [s]."""
        p = self.pressure
        content = ((p + ATMOSPHERE) * self.volume + p * hose_volume) / ATMOSPHERE
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
) -> ValveSizing | None:
    """Valves and hoses with which a design does the load cases within a time.

    **Arguments:**

    - `designs`: with the design among them.
    - `index`: of the design.
    - `task`: what is demanded.
    - `cycle`: the time, and the hoses.
    - `pressurized`: mask of the units that each load case feeds.
    - `fluid`: that each takes [m³].
    - `margin`: relative margin of each [-]; negative for one that isn't reached.

    **Returns:** the sizing; `None` if no load case is reached. Of more than 64 load cases, those
    that take most fluid and those with the least margin are run.
    """
    (successes,) = np.nonzero((margin >= 0) & pressurized.any(axis=1))
    if not successes.size:
        return None
    hardest = [successes[np.argsort(key[successes])[:_CASES]] for key in (-fluid, margin)]
    cases = np.unique(np.concatenate(hardest))
    filled, contraction = (
        pressurized[cases],
        _contraction(designs, index, task, cases, pressurized[cases]),
    )
    C, bore, volume = _conductances(contraction, cycle, filled)
    case, unit = np.unravel_index(np.argmax(C), C.shape)
    needed = C.max(axis=0)
    line = None if cycle.hose_length is None or bore is None else Line(cycle.hose_length, bore)
    fill = vent = np.inf
    valves: list[CatalogValve | None] = [None] * len(needed)
    if np.isfinite(needed).all():
        valve = SonicValve(np.where(needed > 0, needed, needed.max()), cycle.b, line=line)
        fill, vent = (float(t[case, unit]) for t in contraction.times(valve, valve, volume))
        for candidate in reversed(catalog_valves()):
            supply, exhaust = (with_fields(valve, line=line) for valve in candidate[1:3])
            enough = np.all(
                ~filled | (sum(contraction.times(supply, exhaust, volume)) <= cycle.time), axis=0
            )
            valves = [candidate if ok else v for ok, v in zip(enough, valves, strict=True)]
    return ValveSizing(
        cycle, int(cases[case]), filled[case], needed, fill, vent, bore, tuple(valves)
    )


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
) -> tuple[np.ndarray, float | None, float]:
    """Conductance that each unit needs in each case [m³/(s·Pa)], and the hoses' bore [m] and volume
    [m³]; infinite conductances if no hose is wide enough.
    """
    unit_valve = SonicValve(1e-8, cycle.b)
    valve_conductance = np.where(
        filled, 1e-8 * sum(contraction.times(unit_valve, unit_valve)) / cycle.time, 0.0
    )
    if cycle.hose_length is None:
        return valve_conductance, None, 0.0
    for bore in _BORES:
        line, volume = Line(cycle.hose_length, bore), np.pi / 4 * bore**2 * cycle.hose_length
        # a conductance half the hose's must be enough, and one without hose isn't too much
        low, high = (
            valve_conductance,
            np.broadcast_to(line.conductance / _HOSE_SHARE, valve_conductance.shape),
        )

        def time(C: np.ndarray, line: Line = line, volume: float = volume) -> np.ndarray:
            valve = SonicValve(np.where(filled, C, 1e-8), cycle.b, line=line)
            return np.where(filled, sum(contraction.times(valve, valve, volume)), 0.0)

        if np.any(low > high) or np.any(time(high) > cycle.time):
            continue
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            enough = time(middle) <= cycle.time
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return np.where(filled, high, 0.0), float(bore), float(volume)
    return np.where(filled, np.inf, 0.0), None, 0.0
