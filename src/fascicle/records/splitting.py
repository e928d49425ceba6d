"""The runs of a record: the sweeps at one pressure, or at one length, that it is made of.

A record comes as samples in time, with setpoints held and ramps between them, or as a table
whose rows stand in any order. The levels at which pressure and strain were held are found
first, exact ones before noisy ones. Then a run is a stretch of readings at one level in which
the other quantity moves; where the order of the rows says nothing, all readings at a level are
one. Whichever of the two explains more of the record is its protocol.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..core.errors import InvalidInputError
from .levels import held, noise, smoothed
from .record import DOWN, UNKNOWN, UP, Record


_EXACT = 2e-4  # of full scale: how far readings of a level lie apart where there is no noise
_NOISY = (0.008, 0.03)  # of full scale: regulators droop, and levels must stay apart
_DEVIATIONS = 4  # of the noise that stay within a level
_WINDOW = 9  # readings that are smoothed over
_MANY = 200  # readings: fewer are a table, and aren't smoothed
_FEWEST = 3  # readings in a run
_MOVES = 0.1  # of its whole span: the other quantity moves at least so far in a run
_SHORT = 0.005  # of the strain's span: a sweep that short, at a held pressure, is not a dwell
_TURNS = 0.1  # of a run's span: a shorter way back is no branch
_ORDERED = 0.6  # of the readings that lie in stretches where rows are in order
_SORTED = 0.8  # of the readings that are at levels where they aren't
_SECOND = 0.2  # of the readings in runs of the other kind, for them to be meant
_SCRAP = 0.2  # of the usual run's readings: shorter ones are ends of ramps near a level
_TRACED = 4000  # readings that a run's turns are looked for in

Kind = Literal["pressure", "strain"]


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of a record that belong together.

    - `kind`: `"pressure"` or `"strain"`, whichever was held, or `"mixed"` for ramps and
      all else [-].
    - `level`: the median of what was held [Pa] or [-]; NaN where nothing was.
    - `points`: the readings' places in the record, in its order [-].
    - `branch`: 1 contracting or inflating, −1 back, 0 unknown [-].
    """

    kind: Literal["pressure", "strain", "mixed"]
    level: float
    points: np.ndarray
    branch: int


def runs(record: Record, by: str = "auto") -> tuple[Run, ...]:
    """Split a record into its sweeps.

    A hysteresis loop gives a run for each branch: by the record's own branches where it has
    them, else by the direction of the sweep. A sorted table that has no times and never turns
    says nothing of a direction; its branch stays unknown.

    **Arguments:**

    - `record`: of which muscle ever [-].
    - `by`: what was held, `"pressure"` or `"strain"` [-]; `"auto"`, whichever explains more.

    **Returns:** the runs, each reading in just one of them, in the order of their first [-].

    **Raises:** `ValueError` for another `by`.
    """
    held_by: dict[str, tuple[Kind, ...]] = {
        "auto": ("pressure", "strain"), "pressure": ("pressure",), "strain": ("strain",),
    }  # fmt: skip
    if by not in held_by:
        raise InvalidInputError("by", 'must be "auto", "pressure" or "strain"', by)
    if not len(record):
        return ()
    found, ordered = _stretches(record, held_by[by])
    found = [part for run in found for part in _branches(record, run, ordered)]
    if len(record) >= _MANY:
        found = _without_scraps(found)
    if record.time is None and not np.any(record.branch) and _never_turns(found):
        found = [replace(run, branch=UNKNOWN) for run in found]
    left = np.ones(len(record), dtype=bool)
    for run in found:
        left[run.points] = False
    found += [Run("mixed", np.nan, points, UNKNOWN) for points in _parted(np.flatnonzero(left))]
    return tuple(sorted(found, key=lambda run: int(run.points[0])))


def _stretches(record: Record, kinds: Sequence[Kind]) -> tuple[list[Run], bool]:
    """The runs before their branches are told apart; whether the rows' order counted."""
    values: dict[Kind, np.ndarray] = {"pressure": record.pressure, "strain": record.strain}
    other: dict[Kind, Kind] = {"pressure": "strain", "strain": "pressure"}
    scales = {"pressure": float(np.max(np.abs(record.pressure))), "strain": _span(record.strain)}
    width = _WINDOW if len(record) >= _MANY else 1
    smooth = {kind: smoothed(v, width) for kind, v in values.items()}
    # a median of nine leaves 0.42 of the noise
    kept = 0.45 if width > 1 else 1.0
    noisy = {
        kind: float(np.clip(_DEVIATIONS * kept * noise(v), *np.multiply(_NOISY, scales[kind])))
        for kind, v in values.items()
    }
    tries = [
        {kind: held(values[kind], _EXACT * scales[kind]) for kind in kinds},
        {kind: held(smooth[kind], noisy[kind]) for kind in kinds},
    ]
    best: list[Run] = []
    for labels in tries:
        found = {
            kind: _in_order(kind, labels[kind], values[kind], smooth[other[kind]]) for kind in kinds
        }
        first = kinds[int(np.argmax([_readings(found[kind]) for kind in kinds]))]
        chosen = found[first]
        if len(kinds) > 1:
            taken = np.zeros(len(record), dtype=bool)
            for run in chosen:
                taken[run.points] = True
            second = [run for run in found[other[first]] if not taken[run.points].any()]
            chosen = chosen + second * (_readings(second) >= _SECOND * len(record))
        if _readings(chosen) >= _ORDERED * len(record):
            if first == "pressure":
                chosen = chosen + _short_sweeps(record, labels[first], smooth["strain"], chosen)
            return chosen, True
        if _readings(chosen) > _readings(best):
            best = chosen
    for labels in tries:
        for kind in kinds:
            found = _at_levels(kind, labels[kind], values[kind], values[other[kind]])
            if _readings(found) >= _SORTED * len(record):
                return found, False
    return best, True


def _short_sweeps(
    record: Record, labels: np.ndarray, strain: np.ndarray, found: Sequence[Run]
) -> list[Run]:
    """Sweeps at a held pressure that move too little for a run, such as one at zero pressure: they
    are no ramps, and only they show the gauge's zero.
    """
    taken = np.zeros(len(record), dtype=bool)
    for run in found:
        taken[run.points] = True
    runs = _in_order("pressure", labels, record.pressure, strain, _SHORT)
    return [run for run in runs if not taken[run.points].any()]


def _in_order(
    kind: Kind, labels: np.ndarray, values: np.ndarray, free: np.ndarray, share: float = _MOVES
) -> list[Run]:
    """Runs at held `values`, in which the `free` quantity moves by a `share` of its span [-]."""
    labels = _bridged(labels)
    moves = share * _span(free)
    edges = np.flatnonzero(np.diff(labels)) + 1
    starts = np.concatenate([[0], edges])
    stops = np.concatenate([edges, [labels.size]])
    long = (stops - starts >= _FEWEST) & (labels[starts] >= 0)
    found = []
    for start, stop in zip(starts[long], stops[long], strict=True):
        if _span(free[start:stop]) >= moves > 0:
            level = float(np.median(values[start:stop]))
            found.append(Run(kind, level, np.arange(start, stop), UNKNOWN))
    return found


def _at_levels(kind: Kind, labels: np.ndarray, values: np.ndarray, free: np.ndarray) -> list[Run]:
    moves = _MOVES * _span(free)
    order = np.argsort(labels, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
    return [
        Run(kind, float(np.median(values[points])), points, UNKNOWN)
        for points in groups
        if labels[points[0]] >= 0 and points.size >= _FEWEST and _span(free[points]) >= moves > 0
    ]


def _bridged(labels: np.ndarray) -> np.ndarray:
    """Labels with short gaps between readings at the same level closed."""
    places = np.arange(labels.size)
    before = np.maximum.accumulate(np.where(labels >= 0, places, -1))
    after = np.minimum.accumulate(np.where(labels >= 0, places, labels.size)[::-1])[::-1]
    between = (labels < 0) & (before >= 0) & (after < labels.size) & (after - before <= _WINDOW)
    close = between & (labels[before] == labels[np.minimum(after, labels.size - 1)])
    return np.where(close, labels[before], labels)


def _branches(record: Record, run: Run, ordered: bool) -> list[Run]:
    """The run's branches, each a run."""
    told = record.branch[run.points]
    if np.any(told != UNKNOWN):
        if not ordered:
            return [
                replace(run, points=run.points[told == branch], branch=branch)
                for branch in (UP, DOWN, UNKNOWN)
                if np.any(told == branch)
            ]
        parts = np.split(run.points, np.flatnonzero(np.diff(told)) + 1)
        return [replace(run, points=p, branch=int(record.branch[p[0]])) for p in parts]
    if not ordered:
        return [run]
    free = (record.strain if run.kind == "pressure" else record.pressure)[run.points]
    width = _WINDOW if free.size >= _MANY else 1
    free, scatter = smoothed(free, width), noise(free)
    turns = _turns(free, max(_TURNS * _span(free), _DEVIATIONS * scatter))
    parts = np.split(np.arange(free.size), turns)
    ways = [np.sign(free[p[-1]] - free[max(int(p[0]) - 1, 0)]) for p in parts]
    return [
        replace(run, points=run.points[part], branch=UP if way > 0 else DOWN)
        for part, way in zip(parts, ways, strict=True)
    ]


def _turns(values: np.ndarray, least: float) -> np.ndarray:
    """Places at which `values` begin to go the other way, by `least` or more."""
    step = max(values.size // _TRACED, 1)
    traced, turns = values[::step].tolist(), []
    low = high = 0  # where the lowest and the highest so far stand
    first = last = 0  # of the readings at the present extreme: a dwell is halved
    way = 0
    for i, value in enumerate(traced):
        if way == 0:
            low = i if value < traced[low] else low
            high = i if value > traced[high] else high
            if traced[high] - traced[low] >= least:
                way, first, last = (1 if high > low else -1), i, i
        elif way * (value - traced[first]) > 0:
            first = last = i
        elif value == traced[first]:
            last = i
        elif way * (traced[first] - value) >= least:
            turns.append((first + last) // 2 * step + 1)
            way, first, last = -way, i, i
    return np.array(turns, dtype=int)


def _without_scraps(found: Sequence[Run]) -> list[Run]:
    """The runs that aren't much shorter than the one that the middle reading lies in."""
    sizes = np.sort([run.points.size for run in found])
    usual = sizes[np.searchsorted(np.cumsum(sizes), np.sum(sizes) / 2)] if found else 0
    return [run for run in found if run.points.size >= _SCRAP * usual]


def _never_turns(found: Sequence[Run]) -> bool:
    """Whether each level is swept once, and all in one direction."""
    ways = {(run.kind, run.branch) for run in found}
    return len(ways) == len({kind for kind, _ in ways})


def _parted(places: np.ndarray) -> list[np.ndarray]:
    if not places.size:
        return []
    return np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)


def _readings(found: Sequence[Run]) -> int:
    return sum(run.points.size for run in found)


def _span(values: np.ndarray) -> float:
    return float(np.ptp(values))
