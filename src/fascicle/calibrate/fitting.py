"""From a record and a muscle to a fitted muscle: the one call behind `fascicle calibrate`.

Without a choice of parameters this is the paper's tuning: $C_1(P)$ and $C_2(P)$ from
blocked force and free strain, and the factors on what resists (`tuned`). With physical
constants among the parameters all of the readings are fitted directly by the law, clipped
ones as what they are (`problem`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._checks import finite, one_of, positive
from ..muscle import Muscle
from ..muscle.tuning import Tuning
from ..records.record import Record
from .calibration import Calibration
from .causes import causes, untold
from .discrepancy import from_trends, table, widening
from .grid import WEIGHTS, Grid, trimmed, weighed
from .judging import remarks
from .parameters import FACTORS, Parameter, constants_of, coordinates, explicit, named, put
from .misfit import LOSSES
from .problem import Problem
from .pulling import strain_of, untuned
from .readings import Readings, no_curves, smooth_free_strain, tables_of
from .remainder import remainder
from .solving import Solutions, around, joined, scattered, solve
from .taking import Taken, pulling_of, taken
from .trends import looked
from .tuned import problem_of
from .uncertainty import Conclusion, conclude


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
    whole: bool = True,
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
    - `whole`: whether the law past the free strain has a say in what readings say that are
      clipped at zero [-]. If not, and nothing pushed, the tension law alone is fitted, which
      compiles ten times as fast.

    **Returns:** the calibration [-].

    **Raises:** `ValueError` for unknown names, and for fewer readings than parameters.
    """
    search = Search(loss, weights, starts, seed, whole)
    return fitted(taken(record), muscle, parameters, priors, search)


@dataclass(frozen=True)
class Search:
    """How a fit is made: `loss`, `weights`, `starts`, `seed`, `whole` as `fit` [-]; `tune`: whether C1 and C2
    are read first [-], left out where all that is free are factors; `among`: names of constants
    that other fits of the record free [-], so that all of them share what is compiled; `near`:
    coordinates by name [-] to begin from as well.
    """

    loss: str = "linear"
    weights: str = "uniform"
    starts: int = STARTS
    seed: int = 0
    whole: bool = True
    tune: bool | None = None
    among: tuple[str, ...] = ()
    near: Mapping[str, float] = field(default_factory=dict)


def fitted(
    of: Taken,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    search: Search,
) -> Calibration:
    """As `fit`, `of` what was taken of a record [-], by a `search` [-]."""
    if of.pulls and not search.whole:
        of = pulling_of(of)
    problem, readings = begun(of, muscle, parameters, priors, search)
    if readings is not None and not np.any(readings.valid) and _pressed(of.data):
        raise ValueError(_UNREAD)
    return concluded(of, readings, search, *_searched(problem, readings, search))


def begun(
    of: Taken,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    search: Search,
) -> tuple[Problem, Readings | None]:
    """The problem of a fit, and the readings of a tuning; arguments as `fitted` [-], of what was
    taken as `pulling_of` has it for the tension law alone.
    """
    one_of(search.loss, LOSSES, "loss")
    one_of(search.weights, WEIGHTS, "weights")
    given, names = priors or {}, [one.name for one in FACTORS] if parameters is None else parameters
    free = named(names, muscle)
    tuning = all(one in FACTORS for one in free) if search.tune is None else search.tune
    data, pulls = of.data, of.pulls and not search.whole
    _enough(data, free)
    start = _centered(muscle, free, given)
    # what is compiled knows more constants than are free, so that other choices share it
    among = free
    if search.among:
        among = named([*names, *search.among], muscle)
    elif pulls and not tuning:
        among = constants_of(start, free)
    shared = bool(search.among) or among != free
    mask = jnp.asarray([one in free for one in among]) if shared else None
    if shared:
        start = explicit(start, among)
    center = np.asarray(_coordinates(among, start))
    deviation = np.array([_deviation(one, start, given.get(one.name)) for one in among])
    more: dict[str, Any] = {"free": mask, "pulls": pulls}
    if search.among:
        more["corrects"] = jnp.asarray(tuning)
    # a strain without the length it refers to is the muscle's own
    rest = None if of.record.rest_length is None else jnp.asarray(of.record.rest_length)
    if tuning:
        data = on_length(data, of.record, start)
        if rest is not None and search.among:
            more["rest_length"] = start.length  # the others have one
        readings, problem = problem_of(
            start, data, weighed(data, search.weights), center, deviation, among, search.loss,
            **more,
        )  # fmt: skip
        return problem, readings
    noise = jnp.asarray(_FIRST_NOISE * float(np.max(np.abs(np.asarray(data.force)))))
    return Problem(
        start, data, jnp.asarray(weighed(data, search.weights)), noise, jnp.asarray(center),
        jnp.asarray(deviation), rest, no_curves() if search.among else None, among, search.loss,
        **more,
    ), None  # fmt: skip


def concluded(
    of: Taken,
    readings: Readings | None,
    search: Search,
    problem: Problem,
    solutions: Solutions,
    best: np.ndarray,
    end: Conclusion,
) -> Calibration:
    """A calibration from where its search ended.

    **Arguments:**

    - `of`: what was taken of a record [-].
    - `readings`, `search`: of the fit [-].
    - `problem`: that was solved at last [-].
    - `solutions`: where each start ended [-].
    - `best`: coordinates of all parameters at the minimum [-].
    - `end`: what holds there, as far as noise goes [-].

    **Returns:** the calibration [-].
    """
    data, start, chosen = problem.data, problem.muscle, problem.chosen
    if not np.all(np.isfinite(end.linear.residuals)):
        raise ValueError(
            "`muscle`: its laws have no number where the search begins: check sizes and constants."
        )
    left = remainder(problem, end, best, of.gathered.branch, of.gathered.time)
    seen = looked(left)
    trends, inflation = from_trends(problem, end, left, seen), widening(left, seen)
    noise = inflation * (end.covariance - end.from_curves)
    muscle = _put(problem.fitted, start, jnp.asarray(best[chosen]))
    if readings is not None and _pressed(data):
        muscle = _with_tables(muscle, readings)
    shape = np.shape(trimmed(data).count)
    made = Calibration(
        muscle=muscle,
        start=start,
        taken=of,
        method="constants" if readings is None else "tuning",
        problem=replace(problem, noise=jnp.asarray(end.noise)),
        coordinates=best[chosen],
        covariance=noise + end.from_curves + trends,
        from_curves=end.from_curves,
        from_trends=trends,
        readings=readings,
        conclusion=end,
        force=end.linear.force[: shape[0], : shape[1]],
        free_strain=_free_strain(muscle, readings, data)[: shape[0]],
        solutions=solutions,
        inflation=inflation,
        seen=seen,
        causes=causes(problem, best, left, seen),
        untold=untold(problem, best, left),
        discrepancy=table(problem, left, seen),
        weights=search.weights,
    )
    return replace(made, warnings=tuple(remarks(made)))


_UNREAD = (
    "`record` shows no blocked force and free strain at any pressure: it needs at least two"
    " readings that pull at one pressure, or name constants to fit instead, such as c10, c01."
)


def _searched(
    problem: Problem, readings: Readings | None, search: Search
) -> tuple[Problem, Solutions, np.ndarray, Conclusion]:
    """A search, then a second one about its best: the last problem, all ends, the best, and what
    holds there.

    Each collapse is a kink in strain, which passes from one reading to the next as its place
    moves: that leaves shallow minima side by side, within the fit's own uncertainty. A record that
    only pulls has none.
    """
    curves = None if readings is None else readings.covariance
    places = places_of(problem, search)
    problem, first, best, end = settled(problem, problem.whole(places), curves)
    if problem.pulls:
        return problem, first, best, end
    near = around(best[problem.chosen], end.covariance, len(places), search.seed)
    # the second takes the noise that the first one left: priors weigh against it
    again = replace(problem, noise=jnp.asarray(end.noise))
    close = solve(again, again.whole(near))
    best = close.coordinates[close.best]
    scale = (float(problem.noise) / end.noise) ** 2
    ends = joined(replace(first, cost=first.cost * scale), close)
    return again, ends, best, conclude(again, best, curves)


def places_of(problem: Problem, search: Search) -> np.ndarray:
    """Where a `search` [-] begins: coordinates of the free parameters of a `problem` [-]."""
    center = np.asarray(problem.center)[problem.chosen]
    places = scattered(center, max(int(search.starts), 1), search.seed)
    if search.near:
        named = zip(problem.fitted, center, strict=True)
        near = np.array([search.near.get(one.name, z) for one, z in named])
        places = np.concatenate([near[None], places])
    return places


def settled(
    problem: Problem, places: np.ndarray, curves: np.ndarray | None
) -> tuple[Problem, Solutions, np.ndarray, Conclusion]:
    """The problem with the noise that its own solution leaves, solved from `places` [-].

    What a clipped reading says depends on the noise, and the noise on the fit; where none is
    clipped, only priors weigh against it, and once is enough.
    """
    solutions = solve(problem, places)
    best = solutions.coordinates[solutions.best]
    end = conclude(problem, best, curves)
    if curves is not None:
        return problem, solutions, best, end
    for _ in range(_ROUNDS):
        if abs(end.noise / float(problem.noise) - 1) < 1e-3:
            break
        problem = replace(problem, noise=jnp.asarray(end.noise))
        best = solve(problem, best[None]).coordinates[0]
        end = conclude(problem, best, curves)
    # the others follow with the noise as it is now, to be told as they end
    ends = solve(problem, np.concatenate([solutions.coordinates, best[None]]))
    steps = np.append(solutions.steps, 0) + ends.steps
    ends = replace(ends, steps=steps)
    if ends.best < len(places):
        best = ends.coordinates[ends.best]
        end = conclude(problem, best, curves)
    return problem, ends, best, end


_coordinates = eqx.filter_jit(coordinates)
_put = eqx.filter_jit(put)  # one function compiles faster than its operations, one by one


def _free_strain(muscle: Muscle, readings: Readings | None, data: Grid) -> np.ndarray:
    """Free strain [-] of the fitted `muscle` at each level."""
    if readings is not None:
        return smooth_free_strain(muscle, readings)[0]
    P, tuning = np.asarray(data.pressure)[:, 0], muscle.tuning
    seen = np.maximum(P - float(tuning.dead_band), 0.0)
    offset = np.interp(seen, np.asarray(tuning.pressures), np.asarray(tuning.c1))
    return strain_of(untuned(muscle), P, offset)


def on_length(data: Grid, record: Record, muscle: Muscle) -> Grid:
    """`data` [-] of a `record` [-] with strains of the `muscle`'s own length [-]."""
    if record.rest_length is None:
        return data
    longer = record.rest_length / float(muscle.length)
    return replace(data, strain=jnp.asarray(np.asarray(data.strain) * longer))


def _pressed(data: Grid) -> bool:
    """Whether any reading was taken under pressure."""
    return bool(np.max(np.asarray(data.pressure)) > 1.0)


def _enough(data: Grid, free: Sequence[Parameter]) -> None:
    readings = int(np.sum(np.asarray(data.count) > 0))
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


def _with_tables(muscle: Muscle, readings: Readings) -> Muscle:
    """The muscle with $C_1$, $C_2$ at even steps over the measured pressures."""
    P = readings.pressure
    measured = P[readings.valid]
    rows = np.unique(np.concatenate([np.linspace(measured[0], measured[-1], _ROWS), measured]))
    rows = rows[np.concatenate([[True], np.diff(rows) > 1e-9 * rows[-1]])]
    c1, c2 = tables_of(muscle, readings, rows)
    seen = np.maximum(rows - float(muscle.tuning.dead_band), 0.0)
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
