"""From a record and a muscle to a fitted muscle: the one call behind `fascicle calibrate`.

Without a choice of parameters this is the paper's tuning: $C_1(P)$ and $C_2(P)$ from
blocked force and free strain, and the factors on what resists (`tuned`). With physical
constants among the parameters all of the readings are fitted directly by the law, clipped
ones as what they are (`problem`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._checks import finite, one_of, positive
from ..muscle import Muscle
from ..muscle.tuning import Tuning
from ..records.record import Record
from .calibration import Calibration, follows
from .grid import Grid, grid
from .judging import remarks
from .parameters import FACTORS, Parameter, coordinates, named, put
from .problem import LOSSES, Problem
from .readings import Readings, tables
from .solving import Solutions, around, joined, scattered, solve
from .tuned import tune
from .uncertainty import Conclusion, conclude


WEIGHTS = ("uniform", "level")
STARTS = 4
_FIRST_NOISE = 0.02  # of the largest force: where the search for the noise begins
_ROUNDS = 6
_ROWS = 33  # of the tuned muscle's table


@dataclass(frozen=True)
class Prior:
    """What is known of a parameter beforehand.

    - `value`: [SI unit of the parameter].
    - `deviation`: its standard deviation [the same].
    """

    value: float
    deviation: float


def fit(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    *,
    loss: str = "linear",
    weights: str = "uniform",
    starts: int = STARTS,
    seed: int = 0,
) -> Calibration:
    """Fit a muscle to a record.

    **Arguments:**

    - `record`: what was measured [-].
    - `muscle`: sizes, laws and constants to begin with [-].
    - `parameters`: names of those that are free [-]; left out, the paper's factors. If all
      of them are factors, the tension is corrected by $C_1$, $C_2$ first; else it is
      fitted through its constants.
    - `priors`: what is known of some of them beforehand, by name [-].
    - `loss`: "linear", or against outliers "soft_l1" or "cauchy" [-].
    - `weights`: "uniform", or "level" to let every pressure count the same [-].
    - `starts`: how many places the search begins from [-].
    - `seed`: of the random ones among them [-].

    **Returns:** the calibration [-].

    **Raises:** `ValueError` for unknown names, and for fewer readings than parameters.
    """
    one_of(loss, LOSSES, "loss")
    one_of(weights, WEIGHTS, "weights")
    names = [one.name for one in FACTORS] if parameters is None else list(parameters)
    free = named(names, muscle)
    method = "tuning" if all(one in FACTORS for one in free) else "constants"
    record = _steady(record)
    data = _on_length(grid(record), record, muscle if method == "tuning" else None)
    _enough(data, free)
    start = _centered(muscle, free, priors or {})
    center = coordinates(free, start)
    deviation = jnp.asarray([_deviation(one, start, (priors or {}).get(one.name)) for one in free])
    weight = _weight(data, weights)
    places = jnp.asarray(scattered(np.asarray(center), max(int(starts), 1), seed))
    if method == "tuning":

        def search(places: jnp.ndarray, noise: jnp.ndarray) -> _Found:
            found = tune(start, data, weight, center, deviation, places, noise, free, loss)
            return _Found(found.problem, found.solutions, found.conclusion, found.readings)
    else:
        # a strain without the length it refers to is the muscle's own
        rest = None if record.rest_length is None else jnp.asarray(record.rest_length)
        noise = jnp.asarray(_FIRST_NOISE * float(jnp.max(jnp.abs(data.force))))
        problem = Problem(start, data, weight, noise, center, deviation, rest, None, free, loss)
        problem = _with_noise(problem, places)

        def search(places: jnp.ndarray, noise: jnp.ndarray) -> _Found:  # noqa: ARG001 settled above
            return _Found(problem, *_solved(problem, places), None)

    found, solutions = _searched(search, places, seed)
    problem, end, readings = found.problem, found.conclusion, found.readings
    if readings is not None and not bool(jnp.any(readings.valid)) and _pressed(data):
        raise ValueError(_UNREAD)
    best = found.solutions.coordinates[found.solutions.best]
    problem = eqx.tree_at(lambda p: p.noise, problem, end.noise)
    used = np.asarray((problem.weight > 0) & data.uncensored)
    inflation = follows(np.where(used, np.asarray(end.misfits), np.nan))
    covariance = inflation * (end.covariance - end.from_curves) + end.from_curves
    fitted = put(free, start, best)
    if readings is not None and _pressed(data):
        fitted = _with_tables(fitted, readings)
    made = Calibration(
        muscle=fitted,
        start=start,
        record=record,
        method=method,
        problem=problem,
        coordinates=np.asarray(best),
        covariance=np.asarray(covariance),
        from_curves=np.asarray(end.from_curves),
        readings=readings,
        conclusion=end,
        force=np.asarray(_force(fitted, data.pressure, end.strain)),
        solutions=solutions,
        inflation=inflation,
    )
    return _remarked(made)


_UNREAD = (
    "`record` shows no blocked force and free strain at any pressure: it needs at least two"
    " readings that pull at one pressure, or name constants to fit instead, such as c10, c01."
)


@eqx.filter_jit
def _force(muscle: Muscle, pressure: jnp.ndarray, strain: jnp.ndarray) -> jnp.ndarray:
    return muscle.force(pressure, strain)


def _remarked(made: Calibration) -> Calibration:
    return replace(made, warnings=tuple(remarks(made)))


@eqx.filter_jit
def _solved(problem: Problem, places: jnp.ndarray) -> tuple[Solutions, Conclusion]:
    solutions = solve(problem, places)
    return solutions, conclude(problem, solutions.coordinates[solutions.best], None)


def _with_noise(problem: Problem, places: jnp.ndarray) -> Problem:
    """The problem with the noise that its own solution leaves.

    What a clipped reading says depends on the noise, and the noise on the fit.
    """
    for _ in range(_ROUNDS):
        solutions, end = _solved(problem, places)
        settled = abs(float(end.noise / problem.noise) - 1) < 1e-3
        problem = eqx.tree_at(lambda p: p.noise, problem, end.noise)
        if settled:
            break
        places = solutions.coordinates
    return problem


class _Found(NamedTuple):
    """A search's problem, its solutions, what holds at the best, and readings if any."""

    problem: Problem
    solutions: Solutions
    conclusion: Conclusion
    readings: Readings | None


def _searched(
    search: Callable[[jnp.ndarray, jnp.ndarray], _Found], places: jnp.ndarray, seed: int
) -> tuple[_Found, Solutions]:
    """A search from `places` [-], then a second one about its best; the ends of both.

    Each collapse is a kink in strain, which passes from one reading to the next as its place
    moves: that leaves shallow minima side by side, within the fit's own uncertainty.
    """
    wide = search(places, jnp.asarray(0.0))
    best = wide.solutions.coordinates[wide.solutions.best]
    near = around(np.asarray(best), np.asarray(wide.conclusion.covariance), len(places), seed)
    # the second takes the noise that the first one left: priors weigh against it
    close = search(jnp.asarray(near), wide.conclusion.noise)
    scale = (wide.problem.noise / close.problem.noise) ** 2
    begun = eqx.tree_at(lambda s: s.cost, wide.solutions, wide.solutions.cost * scale)
    return close, joined(begun, close.solutions)


def _steady(record: Record) -> Record:
    """The readings of a `record` [-] taken in time that belong to sweeps, without the ramps."""
    if record.time is None:
        return record
    from ..records.splitting import runs  # only sampled data need it

    ramps = np.zeros(len(record), dtype=bool)
    for run in runs(record):
        ramps[run.points] = run.kind == "mixed"
    if not 0 < np.sum(ramps) < len(record) / 2:
        return record
    note = f"{np.sum(ramps)} readings of ramps between sweeps left out of the fit"
    return record.only(~ramps, note)


def _on_length(data: Grid, record: Record, muscle: Muscle | None) -> Grid:
    """`data` with strains of the muscle's length, where that is not itself to be fitted."""
    if muscle is None or record.rest_length is None:
        return data
    return eqx.tree_at(lambda d: d.strain, data, data.strain * (record.rest_length / muscle.length))


def _pressed(data: Grid) -> bool:
    """Whether any reading was taken under pressure."""
    return bool(jnp.max(data.pressure) > 1.0)


def _enough(data: Grid, free: Sequence[Parameter]) -> None:
    readings = int(jnp.sum(data.count > 0))
    if readings < len(free):
        raise ValueError(
            f"`record` holds {readings} readings for {len(free)} parameters:"
            " measure more points, or free fewer parameters."
        )


def _centered(muscle: Muscle, free: Sequence[Parameter], priors: Mapping[str, Prior]) -> Muscle:
    """The muscle with its priors' values, where the fit begins."""
    for name in priors:
        one_of(name, [one.name for one in free], "priors")
    for one in free:
        prior = priors.get(one.name)
        if prior is not None:
            (finite if one.linear else positive)(prior.value, one.name, "SI")
            positive(prior.deviation, f"{one.name}_deviation", "SI")
            muscle = one.put(muscle, jnp.asarray(_coordinate(one, muscle, prior.value)))
    return muscle


def _coordinate(parameter: Parameter, muscle: Muscle, value: float) -> float:
    """The coordinate [-] that gives `value`, found by bisection: each is monotone."""

    def of(z: float) -> float:
        return float(parameter.value(parameter.put(muscle, jnp.asarray(z))))

    low, high = -60.0, 60.0
    for _ in range(70):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of(middle) < value else (low, middle)
    size = max(abs(of(0.0)), abs(value))
    if abs(of(low) - value) > 1e-9 * size:
        raise ValueError(
            f"`priors` of {parameter.name} must be a value that it can have in this muscle,"
            f" got {value:g} (SI): check its unit."
        )
    return low


def _deviation(parameter: Parameter, muscle: Muscle, prior: Prior | None) -> float:
    """Deviation of the prior on the coordinate [-], by its slope at the prior's value."""
    if prior is None:
        return parameter.deviation
    z = jnp.asarray(parameter.coordinate(muscle), dtype=float)
    _, slope = jax.jvp(
        lambda z: parameter.value(parameter.put(muscle, z)), (z,), (jnp.ones_like(z),)
    )
    return prior.deviation / abs(float(slope))


def _weight(data: Grid, weights: str) -> jnp.ndarray:
    """Weights [-] of residuals, 1 on average."""
    some = (data.count > 0).astype(float)
    if weights == "uniform":
        return some
    total = jnp.sum(data.count, axis=1, keepdims=True)
    share = jnp.sum(total) / (jnp.sum(total > 0) * jnp.maximum(total, 1))
    return some * jnp.sqrt(share)


_tables = eqx.filter_jit(tables)


def _with_tables(muscle: Muscle, readings: Readings) -> Muscle:
    """The muscle with $C_1$, $C_2$ at even steps over the measured pressures."""
    P = np.asarray(readings.pressure)
    measured = P[np.asarray(readings.valid)]
    rows = np.unique(np.concatenate([np.linspace(measured[0], measured[-1], _ROWS), measured]))
    rows = rows[np.concatenate([[True], np.diff(rows) > 1e-9 * rows[-1]])]
    c1, c2 = (
        np.asarray(x) for x in _tables(muscle, readings.coefficients, jnp.asarray(rows), P.max())
    )
    seen = np.asarray(muscle.tuning.effective_pressure(rows))
    # below the blocked force's threshold the muscle doesn't pull: the table begins above it
    good = np.isfinite(c1) & np.isfinite(c2) & (c2 > 0) & (seen > 0)
    old = muscle.tuning
    return eqx.tree_at(
        lambda m: m.tuning,
        muscle,
        Tuning(
            seen[good], c1[good], c2[good],
            youngs_modulus_factor=old.youngs_modulus_factor,
            collapse_moment_factor=old.collapse_moment_factor,
            hinge_stiffness_factor=old.hinge_stiffness_factor,
            hinge_stiffness_slope=old.hinge_stiffness_slope,
            transition_rate=old.transition_rate,
            dead_band=old.dead_band,
        ),
    )  # fmt: skip
