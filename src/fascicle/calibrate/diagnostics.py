r"""Residual diagnostics: trends, runs of one sign, their likely causes, and the model's own error.

Let $y$ be the residuals of $n$ readings, $J$ the fit's Jacobian, and $B$ polynomials along which
the residuals may vary. $Q$ spans the part of $B$ that $J$ does not explain, $R$ the same part of
all such polynomials together. Then

$$F = \frac{\lVert Q^T y \rVert^2 / \operatorname{rank} Q}
      {(\lVert y \rVert^2 - \lVert R^T y \rVert^2) / (n - p - \operatorname{rank} R)} \tag{C9}$$

follows Fisher's distribution if the residuals are noise, with $p$ fitted constants. Trends are
tested along strain, pressure, both together, branch and time; the most significant one is taken
first, the others are tested after it. Neighboring residuals change sign half of the time if they
are noise; the probability of fewer changes, along strain in a sweep or along pressure at one
strain, is a binomial tail. All tests together mistake noise for a trend in 1 % of records
(Bonferroni).

A fit makes residuals orthogonal to its own Jacobian, so the model error that its constants have
absorbed is invisible. That error is assumed to be as large as the visible one. The model gets a
smooth discrepancy

$$F = \mu(z) + B b + e, \qquad b \sim N(0, \tau^2), \tag{C10}$$

with the polynomials $B$ of each significant trend. Its size follows from the expectation of the
explained sum of squares (Henderson's method III),

$$E \lVert Q^T y \rVert^2 = \tau^2 \lVert (1 - T T^T) B \rVert^2 + \sigma^2 \operatorname{rank} Q,
  \tag{C11}$$

where $T$ spans everything fitted before. The covariance of the constants grows by the shift that
such errors cause,

$$C_d = \tau^2 (t/1.645)^2\, G B B^T G^T, \qquad G = (J^T J)^{-1} J^T, \tag{C12}$$

with Student's quantile $t$, since $\tau$ is estimated from a few orders only.

The share of the residuals' squares that each known cause would explain, after the fit, is computed
to first order: it hints at a cause and is no fit.

**Assumes** that the discrepancy is smooth, and no larger where the fit absorbed it than elsewhere.
**Source:** Fisher (1922); Wald and Wolfowitz (1940) for runs, here about zero; Kennedy and O'Hagan
(2001) for the discrepancy; Henderson (1953) for its size.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from scipy.special import bdtr, fdtrc, stdtrit

from .calibration import Calibration, Cause, Diagnosis, Runs, Trend
from .least_squares import KNOWN, MIN_FREEDOM, NORMAL, Problem
from .parameters import FACTORS, GAUGE_UNITS, Parameter, coordinates, put


# causes that a constant which was not free would make up for
_CAUSES_BY_CONSTANT = {
    "active_length": "passive_length", "inactive_length": "passive_length",
    "end_compliance": "compliance", "c10": "modulus", "c01": "modulus",
}  # fmt: skip
ALPHA = 0.01  # probability of taking noise for a trend, all tests of a record together
_ORDERS = 5  # highest order of a polynomial: a trend is smoother, noise is rougher
_SMALL = 0.25  # of the root mean square: a fifth of normal residuals is smaller
_MIN_PAIRS = 8  # neighbors: with fewer even no change of sign has a probability above 0.4 %
_RESOLUTION = 2e-3  # of the range: closer strains count as equal, as a test stand repeats them
_CELLS = 12  # cells of a swept strain: enough to show a bow, with several readings in each
_RANK = 1e-6  # of a column's size: as exact as finite differences, columns below it are dependent
_READING_SHARE = 0.5  # of a direction's square: more lies in readings than in priors
_QUANTILE = 0.95  # both ends of a 90 % interval
_MIN_SHARE = 0.2  # of the residuals' squares: a smaller cause would not help
_TIED_SHARE = 0.8  # of the best cause's share: first-order shares are no more exact than that
_MAX_CAUSES = 3  # causes in a message that is still read
_STRAIN_STEP = 1e-6  # for the force's slope: errors of rounding and of the step are alike


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of the measured readings, followed by rows of the priors, which show what a
    constant held by its prior has not absorbed.

    - `residual`: measured less fitted force [N], times the root of the number of readings averaged.
    - `slopes`: its Jacobian [N] by the coordinates, then by the curves of the readings.
    - `weight`: root of the number of readings averaged; 0 for a prior.
    - `strain` [-], `pressure` [Pa], `branch`, `time` [s], the model's `force` [N] and the `level`
      of each reading; meaningless for priors.
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
    def is_reading(self) -> np.ndarray:
        """Mask of the rows that are readings."""
        return self.weight > 0

    @cached_property
    def readings(self) -> "Residuals":
        """Residuals without the priors' rows."""
        mask = self.is_reading
        return Residuals(*(getattr(self, field.name)[mask] for field in fields(self)))

    @property
    def squares(self) -> float:
        """Sum of squares of the readings' residuals [N²]."""
        return float(np.sum(self.readings.residual**2))

    @property
    def trend_columns(self) -> dict[str, np.ndarray]:
        """Columns to regress residuals on: "branch" if both occur; "time", if it is known."""
        columns = {}
        if {1, -1} <= set(np.unique(self.readings.branch)):
            # a loop's width grows with pressure
            columns["branch"] = np.stack([self.branch, self.branch * self.pressure], axis=-1)
        if np.all(np.isfinite(self.readings.time)):
            columns["time"] = np.nan_to_num(self.time)
        return columns

    @cached_property
    def model_subspace(self) -> np.ndarray:
        """Orthonormal basis of the changes that the fitted constants can absorb."""
        return span(self.slopes)

    def complement(self, basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Orthonormal basis of the part of `columns` outside the span of an orthonormal `basis`,
        without directions that a constant would absorb but for its prior.
        """
        Q = span(project_out(basis, columns))
        return Q[:, np.sum(Q[self.is_reading] ** 2, axis=0) > _READING_SHARE]

    def weighted(self, values: np.ndarray) -> np.ndarray:
        """Columns to regress on: `values` of the readings times their weight, zero for priors."""
        columns = np.asarray(values, dtype=float).reshape(self.weight.size, -1)
        return np.where(self.is_reading[:, None], columns * self.weight[:, None], 0.0)


def diagnose(fit: Calibration) -> Diagnosis:
    """Diagnose the residuals of a `fit`."""
    residuals = residuals_of(fit)
    effects, diagnosis = _effects_of_constants(fit, residuals), find_trends(residuals)
    diagnosis = replace(diagnosis, past_free_strain=_share_past(fit, residuals, diagnosis))
    covariance, discrepancy = _model_error(fit, residuals, diagnosis)
    return replace(
        diagnosis,
        inflation=autocorrelation_inflation(residuals, diagnosis),
        from_pressure=pressure_covariance(fit, residuals),
        covariance=covariance,
        discrepancy=discrepancy,
        causes=_likely_causes(fit, residuals, diagnosis, effects),
        confounded=_confounded_constants(fit, residuals, effects),
    )


def residuals_of(fit: Calibration) -> Residuals:
    """Residuals of a `fit` with their slopes and conditions, then the rows of its priors."""
    problem, data, linear = fit.problem, fit.fit_data, fit.minimum.linear
    # residuals and priors are relative to the noise that the problem was solved with
    grid, noise, k = problem.grid, fit.minimum.solved_noise, len(problem.parameters)
    measured = problem.tested
    weight = grid.precision[measured]
    residual = weight * (grid.force - linear.force)[measured]
    # outliers keep the reduced weight of the loss; a tuning gives some readings no weight at all
    if problem.loss != "linear":
        softened = linear.residuals[: measured.size].reshape(measured.shape)[measured] * noise
        residual = np.where(softened != 0, softened, residual)
    slopes = -weight[:, None] * linear.force_slopes[measured]
    priors = np.zeros((k, slopes.shape[1]))
    priors[:, :k] = np.diag(noise / problem.deviation)
    prior_residual = (fit.coordinates - problem.center) * noise / problem.deviation
    pressure, level = np.broadcast_to(grid.pressure, measured.shape), np.indices(measured.shape)[0]
    columns = (grid.strain, pressure, data.branch, data.time, linear.force, level)
    rows = [np.concatenate([residual, prior_residual]), np.concatenate([slopes, priors])]
    zeros = np.zeros(k)
    rows += [np.append(row, zeros) for row in (weight, *(values[measured] for values in columns))]
    return Residuals(*rows)


def span(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the span of `columns`."""
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns[:, scale > 0] / scale[scale > 0]
    if not scaled.size:
        return np.zeros((len(columns), 0))
    basis, size, _ = np.linalg.svd(scaled, full_matrices=False)
    return basis[:, size > _RANK * size[0]]


def project_out(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Part of `columns` orthogonal to the span of an orthonormal `basis`."""
    remainder = columns - basis @ (basis.T @ columns)
    remainder = remainder - basis @ (basis.T @ remainder)  # a second time against rounding
    dependent = np.linalg.norm(remainder, axis=0) < _RANK * np.linalg.norm(columns, axis=0)
    return np.where(dependent, 0.0, remainder)


def find_trends(residuals: Residuals) -> Diagnosis:
    """Test `residuals` for trends and for runs of one sign."""
    columns, model = _trend_columns(residuals), residuals.model_subspace
    trend_space = residuals.complement(model, np.hstack(list(columns.values())))
    # a constant that its prior holds does not count as fitted
    constants = float(np.sum(model[residuals.is_reading] ** 2))
    freedom = len(residuals.readings.residual) - constants - trend_space.shape[1]
    runs = _count_runs(residuals.readings)
    tests = len(runs) + (len(columns) if freedom >= MIN_FREEDOM else 0)
    runs = tuple(replace(run, found=run.chance * tests < ALPHA) for run in runs)
    if freedom < MIN_FREEDOM:
        return Diagnosis(runs=runs)
    y, squares = residuals.residual, max(residuals.squares, 1e-300)  # of a perfect fit: 0
    remainder = y - model @ (model.T @ y) - trend_space @ (trend_space.T @ y)
    variance = float(np.sum(remainder**2)) / freedom

    def test(along: str, B: np.ndarray) -> Trend:
        """Test one kind of trend by (C9), after the present `basis`."""
        Q = residuals.complement(basis, B)
        explained, chance = float(np.sum((Q.T @ y) ** 2)), 1.0
        if Q.shape[1] and variance > 0:
            chance = float(fdtrc(Q.shape[1], freedom, explained / Q.shape[1] / variance))
        return Trend(along, min(explained / squares, 1.0), chance, False, B)

    trends: list[Trend] = []
    basis = model
    while columns:
        trials = [test(along, B) for along, B in columns.items()]
        best = min(trials, key=lambda trend: trend.chance)
        if best.chance * tests >= ALPHA:
            trends += trials
            break
        trends.append(replace(best, found=True))
        basis = span(np.hstack([basis, columns.pop(best.along)]))
    return Diagnosis(tuple(trends), runs, float(np.sqrt(variance)))


def _trend_columns(residuals: Residuals) -> dict[str, np.ndarray]:
    """Weighted polynomials of mean square 1, by the direction of the trend."""
    strain = _legendre(residuals, residuals.strain, _ORDERS)
    pressure = _legendre(residuals, residuals.pressure, _ORDERS)
    S, P = strain.T, pressure.T
    # orders 1 and 1, 2 and 1, 1 and 2, as far as there are
    products = [s * p for i, s in enumerate(S[:2]) for p in P[: 2 - i]]
    # a constant error counts as one along strain
    kinds = {"strain": np.insert(strain, 0, 1.0, axis=1), "pressure": pressure}
    if products:
        kinds["strain and pressure"] = np.stack(products, axis=-1)
    kinds |= residuals.trend_columns
    if "time" in kinds:
        kinds["time"] = _legendre(residuals, kinds["time"], 2)
    weight, scaled = residuals.weight**2, {}
    for along, columns in kinds.items():
        # never divides by zero: if all weights are zero, no column is left
        square = weight @ columns**2 / max(float(weight.sum()), 1e-300)
        if np.any(square > 0):
            unit = columns[:, square > 0] / np.sqrt(square[square > 0])
            scaled[along] = residuals.weighted(unit)
    return scaled


def _legendre(residuals: Residuals, values: np.ndarray, order: int) -> np.ndarray:
    """Legendre polynomials of orders 1 to `order` over the range of `values`."""
    mask = residuals.is_reading
    low, width = np.min(values[mask], initial=np.inf), np.ptp(values[mask]) if mask.any() else 0.0
    if not width > 0:
        return np.zeros((values.size, 0))
    distinct = np.unique(np.round((values[mask] - low) / (width * _RESOLUTION))).size
    x = np.where(mask, 2 * (values - low) / width - 1, 0.0)
    return np.polynomial.legendre.legvander(x, min(order, distinct - 1))[:, 1:]


def _count_runs(readings: Residuals) -> list[Runs]:
    """Changes of sign between neighbors along strain and along pressure."""
    order = np.lexsort((readings.strain, readings.branch, readings.level))
    # a gauge that rounds leaves many small residuals, whose signs are those of the fit's offset
    size = np.abs(readings.residual[order])
    order = order[size > _SMALL * np.sqrt(np.mean(size**2))] if size.size else order
    level, branch = readings.level[order], readings.branch[order]
    sweep = (np.diff(level) == 0) & (np.diff(branch) == 0)
    counted = [("strain", np.sign(readings.residual[order]), sweep)]
    cell, cells = _cells(readings.strain)
    if cells:
        # one mean for each level in a cell of strain
        levels = int(readings.level.max()) + 1
        key = (cell * levels + readings.level).astype(int)
        mean = np.bincount(key, readings.residual * readings.weight)
        index = np.flatnonzero(np.bincount(key, readings.weight) > 0)
        counted.append(("pressure", np.sign(mean[index]), np.diff(index // levels) == 0))
    runs = []
    for along, sign, neighbors in counted:
        pairs = neighbors & (sign[1:] != 0) & (sign[:-1] != 0)
        count, changes = int(np.sum(pairs)), int(np.sum(pairs & (sign[1:] != sign[:-1])))
        if count >= _MIN_PAIRS:
            runs.append(Runs(along, count, changes, float(bdtr(changes, count, 0.5)), False))
    return runs


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


def autocorrelation_inflation(residuals: Residuals, diagnosis: Diagnosis) -> float:
    """Factor by which correlation along a sweep widens a variance [-]: $(1 + \\rho)/(1 - \\rho)$
    with the correlation $\\rho$ of neighboring residuals, after the significant trends.
    """
    y, readings, mask = residuals.residual, residuals.readings, residuals.is_reading
    if diagnosis.significant:
        y = project_out(span(np.hstack([trend.columns for trend in diagnosis.significant])), y)
    order = np.lexsort((readings.strain, readings.branch, readings.level))
    y, level, branch = y[mask][order], readings.level[order], readings.branch[order]
    pairs = (np.diff(level) == 0) & (np.diff(branch) == 0)
    total = float(y @ y)
    rho = float(np.sum((y[1:] * y[:-1])[pairs])) / total if total > 0 else 0.0
    rho = min(max(rho, 0.0), 0.99)
    # three standard errors of a correlation of white noise
    return (1 + rho) / (1 - rho) if rho > 3 / np.sqrt(max(y.size, 1)) else 1.0


def pressure_covariance(fit: Calibration, residuals: Residuals) -> np.ndarray:
    """Covariance of the coordinates [-] from the standard errors of the levels' mean pressures,
    which are common to all readings of a level.
    """
    data, problem, k = fit.fit_data, fit.problem, len(fit.coordinates)
    measured, P = problem.tested, problem.grid.pressure
    pressure, count = data.record.pressure, np.bincount(data.level)
    scatter = pressure - (np.bincount(data.level, pressure) / count)[data.level]
    square = np.bincount(data.level, scatter**2)
    error = np.sqrt(square / np.maximum(count - 1, 1) / count)
    if not np.any(error):
        return np.zeros((k, k))
    shifted = replace(problem, grid=replace(problem.grid, pressure=P + error[:, None]))
    change = np.nan_to_num(shifted.force(fit.coordinates) - fit.minimum.linear.force)
    effects = np.zeros((len(residuals.residual), len(P)))
    level = np.nonzero(measured)[0]
    effects[np.arange(len(level)), level] = (problem.grid.precision * change)[measured]
    by_level = np.linalg.pinv(residuals.slopes[:, :k]) @ effects
    return by_level @ by_level.T


def discrepancy_sizes(residuals: Residuals, diagnosis: Diagnosis) -> list[tuple[float, int]]:
    """$\\tau^2$ [N²] of each significant trend by (C11), and the number of orders it rests on."""
    basis, sizes = residuals.model_subspace, []
    for trend in diagnosis.significant:
        Q = residuals.complement(basis, trend.columns)
        explained = float(np.sum((Q.T @ residuals.residual) ** 2))
        excess = explained - diagnosis.noise**2 * Q.shape[1]
        visible = float(np.sum(project_out(basis, trend.columns) ** 2))
        sizes.append((max(excess / visible, 0.0), Q.shape[1]))
        basis = span(np.hstack([basis, trend.columns]))
    return sizes


def _model_error(
    fit: Calibration, residuals: Residuals, diagnosis: Diagnosis
) -> tuple[np.ndarray | float, np.ndarray]:
    """Covariance that the model's error adds to that of the coordinates, (C12), and columns of the
    error on the grid [N].
    """
    problem, k, measured = fit.problem, len(fit.coordinates), fit.problem.tested
    if not diagnosis.significant:
        return 0.0, np.zeros((*measured.shape, 0))
    n = int(np.sum(measured))
    J, mask = fit.minimum.linear.slopes[:, :k], measured.reshape(-1)
    # change of the scaled residuals with each newton of model error
    scale = problem.weight.reshape(-1)[mask] / fit.minimum.solved_noise
    influence = np.linalg.solve(J.T @ J, J[: mask.size][mask].T * scale)
    covariance, columns = np.zeros((k, k)), []
    sizes = discrepancy_sizes(residuals, diagnosis)
    for trend, (variance, orders) in zip(diagnosis.significant, sizes, strict=True):
        shift = influence @ trend.columns[:n]
        widening = float(stdtrit(orders, _QUANTILE)) / NORMAL
        covariance += variance * widening**2 * shift @ shift.T
        columns.append(np.sqrt(variance) * trend.columns[:n] / residuals.weight[:n, None])
    discrepancy = np.zeros((*measured.shape, sum(column.shape[1] for column in columns)))
    discrepancy[measured] = np.hstack(columns)
    return covariance, discrepancy


def force_slopes_of(
    problem: Problem, point: np.ndarray, parameters: tuple[Parameter, ...]
) -> np.ndarray:
    """Slopes of the forces [N] at a `point` by coordinates of other `parameters`, last axis."""
    muscle = put(problem.parameters, problem.muscle, point)
    varied = replace(problem, muscle=muscle, parameters=parameters)
    z = np.asarray(coordinates(parameters, muscle), float)
    return varied.force_and_slopes(z, fine=True)[1]


def _effects_of_constants(fit: Calibration, residuals: Residuals) -> dict[Parameter, np.ndarray]:
    """Change of the force [N] with the coordinate of each constant that was not free."""
    problem = fit.problem
    constants = tuple(parameter for parameter in problem.held if parameter not in FACTORS)
    slopes = force_slopes_of(problem, fit.coordinates, constants)[problem.tested]
    columns = np.pad(slopes, ((0, residuals.weight.size - len(slopes)), (0, 0))).T
    pairs = zip(constants, columns, strict=True)
    return {constant: column for constant, column in pairs if np.all(np.isfinite(column))}


def _confounded_constants(
    fit: Calibration, residuals: Residuals, effects: dict[Parameter, np.ndarray]
) -> tuple[str, ...]:
    """Names of constants that were not fitted and that the data can't tell from the fitted ones."""

    def information(column: np.ndarray) -> float:
        distinct = project_out(residuals.model_subspace, residuals.weighted(column))
        return float(np.sum(distinct**2)) / fit.minimum.solved_noise**2

    columns = {constant.name: column for constant, column in effects.items()}
    if not fit.fit_data.reads_contraction and "force_gain" not in fit.names:
        columns["force_gain"] = GAUGE_UNITS["force_gain"] * residuals.force
    names = [name for name, column in columns.items() if information(column) * KNOWN**2 < 1]
    return tuple(name for name in names if name != "dead_band")


def _share_past(fit: Calibration, residuals: Residuals, diagnosis: Diagnosis) -> float:
    """Share of the significant trends' squares that lies past the free strain [-]."""
    if fit.problem.pulls or not diagnosis.significant:
        return 0.0
    trends = np.hstack([trend.columns for trend in diagnosis.significant])
    Q, readings = residuals.complement(residuals.model_subspace, trends), residuals.readings
    square = (Q @ (Q.T @ residuals.residual))[residuals.is_reading] ** 2
    past = readings.strain * fit.strain_scale > fit.free_strain[readings.level.astype(int)]
    return float(np.sum(square[past]) / np.sum(square))


def _likely_causes(
    fit: Calibration,
    residuals: Residuals,
    diagnosis: Diagnosis,
    effects: dict[Parameter, np.ndarray],
) -> tuple[Cause, ...]:
    """Causes that would explain much of the residuals, the likeliest first; none of noise."""
    if diagnosis.is_white_noise or not np.isfinite(diagnosis.noise):
        return ()
    if diagnosis.resisting_law_in_doubt:
        share = sum(trend.share for trend in diagnosis.significant)
        return (Cause("resisting_law", min(share, 1.0)),)
    problem, measured, strain = fit.problem, fit.problem.tested, residuals.strain
    stretched = replace(problem.grid, strain=problem.grid.strain + _STRAIN_STEP)
    force = replace(problem, grid=stretched).force(fit.coordinates)[measured]
    force = np.pad(force, (0, strain.size - force.size))
    slope = (force - residuals.force) / _STRAIN_STEP
    trials = [(_CAUSES_BY_CONSTANT.get(p.name, p.name), p.name, x) for p, x in effects.items()]
    trials += [
        ("compliance", "", slope * residuals.force),
        ("unswelling_ends", "", slope * strain),
        ("length_zero", "", slope),
        ("load_cell_zero", "", np.ones(strain.size)),
        ("rubber", "", np.stack([strain, strain**2, strain**3], axis=-1)),
    ]
    trends = residuals.trend_columns
    # one cycle of friction is like a drift
    drift = "drift" if "branch" in trends else "drift_or_friction"
    codes = {"branch": "friction", "time": drift}
    trials += [(codes[along], "", column) for along, column in trends.items()]
    freedom = len(residuals.readings.residual) - residuals.slopes.shape[1]
    causes: dict[str, Cause] = {}
    for code, constant, column in trials:
        Q = residuals.complement(residuals.model_subspace, residuals.weighted(column))
        if not Q.shape[1]:
            continue
        explained = float(np.sum((Q.T @ residuals.residual) ** 2))
        chance = fdtrc(Q.shape[1], freedom, explained / Q.shape[1] / diagnosis.noise**2)
        share = min(explained / residuals.squares, 1.0)
        better = code not in causes or share > causes[code].share
        if share >= _MIN_SHARE and chance < ALPHA and better:
            causes[code] = Cause(code, share, constant)
    likely = sorted(causes.values(), key=lambda cause: -cause.share)[:_MAX_CAUSES]
    return tuple(cause for cause in likely if cause.share >= _TIED_SHARE * likely[0].share)
