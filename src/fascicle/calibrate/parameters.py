r"""Constants of a muscle that can be fitted, each with an unbounded coordinate.

A fit changes coordinates $z$ without bounds; each parameter converts its coordinate to a possible
value, so no step of a solver leaves the domain: $\log$ of positive constants, the logit of
$\alpha_0/54.7°$ for the braid angle. The factor on the hinge's stiffness is affine in pressure and
must stay positive up to 1 MPa [R14]: its coordinates are the logarithm of its value at zero
pressure, and $z$ in $\ln(1 + e^z)$, its value at 1 MPa. Forces are linear in that value, and nearly
linear in its coordinate.

Each parameter has a weak prior, a factor of $e^3 \approx 20$ either way around its value in the
muscle: without data it stays there; where data determine it, the prior has no effect.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from ..core.array_namespace import array_namespace, exp, expm1, log, maximum, where
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.parameters import Constant
from ..core.types import Batch
from ..core.validation import HIGHEST_PRESSURE, NEUTRAL_ANGLE, check_choice
from ..muscle import Muscle
from ..muscle.laws import LAWS, OMIT_IF_DEFAULT
from ..muscle.materials import MooneyRivlin
from .gauges import DIMENSIONS, PERFECT, Gauge


RUBBER = ("c10", "c01")  # constants of a stretched wall's energy
WEAK = 3.0  # standard deviation of the default prior, on a logarithmic scale
RESISTING = ("buckling", "collapse", "post_collapse")  # laws without effect on the pull
_MIN_BAND = 1e3  # Pa, start of the search for a dead band of zero: it has no logarithm


@dataclass(frozen=True)
class Parameter:
    """A constant of a muscle, or `of_gauge` an error of the bench's gauges, and the coordinate that
    a fit changes instead of it.

    - `about`: description, a noun phrase.
    - `value`, `coordinate`: functions from a muscle or gauge to the value [SI unit of the
      `dimension`] and to the coordinate [-]; `put`: from it and a coordinate to one that has it.
    - `deviation`: standard deviation of the default prior of the coordinate [-].
    - `linear`: the interval is symmetric in the value, not in the coordinate.
    """

    name: str
    dimension: str
    about: str
    value: Callable[[Any], Batch]
    coordinate: Callable[[Any], Batch]
    put: Callable[[Any, Batch], Any]
    deviation: float = WEAK
    linear: bool = False
    of_gauge: bool = False


def _with_value(module: Any, path: str, value: Batch) -> Any:
    """The `module` with another `value` at a dotted `path`, without checks."""
    name, _, inner = path.partition(".")
    if inner:
        value = _with_value(getattr(module, name), inner, value)
    return with_fields(module, **{name: value})


def _positive(name: str, dimension: str, about: str, path: str, start: float = 0.0) -> Parameter:
    """A positive constant at a `path` of a muscle; the search begins at `start` or above."""
    value = attrgetter(path)
    return Parameter(
        name, dimension, about, value,
        coordinate=lambda muscle: log(maximum(value(muscle), start)),
        put=lambda muscle, z: _with_value(muscle, path, exp(z)),
    )  # fmt: skip


def _declared(constant: Constant, kind: str, about: str) -> Parameter:
    """A constant declared by a `kind` of law, or by the material; at a bound from there on."""
    path, scale = f"{kind}.{constant.name}", constant.transform
    value = attrgetter(path)
    assert scale is not None
    least, _, _, largest = constant.bounds

    def put(muscle: Muscle, z: Batch) -> Muscle:
        new = scale.value(z)
        # the ends belong to the inside: a fit that begins at one has a slope there
        new = where(new >= least, where(new <= largest, new, largest), least)
        return _with_value(muscle, path, new)

    return Parameter(
        constant.name, constant.dimension, about, value,
        coordinate=lambda muscle: scale.coordinate(value(muscle)),
        put=put,
        linear=scale.even,
    )  # fmt: skip


def _of_rubber() -> Iterator[Parameter]:
    """Constants of the rubber; a Young's modulus derived from C10 and C01 changes with them."""
    for constant in MooneyRivlin.constants():
        if constant.transform is not None:
            parameter = _declared(constant, "material", constant.about)
            if constant.name in RUBBER:
                parameter = replace(parameter, put=partial(_put_rubber, constant.name))
            yield parameter


def _put_rubber(name: str, muscle: Muscle, z: Batch) -> Muscle:
    old: Any = muscle.material
    new = with_fields(old, **{name: exp(z)})
    # a measured modulus stays; one equal to 6 (C10 + C01) but for rounding is derived
    pair = old.youngs_modulus, 6 * (old.c10 + old.c01)
    derived = array_namespace(*pair).isclose(*pair, rtol=1e-9, atol=0)
    E = where(derived, 6 * (new.c10 + new.c01), old.youngs_modulus)
    return with_fields(muscle, material=with_fields(new, youngs_modulus=E))


def _rate(muscle: Muscle) -> Batch:
    """Transition rate of a `muscle` [-]: its tuning's, if that has one."""
    tuned = muscle.tuning.transition_rate
    return muscle.transition_rate if tuned is None else tuned


def _hinge_at_highest(muscle: Muscle) -> Batch:
    """Inverse of softplus, which keeps it positive, of the hinge's factor at highest pressure."""
    factor = muscle.tuning.hinge_stiffness_at(HIGHEST_PRESSURE)
    return factor + log(-expm1(-factor))


def _put_hinge_slope(muscle: Muscle, z: Batch) -> Muscle:
    factor = array_namespace(z).logaddexp(z, 0.0)
    slope = (factor - muscle.tuning.hinge_stiffness_factor) / HIGHEST_PRESSURE
    return _with_value(muscle, "tuning.hinge_stiffness_slope", slope)


def _logit(fraction: Batch) -> Batch:
    """Log odds of a `fraction` [-]: a search coordinate without limits."""
    return log(fraction / (1 - fraction))


FACTORS: tuple[Parameter, ...] = (
    _positive("youngs_modulus_factor", "number", "factor on Young's modulus",
              "tuning.youngs_modulus_factor"),
    _positive("collapse_moment_factor", "number", "factor on the collapse moment",
              "tuning.collapse_moment_factor"),
    _positive("hinge_stiffness_factor", "number",
              "factor on the hinge's stiffness at zero pressure",
              "tuning.hinge_stiffness_factor"),
    Parameter(
        "hinge_stiffness_slope", "inverse_pressure", "rise of the hinge's factor with pressure",
        attrgetter("tuning.hinge_stiffness_slope"), _hinge_at_highest, _put_hinge_slope,
        deviation=10 * WEAK,  # one unit is a tenth of the factor per bar
        linear=True,
    ),
    Parameter(
        "transition_rate", "number", "rate β of the transition from buckled to collapsed", _rate,
        coordinate=lambda muscle: log(_rate(muscle)),
        put=lambda muscle, z: _with_value(muscle, "tuning.transition_rate", exp(z)),
    ),
)  # fmt: skip

CONSTANTS: tuple[Parameter, ...] = (
    *_of_rubber(),
    Parameter(
        "braid_angle", "angle", "fiber angle at rest, from the axis", attrgetter("braid_angle"),
        coordinate=lambda muscle: _logit(muscle.braid_angle / NEUTRAL_ANGLE),
        put=lambda muscle, z: _with_value(muscle, "braid_angle", NEUTRAL_ANGLE / (1 + exp(-z))),
    ),
    # in this order: the radius stays above the initial wall, then the wall is a share of it
    Parameter(
        "outer_radius", "length", "radius of bladder and braid at rest", attrgetter("outer_radius"),
        coordinate=lambda muscle: log(muscle.outer_radius - muscle.wall_thickness),
        put=lambda muscle, z: _with_value(muscle, "outer_radius", muscle.wall_thickness + exp(z)),
    ),
    Parameter(
        "wall_thickness", "length", "thickness of the bladder at rest",
        attrgetter("wall_thickness"),
        coordinate=lambda muscle: _logit(muscle.wall_thickness / muscle.outer_radius),
        put=lambda muscle, z: _with_value(
            muscle, "wall_thickness", muscle.outer_radius / (1 + exp(-z))
        ),
    ),
    _positive("active_length", "length", "length that contracts, without the fittings", "length"),
    _positive("dead_band", "pressure", "pressure that closes the gap between bladder and braid",
              "tuning.dead_band", start=_MIN_BAND),
)  # fmt: skip

# size of a unit of each gauge's coordinate: a usual error, so that steps of a search fit all
GAUGE_UNITS = {"force_zero": 10.0, "force_gain": 0.02, "force_drift": 0.01, "pressure_zero": 1e3,
               "displacement_zero": 1e-3}  # fmt: skip


def _of_gauge(name: str, about: str) -> Parameter:
    """An error of a gauge."""
    unit, scale = GAUGE_UNITS[name], name == "force_gain"
    value = attrgetter(name)
    return Parameter(
        name, DIMENSIONS[name], f"gauge error: {about}", value,
        coordinate=lambda gauge: (log(value(gauge)) if scale else value(gauge)) / unit,
        put=lambda gauge, z: replace(gauge, **{name: exp(unit * z) if scale else unit * z}),
        linear=not scale, of_gauge=True,
    )  # fmt: skip


GAUGES: tuple[Parameter, ...] = (
    _of_gauge("force_zero", "reading of the load cell without force, at the first reading"),
    _of_gauge("force_gain", "factor of the load cell's readings"),
    _of_gauge("force_drift", "change of the load cell's zero with time"),
    _of_gauge("pressure_zero", "reading of the pressure transducer without pressure"),
    _of_gauge("displacement_zero", "reading of the contraction at the rest length"),
)
PARAMETERS = {parameter.name: parameter for parameter in (*FACTORS, *CONSTANTS)}
FACTOR_NAMES = tuple(factor.name for factor in FACTORS)


def parameters_of(muscle: Muscle) -> dict[str, Parameter]:
    """All parameters by name, with those of the laws of the `muscle`."""
    of_laws = (parameter for kind in LAWS for parameter in _law_parameters(kind, muscle))
    return PARAMETERS | {parameter.name: parameter for parameter in (*of_laws, *GAUGES)}


def parameter_descriptions() -> dict[str, str]:
    """Descriptions of all parameters by name: those of every muscle, then those of each law."""
    descriptions, laws = {p.name: p.about for p in (*PARAMETERS.values(), *GAUGES)}, {}
    for law in (law for kind in LAWS.values() for law in kind.values()):
        for constant in law.constants():
            if constant.transform is not None:
                descriptions.setdefault(constant.name, constant.about)
                laws.setdefault(constant.name, []).append(law.name)
    return {
        name: f"{text} ({', '.join(laws[name])})" if name in laws else text
        for name, text in descriptions.items()
    }


def select_parameters(names: Sequence[str], muscle: Muscle) -> tuple[Parameter, ...]:
    """Parameters of a `muscle` by `names`, in the order in which a fit sets them.

    **Raises:** `InvalidInputError` without names, and for a name that the muscle doesn't have.
    """
    available = parameters_of(muscle)
    if not names:
        raise InvalidInputError("fit", "must name at least one parameter", None, shown="none")
    for name in names:
        check_choice(name, available, "fit")
    return tuple(parameter for name, parameter in available.items() if name in names)


def pulling_parameters(muscle: Muscle) -> tuple[Parameter, ...]:
    """Parameters of a `muscle` that set its pull: sizes, rubber and laws; no factors."""
    rubber = RUBBER if isinstance(muscle.material, MooneyRivlin) else ()
    unused = {constant.name for constant in MooneyRivlin.constants()} - set(rubber)
    names = [constant.name for constant in CONSTANTS if constant.name not in unused]
    kinds = [kind for kind in LAWS if kind not in RESISTING]
    names += [parameter.name for kind in kinds for parameter in _law_parameters(kind, muscle)]
    return select_parameters(names, muscle)


def put(parameters: Sequence[Parameter], muscle: Muscle, coordinates: Batch) -> Muscle:
    """The `muscle` with `coordinates` [-] of its `parameters`, set one after the other."""
    with np.errstate(over="ignore"):  # a search may step, an interval end, beyond any number
        for parameter, z in zip(parameters, coordinates, strict=True):
            if not parameter.of_gauge:
                muscle = parameter.put(muscle, z)
    return muscle


def put_gauge(parameters: Sequence[Parameter], gauge: Gauge, coordinates: Batch) -> Gauge:
    """The `gauge` with the `coordinates` [-] of those `parameters` that are its errors."""
    for parameter, z in zip(parameters, coordinates, strict=True):
        if parameter.of_gauge:
            gauge = parameter.put(gauge, z)
    return gauge


def values(parameters: Sequence[Parameter], muscle: Muscle, gauge: Gauge = PERFECT) -> Batch:
    """Values of `parameters` in a `muscle` and a `gauge` [SI unit of each]."""
    return _stack_or_empty([p.value(gauge if p.of_gauge else muscle) for p in parameters])


def coordinates(parameters: Sequence[Parameter], muscle: Muscle, gauge: Gauge = PERFECT) -> Batch:
    """Coordinates of `parameters` in a `muscle` and a `gauge` [-]."""
    return _stack_or_empty([p.coordinate(gauge if p.of_gauge else muscle) for p in parameters])


def _stack_or_empty(numbers: Sequence[Batch]) -> Batch:
    xp = array_namespace(*numbers)
    return xp.stack(numbers) if numbers else xp.zeros(0)


def with_optional_laws(muscle: Muscle, names: Sequence[str] | None = None) -> Muscle:
    """The `muscle` with the optional laws, such as ends, that have the constants `names`, by
    default all: of a kind the first one with constants, whose defaults change no force.
    """
    if names is not None and set(names) <= parameters_of(muscle).keys():
        return muscle
    for kind in OMIT_IF_DEFAULT:
        laws = [name for name, law in LAWS[kind].shipped.items() if law.constants()]
        if laws and not getattr(muscle, kind).constants():
            muscle = muscle.replace(**{kind: laws[0]})
    return muscle


def _law_parameters(kind: str, muscle: Muscle) -> list[Parameter]:
    """Parameters that a muscle's law of a `kind` declares."""
    law = getattr(muscle, kind)
    return [
        _declared(constant, kind, f"{constant.about}, of {law.name}")
        for constant in law.constants()
        if constant.transform is not None
    ]
