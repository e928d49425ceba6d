r"""What can be fitted: named constants of a muscle, each on a scale where it is free.

A fit moves coordinates $z$ without bounds; each parameter turns its own into a value that
can exist, so no step of a solver ever leaves the domain: $\log$ for what must be positive,
the logit of $\alpha_0/54.7°$ for the braid angle. The hinge's factor is affine in pressure
and must stay positive up to 1 MPa [R14]: its coordinates are the logarithm of its value at
zero pressure, and $z$ in $\ln(1 + e^z)$, its value at 1 MPa. Forces are linear in that one,
and so, nearly, is the coordinate.

Each carries a weak prior, a factor of $e^3 \approx 20$ either way around the muscle's own
value: a parameter that the data say nothing about stays there, one they determine doesn't
notice it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from operator import attrgetter
from types import MappingProxyType
from typing import Any

import equinox as eqx
import jax

from ...core.array_namespace import array_namespace, exp, expm1, log, maximum, where
from ...core.errors import InvalidInputError
from ...core.parameters import Constant
from ...core.types import Batch
from ...core.validation import HIGHEST_PRESSURE, NEUTRAL_ANGLE, check_choice
from ...muscle import Muscle
from ...muscle.laws import LAWS
from ...muscle.materials import MooneyRivlin


RUBBER = ("c10", "c01")  # that store a stretched wall's energy
WEAK = 3.0  # standard deviation of a prior that nobody gave, on a logarithmic scale
_RESISTING = ("buckling", "collapse", "post_collapse")  # laws without a say where a muscle pulls
_SMALLEST_BAND = 1e3  # Pa, where a dead band of zero starts from: it has no logarithm


@dataclass(frozen=True)
class Parameter:
    """A constant of a muscle, and the coordinate that a fit moves instead of it.

    - `name`: as in files and on the command line [-].
    - `dimension`: a key of `units.DIMENSIONS` [-].
    - `about`: what it is, in a few words [-].
    - `value`: of a muscle [SI unit of the dimension].
    - `coordinate`: of a muscle [-].
    - `put`: a muscle with another coordinate [-].
    - `deviation`: of the prior on the coordinate that holds where nobody gave one [-].
    - `linear`: whether its interval is even about the value, not in the coordinate [-].
    """

    name: str
    dimension: str
    about: str
    value: Callable[[Muscle], Batch]
    coordinate: Callable[[Muscle], Batch]
    put: Callable[[Muscle, Batch], Muscle]
    deviation: float = WEAK
    linear: bool = False


def _positive(
    name: str, dimension: str, about: str, at: Callable[[Muscle], Batch], least: float = 0.0
) -> Parameter:
    """A positive constant `at` its place in a muscle; below `least` it starts from there."""
    return Parameter(
        name,
        dimension,
        about,
        value=at,
        coordinate=lambda muscle: log(maximum(at(muscle), least)),
        put=lambda muscle, z: eqx.tree_at(at, muscle, exp(z), is_leaf=_missing),
    )


def _missing(leaf: object) -> bool:
    return leaf is None


def _rate(muscle: Muscle) -> Batch:
    tuned = muscle.tuning.transition_rate
    return muscle.transition_rate if tuned is None else tuned


def _put_rate(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(lambda m: m.tuning.transition_rate, muscle, exp(z), is_leaf=_missing)


def _put_rubber(name: str) -> Callable[[Muscle, Batch], Muscle]:
    def put(muscle: Muscle, z: Batch) -> Muscle:
        old: Any = muscle.material
        new = eqx.tree_at(lambda m: getattr(m, name), old, exp(z))
        # a modulus that was measured apart stays; one that follows the constants follows them
        own = old.youngs_modulus, 6 * (old.c10 + old.c01)
        follows = array_namespace(*own).isclose(*own, rtol=1e-9, atol=0)
        E = where(follows, 6 * (new.c10 + new.c01), old.youngs_modulus)
        return eqx.tree_at(
            lambda m: m.material, muscle, eqx.tree_at(lambda m: m.youngs_modulus, new, E)
        )

    return put


def _angle(muscle: Muscle) -> Batch:
    share = muscle.braid_angle / NEUTRAL_ANGLE
    return log(share / (1 - share))


def _put_angle(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(lambda m: m.braid_angle, muscle, NEUTRAL_ANGLE / (1 + exp(-z)))


def _hinge(muscle: Muscle) -> Any:  # `tree_at` looks through it at what is no array yet
    return muscle.tuning.hinge_stiffness_factor


def _put_hinge(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(_hinge, muscle, exp(z))


def _slope(muscle: Muscle) -> Any:
    return muscle.tuning.hinge_stiffness_slope


def _put_slope(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(
        _slope, muscle, (array_namespace(z).logaddexp(z, 0.0) - _hinge(muscle)) / HIGHEST_PRESSURE
    )


def _far(muscle: Muscle) -> Batch:
    factor = muscle.tuning.hinge_stiffness_at(HIGHEST_PRESSURE)
    return factor + log(-expm1(-factor))


def _wall(muscle: Muscle) -> Batch:
    share = muscle.wall_thickness / muscle.outer_radius
    return log(share / (1 - share))


def _put_wall(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(lambda m: m.wall_thickness, muscle, muscle.outer_radius / (1 + exp(-z)))


def _put_radius(muscle: Muscle, z: Batch) -> Muscle:
    return eqx.tree_at(lambda m: m.outer_radius, muscle, muscle.wall_thickness + exp(z))


def _moved(one: Constant, at: str, about: str) -> Parameter:
    """A declared constant that stands `at` a place in a muscle."""
    here, scale = attrgetter(f"{at}.{one.name}"), one.transform
    assert scale is not None
    return Parameter(
        one.name, one.dimension, about, here,
        coordinate=lambda muscle: scale.coordinate(here(muscle)),
        put=lambda muscle, z: eqx.tree_at(here, muscle, scale.value(z)),
        linear=scale.even,
    )  # fmt: skip


def _of_rubber() -> Iterator[Parameter]:
    """The rubber's constants; a modulus that follows from the others follows them."""
    for one in MooneyRivlin.constants():
        if one.transform is not None:
            moved = _moved(one, "material", one.about)
            own = {"put": _put_rubber(one.name)} if one.name in RUBBER else {}
            yield replace(moved, **own)


FACTORS: tuple[Parameter, ...] = (
    _positive("youngs_modulus_factor", "number", "on E", lambda m: m.tuning.youngs_modulus_factor),
    _positive(
        "collapse_moment_factor",
        "number",
        "on the collapse moment",
        lambda m: m.tuning.collapse_moment_factor,
    ),
    Parameter(
        "hinge_stiffness_factor",
        "number",
        "on the hinge's stiffness at zero pressure",
        _hinge,
        lambda m: log(_hinge(m)),
        _put_hinge,
    ),
    Parameter(
        "hinge_stiffness_slope",
        "inverse_pressure",
        "rise of that factor with pressure",
        _slope,
        _far,
        _put_slope,
        deviation=10 * WEAK,  # one unit is a tenth of the factor per bar
        linear=True,
    ),
    Parameter(
        "transition_rate",
        "number",
        "β, from buckled to collapsed",
        _rate,
        lambda m: log(_rate(m)),
        _put_rate,
    ),
)

CONSTANTS: tuple[Parameter, ...] = (
    *_of_rubber(),
    Parameter("braid_angle", "angle", "at rest, from the axis", lambda m: m.braid_angle, _angle,
              _put_angle),
    # in this order: a radius keeps clear of the wall it starts with, then the wall is a share
    Parameter("outer_radius", "length", "of bladder and braid at rest", lambda m: m.outer_radius,
              lambda m: log(m.outer_radius - m.wall_thickness), _put_radius),
    Parameter("wall_thickness", "length", "of the bladder at rest", lambda m: m.wall_thickness,
              _wall, _put_wall),
    _positive("active_length", "length", "without the end fittings", lambda m: m.length),
    _positive("dead_band", "pressure", "that closes the gap between bladder and braid",
              lambda m: m.tuning.dead_band, least=_SMALLEST_BAND),
)  # fmt: skip

PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {parameter.name: parameter for parameter in (*FACTORS, *CONSTANTS)}
)


def of_muscle(muscle: Muscle) -> dict[str, Parameter]:
    """All parameters by name [-], those of the `muscle`'s own laws [-] among them."""
    own = (parameter for kind in LAWS for parameter in _of_law(kind, muscle))
    return dict(PARAMETERS) | {parameter.name: parameter for parameter in own}


def every() -> dict[str, str]:
    """What each name that a fit takes is [-]: constants of every muscle, then of each law that has
    them.
    """
    about, of = {name: parameter.about for name, parameter in PARAMETERS.items()}, {}
    for law in (law for laws in LAWS.values() for law in laws.values()):
        for one in law.constants():
            if one.transform is not None:
                about.setdefault(one.name, one.about)
                of.setdefault(one.name, []).append(law.name)
    return {
        name: f"{words} ({', '.join(of[name])})" if name in of else words
        for name, words in about.items()
    }


def named(names: Sequence[str], muscle: Muscle) -> tuple[Parameter, ...]:
    """The parameters of these `names` [-] of a `muscle` [-], in the order in which they are put."""
    known = of_muscle(muscle)
    if not names:
        raise InvalidInputError("fit", "must name at least one parameter", None, shown="none")
    for name in names:
        check_choice(name, known, "fit")
    return tuple(parameter for name, parameter in known.items() if name in names)


def put(
    parameters: Sequence[Parameter], muscle: Muscle, coordinates: Batch, free: Any = None
) -> Muscle:
    """`muscle` [-] with the `coordinates` [-] of `parameters` [-], one after the other; only of
    those that are `free` [-], if that is said: the others are left as they are, to the bit.
    """
    for i, (parameter, z) in enumerate(zip(parameters, coordinates, strict=True)):
        moved = parameter.put(muscle, z)
        muscle = moved if free is None else _where(free[i], moved, muscle)
    return muscle


def _where(condition: Any, moved: Muscle, muscle: Muscle) -> Muscle:
    return jax.tree.map(partial(where, condition), moved, muscle)


def constants_of(muscle: Muscle, also: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """All that the force of a `muscle` that pulls may depend on [-], and `also` others [-]."""
    rubber = RUBBER if isinstance(muscle.material, MooneyRivlin) else ()
    stored = {one.name for one in MooneyRivlin.constants()} - set(rubber)
    pulling = [one.name for one in CONSTANTS if one.name not in stored]
    kinds = [kind for kind in LAWS if kind not in _RESISTING]
    own = [one.name for kind in kinds for one in _of_law(kind, muscle)]
    return named([*pulling, *own, *(one.name for one in also)], muscle)


def explicit(muscle: Muscle, parameters: Sequence[Parameter]) -> Muscle:
    """The same `muscle` [-]; if `parameters` [-] hold the rate of transition, with that rate where
    they put it, so that it can be left as it is.
    """
    if not any(one.name == "transition_rate" for one in parameters):
        return muscle
    return eqx.tree_at(lambda m: m.tuning.transition_rate, muscle, _rate(muscle), is_leaf=_missing)


def values(parameters: Sequence[Parameter], muscle: Muscle) -> Batch:
    """Values of `parameters` [-] in `muscle` [-], each in its own SI unit [SI]."""
    return _stacked([parameter.value(muscle) for parameter in parameters])


def coordinates(parameters: Sequence[Parameter], muscle: Muscle) -> Batch:
    """Coordinates of `parameters` [-] in `muscle` [-]."""
    return _stacked([parameter.coordinate(muscle) for parameter in parameters])


def _stacked(numbers: Sequence[Batch]) -> Batch:
    return array_namespace(*numbers).stack(numbers)


@cache
def _law_parameter(kind: str, law: str, constant: Constant) -> Parameter:
    """A constant of a law; cached, since what is compiled is found by its identity."""
    return _moved(constant, kind, f"of {law}")


def _of_law(kind: str, muscle: Muscle) -> list[Parameter]:
    """The own constants of a kind of law, where it has any that a fit moves."""
    law = getattr(muscle, kind)
    return [
        _law_parameter(kind, law.name, one) for one in law.constants() if one.transform is not None
    ]
