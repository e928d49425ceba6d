r"""Whether residuals are noise: smooth trends and runs of one sign, along strain and pressure.

Residuals $y$ of $n$ readings, a fit's Jacobian $J$, and columns $B$ of polynomials in what they may
follow: with $Q$ the span of what of $B$ lies beside $J$, and $R$ that of all such columns together,

$$F = \frac{\lVert Q^T y \rVert^2 / \operatorname{rank} Q}
      {(\lVert y \rVert^2 - \lVert R^T y \rVert^2) / (n - p - \operatorname{rank} R)} \tag{C9}$$

follows Fisher's distribution if what is left is noise, $p$ constants having been fitted. Trends
are looked for along strain, pressure, both together, branch and time; the most significant is
taken first, and the others beside it.

Signs of neighbors differ half of the time if they are noise: that they do so rarely, along
strain in a sweep or along pressure at one strain, is a binomial's tail. Residuals of a fit change
sign a little more often than that, so the test is on the safe side.

All tests together call noise a trend in 1 % of records (Bonferroni).

**Source:** Fisher (1922); Wald and Wolfowitz (1940) for runs, here about zero.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, fdtrc

from .remainder import Remainder, span


ALPHA = 0.01  # chance of calling noise a trend, all tests of a record together
_ORDERS = 5  # of a polynomial: smoother than this is a trend, rougher is noise
_FEWEST = 5  # degrees of freedom left, below which nothing can be told
_PAIRS = 8  # neighbors, below which signs tell nothing
_SAME = 2e-3  # of the range: strains closer than this are one
_CELLS = 12  # of strain, where it was swept


@dataclass(frozen=True, eq=False)
class Trend:
    """What residuals may follow.

    - `along`: "strain", "pressure", "strain and pressure", "branch" or "time" [-].
    - `share`: of the residuals' squares that it explains [-], beside those found before it.
    - `chance`: of as much or more in noise [-]. `found`: whether that is too little [-].
    - `columns`: the polynomials at the remainder's rows [-], of mean square 1.
    """

    along: str
    share: float
    chance: float
    found: bool
    columns: np.ndarray


@dataclass(frozen=True)
class Runs:
    """Signs of neighboring residuals `along` "strain" or "pressure": how many `pairs` [-], how
    many of them change sign, `changes` [-]; `chance`, `found`: as of a trend.
    """

    along: str
    pairs: int
    changes: int
    chance: float
    found: bool


@dataclass(frozen=True)
class Signs:
    """Of `count` [-] residuals near a `strain` [-], how many are `below` zero [-]."""

    strain: float
    count: int
    below: int


@dataclass(frozen=True, eq=False)
class Looked:
    """What was looked for in residuals, and found: `trends`, those found first; `runs`;
    `signs`, where nearly all are of one sign; `rest`: at the least strain, pressures [Pa], rising,
    and the mean residual [N] at each; `noise`: deviation of a reading [N] about fit and
    all trends, NaN where too few readings are left to tell.
    """

    trends: tuple[Trend, ...] = ()
    runs: tuple[Runs, ...] = ()
    signs: tuple[Signs, ...] = ()
    rest: tuple[tuple[float, float], ...] = ()
    noise: float = float("nan")

    @property
    def found(self) -> tuple[Trend, ...]:
        """The trends that are no chance [-]."""
        return tuple(one for one in self.trends if one.found)

    @property
    def wandering(self) -> tuple[Runs, ...]:
        """Where neighbors have one sign too often for chance [-]."""
        return tuple(one for one in self.runs if one.found)

    @property
    def noisy(self) -> bool:
        """Whether residuals could be noise [-]."""
        return not self.found and not self.wandering


def looked(left: Remainder) -> Looked:
    """Trends and runs [-] in what a fit `left` [-]."""
    columns = _columns(left)
    taken = left.taken
    every = left.beyond(taken, np.hstack(list(columns.values())))
    count = int(np.sum(left.read))
    fitted = float(np.sum(taken[left.read] ** 2))  # a constant that its prior holds isn't one
    free = count - fitted - every.shape[1]
    runs = _runs(left)
    if free < _FEWEST:
        return Looked(runs=_judged(runs, len(runs)), signs=_signs(left), rest=_rest(left))
    y = left.residual
    noise = float(np.sum((y - taken @ (taken.T @ y) - every @ (every.T @ y)) ** 2)) / free
    tests = len(columns) + len(runs)
    trends, basis = [], taken
    while columns:
        trials = {name: _trial(left, name, basis, B, noise, free) for name, B in columns.items()}
        best = min(trials, key=lambda name: trials[name].chance)
        if trials[best].chance * tests >= ALPHA:
            trends += [_settled(one, found=False) for one in trials.values()]
            break
        trends.append(_settled(trials[best], found=True))
        basis = span(np.hstack([basis, columns.pop(best)]))
    told = _judged(runs, tests), _signs(left), _rest(left)
    return Looked(tuple(trends), *told, float(np.sqrt(noise)))


def _trial(
    left: Remainder, name: str, basis: np.ndarray, B: np.ndarray, noise: float, free: float
) -> Trend:
    Q = left.beyond(basis, B)
    explained = float(np.sum((Q.T @ left.residual) ** 2))
    chance = 1.0
    if Q.shape[1] and noise > 0:
        chance = float(fdtrc(Q.shape[1], free, explained / Q.shape[1] / noise))
    return Trend(name, min(explained / max(left.squares, 1e-300), 1.0), chance, False, B)


def _settled(trend: Trend, found: bool) -> Trend:
    return Trend(trend.along, trend.share, trend.chance, found, trend.columns)


def _columns(left: Remainder) -> dict[str, np.ndarray]:
    """Weighed polynomials in what residuals may follow, by its name."""
    strain, pressure = (_polynomials(left, v, _ORDERS) for v in (left.strain, left.pressure))
    both = [
        strain[:, i] * pressure[:, j]
        for i, j in ((0, 0), (1, 0), (0, 1))
        if i < strain.shape[1] and j < pressure.shape[1]
    ]
    # an error that is the same everywhere is one along strain
    offset = np.ones((strain.shape[0], 1))
    made = {"strain": np.hstack([offset, strain]), "pressure": pressure}
    if both:
        made["strain and pressure"] = np.stack(both, axis=-1)
    ways = set(np.unique(left.branch[left.read]))
    if {1, -1} <= ways:
        # a loop's width grows with pressure
        made["branch"] = np.stack([left.branch, left.branch * left.pressure], axis=-1)
    if np.all(np.isfinite(left.time[left.read])):
        made["time"] = _polynomials(left, left.time, 2)
    out = {name: left.rows(_unit(left, columns)) for name, columns in made.items()}
    return {name: columns for name, columns in out.items() if columns.shape[1]}


def _polynomials(left: Remainder, values: np.ndarray, order: int) -> np.ndarray:
    """Legendre's polynomials of orders 1 to `order` [-] over the range of `values` [any]."""
    seen = values[left.read]
    low, span_ = float(np.min(seen, initial=np.inf)), float(np.ptp(seen)) if seen.size else 0.0
    if not span_ > 0:
        return np.zeros((values.size, 0))
    distinct = np.unique(np.round((seen - low) / (span_ * _SAME))).size
    at = np.where(left.read, 2 * (values - low) / span_ - 1, 0.0)
    return np.polynomial.legendre.legvander(at, min(order, distinct - 1))[:, 1:]


def _unit(left: Remainder, columns: np.ndarray) -> np.ndarray:
    """`columns` [any] scaled to a mean square of 1 over all readings."""
    weight = left.weight**2
    square = np.sum(weight[:, None] * columns**2, axis=0) / max(float(weight.sum()), 1e-300)
    return columns[:, square > 0] / np.sqrt(square[square > 0])


def _runs(left: Remainder) -> list[tuple[str, int, int]]:
    """How many neighbors there are along strain and along pressure, and how many change sign."""
    read = left.read
    sign = np.sign(left.residual[read])
    level, strain, branch = left.level[read], left.strain[read], left.branch[read]
    place, cells = _cells(strain)
    swept = np.lexsort((strain, branch, level))
    same = (np.diff(level[swept]) == 0) & (np.diff(branch[swept]) == 0)
    found = [_changes("strain", sign[swept], same)]
    if cells:
        # one value for each level in a cell of strain
        weight = left.weight[read]
        key = (place * (int(level.max()) + 1) + level).astype(int)
        mean = np.bincount(key, left.residual[read] * weight)
        some = np.flatnonzero(np.bincount(key, weight) > 0)
        at = some // (int(level.max()) + 1)
        found.append(_changes("pressure", np.sign(mean[some]), np.diff(at) == 0))
    return [one for one in found if one[1] >= _PAIRS]


def _changes(along: str, sign: np.ndarray, neighbors: np.ndarray) -> tuple[str, int, int]:
    pairs = neighbors & (sign[1:] != 0) & (sign[:-1] != 0)
    return along, int(np.sum(pairs)), int(np.sum(pairs & (sign[1:] != sign[:-1])))


def _judged(runs: list[tuple[str, int, int]], tests: int) -> tuple[Runs, ...]:
    chances = [float(bdtr(changes, pairs, 0.5)) for _, pairs, changes in runs]
    return tuple(
        Runs(*one, chance, chance * tests < ALPHA)
        for one, chance in zip(runs, chances, strict=True)
    )


def _cells(strain: np.ndarray) -> tuple[np.ndarray, int]:
    """Which of a few strains each is near, and how many these are."""
    span_ = float(np.ptp(strain)) if strain.size else 0.0
    if not span_ > 0:
        return np.zeros(strain.size, dtype=int), 0
    order = np.sort(strain)
    edges = np.flatnonzero(np.diff(order) > 2 * _SAME * span_)
    starts = order[np.concatenate([[0], edges + 1])]
    ends = order[np.concatenate([edges, [order.size - 1]])]
    if starts.size <= 2 * _CELLS and np.max(ends - starts) <= 2 * _SAME * span_:  # a table's
        return np.searchsorted(starts, strain, "right") - 1, starts.size
    cell = np.minimum(((strain - order[0]) / span_ * _CELLS).astype(int), _CELLS - 1)
    return cell, _CELLS


def _signs(left: Remainder) -> tuple[Signs, ...]:
    """Where so many residuals are of one sign that it is no chance, the clearest first."""
    read = left.read
    strain, residual = left.strain[read], left.residual[read]
    place, cells = _cells(strain)
    out = []
    for cell in range(cells):
        there = place == cell
        count, below = int(np.sum(there)), int(np.sum(residual[there] < 0))
        if count and 2 * cells * bdtr(min(below, count - below), count, 0.5) < ALPHA:
            out.append(Signs(float(np.mean(strain[there])), count, below))
    return tuple(sorted(out, key=lambda one: -abs(2 * one.below - one.count)))


def _rest(left: Remainder) -> tuple[tuple[float, float], ...]:
    """Mean residuals [N] by pressure [Pa] in the cell of least strain."""
    read = left.read
    place, _ = _cells(left.strain[read])
    there = place == 0
    level, weight = left.level[read][there].astype(int), left.weight[read][there]
    if not level.size:
        return ()
    # residuals are multiplied by the root of what they average, as the weight is
    total, count = np.bincount(level, left.residual[read][there] * weight), weight**2
    count = np.bincount(level, count)
    P = np.bincount(level, left.pressure[read][there] * weight**2)
    some = count > 0
    return tuple(zip((P[some] / count[some]).tolist(), (total[some] / count[some]).tolist(),
                     strict=True))  # fmt: skip
