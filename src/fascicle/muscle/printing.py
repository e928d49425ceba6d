"""Printed muscles: sizes with their units, laws, and a small table."""

from typing import Any

import numpy as np

from ..core.module import repr_fields
from ..core.validation import HIGHEST_PRESSURE
from ..repr_table import ReprTable, format_number, format_range
from ..units import exact, figures, pretty
from .law import Declared
from .laws import LAWS, is_written_out
from .materials import MATERIALS


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


def muscle_table(muscle: Any) -> ReprTable:
    """Sizes and laws of a muscle, and its forces and strains at a few pressures."""
    facts = [
        (name.replace("_", " "), format_range(getattr(muscle, name), lambda x, d=d: pretty(x, d)))
        for name, d in _SIZES.items()
    ]
    facts += [("material", material_text(muscle.material))]
    facts += [
        (kind.replace("_", "-"), law_text(getattr(muscle, kind)))
        for kind in LAWS
        if is_written_out(kind, getattr(muscle, kind))
    ]
    if muscle.tuning.transition_rate is None:  # a tuning's own stands with the tuning
        facts += [("transition rate", format_range(muscle.transition_rate, figures))]
    facts += [("tuning", tuning_text(muscle.tuning))]
    title = "Muscle" if muscle.is_single else "Muscles, rows of them"
    if not muscle.is_single:
        return ReprTable(title, facts)
    P = np.linspace(0.0, _highest_pressure(muscle), _ROWS)
    columns = (muscle.blocked_force(P), muscle.free_strain(P), muscle.collapse_strain(P))
    rows = [
        [
            format_number(p / 1e3),
            format_number(blocked),
            f"{free:.4f}",
            f"{c:.4f}" if np.isfinite(c) else "never",
        ]
        for p, blocked, free, c in zip(P, *columns, strict=True)
    ]
    heads = ("pressure kPa", "blocked force N", "free strain", "collapse strain")
    return ReprTable(title, facts, heads, rows)


def muscle_line(muscle: Any) -> str:
    """Python expression that makes a single muscle."""
    if not muscle.is_single:
        return repr_fields(muscle)
    arguments = [f"{name}={exact(float(getattr(muscle, name)), d)!r}" for name, d in _SIZES.items()]
    arguments.append(f"material={_material_expression(muscle.material)}")
    for kind, laws in LAWS.items():
        law = getattr(muscle, kind)
        if law != laws.default():
            arguments.append(f"{kind}={_law_expression(law)}")
    if muscle.transition_rate != 25.0:
        arguments.append(f"transition_rate={float(muscle.transition_rate)!r}")
    if muscle.tuning != type(muscle.tuning)():
        arguments.append(f"tuning={muscle.tuning!r}")
    return f"Muscle({', '.join(arguments)})"


def law_text(law: Any) -> str:
    """Name of a law, with its numbers."""
    numbers = _constants(law)
    return f"{law.name}: {numbers}" if numbers else law.name


def tuning_text(tuning: Any) -> str:
    """Corrections of a tuning in words."""
    if tuning == type(tuning)():
        return "none"
    parts = []
    rows = np.shape(tuning.pressures)[-1]
    if rows > 1:
        top = float(np.max(np.asarray(tuning.pressures)))
        parts.append(f"C1 and C2 at {rows} pressures up to {pretty(top, 'pressure')}")
    for name, what in _FACTORS.items():
        value = getattr(tuning, name)
        if np.any(np.asarray(value) != 1):
            parts.append(f"{what} × {format_range(value, figures)}")
    if np.any(np.asarray(tuning.hinge_stiffness_slope) != 0):
        slope = format_range(tuning.hinge_stiffness_slope, lambda x: f"{x * 1e5:+.3g}")
        parts.append(f"hinge stiffness {slope} for each bar")
    if tuning.transition_rate is not None:
        parts.append(f"transition rate {format_range(tuning.transition_rate, figures)}")
    if np.any(np.asarray(tuning.dead_band) != 0):
        band = format_range(tuning.dead_band, lambda x: pretty(x, "pressure"))
        parts.append(f"dead band {band}")
    return ", ".join(parts)


def _highest_pressure(muscle: Any) -> float:
    """The highest pressure of the table [Pa]: no further than a tuning was measured."""
    rows = np.asarray(muscle.tuning.pressures)
    if rows.size < 2:
        return _TOP
    return min(float(rows.max() + muscle.tuning.dead_band), HIGHEST_PRESSURE)


def material_text(material: Any) -> str:
    """Name of a material, with its numbers."""
    name = _material_name(material)
    numbers = _constants(material) or type(material).__name__
    return f"{name}: {numbers}" if name else numbers


def _material_expression(material: Any) -> str:
    name = _material_name(material)
    return repr(name) if name else repr(material)


def _material_name(material: Any) -> str:
    return next((name for name, named in MATERIALS.items() if named == material), "")


def _constants(law: Declared) -> str:
    numbers = [
        f"{constant.name.replace('_', ' ')} "
        + format_range(getattr(law, constant.name), lambda x, d=constant.dimension: pretty(x, d))
        for constant in law.constants()
    ]
    choices = [
        f"{constant.name.replace('_', ' ')} {getattr(law, constant.name)}"
        for constant in law.switches()
    ]
    return ", ".join(numbers + choices)


def _law_expression(law: Any) -> str:
    """Python expression that chooses a law: its name where its numbers are the default ones."""
    return repr(law.name) if law == type(law)() else repr(law)
