"""Where a fit begins: what is known beforehand, what is free, and the problem that follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ...core.errors import InvalidInputError
from ...core.validation import check_choice, check_finite, check_positive
from ...muscle import Muscle
from ...records.record import Record
from ..data.grid import WEIGHTS, Grid, weighed
from ..data.readings import Readings, no_curves
from ..data.taking import Taken
from .misfit import LOSSES
from .parameters import FACTORS, Parameter, constants_of, coordinates, explicit, named
from .residuals import Problem
from .tuned import problem_of


STARTS = 4
_NO_PULL = 0.02  # of the largest push: a smaller pull is the gauge's zero
_PASSIVE = 1.0  # Pa, what a record of no pressure may read
_FIRST_NOISE = 0.02  # of the largest force: where the search for the noise begins


@dataclass(frozen=True)
class Prior:
    """What is known of a parameter beforehand.

    - `value`: [SI unit of the parameter].
    - `deviation`: its standard deviation [the same].
    """

    value: float
    deviation: float


@dataclass(frozen=True)
class Search:
    """How a fit is made.

    - `loss`, `weights`, `starts`, `seed`, `whole`: as of `fit` [-].
    - `tune`: whether C1 and C2 are read first [-]; left out, where all that is free are factors.
    - `among`: names of constants that other fits of the record free [-], so that all of them
      share what is compiled.
    - `near`: coordinates by name [-] to begin from as well.
    """

    loss: str = "linear"
    weights: str = "uniform"
    starts: int = STARTS
    seed: int = 0
    whole: bool = True
    tune: bool | None = None
    among: tuple[str, ...] = ()
    near: Mapping[str, float] = field(default_factory=dict)


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
    check_choice(search.loss, LOSSES, "loss")
    check_choice(search.weights, WEIGHTS, "weights")
    given, names = priors or {}, [one.name for one in FACTORS] if parameters is None else parameters
    free = named(names, muscle)
    tuning = all(one in FACTORS for one in free) if search.tune is None else search.tune
    data, pulls = of.data, of.pulls and not search.whole
    _enough(of, free)
    start = _centered(muscle, free, given)
    # what is compiled knows more constants than are free, so that other choices share it
    among = free
    if search.among:
        among = named([*names, *search.among], muscle)
    elif pulls and not tuning:
        among = constants_of(start, free)
    shared = bool(search.among) or among != free
    mask = np.array([one in free for one in among]) if shared else None
    if shared:
        start = explicit(start, among)
    center = np.asarray(coordinates(among, start))
    deviation = np.array([_deviation(one, start, given.get(one.name)) for one in among])
    more: dict[str, Any] = {"free": mask, "pulls": pulls}
    if search.among:
        more["corrects"] = np.asarray(tuning)
    # a strain without the length it refers to is the muscle's own
    rest = None if of.record.rest_length is None else np.asarray(of.record.rest_length)
    if tuning:
        data = on_length(data, of.record, start)
        if rest is not None and search.among:
            more["rest_length"] = start.length  # the others have one
        readings, problem = problem_of(
            start, data, weighed(data, search.weights), center, deviation, among, search.loss,
            **more,
        )  # fmt: skip
        return problem, readings
    noise = np.asarray(_FIRST_NOISE * float(np.max(np.abs(np.asarray(data.force)))))
    return Problem(
        start, data, weighed(data, search.weights), noise, center, deviation, rest,
        no_curves() if search.among else None, among, search.loss, **more,
    ), None  # fmt: skip


def on_length(data: Grid, record: Record, muscle: Muscle) -> Grid:
    """`data` [-] of a `record` [-] with strains of the `muscle`'s own length [-]."""
    if record.rest_length is None:
        return data
    longer = record.rest_length / float(muscle.length)
    return replace(data, strain=np.asarray(data.strain) * longer)


def _enough(of: Taken, free: Sequence[Parameter]) -> None:
    data, files = of.data, ", ".join(source.name for source in of.record.sources)
    where = f"of {files} " if files else ""
    there = np.asarray(data.count) > 0
    readings = int(np.sum(there))
    if readings < len(free):
        raise InvalidInputError(
            "record",
            f"{where}holds {readings} readings for {len(free)} parameters",
            None,
            "measure more points, or free fewer parameters",
        )
    force = np.asarray(data.force)[there]
    if not of.pushes and not np.any(force):
        rule = f"{where}holds no force but 0 N"
        raise InvalidInputError("record", rule, None, "check the column of forces")
    # a passive muscle's may only push, but one under pressure was also measured where it pulls
    # noise about zero may pull a little where all else pushes
    if np.max(force) <= _NO_PULL * -np.min(force) and np.max(np.asarray(data.pressure)) > _PASSIVE:
        rule = f"{where}holds no force that pulls, the largest is {np.max(force) + 0.0:.4g} N"
        remedy = (
            "if the gauge reads a pull as negative, turn the sign with --push-positive, or with"
            ' signs.force = "pushing positive" in the TOML beside the file; else measure where it'
            " pulls, too"
        )
        raise InvalidInputError("record", rule, None, remedy)


def _centered(muscle: Muscle, free: Sequence[Parameter], priors: Mapping[str, Prior]) -> Muscle:
    """The muscle with its priors' values, where the fit begins."""
    for name in priors:
        check_choice(name, [one.name for one in free], "priors")
    for one in free:
        prior = priors.get(one.name)
        if prior is not None:
            (check_finite if one.linear else check_positive)(prior.value, one.name, "SI")
            check_positive(prior.deviation, f"{one.name}_deviation", "SI")
            muscle = one.put(muscle, np.float64(_coordinate(one, muscle, prior.value)))
    return muscle


def _coordinate(parameter: Parameter, muscle: Muscle, value: float) -> float:
    """The coordinate [-] that gives `value`, found by bisection: each is monotone."""

    def of(z: float) -> float:
        return float(parameter.value(parameter.put(muscle, np.float64(z))))

    low, high = -60.0, 60.0
    for _ in range(70):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of(middle) < value else (low, middle)
    size = max(abs(of(0.0)), abs(value))
    if abs(of(low) - value) > 1e-9 * size:
        raise InvalidInputError(
            "priors",
            f"of {parameter.name} must be a value that it can have in this muscle",
            value,
            "check its unit",
            shown=f"{value:g} (SI)",
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
