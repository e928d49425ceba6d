"""Tables that print for bundles, their equilibria and recruitment."""

from typing import TYPE_CHECKING

import numpy as np

from ..muscle.laws import LAWS, is_written_out
from ..muscle.printing import SIZES, law_text, material_text, range_text, tuning_text
from ..repr_table import ReprTable, format_number, format_range, title_with_shape
from ..units import exact


if TYPE_CHECKING:
    from ..muscle import Muscle
    from .bundle import Bundle
    from .equilibria import Equilibria
    from .inverse import RecruitmentResult


# texts of a recruitment's status 0, 1 and 2
_STATUS = ("reached", "above what is reachable", "below what is reachable")


def bundle_table(bundle: "Bundle") -> ReprTable:
    """Motor units of a bundle, its supply and scheme."""
    units, supply = bundle.motor_units, "not given"
    if bundle.supply_pressure is not None:
        supply = range_text(bundle, "supply_pressure", "pressure")
    texts = {
        "material": lambda muscle: material_text(muscle.material),
        "laws": _laws_text,
        "tuning": lambda muscle: tuning_text(muscle.tuning),
    }
    facts = [
        ("length", range_text(bundle, "length", "length")),
        ("supply pressure", supply),
        ("scheme", bundle.scheme.name),
        *(
            (name, "; ".join(dict.fromkeys(text(unit.muscle) for unit in units)))
            for name, text in texts.items()
        ),
    ]
    rows = [
        [str(number), format_range(unit.count, "{:.0f}".format)]
        + [range_text(unit.muscle, size, dimension) for size, dimension in SIZES.items()]
        for number, unit in enumerate(units, start=1)
    ]
    heads = ("motor unit", "muscles", *(size.replace("_", " ") for size in SIZES))
    title = f"Bundle of {len(units)} motor unit{'s' * (len(units) > 1)}"
    return ReprTable(title, facts, heads, rows)


def bundle_line(bundle: "Bundle") -> str:
    """Python expression of a bundle, without a supply pressure or length that is an array."""
    texts = [f"{list(bundle.motor_units)!r}"]
    if bundle.supply_pressure is not None and np.ndim(bundle.supply_pressure) == 0:
        texts.append(f"supply_pressure={exact(float(bundle.supply_pressure), 'pressure')!r}")
    texts.append(f"scheme={bundle.scheme.name!r}")
    if bundle.plate_distance is not None and np.ndim(bundle.plate_distance) == 0:
        texts.append(f"length={exact(float(bundle.plate_distance), 'length')!r}")
    return f"Bundle({', '.join(texts)})"


def equilibria_table(equilibria: "Equilibria") -> ReprTable:
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


def recruitment_table(result: "RecruitmentResult") -> ReprTable:
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


def _laws_text(muscle: "Muscle") -> str:
    """All laws of a `muscle` but default ends, such as "buckling kim2021"."""
    laws = {kind: getattr(muscle, kind) for kind in LAWS}
    return "; ".join(
        f"{kind.replace('_', '-')} {law_text(law)}"
        for kind, law in laws.items()
        if is_written_out(kind, law)
    )
