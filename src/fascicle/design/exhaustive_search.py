"""Exhaustive search of a space: every design's objectives, the Pareto front, and what to offer.

A design dominates another if it is at least as good in every objective and better in one; where all
prices are known, the price of muscles and valves is an objective, too. The front is the set that
none dominates, found by moocore (López-Ibáñez and others).

Designs that break a limit, or miss a part of the task, are left out of the front, not out of the
record. Where none reaches the task, the *nearest* misses its worst point by the smallest share of
what is demanded there.

**Offers**, each from the front: the *cheapest*, if prices are known; the *simplest*, with the
fewest valves; the *most efficient*; and the *compromise*, whose worst objective, counted from the
front's best (0) to its worst (1), is least bad, on a tie the least sum. Of equal designs the one
with the least volume of muscles is offered. Recommended is the cheapest, without prices the
compromise.

**Safety.** Designs are judged front by front, without those found unsafe, until all designs of a
front hold the task and all limits in the demanded share of random draws. If none holds, none is
recommended: the surest of those that were judged is the nearest. Limits on objectives that need
curves (`reversal_depth`, `overlap_width`) hold for the drawn sizes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..core.array_namespace import slices
from ..core.types import Bool, Float, Int
from . import objectives
from .cycle import Cycle
from .designs import Designs
from .evaluation import Values, evaluate
from .objectives import OBJECTIVES, Limit, Limits, Matrix, other_limits, with_reach_limits
from .scatter import Safety, Spread, Uncertainty, spread
from .space import Catalog, Space
from .task import Task


USUAL = {"mean_efficiency": "max", "envelope": "min", "valves": "min"}  # usual objectives
LEAST_MARGIN = 0.2  # forces of a muscle that isn't tuned are off by tens of percent
_BLOCK = 2**16  # designs computed between two reports of progress, some seconds
_DIGITS = 9  # of shares and sizes that are compared: equal ones differ by rounding
_DRAWS = (64, 512)  # are enough for designs that fail in a third, and in a tenth of the draws
_DEVIATIONS = 4.0  # of the share in few draws, by which it may be off: 3 of 100 000 more
_MOST_REPORTED = 50_000  # reported designs in a draw, a part of a second
_MOST_DRAWN = 400_000  # designs in a draw, over a search: some 12 s
_SLOWER = 8  # times as long a draw takes if it has a muscle of its own, as of a calibration

Rows = Int[np.ndarray, " row"]


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: evaluated designs, their front, and what is offered of it.

    - `values`: an array for each objective [SI], over all recorded designs.
    - `index`: of these in the space, -1 if sizes lie between those it lists; then `unlisted` has
      them.
    - `allowed`: mask of those that reach the task and keep all limits.
    - `front`: indices of the recorded designs that none dominates, best first in the first
      objective; if none is safe, of nominal sizes.
    - `nearest`: index of the one that comes nearest to the task, or that is surest, if none is
      recommended.
    - `judged`: number of evaluated designs; `extra`: further objectives to report.
    - `safety`: judgement in draws of scatter and the model's error, by `judge_safety`, or `None`.
    - `catalog`, `least_margin` [-]: as of `search`; `cycle`: for which valves are sized, or `None`.
    """

    space: Space
    task: Task
    senses: dict[str, str]
    limits: dict[str, Limit]
    index: Rows
    values: Values
    allowed: Bool[np.ndarray, " design"]
    front: Rows
    nearest: int | None
    judged: int
    extra: tuple[str, ...] = ()
    catalog: Catalog = field(default_factory=Catalog)
    least_margin: float = LEAST_MARGIN
    unlisted: Designs | None = None
    safety: Safety | None = None
    cycle: Cycle | None = None

    def all_designs(self, rows: Rows) -> Designs:
        """Recorded designs, by their indices."""
        if self.unlisted is not None:
            return self.unlisted.take(rows)
        return self.space.at(self.index[rows])

    @cached_property
    def designs(self) -> Designs:
        """The designs on the front."""
        return self.all_designs(self.front)

    def _points_of(self, rows: Rows) -> Matrix:
        """Objectives of recorded designs, and the price if it is known; smaller is better [SI]."""
        points = objectives.as_minimization(self.values, self.senses)[rows]
        if not self.catalog.is_priced(self.space.drawings):
            return points
        return np.column_stack([points, self.catalog.price(self.all_designs(rows))])

    @property
    def points(self) -> Matrix:
        """The front's objectives, and the price if it is known, smaller is better [SI]."""
        return self._points_of(self.front)

    def pareto_front(self, candidates: Rows) -> Rows:
        """Indices of the `candidates` that no other dominates, best first in the first objective;
        of equal ones the smallest, of these the one with the largest margin.
        """
        points = _without_noise(self._points_of(candidates))
        mask = objectives.non_dominated(points)
        front, points = candidates[mask], points[mask]
        margin, size = self.values["relative_margin"][front], _without_noise(self._sizes(front))
        order = np.lexsort((front, -margin, size, *points.T[::-1]))
        differs = np.any(np.diff(points[order], axis=0, prepend=np.nan) != 0, axis=1)
        return front[order][differs]

    def _sizes(self, rows: Rows) -> Float[np.ndarray, " design"]:
        """Volume of all muscles at rest, over π [m³]."""
        designs = self.all_designs(rows)
        return designs.length * np.sum(designs.counts * designs.radius**2, axis=1)

    @cached_property
    def offers(self) -> dict[str, int]:
        """Index on the front of the design "cheapest", "simplest", …; the first is recommended."""
        if self.nearest is not None or not self.front.size:
            return {}
        points = self.points
        low, high = points.min(axis=0), points.max(axis=0)
        loss = (points - low) / np.where(high > low, high - low, 1.0)
        size, muscles = self._sizes(self.front), self.designs.counts.sum(axis=1)
        # the last key counts first; of equal ones the smallest
        keys = {
            "compromise": (size, loss.sum(axis=1), loss.max(axis=1)),
            "simplest": (muscles, size, self.values["valves"][self.front]),
            "most efficient": (size, -self.values["mean_efficiency"][self.front]),
        }
        if self.catalog.is_priced(self.space.drawings):
            price = self.catalog.price(self.designs)
            keys = {"cheapest": (loss.sum(axis=1), size, price)} | keys
        return {n: int(np.lexsort([*map(_without_noise, key)])[0]) for n, key in keys.items()}

    @property
    def recommended(self) -> int | None:
        """Index of the recommended design on the front; `None` if there is none."""
        return next(iter(self.offers.values()), None)

    @property
    def best(self) -> int | None:
        """Index of the recommended design among the recorded ones; `None` if there is none."""
        return None if self.recommended is None else int(self.front[self.recommended])

    @property
    def reaches_task(self) -> Bool[np.ndarray, " design"]:
        """Mask of designs that reach the task, whatever other limits they break."""
        return objectives.reaches_task(self.values, self.limits)

    @property
    def reported_objectives(self) -> tuple[str, ...]:
        """Objectives with a sense or a limit, the extra ones, and the relative margin."""
        names = (*self.senses, *other_limits(self.limits), *self.extra, "relative_margin")
        return tuple(dict.fromkeys(names))


def _without_noise(values: np.ndarray) -> np.ndarray:
    """The `values` over the largest of their column [-], rounded: equal ones compare as equal."""
    scale = np.where(np.isfinite(values), np.abs(values), 0.0).max(axis=0, initial=0.0)
    return np.round(values / np.where(scale > 0, scale, 1.0), _DIGITS)


def search(
    space: Space,
    task: Task,
    senses: Mapping[str, str] | None = None,
    limits: Limits | None = None,
    extra: tuple[str, ...] = (),
    progress: Callable[[int, int], None] = lambda *_: None,
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

    **Raises:** `ValueError` for unknown objectives.
    """
    senses, limits = USUAL if senses is None else senses, with_reach_limits(limits)
    names, size, blocks = objectives.recorded_objectives(senses, limits, extra), len(space), []
    for block in slices(size, _BLOCK):
        index = np.arange(size)[block]
        blocks.append(evaluate(space.at(index), task, names))
        progress(int(index[-1]) + 1, size)
    values = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    return conclude(space, task, senses, limits, values, extra, catalog, least_margin)


def conclude(
    space: Space,
    task: Task,
    senses: Mapping[str, str],
    limits: Limits,
    values: Values,
    extra: tuple[str, ...] = (),
    catalog: Catalog | None = None,
    least_margin: float = LEAST_MARGIN,
    designs: Designs | None = None,
    judged: int | None = None,
) -> SearchResult:
    """Result of a search: the front among evaluated designs.

    `values`: their objectives [SI], with those of `recorded_objectives`; `designs`: in the order of
    `values`; default: those of the space; `judged`: number of all evaluated designs [-]; default:
    these; others as of `search`.
    """
    limits, catalog = with_reach_limits(limits), catalog or Catalog()
    index = np.arange(len(space)) if designs is None else np.full(len(designs), -1)
    excluded = catalog.excluded(space.drawings, task)
    kind = index // (len(space) // len(space.drawings)) if designs is None else designs.kind
    permitted = np.array([name not in excluded for name in space.drawings])[kind]
    allowed, nearest = objectives.within_limits(values, limits) & permitted, None
    if not allowed.any() and len(index):
        keeps_limits = objectives.within_limits(values, other_limits(limits)) & permitted
        # of those that miss as much, up to rounding, the one with fewer valves
        misses = np.round(values["relative_shortfall"], _DIGITS)
        nearest = int(np.lexsort((values["valves"], misses, ~keeps_limits))[0])
    result = SearchResult(
        *(space, task, dict(senses), limits, index, dict(values), allowed, np.arange(0), nearest),
        *(judged or len(index), tuple(extra), catalog, least_margin, designs),
    )
    return replace(result, front=result.pareto_front(np.flatnonzero(allowed)))


def judge_safety(result: SearchResult, uncertainty: Uncertainty) -> SearchResult:
    """Result of a search with `safety`, and the front of the designs that hold the task in most
    draws of an `uncertainty`; if none holds, the front as it was, and the surest as the `nearest`.
    One without a recommended design is returned as it is.

    **Raises:** `ValueError` for draws of a calibrated muscle in a search of several.
    """
    if not result.front.size:
        return result
    slower = 1 if uncertainty.muscles is None else _SLOWER
    candidates, budget, complete = result.allowed.copy(), _MOST_DRAWN // slower, False
    probability = np.full(len(candidates), np.nan)

    def judge(rows: Rows, draws: int) -> Spread:
        return _spread_of_rows(result, rows, uncertainty, draws, ())

    while budget > 0:
        front = result.pareto_front(np.flatnonzero(candidates))
        new = front[np.isnan(probability[front])]
        if complete := not new.size:
            break
        new = new[: 1 + budget // _DRAWS[0]]
        probability[new], drawn = staged_probabilities(new, uncertainty, judge)
        candidates[new[probability[new] < uncertainty.share]] = False
        budget -= drawn
    safe = np.flatnonzero(probability >= uncertainty.share)
    unsafe = np.where(probability < uncertainty.share, probability, np.nan)
    surest = None if np.all(np.isnan(unsafe)) else int(np.nanargmax(unsafe))
    changed = {"front": result.pareto_front(safe)} if safe.size else {"nearest": surest}
    result = replace(result, **changed)
    row = np.array([result.nearest if result.best is None else result.best])
    alone = _spread_of_rows(result, row, uncertainty, uncertainty.draws, ("relative_margin",))
    draws = max(_DRAWS[0], min(uncertainty.draws, _MOST_REPORTED // slower // len(result.front)))
    reported = _spread_of_rows(result, result.front, uncertainty, draws, tuple(result.values))
    judged, share = int(np.sum(~np.isnan(probability))), float(alone.probability[0])
    low_margin = float(alone.quantile(0.05)["relative_margin"][0])
    nearest_share = np.nan if surest is None else float(probability[surest])
    safety = Safety(
        uncertainty, share, low_margin, judged, complete, reported, surest, nearest_share
    )
    return replace(result, safety=safety)


def staged_probabilities(
    rows: Rows, uncertainty: Uncertainty, judge: Callable[[Rows, int], Spread]
) -> tuple[Float[np.ndarray, " design"], int]:
    """Share of draws in which each design holds [-], from as few draws as tell whether it is large
    enough, and the number of designs in draws that were evaluated; `judge`: spread of the designs
    of some `rows` in a number of draws.
    """
    share, probability, drawn = uncertainty.share, np.empty(len(rows)), 0
    unclear = np.arange(len(rows))
    for draws in (*(n for n in _DRAWS if n < uncertainty.draws), uncertainty.draws):
        probability[unclear] = judge(rows[unclear], draws).probability
        drawn += draws * len(unclear)
        deviation = np.sqrt(share * (1 - share) / draws)
        unclear = unclear[np.abs(probability[unclear] - share) < _DEVIATIONS * deviation]
        if not unclear.size:
            break
    return probability, drawn


def _spread_of_rows(
    result: SearchResult, rows: Rows, uncertainty: Uncertainty, draws: int, names: tuple[str, ...]
) -> Spread:
    """Spread of the designs with these `rows`; `names` of objectives, but those with curves."""
    drawn = tuple(name for name in names if OBJECTIVES[name].needs != "curves")
    limits = {n: limit for n, limit in result.limits.items() if OBJECTIVES[n].needs != "curves"}
    designs, task = result.all_designs(rows), result.task
    scatter, muscles = uncertainty.scatter, uncertainty.muscles
    return spread(designs, task, drawn, limits, scatter, muscles, draws)
