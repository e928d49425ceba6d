"""Setting of all figures: the paper's muscles, pressures and tested range.

Every muscle is a named example, so its sizes stand in one file with their source.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial, wraps
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import numpy as np

import fascicle.jax  # noqa: F401 muscles as pytrees
from fascicle.bundle import Bundle, MotorUnit
from fascicle.files import example
from fascicle.muscle import Muscle, Tuning
from fascicle.muscle.materials import LATEX, MooneyRivlin
from fascicle.plot.curves import Components, components_of

from ..claims import claim_builder
from .series import SpringsInSeries
from .springs import LinkedSprings, ResolvedSprings, StiffSprings


PRESSURES = np.array([0.0, 34.5, 68.9, 103.4, 137.9, 344.7]) * 1e3  # Pa, Figs 6, 7 and 12
FIGURE_6, FIGURE_12 = [0, 1, 4, 5], [0, 1, 2, 3, 4]  # which of them
STRAIN = np.linspace(0.0, 0.3, 301)
TABLE = np.linspace(0.0, 413.7e3, 13)  # Pa, of C1 and C2: every 5 psi, as tested
HIGHEST = 413.7e3  # Pa, the largest pressure tested, and the supply's in sections 4.1 and 4.2
UNIT_1 = 344.7e3  # Pa, motor unit 1 in section 6
claim = claim_builder(Path(__file__).with_name("claims.toml"))
Function = TypeVar("Function", bound=Callable[..., Any])
UNTUNED = "C₁ = 0 and C₂ = 1: the paper shows these two tables of section 5.1 nowhere."


def _with_latex(share: float, muscle: Muscle) -> Muscle:
    """A muscle whose bladder has in tension a `share` of the constants of latex [R3]."""
    numbers = tuple(share * np.asarray(constant) for constant in (LATEX.c10, LATEX.c01))
    return eqx.tree_at(lambda m: (m.material.c10, m.material.c01), muscle, numbers)


def _in_megapascals(muscle: Muscle) -> Muscle:
    """A muscle whose P in Table 1's factor on k_r is in MPa instead of bar [R14]."""
    slope = muscle.tuning.hinge_stiffness_slope
    return eqx.tree_at(lambda m: m.tuning.hinge_stiffness_slope, muscle, 0.1 * slope)


class PaperReading(NamedTuple):
    """One way to read the paper: its `condition`, a clause, and the `change` to a muscle."""

    condition: str
    change: Callable[[Muscle], Muscle]


def _by_law(condition: str, **laws: Any) -> PaperReading:
    return PaperReading(condition, lambda muscle: muscle.replace(**laws))


READINGS: Mapping[str, PaperReading] = MappingProxyType({
    "derived": PaperReading("as in every figure", lambda muscle: muscle),
    "resolved": _by_law("if the joint of the springs is in equilibrium [R19]",
                        buckling=ResolvedSprings()),
    "linked": _by_law("if the links of Fig. 4 themselves give the deflection [R20]",
                      buckling=LinkedSprings()),
    "stiff": _by_law("if each axial spring has the stiffness of half a bladder, 2EA/L_fs [R21]",
                     buckling=StiffSprings()),
    "kim2021_series": _by_law("if mesh, bladder and bow carry one force, in series",
                              buckling=SpringsInSeries()),
    "wood1958": _by_law("if (17) has the cube of r₀/t₀ [R8]", collapse="wood1958"),
    "consistent": _by_law("if the halves keep their length after collapse [R10]",
                          post_collapse="consistent"),
    "printed": _by_law("if (25) stands as in the text that we read [R10]", post_collapse="printed"),
    "softest": PaperReading("if the free strain of 0.24 is 0.245: 0.69 times latex [R3]",
                            partial(_with_latex, 0.69)),
    "stiffest": PaperReading("if the free strain of 0.24 is 0.235: 0.82 times latex [R3]",
                             partial(_with_latex, 0.82)),
    "latex": PaperReading("if the bladder is Klute and Hannaford's latex [R3]",
                          partial(_with_latex, 1.0)),
    "megapascals": PaperReading("if P in Table 1 is in MPa [R14]", _in_megapascals),
})  # fmt: skip
_READING: ContextVar[str] = ContextVar("reading", default="derived")


@contextmanager
def reading(name: str) -> Iterator[None]:
    """Context in which `muscle` follows one of the `READINGS`, by its `name`."""
    before = _READING.set(name)
    try:
        yield
    finally:
        _READING.reset(before)


def cached(function: Function) -> Function:
    """Cache a function by the present reading and its arguments."""

    @cache
    def by_reading(_reading: str, *arguments: Any) -> Any:
        return function(*arguments)

    @wraps(function)
    def cached_function(*arguments: Any) -> Any:
        return by_reading(_READING.get(), *arguments)

    return cached_function  # type: ignore[return-value]  # the same arguments, by position


def muscle(name: str) -> Muscle:
    """Named example `kim2021_` + `name` by the present reading, with its transition rate on the
    muscle itself.
    """
    result = example(f"kim2021_{name}")
    assert isinstance(result, Muscle)
    result = READINGS[_READING.get()].change(result)
    rate = result.tuning.transition_rate
    if rate is None:
        return result
    return eqx.tree_at(
        lambda m: (m.transition_rate, m.tuning.transition_rate), result, (rate, None)
    )


def tuned(factors: Tuning, c1: np.ndarray, c2: np.ndarray) -> Tuning:
    """Tuning with the factors of another and `c1` [N], `c2` [-] at the pressures of `TABLE`."""
    return Tuning(
        TABLE, c1, c2,
        youngs_modulus_factor=factors.youngs_modulus_factor,
        collapse_moment_factor=factors.collapse_moment_factor,
        hinge_stiffness_factor=factors.hinge_stiffness_factor,
        hinge_stiffness_slope=factors.hinge_stiffness_slope,
    )  # fmt: skip


@cached
def forces(name: str) -> Components:
    """Forces of a named muscle at `PRESSURES` and `STRAIN`, computed once."""
    return components_of(muscle(name), PRESSURES, STRAIN)


def bundle(muscle: Muscle, counts: tuple[int, ...], supply_pressure: float) -> Bundle:
    """A bundle of motor units with `counts` of one muscle, at `supply_pressure` [Pa]."""
    return Bundle([MotorUnit(muscle, count) for count in counts], supply_pressure)


def tested(muscle: Muscle) -> float:
    """The largest strain tested [-]: section 5.3 drives to the free strain at 413.7 kPa."""
    return float(muscle.free_strain(HIGHEST))


def resistance_after(muscle: Muscle, pressure: float, reach: float) -> float:
    """Largest resistance after collapse, up to the strain `reach` [-], over that at collapse [-].

    It is 1 if it never exceeds that at collapse; NaN if the muscle doesn't collapse before.
    """
    collapse = float(muscle.collapse_strain(pressure))
    if not collapse < reach:
        return np.nan
    # the first point is the collapse itself: a grid can't miss the largest, and none is rounded up
    force = array(muscle.force(pressure, np.linspace(collapse, reach, 2001)))
    return float((force / force[0]).max())


def sizes(muscle: Muscle) -> str:
    """Line on a muscle's sizes and material."""
    length, radius, wall = (
        1e3 * float(x) for x in (muscle.length, muscle.outer_radius, muscle.wall_thickness)
    )
    rubber = muscle.material
    assert isinstance(rubber, MooneyRivlin)
    return (
        f"L₀ {length:.4g} mm, r₀ {radius:.4g} mm, t₀ {wall:.4g} mm, "
        f"α₀ {float(np.degrees(muscle.braid_angle)):.3g}°; "
        f"E {float(rubber.youngs_modulus) / 1e6:.3g} MPa, "
        f"C₁₀ {float(rubber.c10) / 1e3:.4g} and C₀₁ {float(rubber.c01) / 1e3:.4g} kPa"
    )


def array(values: Any) -> np.ndarray:
    """Anything numeric as NumPy."""
    return np.asarray(values, dtype=float)
