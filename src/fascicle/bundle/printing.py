"""How bundles print, and what they answer: units, pressures and strains, in small tables."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..muscle.laws import LAWS, is_written_out
from ..muscle.printing import law_text, material_text, tuning_text
from ..repr_table import ReprTable, format_number, format_range, title_with_shape
from ..units import exact, pretty


_ROUNDING = 1e-9  # of a force
_MOST = 8  # demands that a line names
_STATUS = ("reached", "above what is reachable", "below what is reachable")


def sheet(bundle: Any) -> ReprTable:
    """A bundle's motor units, and the supply and scheme that it knows.

    **Arguments:** `bundle`: it [-].

    **Returns:** what is printed [-].
    """
    supply, units = bundle.supply_pressure, bundle.motor_units
    facts = [
        ("length", format_range(bundle.length, _in("length"))),
        (
            "supply pressure",
            "not given" if supply is None else format_range(supply, _in("pressure")),
        ),
        ("scheme", bundle.scheme.name),
        ("material", _each(material_text(unit.muscle.material) for unit in units)),
        ("laws", _each(_laws(unit.muscle) for unit in units)),
        ("tuning", _each(tuning_text(unit.muscle.tuning) for unit in units)),
    ]
    rows = [
        [
            str(number),
            format_range(unit.count, lambda n: f"{n:.0f}"),
            *(
                format_range(getattr(unit.muscle, name), _in(dimension))
                for name, dimension in _SIZES
            ),
        ]
        for number, unit in enumerate(units, start=1)
    ]
    heads = ("motor unit", "muscles", "length", "outer radius", "wall thickness", "braid angle")
    return ReprTable(
        f"Bundle of {len(units)} motor unit{'s' * (len(units) > 1)}", facts, heads, rows
    )


def line(bundle: Any) -> str:
    """A `bundle` as the Python that makes it [-]."""
    more = ""
    if bundle.supply_pressure is not None and np.ndim(bundle.supply_pressure) == 0:
        more += f", supply_pressure={exact(float(bundle.supply_pressure), 'pressure')!r}"
    more += f", scheme={bundle.scheme.name!r}"
    if bundle.plate_distance is not None and np.ndim(bundle.plate_distance) == 0:
        more += f", length={exact(float(bundle.plate_distance), 'length')!r}"
    return f"Bundle({list(bundle.motor_units)!r}{more})"


def unit_line(unit: Any) -> str:
    """A motor `unit` as the Python that makes it [-]."""
    return f"MotorUnit({unit.muscle!r}, count={np.asarray(unit.count).tolist()!r})"


def unit_sheet(unit: Any) -> ReprTable:
    """A motor `unit`: its muscle, and how many of it [-]."""
    from ..muscle.printing import muscle_table as of_muscle

    count = format_range(unit.count, lambda n: f"{n:.0f}")
    return of_muscle(unit.muscle)._replace(title=f"Motor unit of {count} × the muscle")


def equilibria_sheet(found: Any) -> ReprTable:
    """Strains of an equilibrium that was `found`, and which of them are stable [-]."""
    strains = np.asarray(found.strain).reshape(-1, np.shape(found.strain)[-1])
    firm = np.asarray(found.stable).reshape(strains.shape)
    rows = [
        [
            str(number),
            ", ".join(
                f"{strain:.4f}{'' if stable else ' u'}"
                for strain, stable in zip(*pair, strict=True)
                if math.isfinite(strain)
            )
            or "none",
        ]
        for number, pair in enumerate(zip(strains, firm, strict=True), start=1)
    ]
    unstable = np.any(np.isfinite(strains) & ~firm)
    notes = ["u: unstable, the force rises with strain there"] if unstable else []
    return ReprTable(
        title_with_shape("Equilibria", found.count), (), ("point", "strains"), rows, notes
    )


def recruited_sheet(found: Any) -> ReprTable:
    """What to do for each demand that was looked for and `found` [-]."""
    units = np.shape(found.pressures)[-1]
    pressures = np.reshape(found.pressures, (-1, units))
    columns = (found.force, found.state, found.count, found.status, found.stable)
    rows = [
        [
            format_number(force), str(state), *(format_number(p / 1e3) for p in row),
            str(count), _STATUS[status],
            "yes" if stable else "no",
        ]
        for row, force, state, count, status, stable in zip(
            pressures, *(np.ravel(x) for x in columns), strict=True
        )
    ]  # fmt: skip
    heads = ("force N", "state", *(f"P{unit + 1} kPa" for unit in range(units)), "solutions",
             "demand", "stable")  # fmt: skip
    notes = []
    if np.any(np.asarray(found.status) != 0):
        notes.append("where a demand isn't reached: the nearest force that is")
    if np.any(np.asarray(found.count) > 1):
        notes.append("of several solutions the first; `.solutions` holds all of them")
    return ReprTable(title_with_shape("Recruited", found.force), (), heads, rows, notes)


def solutions_sheet(found: Any) -> ReprTable:
    """All pressures and states that were `found`, a row for each [-]."""
    width = np.shape(found.pressure)[-1]
    columns = [np.reshape(x, (-1, width)) for x in found]
    rows = [
        [str(number), str(state), format_number(pressure / 1e3), "yes" if stable else "no"]
        for number, each in enumerate(zip(*columns, strict=True), start=1)
        for pressure, state, stable in zip(*each, strict=True)
        if state
    ]
    heads = ("demand", "state", "throttled kPa", "stable")
    none = [str(number) for number, row in enumerate(columns[1], start=1) if not np.any(row)]
    notes = []
    if none:
        every = len(none) == len(columns[1])
        which = "any" if every and len(none) > 1 else ", ".join(none[:_MOST])
        more = "" if every or len(none) <= _MOST else f" and {len(none) - _MOST} more"
        notes = [f"none for demand {which}{more}: it can't be reached"]
    return ReprTable(f"Solutions, {len(rows)}", (), heads, rows, notes)


def space_sheet(found: Any) -> ReprTable:
    """What each recruitment state of the space that was `found` reaches [-]."""
    facts = [
        ("scheme", found.scheme),
        ("supply pressure", _in("pressure")(found.supply_pressure)),
        ("throttled to", format_range(found.level, _in("pressure"))),
        ("strains", format_range(found.strain, _of)),
    ]
    rows = []
    for state, high in enumerate(found.high, start=1):
        pulls = found.strain[high > -_ROUNDING * np.max(high)]
        rows.append([str(state), format_number(np.max(high)), _of(np.max(pulls, initial=0.0))])
    return ReprTable(
        "Force-strain space", facts, ("state", "largest force N", "pulls to strain"), rows
    )


def reversal_sheet(found: Any) -> ReprTable:
    """Where a free strain turns, as it was `found` [-]."""
    if found.depth == 0:
        return ReprTable(
            "Reversal: none, the free strain never falls", [("initial", _of(found.initial))]
        )
    facts = [
        ("initial", f"{_of(found.initial)} of strain"),
        ("lowest", f"{_of(found.free_strain)} at {pretty(found.pressure, 'pressure')}"),
        ("depth", _of(found.depth)),
        ("jump", "yes, it turns at one" if found.jump else "no"),
    ]
    return ReprTable("Reversal of the free strain", facts)


_SIZES = (
    ("length", "length"),
    ("outer_radius", "length"),
    ("wall_thickness", "length"),
    ("braid_angle", "angle"),
)


def _each(told: Iterable[str]) -> str:
    """What units have, each once."""
    return "; ".join(dict.fromkeys(told))


def _in(dimension: str) -> Any:
    return lambda x: pretty(x, dimension)


def _of(strain: float) -> str:
    return f"{float(strain):.4f}"


def _laws(muscle: Any) -> str:
    laws = {kind: getattr(muscle, kind) for kind in LAWS}
    told = {
        kind.replace("_", "-"): law_text(law)
        for kind, law in laws.items()
        if is_written_out(kind, law)
    }
    return "; ".join(f"{kind} {law}" for kind, law in told.items())
