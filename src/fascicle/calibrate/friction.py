r"""Friction from a record's two branches: sliding springs beside the static law.

A muscle whose braid rubs pulls with $F(P, \varepsilon) - z$: $F$ is the static law's, $z$ that of
springs $k_j$ that slip at $f_j$, whatever the speed, `fascicle.dynamics.MaxwellSlip`. The half-way
curve of a record's two branches is the static law's to fit, their distance, as `records.averaged`
measures it, the springs'. In the middle of a sweep it is twice

$$h(P) = \sum_j f_j(P), \qquad f_j = s_j (h_0 + h_P P), \qquad \sum_j s_j = 1, \tag{H5}$$

and less near its ends, (H4): a spring slips from a way $2 f_j/k_j$ past a turn on. One spring, then
more, are fitted by least squares; more are taken where Bayes' criterion finds them worth it.

**Not told by a record:** what is within a step of its readings after a turn. A loop that has its
whole width there gets springs that break away within that step, and are no stiffer.
**Assumes** sweeps at constant pressure that turn at the ends of what was measured.
**Source:** Iwan (1966), for springs that slip; their fit to widths is derived here.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..dynamics.hysteresis import MaxwellSlip
from ..records.hysteresis import averaged
from ..records.record import DOWN, UP, Record
from ..records.segmentation import Run, runs


_MAX_SPRINGS = 3  # springs: the ends of loops hardly tell more
_CLEAR = 3.0  # standard errors by which a mean width must exceed none
_SAME_PRESSURE = 5e-3  # of the largest pressure: closer runs are at one, as `averaged` has it
_MAX_READINGS = 200  # readings of a level at most: ends of loops are short
_FINEST = 1e-4  # of the width: an error that small is none, and no reason for another spring


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of a muscle.

    - `law`: the springs; `None` where both branches are one.
    - `width`: measured, the pull on the way back less that on the way there [N].
    - `fitted`: the springs', at the same readings [N].
    - `breakaway`: way from a turn to where each spring slips, at the highest pressure [m].
    - `resolved`: of each spring, whether that way is longer than a step of the readings.
    - `pressures`: number of those with both branches.
    """

    law: MaxwellSlip | None
    width: np.ndarray
    fitted: np.ndarray
    breakaway: np.ndarray
    resolved: tuple[bool, ...]
    pressures: int

    @property
    def rmse(self) -> float:
        """Root mean square error of the width [N]."""
        return float(np.sqrt(np.mean((self.width - self.fitted) ** 2)))

    def half_width(self, pressure: float) -> float:
        """$h$ [N] at `pressure` [Pa], (H5)."""
        if self.law is None:
            return 0.0
        return float(np.sum(self.law.slip_force + self.law.slip_force_slope * pressure))


def fit_friction(record: Record, length: float) -> Friction | None:
    """Fit springs to a record's loops.

    **Arguments:**

    - `record`: with both ways of its sweeps.
    - `length`: that its strains refer to [m].

    **Returns:** the friction; `None` where no pressure was held on both ways.
    """
    loops = _loops(record, length)
    if loops is None:
        return None
    width = loops.width
    if np.mean(width) <= _CLEAR * np.std(width) / np.sqrt(width.size):
        return Friction(None, width, 0.0 * width, np.zeros(0), (), loops.levels)
    fits = [_fitted(loops, many) for many in range(1, _MAX_SPRINGS + 1)]
    least, n = _FINEST * float(np.mean(width)), width.size
    # each spring has a share and a way
    costs = [2 * n * np.log(max(fit.rmse, least)) + 2 * k * np.log(n) for k, fit in enumerate(fits)]
    return fits[int(np.argmin(costs))]


@dataclass(frozen=True, eq=False)
class _Loops:
    """Of each reading with both branches: pressure [Pa], ways from either turn [m], width [N];
    `step`: between readings [m]; of how many `levels` [-].
    """

    pressure: np.ndarray
    there: np.ndarray
    back: np.ndarray
    width: np.ndarray
    step: float
    levels: int


def _loops(record: Record, length: float) -> _Loops | None:
    """Both branches at held pressures; `None` where there are none."""
    held = sorted((run for run in runs(record) if run.kind == "pressure"), key=lambda r: r.level)
    apart, levels = _SAME_PRESSURE * max(float(np.max(record.pressure)), 1.0), list[list[Run]]()
    for run in held:
        if levels and run.level - levels[-1][-1].level <= apart:
            levels[-1].append(run)
        else:
            levels.append([run])
    rows = [row for level in levels if (row := _loop(record, level)) is not None]
    if not rows:
        return None
    step = float(np.median([np.median(np.diff(np.sort(one[1]))) for one in rows]))
    P, there, back, width = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    # at a turn itself both branches are one reading
    past = np.minimum(there, back) > step / 2
    return _Loops(
        P[past], length * there[past], length * back[past], width[past], length * step, len(rows)
    )


def _loop(record: Record, level: list[Run]) -> tuple[np.ndarray, ...] | None:
    """Pressure, ways from either turn [strain] and width of one level's readings."""
    if not {UP, DOWN} <= {run.branch for run in level}:
        return None
    points = np.concatenate([run.points for run in level])
    ways = np.concatenate([np.full(run.points.size, run.branch, np.int8) for run in level])
    order = np.argsort(points)
    part = averaged(replace(record.only(points[order]), branch=ways[order]), _MAX_READINGS)
    strain, turns = part.record.strain, record.strain[points]
    good = np.isfinite(part.width) & ~part.record.censored
    # a turn lies at or beyond each reading, but for noise
    there, back = (np.maximum(way, 0.0) for way in (strain - turns.min(), turns.max() - strain))
    columns = (part.record.pressure, there, back, part.width)
    return tuple(one[good] for one in columns) if np.sum(good) > 1 else None


def _fitted(loops: _Loops, many: int) -> Friction:
    """So `many` springs, by least squares."""
    from scipy.optimize import least_squares, nnls  # a tenth of a second, that few records need

    top, stroke = float(loops.pressure.max()) or 1.0, float(np.max(loops.there + loops.back))
    middle = np.minimum(loops.there, loops.back) > stroke / 5
    some = middle if np.any(middle) else loops.width > -np.inf
    at = np.stack([np.ones(some.sum()), loops.pressure[some] / top], axis=1)
    h, _ = nnls(at, loops.width[some] / 2)
    h = np.maximum(h, 1e-6 * max(h.max(), 1e-9))
    shortest, longest = np.log(min(loops.step, stroke / 4)), np.log(stroke)

    def law(z: np.ndarray) -> MaxwellSlip:
        share = np.exp(z[:many] - z[:many].max())
        share = share / share.sum()
        low, rise = z[-2:]
        stiffness = 2 * share * (low + rise) / np.exp(z[many:-2])
        return MaxwellSlip(stiffness, share * low, share * rise / top)

    def missed(z: np.ndarray) -> np.ndarray:
        return law(z).loop_width(loops.there, loops.back, loops.pressure) - loops.width

    none = np.full(many, 5.0)
    low = np.concatenate([-none, np.full(many, shortest), [0.0, 1e-9 * h.max()]])
    high = np.concatenate([none, np.full(many, longest), [np.inf, np.inf]])
    found = []
    for share in (0.05, 0.4):  # of the stroke: the longest way to begin with
        ways = np.linspace(shortest, np.log(share * stroke), many + 2)[1:-1]
        start = np.concatenate([np.zeros(many), np.clip(ways, shortest + 1e-3, longest), h])
        scale = np.concatenate([np.ones(2 * many), np.full(2, h.sum())])
        found.append(least_squares(missed, start, bounds=(low, high), x_scale=scale))
    z = min(found, key=lambda one: one.cost).x
    order = np.argsort(z[many:-2])
    z = np.concatenate([z[:many][order], z[many:-2][order], z[-2:]])
    way = np.exp(z[many:-2])
    return Friction(
        law=law(z),
        width=loops.width,
        fitted=loops.width + missed(z),
        breakaway=way,
        resolved=tuple((way > 1.5 * loops.step).tolist()),
        pressures=loops.levels,
    )
