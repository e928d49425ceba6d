r"""Errors of a bench's gauges, estimated from readings without pressure, and faults of channels.

A load cell with a zero $F_0$, a scale $s$ and a drift $d$, a transducer with a zero $P_0$ and a
ruler with a zero $x_0$ read of a muscle that pulls with $F(P, x)$, at the time $t$,

$$F' = s\, F(P, x) + F_0 + d\,(t - t_0), \qquad P' = P + P_0, \qquad x' = x + x_0. \tag{C16}$$

A fit may free these five numbers beside the muscle's constants; they are no part of the muscle.
A muscle without pressure can't pull, and at its rest length it doesn't push: what the gauges read
then is their zero. A little shorter it pushes, between nothing, if it gives way, and what a
straight muscle would, and the braid's friction leaves a force of either sign, half a loop wide.
These readings come first: they correct the record before the fit if a zero or a drift exceeds noise
and friction wherever the push lies in that range. What the muscle does further on tells nothing of
the gauges: a column that folds earlier than the law's would look like a zero.

Faults of a channel are properties of its readings, whatever the muscle: many readings exactly at
one end of a range.

**Assumes** that the lowest pressure of a record is a vented muscle if it is below 1 % of the
highest. **Not resolved:** a zero of the pressure beside a free dead band, and a scale of the force
beside a free radius and rubber: the priors alone separate them. At equal stretches the gas's force
grows with the square of the radius at rest, the rubber's with its constants and the wall's
cross-section, so that a scale $s$ is a radius $\sqrt{s}$ times as large with another rubber. With
a given radius it is found.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..core.module import to_numpy
from ..core.types import Batch
from ..muscle import Muscle
from ..records.hysteresis import averaged
from ..records.record import DOWN, UP, Record


VENTED = 0.01  # of the highest pressure: below it a transducer shows its zero, not a setpoint
_STRETCHED = -1e-3  # strain: a muscle pulled beyond this pulls back without pressure
CLEAR = 4.0  # deviations of a zero, as all records together shall have few false ones
_STIFFER = 2.0  # times the straight muscle's stiffness: nominal moduli of rubber are no better
_SMALL_STRAIN = 1e-4  # where a straight muscle's push is still linear
_MIN_FOR_NOISE = 8  # readings: the median of fewer differences is too uncertain
_MIN_VENTED = 3  # pressures: fewer show no scatter
_APART = 0.3  # of the record's duration: readings of one strain over a shorter time show no drift
# an end of a range: at least so many readings, such a share of all, and so many times as many as
# at each of the values next to it, which a coarse gauge would repeat as well
_END_COUNT, _END_SHARE, _END_RATIO, _END_NEIGHBORS = 5, 0.02, 4, 10
_DISTINCT = 0.5  # of the readings: a channel with fewer values was set, or is from a table


@dataclass(frozen=True)
class Gauge:
    """Errors of a bench's gauges, (C16).

    - `force_zero`: reading of the load cell without a force, at the time `start` [N].
    - `force_gain`: change of its reading over the change of the force [-].
    - `force_drift`: change of its zero with time [N/s].
    - `pressure_zero`: reading of the pressure transducer without pressure [Pa].
    - `displacement_zero`: reading of the contraction at the rest length [m].
    - `start`: time of the record's first reading [s].
    """

    force_zero: Batch = 0.0
    force_gain: Batch = 1.0
    force_drift: Batch = 0.0
    pressure_zero: Batch = 0.0
    displacement_zero: Batch = 0.0
    start: float = 0.0

    @property
    def faults(self) -> dict[str, float]:
        """Values [SI] that differ from those of a perfect gauge, by name."""
        values = {name: float(getattr(self, name)) for name in GAUGE_NAMES}
        return {name: value for name, value in values.items() if value != getattr(PERFECT, name)}

    def read_force(self, force: Batch, elapsed: Batch) -> Batch:
        """Reading [N] of a pull of `force` [N], `elapsed` [s] after the start."""
        return self.force_gain * force + self.force_zero + self.force_drift * elapsed

    def true_force(self, reading: Batch, elapsed: Batch) -> Batch:
        """Pull [N] that gives a `reading` [N], `elapsed` [s] after the start."""
        return (reading - self.force_zero - self.force_drift * elapsed) / self.force_gain

    def correct(
        self, record: Record, length: float | None = None, previous: "Gauge | None" = None
    ) -> Record:
        """Readings of perfect gauges from those of a `record`; `length`: reference of its strains
        [m], by default its rest length; `previous`: gauge that has corrected them before.
        """
        previous = previous or PERFECT
        length = record.rest_length if length is None else length
        elapsed = 0.0 if record.time is None else record.time - self.start
        shift = self.displacement_zero - previous.displacement_zero
        return replace(
            record,
            pressure=record.pressure - (self.pressure_zero - previous.pressure_zero),
            strain=record.strain - (shift / length if length else 0.0),
            force=self.true_force(previous.read_force(record.force, elapsed), elapsed),
        )


GAUGE_NAMES = tuple(field.name for field in fields(Gauge) if field.name != "start")
DIMENSIONS = {"force_zero": "force", "force_gain": "number", "force_drift": "force_rate",
              "pressure_zero": "pressure", "displacement_zero": "length"}  # fmt: skip
PERFECT = Gauge()


def default_deviations(
    force: np.ndarray, pressure: np.ndarray, elapsed: Any, length: float
) -> dict[str, float]:
    """Standard deviations of the priors of a gauge's errors [SI], by name, from readings of `force`
    [N], `pressure` [Pa] and time `elapsed` [s], and the muscle's `length` [m].
    """
    top = max(float(np.max(np.abs(force))), 1e-9)  # N: a deviation is never zero
    duration = float(np.ptp(elapsed)) or 1.0
    return {  # what is usual on benches in laboratories
        "force_zero": 0.03 * top,  # a cell that was zeroed with a muscle or clamp on it
        "force_gain": 0.02,  # by the nominal sensitivity, or calibrated with one weight
        "force_drift": 0.01 * top / duration,  # warming of cell and amplifier
        "pressure_zero": 0.01 * max(float(np.max(pressure)), 1.0),  # an industrial transducer
        "displacement_zero": 0.005 * length,  # a ruler held against the fittings
    }


def read_vented(
    record: Record, muscle: Muscle
) -> tuple[Gauge, dict[str, tuple[float, float]], np.ndarray]:
    """Gauge with the errors that a record's readings without pressure show significantly, values
    and standard deviations of all that they determine [SI], but of channels whose zero was given,
    and a mask of those that tell the load cell's. The stiffness of the `muscle` bounds its push
    near the rest length.
    """
    start = 0.0 if record.time is None else float(np.min(record.time))
    top = float(np.max(record.pressure))
    is_vented = (record.pressure <= VENTED * top) & (record.strain >= _STRETCHED)
    vented = np.flatnonzero(is_vented & ~record.censored)
    gauge, zeros = Gauge(start=start), dict[str, tuple[float, float]]()
    of_load_cell = np.zeros(len(record), dtype=bool)
    if not (top > 0 and vented.size):
        return gauge, zeros, of_load_cell
    # what is left of a pressure still leaves the muscle in the first half of a visit
    settled = np.concatenate([visit[visit.size // 2 :] for visit in _visits(vented)])
    if settled.size >= _MIN_VENTED and "pressure" not in record.zeroed:
        P = record.pressure[settled]
        zero, scatter = float(np.mean(P)), float(np.std(P, ddof=1))
        # a zero that never changed is not exact: at least 1e-5 of the highest pressure
        deviation = max(scatter / np.sqrt(P.size), 1e-5 * top)
        if abs(zero) > max(scatter, CLEAR * deviation):
            gauge = replace(gauge, pressure_zero=zero)
        elif np.min(P) >= 0:  # a transducer may write its noise without the negative half
            zero, deviation = 0.0, float(np.hypot(deviation, zero))
        zeros["pressure_zero"] = zero, deviation
    if "force" not in record.zeroed:
        clear, read, used = _read_load_cell(record, muscle, vented)
        gauge, zeros = replace(gauge, **clear), zeros | read
        of_load_cell[used] = bool(clear)
    return gauge, zeros, of_load_cell


def _visits(points: np.ndarray) -> list[np.ndarray]:
    """Indices of readings, parted where the record has others between them."""
    return np.split(points, np.flatnonzero(np.diff(points) > 1) + 1)


def strain_scale(record: Record, muscle: Muscle) -> float:
    """Contraction of a `muscle` over a `record`'s strain [-], which may refer to another length."""
    length = float(muscle.length)
    return (record.rest_length or length) / length


def _read_load_cell(
    record: Record, muscle: Muscle, vented: np.ndarray
) -> tuple[dict[str, float], dict[str, tuple[float, float]], np.ndarray]:
    """Clear zero and drift of the load cell from the `vented` readings next to the rest length,
    values and standard deviations of what they determine [SI], by name, and the readings. However
    the column buckles, it pushes no harder than a straight muscle: an error counts if it is clear
    with this push and without, beside half a loop's width.
    """
    strain = np.maximum(record.strain * strain_scale(record, muscle), 0.0)
    # a law without rubber has a wall all the same
    straight = to_numpy(muscle.replace(tension="klute_hannaford", tuning=None)).law.tension
    stiffness = abs(float(straight.force(0.0, _SMALL_STRAIN))) / _SMALL_STRAIN
    noise = reading_noise(record.force)
    # as many of the least strains as show the smallest zero: more have less noise, but push more
    order = vented[np.argsort(strain[vented], kind="stable")]
    size = np.arange(1, order.size + 1)
    range_width = _STIFFER * stiffness * np.cumsum(strain[order]) / size
    first = order[: int(np.argmin(CLEAR * noise / np.sqrt(size) + range_width)) + 1]
    push = _STIFFER * stiffness * strain[first]
    basis, names = np.ones((first.size, 1)), ["force_zero"]
    if record.time is not None and record.has_one_clock:
        elapsed = record.time[first] - np.min(record.time)
        if np.ptp(elapsed) > _APART * np.ptp(record.time) > 0:
            basis, names = np.insert(basis, 1, elapsed, axis=1), [*names, "force_drift"]
    inverse = np.linalg.pinv(basis)
    without_push, with_push = inverse @ record.force[first], inverse @ (record.force[first] + push)
    # friction that the braid was left in is the same for all of them, of either sign
    friction = _vented_width(record) / 2 * np.sum(inverse, axis=1)
    by_noise = np.hypot(noise * np.sqrt(np.sum(inverse**2, axis=1)), friction)
    clear = np.minimum(np.abs(without_push), np.abs(with_push)) > CLEAR * by_noise
    clear &= np.sign(without_push) == np.sign(with_push)
    middle, half = (without_push + with_push) / 2, np.abs(with_push - without_push) / 2
    # the push lies anywhere in its range
    deviation = np.hypot(by_noise, half / np.sqrt(3))
    if clear[-1]:  # a drift is the change of a zero
        clear[:] = True
    zeros = dict(zip(names, zip(middle.tolist(), deviation.tolist(), strict=True), strict=True))
    errors = {name: zeros[name][0] for name, sure in zip(names, clear, strict=True) if sure}
    return errors, zeros, first


def _vented_width(record: Record) -> float:
    """Mean width [N] of a record's hysteresis loops without pressure; 0 where it has none."""
    try:
        half_way = averaged(record)
    except ValueError:  # no sweeps in it
        return 0.0
    vented = half_way.record.pressure <= VENTED * np.max(record.pressure)
    width = half_way.width[vented & np.isfinite(half_way.width)]
    return max(float(np.mean(width)), 0.0) if width.size else 0.0


def drift_confounders(record: Record) -> list[str]:
    """Groups, "branch" or "file", each of which has its own time: a drift is the same as friction
    then, or as another zero in each file.
    """
    if record.time is None or not record.has_one_clock:
        return []
    names, limit = [], float(np.std(record.time))
    for name, groups, group in (
        ("branch", (UP, DOWN), record.branch),
        ("file", range(len(record.sources)), record.file),
    ):
        times = [record.time[group == each] for each in groups]
        means = [float(np.mean(time)) for time in times if time.size]
        if len(means) > 1 and np.ptp(means) > limit:
            names.append(name)
    return names


def reading_noise(force: np.ndarray) -> float:
    """Standard deviation of the noise of a reading [N], from second differences of the forces in
    the order of the record: a smooth change has small ones, a turn or a step only a few large ones.
    """
    least = 1e-6 * float(np.max(np.abs(force), initial=0.0))  # of readings without any
    if force.size < _MIN_FOR_NOISE:
        return np.inf
    return max(float(np.median(np.abs(np.diff(force, 2)))) * 1.4826 / np.sqrt(6), least)


@dataclass(frozen=True)
class ChannelFault:
    """A "floor", "ceiling" or "saturation" of the "force", "pressure" or "displacement", at a
    `value` [SI; -, a strain, of a displacement] that a `count` of readings have.
    """

    kind: str
    channel: str
    value: float
    count: int


def channel_faults(record: Record) -> tuple[ChannelFault, ...]:
    """Faults of the channels of a `record`, as the gauges gave it."""
    faults = []
    for kind, channel, values in (
        ("floor", "force", record.force),
        ("ceiling", "force", record.force),
        ("saturation", "pressure", record.pressure),
        ("saturation", "displacement", record.strain),
    ):
        valid = ~record.censored if channel == "force" else True
        mask = readings_at_end(values, kind != "floor", valid)
        varies = channel == "force" or np.unique(values).size > _DISTINCT * np.sum(~mask)
        if np.any(mask) and varies:
            faults.append(ChannelFault(kind, channel, float(values[mask][0]), int(np.sum(mask))))
    return tuple(faults)


def readings_at_end(values: np.ndarray, upper: bool, valid: np.ndarray | bool = True) -> np.ndarray:
    """Mask of the readings at a floor of their channel, or at a ceiling (`upper`): with exactly the
    extreme value of the `valid` ones, but zero: the file has to declare that zeros are clipped.
    """
    valid = np.broadcast_to(valid, values.shape)
    distinct, counts = np.unique(values[valid], return_counts=True)
    if upper:
        distinct, counts = distinct[::-1], counts[::-1]
    if distinct.size < 2 or distinct[0] == 0:
        return np.zeros(values.size, dtype=bool)
    neighbors = np.max(counts[1 : 1 + _END_NEIGHBORS])
    enough = max(_END_COUNT, _END_SHARE * np.sum(counts), _END_RATIO * neighbors)
    return (values == distinct[0]) & valid & bool(counts[0] >= enough)
