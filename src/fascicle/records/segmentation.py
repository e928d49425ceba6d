"""Segmentation of a record into runs: sweeps at one pressure, or at one length.

A record comes as samples in time, with setpoints held and ramps between them, or as a table
whose rows stand in any order. The levels at which pressure and strain were held are found first,
exact ones before noisy ones. A run is then a stretch of readings at one level in which the other
quantity moves; where the order of the rows has no meaning, a run is all readings at a level.
Whichever of pressure and strain explains more of the record is the quantity that was held.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..core.errors import InvalidInputError
from .record import DOWN, UNKNOWN, UP, Record


_EXACT = 2e-4  # of full scale: scatter within a level without noise
_NOISY = (0.008, 0.03)  # of full scale: regulators droop, and levels must stay apart
_DEVIATIONS = 4  # of the noise that stay within a level
_WINDOW = 9  # readings that are smoothed over
_LONG_RECORD = 200  # readings: fewer are a table, and aren't smoothed
_FEWEST = 3  # readings in a run, and at a level
_MOVES = 0.1  # of its whole span: least motion of the other quantity in a run
_SHORT = 0.005  # of the strain's span: a sweep that short, at a held pressure, is not a dwell
_TURNS = 0.1  # of a run's span: a shorter way back is no branch
_ORDERED = 0.6  # of the readings that lie in stretches where rows are in order
_SORTED = 0.8  # of the readings that are at levels where they aren't
_SECOND = 0.2  # of the readings in runs of the other kind, for these to count
_SHORT_SEGMENT = 0.2  # of the usual run's readings: shorter ones are ends of ramps near a level
_TRACED = 4000  # readings in which a run's turns are looked for
_BINS = 8192  # of the histogram in which levels are looked for
_LEVEL_SHARE = 2e-3  # of the record's readings, that a level has at least
_MOST_LEVELS = 1000

Kind = Literal["pressure", "strain"]


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of a record that belong to one sweep.

    - `kind`: the quantity that was held, "pressure" or "strain", or "mixed" for ramps and the rest.
    - `level`: the median of the held quantity [Pa] or [-]; NaN for mixed runs.
    - `points`: the readings' indices in the record, in its order.
    - `branch`: 1 contracting or inflating, −1 back, 0 unknown.
    """

    kind: Literal["pressure", "strain", "mixed"]
    level: float
    points: np.ndarray
    branch: int


def runs(record: Record, by: str = "auto") -> tuple[Run, ...]:
    """Split a record into its sweeps.

    A hysteresis loop gives a run for each branch: by the record's own branches if it has them,
    else by the direction of the sweep. In a sorted table without times that never turns, the
    branch stays unknown.

    **Arguments:**

    - `record`: readings of one muscle [SI].
    - `by`: the held quantity, "pressure" or "strain" [-]; "auto": whichever explains more.

    **Returns:** the runs, each reading in exactly one of them, in the order of their first [SI].

    **Raises:** `InvalidInputError` for another `by`.
    """
    kinds: dict[str, tuple[Kind, ...]] = {
        "auto": ("pressure", "strain"), "pressure": ("pressure",), "strain": ("strain",),
    }  # fmt: skip
    if by not in kinds:
        raise InvalidInputError("by", 'must be "auto", "pressure" or "strain"', by)
    if not len(record):
        return ()
    stretches, ordered = _find_stretches(record, kinds[by])
    segments = [part for run in stretches for part in _split_branches(record, run, ordered)]
    if len(record) >= _LONG_RECORD:
        segments = _drop_short_segments(segments)
    if record.time is None and not np.any(record.branch) and _never_turns(segments):
        segments = [replace(run, branch=UNKNOWN) for run in segments]
    left = np.flatnonzero(~_covered(record, segments))
    gaps = np.split(left, np.flatnonzero(np.diff(left) > 1) + 1) if left.size else []
    segments += [Run("mixed", np.nan, points, UNKNOWN) for points in gaps]
    return tuple(sorted(segments, key=lambda run: int(run.points[0])))


def _find_stretches(record: Record, kinds: Sequence[Kind]) -> tuple[list[Run], bool]:
    """Runs with both branches together, and a flag: the rows' order has a meaning."""
    values: dict[Kind, np.ndarray] = {"pressure": record.pressure, "strain": record.strain}
    other: dict[Kind, Kind] = {"pressure": "strain", "strain": "pressure"}
    scales = {"pressure": float(np.max(np.abs(record.pressure))), "strain": _span(record.strain)}
    width = _WINDOW if len(record) >= _LONG_RECORD else 1
    smooth = {kind: _running_median(v, width) for kind, v in values.items()}
    remaining = 0.45 if width > 1 else 1.0  # a median of nine leaves 0.42 of the noise
    noisy = {
        kind: float(
            np.clip(_DEVIATIONS * remaining * _noise(v), *np.multiply(_NOISY, scales[kind]))
        )
        for kind, v in values.items()
    }
    tries = [
        {kind: assign_levels(values[kind], _EXACT * scales[kind]) for kind in kinds},
        {kind: assign_levels(smooth[kind], noisy[kind]) for kind in kinds},
    ]
    best: list[Run] = []
    for labels in tries:
        stretches = {
            kind: _in_order(kind, labels[kind], values[kind], smooth[other[kind]]) for kind in kinds
        }
        first = max(kinds, key=lambda kind: _count_readings(stretches[kind]))
        chosen = stretches[first]
        if len(kinds) > 1:
            taken = _covered(record, chosen)
            second = [run for run in stretches[other[first]] if not taken[run.points].any()]
            chosen = chosen + second * (_count_readings(second) >= _SECOND * len(record))
        if _count_readings(chosen) >= _ORDERED * len(record):
            if first == "pressure":
                # short sweeps, such as one at zero pressure, are no ramps: they show the gauge's
                # zero
                short = _in_order(first, labels[first], record.pressure, smooth["strain"], _SHORT)
                taken = _covered(record, chosen)
                chosen = chosen + [run for run in short if not taken[run.points].any()]
            return chosen, True
        if _count_readings(chosen) > _count_readings(best):
            best = chosen
    for labels in tries:
        for kind in kinds:
            found = _at_levels(kind, labels[kind], values[kind], values[other[kind]])
            if _count_readings(found) >= _SORTED * len(record):
                return found, False
    return best, True


def _in_order(
    kind: Kind, labels: np.ndarray, values: np.ndarray, free: np.ndarray, share: float = _MOVES
) -> list[Run]:
    """Runs at held `values` in which the `free` quantity moves by a `share` of its span."""
    labels = _bridge_gaps(labels)
    moves = share * _span(free)
    edges = np.flatnonzero(np.diff(labels)) + 1
    starts = np.concatenate([[0], edges])
    stops = np.concatenate([edges, [labels.size]])
    long = (stops - starts >= _FEWEST) & (labels[starts] >= 0)
    return [
        Run(kind, float(np.median(values[start:stop])), np.arange(start, stop), UNKNOWN)
        for start, stop in zip(starts[long], stops[long], strict=True)
        if _span(free[start:stop]) >= moves > 0
    ]


def _at_levels(kind: Kind, labels: np.ndarray, values: np.ndarray, free: np.ndarray) -> list[Run]:
    """Runs of all readings at a level, whatever their order."""
    moves = _MOVES * _span(free)
    order = np.argsort(labels, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
    return [
        Run(kind, float(np.median(values[points])), points, UNKNOWN)
        for points in groups
        if labels[points[0]] >= 0 and points.size >= _FEWEST and _span(free[points]) >= moves > 0
    ]


def _bridge_gaps(labels: np.ndarray) -> np.ndarray:
    """Labels with short gaps between readings at one level closed."""
    indices = np.arange(labels.size)
    before = np.maximum.accumulate(np.where(labels >= 0, indices, -1))
    after = np.minimum.accumulate(np.where(labels >= 0, indices, labels.size)[::-1])[::-1]
    between = (labels < 0) & (before >= 0) & (after < labels.size) & (after - before <= _WINDOW)
    close = between & (labels[before] == labels[np.minimum(after, labels.size - 1)])
    return np.where(close, labels[before], labels)


def _split_branches(record: Record, run: Run, ordered: bool) -> list[Run]:
    """The run's branches, each a run."""
    branches = record.branch[run.points]
    if np.any(branches != UNKNOWN):
        if not ordered:
            return [
                replace(run, points=run.points[branches == branch], branch=branch)
                for branch in (UP, DOWN, UNKNOWN)
                if np.any(branches == branch)
            ]
        parts = np.split(run.points, np.flatnonzero(np.diff(branches)) + 1)
        return [replace(run, points=p, branch=int(record.branch[p[0]])) for p in parts]
    if not ordered:
        return [run]
    free = (record.strain if run.kind == "pressure" else record.pressure)[run.points]
    width = _WINDOW if free.size >= _LONG_RECORD else 1
    free, scatter = _running_median(free, width), _noise(free)
    turns = _turning_points(free, max(_TURNS * _span(free), _DEVIATIONS * scatter))
    parts = np.split(np.arange(free.size), turns)
    rises = [free[part[-1]] > free[max(int(part[0]) - 1, 0)] for part in parts]
    return [
        replace(run, points=run.points[part], branch=UP if rising else DOWN)
        for part, rising in zip(parts, rises, strict=True)
    ]


def _turning_points(values: np.ndarray, least: float) -> np.ndarray:
    """Indices at which `values` begin to go the other way, by `least` or more."""
    step = max(values.size // _TRACED, 1)
    traced, turns = values[::step].tolist(), []
    low = high = 0  # indices of the lowest and the highest so far
    first = last = 0  # of the readings at the present extreme: a dwell is halved
    direction = 0
    for i, value in enumerate(traced):
        if direction == 0:
            low = i if value < traced[low] else low
            high = i if value > traced[high] else high
            if traced[high] - traced[low] >= least:
                direction, first, last = (1 if high > low else -1), i, i
        elif direction * (value - traced[first]) > 0:
            first = last = i
        elif value == traced[first]:
            last = i
        elif direction * (traced[first] - value) >= least:
            turns.append((first + last) // 2 * step + 1)
            direction, first, last = -direction, i, i
    return np.array(turns, dtype=int)


def _drop_short_segments(segments: Sequence[Run]) -> list[Run]:
    """The runs that aren't much shorter than the one that the middle reading lies in."""
    sizes = np.sort([run.points.size for run in segments])
    usual = sizes[np.searchsorted(np.cumsum(sizes), np.sum(sizes) / 2)] if segments else 0
    return [run for run in segments if run.points.size >= _SHORT_SEGMENT * usual]


def _never_turns(segments: Sequence[Run]) -> bool:
    """True if all runs of a kind go in one direction."""
    directions = {(run.kind, run.branch) for run in segments}
    return len(directions) == len({kind for kind, _ in directions})


def _covered(record: Record, segments: Sequence[Run]) -> np.ndarray:
    """Mask of the readings that are in a run."""
    mask = np.zeros(len(record), dtype=bool)
    for run in segments:
        mask[run.points] = True
    return mask


def _count_readings(segments: Sequence[Run]) -> int:
    return sum(run.points.size for run in segments)


def _span(values: np.ndarray) -> float:
    return float(np.ptp(values))


def _running_median(values: np.ndarray, width: int) -> np.ndarray:
    """Running median over `width` readings: noise falls, steps stay where they are."""
    if width < 3 or values.size < width:
        return values
    half = width // 2
    padded = np.pad(values, half, mode="edge")
    out = np.empty_like(values)
    for start in range(0, values.size, 100_000):  # bounds the memory that windows take
        part = padded[start : start + 100_000 + 2 * half]
        windows = np.lib.stride_tricks.sliding_window_view(part, 2 * half + 1)
        out[start : start + windows.shape[0]] = np.median(windows, axis=1)
    return out


def _noise(values: np.ndarray) -> float:
    """Standard deviation of the noise on `values`, from their second differences."""
    if values.size < 4:
        return 0.0
    return 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / 6**0.5


def assign_levels(values: np.ndarray, tolerance: float) -> np.ndarray:
    """Index from 0 of the level at which each of `values` was held, or −1 for none.

    The level with most readings within the `tolerance`, in the values' unit, is found first and
    taken off; and so on, while there are levels with enough readings.
    """
    low, span = float(np.min(values)), _span(values)
    if span <= 2 * tolerance:
        return np.zeros(values.size, dtype=int)
    width = max(span / _BINS, tolerance / 4)
    bins = np.minimum(((values - low) / width).astype(int), int(span / width))
    left = np.bincount(bins, minlength=int(span / width) + 1)
    reach = max(int(tolerance / width), 0)
    least = max(_FEWEST, int(_LEVEL_SHARE * values.size))
    centers: list[float] = []
    for _ in range(_MOST_LEVELS):
        window = np.convolve(left, np.ones(2 * reach + 1, dtype=int), mode="same")
        best = int(np.argmax(window))
        if window[best] < least:
            break
        near = np.arange(max(best - reach, 0), min(best + reach + 1, left.size))
        center = low + width * (0.5 + float(np.average(near, weights=left[near])))
        left[near] = 0
        # the tails of a level found before are no level of their own
        if all(abs(center - other) > 2 * tolerance + width for other in centers):
            centers.append(center)
    if not centers:
        return np.full(values.size, -1)
    ordered = np.sort(centers)
    nearest = np.searchsorted((ordered[1:] + ordered[:-1]) / 2, values)
    inside = np.abs(values - ordered[nearest]) <= tolerance + width
    return np.where(inside, nearest, -1)
