r"""Residual diagnostics: trends, runs of one sign, their likely causes, and the model's own error.

Residuals $y$ of $n$ readings, a fit's Jacobian $J$, and columns $B$ of polynomials in what they may
follow: with $Q$ the span of what of $B$ lies beside $J$, and $R$ that of all such columns together,

$$F = \frac{\lVert Q^T y \rVert^2 / \operatorname{rank} Q}
      {(\lVert y \rVert^2 - \lVert R^T y \rVert^2) / (n - p - \operatorname{rank} R)} \tag{C9}$$

follows Fisher's distribution if what is left is noise, $p$ constants having been fitted. Trends
are looked for along strain, pressure, both together, branch and time; the most significant is
taken first, and the others beside it. Signs of neighbors differ half of the time if they are
noise: that they do so rarely, along strain in a sweep or along pressure at one strain, is a
binomial's tail. All tests together call noise a trend in 1 % of records (Bonferroni).

A fit makes residuals orthogonal to its own Jacobian, and the error that it has taken up into its
constants can't be seen. It is taken to be as large as what can be: a smooth discrepancy is added to
the model,

$$F = \mu(z) + B b + e, \qquad b \sim N(0, \tau^2), \tag{C10}$$

with the polynomials $B$ of each trend that was found, and its size from what they explain,
the expectation of the explained squares (Henderson's method III)

$$E \lVert Q^T y \rVert^2 = \tau^2 \lVert (1 - T T^T) B \rVert^2 + \sigma^2 \operatorname{rank} Q,
  \tag{C11}$$

$T$ the span of all that was fitted before. The constants' covariance grows by what such errors
would move them,

$$C_d = \tau^2 (t/1.645)^2\, G B B^T G^T, \qquad G = (J^T J)^{-1} J^T, \tag{C12}$$

$t$ Student's quantile, since $\tau$ is known from a few orders only.

Each known cause changes the force in its own way over strain and pressure. How much of the
residuals' squares such a change would take up, beside what was fitted, is computed to first
order: a hint where to look, and no fit. Readings past the free strain are also compared with other
buckling laws, each with its own best factors on Young's modulus and on the moment of collapse.

**Assumes** that the discrepancy is smooth, and no larger where the fit took it up than beside.
**Source:** Fisher (1922); Wald and Wolfowitz (1940) for runs, here about zero; Kennedy and O'Hagan
(2001) for the discrepancy; Henderson (1953) for its size.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.special import bdtr, fdtrc, stdtrit

from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN
from ..muscle import Muscle
from .least_squares import KNOWN, NORMAL, Fit, Problem
from .parameters import FACTORS, coordinates, put, select_parameters


# causes of residuals, and what to do; of constants that a fit may free, their names alone
_CAUSES = {
    "compliance": ("an end effect: fibers or fittings that give", "free end_compliance"),
    "ends": ("an end effect: ends that don't swell",
             "compare tension laws: tondu_lopez scales the strain"),
    "length": ("the zero of the length", "check the rest length"),
    "zero": ("the load cell's zero", "take it off"),
    "rubber": (
        "the bladder's elasticity: a force that goes with contraction, whatever the pressure",
        "C10 and C01 can't follow it: trust strains that were measured, not those between or"
        " beyond",
    ),
    "friction": ("friction: a hysteresis loop", "its width is part of the muscle's error in use"),
    "drift": ("a drift in time", "measure the first pressure again at the end"),
}  # fmt: skip
_CONSTANTS = {
    "dead_band": "a dead band, or the transducer's zero",
    "active_length": "an end effect: a part of the length that doesn't work",
    "wall_thickness": "another wall",
    "end_compliance": _CAUSES["compliance"][0],
    "inactive_length": "an end effect: a part of the length that doesn't work",
    "c10": "the rubber's modulus",
    "c01": "the rubber's modulus",
    "braid_angle": "another braid angle",
    "outer_radius": "another radius",
}
ALPHA = 0.01  # chance of calling noise a trend, all tests of a record together
_ORDERS = 5  # of a polynomial: smoother than this is a trend, rougher is noise
_MIN_FREEDOM = 5  # degrees of freedom left, below which nothing can be told
_MIN_PAIRS = 8  # neighbors, below which signs tell nothing
_RESOLUTION = 2e-3  # of the range: strains closer than this are one
_CELLS = 12  # of strain, where it was swept
_RANK = 1e-6  # of their size: columns that are one but for errors of finite differences
_IN_READINGS = 0.5  # of a direction's square that lies in readings, for it to be one of them
_LEVEL = 0.95  # both ends of a 90 % interval
_WORTH = 0.2  # of the residuals' squares, below which a cause isn't named
_NEXT = 0.8  # of the best cause's share: others are named too
_MAX_CAUSES = 3
_STRAIN_STEP = 1e-6  # for the force's slope: errors of rounding and of the step are alike
_LAWS = ("kim2021", "kim2021_series", "elastica")  # `ovalising` takes minutes
_MOSTLY = 0.5  # of the residuals' squares: past the free strain, so that the law there is in doubt
_MAX_COMPARED = 300  # readings: enough to tell laws apart, and quick
_MAX_CALLS = 30  # of a law's forces in the search for its factors
_FARTHEST = np.log(20)  # of a factor either way


@dataclass(frozen=True, eq=False)
class Trend:
    """A trend that residuals may follow.

    - `along`: "strain", "pressure", "strain and pressure", "branch" or "time".
    - `share`: of the residuals' squares that it explains [-], beside those found before it.
    - `chance`: of as much or more in noise [-]. `found`: whether that is too little.
    - `columns`: the polynomials at the residuals' rows, of mean square 1.
    """

    along: str
    share: float
    chance: float
    found: bool
    columns: np.ndarray


@dataclass(frozen=True)
class Runs:
    """Signs of neighboring residuals `along` "strain" or "pressure": the number of `pairs`, and of
    those that change sign, `changes`; `chance`, `found`: as of a trend.
    """

    along: str
    pairs: int
    changes: int
    chance: float
    found: bool


@dataclass(frozen=True)
class Signs:
    """Of `count` residuals near a `strain` [-], the number that lies `below` zero."""

    strain: float
    count: int
    below: int


@dataclass(frozen=True)
class Cause:
    """A likely cause: its `name`, the `remedy`, and the `share` of the residuals' squares that it
    would explain [-].
    """

    name: str
    remedy: str
    share: float


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Residual diagnostics of a fit.

    - `trends`: tested trends, significant ones first; `runs`: of signs.
    - `signs`: strains where nearly all residuals are of one sign.
    - `at_rest`: at the least strain, pressures [Pa], rising, and the mean residual [N] at each.
    - `noise`: standard deviation of a reading [N] about fit and all trends, NaN where too few
      readings are left to tell.
    - `inflation`: of the covariance from noise, for residuals that follow one another [-].
    - `covariance`: what the model's own error adds to that of the coordinates; `None`: nothing.
    - `discrepancy`: columns [N] of that error at the places of the grid, each to be multiplied by
      a standard normal deviate.
    - `causes`: that would explain the residuals, the likeliest first.
    - `confounded`: constants that weren't fitted, and that the data could not tell beside those
      that were.
    """

    trends: tuple[Trend, ...] = ()
    runs: tuple[Runs, ...] = ()
    signs: tuple[Signs, ...] = ()
    at_rest: tuple[tuple[float, float], ...] = ()
    noise: float = float("nan")
    inflation: float = 1.0
    covariance: np.ndarray | None = None
    discrepancy: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 0)))
    causes: tuple[Cause, ...] = ()
    confounded: tuple[str, ...] = ()

    @property
    def significant(self) -> tuple[Trend, ...]:
        """The trends that are no chance."""
        return tuple(trend for trend in self.trends if trend.found)

    @property
    def autocorrelated(self) -> tuple[Runs, ...]:
        """Directions along which neighbors have one sign too often for chance."""
        return tuple(run for run in self.runs if run.found)

    @property
    def is_white_noise(self) -> bool:
        """Whether residuals could be noise."""
        return not self.significant and not self.autocorrelated


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of readings that were measured, and their places. The last rows of `residual` and
    `slopes` are the priors': a constant that its prior holds has taken nothing up.

    - `residual`: measured less fitted force [N], times the root of how many readings it averages.
    - `slopes`: its Jacobian [N] by the coordinates, then by the curves of the readings.
    - `weight`: root of how many readings are averaged; 0 for a prior.
    - `strain`, `pressure`, `branch`, `time`, `force`: of each reading, the record's [-], [Pa],
      [-], [s], and the model's [N]; of priors they mean nothing.
    - `level`: of pressure.
    """

    residual: np.ndarray
    slopes: np.ndarray
    weight: np.ndarray
    strain: np.ndarray
    pressure: np.ndarray
    branch: np.ndarray
    time: np.ndarray
    force: np.ndarray
    level: np.ndarray

    @property
    def read(self) -> np.ndarray:
        """Rows that are readings."""
        return self.weight > 0

    @property
    def squares(self) -> float:
        """Sum of squares of the readings' residuals [N²]."""
        return float(np.sum(self.residual[self.read] ** 2))

    @cached_property
    def model_subspace(self) -> np.ndarray:
        """Orthonormal basis of what the fit could take up."""
        return span(self.slopes)

    def beyond(self, basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Orthonormal basis of the part of `columns` that lies beside an orthonormal `basis`.

        What a constant takes up but for its prior is none of it: that lies in the priors' rows.
        """
        Q = span(project_out(basis, columns))
        return Q[:, np.sum(Q[self.read] ** 2, axis=0) > _IN_READINGS]

    def rows(self, values: np.ndarray) -> np.ndarray:
        """`values` at the readings as columns to regress on: weighted, and zero for priors."""
        columns = np.asarray(values, dtype=float).reshape(self.weight.size, -1)
        return np.where(self.read[:, None], columns * self.weight[:, None], 0.0)


def diagnose(fit: Fit) -> Diagnosis:
    """Diagnose the residuals of a `fit`."""
    residuals = residuals_of(fit)
    diagnosis = find_trends(residuals)
    sizes = discrepancy_sizes(residuals, diagnosis)
    diagnosis = replace(
        diagnosis,
        inflation=autocorrelation_inflation(residuals, diagnosis),
        covariance=_trend_covariance(fit, diagnosis, sizes),
        discrepancy=_discrepancy(fit.problem, residuals, diagnosis, sizes),
        causes=find_causes(fit, residuals, diagnosis),
        confounded=confounded_parameters(fit, residuals),
    )
    other = other_buckling_law(fit, diagnosis)
    if other is None:
        return diagnosis
    # what it explains is not the rubber's or the gauge's
    smaller = tuple(cause for cause in diagnosis.causes if cause.share > other.share)
    return replace(diagnosis, causes=(other, *smaller))


def residuals_of(fit: Fit) -> Residuals:
    """The residuals of a `fit`, with the rows of its priors."""
    problem, data = fit.problem, fit.fit_data
    grid, linear = problem.grid, fit.minimum.linear
    # the noise of the problem that was solved, which residuals and priors are relative to
    used, k, noise = grid.measured, len(problem.parameters), fit.minimum.solved_noise
    weight = np.sqrt(grid.count[used])
    missed = weight * (grid.force - linear.force)[used]
    # outliers stay played down as the loss has them, in a tuning also where it doesn't look
    if problem.loss != "linear":
        softened = linear.residuals[: used.size].reshape(used.shape)[used] * noise
        missed = np.where(softened != 0, softened, missed)
    slopes = -weight[:, None] * linear.force_slopes[used]
    priors = np.zeros((k, slopes.shape[1]))
    priors[:, :k] = np.diag(noise / problem.deviation)
    pulled = (fit.coordinates - problem.center) * noise / problem.deviation
    pressure, level = np.broadcast_to(grid.pressure, used.shape), np.indices(used.shape)[0]
    columns = (grid.strain, pressure, data.branch, data.time, linear.force, level)
    none = np.zeros(k)
    return Residuals(
        np.concatenate([missed, pulled]),
        np.concatenate([slopes, priors]),
        np.concatenate([weight, none]),
        *(np.concatenate([values[used], none]) for values in columns),
    )


def span(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the span of `columns`."""
    scale = np.linalg.norm(columns, axis=0)
    some = columns[:, scale > 0] / scale[scale > 0]
    if not some.size:
        return np.zeros((len(columns), 0))
    basis, size, _ = np.linalg.svd(some, full_matrices=False)
    return basis[:, size > _RANK * size[0]]


def project_out(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The part of `columns` that lies beside the span of an orthonormal `basis`."""
    rest = columns - basis @ (basis.T @ columns)
    rest = rest - basis @ (basis.T @ rest)  # once more for what rounding left
    nothing = np.linalg.norm(rest, axis=0) < _RANK * np.linalg.norm(columns, axis=0)
    return np.where(nothing, 0.0, rest)


def find_trends(residuals: Residuals) -> Diagnosis:
    """Trends and runs in `residuals`."""
    columns, model = _trend_columns(residuals), residuals.model_subspace
    every = residuals.beyond(model, np.hstack(list(columns.values())))
    fitted = float(np.sum(model[residuals.read] ** 2))  # a constant that its prior holds isn't one
    free = int(np.sum(residuals.read)) - fitted - every.shape[1]
    runs = _count_runs(residuals)
    tests = len(runs) + (len(columns) if free >= _MIN_FREEDOM else 0)
    diagnosis = Diagnosis(
        runs=_test_runs(runs, tests), signs=_signs(residuals), at_rest=_at_rest(residuals)
    )
    if free < _MIN_FREEDOM:
        return diagnosis
    y = residuals.residual
    rest = y - model @ (model.T @ y) - every @ (every.T @ y)
    variance = float(np.sum(rest**2)) / free
    trends, basis = [], model
    while columns:
        trials = [
            _test_trend(residuals, name, basis, B, variance, free) for name, B in columns.items()
        ]
        best = min(trials, key=lambda trend: trend.chance)
        if best.chance * tests >= ALPHA:
            trends += trials
            break
        trends.append(replace(best, found=True))
        basis = span(np.hstack([basis, columns.pop(best.along)]))
    return replace(diagnosis, trends=tuple(trends), noise=float(np.sqrt(variance)))


def _test_trend(
    residuals: Residuals, name: str, basis: np.ndarray, B: np.ndarray, variance: float, free: float
) -> Trend:
    Q = residuals.beyond(basis, B)
    explained = float(np.sum((Q.T @ residuals.residual) ** 2))
    chance = 1.0
    if Q.shape[1] and variance > 0:
        chance = float(fdtrc(Q.shape[1], free, explained / Q.shape[1] / variance))
    return Trend(name, min(explained / max(residuals.squares, 1e-300), 1.0), chance, False, B)


def _trend_columns(residuals: Residuals) -> dict[str, np.ndarray]:
    """Weighted polynomials in what residuals may follow, by its name."""
    strain = _polynomials(residuals, residuals.strain, _ORDERS)
    pressure = _polynomials(residuals, residuals.pressure, _ORDERS)
    both = [
        strain[:, i] * pressure[:, j]
        for i, j in ((0, 0), (1, 0), (0, 1))
        if i < strain.shape[1] and j < pressure.shape[1]
    ]
    # an error that is the same everywhere is one along strain
    out = {"strain": np.insert(strain, 0, 1.0, axis=1), "pressure": pressure}
    if both:
        out["strain and pressure"] = np.stack(both, axis=-1)
    if {1, -1} <= set(np.unique(residuals.branch[residuals.read])):
        out["branch"] = _branch_columns(residuals)
    if np.all(np.isfinite(residuals.time[residuals.read])):
        out["time"] = _polynomials(residuals, residuals.time, 2)
    scaled = {name: residuals.rows(_unit(residuals, columns)) for name, columns in out.items()}
    return {name: columns for name, columns in scaled.items() if columns.shape[1]}


def _branch_columns(residuals: Residuals) -> np.ndarray:
    # a loop's width grows with pressure
    return np.stack([residuals.branch, residuals.branch * residuals.pressure], axis=-1)


def _polynomials(residuals: Residuals, values: np.ndarray, order: int) -> np.ndarray:
    """Legendre's polynomials of orders 1 to `order` over the range of `values`."""
    read = values[residuals.read]
    low, width = float(np.min(read, initial=np.inf)), float(np.ptp(read)) if read.size else 0.0
    if not width > 0:
        return np.zeros((values.size, 0))
    distinct = np.unique(np.round((read - low) / (width * _RESOLUTION))).size
    x = np.where(residuals.read, 2 * (values - low) / width - 1, 0.0)
    return np.polynomial.legendre.legvander(x, min(order, distinct - 1))[:, 1:]


def _unit(residuals: Residuals, columns: np.ndarray) -> np.ndarray:
    """`columns` scaled to a mean square of 1 over all readings."""
    weight = residuals.weight**2
    square = np.sum(weight[:, None] * columns**2, axis=0) / max(float(weight.sum()), 1e-300)
    return columns[:, square > 0] / np.sqrt(square[square > 0])


def _count_runs(residuals: Residuals) -> list[tuple[str, int, int]]:
    """Numbers of neighbors along strain and along pressure, and of those that change sign."""
    read = residuals.read
    sign, level = np.sign(residuals.residual[read]), residuals.level[read]
    strain, branch = residuals.strain[read], residuals.branch[read]
    cell, cells = _cells(strain)
    order = np.lexsort((strain, branch, level))
    sweep = (np.diff(level[order]) == 0) & (np.diff(branch[order]) == 0)
    counts = [_count_changes("strain", sign[order], sweep)]
    if cells:
        # one value for each level in a cell of strain
        weight, levels = residuals.weight[read], int(level.max()) + 1
        key = (cell * levels + level).astype(int)
        mean = np.bincount(key, residuals.residual[read] * weight)
        some = np.flatnonzero(np.bincount(key, weight) > 0)
        one_cell = np.diff(some // levels) == 0
        counts.append(_count_changes("pressure", np.sign(mean[some]), one_cell))
    return [count for count in counts if count[1] >= _MIN_PAIRS]


def _count_changes(along: str, sign: np.ndarray, neighbors: np.ndarray) -> tuple[str, int, int]:
    pairs = neighbors & (sign[1:] != 0) & (sign[:-1] != 0)
    return along, int(np.sum(pairs)), int(np.sum(pairs & (sign[1:] != sign[:-1])))


def _test_runs(runs: list[tuple[str, int, int]], tests: int) -> tuple[Runs, ...]:
    chances = [float(bdtr(changes, pairs, 0.5)) for _, pairs, changes in runs]
    return tuple(
        Runs(*run, chance, chance * tests < ALPHA)
        for run, chance in zip(runs, chances, strict=True)
    )


def _cells(strain: np.ndarray) -> tuple[np.ndarray, int]:
    """Cell of each strain, and the number of cells: a table's strains, or even steps of a sweep."""
    width = float(np.ptp(strain)) if strain.size else 0.0
    if not width > 0:
        return np.zeros(strain.size, dtype=int), 0
    order = np.sort(strain)
    edges = np.flatnonzero(np.diff(order) > 2 * _RESOLUTION * width)
    starts = order[np.concatenate([[0], edges + 1])]
    ends = order[np.concatenate([edges, [order.size - 1]])]
    if starts.size <= 2 * _CELLS and np.max(ends - starts) <= 2 * _RESOLUTION * width:
        return np.searchsorted(starts, strain, "right") - 1, starts.size
    cell = np.minimum(((strain - order[0]) / width * _CELLS).astype(int), _CELLS - 1)
    return cell, _CELLS


def _signs(residuals: Residuals) -> tuple[Signs, ...]:
    """Strains where so many residuals are of one sign that it is no chance, the clearest first."""
    strain, residual = residuals.strain[residuals.read], residuals.residual[residuals.read]
    cell, cells = _cells(strain)
    out = []
    for i in range(cells):
        count, below = int(np.sum(cell == i)), int(np.sum(residual[cell == i] < 0))
        if count and 2 * cells * bdtr(min(below, count - below), count, 0.5) < ALPHA:
            out.append(Signs(float(np.mean(strain[cell == i])), count, below))
    return tuple(sorted(out, key=lambda signs: -abs(2 * signs.below - signs.count)))


def _at_rest(residuals: Residuals) -> tuple[tuple[float, float], ...]:
    """Pressures [Pa] and mean residuals [N] in the cell of least strain."""
    read = residuals.read
    first = _cells(residuals.strain[read])[0] == 0
    level, weight = residuals.level[read][first].astype(int), residuals.weight[read][first]
    if not level.size:
        return ()
    # residuals are multiplied by the root of what they average, as the weight is
    count = np.bincount(level, weight**2)
    total = np.bincount(level, residuals.residual[read][first] * weight)
    P = np.bincount(level, residuals.pressure[read][first] * weight**2)
    some = count > 0
    pairs = P[some] / count[some], total[some] / count[some]
    return tuple(zip(*(column.tolist() for column in pairs), strict=True))


def autocorrelation_inflation(residuals: Residuals, diagnosis: Diagnosis) -> float:
    """Factor by which residuals that follow one another along a sweep widen a variance [-].

    Of what is left beside the trends that were found: $(1 + \\rho)/(1 - \\rho)$ with the
    correlation $\\rho$ from one to the next; 1 unless that is more than chance allows.
    """
    read, y = residuals.read, residuals.residual
    if diagnosis.significant:
        y = project_out(span(np.hstack([trend.columns for trend in diagnosis.significant])), y)
    order = np.lexsort((residuals.strain[read], residuals.branch[read], residuals.level[read]))
    y, level, branch = (v[read][order] for v in (y, residuals.level, residuals.branch))
    pairs = (np.diff(level) == 0) & (np.diff(branch) == 0)
    total = float(y @ y)
    rho = float(np.sum((y[1:] * y[:-1])[pairs])) / total if total > 0 else 0.0
    rho = min(max(rho, 0.0), 0.99)
    return (1 + rho) / (1 - rho) if rho > 3 / np.sqrt(max(y.size, 1)) else 1.0


def discrepancy_sizes(residuals: Residuals, diagnosis: Diagnosis) -> list[tuple[float, int]]:
    """$\\tau^2$ [N²] of each significant trend by (C11), and the number of orders it is known
    from.
    """
    basis, out = residuals.model_subspace, []
    for trend in diagnosis.significant:
        away, Q = project_out(basis, trend.columns), residuals.beyond(basis, trend.columns)
        explained = float(np.sum((Q.T @ residuals.residual) ** 2))
        excess = explained - diagnosis.noise**2 * Q.shape[1]
        out.append((max(excess / float(np.sum(away**2)), 0.0), Q.shape[1]))
        basis = span(np.hstack([basis, trend.columns]))
    return out


def _trend_covariance(
    fit: Fit, diagnosis: Diagnosis, sizes: list[tuple[float, int]]
) -> np.ndarray | None:
    """Covariance of the coordinates that the significant trends add, (C12)."""
    if not sizes:
        return None
    problem, k = fit.problem, len(fit.coordinates)
    J, used = fit.minimum.linear.slopes[:, :k], problem.grid.measured.reshape(-1)
    # residuals fall by this much for each newton that the model errs
    scale = problem.weight.reshape(-1)[used] / fit.minimum.solved_noise
    influence = np.linalg.solve(J.T @ J, J[: used.size][used].T * scale)
    total = np.zeros((k, k))
    for trend, (variance, orders) in zip(diagnosis.significant, sizes, strict=True):
        moved = influence @ trend.columns[: int(np.sum(used))]
        wide = float(stdtrit(orders, _LEVEL)) / NORMAL
        total += variance * wide**2 * moved @ moved.T
    return total


def _discrepancy(
    problem: Problem, residuals: Residuals, diagnosis: Diagnosis, sizes: list[tuple[float, int]]
) -> np.ndarray:
    """Columns of the discrepancy at the places of the grid, each times its $\\tau$ [N]."""
    used = problem.grid.measured
    count = int(np.sum(used))
    columns = [
        np.sqrt(variance) * trend.columns[:count] / residuals.weight[:count, None]
        for trend, (variance, _) in zip(diagnosis.significant, sizes, strict=True)
    ]
    out = np.zeros((*used.shape, sum(column.shape[1] for column in columns)))
    if columns:
        out[used] = np.hstack(columns)
    return out


def find_causes(fit: Fit, residuals: Residuals, diagnosis: Diagnosis) -> tuple[Cause, ...]:
    """Causes that would explain much of the `residuals`, the likeliest first; none where these
    could be noise.
    """
    if diagnosis.is_white_noise or not np.isfinite(diagnosis.noise):
        return ()
    free = float(np.sum(residuals.read)) - residuals.slopes.shape[1]
    out: dict[str, Cause] = {}
    for (name, remedy), columns in _cause_columns(fit, residuals):
        Q = residuals.beyond(residuals.model_subspace, residuals.rows(columns))
        if not Q.shape[1]:
            continue
        explained = float(np.sum((Q.T @ residuals.residual) ** 2))
        chance = fdtrc(Q.shape[1], free, explained / Q.shape[1] / diagnosis.noise**2)
        share = min(explained / residuals.squares, 1.0)
        if share >= _WORTH and chance < ALPHA and share > getattr(out.get(name), "share", 0.0):
            out[name] = Cause(name, remedy, share)
    likely = sorted(out.values(), key=lambda cause: -cause.share)[:_MAX_CAUSES]
    return tuple(cause for cause in likely if cause.share >= _NEXT * likely[0].share)


def confounded_parameters(fit: Fit, residuals: Residuals) -> tuple[str, ...]:
    """Names of constants that weren't fitted and that the data could not tell beside those that
    were.
    """
    out = []
    for name, columns in _held_columns(fit, residuals):
        away = project_out(residuals.model_subspace, residuals.rows(columns))
        known = float(np.sum(away**2))
        if name != "dead_band" and known * KNOWN**2 < fit.minimum.solved_noise**2:
            out.append(name)
    return tuple(out)


def _held_columns(fit: Fit, residuals: Residuals) -> Iterator[tuple[str, np.ndarray]]:
    """Change of the force [N] with the coordinate of each constant that wasn't free."""
    problem = fit.problem
    held = tuple(parameter for parameter in problem.held if parameter not in FACTORS)
    slopes = held_slopes(problem, fit.coordinates, held)[problem.grid.measured]
    priors = residuals.weight.size - len(slopes)
    for parameter, column in zip(held, slopes.T, strict=True):
        if np.all(np.isfinite(column)):
            yield parameter.name, np.pad(column, (0, priors))


def held_slopes(problem: Problem, point: np.ndarray, held: tuple) -> np.ndarray:
    """Slopes of the forces [N] at a `point` by the coordinates of `held` parameters, on the last
    axis.
    """
    muscle = put(problem.parameters, problem.muscle, point)
    alone = replace(problem, muscle=muscle, parameters=held)
    z = np.asarray(coordinates(held, muscle), float)
    return alone.force_slopes(z, alone.force(z), fine=True)


def _cause_columns(fit: Fit, residuals: Residuals) -> Iterator[tuple[tuple[str, str], np.ndarray]]:
    """Change of the force [N] by each cause, to any scale, at the residuals' rows."""
    problem, used = fit.problem, fit.grid.measured
    priors = residuals.weight.size - int(np.sum(used))
    about = {parameter.name: parameter.about for parameter in problem.held}
    for name, column in _held_columns(fit, residuals):
        yield (_CONSTANTS.get(name, f"{name}, {about[name]}"), f"free {name}"), column
    stretched = replace(problem.grid, strain=problem.grid.strain + _STRAIN_STEP)
    moved = replace(problem, grid=stretched).force(fit.coordinates)
    slope = (np.pad(moved[used], (0, priors)) - residuals.force) / _STRAIN_STEP
    strain = residuals.strain
    columns = {
        "compliance": slope * residuals.force,
        "ends": slope * strain,
        "length": slope,
        "zero": np.ones(strain.size),
        "rubber": np.stack([strain, strain**2, strain**3], axis=-1),
    }
    if {1, -1} <= set(np.unique(residuals.branch[residuals.read])):
        columns["friction"] = _branch_columns(residuals)
    if np.all(np.isfinite(residuals.time[residuals.read])):
        columns["drift"] = np.nan_to_num(residuals.time)
    for kind, column in columns.items():
        yield _CAUSES[kind], column


def other_buckling_law(fit: Fit, diagnosis: Diagnosis) -> Cause | None:
    """The buckling law that explains much of what a fit left past the free strain; `None` where
    residuals could be noise, lie elsewhere, or no other law is better.
    """
    errors, level = fit.errors, fit.fit_data.level
    measured = np.isfinite(errors)
    if diagnosis.is_white_noise or not np.isfinite(diagnosis.noise) or not np.any(measured):
        return None
    record, muscle = fit.record, fit.muscle
    scale = 1.0 if record.rest_length is None else record.rest_length / float(muscle.length)
    strain = np.clip(record.strain * scale, 0.0, LARGEST_STRAIN)
    past = measured & (strain > fit.free_strain[level])
    if np.sum(errors[past] ** 2) < _MOSTLY * np.sum(errors[measured] ** 2):
        return None
    index = np.flatnonzero(past)
    index = index[np.linspace(0, index.size - 1, min(index.size, _MAX_COMPARED)).astype(int)]
    pressure = np.clip(record.pressure[index], 0.0, HIGHEST_PRESSURE)

    def squares(muscle: Muscle) -> float:
        """Least mean square error [N²] of a muscle with the best factors."""
        names = ["youngs_modulus_factor", "collapse_moment_factor"]
        parameters = select_parameters(names, muscle)
        start = np.asarray(coordinates(parameters, muscle))

        def residuals(z: np.ndarray) -> np.ndarray:
            law = put(parameters, muscle, np.clip(z, start - _FARTHEST, start + _FARTHEST))
            force = np.asarray(law.force(pressure, strain[index]))
            return np.nan_to_num(record.force[index] - force, nan=1e9)

        return 2 * least_squares(residuals, start, max_nfev=_MAX_CALLS).cost / index.size

    names = [name for name in _LAWS if name != muscle.buckling.name]
    mean_squares = {name: squares(muscle.replace(buckling=name)) for name in names}
    best = min(mean_squares, key=mean_squares.__getitem__)
    present = min(squares(muscle), float(np.mean(errors[index] ** 2)))
    share = 1 - mean_squares[best] / present
    if share < _WORTH:
        return None
    rmse = float(np.sqrt(mean_squares[best]))
    name = f"the law past the free strain: `{best}` errs by {rmse:.3g} N there"
    return Cause(name, f"fit with `--buckling {best}`", float(share))
