r"""The least-squares problem of a fit, its solution, and the uncertainty at the minimum.

A measured force $F$, the mean of $n$ readings that scatter by $\sigma$, leaves the residual

$$r = \sqrt{n}\, \frac{F - \mu}{\sigma}, \tag{C1}$$

a censored one, which only says that the force was not above $F$ (zero, or the gauge's floor; with
the other sign of $F - \mu$ not below it, the gauge's ceiling),

$$r = \sqrt{-2 \ln \Phi((F - \mu)/\sigma)}, \tag{C2}$$

so that half the sum of squares is the negative logarithm of the likelihood. Each coordinate's prior
adds $(z - z_0)/\tau$. MINPACK's Levenberg-Marquardt walks from several starts. At the minimum, with
the Jacobian $J$ of the residuals by the coordinates, and $S$ by the readings' curves, whose own
covariance is $\Sigma_s$,

$$C = (J^T J)^{-1} + K \Sigma_s K^T, \qquad K = (J^T J)^{-1} J^T S. \tag{C3}$$

The readings come from where the muscle pulls and the factors from where it resists, so the
two parts are independent. The noise is widened by Student's quantile over the normal one. Errors of
the model come on top of it (`diagnostics`); too few readings to show any count as a usual one.

Where loads were set and contractions read, the deviation of a force is the effective one,

$$\sigma_i = \sigma_\varepsilon \left| \partial F / \partial \varepsilon \right|_i, \tag{C15}$$

with law and slopes at the contractions at which the model bears the loads.

A coordinate is *identifiable* if the data without the prior know it to a deviation below 1, a
factor of e either way.

**Source:** Tobin (1958) for censored regression; Orear (1982) for the effective variance.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import leastsq
from scipy.special import erfcx, log_ndtr, stdtrit

from ..core.array_namespace import array_namespace, maximum, where
from ..core.module import with_fields
from ..core.types import AnyArray, Batch, Float
from ..muscle import Muscle
from .data import FitData, Grid, Table
from .gauges import PERFECT, Gauge
from .parameters import FACTORS, WEAK, Parameter, put, put_gauge
from .readings import Readings, SmoothCurves, top_pressure


LOSSES = ("linear", "soft_l1")
KNOWN = 1.0  # deviation of an identifiable coordinate
NORMAL = 1.6448536269514722  # 95 % quantile: intervals hold 90 %
ROUGH = 1e-4  # of the cost, which is some hundreds: tells which start leads lowest
_CERTAIN = 30.0  # deviations below the limit, where a censored reading says nothing in float64
# steps of finite differences: roots in the law are exact to 1e-12, so a first-order difference is
# good to 1e-6, which is enough for a search, and a second-order one to 1e-8
_FIRST_ORDER, _SECOND_ORDER = 1e-6, 1e-4
_MAX_STEPS = 200  # of the last search; some dozens are usual
_MAX_ROUGH_STEPS = 60  # of a search to `ROUGH` or less: further steps gain far less than noise
_TOLERANCE = 1e-8  # of coordinates: far below any parameter's uncertainty
FINE = 1e-8  # of the cost, which is some hundreds: a few thousandths of a deviation
_NO_NUMBER = 1e9  # deviations, for a residual where the law has no number
_MAX_FEV = 5  # MINPACK's status for all steps taken
_FARTHEST = 1.0  # coordinates that the data don't determine are not sent further
_SEARCHED = 512  # readings of a second search: it only finds where to go on
_NOISE_ROUNDS = 6  # three are usual until the noise settles, five the most that was seen
FIRST_NOISE = 0.02  # of the largest force: where the search for the noise begins
MIN_FREEDOM = 5  # degrees of freedom: with fewer the noise is too uncertain to test against
_LAW_ERROR = 0.005  # of the largest force: what the best fit of a measured muscle leaves
_FIRST_STRAIN = 0.01  # the same, of contractions
_STRAIN_STEP = 1e-6  # for the force's slope: errors of rounding and of the step are alike
_LEAST_SPREAD = 0.05  # of the typical slope: where the force hardly depends on strain, force errs
_LARGEST_STEP = 0.05  # of strain, in a round: laws curve over a tenth

CONVERGED, STOPPED, BROKE = 0, 1, 2
STATUS = ("converged", "stopped", "broke")  # no step gains, all steps taken, no number
Vector = Float[AnyArray, "parameter"]


class Linearization(NamedTuple):
    """A problem at a point: `residuals` of the readings, then of the priors [-], with their
    Jacobian `slopes`; `force` of the model at the readings [N], with its Jacobian `force_slopes`
    [N] on the last axis; `misfits`, the readings' residuals before any loss [-].

    Columns are coordinates, then the curves' coefficients.
    """

    residuals: np.ndarray
    slopes: np.ndarray
    force: np.ndarray
    force_slopes: np.ndarray
    misfits: np.ndarray


@dataclass(frozen=True, eq=False)
class Problem:
    """Data, a muscle to begin with, and the parameters that are free. A point is their coordinates,
    in a joint fit followed by the coefficients of the readings' curves.

    - `weight`: of each reading's residual [-]; 0 leaves it out.
    - `noise`: $\\sigma$ [N] of one reading.
    - `center`, `deviation`: of the prior on each number of a point.
    - `rest_length`: that the data's strains refer to [m]; `None`: the muscle's own.
    - `curves`: coefficients of the curves of $C_1$, $C_2$; `None`: the muscle's own tuning.
    - `pulls`: nothing pushed, so the tension law is enough.
    - `held`: parameters that aren't free, of which the data may tell something.
    - `gauge`: errors of the gauges that the data are corrected for.
    - `branch`: of each reading, for a fitted hysteresis loop; `None`: loops are errors.
    - `strain_slope`: root mean square slope of the force with strain [N] where contractions are in
      error, else 0. The readings then are `observed`, the grid is linear about the model's.
    """

    muscle: Muscle
    grid: Grid
    weight: Table
    noise: float
    center: Vector
    deviation: Vector
    parameters: tuple[Parameter, ...]
    rest_length: float | None = None
    curves: np.ndarray | None = None
    loss: str = "linear"
    pulls: bool = False
    held: tuple[Parameter, ...] = ()
    gauge: Gauge = PERFECT
    branch: np.ndarray | None = None
    strain_slope: float = 0.0
    observed: Grid | None = None

    def gauge_at(self, point: AnyArray) -> Gauge:
        """Gauge with the free errors at a `point`; others as the data are corrected."""
        return put_gauge(self.parameters, self.gauge, point[: len(self.parameters)])

    @cached_property
    def smooth_curves(self) -> SmoothCurves:
        """The readings' curves of the muscle to begin with; factors don't change them."""
        return SmoothCurves(self.muscle, self.grid.pressure[:, 0], top_pressure(self.grid))

    def muscle_at(self, point: AnyArray) -> Muscle:
        """The muscle at a `point`, or a batch of them, with the $C_1$, $C_2$ of any curves."""
        k = len(self.parameters)
        muscle = put(self.parameters, self.muscle, point[:k])
        coefficients = self.curves if len(point) == k else point[k:, ..., None]
        if coefficients is None:
            return muscle
        curves = self.smooth_curves
        # tables have an axis of pressures of their own
        tabulated = put(self.parameters, self.muscle, point[:k, ..., None])
        if not all(parameter in FACTORS for parameter in self.parameters):
            curves = SmoothCurves(tabulated, curves.pressure, top_pressure(self.grid))
        c1, c2 = curves.corrections(coefficients)
        pressures = tabulated.tuning.effective_pressure(curves.pressure)
        tuning = with_fields(muscle.tuning, pressures=pressures, c1=c1, c2=c2)
        return with_fields(muscle, tuning=tuning)

    def strain(self, muscle: Muscle) -> Table:
        """The data's strains [-] as contractions of a `muscle`, which may be shorter than the
        length they were measured on.
        """
        return self.grid.strain * self._strain_scale(muscle)

    def _strain_scale(self, muscle: Muscle) -> Batch:
        return 1.0 if self.rest_length is None else self.rest_length / muscle.length

    def force(self, point: AnyArray) -> Table:
        """Forces [N] of the model at the readings, 0 for padding; axes of a batch come first."""
        force, used = self.reading_forces(point), self.grid.used
        xp, order = array_namespace(force), np.full(used.shape, -1)
        order[used] = np.arange(np.sum(used))
        force = xp.concatenate([force, xp.zeros((*force.shape[:-1], 1))], axis=-1)[..., order]
        return where(used, force, 0.0)

    def reading_forces(self, point: AnyArray) -> Batch:
        """Forces [N] of the model at the readings, row by row."""
        point_at_levels = point[..., None] if point.ndim > 1 else point
        muscle, gauge = self.muscle_at(point_at_levels), self.gauge_at(point_at_levels)
        level, strain, place = self._places
        law, P = muscle.law, self.grid.pressure[:, 0]
        if point.ndim > 1:
            # laws add axes ahead of the pressure's
            P = np.broadcast_to(P, (*point.shape[1:], P.size))
        strain = strain * self._strain_scale(muscle)
        base = self.gauge
        if gauge is not PERFECT:  # pressures below zero are a corrected transducer's noise
            P = maximum(P - (gauge.pressure_zero - base.pressure_zero), 0.0)
            strain = strain - (gauge.displacement_zero - base.displacement_zero) / muscle.length
        with np.errstate(all="ignore"):  # of branches that aren't taken
            if self.pulls:
                force = law.tension.force(P[..., level], strain)
            else:
                force = law.at(P).take(level).pulling_force(strain)
        force = force[..., place]
        if gauge is not base:
            used = self.grid.used
            elapsed = np.broadcast_to(self.grid.elapsed, used.shape)[used]
            force = base.true_force(gauge.read_force(force, elapsed), elapsed)
        if self.branch is not None:
            force = force + loop_force(self.grid, self.branch, self.weight, force)
        return force

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Level and strain [-] of each distinct place, and the place of each reading, row by row:
        readings at a held length share theirs.
        """
        used = self.grid.used
        readings = np.stack([np.nonzero(used)[0], self.grid.strain[used]])
        (level, strain), place = np.unique(readings, axis=1, return_inverse=True)
        return level.astype(int), strain, place

    def force_and_slopes(
        self, point: Vector, columns: np.ndarray | None = None, fine: bool = False
    ) -> tuple[Table, np.ndarray]:
        """Forces [N] at a `point`, and their Jacobian [N] by its numbers, by forward differences.

        Constants that can't fall below zero have a kink there, so that no difference is central;
        `fine` ones are of second order. `columns`: indices of the numbers, by default all.
        """
        columns = np.arange(len(point)) if columns is None else columns
        # curves' coefficients are newtons, the others logarithms
        newtons = np.maximum(1.0, np.abs(point[columns]))
        size = np.where(columns < len(self.parameters), 1.0, newtons)
        size = size * (_SECOND_ORDER if fine else _FIRST_ORDER)
        step = size * (np.arange(len(point))[:, None] == columns)
        steps = [0.0 * point[:, None], step, *([2 * step] if fine else [])]
        points = point[:, None] + np.concatenate(steps, axis=1)
        forces = self.reading_forces(points)
        n, used = len(columns), self.grid.used
        rise = forces[1 : n + 1] - forces[0]
        if fine:
            # in this form a force that doesn't change has a slope of exactly zero
            rise = 2 * rise - (forces[n + 1 :] - forces[0]) / 2
        force, slopes = np.zeros(used.shape), np.zeros((*used.shape, n))
        force[used], slopes[used] = forces[0], rise.T / size
        return force, slopes

    def misfits(self, force: Table) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of the readings [-], (C1) and (C2), at a model's `force` [N], before any loss;
        and their slopes with it [1/N].
        """
        grid, scaled = self.grid, self.grid.precision / self.noise
        missed = (grid.force - force) * scaled
        if not np.any(grid.censored):
            return self.weight * missed, -self.weight * scaled
        side = 1.0 if grid.at_least is None else np.where(grid.at_least, -1.0, 1.0)
        limited = np.minimum(side * missed, _CERTAIN)
        not_above = np.sqrt(-2 * log_ndtr(limited))
        # what chance of a clipped reading is lost with each newton, over the residual
        mills = np.sqrt(2 / np.pi) / erfcx(-limited / np.sqrt(2))
        rises = side * np.where(limited < _CERTAIN, scaled * mills / not_above, 0.0)
        return (
            self.weight * np.where(grid.censored, not_above, missed),
            self.weight * np.where(grid.censored, rises, -scaled),
        )

    @property
    def tested(self) -> np.ndarray:
        """Mask of the measured entries but those after a turn where a loop is fitted."""
        measured: np.ndarray = self.grid.measured
        return measured if self.branch is None else measured & (self.weight > 0)

    def errors(self, force: Table, data: FitData) -> np.ndarray:
        """Measured less a model's `force` [N] of each reading of `data`, NaN where clipped."""
        if self.observed is None:
            return data.errors(force)
        return (self.grid.force - force)[data.level, data.column]

    def contraction_errors(self, force: Table, data: FitData) -> np.ndarray:
        """Errors of contraction [-] of each reading of `data` beside a model's `force` [N]."""
        slope = np.broadcast_to(self.grid.spread, self.grid.count.shape) * self.strain_slope
        return self.errors(force, data) / slope[data.level, data.column]

    def residuals(self, point: Vector, force: Table) -> np.ndarray:
        """Residuals [-] at a `point` with its `force` [N]: readings' under the loss, priors'."""
        softened, _ = soften(self.misfits(force)[0], self.loss)
        return np.concatenate([softened.reshape(-1), (point - self.center) / self.deviation])

    def slopes(self, force: Table, force_slopes: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Jacobian of the residuals [-] by the coordinates `columns`, from that of forces [N]."""
        misfits, by_force = self.misfits(force)
        softer = (by_force * soften(misfits, self.loss)[1]).reshape(-1, 1)
        priors = (np.arange(len(self.center))[:, None] == columns) / self.deviation[:, None]
        return np.concatenate([softer * force_slopes.reshape(force.size, -1), priors])


def loop_force(grid: Grid, branch: np.ndarray, weight: Table, force: Batch) -> Batch:
    """Friction [N] at the used entries of a `grid`, fitted by least squares to residuals from a
    static `force` [N] there: a constant, a term in pressure and one in force, with the sign of the
    `branch`.
    """
    xp, used, top = array_namespace(force), grid.used, np.max(np.abs(grid.force))
    pressure = np.broadcast_to(grid.pressure / top_pressure(grid), used.shape)[used]
    terms = [xp.ones_like(force), 0 * force + pressure, force / top]
    columns, scale = branch[used] * xp.stack(terms, axis=-2), (weight * grid.precision)[used]
    usable = ~grid.censored[used] & (scale > 0) & xp.isfinite(force)
    missed = xp.where(usable, (grid.force[used] - force) * scale, 0.0)
    basis = xp.where(usable[..., None, :], columns * scale, 0.0)
    # a small diagonal for a record with a single pressure
    gram = basis @ xp.swapaxes(basis, -1, -2) + 1e-9 * float(np.sum(grid.count)) * np.eye(3)
    share = xp.linalg.solve(gram, basis @ missed[..., None])
    return xp.sum(share * columns, axis=-2)


def soften(r: np.ndarray, loss: str) -> tuple[np.ndarray, np.ndarray]:
    """Residuals whose squares are the `loss` of `r` [-], and their slopes with `r`."""
    if loss == "linear":
        return r, np.ones_like(r)
    # of two forms of 2 (sqrt(1 + r²) - 1), the one without cancellation
    root = np.sqrt(1 + r**2)
    factor = np.sqrt(2 / (root + 1))
    return r * factor, 1 / (root * factor)


def linearize(problem: Problem, point: Vector, by_curves: bool = False) -> Linearization:
    """Linearize a problem at a `point`; `by_curves`: with columns for a tuning's curves, too."""
    both = point
    if by_curves and problem.curves is not None:
        both = np.concatenate([point, problem.curves])
    force, force_slopes = problem.force_and_slopes(both, fine=True)
    residuals, misfits = problem.residuals(point, force), problem.misfits(force)[0]
    slopes = problem.slopes(force, force_slopes, np.arange(len(both)))
    return Linearization(residuals, slopes, force, force_slopes, misfits)


class SearchEnds(NamedTuple):
    """Ends of a search by start: point, half the sum of squares [-], status, number of steps."""

    points: np.ndarray
    cost: np.ndarray
    status: np.ndarray
    steps: np.ndarray

    @property
    def best(self) -> int:
        """Index of the lowest end."""
        return int(np.argmin(np.where(np.isfinite(self.cost), self.cost, np.inf)))


def solve(
    problem: Problem,
    starts: np.ndarray,
    free_columns: np.ndarray | None = None,
    tolerance: float = FINE,
) -> SearchEnds:
    """Minimize a `problem` by Levenberg-Marquardt from each row of `starts`, by the numbers
    `free_columns`, by default all, until a step wins no more than the `tolerance` of the cost [-].
    """
    columns = np.arange(starts.shape[1]) if free_columns is None else free_columns
    ends = [_walk(problem, start, columns, tolerance) for start in np.asarray(starts, float)]
    return SearchEnds(*map(np.array, zip(*ends, strict=True)))


def _walk(
    problem: Problem, start: np.ndarray, free_columns: np.ndarray, tolerance: float
) -> tuple[np.ndarray, float, int, int]:
    """One walk from `start`: its end, half the sum of squares, status, steps."""
    # MINPACK asks for residuals and Jacobian one after another
    last: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def complete(z: np.ndarray) -> np.ndarray:
        point = start.copy()
        point[free_columns] = z
        return point

    def force_and_slopes(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = z.tobytes()
        if key not in last:
            last.clear()
            last[key] = problem.force_and_slopes(complete(z), free_columns)
        return last[key]

    # padding has no residuals
    rows = np.append(problem.grid.used, np.ones(len(start), dtype=bool))

    def residuals(z: np.ndarray) -> np.ndarray:
        r = problem.residuals(complete(z), force_and_slopes(z)[0])[rows]
        # where the law has no number a step is too far
        return r if np.all(np.isfinite(r)) else np.full(r.size, _NO_NUMBER)

    def jacobian(z: np.ndarray) -> np.ndarray:
        return problem.slopes(*force_and_slopes(z), free_columns)[rows]

    z = start[free_columns]
    r, J = problem.residuals(start, force_and_slopes(z)[0])[rows], jacobian(z)
    if not (np.all(np.isfinite(r)) and np.all(np.isfinite(J))):
        return start, np.nan, BROKE, 0
    if not free_columns.size:
        return start, 0.5 * float(r @ r), CONVERGED, 0
    minpack: Any = leastsq  # its stubs know only the short answer
    end, _, counts, _, flag = minpack(
        residuals, z, Dfun=jacobian, full_output=True, ftol=tolerance,
        # gtol, an angle, would say nothing on the cost that is left
        xtol=_TOLERANCE, gtol=0.0, maxfev=_MAX_STEPS if tolerance < ROUGH else _MAX_ROUGH_STEPS,
    )  # fmt: skip
    # 1 to 4: nothing moves any more, or no step within rounding is left
    r, status = counts["fvec"], STOPPED if flag == _MAX_FEV else CONVERGED
    return complete(end), 0.5 * float(r @ r), status, int(counts["njev"])


def starts_around(
    center: np.ndarray, count: int, seed: int = 0, covariance: np.ndarray | None = None
) -> np.ndarray:
    """A `count` of starts: the `center`, then random ones within a factor of 2, or about twice the
    deviations of a `covariance` away.
    """
    rng, shape = np.random.default_rng(seed), (count - 1, center.size)
    if covariance is None:
        return np.concatenate([center[None], center + np.log(2) * rng.uniform(-1, 1, shape)])
    spread, basis = np.linalg.eigh(np.nan_to_num(covariance))
    scaled = basis * np.sqrt(np.clip(spread, 0, _FARTHEST**2))
    return np.concatenate([center[None], center + 2 * rng.normal(size=shape) @ scaled.T])


class Minimum(NamedTuple):
    """A minimum of a problem: `covariance` of the coordinates, `from_curves` the part that the
    readings' curves cause; the `noise` of a reading by the residuals, and the `solved_noise` of the
    problem [N], which is `linear` there.
    """

    covariance: np.ndarray
    from_curves: np.ndarray
    noise: float
    solved_noise: float
    linear: Linearization


class Solution(NamedTuple):
    """Best `point` of a search [-], its `minimum`, and all `ends`; `readings` of a tuning."""

    problem: Problem
    ends: SearchEnds
    point: np.ndarray
    minimum: Minimum
    readings: Readings | None = None


def minimum_at(
    problem: Problem, point: np.ndarray, curves_covariance: np.ndarray | None
) -> Minimum:
    """Noise and covariance (C3) at a minimum, widened for a noise that few readings tell;
    `curves_covariance`: of the readings' curves.
    """
    linear = linearize(problem, point, by_curves=True)
    k, misfits = len(point), linear.misfits
    noise = usual = residual_noise(problem, misfits, k)
    freedom = np.sum((problem.weight > 0) & problem.grid.measured) - k
    if freedom < MIN_FREEDOM:  # an error of the law would not be seen
        slope, grid = problem.strain_slope, problem.grid
        top = slope * np.abs(grid.strain) if slope else np.abs(grid.force)
        usual = max(noise, _LAW_ERROR * float(np.max(top)))
    usual = usual * float(stdtrit(max(freedom, 1), 0.95)) / NORMAL
    # residuals are in units of the noise, priors are not
    J = linear.slopes.copy()
    J[: misfits.size] *= problem.noise / usual
    inverse = np.linalg.inv(J[:, :k].T @ J[:, :k])
    caused = np.zeros_like(inverse)
    if J.shape[1] > k and curves_covariance is not None:
        K = inverse @ J[:, :k].T @ J[:, k:]
        caused = K @ curves_covariance @ K.T
    return Minimum(inverse + caused, caused, noise, problem.noise, linear)


def residual_noise(problem: Problem, misfits: np.ndarray, parameter_count: int) -> float:
    """Standard deviation of a single reading [N], from `misfits` over the problem's noise [-]."""
    fitted = (problem.weight > 0) & problem.grid.measured
    r = misfits[fitted] / problem.weight[fitted] * problem.noise
    usual = float(np.sqrt(np.sum(r**2) / max(r.size - parameter_count, 1)))
    if problem.loss != "linear":  # outliers that the loss plays down must not come back as noise
        usual = 1.4826 * float(np.median(np.abs(r))) if r.size else 0.0
    return usual if usual > 0 else problem.noise


def with_effective_errors(problem: Problem, point: np.ndarray) -> Problem:
    """The `problem` about the contractions at which the muscle of a `point` bears the loads, (C15);
    slopes at the readings themselves would depend on their errors, and bias the fit.
    """
    observed, grid, used = problem.observed or problem.grid, problem.grid, problem.grid.used
    shifted = [replace(grid, strain=grid.strain + side * _STRAIN_STEP) for side in (-1, 1)]
    low, high = (replace(problem, grid=ends).force(point) for ends in shifted)
    slope = np.where(used, (high - low) / (2 * _STRAIN_STEP), 0.0)
    mean = float(np.sqrt(np.sum(slope**2) / np.sum(used)))
    if not mean > 0:
        return problem
    # a force falls with contraction
    slope = np.where(used, np.minimum(slope, -_LEAST_SPREAD * mean), -mean)
    missed = np.where(used, observed.force - (low + high) / 2, 0.0)
    strain = grid.strain + np.clip(missed / slope, -_LARGEST_STEP, _LARGEST_STEP)
    force = observed.force - slope * (observed.strain - strain)
    # the noise in strain stays, or is that of a first guess
    noise = problem.noise / problem.strain_slope if problem.strain_slope else _FIRST_STRAIN
    grid = replace(grid, strain=strain, force=force, spread=-slope / mean)
    return replace(problem, grid=grid, observed=observed, strain_slope=mean, noise=noise * mean)


def solve_with_noise(
    problem: Problem,
    starts: np.ndarray,
    curves_covariance: np.ndarray | None = None,
    tolerance: float = FINE,
) -> Solution:
    """Solve a problem, and find the noise that its own solution leaves: what a clipped reading says
    depends on the noise, and the noise on the fit.
    """
    # which start leads lowest shows long before each has settled: only that one goes on
    first, ends = problem.noise, solve(problem, starts, tolerance=ROUGH)
    best = ends.points[ends.best]
    if curves_covariance is None:
        for _ in range(_NOISE_ROUNDS):
            misfits, _ = problem.misfits(problem.force(best))
            noise = residual_noise(problem, misfits, len(best))
            settled = abs(noise / problem.noise - 1) < 1e-3  # far below an interval's two digits
            problem = replace(problem, noise=noise)
            if problem.strain_slope:
                problem = with_effective_errors(problem, best)
            if settled:
                break
            best = solve(problem, best[None], tolerance=ROUGH).points[0]
    # other ends are compared with the noise as it is now
    ends = ends._replace(cost=ends.cost * (first / problem.noise) ** 2)
    if tolerance < ROUGH:
        best = solve(problem, best[None], tolerance=tolerance).points[0]
    return Solution(problem, ends, best, minimum_at(problem, best, curves_covariance))


def search_minimum(
    problem: Problem, starts: np.ndarray, seed: int, curves_covariance: np.ndarray | None
) -> Solution:
    """Search from `starts`, then a second time about the best end.

    Each collapse is a kink in strain, which passes from one reading to the next as its place
    moves: that leaves shallow minima side by side, within the fit's own uncertainty, and where no
    reading shows a collapse, the data don't lead to one. A record that only pulls has none.
    """
    if problem.pulls:
        return solve_with_noise(problem, starts, curves_covariance)
    solution = solve_with_noise(problem, starts, curves_covariance, ROUGH)
    problem, first, best, minimum, _ = solution
    # a collapse beyond all readings may lie among them one unit further along any coordinate that
    # the data don't determine
    unit = np.array([parameter.deviation / WEAK for parameter in problem.parameters])
    steps = np.diag(unit)[np.diag(minimum.covariance) > (KNOWN * unit) ** 2]
    around = starts_around(best, len(starts), seed, minimum.covariance)
    # the second takes the noise that the first one left: priors weigh against it
    first = first._replace(cost=first.cost * (problem.noise / minimum.noise) ** 2)
    problem = replace(problem, noise=minimum.noise)
    grid, count = problem.grid, int(np.sum(problem.grid.used))
    few = grid
    if count > _SEARCHED:  # enough readings to tell which way leads lowest
        chosen = np.random.default_rng(seed).random(grid.count.shape) < _SEARCHED / count
        few = replace(grid.without(~chosen), count=grid.count * chosen * count / _SEARCHED)
    points = np.concatenate([around, best + steps, best - steps])
    nearby = solve(replace(problem, grid=few), points, tolerance=ROUGH)
    last = solve(problem, np.stack([nearby.points[nearby.best], best]), tolerance=ROUGH)
    best = solve(problem, last.points[[last.best]]).points[0]
    ends = SearchEnds(*map(np.concatenate, zip(first, last, strict=True)))
    return Solution(problem, ends, best, minimum_at(problem, best, curves_covariance))
