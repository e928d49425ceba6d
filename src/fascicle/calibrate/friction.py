r"""Friction from a record's two branches: sliding springs in parallel with the static law.

A muscle with friction in its braid pulls with $F(P, \varepsilon) - z$: $F$ is the force of the
static law, $z$ that of springs $k_j$ that slip at $f_j$ whatever the speed,
`fascicle.dynamics.MaxwellSlip`. The static law is fitted to the half-way curve of a record's two
branches, the springs to their distance, as `records.averaged` measures it. In the middle of a sweep
this distance is twice

$$h(P) = \sum_j f_j(P), \qquad f_j = s_j (h_0 + h_P P), \qquad \sum_j s_j = 1, \tag{H5}$$

and less near its ends, (H4): a spring slips after a distance $2 f_j/k_j$ from a turn. One to three
springs are fitted by least squares; their number is the best by Bayes' criterion.

**Not resolved by a record:** distances from a turn below the step of its readings. A loop that has
its full width at the first reading gets springs that slip within that step, and are no stiffer.
**Assumes** sweeps at constant pressure that turn at the ends of the measured range.
**Source:** Iwan (1966), for springs that slip; their fit to widths is derived here.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..muscle.hysteresis import MaxwellSlip
from ..records.hysteresis import averaged, group_by_level, split_by_file
from ..records.record import DOWN, UP, Record
from ..records.segmentation import Run, runs


_MAX_SPRINGS = 3  # springs: the ends of loops hardly distinguish more
_CLEAR = 3.0  # standard errors by which a mean width must exceed zero
_MAX_READINGS = 200  # of a level, more than of a half-way curve: the ends of loops are short
_MIN_ERROR = 1e-4  # of the width: a smaller error is no reason for another spring


@dataclass(frozen=True, eq=False)
class Friction:
    """Widths of a record's hysteresis loops, and the sliding springs fitted to them.

    - `law`: the springs; `None` where the loops are no wider than their scatter.
    - `width`, `fitted_width`: pull of the returning branch less that of the contracting one [N],
      measured and of the springs.
    - `breakaway`: distance from a turn to the slip of each spring, at the highest pressure [m];
      `resolved`: it exceeds a step of the readings.
    - `pressures`: number of pressures with both branches.
    """

    law: MaxwellSlip | None
    width: np.ndarray
    fitted_width: np.ndarray
    breakaway: np.ndarray
    resolved: tuple[bool, ...]
    pressures: int

    @property
    def rmse(self) -> float:
        """Root mean square error of the width [N]."""
        return float(np.sqrt(np.mean((self.width - self.fitted_width) ** 2)))

    def half_width(self, pressure: float) -> float:
        """$h$ [N] at `pressure` [Pa], (H5)."""
        if self.law is None:
            return 0.0
        return float(np.sum(self.law.slip_force + self.law.slip_force_slope * pressure))


def fit_friction(record: Record, length: float) -> Friction | None:
    """Fit sliding springs to the hysteresis loops of a `record`; `length`: reference of its strains
    [m]. `None` without a pressure that was measured on both branches.
    """
    groups = group_by_level(record, [run for run in runs(record) if run.kind == "pressure"])
    levels_of = [
        [loop for part in split_by_file(record, group)
         if (loop := _loop(record, part, length)) is not None]
        for group in groups
    ]  # fmt: skip
    levels, pressures = [level for part in levels_of for level in part], sum(map(bool, levels_of))
    if not levels:
        return None
    # readings of several files may lie at one strain
    steps = [np.diff(np.unique(level[1])).astype(float) for level in levels]
    step = float(np.median([np.median(x) for x in steps]))
    loops = np.concatenate(levels, axis=1)
    # at a turn both branches are one reading
    loops = loops[:, np.minimum(loops[1], loops[2]) > step / 2]
    width, n = loops[3], loops.shape[1]
    if n == 0:
        return None
    if np.mean(width) <= _CLEAR * np.std(width) / np.sqrt(n):
        return Friction(None, width, 0.0 * width, np.zeros(0), (), pressures)
    fits = [_fit_springs(loops, step, pressures, k) for k in range(1, _MAX_SPRINGS + 1)]
    errors = np.maximum([fit.rmse for fit in fits], _MIN_ERROR * float(np.mean(width)))
    # two numbers for each spring: its share and its distance
    costs = 2 * n * np.log(errors) + 2 * np.arange(len(fits)) * np.log(n)
    return fits[int(np.argmin(costs))]


def _loop(record: Record, level: list[Run], length: float) -> np.ndarray | None:
    """Pressure [Pa], distances from either turn [m] and width [N] of one level's readings."""
    if not {UP, DOWN} <= {run.branch for run in level}:
        return None
    points = np.concatenate([run.points for run in level])
    branch = np.concatenate([np.full(run.points.size, run.branch, np.int8) for run in level])
    order = np.argsort(points)
    half_way = averaged(replace(record.only(points[order]), branch=branch[order]), _MAX_READINGS)
    strain, all_strains = half_way.record.strain, record.strain[points]
    good = np.isfinite(half_way.width) & ~half_way.record.censored
    if np.unique(strain[good]).size < 2:
        return None
    # a turn lies at or beyond each reading, but for noise
    from_start = length * np.maximum(strain - all_strains.min(), 0.0)
    from_end = length * np.maximum(all_strains.max() - strain, 0.0)
    return np.array([half_way.record.pressure, from_start, from_end, half_way.width])[:, good]


def _fit_springs(loops: np.ndarray, step: float, pressures: int, count: int) -> Friction:
    """Fit a `count` of springs to rows of `_loop` by least squares; `step`: of the readings [m]."""
    from scipy.optimize import least_squares, nnls  # a tenth of a second, that few records need

    P, from_start, from_end, width = loops
    stroke, top = float(np.max(from_start + from_end)), float(P.max()) or 1.0
    # the middle of a loop has its full width
    middle = np.minimum(from_start, from_end) > stroke / 5
    used = middle if np.any(middle) else width > -np.inf
    basis = np.stack([np.ones(used.sum()), P[used] / top], axis=1)
    h, _ = nnls(basis, width[used] / 2)
    # a start inside the bounds below, also where the regression gives zero
    h = np.maximum(h, 1e-6 * max(h.max(), 1e-9))
    shortest, longest = np.log(min(step, stroke / 4)), np.log(stroke)

    def law(z: np.ndarray) -> MaxwellSlip:
        fraction = np.exp(z[:count] - z[:count].max())
        fraction = fraction / fraction.sum()
        constant, rise = z[-2:]
        stiffness = 2 * fraction * (constant + rise) / np.exp(z[count:-2])
        return MaxwellSlip(stiffness, fraction * constant, fraction * rise / top)

    def residuals(z: np.ndarray) -> np.ndarray:
        return law(z).loop_width(from_start, from_end, P) - width

    limit = np.full(count, 5.0)
    # a rise of zero beside a constant of zero would be a spring without stiffness
    low = np.concatenate([-limit, np.full(count, shortest), [0.0, 1e-9 * h.max()]])
    high = np.concatenate([limit, np.full(count, longest), [np.inf, np.inf]])
    scale = np.concatenate([np.ones(2 * count), np.full(2, h.sum())])
    results = []
    for fraction in (0.05, 0.4):  # of the stroke: the longest distance to begin with
        distances = np.linspace(shortest, np.log(fraction * stroke), count + 2)[1:-1]
        distances = np.clip(distances, shortest + 1e-3, longest)  # inside the bounds
        start = np.concatenate([np.zeros(count), distances, h])
        results.append(least_squares(residuals, start, bounds=(low, high), x_scale=scale))
    z = min(results, key=lambda result: result.cost).x
    order = np.argsort(z[count:-2])
    z = np.concatenate([z[:count][order], z[count:-2][order], z[-2:]])
    breakaway = np.exp(z[count:-2])
    resolved = tuple((breakaway > 1.5 * step).tolist())
    return Friction(law(z), width, width + residuals(z), breakaway, resolved, pressures)
