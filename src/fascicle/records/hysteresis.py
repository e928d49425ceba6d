"""Hysteresis loops of a record: the half-way curve, and the loops' width.

A braid rubs: at one pressure a muscle pulls less while it contracts than while it is pulled out.
The quasi-static laws know no friction, and the mean of both branches at one strain comes nearest to
what they describe. In use a muscle pulls by half of the loop's width less while it contracts, and
by as much more on the way back: an error of any static law, however well it fits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.errors import InvalidInputError
from .record import COLUMNS, DOWN, UNKNOWN, UP, Record
from .segmentation import Run, runs


_ONE_LEVEL = 5e-3  # of full scale: runs at closer levels, and widths at closer pressures, are one
_DENSE = 4  # readings per point of the grid, from which a branch is averaged in cells
_MOST_WIDTHS = 12  # pressures for which widths are given; of more, neighbors are averaged


@dataclass(frozen=True, eq=False)
class Averaged:
    """A half-way record; the record it was made of stays unchanged.

    - `record`: half-way readings, and those of levels with one branch as they were [SI].
    - `width`: force on the way back less that on the way there, at each reading [N]; NaN at levels
      with one branch.
    """

    record: Record
    width: np.ndarray


@dataclass(frozen=True, eq=False)
class Loop:
    """Widths of hysteresis loops: force on the way back less that on the way there.

    - `pressure`: levels that were measured both ways [Pa], rising.
    - `width`: mean over the loop at each of them [N]; `widest`: the largest there [N].
    - `pull`: the largest half-way force at each of them [N].
    - `half`: root mean square of half the width over all of them [N].
    """

    pressure: np.ndarray
    width: np.ndarray
    widest: np.ndarray
    pull: np.ndarray
    half: float

    @property
    def share(self) -> np.ndarray:
        """Width over the largest half-way force at each pressure [-]."""
        return self.width / np.where(self.pull > 0, self.pull, np.nan)


def averaged(record: Record, points: int = 50) -> Averaged:
    """Average the branches of each hysteresis loop.

    At each level both branches are interpolated on one grid, over the strains (or pressures) that
    both reach, and averaged. A half-way force is censored where one of its branches is. Readings of
    ramps are left out.

    **Arguments:**

    - `record`: readings of both branches [SI].
    - `points`: most readings of a level on the grid [-]; fewer where a branch has fewer.

    **Returns:** the half-way record, and the loops' width [SI].

    **Raises:** `InvalidInputError` for fewer than two `points`, or a record without runs.
    """
    if points < 2:
        raise InvalidInputError("points", "must be at least 2", points)
    segments = [run for run in runs(record) if run.kind != "mixed"]
    if not segments:
        raise InvalidInputError(
            "record", "has no runs at constant pressure or length to average", None
        )
    pieces, widths, loops = [], [], 0
    for level in _group_by_level(record, segments):
        branches = {way: [run for run in level if run.branch == way] for way in (UP, DOWN)}
        loop = _half_way(record, branches, points) if all(branches.values()) else None
        if loop is None:
            piece = record.only(np.concatenate([run.points for run in level]))
            loop = piece, np.full(len(piece), np.nan)
        else:
            loops += 1
        pieces.append(loop[0])
        widths.append(loop[1])
    columns = {name: np.concatenate([getattr(p, name) for p in pieces]) for name in COLUMNS}
    note = f"hysteresis averaged: {loops} of {len(pieces)} levels have both branches"
    half_way = replace(record, **columns, time=None, notes=(*record.notes, note))
    return Averaged(half_way, np.concatenate(widths))


def loop_of(record: Record, half_way: Averaged | None = None) -> Loop | None:
    """Widths of a record's hysteresis loops, pressure by pressure.

    **Arguments:**

    - `record`: readings with known branches [SI].
    - `half_way`: its half-way record [SI]; computed if left out.

    **Returns:** the widths [SI], or `None` for a record without loops.
    """
    if not {UP, DOWN} <= set(np.unique(record.branch).tolist()):
        return None
    try:
        half_way = half_way or averaged(record)
    except ValueError:  # no sweeps in it
        return None
    both = np.isfinite(half_way.width) & ~half_way.record.censored
    if not np.any(both):
        return None
    P, width = half_way.record.pressure[both], half_way.width[both]
    force = half_way.record.force[both]
    top = max(float(P.max()), 1.0)
    order = np.argsort(P, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(P[order]) > _ONE_LEVEL * top) + 1)
    if len(parts) > _MOST_WIDTHS:
        parts = np.array_split(order, _MOST_WIDTHS)
    return Loop(
        pressure=np.array([P[part].mean() for part in parts]),
        width=np.array([width[part].mean() for part in parts]),
        widest=np.array([width[part][np.argmax(np.abs(width[part]))] for part in parts]),
        pull=np.array([force[part].max() for part in parts]),
        half=float(np.sqrt(np.mean((width / 2) ** 2))),
    )


def _group_by_level(record: Record, segments: Sequence[Run]) -> list[list[Run]]:
    """Runs of one kind at one level, together."""
    levels: list[list[Run]] = []
    scales = {"pressure": np.max(np.abs(record.pressure)), "strain": np.ptp(record.strain)}
    for run in sorted(segments, key=lambda run: (run.kind, run.level)):
        last = levels[-1][-1] if levels else None
        reach = _ONE_LEVEL * scales[run.kind]
        if last is not None and last.kind == run.kind and run.level - last.level <= reach:
            levels[-1].append(run)
        else:
            levels.append([run])
    return levels


def _half_way(
    record: Record, branches: dict[int, list[Run]], points: int
) -> tuple[Record, np.ndarray] | None:
    """The half-way curve of one level, and its width; `None` if the branches don't overlap."""
    by_pressure = branches[UP][0].kind == "pressure"
    free, held = ("strain", "pressure") if by_pressure else ("pressure", "strain")
    indices = {way: np.concatenate([run.points for run in branches[way]]) for way in (UP, DOWN)}
    swept = {way: getattr(record, free)[indices[way]] for way in (UP, DOWN)}
    low = max(float(values.min()) for values in swept.values())
    high = min(float(values.max()) for values in swept.values())
    if not low < high:
        return None
    grid = _common_grid(swept, low, high, points)
    up, down = (
        {
            name: _interpolate(grid, swept[way], getattr(record, name)[indices[way]].astype(float))
            for name in ("force", "censored", held)
        }
        for way in (UP, DOWN)
    )
    arrays = {
        free: grid,
        held: (up[held] + down[held]) / 2,
        "force": (up["force"] + down["force"]) / 2,
        # one clipped neighbor is enough to censor the point between them
        "censored": np.maximum(up["censored"], down["censored"]) > 0,
        "branch": np.full(grid.size, UNKNOWN, dtype=np.int8),
    }
    return replace(record, **arrays, time=None), down["force"] - up["force"]


def _common_grid(swept: dict[int, np.ndarray], low: float, high: float, points: int) -> np.ndarray:
    up, down = (np.unique(values[(values >= low) & (values <= high)]) for values in swept.values())
    shared, fewest = np.intersect1d(up, down), min(up.size, down.size)
    # a table measured at the same strains both ways needs no grid of its own
    if shared.size == fewest <= points:
        return shared
    return np.linspace(low, high, max(min(points, fewest), 2))


def _interpolate(grid: np.ndarray, x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """`values` on the `grid`, from readings at `x` in any order, dense ones averaged in cells."""
    if x.size > _DENSE * grid.size:
        cells = np.searchsorted((grid[1:] + grid[:-1]) / 2, x)
    else:
        _, cells = np.unique(x, return_inverse=True)
    counts = np.bincount(cells)
    some = counts > 0
    centers = np.bincount(cells, weights=x)[some] / counts[some]
    means = np.bincount(cells, weights=values)[some] / counts[some]
    if centers.size < 2:
        return np.full(grid.size, means[0])

    def extended(row: np.ndarray) -> np.ndarray:  # the outer cells' means lie inside the grid
        return np.concatenate([[2 * row[0] - row[1]], row, [2 * row[-1] - row[-2]]])

    return np.interp(grid, extended(centers), extended(means))
