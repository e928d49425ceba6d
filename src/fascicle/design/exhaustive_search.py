"""Exhaustive search of a space: every design's objectives, the Pareto front, and the best design.

A design dominates another if it is at least as good in every objective and better in one. The front
is the set that none dominates; its *hypervolume* is that of the points which it dominates, up to a
reference point that is worse than all. Both are moocore's (López-Ibáñez and others).

Designs that break a limit are left out of the front, not out of the record; to reach the whole
task is a limit that every search has. Recommended is the cheapest design that keeps all limits,
on the front or not. The front's *compromise* is the design whose worst objective, counted from
the front's best (0) to its worst (1), is least bad; on a tie, the least sum. Where no design
reaches the task, none is recommended; the *nearest* misses its worst point by the smallest share of
what is demanded there.

**Safety.** Designs are judged from the cheapest on: first in a few draws, in which those that fail
too often are dropped, then in all of them. The first that meets the task and all limits in the
demanded share is recommended. If none does, none is: the surest of those that were judged is the
nearest.

Limits on objectives that need curves (`reversal_depth`, `overlap_width`) hold for the drawn sizes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import sqrt

import numpy as np

from ..core.types import Bool, Float, Int
from .catalog import Catalog, cheapest
from .cycle import Cycle
from .designs import Designs
from .evaluation import Values, evaluate
from .objectives import (
    OBJECTIVES,
    SHARES,
    Limit,
    Limits,
    Matrix,
    as_minimization,
    check_search,
    non_dominated,
    other_limits,
    reaches_task,
    recorded_objectives,
    with_reach_limits,
    within_limits,
)
from .scatter import Safety, Spread, Uncertainty, spread
from .space import Space
from .task import Task


# usual objectives; depth and resolution tell how well the bundle can be controlled
USUAL = {
    "mean_efficiency": "max",
    "margin": "max",
    "envelope": "min",
    "valves": "min",
}
LEAST_MARGIN = 0.2  # forces of a muscle that isn't tuned are off by tens of percent
_BLOCK = 2**16  # designs computed between two reports of progress, some seconds
_DIGITS = 9  # of shares that are compared: equal ones differ by rounding
_DRAWS = (64, 512)  # are enough for designs that fail in a third, and in a tenth of the draws
_DEVIATIONS = 4.0  # of the share in few draws, by which it may be off: 3 of 100 000 more
_MOST_REPORTED = 100_000  # reported designs in a draw: some 3 s
_MOST_DRAWN = 400_000  # designs in a draw, over a search: some 12 s
_SLOWER = 8  # times as long a draw takes if it has a muscle of its own, as of a calibration


def hypervolume(points: Matrix, reference: Sequence[float] | np.ndarray) -> float:
    """Volume dominated by points, up to a reference.

    **Arguments:**

    - `points`: smaller is better [-], a row each; those beyond the reference don't count.
    - `reference`: worse than what counts [-], one number for each objective.

    **Returns:** the volume [-], product of the objectives' units.
    """
    import moocore

    return float(moocore.hypervolume(points, ref=np.asarray(reference, float)))


def pareto_front(
    values: Values, senses: Mapping[str, str], candidates: Int[np.ndarray, " candidate"]
) -> Int[np.ndarray, " front"]:
    """Indices of the `candidates` that no other dominates, best first in the first objective.

    `values`: objectives of all designs, by name [SI]; `senses`: "min" or "max" by objective.
    """
    points = as_minimization(values, senses)
    front = candidates[non_dominated(points[candidates])]
    return front[np.lexsort((front, *points[front].T[::-1]))]


def nearest(
    values: Values, limits: Limits, permitted: Bool[np.ndarray, " design"] | bool = True
) -> int:
    """Index of the design nearest to the task: with the least `relative_shortfall`, of those that
    keep all other limits if any does; on a tie, of that with the fewest valves.

    `values`: objectives of at least one design [SI]; `permitted`: mask of designs of products that
    may be used.
    """
    keeps_limits = within_limits(values, other_limits(limits)) & permitted
    # of those that miss as much, up to rounding, the one with fewer valves
    keys = (values["valves"], np.round(values["relative_shortfall"], _DIGITS), ~keeps_limits)
    return int(np.lexsort(keys)[0])


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: evaluated designs, their front, and the recommended one.

    - `values`: an array for each objective [SI], over all recorded designs.
    - `index`: of these in the space, -1 if sizes lie between those it lists.
    - `allowed`: mask of those that reach the task and keep all limits.
    - `front`: indices, among the recorded designs, of those that none dominates, best first in the
      first objective.
    - `cheapest`: index of the recommended one, `None` if there is none.
    - `nearest`: index of the one that comes nearest to the task, if none reaches it.
    - `all_designs`: gives designs by these indices.
    - `judged`: number of evaluated designs.
    - `extra`: further objectives to report.
    - `catalog`: products and prices.
    - `least_margin`: relative margin [-] below which the recommended one has a warning.
    - `safety`: judgement in draws of scatter and the model's error, by `judge_safety`, or `None`.
    - `cycle`: for which summaries of designs size valves, or `None`.
    """

    space: Space
    task: Task
    senses: dict[str, str]
    limits: dict[str, Limit]
    index: Int[np.ndarray, " design"]
    values: Values
    allowed: Bool[np.ndarray, " design"]
    front: Int[np.ndarray, " front"]
    cheapest: int | None
    nearest: int | None
    all_designs: Callable[[Int[np.ndarray, " index"]], Designs]
    judged: int
    extra: tuple[str, ...] = ()
    catalog: Catalog = field(default_factory=Catalog)
    least_margin: float = LEAST_MARGIN
    safety: Safety | None = None
    cycle: Cycle | None = None

    @cached_property
    def designs(self) -> Designs:
        """The designs on the front."""
        return self.all_designs(self.front)

    @property
    def points(self) -> Float[np.ndarray, "front objective"]:
        """The front's objectives, turned so that smaller is better [SI]."""
        return as_minimization(self.values, self.senses)[self.front]

    @property
    def recommended(self) -> int | None:
        """Index of the recommended design on the front; `None` if there is none."""
        if self.cheapest is None:
            return None
        return int(np.flatnonzero(self.front == self.cheapest)[0])

    @property
    def compromise(self) -> int | None:
        """Index of the best compromise in the front; `None` if none there is recommendable."""
        if self.cheapest is None:
            return None
        points = self.points
        low, high = points.min(axis=0), points.max(axis=0)
        loss = (points - low) / np.where(high > low, high - low, 1.0)
        return int(np.lexsort((loss.sum(axis=1), np.round(loss.max(axis=1), _DIGITS)))[0])

    @property
    def reaches_task(self) -> Bool[np.ndarray, " design"]:
        """Mask of designs that reach the task, whatever other limits they break."""
        return reaches_task(self.values, self.limits)

    @property
    def excluded_products(self) -> dict[str, str]:
        """Reasons why products must not be used for the task, by the drawing's name."""
        return self.catalog.excluded(self.space.drawings, self.task)

    @property
    def reported_objectives(self) -> tuple[str, ...]:
        """Objectives with a sense or a limit, the extra ones, and the margins."""
        limited = (name for name in self.limits if name not in SHARES)
        names = (*self.senses, *limited, *self.extra, "margin", "relative_margin")
        return tuple(dict.fromkeys(names))

    @cached_property
    def cheapest_with_margin(self) -> int | None:
        """Index of the cheapest design that has the `least_margin` too [-]; `None` if none has."""
        margin = Limit(least=self.least_margin).holds(self.values["relative_margin"])
        front = pareto_front(self.values, self.senses, np.flatnonzero(self.allowed & margin))
        return cheapest(front, self.values, self.all_designs, self.catalog)


def search(
    space: Space,
    task: Task,
    senses: Mapping[str, str] | None = None,
    limits: Limits | None = None,
    extra: tuple[str, ...] = (),
    progress: Callable[[int, int], None] | None = None,
    catalog: Catalog | None = None,
    least_margin: float = LEAST_MARGIN,
) -> SearchResult:
    """Evaluate every design of a space.

    **Arguments:**

    - `space`: the designs.
    - `task`: what is demanded.
    - `senses`: "min" or "max" by objective; default: `USUAL`.
    - `limits`: on objectives, by name [SI]; `not_reached` is the share of the task that may be
      missed, by weight and by points. Default: all of it must be reached.
    - `extra`: objectives to record that don't make the front.
    - `progress`: called with the numbers of evaluated and of all designs [-].
    - `catalog`: products and prices [-]; default: no price is known.
    - `least_margin`: relative margin [-] below which the recommended one has a warning.

    **Returns:** the result.

    **Raises:** `ValueError` for unknown objectives.
    """
    senses = dict(USUAL if senses is None else senses)
    limits = with_reach_limits(limits)
    names = recorded_objectives(senses, limits, extra)
    check_search(senses, limits)
    size = len(space)
    blocks = []
    for start in range(0, size, _BLOCK):
        index = np.arange(start, min(start + _BLOCK, size))
        blocks.append(evaluate(space.at(index), task, names))
        if progress is not None:
            progress(int(index[-1]) + 1, size)
    values = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    return conclude(
        space, task, senses, limits, np.arange(size), values, extra, catalog,
        least_margin=least_margin,
    )  # fmt: skip


def conclude(
    space: Space,
    task: Task,
    senses: Mapping[str, str],
    limits: Limits,
    index: Int[np.ndarray, " design"],
    values: Values,
    extra: tuple[str, ...] = (),
    catalog: Catalog | None = None,
    designs: Designs | None = None,
    judged: int | None = None,
    least_margin: float = LEAST_MARGIN,
) -> SearchResult:
    """Find the front and the recommended design among evaluated designs: the result of a search.

    `index`: of the designs in the space; `values`: their objectives, by name [SI], with those of
    `recorded_objectives`; `designs`: in the order of `values`, if the space doesn't list them;
    `judged`: number of all evaluated designs [-]; default: these; others as of `search`.
    """
    limits, catalog = with_reach_limits(limits), catalog or Catalog()

    def all_designs(rows: Int[np.ndarray, " index"]) -> Designs:
        return space.at(index[rows]) if designs is None else designs.take(rows)

    excluded = catalog.excluded(space.drawings, task)
    kinds = [i for i, name in enumerate(space.drawings) if name in excluded]
    permitted = ~np.isin(space.kind(index), kinds)
    allowed = within_limits(values, limits) & permitted
    front = pareto_front(values, senses, np.flatnonzero(allowed))
    best = cheapest(front, values, all_designs, catalog)
    return SearchResult(
        space, task, dict(senses), limits, index, dict(values), allowed,
        front, best,
        nearest(values, limits, permitted) if best is None and len(index) else None,
        all_designs, len(index) if judged is None else judged, tuple(extra), catalog,
        least_margin,
    )  # fmt: skip


def judge_safety(result: SearchResult, uncertainty: Uncertainty) -> SearchResult:
    """Keep the designs on the front that hold the task in most draws, and recommend one of them.

    A design that is dominated by unsafe ones alone is on the front of the safe ones, so designs are
    judged front by front, without those found unsafe, until all of a front hold.

    **Arguments:**

    - `result`: of a search; one without a recommended design is returned as it is.
    - `uncertainty`: what is drawn, and the share of draws in which a design must hold.

    **Returns:** the result with `safety`, and the front of the safe designs; without a recommended
    design, and with the front as it was, if none holds: the surest one is the `nearest` then.

    **Raises:** `ValueError` for draws of a calibrated muscle in a search of several.
    """
    if result.cheapest is None:
        return result
    candidates, budget, complete = result.allowed.copy(), _budget(uncertainty, _MOST_DRAWN), False
    probability = np.full(len(candidates), np.nan)
    while budget > 0:
        front = pareto_front(result.values, result.senses, np.flatnonzero(candidates))
        new = front[np.isnan(probability[front])]
        if complete := not new.size:
            break
        new = new[: 1 + budget // _DRAWS[0]]
        probability[new], drawn = _probabilities(result, new, uncertainty)
        candidates[new[probability[new] < uncertainty.share]] = False
        budget -= drawn
    safe = np.flatnonzero(probability >= uncertainty.share)
    if safe.size:
        front = pareto_front(result.values, result.senses, safe)
        row = cheapest(front, result.values, result.all_designs, result.catalog)
        assert row is not None
        result = replace(result, cheapest=row, front=front)
    else:
        row = int(np.nanargmax(probability))
        result = replace(result, cheapest=None, nearest=row)
    alone = _spread_of_rows(result, np.array([row]), uncertainty, uncertainty.draws, ())
    draws = _budget(uncertainty, _MOST_REPORTED) // max(1, len(result.front))
    draws = max(_DRAWS[0], min(uncertainty.draws, draws))
    return replace(result, safety=Safety(
        uncertainty, float(alone.probability[0]), int(np.sum(~np.isnan(probability))), safe.size,
        complete, _spread_of_rows(result, result.front, uncertainty, draws),
    ))  # fmt: skip


def _probabilities(
    result: SearchResult, rows: Int[np.ndarray, " design"], uncertainty: Uncertainty
) -> tuple[Float[np.ndarray, " design"], int]:
    """Share of draws in which each design with these `rows` holds [-], from as few draws as tell
    whether it is large enough; and the number of designs in draws that were evaluated.
    """
    share, probability, drawn = uncertainty.share, np.empty(len(rows)), 0
    unclear = np.arange(len(rows))
    for draws in (*(n for n in _DRAWS if n < uncertainty.draws), uncertainty.draws):
        spread = _spread_of_rows(result, rows[unclear], uncertainty, draws, ())
        probability[unclear], drawn = spread.probability, drawn + draws * len(unclear)
        deviation = sqrt(share * (1 - share) / draws)
        unclear = unclear[np.abs(probability[unclear] - share) < _DEVIATIONS * deviation]
        if not unclear.size:
            break
    return probability, drawn


def _budget(uncertainty: Uncertainty, count: int) -> int:
    """Number of designs in a draw to evaluate; `count`: if all draws share their muscles."""
    return count // (1 if uncertainty.muscles is None else _SLOWER)


def _spread_of_rows(
    result: SearchResult,
    rows: Int[np.ndarray, " design"],
    uncertainty: Uncertainty,
    draws: int,
    names: tuple[str, ...] | None = None,
) -> Spread:
    """Spread of the designs with these `rows`; `names` of objectives: default, the recorded."""
    names = tuple(result.values) if names is None else names
    drawn = tuple(name for name in names if OBJECTIVES[name].needs != "curves")
    limits = {n: limit for n, limit in result.limits.items() if OBJECTIVES[n].needs != "curves"}
    return spread(
        result.all_designs(rows), result.task, drawn, limits, uncertainty.scatter,
        uncertainty.muscles, draws,
    )  # fmt: skip
