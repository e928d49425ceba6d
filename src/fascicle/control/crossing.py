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

from typing import Any, NamedTuple

import numpy as np

from ..bundle.bundle import Bundle, resolve_supply_pressure
from ..core.errors import InvalidInputError
from ..core.types import Numbers, Values
from ..core.validation import check_finite
from .branches import Branches
from .transition import Transition, check_unit, transition, unit_strain
from .units import SLACK
from .valves import AbstractValves, for_each


_SHAPE = (81, 121)  # of tables, which say how soon; whether there is a dip the law itself says
_MOMENTS = 129  # of a path at least, at which a hand-over may begin
_STEPS = 32  # of a hand-over
_ZOOMS = 2  # of 32 moments each, after the last that would do: to 1e-5 of the path
_NO_FLOW = 1e-300  # against division by none, at the supply's pressure
_STRAINS = 65  # at which dips are looked for, where more are on the path


class Path(NamedTuple):
    """Demand: `time` [s], rising, `force` [N], and `strain` [-], one for all or each."""

    time: Numbers
    force: Numbers
    strain: Numbers

    @classmethod
    def of(cls, time: Values, force: Values, strain: Values) -> "Path":
        """A path through moments, linear between them.

        **Arguments:**

        - `time`: at least two, rising [s].
        - `force`: the demand at each [N].
        - `strain`: the bundle's contraction at each, or one for all [-].

        **Returns:** the path [-].

        **Raises:** `ValueError` for times that don't rise, and rows that don't fit.
        """
        t, F = (
            np.atleast_1d(check_finite(x, n, u))
            for x, n, u in ((time, "time", "s"), (force, "force", "N"))
        )
        if t.ndim != 1 or len(t) < 2 or np.any(np.diff(t) <= 0):
            raise InvalidInputError("time", "must be a row of at least two that rise", None)
        if F.shape != t.shape:
            raise InvalidInputError("force", "must have one for each time", np.size(F))
        eps = check_finite(strain, "strain", "-")
        if np.ndim(eps) and np.shape(eps) != t.shape:
            raise InvalidInputError("strain", "must be one, or one for each time", np.size(eps))
        return cls(t, F, np.broadcast_to(eps, t.shape) + 0.0)


class Crossing(NamedTuple):
    """A hand-over: its `start` and `end` [s], what of that the next unit alone needs at its end's
    strain, `time` $t_c$ [s], (X4); the `strain` [-], `dip` [N] and `onset_pressure` [Pa] there;
    the reserve when it begins, `reserve` [N]; when the units before no longer suffice, `needed`
    [s]; in words why there is none, `reason`. What there isn't is `None`.
    """

    start: float | None
    end: float | None
    time: float | None
    strain: float | None
    dip: float | None
    onset_pressure: float | None
    reserve: float | None
    needed: float | None
    reason: str

    @property
    def found(self) -> bool:
        """True if there is a crossing."""
        return self.start is not None

    def __str__(self) -> str:
        """In a sentence."""
        if not self.found:
            return f"none: {self.reason}"
        return (
            f"from {self.start:.4g} s to {self.end:.4g} s at a strain of {self.strain:.4g}:"
            f" {self.reserve:.4g} N of reserve for a dip of {self.dip:.4g} N"
        )


def hand_over_time(
    bundle: Bundle, strain: Values, valves: Any, unit: int = 2, supply_pressure: Values = None
) -> Numbers:
    """How long a unit's valve needs to its onset, $t_c$ of equation (X4).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: its contraction [-].
    - `valves`: `GasValves`, `OilValves`, a `Plant`, or one for each unit [-].
    - `unit`: that is fed [-], counted from 1.
    - `supply_pressure`: the supply's [Pa]; left out, the bundle's own.

    **Returns:** time [s]; inf where the unit gains nothing up to the supply's pressure.

    **Raises:** `ValueError` as `transition` does, and for valves that don't fit.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    result = transition(bundle, strain, unit, supply)
    valve = for_each(valves, len(bundle.motor_units))[unit - 1]
    return _time(bundle, unit, valve, result.onset_pressure, strain)


def crossing(
    bundle: Bundle,
    path: Path,
    valves: Any,
    unit: int = 2,
    supply_pressure: Values = None,
    slack: float = SLACK,
) -> Crossing:
    """The latest hand-over to a unit without a dip, along a path of demand.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `path`: what is demanded [N] at which strain [-] and time [s].
    - `valves`: `GasValves`, `OilValves`, a `Plant`, or one for each unit [-].
    - `unit`: that is recruited [-], counted from 1.
    - `supply_pressure`: the supply's [Pa]; left out, the bundle's own.
    - `slack`: factor on the valves' time [-]: 1 is the criterion itself, where a ramp at the
      valves' limit leaves a controller nothing to correct with.

    **Returns:** a `Crossing` [s]; where there is none, its `reason` says why.

    **Raises:** `ValueError` for a unit that doesn't exist, a path off the domain, and valves that
    don't fit.
    """
    check_unit(bundle, unit)
    supply = resolve_supply_pressure(bundle, supply_pressure)
    per_unit = for_each(valves, len(bundle.motor_units))
    path = Path.of(*path)
    along = _HandOver(bundle, unit, supply, path, per_unit, slack)
    t = np.union1d(path.time, np.linspace(path.time[0], path.time[-1], _MOMENTS))
    F, at = along.demand(t)
    reserve = at.largest_force - F
    short = np.flatnonzero(reserve < 0)

    def none(reason: str, needed: float | None = None) -> Crossing:
        return Crossing(None, None, None, None, None, None, None, needed, reason)

    before = f"unit {unit - 1}" if unit == 2 else f"units 1 to {unit - 1}"
    if not short.size:
        return none(f"{before} can hold all of the path, at least {np.min(reserve):.4g} N are left")
    if short[0] == 0:
        return none(
            f"{before} can't hold the path's beginning: {-reserve[0]:.4g} N are missing",
            float(t[0]),
        )
    k = short[0]  # between whose moments the reserve is used up
    needed = float(t[k - 1] + (t[k] - t[k - 1]) * reserve[k - 1] / (reserve[k - 1] - reserve[k]))
    open_ = t[(t < needed) & (reserve >= at.dip)]
    evaluated = along.followed(open_)
    good = np.flatnonzero(np.isfinite(evaluated))
    if not good.size:
        return none(along.why(t[: k + 1], before), needed)
    start, step = float(open_[good[-1]]), float(np.max(np.diff(t)))
    for _ in range(_ZOOMS):
        finer = np.linspace(start, min(start + step, needed), 33)
        evaluated = along.followed(finer)
        good = np.flatnonzero(np.isfinite(evaluated))
        start, step = float(finer[good[-1]]), step / 32
    end = float(evaluated[good[-1]])
    eps = float(np.interp(end, path.time, path.strain))
    index = transition(bundle, eps, unit, supply)
    F_then, then = along.demand(np.array([start]))
    return Crossing(
        start, end, float(_time(bundle, unit, per_unit[unit - 1], index.onset_pressure, eps)), eps,
        float(index.dip), float(index.onset_pressure), float(then.largest_force[0] - F_then[0]),
        needed, "",
    )  # fmt: skip


class _HandOver:
    """A path, what the units do along it, and hand-overs that are followed on it."""

    def __init__(
        self,
        bundle: Bundle,
        unit: int,
        supply: float,
        path: Path,
        valves: tuple[AbstractValves, ...],
        slack: float,
    ):
        self.path, self.k, self.supply, self.valves = path, unit - 1, supply, valves
        self.slack = slack
        self.ratios = bundle.ratios
        key = "control.branches", supply
        if key not in bundle.cache:
            bundle.cache[key] = Branches.of(bundle, supply, _SHAPE)
        self.branches: Branches = bundle.cache[key]
        self.counts = np.asarray(bundle.counts, float)
        low, high = float(np.min(path.strain)), float(np.max(path.strain))
        fewest = np.unique(path.strain)
        self.strains = fewest if len(fewest) <= _STRAINS else np.linspace(low, high, _STRAINS)
        self.found = transition(bundle, self.strains, unit, supply)
        self.bundle = bundle

    def demand(self, time: np.ndarray) -> tuple[np.ndarray, Transition]:
        """Demand [N] at a `time` [s], and the transition at its strain."""
        eps = np.interp(time, self.path.time, self.path.strain)
        F = np.interp(time, self.path.time, self.path.force)
        rows = [np.interp(eps, self.strains, row) for row in self.found]
        return F, Transition(*rows)

    def followed(self, start: np.ndarray) -> np.ndarray:
        """When a hand-over ends [s] that begins at each `start` [s]; inf where none without a dip
        does.
        """
        t, last = start + 0.0, self.path.time[-1]
        good, took, before = np.full(t.shape, True), np.zeros_like(t), []
        for fraction in np.linspace(0.0, 1.0, _STEPS + 1):
            # the demand of then, if this step takes as long as the one before
            ok, held = self._held(np.minimum(t + took, last), fraction)
            if before:
                per_unit = [
                    self.slack * np.maximum(time_now - was, 0.0) / np.maximum(flow, _NO_FLOW)
                    for (time_now, flow), (was, _) in zip(held, before, strict=True)
                ]
                took = np.maximum(*per_unit)
            t, before = t + took, held
            good &= ok & (t <= last)
            t = np.where(good, t, last)
        return np.where(good, t, np.inf)

    def _held(self, time: np.ndarray, fraction: float) -> tuple[np.ndarray, list]:
        """Feasibility of a hand-over to unit k, and the forces and rates of both units."""
        k, P_s = self.k, self.supply
        F, at = self.demand(time)
        eps = self._strains(time)
        helps = np.isfinite(at.onset_pressure)
        # the deepest point is among the steps, where a muscle's force has a kink
        onset = np.where(helps, at.onset_pressure, P_s)
        down, up = 2 * fraction * at.dip_pressure, (2 * fraction - 1) * (onset - at.dip_pressure)
        p = down if fraction <= 0.5 else at.dip_pressure + up
        n, P = self.counts, np.zeros((len(time), len(self.counts)))
        empty = self.branches.force(P, eps)[:, k]
        P[:, k - 1], P[:, k] = P_s, p
        forces = self.branches.force(P, eps)
        # at the kink the law, which a table rounds off
        gained = -at.dip if fraction == 0.5 else n[k] * (forces[:, k] - empty)
        left = at.largest_force - F + gained
        demand = forces.copy()
        demand[:, k - 1] -= np.maximum(left, 0.0) / n[k - 1]
        P[:, k - 1] = self.branches.pressure(demand, eps).pressure[:, k - 1]
        # less than an empty unit's is held by none, which isn't the hand-over's fault
        ok = helps & (left >= 0)
        V = self.branches.muscles.at(P, eps).volume * n
        return ok, [
            (
                np.asarray(self.valves[i].content(P[:, i], V[:, i])),
                np.asarray(self.valves[i].flow(P[:, i])),
            )
            for i in (k - 1, k)
        ]

    def _strains(self, time: np.ndarray) -> np.ndarray:
        eps = np.interp(time, self.path.time, self.path.strain)
        per_unit = [unit_strain(self.bundle, i + 1, eps) for i in range(len(self.counts))]
        return np.stack(per_unit, axis=-1)

    def why(self, time: np.ndarray, before: str) -> str:
        """Why there is no hand-over that begins at any `time` [s]."""
        F, at = self.demand(time)
        if not np.any(np.isfinite(at.onset_pressure)):
            return f"unit {self.k + 1} gains nothing at these strains up to the supply's pressure"
        margin = at.largest_force - F - at.dip
        best = int(np.argmax(np.where(np.isfinite(at.onset_pressure), margin, -np.inf)))
        if margin[best] < 0:
            spare = at.largest_force[best] - F[best]
            return (
                f"{before} can spare {max(spare, 0.0):.4g} N at most where the dip is"
                f" {at.dip[best]:.4g} N deep: force dips by {-margin[best]:.4g} N at least"
            )
        return (
            f"the valves are too slow: {before} can spare the dip's {at.dip[best]:.4g} N only while"
            " the demand is lower than when the hand-over would be over"
        )


def _time(
    bundle: Bundle, unit: int, valve: AbstractValves, onset: Values, strain: Values
) -> Numbers:
    time = bundle.motor_units[unit - 1]
    eps = unit_strain(bundle, unit, strain)
    p_on = np.asarray(onset)
    index = np.where(np.isfinite(p_on), p_on, 0.0)
    V = [time.count * time.muscle.conjugate_volume(P, eps) for P in (index, 0.0 * index)]
    spent = valve.content(index, V[0]) - valve.content(0.0 * index, V[1])
    # the least flow on its way
    return np.where(np.isfinite(p_on), spent / valve.flow(index), np.inf)[()]
