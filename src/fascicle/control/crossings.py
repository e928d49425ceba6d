r"""Time at which the next motor unit can be recruited without a dip of force, if there is one.

Along a path of demand $F(t)$ and strain $\varepsilon(t)$ the hand-over to unit $k + 1$ must be over
before the units up to $k$ no longer suffice. While its pressure rises from 0 to the onset, unit
$k$ gives room at every moment:

$$n_k F_k(P_k, \varepsilon) = F(t) - \sum_{i < k} n_i F_i(P_s, \varepsilon)
    - n_{k+1} F_{k+1}(p, \varepsilon) - \sum_{i > k+1} n_i F_i(0, \varepsilon), \qquad P_k \le P_s.
  \tag{X5}$$

A hand-over that may begin at $t$ is followed in small steps of $p/p_{on}$, each of which takes as
long as the slower of both valves needs for its part: unit $k + 1$'s alone makes (X4); unit $k$'s
flow vanishes as its pressure nears the supply's, so that all of its reserve is never to be had in
time. The latest such hand-over is the cheapest; where none that ends in time would do, the last
strain at which one does; after it the next unit is kept at its onset.

**Assumes** both valves wide open where they are the slower ones, and quasi-static muscles.
**Source:** derived here.
"""

from typing import NamedTuple

import numpy as np

from ..bundle.bundle import Bundle
from ..bundle.states import resolve_supply_pressure
from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
from ..core.types import Numbers, Values
from ..core.validation import check_finite, check_nonnegative
from ..dynamics import Plant
from .branches import Branches
from .controller import DAMPED, pulse_delay, valve_lag
from .dip import Transition, check_unit, transition, unit_strain
from .units import SLACK, AbstractValves, Valves, valves_of_units


_SHAPE = (81, 121)  # of tables, for times alone; the dip is that of the law itself
_MOMENTS = 129  # times of a path, at least, at which a hand-over may begin: 1 % apart
_STEPS = 32  # of a hand-over: its time changes by less than a percent beyond
_ZOOMS = 2  # of 32 moments each, after the last that would do: to 1e-5 of the path
_NO_FLOW = 1e-300  # against division by none, at the supply's pressure
_SAMPLES = 401  # of a reference: steps of a quarter of a percent
_STRAINS = 65  # of dips, if the path has more: they are smooth between


class Path(NamedTuple):
    """Demand: `time` [s], rising, `force` [N] and `strain` [-]."""

    time: Numbers
    force: Numbers
    strain: Numbers

    @classmethod
    def of(cls, time: Values, force: Values, strain: Values) -> "Path":
        """Path of demand, linear between its times: `force` [N] and `strain` [-], or one for all,
        at each `time` [s]; `InvalidInputError` for times that don't rise, and unequal lengths.
        """
        t = np.atleast_1d(check_finite(time, "time", "s"))
        F = np.atleast_1d(check_finite(force, "force", "N"))
        if t.ndim != 1 or len(t) < 2 or np.any(np.diff(t) <= 0):
            raise InvalidInputError("time", "must be a row of at least two that rise", None)
        if F.shape != t.shape:
            raise InvalidInputError("force", "must have one for each time", np.size(F))
        eps = check_finite(strain, "strain", "-")
        if np.ndim(eps) and np.shape(eps) != t.shape:
            raise InvalidInputError("strain", "must be one, or one for each time", np.size(eps))
        return cls(t, F, np.broadcast_to(eps, t.shape) + 0.0)


class Crossing(NamedTuple):
    """Crossing of a transition: a hand-over to the next unit without a dip, if one exists.

    `deadline`: time from which the units before no longer suffice [s], `None` if they do. `start`
    and `end` [s]; `fill_time`: $t_c$, (X4), that the next unit alone needs at the end's strain [s];
    `strain` [-], `dip` [N] and `onset_pressure` [Pa] at the end; `reserve` at the start [N]; `None`
    without a hand-over, which has an `obstacle`:

    - "crossing.not_needed": the units before hold all of the path; the least `reserve` [N].
    - "crossing.too_late": they don't hold its beginning; the `shortfall` [N].
    - "crossing.no_gain": the next unit gains nothing up to the supply's pressure.
    - "crossing.dip_too_deep": the largest `reserve` [N] is less than the `dip` [N] there.
    - "crossing.valves_too_slow": the `reserve` [N] is less than the `dip` [N] too soon.
    """

    deadline: float | None
    start: float | None = None
    end: float | None = None
    fill_time: float | None = None
    strain: float | None = None
    dip: float | None = None
    onset_pressure: float | None = None
    reserve: float | None = None
    obstacle: Finding | None = None

    @property
    def exists(self) -> bool:
        """True if a hand-over without a dip exists."""
        return self.start is not None

    @property
    def is_resolved(self) -> bool:
        """True if the crossing exists, or none is needed."""
        return self.exists or self.deadline is None


def hand_over_time(
    bundle: Bundle,
    strain: Values,
    valves: Valves,
    unit: int = 2,
    supply_pressure: Values = None,
) -> Numbers:
    """Time $t_c$ [s] in which a unit's valve fills it to its onset pressure, (X4): inf if it gains
    nothing up to the supply's pressure. `valves` are those of `crossing`; other arguments and
    errors are those of `transition`: `strain` [-] and `supply_pressure` [Pa].
    """
    onset = np.asarray(transition(bundle, strain, unit, supply_pressure).onset_pressure)
    valve = valves_of_units(valves, len(bundle.motor_units))[unit - 1]
    muscle, count = bundle.motor_units[unit - 1].muscle, bundle.motor_units[unit - 1].count
    eps, gains = unit_strain(bundle, unit, strain), np.isfinite(onset)
    p = np.where(gains, onset, 0.0)
    full, empty = (valve.content(P, count * muscle.conjugate_volume(P, eps)) for P in (p, 0.0 * p))
    # the least flow on its way
    return np.where(gains, (full - empty) / valve.flow(p), np.inf)[()]


def crossing(
    bundle: Bundle,
    path: Path,
    valves: Valves,
    unit: int = 2,
    supply_pressure: Values = None,
    slack: float = SLACK,
    lag: float = 0.0,
) -> Crossing:
    """The latest hand-over to a unit without a dip, along a path of demand.

    **Arguments:**

    - `bundle`, `unit` and `supply_pressure`: those of `transition` [Pa].
    - `path`: demand [N] and strain [-] over time [s].
    - `valves`: `GasValves`, `OilValves`, a `Plant`, or one for each unit.
    - `slack`: factor on the valves' time [-]: 1 is the criterion itself, with which a ramp at the
      valves' limit leaves a controller nothing to correct with.
    - `lag`: of the pressures behind a controller's demand [s]; a hand-over must be over by as much
      earlier.

    **Returns:** a `Crossing` [s]; if there is none, with its `obstacle`.

    **Raises:** `InvalidInputError` for a unit that doesn't exist, a path off the domain, and valves
    that don't fit.
    """
    check_unit(bundle, unit)
    supply = resolve_supply_pressure(bundle, supply_pressure)
    per_unit = valves_of_units(valves, len(bundle.motor_units))
    path = Path.of(*path)
    lag = float(check_nonnegative(lag, "lag", "s"))
    begin = path.time[0]
    path = path._replace(time=path.time - lag)  # pressures of now are those of this demand
    strains = np.unique(path.strain)
    if len(strains) > _STRAINS:
        strains = np.linspace(strains[0], strains[-1], _STRAINS)
    transitions = transition(bundle, strains, unit, supply)
    branches = Branches.of(bundle, supply, _SHAPE)
    hand_over = _HandOver(
        bundle, branches, unit - 1, supply, path, per_unit, slack, strains, transitions
    )
    t = np.union1d(path.time, np.linspace(path.time[0], path.time[-1], _MOMENTS))
    F, state = hand_over.demand(t)
    reserve = state.largest_force - F
    short = np.flatnonzero(reserve < 0)

    def no_crossing(deadline: float | None, code: str, **data: float) -> Crossing:
        finding = Finding(f"crossing.{code}", Severity.NOTE, {"unit": unit, **data})
        return Crossing(deadline, obstacle=finding)

    if not short.size:
        return no_crossing(None, "not_needed", reserve=float(np.min(reserve)))
    k = short[0]  # the reserve is used up before this moment
    if k == 0:
        return no_crossing(float(t[0]), "too_late", shortfall=-float(reserve[0]))
    deadline = float(t[k - 1] + (t[k] - t[k - 1]) * reserve[k - 1] / (reserve[k - 1] - reserve[k]))
    starts = t[(t >= begin) & (t < deadline) & (reserve >= state.dip)]
    start, end, step = np.nan, np.nan, float(np.max(np.diff(t)))
    for _ in range(_ZOOMS + 1):
        ends = hand_over.ends(starts)
        feasible = np.flatnonzero(ends <= deadline)  # in time, even if the demand falls again
        if not feasible.size:  # only in the first round: its start is among the next ones
            gains = np.isfinite(state.onset_pressure[: k + 1])
            margin = np.where(gains, (reserve - state.dip)[: k + 1], -np.inf)
            best = int(np.argmax(margin))
            if not np.any(gains):
                return no_crossing(deadline, "no_gain")
            code = "dip_too_deep" if margin[best] < 0 else "valves_too_slow"
            numbers = {"reserve": float(reserve[best]), "dip": float(state.dip[best])}
            return no_crossing(deadline, code, **numbers)
        start, end = float(starts[feasible[-1]]), float(ends[feasible[-1]])
        starts, step = np.linspace(start, min(start + step, deadline), 33), step / 32
    eps = float(np.interp(end, path.time, path.strain))
    last = transition(bundle, eps, unit, supply)
    F_start, first = hand_over.demand(np.array([start]))
    fill_time = float(hand_over_time(bundle, eps, per_unit, unit, supply))
    at_end, reserve = (eps, float(last.dip), float(last.onset_pressure)), first.largest_force
    return Crossing(deadline, start, end, fill_time, *at_end, float(reserve[0] - F_start[0]))


def crossings_on_reference(
    plant: Plant, reference: Values, dt: float, of: str, delay: float = 0.0
) -> tuple[Crossing, ...]:
    """A `Crossing` [s] to each unit but the first along the quasi-static motion of a `plant` that
    follows a `reference` `of` "force" or "position" [SI], one for each step `dt` [s], with a
    `delay` of measurements [s] besides the plant's valves'; raises as `crossing`.

    None for two bundles, whose demands depend on the controller.
    """
    bundle, *others = plant.bundles
    if others:
        return ()
    target = np.asarray(reference, float)
    steps = np.unique(np.linspace(0, len(target) - 1, _SAMPLES).astype(int))
    time, target = dt * steps, target[steps]
    low, high = plant.stroke
    if of == "position":
        q = np.clip(target, low, high)
        force, strain = -np.asarray(plant.load.force(q)), plant.strains(q[:, None])[:, 0]
    else:
        q = float(plant.load.motion_at(0.0, 0.0, 0.0)[0])
        force, strain = target, float(np.atleast_1d(plant.strains(q))[0])
    path = Path.of(time, force, strain)
    lag = DAMPED * (valve_lag(plant) + pulse_delay(plant) + delay)
    supply = plant.supply_pressure
    units = range(2, plant.units + 1)
    return tuple(crossing(bundle, path, plant, unit, supply, lag=lag) for unit in units)


class _HandOver(NamedTuple):
    """Search for hand-overs to the unit of index `k` along a `path`, with the `transitions` at some
    `strains` on it.
    """

    bundle: Bundle
    branches: Branches
    k: int
    supply: float
    path: Path
    valves: tuple[AbstractValves, ...]
    slack: float
    strains: Numbers
    transitions: Transition

    def demand(self, time: np.ndarray) -> tuple[np.ndarray, Transition]:
        """Demand [N] at a `time` [s], and the transition at its strain."""
        eps = np.interp(time, self.path.time, self.path.strain)
        F = np.interp(time, self.path.time, self.path.force)
        return F, Transition(*(np.interp(eps, self.strains, row) for row in self.transitions))

    def ends(self, start: np.ndarray) -> np.ndarray:
        """Ends [s] of the hand-overs that begin at each `start` [s]; inf without a feasible one."""
        t, last = start + 0.0, self.path.time[-1]
        feasible, duration, before = np.full(t.shape, True), np.zeros_like(t), None
        for fraction in np.linspace(0.0, 1.0, _STEPS + 1):
            # the demand at the step's end, if it takes as long as the one before
            ok, content, flow, gain = self._step(np.minimum(t + duration, last), fraction)
            if before is not None:  # as long as the slower valve needs
                added = np.maximum(content - before, 0.0) / np.maximum(flow, _NO_FLOW)
                duration = self.slack * np.max(added, axis=0)
            t, before = t + duration, content
            # a step near the supply's pressure takes far longer than the one before
            F, state = self.demand(np.minimum(t, last))
            feasible &= ok & (state.largest_force - F + gain >= 0) & (t <= last)
            t = np.where(feasible, t, last)
        return np.where(feasible, t, np.inf)

    def _step(self, time: np.ndarray, fraction: float) -> tuple[np.ndarray, ...]:
        """Feasibility of a hand-over at a `fraction` of it, both units' contents and flows on the
        first axis, and the force that the next unit gains [N].
        """
        k, P_s, n = self.k, self.supply, np.asarray(self.bundle.counts, float)
        F, state = self.demand(time)
        strain = np.interp(time, self.path.time, self.path.strain)
        eps = np.stack([unit_strain(self.bundle, i + 1, strain) for i in range(len(n))], axis=-1)
        gains = np.isfinite(state.onset_pressure)
        # the deepest point is among the steps: a muscle's force may have a kink there
        onset = np.where(gains, state.onset_pressure, P_s)
        first, second = min(2 * fraction, 1.0), max(2 * fraction - 1, 0.0)
        p = first * state.dip_pressure + second * (onset - state.dip_pressure)
        P = np.zeros((len(time), len(n)))
        empty = self.branches.force(P, eps)[:, k]
        P[:, k - 1], P[:, k] = P_s, p
        forces = self.branches.force(P, eps)
        # at the kink the law, since a table rounds it off
        gain = -state.dip if fraction == 0.5 else n[k] * (forces[:, k] - empty)
        spare = state.largest_force - F + gain
        demand = forces.copy()
        demand[:, k - 1] -= np.maximum(spare, 0.0) / n[k - 1]
        # a demand below an empty unit's force is no fault of the hand-over
        P[:, k - 1] = self.branches.pressure(demand, eps)[:, k - 1]
        V = self.branches.muscles.at(P, eps).volume * n
        units = [(self.valves[i], P[:, i], V[:, i]) for i in (k - 1, k)]
        contents = np.stack([valve.content(p, volume) for valve, p, volume in units])
        flows = np.stack([valve.flow(p) for valve, p, _ in units])
        return gains & (spare >= 0), contents, flows, gain
