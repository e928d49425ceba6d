"""Tables that print for bundles and their results: units, pressures and strains."""

from functools import partial
from typing import Any

import numpy as np

from ..muscle.laws import LAWS, is_written_out
from ..muscle.printing import SIZES, law_text, material_text, muscle_table, range_text, tuning_text
from ..repr_table import ReprTable, format_number, format_range, title_with_shape
from ..units import exact, pretty


_ROUNDING = 1e-9  # of a force: the free strain's own is zero but for that
_MAX_NAMES = 8  # demands that a line names
# texts of a recruitment's status 0, 1 and 2
_STATUS = ("reached", "above what is reachable", "below what is reachable")
_format_pressure = partial(pretty, dimension="pressure")


def bundle_table(bundle: Any) -> ReprTable:
    """Motor units of a bundle, its supply and scheme."""
    units, supply = bundle.motor_units, "not given"
    if bundle.supply_pressure is not None:
        supply = range_text(bundle, "supply_pressure", "pressure")
    facts = [
        ("length", range_text(bundle, "length", "length")),
        ("supply pressure", supply),
        ("scheme", bundle.scheme.name),
    ]
    texts = {
        "material": lambda muscle: material_text(muscle.material),
        "laws": _laws_text,
        "tuning": lambda muscle: tuning_text(muscle.tuning),
    }
    for name, text in texts.items():
        facts.append((name, "; ".join(dict.fromkeys(text(unit.muscle) for unit in units))))
    rows = [
        [str(number), _format_count(unit)]
        + [range_text(unit.muscle, size, dimension) for size, dimension in SIZES.items()]
        for number, unit in enumerate(units, start=1)
    ]
    heads = ("motor unit", "muscles", *(size.replace("_", " ") for size in SIZES))
    title = f"Bundle of {len(units)} motor unit{'s' * (len(units) > 1)}"
    return ReprTable(title, facts, heads, rows)


def bundle_line(bundle: Any) -> str:
    """Python expression of a bundle."""
    texts = [f"{list(bundle.motor_units)!r}"]
    if bundle.supply_pressure is not None and np.ndim(bundle.supply_pressure) == 0:
        texts.append(f"supply_pressure={exact(float(bundle.supply_pressure), 'pressure')!r}")
    texts.append(f"scheme={bundle.scheme.name!r}")
    if bundle.plate_distance is not None and np.ndim(bundle.plate_distance) == 0:
        texts.append(f"length={exact(float(bundle.plate_distance), 'length')!r}")
    return f"Bundle({', '.join(texts)})"


def unit_line(unit: Any) -> str:
    """Python expression of a motor unit."""
    return f"MotorUnit({unit.muscle!r}, count={np.asarray(unit.count).tolist()!r})"


def unit_table(unit: Any) -> ReprTable:
    """Muscle of a motor unit, and their number."""
    title = f"Motor unit of {_format_count(unit)} × the muscle"
    return muscle_table(unit.muscle)._replace(title=title)


def equilibria_table(equilibria: Any) -> ReprTable:
    """Strains of equilibria, the unstable ones marked."""
    strains = np.asarray(equilibria.strain).reshape(-1, np.shape(equilibria.strain)[-1])
    stable = np.asarray(equilibria.stable).reshape(strains.shape)
    exists = np.isfinite(strains)
    rows = []
    for i, mask in enumerate(exists):
        pairs = zip(strains[i, mask], stable[i, mask], strict=True)
        texts = [f"{strain:.4f}{'' if is_stable else ' u'}" for strain, is_stable in pairs]
        rows.append([str(i + 1), ", ".join(texts) or "none"])
    unstable = np.any(exists & ~stable)
    notes = ["u: unstable, the force rises with strain there"] * bool(unstable)
    title = title_with_shape("Equilibria", equilibria.count)
    return ReprTable(title, (), ("point", "strains"), rows, notes)


def recruitment_table(result: Any) -> ReprTable:
    """Pressures for each demand, and whether it is reached."""
    pressures = np.reshape(result.pressures, (-1, np.shape(result.pressures)[-1]))
    columns = (result.force, result.state, result.count, result.status, result.stable)
    rows = []
    for row, force, state, count, status, stable in zip(
        pressures, *map(np.ravel, columns), strict=True
    ):
        texts = [format_number(force), str(state), *(format_number(p / 1e3) for p in row)]
        rows.append([*texts, str(count), _STATUS[status], "yes" if stable else "no"])
    heads = [f"P{unit + 1} kPa" for unit in range(pressures.shape[1])]
    heads = ("force N", "state", *heads, "solutions", "demand", "stable")
    notes = []
    if np.any(np.asarray(result.status) != 0):
        notes.append("for a demand that isn't reached: the nearest force that is")
    if np.any(np.asarray(result.count) > 1):
        notes.append("of several solutions the first; `.solutions` holds all of them")
    return ReprTable(title_with_shape("Recruitment", result.force), (), heads, rows, notes)


def solutions_table(solutions: Any) -> ReprTable:
    """All throttled pressures and states, a row for each solution."""
    columns = [np.reshape(x, (-1, np.shape(solutions.pressure)[-1])) for x in solutions]
    rows = [
        [str(number), str(state), format_number(pressure / 1e3), "yes" if stable else "no"]
        for number, values in enumerate(zip(*columns, strict=True), start=1)
        for pressure, state, stable in zip(*values, strict=True)
        if state
    ]
    notes, unreached = [], np.flatnonzero(~np.any(columns[1], axis=1)) + 1
    if len(unreached):
        names, more = ", ".join(map(str, unreached[:_MAX_NAMES])), len(unreached) - _MAX_NAMES
        names += f" and {more} more" if more > 0 else ""
        names = "any" if len(unreached) == len(columns[1]) > 1 else names
        notes = [f"none for demand {names}: it can't be reached"]
    heads = ("demand", "state", "throttled kPa", "stable")
    return ReprTable(f"Solutions, {len(rows)}", (), heads, rows, notes)


def workspace_table(workspace: Any) -> ReprTable:
    """Largest force and strain that each recruitment state reaches."""
    facts = [
        ("scheme", workspace.scheme),
        ("supply pressure", _format_pressure(workspace.supply_pressure)),
        ("throttled to", format_range(workspace.level, _format_pressure)),
        ("strains", format_range(workspace.strain, "{:.4f}".format)),
    ]
    rows = []
    for state, high in enumerate(workspace.high, start=1):
        pulls = workspace.strain[high > -_ROUNDING * np.max(high)]
        strain = np.max(pulls, initial=0.0)
        rows.append([str(state), format_number(np.max(high)), f"{strain:.4f}"])
    heads = ("state", "largest force N", "pulls to strain")
    return ReprTable("Workspace", facts, heads, rows)


def reversal_table(reversal: Any) -> ReprTable:
    """Turn of a free strain."""
    initial = f"{reversal.initial:.4f}"
    if reversal.depth == 0:
        return ReprTable("Reversal: none, the free strain never falls", [("initial", initial)])
    facts = [
        ("initial", f"{initial} of strain"),
        ("lowest", f"{reversal.free_strain:.4f} at {_format_pressure(reversal.pressure)}"),
        ("depth", f"{reversal.depth:.4f}"),
        ("jump", "yes, it turns at one" if reversal.jump else "no"),
    ]
    return ReprTable("Reversal of the free strain", facts)


def efficiency_table(efficiencies: Any) -> ReprTable:
    """Range, average and best of an efficiency map."""
    eta, force, strain = efficiencies.efficiency, efficiencies.force, efficiencies.strain
    covered = np.isfinite(eta)
    facts = [
        ("path", efficiencies.path),
        ("reached", f"{np.sum(covered)} of {eta.size} points"),
        ("forces", format_range(force, lambda F: f"{format_number(F)} N")),
        ("strains", format_range(strain, "{:.4f}".format)),
    ]
    if np.any(covered):
        row, column = np.unravel_index(np.nanargmax(eta), eta.shape)
        point = f"at {format_number(force[row])} N, strain {strain[column]:.4f}"
        facts.append(("average", f"{efficiencies.average:.4f}"))
        facts.append(("best", f"{np.nanmax(eta):.4f} {point}"))
    return ReprTable("Efficiency", facts)


def _format_count(unit: Any) -> str:
    return format_range(unit.count, "{:.0f}".format)


def _laws_text(muscle: Any) -> str:
    """Laws of a `muscle` that its file would name, such as "buckling kim2021"."""
    laws = {kind: getattr(muscle, kind) for kind in LAWS}
    return "; ".join(
        f"{kind.replace('_', '-')} {law_text(law)}"
        for kind, law in laws.items()
        if is_written_out(kind, law)
    )
