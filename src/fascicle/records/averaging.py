"""The half-way curve of hysteresis loops: both branches averaged, level by level.

A braid rubs: at one pressure a muscle pulls less while it contracts than while it is pulled
out. The quasi-static laws know no friction, and the mean of both branches at the same strain is
the nearest thing to what they describe. How far apart the branches are is kept beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.errors import InvalidInputError
from .record import DOWN, UNKNOWN, UP, Record
from .splitting import Run, runs


_SAME = 5e-3  # of full scale: runs at closer levels are at one
_DENSE = 4  # readings for each point of the grid, from which on a branch is averaged in cells


@dataclass(frozen=True, eq=False)
class Averaged:
    """What averaging gave; the record that it was made of stays as it is.

    - `record`: half-way readings, and those of levels with one branch as they were [-].
    - `width`: force on the way back less that on the way there, at each reading [N]; NaN where
      there was one branch.
    """

    record: Record
    width: np.ndarray


def averaged(record: Record, points: int = 50) -> Averaged:
    """Average the branches of each hysteresis loop.

    At each level both branches are brought to one grid, over the strains (or pressures) that
    both reach, and averaged. A half-way force is clipped where one of its branches is: all that
    is known is that it isn't above. Readings of ramps are left out.

    **Arguments:**

    - `record`: with both branches [-].
    - `points`: readings of a level on the grid at most [-]; fewer where a branch has fewer.

    **Returns:** the half-way record, and the loops' width [-].

    **Raises:** `ValueError` for fewer than two `points`, or where there are no runs.
    """
    if points < 2:
        raise InvalidInputError("points", "must be at least 2", points)
    found = [run for run in runs(record) if run.kind != "mixed"]
    if not found:
        raise InvalidInputError(
            "record", "has no runs at constant pressure or length to average", None
        )
    pieces, widths, pairs = [], [], 0
    for level in _levels(record, found):
        ways = {way: [run for run in level if run.branch == way] for way in (UP, DOWN)}
        loop = _loop(record, ways, points) if ways[UP] and ways[DOWN] else None
        if loop is None:
            kept = record.only(np.concatenate([run.points for run in level]))
            pieces.append(kept)
            widths.append(np.full(len(kept), np.nan))
            continue
        pairs += 1
        pieces.append(loop[0])
        widths.append(loop[1])
    columns = {
        name: np.concatenate([getattr(piece, name) for piece in pieces])
        for name in ("pressure", "strain", "force", "censored", "branch")
    }
    note = f"hysteresis averaged: {pairs} of {len(pieces)} levels have both branches"
    half_way = replace(record, **columns, time=None, notes=(*record.notes, note))
    return Averaged(half_way, np.concatenate(widths))


def _levels(record: Record, found: Sequence[Run]) -> list[list[Run]]:
    """Runs of one kind at one level, together."""
    levels: list[list[Run]] = []
    scales = {"pressure": np.max(np.abs(record.pressure)), "strain": np.ptp(record.strain)}
    for run in sorted(found, key=lambda run: (run.kind, run.level)):
        last = levels[-1][-1] if levels else None
        if (
            last is not None
            and last.kind == run.kind
            and run.level - last.level <= _SAME * scales[run.kind]
        ):
            levels[-1].append(run)
        else:
            levels.append([run])
    return levels


def _loop(
    record: Record, ways: dict[int, list[Run]], points: int
) -> tuple[Record, np.ndarray] | None:
    """The half-way curve of one level, and its width; `None` where the branches don't meet."""
    kind = ways[UP][0].kind
    free, still = ("strain", "pressure") if kind == "pressure" else ("pressure", "strain")
    places = {way: np.concatenate([run.points for run in ways[way]]) for way in (UP, DOWN)}
    swept = {way: getattr(record, free)[places[way]] for way in (UP, DOWN)}
    low = max(float(values.min()) for values in swept.values())
    high = min(float(values.max()) for values in swept.values())
    if not low < high:
        return None
    grid = _grid(swept, low, high, points)
    curves = {
        way: {
            name: _on_grid(grid, swept[way], getattr(record, name)[places[way]].astype(float))
            for name in ("force", "censored", still)
        }
        for way in (UP, DOWN)
    }
    up, down = curves[UP], curves[DOWN]
    arrays = {
        free: grid,
        still: (up[still] + down[still]) / 2,
        "force": (up["force"] + down["force"]) / 2,
        # a neighbor that is clipped makes the point between them no better
        "censored": np.maximum(up["censored"], down["censored"]) > 0,
        "branch": np.full(grid.size, UNKNOWN, dtype=np.int8),
    }
    return replace(record, **arrays, time=None), down["force"] - up["force"]


def _grid(swept: dict[int, np.ndarray], low: float, high: float, points: int) -> np.ndarray:
    inside = {
        way: np.unique(values[(values >= low) & (values <= high)]) for way, values in swept.items()
    }
    shared = np.intersect1d(inside[UP], inside[DOWN])
    fewest = min(values.size for values in inside.values())
    # a table measured at the same strains both ways needs no grid of its own
    if shared.size == fewest <= points:
        return shared
    return np.linspace(low, high, max(min(points, fewest), 2))


def _on_grid(grid: np.ndarray, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """`values` at the `grid`, from readings in any order, noisy ones averaged in cells."""
    if at.size > _DENSE * grid.size:
        edges = (grid[1:] + grid[:-1]) / 2
        cells = np.searchsorted(edges, at)
    else:
        _, cells = np.unique(at, return_inverse=True)
    counts = np.bincount(cells)
    some = counts > 0
    centers = np.bincount(cells, weights=at)[some] / counts[some]
    means = np.bincount(cells, weights=values)[some] / counts[some]
    if centers.size < 2:
        return np.full(grid.size, means[0])
    # the outer cells' means lie inside the grid
    ends = np.array([2 * centers[0] - centers[1], 2 * centers[-1] - centers[-2]])
    beyond = [2 * means[0] - means[1], 2 * means[-1] - means[-2]]
    centers = np.concatenate([ends[:1], centers, ends[1:]])
    return np.interp(grid, centers, np.concatenate([beyond[:1], means, beyond[1:]]))
