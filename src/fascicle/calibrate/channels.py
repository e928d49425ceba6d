"""Faults of a record's channels: floor and ceiling, saturation, quantization, time lag.

They are properties of readings, whatever the muscle: many readings exactly at one end of a range,
few distinct values in even steps, and a force that follows pressure or displacement late.
"""

from dataclasses import dataclass

import numpy as np

from ..records.record import Record


# an end of a range: at least so many readings, such a share of all, and so many times as many as
# at each of the values next to it, which a coarse gauge would repeat as well
_END_COUNT, _END_SHARE, _END_RATIO, _END_NEIGHBORS = 5, 0.02, 4, 10
_DISTINCT = 0.5  # of the readings: a channel with fewer values was set, or is from a table
_MIN_STEP = 2e-3  # of the largest force: a finer step is below the error of any fit
_MIN_READINGS = 30  # fewer don't show steps or lags
_MIN_VALUES = 10  # fewer forces were set, such as those of hung masses
_ALIGNED = 0.8  # mean resultant length of values over a step: 1 if all are its multiples
_ALMOST = 0.9  # of the best resultant length, between grid points of the periodogram
_FINE = 8  # frequencies in the width of the periodogram's peak
_UNEVEN = 0.2  # of a sampling interval: its largest deviation, for a lag counted in intervals
_MAX_LAG = 0.05  # of the record: a later response is a slow muscle
_CLEAR = 4.0  # standard errors of a correlation
_HALF = 0.5  # of what the cause leaves unexplained without a lag: friction never does as much
_STEP = 0.02  # of the highest pressure: a larger change between two readings is a new level


@dataclass(frozen=True)
class ChannelFault:
    """A fault of a record's channel.

    - `kind`: "floor", "ceiling", "saturation", "quantization" or "lag".
    - `channel`: "force", "pressure" or "displacement"; of a lag the one that the force follows.
    - `value`: the end of the range or the step [SI unit of the channel; -, a strain, of a
      displacement]; of a lag the time [s], positive if the force is late.
    - `count`: number of readings that it affects.
    """

    kind: str
    channel: str
    value: float
    count: int


def channel_faults(record: Record) -> tuple[ChannelFault, ...]:
    """Faults of the channels of a `record`, as the gauges gave it."""
    faults = []
    for kind, upper in (("floor", False), ("ceiling", True)):
        mask = readings_at_end(record.force, upper, ~record.censored)
        if np.any(mask):
            value = float(record.force[mask][0])
            faults.append(ChannelFault(kind, "force", value, int(np.sum(mask))))
    for channel, values in (("pressure", record.pressure), ("displacement", record.strain)):
        mask = readings_at_end(values, True)
        if np.any(mask) and np.unique(values).size > _DISTINCT * np.sum(~mask):
            value = float(values[mask][0])
            faults.append(ChannelFault("saturation", channel, value, int(np.sum(mask))))
    step = _force_step(record)
    if step:
        faults.append(ChannelFault("quantization", "force", step, len(record)))
    return (*faults, *_lags(record))


def readings_at_end(values: np.ndarray, upper: bool, valid: np.ndarray | bool = True) -> np.ndarray:
    """Mask of the readings at a floor of their channel, or at a ceiling (`upper`).

    They have exactly the extreme value of the `valid` readings. An end of exactly zero doesn't
    count: the file has to declare that zeros are clipped.
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


def _force_step(record: Record) -> float:
    """Coarse step [N] that the forces differ by multiples of; 0 if there is none."""
    values = np.unique(record.force[~record.censored])
    top = float(np.max(np.abs(values), initial=0.0))
    if len(record) < _MIN_READINGS or values.size < _MIN_VALUES:
        return 0.0
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-9 * top]  # closer values are the same, but for rounding
    # steps fill a range: most neighbors among the distinct values are one or two steps apart
    usual = float(np.median(gaps)) if gaps.size else 0.0
    if usual < _MIN_STEP * top / 2 or np.ptp(values) > usual * 8 * values.size:
        return 0.0
    periods = 1 / np.arange(0.6 / usual, 2.4 / usual, 1 / (_FINE * np.ptp(values)))
    resultant = np.abs(np.mean(np.exp(2j * np.pi * (values - values[0])[:, None] / periods), 0))
    best = float(resultant.max(initial=0.0))
    if best < _ALIGNED:
        return 0.0
    # all divisors of the step align the values: periods fall, so the step comes first
    first = int(np.argmax(resultant > _ALMOST * best))
    step = float(periods[first + int(np.argmax(resultant[first : first + 2 * _FINE]))])
    return step if step >= _MIN_STEP * top else 0.0


def _lags(record: Record) -> list[ChannelFault]:
    """Times by which the force follows pressure or displacement late."""
    if record.time is None or len(record) < _MIN_READINGS:
        return []
    interval = float(np.median(np.diff(record.time)))
    if interval <= 0 or np.max(np.abs(np.diff(record.time) - interval)) > _UNEVEN * interval:
        return []
    force, pressure, strain = (np.diff(x) for x in (record.force, record.pressure, record.strain))
    level = np.abs(pressure) < _STEP * float(np.max(record.pressure))
    channels = {"pressure": (pressure, 1.0), "displacement": (np.where(level, strain, 0.0), -1.0)}
    faults = []
    for channel, (change, sign) in channels.items():
        response = force if channel == "pressure" else np.where(level, force, 0.0)
        lag = _lag(change, sign * response)
        if lag:
            faults.append(ChannelFault("lag", channel, lag * interval, len(record)))
    return faults


def _lag(cause: np.ndarray, response: np.ndarray) -> int:
    """Number of intervals by which a `response` follows its `cause`, negative if it leads; 0 unless
    it is clear.
    """
    size = cause.size
    reach = max(int(_MAX_LAG * size), 1)
    scale = float(np.linalg.norm(cause) * np.linalg.norm(response))
    if scale == 0:
        return 0
    correlations = np.correlate(response, cause, "full") / scale
    lags = np.arange(-reach, reach + 1)
    correlation = correlations[size - 1 + lags]
    best = int(np.argmax(correlation))
    unexplained = 1 - correlation**2
    clear = correlation[best] > _CLEAR / np.sqrt(size)
    clear = clear and unexplained[best] < _HALF * unexplained[reach]  # of no lag
    return int(lags[best]) if clear else 0
