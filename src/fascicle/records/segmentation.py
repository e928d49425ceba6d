"""Segmentation of a record into runs: sweeps at one pressure, at one length, or under one load.

A record comes as samples in time, with constant setpoints and ramps between them, or as a table
with rows in any order. First the levels of pressure and strain are found, exact ones before noisy
ones. A run is then a stretch of readings at one level in which the other quantity moves; in a table
without order, a run is all readings at a level. The quantity that explains more of the record,
pressure or strain, is the constant one; a record that neither explains may have constant forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from .record import DOWN, UNKNOWN, UP, Record


_EXACT = 2e-4  # of full scale: scatter within a level without noise
_LEAST_SPAN = 0.02  # of strain: what spans less is one length with noise of a gauge
_NOISY = (0.008, 0.03)  # of full scale: regulators droop, and levels must stay apart
_WHITE = 1.5  # standard deviation over that of the noise: more is no constant
_DEVIATIONS = 4  # of the noise that stay within a level
_WINDOW = 9  # readings that are smoothed over
_LONG_RECORD = 200  # readings: fewer are a table, and aren't smoothed
_MIN_READINGS = 3  # in a run, and at a level: fewer show no motion
_MIN_MOTION = 0.1  # of its whole span: least motion of the other quantity in a run
_SHORT = 0.005  # of the strain's span: shorter sweeps at a pressure are dwells
_MIN_RETURN = 0.1  # of a run's span: a shorter way back is no branch
_ORDERED = 0.6  # of the readings that lie in stretches where rows are in order
_SORTED = 0.8  # of the readings that are at levels where they aren't
_MIN_SECOND = 0.2  # of the readings in runs of the other kind, for these to count
_SHORT_SEGMENT = 0.2  # of the usual run's readings: shorter ones are ends of ramps near a level
_MAX_TRACED = 4000  # readings of a run that are searched for turns: resolves a branch
_BINS = 8192  # of the histogram of levels: finer than the noise of transducers
_LEVEL_SHARE = 2e-3  # of the record's readings, that a level has at least
_MAX_LEVELS = 1000  # more are ramps

Kind = Literal["pressure", "strain", "force"]
_SWEPT: dict[Kind, Kind] = {"pressure": "strain", "strain": "pressure", "force": "pressure"}


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of a record that belong to one sweep.

    - `kind`: the constant quantity, "pressure", "strain" or "force", or "mixed" for ramps and the
      like.
    - `level`: median of the constant quantity [SI]; NaN for mixed runs.
    - `points`: the readings' indices in the record, in its order.
    - `branch`: 1 contracting or inflating, −1 back, 0 unknown.
    """

    kind: Literal["pressure", "strain", "force", "mixed"]
    level: float
    points: np.ndarray
    branch: int


def runs(record: Record) -> tuple[Run, ...]:
    """Split a record into its sweeps.

    The constant quantity is pressure or strain, whichever explains more, or force where neither
    does. A hysteresis loop gives a run for each branch: by the record's own branches if it has
    them, else by the direction of the sweep. In a sorted table without times that never turns, the
    branch stays unknown.

    **Arguments:** `record`: readings of one muscle.

    **Returns:** the runs, each reading in exactly one of them, in the order of their first reading.
    """
    if not len(record):
        return ()
    stretches, ordered = _find_stretches(record, ("pressure", "strain"))
    is_explained = _count_readings(stretches) >= _ORDERED * len(record)
    if not (ordered and is_explained):
        isotonic, in_order = _find_stretches(record, ("force",))
        # masses of a set, each at the same pressures, are levels of pressure in no order, too
        is_better = in_order or not is_explained
        if is_better and _count_readings(isotonic) >= _SORTED * len(record):
            stretches, ordered = isotonic, in_order
    segments = [branch for run in stretches for branch in _split_branches(record, run, ordered)]
    if len(record) >= _LONG_RECORD and segments:
        # ends of ramps near a level are shorter than the run of the middle reading
        sizes = np.sort([run.points.size for run in segments])
        usual = sizes[np.searchsorted(np.cumsum(sizes), np.sum(sizes) / 2)]
        segments = [run for run in segments if run.points.size >= _SHORT_SEGMENT * usual]
    directions = {(run.kind, run.branch) for run in segments}
    has_turns = len(directions) > len({kind for kind, _ in directions})
    if record.time is None and not np.any(record.branch) and not has_turns:
        segments = [replace(run, branch=UNKNOWN) for run in segments]
    outside = np.flatnonzero(~_covered(record, segments))
    gaps = np.split(outside, np.flatnonzero(np.diff(outside) > 1) + 1) if outside.size else []
    segments += [Run("mixed", np.nan, points, UNKNOWN) for points in gaps]
    return tuple(sorted(segments, key=lambda run: int(run.points[0])))


def _find_stretches(record: Record, kinds: Sequence[Kind]) -> tuple[list[Run], bool]:
    """Sweeps at levels of one or two of the `kinds`, and true if they follow the rows' order."""
    values: dict[Kind, np.ndarray] = {kind: getattr(record, kind) for kind in _SWEPT}
    scales = {kind: float(np.max(np.abs(x))) for kind, x in values.items()}
    scales["strain"] = max(float(np.ptp(record.strain)), _LEAST_SPAN)
    smooth = {kind: _running_median(x) for kind, x in values.items()}
    # a median of nine leaves 0.42 of the noise
    noise_share = 0.45 if len(record) >= _LONG_RECORD else 1.0
    noisy = {
        kind: np.clip(_DEVIATIONS * noise_share * _noise(x), *np.multiply(_NOISY, scales[kind]))
        for kind, x in values.items()
    }
    labelings = [
        {kind: find_levels(values[kind], _EXACT * scales[kind]) for kind in kinds},
        {kind: find_levels(smooth[kind], float(noisy[kind])) for kind in kinds},
    ]
    narrow = [kind for kind in kinds if np.ptp(values[kind]) <= 2 * _NOISY[0] * scales[kind]]
    if kinds == ("force",) and np.std(record.force) <= _WHITE * _noise(record.force):
        narrow = list(kinds)  # no load, whose only scale is the noise of the load cell
    for kind in narrow:  # one level, unless each reading has an exact one
        if np.any(labelings[0][kind] < 0):
            labelings[0][kind] = np.zeros(len(record), dtype=int)
    best: list[Run] = []
    for labels in labelings:
        stretches = {
            kind: _ordered_runs(kind, labels[kind], values[kind], smooth[_SWEPT[kind]])
            for kind in kinds
        }
        first = max(kinds, key=lambda kind: _count_readings(stretches[kind]))
        stretch = stretches[first]
        if len(kinds) > 1:
            second = _outside(record, stretch, stretches[_SWEPT[first]])
            if _count_readings(second) >= _MIN_SECOND * len(record):
                stretch = stretch + second
        if _count_readings(stretch) >= _ORDERED * len(record):
            if first == "pressure":
                # short sweeps, as at zero pressure, are no ramps: they show the gauge's zero
                free = smooth["strain"]
                short = _ordered_runs(first, labels[first], record.pressure, free, _SHORT)
                stretch = stretch + _outside(record, stretch, short)
            return stretch, True
        if _count_readings(stretch) > _count_readings(best):
            best = stretch
    for labels in labelings:
        for kind in kinds:
            order, free = np.argsort(labels[kind], kind="stable"), values[_SWEPT[kind]]
            sweeps = _runs_of(kind, order, labels[kind], values[kind], free, _MIN_MOTION)
            if _count_readings(sweeps) >= _SORTED * len(record):
                return sweeps, False
    return best, True


def _ordered_runs(
    kind: Kind,
    labels: np.ndarray,
    values: np.ndarray,
    free: np.ndarray,
    motion: float = _MIN_MOTION,
) -> list[Run]:
    """Runs of consecutive readings at one level, short gaps closed, in which `free` moves."""
    indices = np.arange(labels.size)
    before = np.maximum.accumulate(np.where(labels >= 0, indices, -1))
    after = np.minimum.accumulate(np.where(labels >= 0, indices, labels.size)[::-1])[::-1]
    gap = (labels < 0) & (before >= 0) & (after < labels.size) & (after - before <= _WINDOW)
    gap &= labels[before] == labels[np.minimum(after, labels.size - 1)]
    return _runs_of(kind, indices, np.where(gap, labels[before], labels), values, free, motion)


def _runs_of(
    kind: Kind, order: np.ndarray, labels: np.ndarray, values: np.ndarray, free: np.ndarray,
    motion: float,
) -> list[Run]:  # fmt: skip
    """Runs of one label in the `order` of rows; `free` moves by `motion` times its span in them."""
    groups = np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)
    min_motion = motion * np.ptp(free)
    return [
        Run(kind, float(np.median(values[points])), points, UNKNOWN)
        for points in groups
        if labels[points[0]] >= 0
        and points.size >= _MIN_READINGS
        and np.ptp(free[points]) >= min_motion > 0
    ]


def _split_branches(record: Record, run: Run, ordered: bool) -> list[Run]:
    """The run's branches, each a run."""
    points, branches = run.points, record.branch[run.points]
    if np.any(branches != UNKNOWN):
        order = np.arange(points.size) if ordered else np.argsort(branches, kind="stable")
        pieces = np.split(points[order], np.flatnonzero(np.diff(branches[order])) + 1)
        return [replace(run, points=piece, branch=int(record.branch[piece[0]])) for piece in pieces]
    if not ordered:
        return [run]
    free = (record.strain if run.kind == "pressure" else record.pressure)[points]
    free, noise = _running_median(free), _noise(free)
    edges = _turning_points(free, max(_MIN_RETURN * np.ptp(free), _DEVIATIONS * noise))
    starts, ends = [0, *(edges - 1)], [*(edges - 1), free.size - 1]
    rises = free[ends] > free[starts]
    return [
        replace(run, points=piece, branch=UP if rising else DOWN)
        for piece, rising in zip(np.split(points, edges), rises, strict=True)
    ]


def _turning_points(values: np.ndarray, threshold: float) -> np.ndarray:
    """Indices at which `values` turn back, by the `threshold` or more."""
    step = max(values.size // _MAX_TRACED, 1)
    traced, indices = values[::step].tolist(), []
    low = high = 0  # indices of the lowest and the highest so far
    first = last = 0  # of the readings at the present extreme: a dwell is halved
    direction = 0
    for i, value in enumerate(traced):
        if direction == 0:
            low = i if value < traced[low] else low
            high = i if value > traced[high] else high
            if traced[high] - traced[low] >= threshold:
                direction, first, last = (1 if high > low else -1), i, i
        elif direction * (value - traced[first]) > 0:
            first = last = i
        elif value == traced[first]:
            last = i
        elif direction * (traced[first] - value) >= threshold:
            indices.append((first + last) // 2 * step + 1)
            direction, first, last = -direction, i, i
    return np.array(indices, dtype=int)


def _outside(record: Record, segments: Sequence[Run], candidates: Sequence[Run]) -> list[Run]:
    """Candidates that share no reading with the `segments`."""
    covered = _covered(record, segments)
    return [run for run in candidates if not covered[run.points].any()]


def _covered(record: Record, segments: Sequence[Run]) -> np.ndarray:
    """Mask of the readings that are in a run."""
    mask = np.zeros(len(record), dtype=bool)
    for run in segments:
        mask[run.points] = True
    return mask


def _count_readings(segments: Sequence[Run]) -> int:
    """Number of readings in all runs."""
    return sum(run.points.size for run in segments)


def _running_median(values: np.ndarray) -> np.ndarray:
    """Running median of many readings: noise falls, steps stay where they are."""
    if values.size < _LONG_RECORD:
        return values
    from scipy.ndimage import median_filter

    return median_filter(values, _WINDOW, mode="nearest")


def _noise(values: np.ndarray) -> float:
    """Standard deviation of the noise on `values`, from their second differences."""
    if values.size < 4:
        return 0.0
    # 1.4826: from the median of a normal distribution; √6: of the sum of 1, −2, 1
    return 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / 6**0.5


def find_levels(values: np.ndarray, tolerance: float) -> np.ndarray:
    """Index from 0 of the level of each of `values`, or −1 for none.

    The level with most readings within the `tolerance` is found first; they are removed, and so on.
    """
    low, span = float(np.min(values)), float(np.ptp(values))
    if span <= 2 * tolerance:
        return np.zeros(values.size, dtype=int)
    width = max(span / _BINS, tolerance / 4)
    bins = np.minimum(((values - low) / width).astype(int), int(span / width))
    counts = np.bincount(bins, minlength=int(span / width) + 1)
    reach = max(int(tolerance / width), 0)
    minimum = max(_MIN_READINGS, int(_LEVEL_SHARE * values.size))
    centers: list[float] = []
    for _ in range(_MAX_LEVELS):
        window = np.convolve(counts, np.ones(2 * reach + 1, dtype=int), mode="same")
        best = int(np.argmax(window))
        if window[best] < minimum:
            break
        window_bins = np.arange(max(best - reach, 0), min(best + reach + 1, counts.size))
        center = low + width * (0.5 + float(np.average(window_bins, weights=counts[window_bins])))
        counts[window_bins] = 0
        # the tails of a level are no level
        if all(abs(center - level) > 2 * tolerance + width for level in centers):
            centers.append(center)
    if not centers:
        return np.full(values.size, -1)
    ordered = np.sort(centers)
    nearest = np.searchsorted((ordered[1:] + ordered[:-1]) / 2, values)
    inside = np.abs(values - ordered[nearest]) <= tolerance + width
    return np.where(inside, nearest, -1)
