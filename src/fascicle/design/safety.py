"""Recommendation of a design that holds its task in most draws, not only as it is drawn.

Designs are judged from the cheapest on: first in a few draws, in which those that fail too often
are dropped, then in all of them. The first that meets the task and all limits in the demanded share
is recommended. If none does, none is: the surest of those that were judged is the nearest.

Limits on objectives that need curves (`reversal_depth`, `overlap_width`) hold for the drawn sizes.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt

import numpy as np

from ..core.array_namespace import slices
from ..core.types import Int
from ..muscle import Muscle
from ..records.dynamometer import Scatter
from .catalog import cheapest_first
from .designs import Designs
from .evaluation import evaluate
from .exhaustive_search import SearchResult
from .objectives import (
    OBJECTIVES,
    Limits,
    check_objectives,
    with_reach_limits,
    within_limits,
)
from .scatter import Safety, Spread, Uncertainty, draw_designs, sample_draws
from .tables import MIXED
from .task import Task


_FEWER_DRAWS = (64, 512)  # drop designs that fail in a third, and in a tenth of the draws
_DEVIATIONS = 4.0  # of the share in few draws, by which it may be too low: 3 of 100 000 more
_TOGETHER = 64  # designs judged in a few draws at once: some 0.1 s
_MOST_REPORTED = 100_000  # reported designs in a draw: some 3 s
_MOST_DRAWN = 400_000  # designs in a draw, over a search: some 12 s
_BATCH = 2**20  # units of designs in all draws that are in memory together: some 100 megabytes
_SLOWER = 8  # how many times as long a draw takes that JAX evaluates by itself


def spread(
    designs: Designs,
    task: Task,
    objectives: tuple[str, ...],
    limits: Limits | None = None,
    scatter: Scatter | None = None,
    muscles: Muscle | None = None,
    draws: int = 200,
    seed: int = 0,
) -> Spread:
    """Spread of designs' objectives under fabrication scatter, model error and uncertain constants.

    **Arguments:**

    - `designs`: any; of one drawing, if `muscles` are given.
    - `task`: what is demanded.
    - `objectives`: by name.
    - `limits`: on objectives, by name [SI], as `search` takes them: all must be reached.
    - `scatter`: of length and braid angle, with a `DesignScatter` also of the wall and of all
      forces; default: none.
    - `muscles`: draws of the calibrated drawing, on the first axis of their numbers [-]; default:
      the drawing itself.
    - `draws`: their number [-], the same for every design.
    - `seed`: random seed.

    **Returns:** values over the draws [SI].

    **Raises:** `ValueError` for `muscles` and designs of several drawings, and unknown objectives.
    """
    limits, scatter = with_reach_limits(limits), Scatter() if scatter is None else scatter
    names = check_objectives([*objectives, *limits], task.scheme)
    sample = sample_draws(scatter, draws, seed)
    if muscles is None:
        indices, blocks = np.arange(len(designs)), []
        for part in slices(len(designs), max(1, _BATCH // (draws * designs.counts.shape[1]))):
            drawn = draw_designs(designs.take(indices[part]), sample)
            factor = np.resize(sample.force, len(drawn))  # all draws of one design after another
            blocks.append(evaluate(drawn, task, names, MIXED, factor))
        values = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    else:
        from .robust import compiled_objectives  # loads JAX

        values = compiled_objectives(designs, task, names, sample, muscles, seed)
    is_within = within_limits(values, limits).reshape(len(designs), draws)
    return Spread({name: row.reshape(is_within.shape) for name, row in values.items()}, is_within)


def judge_safety(result: SearchResult, uncertainty: Uncertainty) -> SearchResult:
    """Recommend the cheapest design that holds the task in most draws.

    **Arguments:**

    - `result`: of a search; one without a recommended design is returned as it is.
    - `uncertainty`: what is drawn, and the share of draws in which a design must hold.

    **Returns:** the result with `safety`; without a recommended design if none holds, the surest
    one is the `nearest` then.

    **Raises:** `ValueError` for draws of a calibrated muscle in a search of several.
    """
    if result.cheapest is None:
        return result
    row, probability, judged, complete = _first_that_holds(result, uncertainty)
    if probability >= uncertainty.share:
        result = replace(result, cheapest=row)
    else:
        result = replace(result, cheapest=None, nearest=row)
    draws = _budget(uncertainty, _MOST_REPORTED) // len(result.reported)
    draws = max(_FEWER_DRAWS[0], min(uncertainty.draws, draws))
    reported = _spread_of_rows(result, result.reported, uncertainty, draws)
    return replace(result, safety=Safety(uncertainty, probability, judged, complete, reported))


def _first_that_holds(
    result: SearchResult, uncertainty: Uncertainty
) -> tuple[int, float, int, bool]:
    """Index of the cheapest design that holds, or of the surest; the share of draws in which it
    does [-], the number of judged designs, and whether these were enough.
    """
    threshold, all_draws = uncertainty.share, uncertainty.draws
    budget = _budget(uncertainty, _MOST_DRAWN)
    judged, surest = 0, (0, 0.0, -1)  # draws, share of them that are met, index
    for block in _blocks(result):
        if budget <= 0:
            break
        rows, positions = block, judged + 1 + np.arange(len(block))
        judged += len(rows)
        for draws in (n for n in _FEWER_DRAWS if n < all_draws):
            probabilities = _spread_of_rows(result, rows, uncertainty, draws, ()).probability
            budget -= draws * len(rows)
            best = int(np.argmax(probabilities))
            surest = max(surest, (draws, float(probabilities[best]), int(rows[best])))
            deviation = sqrt(threshold * (1 - threshold) / draws)
            keep = probabilities >= threshold - _DEVIATIONS * deviation
            rows, positions = rows[keep], positions[keep]
            if not rows.size:
                break
        for row, position in zip(rows, positions, strict=True):
            probability = _spread_of_rows(
                result, row[None], uncertainty, all_draws, ()
            ).probability.item()
            budget -= all_draws
            surest = max(surest, (all_draws, probability, int(row)))
            if probability >= threshold:
                return int(row), probability, int(position), True
    row = surest[2]
    probability = _spread_of_rows(
        result, np.array([row]), uncertainty, all_draws, ()
    ).probability.item()
    return row, probability, judged, judged == int(result.allowed.sum())


def _blocks(result: SearchResult) -> Iterator[Int[np.ndarray, " design"]]:
    """Blocks of designs that do the task as drawn, from the cheapest on: one design at first, since
    the cheapest often holds.
    """
    count = 0
    candidates = np.flatnonzero(result.allowed)
    for group in cheapest_first(candidates, result.values, result.all_designs, result.catalog):
        remaining = group
        while len(remaining):
            block, remaining = np.split(remaining, [min(_TOGETHER, count + 1)])
            count += len(block)
            yield block


def _budget(uncertainty: Uncertainty, count: int) -> int:
    """Number of designs in a draw to evaluate; `count`: if NumPy does it, faster than JAX."""
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
