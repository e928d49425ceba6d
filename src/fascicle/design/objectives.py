"""Objectives of designs and limits on them, from the `Outcome` of many designs together.

`OBJECTIVES` has each objective by its name, with unit, the sense in which it is better, and what it
needs beyond the task's points; files, searches, results, reports and the docs read that. Weights
are the task's, over their sum.

Every search has the limit that a design reaches all points of the task. `not_reached`, limited, is
the share of the task that may be missed, by weight *and* by points, so that a peak load that counts
a thirtieth can't be lost among the others.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..bundle.schemes import AbstractScheme
from ..core.errors import InvalidInputError
from ..core.types import Bool, Float
from ..core.validation import check_choice, distinct_texts
from .outcome import Outcome, PerDesign


BY_WEIGHT, BY_POINTS = "not_reached", "points_not_reached"
SHARES = (BY_WEIGHT, BY_POINTS)
# objectives of every search: how far a design is from the task, and those of the offers
ALWAYS = (
    *(*SHARES, "margin", "relative_margin", "relative_shortfall", "valves", "mean_energy"),
    "mean_efficiency",
)
_ROUNDING = 1e-12  # of a limit, or of 1 in its unit: sums of shares don't end in round numbers

Function = Callable[[Outcome], PerDesign]


class Objective(NamedTuple):
    """A `function`, its unit, the `sense` in which it is better, and what of designs it `needs`:
    "" for the task's points, "size" for radii and bowing, "curves" for all strains.
    """

    function: Function
    unit: str
    sense: str
    needs: str = ""

    @property
    def about(self) -> str:
        """Description in a sentence."""
        return " ".join((self.function.__doc__ or "").split()).split(" [")[0]


OBJECTIVES: dict[str, Objective] = {}


def objective(unit: str, sense: str, needs: str = "") -> Callable[[Function], Function]:
    """Declare a function of an `Outcome` as an objective of its name; a decorator.

    **Arguments:**

    - `unit`: of its values: "-", "N", "J", "m" or another that `fascicle.units` has.
    - `sense`: in which it is better, "min" or "max".
    - `needs`: beyond the task's points: "size" or "curves".

    The first sentence of the function's docstring, up to a unit in brackets, describes it.
    **Raises:** `ValueError` for a name that is taken, no docstring, an unknown sense or need.
    """
    check_choice(sense, ("min", "max"), "sense")
    check_choice(needs or "points", ("points", "size", "curves"), "needs")

    def declare(function: Function) -> Function:
        name = function.__name__
        if name in OBJECTIVES:
            raise InvalidInputError(name, "is an objective already", None, "choose another name")
        if not function.__doc__:
            raise InvalidInputError(name, "must have a docstring", None, "reports show it")
        OBJECTIVES[name] = Objective(function, unit, sense, needs)
        return function

    return declare


@objective("-", "max")
def mean_efficiency(outcome: Outcome) -> PerDesign:
    r"""Mean over the task of work over fluid energy [-]: $W/E$, $W = F \varepsilon L_0$, (29).

    Points that ask for no work are left out; one that isn't reached counts as 0. `outcome` [-].
    """
    works = outcome.work > 0
    # a divisor where there is nothing to divide; at work the fluid's volume has grown
    E = np.where(works, outcome.energy, 1.0)
    efficiency = np.where(works & outcome.reached, outcome.work, 0.0) / E
    weight = np.where(works, outcome.weight, 0.0)
    return (weight * efficiency).sum(axis=0) / weight.sum(axis=0)


@objective("J", "min")
def peak_energy(outcome: Outcome) -> PerDesign:
    """Largest fluid energy that any point of the task takes [J]."""
    return outcome.energy.max(axis=0)


@objective("J", "min")
def mean_energy(outcome: Outcome) -> PerDesign:
    """Mean fluid energy of the task's points [J]."""
    return _weighted_mean(outcome, outcome.energy)


@objective("-", "min")
def not_reached(outcome: Outcome) -> PerDesign:
    """Share of the task, by weight, that no recruitment state reaches [-]."""
    return _weighted_mean(outcome, ~outcome.reached)


@objective("-", "min")
def points_not_reached(outcome: Outcome) -> PerDesign:
    """Share of the task's points, by number, that no recruitment state reaches [-]."""
    return np.mean(~outcome.reached, axis=0)


@objective("N", "max")
def margin(outcome: Outcome) -> PerDesign:
    """Least force to spare over the task's points [N], negative where one isn't reached."""
    return outcome.spare.min(axis=0)


@objective("-", "max")
def relative_margin(outcome: Outcome) -> PerDesign:
    """Least force to spare over what is demanded there [-], as of `Outcome.reference`."""
    return np.min(outcome.spare / outcome.reference, axis=0)


@objective("N", "min")
def shortfall(outcome: Outcome) -> PerDesign:
    """Mean distance from what is demanded to what is reachable [N]."""
    return _weighted_mean(outcome, outcome.shortfall)


@objective("N", "min")
def worst_shortfall(outcome: Outcome) -> PerDesign:
    """Largest distance from what is demanded to what is reachable [N]."""
    return outcome.shortfall.max(axis=0)


@objective("-", "min")
def relative_shortfall(outcome: Outcome) -> PerDesign:
    """Largest shortfall over what is demanded there [-], as of `Outcome.reference`."""
    return np.max(outcome.shortfall / outcome.reference, axis=0)


@objective("N", "max")
def largest_force(outcome: Outcome) -> PerDesign:
    """Blocked force of all units at supply pressure [N]."""
    return outcome.blocked.sum(axis=0)


@objective("N", "min")
def force_resolution(outcome: Outcome) -> PerDesign:
    """Largest step of the blocked force from one fully active state to the next [N]."""
    return outcome.blocked.max(axis=0)


@objective("-", "min")
def valves(outcome: Outcome) -> PerDesign:
    """Number of motor units [-], each with a valve of its own."""
    return outcome.units.astype(float)


@objective("m", "min", "size")
def envelope(outcome: Outcome) -> PerDesign:
    """Diameter of the circle around the muscles at the task's largest strain, with room for the
    deepest bow of a vented muscle up to there [m]; a lone unit is never vented.
    """
    assert outcome.size is not None
    return outcome.size


@objective("-", "min", "curves")
def reversal_depth(outcome: Outcome) -> PerDesign:
    """Largest fall of the free strain while a further unit's pressure rises from zero, earlier
    ones at the supply's [-]; 0 for a lone unit.
    """
    assert outcome.depth is not None
    return outcome.depth


@objective("N", "max", "curves")
def overlap_width(outcome: Outcome) -> PerDesign:
    """Largest height in force of what two successive states both reach, at forces of zero and
    above [N].
    """
    assert outcome.overlap is not None
    return outcome.overlap


def _weighted_mean(outcome: Outcome, values: np.ndarray) -> PerDesign:
    return (outcome.weight * values).sum(axis=0) / outcome.weight.sum(axis=0)


def check_objectives(names: Iterable[str], scheme: AbstractScheme | None = None) -> tuple[str, ...]:
    """Names of objectives in their order, without repetitions; `ValueError` for an unknown one, and
    for one that compares a state with the next under a `scheme` with independent units.
    """
    names = tuple(dict.fromkeys(check_choice(name, OBJECTIVES, "objectives") for name in names))
    for name in names:
        if scheme is not None and scheme.independent and OBJECTIVES[name].needs == "curves":
            rule = f"can't hold {name!r} with scheme {scheme.name!r}, which has no order of units"
            remedy = "leave it out, or take another scheme"
            raise InvalidInputError("objectives", rule, name, remedy, shown="")
    return names


class Limit(NamedTuple):
    """Limit: the least and the largest that an objective may be, in its own unit [SI]."""

    least: float = -np.inf
    most: float = np.inf

    def holds(self, values: Any) -> Any:
        """Mask of the `values` [SI] within; a NaN isn't."""
        return self.excess(values) <= 0

    def excess(self, values: Any) -> Any:
        """Distance of `values` [SI] from the interval, less rounding [SI]; not positive within."""
        low, high = (_ROUNDING * max(1.0, abs(x)) if np.isfinite(x) else 0.0 for x in self)
        return np.maximum(self.least - low - values, values - (self.most + high))


Limits = Mapping[str, Limit]
Values = Mapping[str, Float[np.ndarray, " design"]]
Matrix = Float[np.ndarray, "design objective"]


def within_limits(values: Values, limits: Limits) -> Bool[np.ndarray, " design"]:
    """Mask of designs within all limits; `values` [SI] and `limits` [SI] by objective."""
    mask = np.ones(next(iter(values.values())).shape, bool)
    for name, limit in limits.items():
        mask &= limit.holds(values[name])
    return mask


def recorded_objectives(
    senses: Mapping[str, str], limits: Limits, extra: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Names of the objectives that a search computes: of its senses, of its limits, the `extra`
    ones, and those of every search. `ValueError` for no `senses`, any but "min" and "max", and
    `limits` with the least above the most.
    """
    names = check_objectives([*senses, *limits, *extra, *ALWAYS])
    if not senses:
        raise InvalidInputError("objectives", "must name at least one", None, shown="none")
    for name, sense in senses.items():
        check_choice(sense, ("min", "max"), name)
    for name, limit in limits.items():
        if not limit.least <= limit.most:
            unit = OBJECTIVES[name].unit.replace("-", "")
            least, most = distinct_texts(limit.least, limit.most)
            rule = f"is limited to at least {least} and at most {most} {unit}"
            raise InvalidInputError(name, rule.rstrip(), None, "no design can be both")
    return names


def with_reach_limits(limits: Limits | None) -> dict[str, Limit]:
    """The `limits` on objectives [SI], with limits on both shares of the task that are missed: by
    weight what it was limited to, else 0 [-]; by points no more than that.
    """
    limits = dict(limits or {})
    by_weight, by_points = limits.get(BY_WEIGHT, Limit()), limits.get(BY_POINTS, Limit())
    allowed = by_weight.most if np.isfinite(by_weight.most) else 0.0
    return limits | {
        BY_WEIGHT: Limit(by_weight.least, allowed),
        BY_POINTS: Limit(by_points.least, min(by_points.most, allowed)),
    }


def allowed_miss_fraction(limits: Limits) -> float:
    """Share of the task that may be missed [-]; `limits` [SI] as of `with_reach_limits`."""
    return float(np.clip(limits[BY_WEIGHT].most, 0.0, 1.0))


def reaches_task(values: Values, limits: Limits) -> Bool[np.ndarray, " design"]:
    """Mask of designs that reach the task, whatever other limits they break."""
    return within_limits(values, {name: limits[name] for name in SHARES})


def other_limits(limits: Limits) -> dict[str, Limit]:
    """The `limits` [SI] on other objectives than the shares that may be missed."""
    return {name: limit for name, limit in limits.items() if name not in SHARES}


def as_minimization(values: Values, senses: Mapping[str, str]) -> Matrix:
    """Objectives with `senses` as columns in which smaller is better, a row a design [SI]."""
    columns = [values[name] if sense == "min" else -values[name] for name, sense in senses.items()]
    return np.stack(columns, axis=1) + 0.0


def non_dominated(points: Matrix) -> Bool[np.ndarray, " design"]:
    """Mask of the points, a row each, that no other dominates: smaller is better, a NaN is worse
    than all; all of several equal points are in it.
    """
    import moocore

    mask = ~np.any(np.isnan(points), axis=1)
    mask[mask] = moocore.is_nondominated(points[mask], keep_weakly=True)
    return mask
