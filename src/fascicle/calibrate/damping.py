r"""Damping of a muscle: friction that grows with speed, from sweeps at two speeds or more.

Sweeps over the same strains at one pressure and in one direction differ by nothing but their
speeds. What a static law misses, $e_i$, is the same for all of them at one strain, whatever it is,
and so is friction that does not depend on the speed, but for

$$e_i = a_c + b_c \varepsilon_i - (B_0 + B_P P_i)\, \dot x_i, \tag{H7}$$

with a straight line for each cell $c$ of a pressure, a direction and a tenth of the sweeps' common
strains. Linear least squares give $B_0$ and $B_P$ of (H6), one pair for shortening and one for
lengthening, and their covariance from the scatter about (H7).

**Assumes** errors that are independent from reading to reading: a drift of the load cell from one
sweep to the next is taken for damping.
**Source:** Reynolds et al. (2003), Lilly and Quesada (2004), for the law; the fit is derived here.
"""

from dataclasses import dataclass

import numpy as np

from ..muscle.hysteresis import Damping
from ..records.hysteresis import group_by_level
from ..records.record import DOWN, UP, Record
from ..records.segmentation import runs


# speeds that differ by less are one: a damper's force at either of them would have ten times the
# error of the forces' difference
_MIN_RATIO = 1.1
_CLEAR = 3.0  # standard errors by which damping must exceed zero
_CELLS = 10  # stretches of a sweep, in each of which its speed hardly changes
_PER_CELL = 4  # readings in each: their mean has half of a reading's noise


@dataclass(frozen=True, eq=False)
class DirectionDamping:
    """Damping in one direction: `coefficients` $B_0$ [N·s/m] and $B_P$ [N·s/(m·Pa)], zero of one
    pressure, with their `covariance`; from a number of `pressures` of mean `pressure` [Pa].
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    pressure: float
    pressures: int

    def at(self, pressure: float) -> tuple[float, float]:
        """$B$ and its standard error [N·s/m] at a `pressure` [Pa]."""
        row = np.array([1.0, pressure])
        return float(row @ self.coefficients), float(np.sqrt(row @ self.covariance @ row))

    @property
    def is_clear(self) -> bool:
        """The damping at the mean pressure exceeds its scatter."""
        value, error = self.at(self.pressure)
        return value > _CLEAR * error


@dataclass(frozen=True, eq=False)
class FittedDamping:
    """Damping of a record.

    - `shortening`, `lengthening`: of either direction; `None` without two speeds.
    - `speeds`: the lowest and the highest mean speed of a sweep [m/s]; NaN without sweeps in time.
    - `velocity`: of contraction at each reading [m/s], zero where unknown.
    """

    shortening: DirectionDamping | None
    lengthening: DirectionDamping | None
    speeds: tuple[float, float]
    velocity: np.ndarray

    @property
    def unknown(self) -> list[str]:
        """Directions without two speeds, "shortening" and "lengthening"."""
        return [name for name in ("shortening", "lengthening") if getattr(self, name) is None]

    @property
    def law(self) -> Damping | None:
        """Damping of the directions where it is clear, zero in the other; `None` without any."""
        sides = [self.shortening, self.lengthening]
        clear = [side.coefficients if side and side.is_clear else np.zeros(2) for side in sides]
        (up, up_slope), (down, down_slope) = (side.tolist() for side in clear)
        return Damping(up, down, up_slope, down_slope) if np.any(clear) else None


def fit_damping(record: Record, errors: np.ndarray, length: float) -> FittedDamping:
    """Fit the damping of a `record`; `errors`: measured less a static law's force of each reading
    [N], NaN where unknown; `length`: reference of its strains [m].
    """
    velocity = np.zeros(len(record))
    time = velocity if record.time is None else record.time  # that doesn't run: no sweeps
    compared: dict[int, list[list[np.ndarray]]] = {UP: [], DOWN: []}
    mean_speeds: list[float] = []
    sweeps = [run for run in runs(record) if run.kind == "pressure"]
    for group in group_by_level(record, sweeps):
        for branch, levels in compared.items():
            points = [run.points for run in group if run.branch == branch]
            pieces = [piece for run in points for piece in _pieces(time, run)]
            for piece in pieces:
                velocity[piece] = _velocity(time[piece], length * record.strain[piece])
            speeds = [abs(float(np.mean(velocity[piece]))) for piece in pieces]
            mean_speeds += speeds
            if speeds and max(speeds) >= _MIN_RATIO * min(speeds):
                levels.append(pieces)
    up, down = (_fit_direction(record, errors, velocity, levels) for levels in compared.values())
    ends = min(mean_speeds, default=np.nan), max(mean_speeds, default=np.nan)
    return FittedDamping(up, down, ends, velocity)


def _pieces(time: np.ndarray, points: np.ndarray) -> list[np.ndarray]:
    """Stretches of a run's `points` in which `time` [s] runs on, as in each of several files."""
    pieces = np.split(points, np.flatnonzero(np.diff(time[points]) < 0) + 1)
    return [x for x in pieces if x.size >= 2 * _PER_CELL and time[x[-1]] > time[x[0]]]


def _velocity(time: np.ndarray, contraction: np.ndarray) -> np.ndarray:
    """Velocity at each reading of a sweep [m/s], from means of time [s] and `contraction` [m]."""
    cells = np.array_split(np.arange(time.size), min(_CELLS, time.size // _PER_CELL))
    t, x = (np.array([np.mean(values[cell]) for cell in cells]) for values in (time, contraction))
    return np.interp(time, t, np.gradient(x, t))


def _fit_direction(
    record: Record, errors: np.ndarray, velocity: np.ndarray, levels: list[list[np.ndarray]]
) -> DirectionDamping | None:
    """Least squares of (H7) in one direction; `levels`: readings of each sweep by pressure."""
    points, cells = [np.zeros(0, int)], [np.zeros(0, int)]
    for level, pieces in enumerate(levels):
        strains = [record.strain[piece] for piece in pieces]
        low, high = max(float(x.min()) for x in strains), min(float(x.max()) for x in strains)
        edges = np.linspace(low, high, min(_CELLS, min(x.size for x in strains) // _PER_CELL) + 1)
        for piece, strain in zip(pieces, strains, strict=True):
            used = (low <= strain) & (strain <= high) & np.isfinite(errors[piece])
            points.append(piece[used])
            cells.append(_CELLS * level + np.searchsorted(edges[1:-1], strain[used]))
    rows, (_, cell) = np.concatenate(points), np.unique(np.concatenate(cells), return_inverse=True)
    count, size = min(len(levels), 2), np.bincount(cell)
    freedom = rows.size - 2 * size.size - count
    if freedom < 1:
        return None

    def centered(values: np.ndarray) -> np.ndarray:
        return values - (np.bincount(cell, weights=values) / size)[cell]

    x = centered(record.strain[rows])
    spread = np.maximum(np.bincount(cell, weights=x**2), np.finfo(float).tiny)

    def within(values: np.ndarray) -> np.ndarray:
        """Residuals [any unit] of a straight line along the strain in each cell."""
        slope = np.bincount(cell, weights=x * centered(values)) / spread
        return centered(values) - slope[cell] * x

    P, v, left = record.pressure[rows], velocity[rows], within(errors[rows])
    top = float(P.max()) or 1.0  # columns of one size
    columns = np.stack([within(-v), within(-v * P / top)], axis=1)[:, :count]
    values, _, rank, _ = np.linalg.lstsq(columns, left, rcond=None)
    if rank < count:
        return None
    unit, coefficients, covariance = np.array([1.0, 1 / top]), np.zeros(2), np.zeros((2, 2))
    coefficients[:count] = values
    covariance[:count, :count] = np.linalg.inv(columns.T @ columns)
    covariance *= np.sum((left - columns @ values) ** 2) / freedom
    covariance *= np.outer(unit, unit)
    return DirectionDamping(coefficients * unit, covariance, float(np.mean(P)), len(levels))
