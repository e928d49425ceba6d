"""Data of a fit: readings in a table by level of pressure, and what became of every reading.

Free strain and collapse depend on pressure alone, so readings at one pressure share a level.
Pressures that a transducer scattered are grouped into levels; a long sweep is averaged in even
steps of strain, each branch of a loop by itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..core.types import AnyArray, Bool, Float
from ..muscle import Muscle
from ..records.record import DOWN, UNKNOWN, Record, warning
from ..records.segmentation import runs
from .friction import fit_friction
from .gauges import PERFECT, ChannelFault, Gauge, channel_faults, read_vented


MAX_READINGS = 384  # of a level; a longer sweep is averaged: more points add no information
_THIN_LEVELS = 24  # pressures: three in each part that is left out
_THIN_ENTRIES = 512  # readings in all: means over longer steps blur free strain and collapse
_MIN_ENTRIES = 16  # of a level: both branches of a sweep in steps of an eighth of its strain
MIN_PUSHES = 5  # number of factors on the resisting force; fewer readings can't determine them
_GAP = 0.005  # of the largest pressure: readings closer than this share a level
_MAX_WIDTH = 0.02  # of the largest pressure: a wider level is a sweep, cut finer
_SMALL = 0.1  # of a level's largest force: upper limit of a gauge's noise at zero force
_NOISE = 0.02  # of the record's largest force: the same limit at low pressures
_MAX_LOADS, _REPEATS = 20, 3  # masses of a set, and readings of each: a load cell shows more values
_UNEXPLAINED = 0.1  # of the contractions' variance: more is a sweep of them, not an equilibrium
_IDLE = 0.01  # of the highest pressure: below it an unstretched muscle doesn't pull

Table = Float[AnyArray, "level reading"]


@dataclass(frozen=True, eq=False)
class Grid:
    """Readings by level of pressure, in rows of one length.

    - `pressure`: of each level [Pa], as a column.
    - `strain`, `force`: of each entry [-], [N].
    - `count`: number of readings averaged in an entry; 0 for padding.
    - `censored`: the entry only says "not above", or of those `at_least` "not below".
    - `elapsed`: mean time of an entry since the record's start [s]; 0 without times.
    - `spread`: standard deviation of a reading of the entry over the typical one [-].
    """

    pressure: Float[AnyArray, "level 1"]
    strain: Table
    force: Table
    count: Table
    censored: Bool[AnyArray, "level reading"]
    elapsed: Table | float = 0.0
    at_least: Bool[AnyArray, "level reading"] | None = None
    spread: Table | float = 1.0

    @property
    def precision(self) -> np.ndarray:
        """Standard deviation of a typical reading over that of each entry [-]; 0 for padding."""
        return np.sqrt(self.count) / self.spread

    @property
    def used(self) -> Bool[np.ndarray, "level reading"]:
        """Mask of the entries that hold a reading."""
        return self.count > 0

    @property
    def measured(self) -> Bool[np.ndarray, "level reading"]:
        """Mask of the entries that hold a force that isn't clipped."""
        return self.used & ~self.censored

    def without(self, mask: np.ndarray) -> "Grid":
        """Grid of the same shape, with a `count` of 0 at the entries of a `mask`."""
        return replace(self, count=np.where(mask, 0.0, self.count))


@dataclass(frozen=True, eq=False)
class FitData:
    """Selected readings of a record.

    - `record`: the fitted readings, with their branches as far as they are known.
    - `grid`: their table by level of pressure.
    - `level`, `column`: position of each reading in the table.
    - `branch`, `time`: of each entry of the table; mean time of its readings [s] or NaN.
    - `read`: number of readings read.
    - `left_out`: number of readings that are not fitted, by reason.
    - `noise_clipped`: number of small forces past the free strain that only limit the force.
    - `pushes_clipped`: number of readings without pull that only limit the force.
    - `faults`: of the record's channels.
    - `at_ceiling`: mask of the clipped readings that limit the force from below; `None`: no such.
    - `gauge`: errors of the gauges that the readings were corrected for.
    - `zeros`: errors that readings without pressure show, with standard deviations [SI], by name.
    - `at_rest`: mask of the readings without pressure that show an error of the load cell.
    - `turning`: mask of the readings after a turn of their sweep, where friction still builds up.
    - `reads_contraction`: loads were set and contractions read: their error counts.
    """

    record: Record
    grid: Grid
    level: np.ndarray
    column: np.ndarray
    branch: np.ndarray
    time: np.ndarray
    read: int
    left_out: Mapping[str, int] = field(default_factory=dict)
    noise_clipped: int = 0
    pushes_clipped: int = 0
    faults: tuple[ChannelFault, ...] = ()
    at_ceiling: np.ndarray | None = None
    gauge: Gauge = PERFECT
    zeros: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    at_rest: np.ndarray | None = None
    turning: np.ndarray | None = None
    reads_contraction: bool = False

    @property
    def clipped(self) -> int:
        """Number of readings that the gauge clipped."""
        return int(np.sum(self.record.censored)) - self.noise_clipped - self.pushes_clipped

    @property
    def floor(self) -> float:
        """Force at which readings are clipped from below [N]: zero, or the gauge's floor."""
        floors = [fault.value for fault in self.faults if fault.kind == "floor"]
        return floors[0] if floors else 0.0

    @property
    def pushes(self) -> int:
        """Number of readings without pull that aren't clipped."""
        return int(np.sum((self.record.force <= 0) & ~self.record.censored))

    @property
    def pulls(self) -> bool:
        """True if all measured forces pull, so that they depend on the tension law alone."""
        return self.reads_contraction or (not self.pushes and not np.all(self.record.censored))

    @property
    def settled(self) -> np.ndarray:
        """Mask of the table's entries without readings after a turn."""
        return self.used_without(self.turning)

    def used_without(self, mask: np.ndarray | None) -> np.ndarray:
        """Mask of the table's entries without those that a `mask` of the readings leaves out."""
        used = self.grid.used.copy()
        if mask is not None:
            used[self.level[mask], self.column[mask]] = False
        return used

    @property
    def largest_strain(self) -> float:
        """Largest contraction over the record's reference length [-]."""
        return float(np.max(np.abs(self.record.strain)))

    @property
    def averaged(self) -> int:
        """Number of readings that share their entry with others."""
        return int(np.sum(self.grid.count[self.grid.count > 1]))

    @property
    def means(self) -> int:
        """Number of entries that average several readings."""
        return int(np.sum(self.grid.count > 1))

    def counts(self) -> dict[str, int]:
        """Numbers of readings by their use."""
        return {
            "read": self.read,
            **{f"left out: {reason}": count for reason, count in self.left_out.items()},
            "clipped": self.clipped,
            "clipped as noise": self.noise_clipped,
            "without pull": self.pushes_clipped,
            "averaged": self.averaged,
            "means": self.means,
            "pressures": len(self.grid.pressure),
        }

    def errors(self, force: np.ndarray) -> np.ndarray:
        """Measured less fitted force of each reading [N], NaN where it is clipped; `force`: the
        model's, at each entry of the grid [N].
        """
        record, entry = self.record, (self.level, self.column)
        fitted = force[entry]
        if self.averaged:
            slopes = _slopes(force, self.grid)[entry]
            fitted = fitted + (record.strain - self.grid.strain[entry]) * slopes
        return np.where(record.censored, np.nan, record.force - fitted)

    def corrected(self, gauge: Gauge, length: float) -> "FitData":
        """Data corrected for another `gauge`; `length`: reference of strains without one [m]."""
        length = self.record.rest_length or length
        record = gauge.correct(self.record, length, self.gauge)
        old, grid, t = self.gauge, self.grid, self.grid.elapsed
        grid = replace(
            grid,
            pressure=grid.pressure - (gauge.pressure_zero - old.pressure_zero),
            strain=grid.strain - (gauge.displacement_zero - old.displacement_zero) / length,
            force=gauge.true_force(old.read_force(grid.force, t), t),
        )
        return replace(self, record=record, grid=grid, gauge=gauge)


def select_fit_data(record: Record, muscle: Muscle | None = None) -> FitData:
    """Select the readings to fit: those of sweeps, without the ramps between them. With a `muscle`,
    correct them for the gauges' zeros: those that explain the readings without pressure.
    """
    # a clipped reading counts as zero, whatever number the file has for it
    force = np.where(record.censored, 0.0, record.force)
    record = replace(record, force=force)
    faults, measured = channel_faults(record), ~record.censored
    ends = {fault.kind: fault.value for fault in faults if fault.channel == "force"}
    at_floor, at_ceiling = (
        measured & (force == ends.get(kind, np.nan)) for kind in ("floor", "ceiling")
    )
    record = replace(record, censored=record.censored | at_floor | at_ceiling)
    branch, ramp = record.branch.copy(), np.zeros(len(record), dtype=bool)
    has_branches = bool(np.any(branch != UNKNOWN))
    for run in runs(record):
        ramp[run.points] = run.kind == "mixed"
        if not has_branches and run.kind != "mixed":
            branch[run.points] = run.branch
    read, left_out, ramps = len(record), {}, int(np.sum(ramp))
    if record.time is not None and 0 < ramps < len(record) / 2:
        left_out = {"on ramps between sweeps": ramps}
        finding = warning("ramps", count=ramps)
        record, branch, at_ceiling = record.only(~ramp, finding), branch[~ramp], at_ceiling[~ramp]
    facts: dict[str, Any] = {"read": read, "left_out": left_out, "faults": faults}
    facts |= {"at_ceiling": at_ceiling if np.any(at_ceiling) else None}
    record = replace(record, branch=branch)
    data = fit_table(record, **facts, reads_contraction=has_set_loads(record))
    if muscle is None:
        return data
    length, (gauge, zeros, at_rest) = float(muscle.length), read_vented(data.record, muscle)
    facts = {"at_rest": at_rest, "turning": after_turns(data.record, length)}
    return replace(data, zeros=zeros, **facts).corrected(gauge, length)


def has_set_loads(record: Record) -> bool:
    """True if the forces of a `record` are a few set ones, which with the pressures explain the
    strains that were measured.
    """
    loads, load = np.unique(record.force, return_inverse=True)
    strain, count = record.strain, len(record)
    is_set = loads.size <= min(_MAX_LOADS, count / _REPEATS) and not np.any(record.censored)
    if not is_set or np.unique(strain).size <= _REPEATS * loads.size:
        return False
    _, group = np.unique(assign_levels(record.pressure) * loads.size + load, return_inverse=True)
    means = np.bincount(group, strain) / np.bincount(group)
    return bool(np.sum((strain - means[group]) ** 2) < _UNEXPLAINED * np.var(strain) * count)


def after_turns(record: Record, length: float) -> np.ndarray | None:
    """Mask of the readings so soon after a turn of their sweep that friction still builds up;
    `length`: reference of strains without one [m].
    """
    length = record.rest_length or length
    friction = fit_friction(record, length) if np.any(record.branch == DOWN) else None
    if friction is None or not any(friction.resolved):  # the build-up is shorter than a step
        return None
    mask = np.zeros(len(record), dtype=bool)
    # springs spread evenly over distances have the mean of one; the last slips at twice that
    distance = 2 * float(np.max(friction.breakaway)) / length
    for run in runs(record):
        if run.kind == "pressure":
            strain = record.strain[run.points]
            mask[run.points] = np.abs(strain - strain[0]) < distance
    return mask


def thin(data: FitData) -> FitData:
    """Fewer readings for the comparison of candidates: levels at even steps of the readings in the
    order of pressure, so that those held are among many that were passed; averaged if long.
    """
    levels, counts = len(data.grid.pressure), np.bincount(data.level)
    middle = np.cumsum(counts) - counts / 2
    steps = np.linspace(middle[0], middle[-1], min(levels, _THIN_LEVELS))
    chosen = np.unique(np.interp(steps, middle, np.arange(levels)).round().astype(int))
    limit = max(_THIN_ENTRIES // chosen.size, _MIN_ENTRIES)
    if chosen.size == levels and data.grid.force.shape[1] <= limit:
        return data
    rows = np.isin(data.level, chosen)
    masks = {"at_ceiling": data.at_ceiling, "at_rest": data.at_rest, "turning": data.turning}
    masks = {name: None if mask is None else mask[rows] for name, mask in masks.items()}
    return fit_table(data.record.only(rows), limit, data, **masks)


def pulling_only(data: FitData) -> FitData:
    """Data in which pushes, and readings of either sign that are noise past the free strain, only
    say that the force is not above 0 N; data on contraction as they are.
    """
    if data.reads_contraction:
        return data
    record = data.record
    below = (record.force <= 0) & ~record.censored
    noise = _noise_past_free_strain(data, record.censored | below)
    if not np.any(below | noise):
        return data
    clipped = record.censored | below | noise
    at_ceiling = False if data.at_ceiling is None else data.at_ceiling
    force = np.where(clipped & ~np.asarray(at_ceiling), 0.0, record.force)
    record = replace(record, force=force, censored=clipped)
    noises, pushes = data.noise_clipped + int(noise.sum()), data.pushes_clipped + int(below.sum())
    return fit_table(record, previous=data, noise_clipped=noises, pushes_clipped=pushes)


def fit_table(
    record: Record,
    max_readings: int = MAX_READINGS,
    previous: FitData | None = None,
    **changes: Any,
) -> FitData:
    """Table of a `record` by level of pressure; a level of more than `max_readings` is averaged in
    steps of strain. Further fields are those of `previous` data, with `changes`.
    """
    level = assign_levels(record.pressure)
    rows = _rows(level, np.arange(len(record)))
    column = np.zeros(len(record), dtype=int)
    for points in rows:
        column[points] = _assign_columns(record, points, max_readings)
    shape = len(rows), int(column.max()) + 1
    flat = level * shape[1] + column
    count = np.bincount(flat, minlength=shape[0] * shape[1]).astype(float).reshape(shape)

    def mean(values: np.ndarray) -> np.ndarray:
        total = np.bincount(flat, values, minlength=count.size).reshape(shape)
        return total / np.maximum(count, 1)

    pressure = np.array([[np.mean(record.pressure[points])] for points in rows])
    censored = mean(record.censored) > 0.5
    grid = Grid(pressure, mean(record.strain), mean(record.force), count, censored)
    time = np.full(shape, np.nan)
    if record.time is not None and record.has_one_clock:  # several clocks show no drift
        start = float(np.min(record.time)) if previous is None else previous.gauge.start
        time = np.where(count > 0, mean(record.time), np.nan)
        grid = replace(grid, elapsed=np.where(count > 0, time - start, 0.0))
    at_ceiling = changes.get("at_ceiling", None if previous is None else previous.at_ceiling)
    if at_ceiling is not None:
        grid = replace(grid, at_least=mean(at_ceiling) > 0.5)
    branch = np.round(mean(record.branch)).astype(int)
    if previous is None:
        changes = {"read": len(record), **changes}
        return FitData(record, grid, level, column, branch, time, **changes)
    place = {"level": level, "column": column, "branch": branch, "time": time}
    return replace(previous, record=record, grid=grid, **place, **changes)


def _rows(level: np.ndarray, order: np.ndarray) -> list[np.ndarray]:
    """Indices of the readings of each level, in the given `order`."""
    order = order[np.argsort(level[order], kind="stable")]
    return np.split(order, np.flatnonzero(np.diff(level[order])) + 1)


def assign_levels(pressure: np.ndarray) -> np.ndarray:
    """Index of the level of each `pressure` [Pa], from the lowest."""
    order = np.argsort(pressure, kind="stable")
    P, top = pressure[order], max(float(np.max(pressure)), 1.0)
    cluster = np.concatenate([[0], np.cumsum(np.diff(P) > _GAP * top)])
    first = P[np.searchsorted(cluster, cluster)]
    last = P[np.searchsorted(cluster, cluster, "right") - 1]
    # a pressure that was swept has no gaps: cut it in steps as fine as a gap
    step = np.where(last - first > _MAX_WIDTH * top, np.floor((P - first) / (_GAP * top)), 0.0)
    new = (np.diff(cluster) > 0) | (np.diff(step) != 0)
    levels = np.empty(P.size, dtype=int)
    levels[order] = np.concatenate([[0], np.cumsum(new)])
    return levels


def _assign_columns(record: Record, points: np.ndarray, max_readings: int) -> np.ndarray:
    """Columns of a level's readings: one for each, or one for each step of strain."""
    if points.size <= max_readings:
        return np.arange(points.size)
    strain = record.strain[points]
    # clipped readings are never averaged with others, nor is one branch with the other
    kind = 2 * record.branch[points].astype(int) + record.censored[points]
    kind = np.unique(kind, return_inverse=True)[1]
    kinds = int(kind.max()) + 1
    steps = max(max_readings // kinds, 1)
    low, high = strain.min(), strain.max()
    # never divides by zero: a level at one strain has one step
    step = np.minimum((steps * (strain - low) / max(high - low, 1e-12)).astype(int), steps - 1)
    return np.unique(kinds * step + kind, return_inverse=True)[1]


def _noise_past_free_strain(data: FitData, clipped: np.ndarray) -> np.ndarray:
    """Mask of the readings that are noise: small forces past the strain where the pull ends, which
    best separates `clipped` readings (a mask) from others; the least strain without pressure.
    """
    force, strain = data.record.force, data.record.strain
    mask, top = np.zeros(force.size, dtype=bool), float(np.max(force))
    idle = data.record.pressure < _IDLE * float(np.max(data.record.pressure))
    for points in _rows(data.level, np.argsort(strain, kind="stable")):
        zero = clipped[points]
        if np.all(zero) or not (np.any(zero) or idle[points[0]]):
            continue
        # the strain that best separates readings that pull from those that don't
        correct = np.append(0, np.cumsum(~zero)) + np.append(np.cumsum(zero[::-1])[::-1], 0)
        end = 0 if idle[points[0]] else int(np.argmax(correct))
        small = force[points] < max(_SMALL * np.max(force[points]), _NOISE * top)
        noise = (np.arange(points.size) >= end) & ~zero & small
        # forces before it that are no larger than this noise are noise, too
        largest = np.max(force[points], where=noise, initial=0.0)
        while end > 0 and (zero[end - 1] or force[points][end - 1] <= largest):
            end -= 1
            noise[end] = not zero[end]
        mask[points] = noise
    return mask


def _slopes(force: np.ndarray, grid: Grid) -> np.ndarray:
    """Slopes of the model's force with strain [N] along each level."""
    slopes = np.zeros(force.shape)
    for row in range(len(force)):
        columns = np.flatnonzero(grid.used[row])
        columns = columns[np.argsort(grid.strain[row, columns], kind="stable")]
        x = grid.strain[row, columns]
        # the means of both branches may differ by rounding
        distinct = np.concatenate([[True], np.diff(x) > 1e-6 * np.ptp(x)])
        if np.sum(distinct) > 1:
            slope = np.gradient(force[row, columns[distinct]], x[distinct])
            slopes[row, columns] = np.interp(x, x[distinct], slope)
    return slopes
