"""Hysteresis loops of a record: the half-way curve, and the loops' width.

Friction in the braid lowers a muscle's pull while it contracts, and raises it while it is drawn
out. The quasi-static laws have no friction; the mean of both branches at one strain comes nearest
to them. In use a muscle's force differs from the half-way curve by half of the loop's width: an
error of any static law, however well it fits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.errors import InvalidInputError
from .record import COLUMNS, DOWN, UNKNOWN, UP, Record, note
from .segmentation import Run, runs


_LEVEL_WIDTH = 5e-3  # of full scale: closer runs are at one level, wider than a regulator's drift
_DENSE = 4  # readings per point of the grid: denser ones are averaged, which lowers noise
_MAX_WIDTHS = 12  # pressures in a table of widths; of more, neighbors are averaged


@dataclass(frozen=True, eq=False)
class Averaged:
    """A record of half-way readings.

    - `record`: half-way readings, and unchanged those of levels with one branch.
    - `width`: force of the branch down less that of the branch up, at each reading [N]; NaN at
      levels with one branch. At held lengths either branch may pull harder: the stronger one less
      the other.
    """

    record: Record
    width: np.ndarray


@dataclass(frozen=True, eq=False)
class Loop:
    """Widths of hysteresis loops: force of the branch down less that of the branch up.

    - `pressure`: levels with both branches [Pa], rising.
    - `width`: mean over the loop at each of them [N].
    - `pull`: the largest half-way force at each of them [N].
    - `half`: root mean square of half the width over all of them [N].
    """

    pressure: np.ndarray
    width: np.ndarray
    pull: np.ndarray
    half: float

    @property
    def share(self) -> np.ndarray:
        """Width over the largest half-way force at each pressure [-]."""
        return self.width / np.where(self.pull > 0, self.pull, np.nan)


def averaged(record: Record, points: int = 50) -> Averaged:
    """Average the branches of each hysteresis loop to a half-way curve.

    At each level both branches are interpolated on one grid, over the strains (or pressures) that
    both reach, and averaged. A half-way force is censored where one of its branches is. Readings of
    ramps are left out.

    **Arguments:**

    - `record`: readings of both branches.
    - `points`: largest number of grid points of a level; fewer if a branch has fewer readings.

    **Returns:** the half-way record, and the loops' width.

    **Raises:** `InvalidInputError` for fewer than two `points`, or a record without runs.
    """
    if points < 2:
        raise InvalidInputError("points", "must be at least 2", points)
    segments = [run for run in runs(record) if run.kind != "mixed"]
    if not segments:
        rule = "has no runs at constant pressure or length to average"
        raise InvalidInputError("record", rule, None)
    pieces, widths, isometric, loops = [], [], list[bool](), 0
    levels = group_by_level(record, segments)
    for level in (part for group in levels for part in split_by_file(record, group)):
        branches = {side: [run for run in level if run.branch == side] for side in (UP, DOWN)}
        loop = _half_way(record, branches, points) if all(branches.values()) else None
        loops += loop is not None
        piece = loop[0] if loop else record.only(np.concatenate([run.points for run in level]))
        # a load that hangs leaves the loop to the strains
        is_wide = loop and level[0].kind != "force"
        pieces.append(piece)
        widths.append(loop[1] if loop and is_wide else np.full(len(piece), np.nan))
        isometric += [level[0].kind == "strain"] * len(piece)
    columns = {name: np.concatenate([getattr(p, name) for p in pieces]) for name in COLUMNS}
    finding = note("averaged", loops=loops, levels=len(pieces))
    columns |= {"time": None, "moment_arm": None, "file": None}
    half_way = replace(record, **columns, findings=(*record.findings, finding))
    width, is_isometric = np.concatenate(widths), np.array(isometric)
    if np.nansum(width[is_isometric]) < 0:
        width[is_isometric] *= -1
    return Averaged(half_way, width)


def loop_of(record: Record, half_way: Averaged | None = None) -> Loop | None:
    """Widths of a record's loops by pressure, or `None` without any; `half_way`: its average."""
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
    levels = np.split(order, np.flatnonzero(np.diff(P[order]) > _LEVEL_WIDTH * top) + 1)
    if len(levels) > _MAX_WIDTHS:
        levels = np.array_split(order, _MAX_WIDTHS)
    return Loop(
        pressure=np.array([P[level].mean() for level in levels]),
        width=np.array([width[level].mean() for level in levels]),
        pull=np.array([force[level].max() for level in levels]),
        half=float(np.sqrt(np.mean((width / 2) ** 2))),
    )


def group_by_level(record: Record, segments: Sequence[Run]) -> list[list[Run]]:
    """Runs in groups, each of one kind at about one level, in order of kind and level."""
    levels: list[list[Run]] = []
    scales = {kind: np.max(np.abs(getattr(record, kind))) for kind in ("pressure", "force")}
    scales["strain"] = np.ptp(record.strain)
    for run in sorted(segments, key=lambda run: (run.kind, run.level)):
        last = levels[-1][-1] if levels else None
        reach = _LEVEL_WIDTH * scales[run.kind]
        if last is not None and last.kind == run.kind and run.level - last.level <= reach:
            levels[-1].append(run)
        else:
            levels.append([run])
    return levels


def split_by_file(record: Record, level: Sequence[Run]) -> list[list[Run]]:
    """Runs of a level by file: a loop begins and ends in one, another may have other zeros."""
    if record.file is None:
        return [list(level)]
    files = [int(record.file[run.points[0]]) for run in level]
    return [
        [run for run, index in zip(level, files, strict=True) if index == file]
        for file in dict.fromkeys(files)
    ]


def _half_way(
    record: Record, branches: dict[int, list[Run]], points: int
) -> tuple[Record, np.ndarray] | None:
    """Mean of both branches of one level, and DOWN less UP [N]; `None` without overlap."""
    by_pressure = branches[UP][0].kind == "pressure"
    free, level = ("strain", "pressure") if by_pressure else ("pressure", "strain")
    sides = [record.only(np.concatenate([run.points for run in branches[s]])) for s in (UP, DOWN)]
    swept = [getattr(side, free) for side in sides]
    low, high = max(float(x.min()) for x in swept), min(float(x.max()) for x in swept)
    if not low < high:
        return None
    up, down = (np.unique(x[(x >= low) & (x <= high)]) for x in swept)
    grid, size = np.intersect1d(up, down), min(up.size, down.size)
    # a table with the same strains on both branches has its grid
    if not grid.size == size <= points:
        grid = np.linspace(low, high, max(min(points, size), 2))
    (level_up, F_up, clipped_up), (level_down, F_down, clipped_down) = (
        [_values_on_grid(grid, x, getattr(side, n)) for n in (level, "force", "censored")]
        for side, x in zip(sides, swept, strict=True)
    )
    arrays = {
        free: grid,
        level: (level_up + level_down) / 2,
        "force": (F_up + F_down) / 2,
        # one clipped neighbor is enough to censor the point between them
        "censored": np.maximum(clipped_up, clipped_down) > 0,
        "branch": np.full(grid.size, UNKNOWN, dtype=np.int8),
    }
    return replace(record, **arrays, time=None, moment_arm=None, file=None), F_down - F_up


def _values_on_grid(grid: np.ndarray, x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values on the `grid`, from readings at `x` in any order; dense ones are averaged in cells."""
    values = values.astype(float)
    if x.size > _DENSE * grid.size:
        cells = np.searchsorted((grid[1:] + grid[:-1]) / 2, x)
    else:
        _, cells = np.unique(x, return_inverse=True)
    counts = np.bincount(cells)
    filled = counts > 0
    centers = np.bincount(cells, weights=x)[filled] / counts[filled]
    means = np.bincount(cells, weights=values)[filled] / counts[filled]
    if centers.size < 2:
        return np.full(grid.size, means[0])
    # the outer cells' means lie inside the grid
    x, values = (np.r_[2 * y[0] - y[1], y, 2 * y[-1] - y[-2]] for y in (centers, means))
    return np.interp(grid, x, values)
