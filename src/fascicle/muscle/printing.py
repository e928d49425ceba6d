"""How a muscle and what it answers print: sizes with their units, laws, a small table."""

from typing import Any

import numpy as np

from ..core.module import repr_fields
from ..core.validation import HIGHEST_PRESSURE
from ..repr_table import ReprTable, format_number, format_range
from ..units import exact, figures, pretty
from .law import Declared
from .laws import LAWS, said
from .materials import MATERIALS


Muscle = Any  # the class, which imports this

_SIZES = {
    "length": "length",
    "outer_radius": "length",
    "wall_thickness": "length",
    "braid_angle": "angle",
}
_FACTORS = {
    "youngs_modulus_factor": "E",
    "collapse_moment_factor": "collapse moment",
    "hinge_stiffness_factor": "hinge stiffness",
}
_TOP = 400e3  # Pa, of the table where no tuning says how far it was measured
_ROWS = 5


def sheet(muscle: Muscle) -> ReprTable:
    """A muscle's sizes and laws, and what it does at a few pressures.

    **Arguments:** `muscle`: it [-].

    **Returns:** what is printed [-].
    """
    facts = [
        (name.replace("_", " "), format_range(getattr(muscle, name), lambda x, d=d: pretty(x, d)))
        for name, d in _SIZES.items()
    ]
    facts += [("material", material(muscle.material))]
    facts += [
        (kind.replace("_", "-"), words(getattr(muscle, kind)))
        for kind in LAWS
        if said(kind, getattr(muscle, kind))
    ]
    if muscle.tuning.transition_rate is None:  # a tuning's own stands with the tuning
        facts += [("transition rate", format_range(muscle.transition_rate, figures))]
    facts += [("tuning", tuned(muscle.tuning))]
    title = "Muscle" if muscle._is_single else "Muscles, rows of them"
    if not muscle._is_single:
        return ReprTable(title, facts)
    P = np.linspace(0.0, _top(muscle), _ROWS)
    found = (muscle.blocked_force(P), muscle.free_strain(P), muscle.collapse_strain(P))
    rows = [
        [
            format_number(p / 1e3),
            format_number(blocked),
            f"{free:.4f}",
            f"{c:.4f}" if np.isfinite(c) else "never",
        ]
        for p, blocked, free, c in zip(P, *found, strict=True)
    ]
    heads = ("pressure kPa", "blocked force N", "free strain", "collapse strain")
    return ReprTable(title, facts, heads, rows)


def line(muscle: Muscle) -> str:
    """A `muscle` as the Python that makes it, for a single one [-]."""
    if not muscle._is_single:
        return repr_fields(muscle)
    given = [f"{name}={exact(float(getattr(muscle, name)), d)!r}" for name, d in _SIZES.items()]
    given.append(f"material={_named(muscle.material)}")
    for kind, laws in LAWS.items():
        law = getattr(muscle, kind)
        if law != _first(laws):
            given.append(f"{kind}={_by_name(law)}")
    if muscle.transition_rate != 25.0:
        given.append(f"transition_rate={float(muscle.transition_rate)!r}")
    if muscle.tuning != type(muscle.tuning)():
        given.append(f"tuning={muscle.tuning!r}")
    return f"Muscle({', '.join(given)})"


def words(law: Any) -> str:
    """A `law` by its name, with its numbers [-]."""
    numbers = _constants(law)
    return f"{law.name}: {numbers}" if numbers else law.name


def tuned(tuning: Any) -> str:
    """What a `tuning` corrects, in words [-]."""
    if tuning == type(tuning)():
        return "none"
    told = []
    rows = np.shape(tuning.pressures)[-1]
    if rows > 1:
        top = float(np.max(np.asarray(tuning.pressures)))
        told.append(f"C1 and C2 at {rows} pressures up to {pretty(top, 'pressure')}")
    for name, what in _FACTORS.items():
        value = getattr(tuning, name)
        if np.any(np.asarray(value) != 1):
            told.append(f"{what} × {format_range(value, figures)}")
    if np.any(np.asarray(tuning.hinge_stiffness_slope) != 0):
        slope = format_range(tuning.hinge_stiffness_slope, lambda x: f"{x * 1e5:+.3g}")
        told.append(f"hinge stiffness {slope} for each bar")
    if tuning.transition_rate is not None:
        told.append(f"transition rate {format_range(tuning.transition_rate, figures)}")
    if np.any(np.asarray(tuning.dead_band) != 0):
        band = format_range(tuning.dead_band, lambda x: pretty(x, "pressure"))
        told.append(f"dead band {band}")
    return ", ".join(told)


def _top(muscle: Muscle) -> float:
    """The highest pressure of the table [Pa]: no further than a tuning was measured."""
    rows = np.asarray(muscle.tuning.pressures)
    if rows.size < 2:
        return _TOP
    return min(float(rows.max() + muscle.tuning.dead_band), HIGHEST_PRESSURE)


def material(of: Any) -> str:
    """A material `of` a bladder by its name, with its numbers [-]."""
    name = _known(of)
    numbers = _constants(of) or type(of).__name__
    return f"{name}: {numbers}" if name else numbers


def _named(material: Any) -> str:
    name = _known(material)
    return repr(name) if name else repr(material)


def _known(material: Any) -> str:
    return next((name for name, one in MATERIALS.items() if one == material), "")


def _constants(law: Declared) -> str:
    numbers = [
        f"{one.name.replace('_', ' ')} "
        + format_range(getattr(law, one.name), lambda x, d=one.dimension: pretty(x, d))
        for one in law.constants()
    ]
    choices = [f"{one.name.replace('_', ' ')} {getattr(law, one.name)}" for one in law.switches()]
    return ", ".join(numbers + choices)


def _first(laws: Any) -> Any:
    """The law [-] that is taken where none is chosen."""
    return next(iter(laws.values()))()


def _by_name(law: Any) -> str:
    """A `law` as the Python that chooses it: by name where its numbers are those left out [-]."""
    return repr(law.name) if law == type(law)() else repr(law)
