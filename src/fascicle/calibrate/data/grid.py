"""A record as a fit sees it: levels of pressure, and the readings at each.

Free strain and collapse depend on pressure alone, so readings at one pressure share them.
Pressures that a transducer scattered are gathered into levels, a long sweep is averaged in even
steps of strain, each branch of a loop by itself. Rows and levels are filled up to a size on a
ladder: a fit then costs one solve for each level, and records of nearly the same size share
what is compiled. What was averaged is remembered, reading by reading (`gathered`).
"""

from dataclasses import dataclass

import equinox as eqx
import numpy as np

from ...core.types import AnyArray, Bool, Float
from ...records.record import Record


WEIGHTS = ("uniform", "level")
_GAP = 0.005  # of the largest pressure: readings closer than this share a level
_WIDEST = 0.02  # of the largest pressure: a level wider than this is a sweep, cut finer
LONGEST = 384  # readings of a level; a longer sweep is averaged
_LEAST = 8  # levels, and readings of a level, that a table has room for

Table = Float[AnyArray, "level reading"]


class Grid(eqx.Module):
    """Readings by level of pressure, in rows of one length.

    - `pressure`: of each level [Pa], as a column; rows without readings repeat the last.
    - `strain`, `force`: of each reading [-], [N].
    - `count`: how many readings are averaged there [-]; 0 where a row is filled up.
    - `censored`: whether the reading only says "not above" [-].
    """

    pressure: Float[AnyArray, "level 1"]
    strain: Table
    force: Float[AnyArray, "*seeds level reading"]
    count: Table
    censored: Bool[AnyArray, "level reading"]

    @property
    def uncensored(self) -> Bool[np.ndarray, "level reading"]:
        """Which places hold a force that was measured [-]."""
        return (np.asarray(self.count) > 0) & ~np.asarray(self.censored)


@dataclass(frozen=True, eq=False)
class Gathered:
    """A record's readings and where each of them went.

    - `data`: the tables [-].
    - `level`, `place`: of each reading in them [-].
    - `branch`: of each place of the tables [-]; `time`: mean of its readings' [s], NaN where
      there is none.
    - `averaged`: how many readings share their place with others [-]; `means`: how many such
      places there are [-].
    """

    data: Grid
    level: np.ndarray
    place: np.ndarray
    branch: np.ndarray
    time: np.ndarray
    averaged: int
    means: int


def grid(record: Record, longest: int = LONGEST) -> Grid:
    """`record` [-] by level of pressure, at most `longest` readings [-] in each."""
    return gathered(record, longest).data


def gathered(record: Record, longest: int = LONGEST) -> Gathered:
    """`record` [-] by level of pressure, at most `longest` readings [-] in each, and where each
    reading went.
    """
    level = level_of(record.pressure)
    order = np.argsort(level, kind="stable")
    rows = np.split(order, np.flatnonzero(np.diff(level[order])) + 1)
    place = np.zeros(len(record), dtype=int)
    for points in rows:
        place[points] = _places(record, points, longest)
    shape = _room(len(rows)), _room(int(place.max()) + 1)
    flat = level * shape[1] + place
    count = np.bincount(flat, minlength=shape[0] * shape[1]).astype(float)

    def mean(values: np.ndarray) -> np.ndarray:
        total = np.bincount(flat, values, minlength=count.size)
        return (total / np.maximum(count, 1)).reshape(shape)

    pressure = np.array([np.mean(record.pressure[points]) for points in rows])
    data = Grid(
        pressure=np.pad(pressure, (0, shape[0] - len(rows)), mode="edge")[:, None],
        strain=mean(record.strain),
        force=mean(record.force),
        count=count.reshape(shape),
        censored=mean(record.censored) > 0.5,
    )
    none = np.full(shape, np.nan)
    return Gathered(
        data, level, place,
        branch=np.round(mean(record.branch)).astype(int),
        time=none if record.time is None else np.where(data.count > 0, mean(record.time), np.nan),
        averaged=int(np.sum(count[count > 1])),
        means=int(np.sum(count > 1)),
    )  # fmt: skip


def trimmed(data: Grid) -> Grid:
    """`data` [-] without the rows and columns that hold nothing."""
    used = np.asarray(data.count) > 0
    rows = int(np.max(np.flatnonzero(used.any(axis=1)))) + 1
    width = int(np.max(np.flatnonzero(used.any(axis=0)))) + 1
    names = ("strain", "force", "count", "censored")
    tables = {name: np.asarray(getattr(data, name))[:rows, :width] for name in names}
    return Grid(np.asarray(data.pressure)[:rows], **tables)


def weighed(data: Grid, weights: str) -> np.ndarray:
    """Weights [-] of residuals, 1 on average."""
    count = np.asarray(data.count)
    some = (count > 0).astype(float)
    if weights == "uniform":
        return some
    total = np.sum(count, axis=1, keepdims=True)
    share = np.sum(total) / (np.sum(total > 0) * np.maximum(total, 1))
    return some * np.sqrt(share)


def level_of(pressure: np.ndarray) -> np.ndarray:
    """The level of each `pressure` [Pa], numbered from the lowest [-]."""
    order = np.argsort(pressure, kind="stable")
    P, top = pressure[order], max(float(np.max(pressure)), 1.0)
    cluster = np.concatenate([[0], np.cumsum(np.diff(P) > _GAP * top)])
    first, last = (
        P[np.searchsorted(cluster, cluster)],
        P[np.searchsorted(cluster, cluster, "right") - 1],
    )
    # a pressure that was swept has no gaps: cut it in steps as fine as a gap
    within = np.where(last - first > _WIDEST * top, np.floor((P - first) / (_GAP * top)), 0.0)
    new = (np.diff(cluster) > 0) | (np.diff(within) != 0)
    levels = np.empty(P.size, dtype=int)
    levels[order] = np.concatenate([[0], np.cumsum(new)])
    return levels


def _places(record: Record, points: np.ndarray, longest: int) -> np.ndarray:
    """The column of each of a level's readings: its own, or that of a step of strain."""
    if points.size <= longest:
        return np.arange(points.size)
    strain = record.strain[points]
    # clipped readings are never averaged with others, nor is one branch with the other
    _, kind = np.unique(
        2 * record.branch[points].astype(int) + record.censored[points], return_inverse=True
    )
    kinds = int(kind.max()) + 1
    steps = max(longest // kinds, 1)
    low, high = strain.min(), strain.max()
    step = np.minimum((steps * (strain - low) / max(high - low, 1e-12)).astype(int), steps - 1)
    return np.unique(kinds * step + kind, return_inverse=True)[1]


def _room(count: int) -> int:
    """The least size on the ladder that holds `count` [-]: 8, 12, 16, 24, 32, 48, …"""
    size = _LEAST
    while size < count:
        size = size * 3 // 2 if size & (size - 1) == 0 else size * 4 // 3
    return size
