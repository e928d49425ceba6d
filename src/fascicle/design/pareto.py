r"""What can't be bettered: the non-dominated set, and the volume that it dominates.

A design dominates another if it is at least as good in every objective and better in one.
The front is the set that none dominates. Its *hypervolume* is that of the points which the
front dominates, up to a reference point that is worse than all: it falls if any part of the
front is missing, and so compares two searches by one number.

Here smaller is better; `directed` turns objectives around.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float


Matrix = Float[np.ndarray, "design objective"]
_BLOCK = 512


def directed(
    values: Mapping[str, Float[np.ndarray, " design"]], senses: Mapping[str, str]
) -> Matrix:
    """Objectives as columns in which smaller is better.

    **Arguments:**

    - `values`: an array for each objective [SI].
    - `senses`: "min" or "max" by name [-]; only these objectives are taken.

    **Returns:** a row for each design [SI].

    **Raises:** `ValueError` for an unknown sense.
    """
    for name, sense in senses.items():
        if sense not in ("min", "max"):
            raise ValueError(f"`{name}` must be 'min' or 'max', got {sense!r}.")
    columns = [values[name] if sense == "min" else -values[name] for name, sense in senses.items()]
    return np.stack(columns, axis=1) + 0.0


def non_dominated(points: Matrix) -> Bool[np.ndarray, " design"]:
    """Which points none dominates.

    **Arguments:** `points`: smaller is better [-], a row each; a NaN is worse than all.

    **Returns:** a mask [-]; of equal points all are kept.
    """
    kept = np.zeros(len(points), bool)
    good = np.flatnonzero(~np.any(np.isnan(points), axis=1))
    if not good.size:
        return kept
    unique, inverse = np.unique(points[good], axis=0, return_inverse=True)
    front = _front(unique)
    kept[good] = front[inverse.reshape(-1)]
    return kept


def hypervolume(points: Matrix, reference: Sequence[float] | np.ndarray) -> float:
    """Volume dominated by points, up to a reference.

    **Arguments:**

    - `points`: smaller is better [-], a row each; those beyond the reference don't count.
    - `reference`: worse than what counts [-], one number for each objective.

    **Returns:** the volume [-], product of the objectives' units.
    """
    limit = np.asarray(reference, float)
    inside = points[np.all(points < limit, axis=1)]
    if not len(inside):
        return 0.0
    return _volume(inside[non_dominated(inside)], limit)


def _front(rows: Matrix) -> Bool[np.ndarray, " design"]:
    """Of unlike rows, in lexical order: none is dominated by a later one."""
    front = np.zeros(len(rows), bool)
    found = rows[:0]
    for start in range(0, len(rows), _BLOCK):
        block = rows[start : start + _BLOCK]
        # what dominates one of the block is on the front before it, or in the block
        free = ~_dominated(block, found) if len(found) else np.ones(len(block), bool)
        left = block[free]
        own = ~_dominated(left, left)
        front[start + np.flatnonzero(free)[own]] = True
        found = rows[: start + len(block)][front[: start + len(block)]]
    return front


def _dominated(
    rows: Matrix, by: Float[np.ndarray, "other objective"]
) -> Bool[np.ndarray, " design"]:
    worse = np.zeros(len(rows), bool)
    for start in range(0, len(by), _BLOCK):
        other = by[start : start + _BLOCK]
        better = np.ones((len(rows), len(other)), bool)
        equal = better.copy()
        for column in range(rows.shape[1]):
            mine, theirs = rows[:, None, column], other[None, :, column]
            better &= theirs <= mine
            equal &= theirs == mine
        worse |= np.any(better & ~equal, axis=1)
    return worse


def _volume(front: Matrix, limit: np.ndarray) -> float:
    """By slices along the last objective, each a volume of one objective less."""
    if front.shape[1] == 1:
        return float(limit[0] - front.min())
    if front.shape[1] == 2:
        order = front[np.lexsort((front[:, 1], front[:, 0]))]
        least = np.minimum.accumulate(order[:, 1])
        widths = np.diff(np.append(order[:, 0], limit[0]))
        return float(np.sum(widths * (limit[1] - least)))
    order = front[np.argsort(front[:, -1], kind="stable")]
    heights = np.diff(np.append(order[:, -1], limit[-1]))
    total = 0.0
    for i in np.flatnonzero(heights > 0):
        below = order[: i + 1, :-1]
        total += float(heights[i]) * _volume(below[non_dominated(below)], limit[:-1])
    return total
