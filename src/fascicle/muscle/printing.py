"""Printed muscles: sizes with their units, laws, and a small table."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..core.module import repr_fields
from ..core.validation import HIGHEST_PRESSURE
from ..repr_table import ReprTable, format_number, format_range
from ..units import exact, format_digits, pretty
from .law import AbstractLaw, Declared
from .laws import LAWS, is_written_out
from .materials import MATERIALS, AbstractMaterial
from .tuning import Tuning


if TYPE_CHECKING:
    from .muscle import Muscle


# sizes of a muscle, and their dimensions
SIZES = dict.fromkeys(("length", "outer_radius", "wall_thickness"), "length")
SIZES |= {"braid_angle": "angle"}
# Pa, highest pressure of the table without a tuning: what soft muscles are driven with
_TOP = 400e3
_ROWS = 5  # pressures of the table: as many as fit beside the code


def muscle_table(muscle: "Muscle") -> ReprTable:
    """Table of a muscle: sizes, laws, and blocked force, free and collapse strain by pressure."""
    facts = [(_spaced(name), range_text(muscle, name, d)) for name, d in SIZES.items()]
    facts.append(("material", material_text(muscle.material)))
    for kind in LAWS:
        law = getattr(muscle, kind)
        if is_written_out(kind, law):
            facts.append((kind.replace("_", "-"), law_text(law)))
    if muscle.tuning.transition_rate is None:  # a tuning's rate is in its text
        facts.append(("transition rate", format_range(muscle.transition_rate, format_digits)))
    facts.append(("tuning", tuning_text(muscle.tuning)))
    if not muscle.is_single:
        return ReprTable("Muscles, rows of them", facts)
    tuning, highest = muscle.tuning, _TOP
    if tuning.pressures.size > 1:
        last = float(np.max(np.asarray(tuning.pressures)) + tuning.dead_band)
        highest = min(last, HIGHEST_PRESSURE)
    P = np.linspace(0.0, highest, _ROWS)
    columns = (muscle.blocked_force(P), muscle.free_strain(P), muscle.collapse_strain(P))
    rows = []
    for p, blocked, free, collapse in zip(P, *columns, strict=True):
        last = f"{collapse:.4f}" if np.isfinite(collapse) else "never"
        rows.append([format_number(p / 1e3), format_number(blocked), f"{free:.4f}", last])
    heads = ("pressure kPa", "blocked force N", "free strain", "collapse strain")
    return ReprTable("Muscle", facts, heads, rows)


def muscle_line(muscle: "Muscle") -> str:
    """Python expression that constructs a single muscle; the fields of rows of muscles."""
    if not muscle.is_single:
        return repr_fields(muscle)
    arguments = [f"{name}={exact(float(getattr(muscle, name)), d)!r}" for name, d in SIZES.items()]
    material = _material_name(muscle.material)
    arguments.append(f"material={repr(material) if material else repr(muscle.material)}")
    for kind, laws in LAWS.items():
        law = getattr(muscle, kind)
        if law != laws.default():  # by name where its numbers are the default ones
            arguments.append(f"{kind}={(law.name if law == type(law)() else law)!r}")
    if muscle.transition_rate != 25.0:
        arguments.append(f"transition_rate={float(muscle.transition_rate)!r}")
    if muscle.tuning != type(muscle.tuning)():
        arguments.append(f"tuning={muscle.tuning!r}")
    return f"Muscle({', '.join(arguments)})"


def law_text(law: AbstractLaw) -> str:
    """Name of a law with its constants and switches."""
    numbers = _constants_text(law)
    return f"{law.name}: {numbers}" if numbers else law.name


def material_text(material: AbstractMaterial) -> str:
    """Name of a material with its constants."""
    name, numbers = _material_name(material), _constants_text(material) or type(material).__name__
    return f"{name}: {numbers}" if name else numbers


def tuning_text(tuning: Tuning) -> str:
    """Corrections of a tuning in words."""
    texts = []
    rows = np.shape(tuning.pressures)[-1]
    if rows > 1:
        top = pretty(float(np.max(np.asarray(tuning.pressures))), "pressure")
        texts.append(f"C1 and C2 at {rows} pressures up to {top}")
    bar: Callable[[float], str] = lambda x: f"{x * 1e5:+.3g}"  # noqa: E731
    for name, neutral, text, show in (
        ("youngs_modulus_factor", 1.0, "E × {}", format_digits),
        ("collapse_moment_factor", 1.0, "collapse moment × {}", format_digits),
        ("hinge_stiffness_factor", 1.0, "hinge stiffness × {}", format_digits),
        ("hinge_stiffness_slope", 0.0, "hinge stiffness {} for each bar", bar),
        ("transition_rate", None, "transition rate {}", format_digits),
        ("dead_band", 0.0, "dead band {}", partial(pretty, dimension="pressure")),
    ):
        value = getattr(tuning, name)
        if value is not None and (neutral is None or np.any(np.asarray(value) != neutral)):
            texts.append(text.format(format_range(value, show)))
    return ", ".join(texts) or "none"


def _material_name(material: AbstractMaterial) -> str:
    """Name of a library's material that equals this one, else an empty text."""
    return next((name for name, named in MATERIALS.items() if named == material), "")


def _spaced(name: str) -> str:
    """The `name` with spaces for underscores."""
    return name.replace("_", " ")


def range_text(owner: object, name: str, dimension: str) -> str:
    """Text of the `owner`'s attribute: one number, or the least to the largest of a batch."""
    return format_range(getattr(owner, name), lambda x: pretty(x, dimension))


def _constants_text(law: Declared) -> str:
    """Text of the constants and switches of a `law`, with the values that this object has."""
    numbers = [f"{_spaced(c.name)} {range_text(law, c.name, c.dimension)}" for c in law.constants()]
    return ", ".join(
        [*numbers, *(f"{_spaced(s.name)} {getattr(law, s.name)}" for s in law.switches())]
    )
