"""All designs of a space judged, and what none of them betters.

Designs that break a limit are left out of the front, not out of the record. Of the front one
design is recommended: the one whose worst objective, counted from the front's best (0) to its
worst (1), is least bad; on a tie, the least sum.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from .._checks import one_of
from .designs import Designs
from .judging import Values, evaluate
from .objectives import OBJECTIVES, known
from .pareto import directed, non_dominated
from .space import Space
from .task import Task


_BLOCK = 2**16
MOST = 20_000_000  # designs of one search: their objectives stay in memory


class Limit(NamedTuple):
    """The least and the largest that an objective may be, in its own unit [SI]."""

    least: float = -np.inf
    most: float = np.inf


Limits = Mapping[str, Limit]


@dataclass(frozen=True, eq=False)
class Found:
    """What a search found. `values`: an array for each objective [SI], over all designs that
    were kept; `index` of these in the space [-], -1 where sizes lie between those it lists;
    `allowed`: those within the limits; `front`: places of those that none betters, best first in
    the first objective, and these `designs` themselves; how many were `judged` in all.
    """

    space: Space
    task: Task
    senses: dict[str, str]
    limits: dict[str, Limit]
    index: Int[np.ndarray, " design"]
    values: Values
    allowed: Bool[np.ndarray, " design"]
    front: Int[np.ndarray, " front"]
    designs: Designs
    judged: int

    @property
    def points(self) -> Float[np.ndarray, "front objective"]:
        """The front's objectives, turned so that smaller is better [SI]."""
        return directed(self.values, self.senses)[self.front]

    @property
    def recommended(self) -> int | None:
        """Which place of the front is recommended [-]; `None` if it is empty."""
        if not self.front.size:
            return None
        points = self.points
        low, high = points.min(axis=0), points.max(axis=0)
        share = (points - low) / np.where(high > low, high - low, 1.0)
        return int(np.lexsort((share.sum(axis=1), np.round(share.max(axis=1), 9)))[0])


def search(
    space: Space,
    task: Task,
    senses: Mapping[str, str] | None = None,
    limits: Limits | None = None,
    extra: tuple[str, ...] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Found:
    """Judge every design of a space.

    **Arguments:**

    - `space`: the designs [-].
    - `task`: what is demanded [-].
    - `senses`: "min" or "max" by objective [-]; left out, `USUAL`.
    - `limits`: on objectives, by name [-].
    - `extra`: objectives to record that don't make the front [-].
    - `progress`: told how many designs are done, and of how many [-].

    **Returns:** what was found [-].

    **Raises:** `ValueError` for unknown objectives and a space too large for one search.
    """
    senses = dict(USUAL if senses is None else senses)
    limits = dict(limits or {})
    names = known([*senses, *limits, *extra])
    checked(senses, limits)
    size = len(space)
    if size > MOST:
        raise ValueError(
            f"the space holds {size} designs, more than {MOST}: use `fascicle sweep`, or NSGA-II."
        )
    blocks = []
    for start in range(0, size, _BLOCK):
        index = np.arange(start, min(start + _BLOCK, size))
        blocks.append(evaluate(space.at(index), task, names))
        if progress is not None:
            progress(int(index[-1]) + 1, size)
    values = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    return concluded(space, task, senses, limits, np.arange(size), values)


def concluded(
    space: Space,
    task: Task,
    senses: Mapping[str, str],
    limits: Limits,
    index: Int[np.ndarray, " design"],
    values: Values,
) -> Found:
    """The front of designs that have been judged.

    **Arguments:**

    - `space`: the designs [-].
    - `task`: what is demanded [-].
    - `senses`: "min" or "max" by objective [-].
    - `limits`: on objectives, by name [-].
    - `index`: of the designs in the space [-].
    - `values`: their objectives, by name [SI].

    **Returns:** what was found [-].
    """
    allowed = within_limits(values, limits)
    front = best_first(values, senses, np.flatnonzero(allowed))
    return Found(
        space, task, dict(senses), dict(limits), index, dict(values), allowed, front,
        space.at(index[front]), len(index),
    )  # fmt: skip


def best_first(
    values: Values, senses: Mapping[str, str], places: Int[np.ndarray, " place"]
) -> Int[np.ndarray, " front"]:
    """Those that none betters, best first in the first objective.

    **Arguments:**

    - `values`: objectives of designs, by name [SI].
    - `senses`: "min" or "max" by objective [-].
    - `places`: of the designs that count [-].

    **Returns:** their places [-].
    """
    points = directed(values, senses)
    front = places[non_dominated(points[places])]
    return front[np.lexsort((front, *points[front].T[::-1]))]


def within_limits(values: Values, limits: Limits) -> Bool[np.ndarray, " design"]:
    """Which designs keep all limits; `values` [SI] and `limits` [SI] by objective."""
    size = len(next(iter(values.values())))
    kept = np.ones(size, bool)
    for name, limit in limits.items():
        kept &= (values[name] >= limit.least) & (values[name] <= limit.most)
    return kept


def checked(senses: Mapping[str, str], limits: Limits) -> None:
    """Refuse senses and limits that can't be; both by objective [-]."""
    if not senses:
        raise ValueError("`objectives` must name at least one, got none.")
    for name, sense in senses.items():
        one_of(sense, ("min", "max"), name)
    for name, limit in limits.items():
        if not limit.least <= limit.most:
            unit = OBJECTIVES[name].unit
            raise ValueError(
                f"`{name}` is limited to at least {limit.least:g} and at most {limit.most:g}"
                f" {unit}: nothing can be both."
            )


# what most tasks are about; depth and resolution tell how well the bundle can be controlled
USUAL = {
    "mean_efficiency": "max",
    "not_reached": "min",
    "envelope": "min",
    "valves": "min",
}
