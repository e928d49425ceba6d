"""Fit of a muscle to a record: the function behind `fascicle calibrate`.

Without a choice of parameters this is the paper's tuning: $C_1(P)$ and $C_2(P)$ from blocked force
and free strain, and the factors on the resisting force (`tuning`). With physical constants among
the parameters the law is fitted directly to all readings, clipped ones included (`least_squares`).
"""

import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ..core.errors import InvalidInputError
from ..core.module import to_numpy, with_fields
from ..core.validation import RANGES, check_choice
from ..muscle import Muscle
from ..muscle.tuning import Tuning
from ..muscle.validation import END_PARAMETERS, FittedLength
from ..records.record import DOWN, UP, Record
from .calibration import Calibration
from .data import FitData, Grid, pulling_only, select_fit_data
from .diagnostics import diagnose
from .gauges import GAUGE_NAMES, Gauge, default_deviations, strain_scale
from .least_squares import (
    FIRST_NOISE,
    LOSSES,
    ROUGH,
    Problem,
    Solution,
    minimum_at,
    search_minimum,
    solve_with_noise,
    starts_around,
    with_effective_errors,
)
from .parameters import (
    FACTOR_NAMES,
    Parameter,
    coordinates,
    pulling_parameters,
    put,
    select_parameters,
    with_optional_laws,
)
from .readings import Readings, SmoothCurves, invert_force, top_pressure, without_tuning
from .tuning import fit_jointly, with_readings


STARTS = 4  # a second search about the best end follows: more starts rarely find a better one
_NO_PULL = 0.02  # of the largest push: a smaller pull is the gauge's zero
_NO_FORCE = 1e-6  # N: rounding of zeros, below any load cell's resolution
_PASSIVE = 1.0  # Pa, what a record without pressure may read
_ROWS = 33  # of the tuned muscle's table: straight lines between them are closer than readings
_STEPS = 3  # of Newton's, to where the muscle to begin with bears the loads
_SLOPE_STEP = 1e-6  # of a coordinate: rounding and curvature are both below 1e-9 of the slope


@dataclass(frozen=True)
class Prior:
    """Expected `value` of a parameter and its standard `deviation` [SI unit of the parameter]."""

    value: float
    deviation: float


@dataclass(frozen=True)
class FitOptions:
    """How a fit searches: its loss, starts and stages, and whether it fits a loop.

    - `loss`, `starts`, `seed`, `whole`: as of `fit`.
    - `tune`: read C1 and C2 first; left out, if all free parameters are factors.
    - `held`: names of fixed constants that the data may determine.
    - `near`: coordinates by name [-], as one more start.
    - `thorough`: search a second time about the best end.
    - `loop`: fit a hysteresis loop beside the constants, where there is one.
    """

    loss: str = "linear"
    starts: int = STARTS
    seed: int = 0
    whole: bool = True
    tune: bool | None = None
    held: tuple[str, ...] = ()
    near: Mapping[str, float] = field(default_factory=dict)
    thorough: bool = True
    loop: bool = False

    def __post_init__(self) -> None:
        check_choice(self.loss, LOSSES, "loss")


def fit(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    *,
    loss: str = "linear",
    starts: int = STARTS,
    seed: int = 0,
    whole: bool = True,
) -> Calibration:
    """Fit a muscle to a record.

    **Arguments:**

    - `record`: the measured readings.
    - `muscle`: sizes, laws and constants to begin with.
    - `parameters`: names of the free parameters; left out, the paper's factors. If all of them
      are factors, the tension is corrected by $C_1$, $C_2$ first; else it is fitted through its
      constants.
    - `priors`: prior knowledge of some of them, by name.
    - `loss`: "linear", or against outliers "soft_l1".
    - `starts`: number of points that the search begins from.
    - `seed`: random seed of the starts.
    - `whole`: compare the law past the free strain with readings that are clipped at zero. If not,
      and nothing pushed, the tension law alone is fitted, which is several times as fast.

    **Returns:** the calibration.

    **Raises:** `InvalidInputError` for unknown names, and for fewer readings than parameters.
    """
    options = FitOptions(loss, starts, seed, whole)
    return fit_data(select_fit_data(record, muscle), muscle, parameters, priors, options)


def fit_data(
    data: FitData,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    options: FitOptions,
) -> Calibration:
    """Fit a muscle to selected `data`; other arguments as of `fit`.

    An empty list of `parameters` compares the muscle as it is with the record.
    """
    if data.pulls and not options.whole:
        data = pulling_only(data)
    problem, readings = set_up_problem(data, muscle, parameters, priors or {}, options)
    solution = solve_problem(problem, readings, options)
    calibration = _calibration(*_with_corrected_readings(data, solution))
    calibration = replace(calibration, diagnosis=diagnose(calibration))
    return _with_binding_priors(calibration, priors or {})


def _with_binding_priors(calibration: Calibration, priors: Mapping[str, Prior]) -> Calibration:
    """The `calibration`, or a fit in which readings weigh as much as the model's error lets them.

    By their scatter alone readings may outweigh a prior though the model's error makes the constant
    less certain than the prior does. Then their noise is multiplied by the ratio of both.
    """
    variances = np.diag(calibration.covariance)
    with_prior = [p.of_gauge or p.name in priors for p in calibration.problem.parameters]
    loose = np.array(with_prior, bool) & (variances > calibration.problem.deviation**2)
    if calibration.readings is not None or not np.any(loose):
        return calibration
    problem = calibration.problem
    weight = problem.weight / np.max(calibration.wider[loose])
    loosened = replace(problem, weight=weight)
    solution = solve_with_noise(loosened, calibration.coordinates[None], tolerance=ROUGH)
    bound = _calibration(*_with_corrected_readings(calibration.fit_data, solution))
    bound = replace(bound, start=calibration.start)
    error_in_weights = {"inflation": 1.0, "from_pressure": 0.0, "covariance": 0.0}
    return replace(bound, diagnosis=replace(diagnose(bound), **error_in_weights))


def set_up_problem(
    data: FitData,
    muscle: Muscle,
    names: Sequence[str] | None,
    priors: Mapping[str, Prior],
    options: FitOptions,
) -> tuple[Problem, Readings | None]:
    """Problem of a fit, and the readings of a tuning; arguments as of `fit_data`."""
    muscle = with_optional_laws(to_numpy(muscle), names or ())
    names = FACTOR_NAMES if names is None else names
    free = select_parameters(names, muscle) if names else ()
    only_factors = bool(names) and set(names) <= set(FACTOR_NAMES)
    tuning = only_factors if options.tune is None else options.tune
    _check_data(data, free)
    pulls = data.pulls and (data.reads_contraction or not options.whole)
    gauges = gauge_priors(data, float(muscle.length), pulls)
    priors = {name: prior for name, prior in gauges.items() if name in names} | dict(priors)
    start, gauge = _at_priors(muscle, data.gauge, free, priors)
    fixed: tuple[Parameter, ...] = ()
    if options.held:
        fixed = select_parameters(options.held, start)
    elif pulls and not tuning:
        fixed = pulling_parameters(start)
    loop = fits_loop(data, names, options)
    weight = data.settled if loop else data.grid.used
    if not pulls and "force_zero" in names:  # these readings are in its prior
        weight = weight & data.used_without(data.at_rest)
    problem = Problem(
        start,
        data.grid,
        weight.astype(float),
        FIRST_NOISE * float(np.max(np.abs(data.grid.force))),
        np.asarray(coordinates(free, start, gauge), float),
        np.array([_prior_deviation(p, start, gauge, priors.get(p.name)) for p in free]),
        free,
        # strains without a reference length are contractions of the muscle
        None if tuning else data.record.rest_length,
        loss=options.loss,
        pulls=pulls,
        held=tuple(parameter for parameter in fixed if parameter.name not in names),
        gauge=data.gauge,
        branch=data.branch if loop else None,
    )
    if data.reads_contraction:
        for _ in range(_STEPS):
            problem = with_effective_errors(problem, problem.center)
    if not tuning:
        return problem, None
    readings, problem = with_readings(problem, on_length(data, start))
    if not np.any(readings.valid) and _has_pressure(data.grid):
        rule = (
            "shows no blocked force and free strain at any pressure: it needs at least two readings"
            " that pull at one pressure"
        )
        remedy = "or name constants to fit instead, such as c10, c01"
        raise InvalidInputError("record", rule, None, remedy)
    return problem, readings


def fits_loop(data: FitData, names: Collection[str], options: FitOptions) -> bool:
    """The hysteresis loop of forces is fitted beside the constants `names`, without the readings
    after a turn: by the `options`, or if the names contain gauges' errors, which it would hide.
    """
    both = not data.reads_contraction and {UP, DOWN} <= set(np.unique(data.branch).tolist())
    return both and (options.loop or not set(names).isdisjoint(GAUGE_NAMES))


def gauge_priors(data: FitData, length: float, only_pulls: bool) -> dict[str, Prior]:
    """Priors of the gauges' errors, by name, narrowed by readings without pressure; `length`: of
    the muscle [m]; `only_pulls`: these are not fitted, nor where they show the load cell's error
    clearly; else their forces would count twice.
    """
    grid, names = data.grid, GAUGE_NAMES
    if not (only_pulls or data.gauge.force_zero):
        names = ("pressure_zero",)
    usual = default_deviations(grid.force, grid.pressure, grid.elapsed, length)
    priors = {name: Prior(float(getattr(data.gauge, name)), d) for name, d in usual.items()}
    vented = {name: Prior(*data.zeros[name]) for name in data.zeros.keys() & names}
    return priors | {n: p for n, p in vented.items() if p.deviation < usual[n]}


def _with_corrected_readings(data: FitData, solution: Solution) -> tuple[FitData, Solution]:
    """Data and `solution` with readings corrected for the fitted gauge."""
    problem, point = solution.problem, solution.point
    gauge = problem.gauge_at(point)
    if gauge == problem.gauge:
        return data, solution
    data = data.corrected(gauge, problem.rest_length or float(problem.muscle.length))
    noise = problem.noise * float(problem.gauge.force_gain / gauge.force_gain)
    problem = replace(problem, grid=data.grid, gauge=gauge, noise=noise)
    return data, solution._replace(problem=problem, minimum=minimum_at(problem, point, None))


def on_length(data: FitData, muscle: Muscle) -> Grid:
    """Table of `data` with strains relative to the length of the `muscle` [-]."""
    return replace(data.grid, strain=data.grid.strain * strain_scale(data.record, muscle))


def starts_of(problem: Problem, options: FitOptions) -> np.ndarray:
    """Points that the search of a `problem` begins from."""
    starts = starts_around(problem.center, max(int(options.starts), 1), options.seed)
    if not options.near:
        return starts
    pairs = zip(problem.parameters, problem.center, strict=True)
    point = np.array([options.near.get(parameter.name, z) for parameter, z in pairs])
    return np.concatenate([point[None], starts])


def solve_problem(problem: Problem, readings: Readings | None, options: FitOptions) -> Solution:
    """Find the minimum; of a tuning, then jointly with its curves."""
    covariance = None if readings is None else readings.covariance
    starts = starts_of(problem, options)
    if options.thorough:
        solution = search_minimum(problem, starts, options.seed, covariance)
    else:
        solution = solve_with_noise(problem, starts, covariance, ROUGH)
    if readings is None:
        return solution
    count, covariance = max(options.starts, 1), solution.minimum.covariance
    joint = fit_jointly(solution.problem, readings, solution.point, count, options.seed, covariance)
    joint = joint or solution._replace(readings=readings)
    return joint._replace(ends=solution.ends)


def _calibration(data: FitData, solution: Solution) -> Calibration:
    """The calibration at a minimum, without a diagnosis."""
    problem, _, point, minimum, readings = solution
    if not np.all(np.isfinite(minimum.linear.residuals)):
        rule = ": its laws return no number where the search begins"
        raise InvalidInputError("muscle", rule, None, "check sizes and constants")
    start, grid, ends = problem.muscle, problem.grid, solution.ends
    muscle = put(problem.parameters, start, point)
    P, tuning = grid.pressure[:, 0], muscle.tuning
    if readings is None:
        offset = np.interp(np.maximum(P - tuning.dead_band, 0.0), tuning.pressures, tuning.c1)
        free_strain = invert_force(without_tuning(muscle), P, offset)
    else:
        if _has_pressure(grid):
            muscle = _with_tables(muscle, readings)
        curves = SmoothCurves(muscle, P, top_pressure(grid))
        free_strain = curves.free_strain(readings.coefficients)
    if problem.parameters or readings is not None:  # else the muscle is as given
        names = {parameter.name for parameter in problem.parameters}
        fitted = FittedLength(float(muscle.length), with_ends=not END_PARAMETERS.isdisjoint(names))
        muscle = with_fields(muscle, fitted_length=fitted)
    problem = replace(problem, noise=minimum.noise)
    return Calibration(muscle, start, data, problem, point, readings, minimum, free_strain, ends)


def _check_data(data: FitData, free: Sequence[Parameter]) -> None:
    grid, files = data.grid, ", ".join(source.name for source in data.record.sources)
    prefix = f"of {files} " if files else ""
    force = grid.force[grid.used]
    if force.size < len(free):
        rule = f"holds {force.size} readings for {len(free)} parameters"
        remedy = "measure more points, or free fewer parameters"
    elif data.reads_contraction:
        return
    elif not data.pushes_clipped and np.max(np.abs(force)) < _NO_FORCE:
        rule, remedy = "holds no force but 0 N", "check the column of forces"
    # a record without pressure may only push; noise about zero is no pull
    elif np.max(force) <= _NO_PULL * -np.min(force) and _has_pressure(grid):
        rule = f"holds no force that pulls, the largest is {np.max(force) + 0.0:.4g} N"
        remedy = (
            "if the gauge reads a pull as negative, reverse the sign with --push-positive, or with"
            ' signs.force = "pushing positive" in the TOML beside the file; else also measure where'
            " the muscle pulls"
        )
    else:
        return
    raise InvalidInputError("record", f"{prefix}{rule}", None, remedy)


def _at_priors(
    muscle: Muscle, gauge: Gauge, free: Sequence[Parameter], priors: Mapping[str, Prior]
) -> tuple[Muscle, Gauge]:
    """Muscle and gauge with the values of their priors, where the fit begins."""
    for name in priors:
        check_choice(name, [parameter.name for parameter in free], "priors")
    for parameter in free:
        prior = priors.get(parameter.name)
        if prior is None:
            continue
        least, kind = (-np.inf, "finite") if parameter.linear else (0.0, "positive")
        if not (least < prior.value < np.inf and 0 < prior.deviation < np.inf):
            rule = f"of {parameter.name} needs a {kind} value and a positive deviation"
            numbers = prior.value, prior.deviation
            raise InvalidInputError("priors", rule, numbers, shown=f"{numbers} (SI)")
        if parameter.of_gauge:
            gauge = replace(gauge, **{parameter.name: prior.value})
        else:
            z = _coordinate_of(parameter, muscle, prior.value)
            muscle = parameter.put(muscle, np.float64(z))
    return muscle, gauge


def _coordinate_of(parameter: Parameter, muscle: Muscle, value: float) -> float:
    """Coordinate [-] of a parameter's `value` [SI]."""

    def excess(z: float) -> float:
        return float(parameter.value(parameter.put(muscle, np.float64(z)))) - value

    try:
        # values are monotone in their coordinates; e^60 is beyond any constant's range
        return float(brentq(excess, -60.0, 60.0, xtol=1e-14))  # pyright: ignore[reportArgumentType]
    except ValueError:
        rule, text = f"of {parameter.name} is out of its range in this muscle", f"{value:g} (SI)"
        raise InvalidInputError("priors", rule, value, "check its unit", shown=text) from None


def _prior_deviation(
    parameter: Parameter, muscle: Muscle, gauge: Gauge, prior: Prior | None
) -> float:
    """Standard deviation of the prior's coordinate [-], from the slope at the prior's value."""
    if prior is None:
        return parameter.deviation
    start: Any = gauge if parameter.of_gauge else muscle
    z = parameter.coordinate(start)
    high, low = (parameter.value(parameter.put(start, z + side * _SLOPE_STEP)) for side in (1, -1))
    return prior.deviation * 2 * _SLOPE_STEP / abs(float(high - low))


def _has_pressure(grid: Grid) -> bool:
    return bool(np.max(grid.pressure) > _PASSIVE)


def _with_tables(muscle: Muscle, readings: Readings) -> Muscle:
    """The muscle with $C_1$, $C_2$ at even steps over the measured pressures."""
    P = readings.pressure
    measured = P[readings.valid]
    rows = np.unique(np.concatenate([np.linspace(measured[0], measured[-1], _ROWS), measured]))
    # a measured pressure may be an even step but for rounding
    rows = rows[np.concatenate([[True], np.diff(rows) > 1e-9 * rows[-1]])]
    c1, c2 = SmoothCurves(muscle, rows, max(float(P.max()), 1.0)).corrections(readings.coefficients)
    effective = np.maximum(rows - float(muscle.tuning.dead_band), 0.0)
    # the table begins above the threshold of the blocked force; near it C2 is a quotient of two
    # small forces, beyond the range of any muscle
    plausible = (RANGES["c2"].least < c2) & (c2 < RANGES["c2"].largest)
    good = np.isfinite(c1) & plausible & (effective > 0)
    with warnings.catch_warnings():
        # unusual values that were fitted are reported with their intervals
        warnings.filterwarnings("ignore", ".* is unusual", UserWarning)
        table = Tuning(effective[good], c1[good], c2[good])
    tables = {"pressures": table.pressures, "c1": table.c1, "c2": table.c2}
    return with_fields(muscle, tuning=with_fields(muscle.tuning, **tables))
