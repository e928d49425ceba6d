"""What commands compute: whether it fits is said before, and it leaves as tables."""

import itertools
from collections.abc import Sequence

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.own import scheme_used
from ..core.errors import InvalidInputError
from ..energetics.efficiency import EfficiencyMap, efficiency_map
from ..results import tables
from ..results.labelled import Table
from .memory import check_memory, of_efficiency, of_equilibria, of_recruitment, of_space


def bundle_equilibria(bundle: Bundle, states: list[list[float]], resistance: bool) -> Table:
    """A bundle's free strain, and all strains of zero force with their stability.

    **Arguments:**

    - `bundle`: whose [-].
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** a table [-]; `equilibria` is NaN where there are fewer.
    """
    P = np.asarray(states)
    check_memory(of_equilibria(P.shape[1], len(P)), f"{P.shape[1]} motor units in {len(P)} states")
    return tables.bundle_equilibria(bundle, P, resistance)


def bundle_space(
    bundle: Bundle,
    supply_pressure: float | None,
    levels: list[float] | None,
    strains: list[float] | None,
    resistance: bool,
    scheme: str | None,
) -> tuple[Table, recruitment.Space]:
    """A bundle's recruitment states and their overlap.

    **Arguments:**

    - `bundle`: whose [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `levels`: throttled pressures [Pa], or `None`.
    - `strains`: a rising list [-], or `None`.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: by name [-], or `None` for the bundle's own.

    **Returns:** a table, and the space itself [-].
    """
    _rising(strains)
    units, points = len(bundle.motor_units), len(strains or range(201))
    need = of_space(units, len(levels or range(7)), points)
    check_memory(need, f"{units} motor units at {points} strains")
    space = recruitment.space(
        bundle,
        supply_pressure,
        7 if levels is None else levels,
        strains,
        resistance=resistance,
        scheme=scheme,
    )
    return tables.space(space), space


def bundle_recruit(
    bundle: Bundle,
    forces: list[float],
    strains: list[float],
    supply_pressure: float | None,
    scheme: str | None,
    resistance: bool,
) -> Table:
    """The states and pressures of a bundle that give forces at strains.

    **Arguments:**

    - `bundle`: whose [-].
    - `forces`: demanded, a list [N].
    - `strains`: a list [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `scheme`: by name [-], or `None` for the bundle's own.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** a table [-]; `solution_pressure` is NaN where there are fewer.
    """
    F, eps = np.asarray(forces), np.asarray(strains)
    units = len(bundle.motor_units)
    check_memory(
        of_recruitment(units) * (1 + F.size * eps.size / 10),
        f"{F.size * eps.size} demands of {units} motor units",
    )
    found = recruitment.recruit(
        bundle, F[:, None], eps, supply_pressure, scheme, resistance=resistance
    )
    return tables.recruited(found, F, eps)


def is_free(bundle: Bundle, scheme: str | None) -> bool:
    """Whether a `bundle`'s units have a pressure each, by its own `scheme` or by this one [-]."""
    return scheme_used(bundle, scheme).independent


def bundle_efficiency(
    bundle: Bundle,
    supply_pressure: float | None,
    paths: Sequence[str],
    forces: list[float] | None,
    strains: list[float] | None,
    resistance: bool,
    scheme: str | None,
) -> tuple[Table, list[EfficiencyMap]]:
    """A bundle's efficiencies, along each path.

    **Arguments:**

    - `bundle`: whose [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `paths`: "isobaric", "isotonic" [-].
    - `forces`: a list [N], or `None`.
    - `strains`: a rising list [-], or `None`.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: by name [-], or `None` for the bundle's own.

    **Returns:** a table, and the maps themselves [-].
    """
    _rising(strains)
    units, sides = len(bundle.motor_units), (len(forces or range(80)), len(strains or range(225)))
    check_memory(
        of_efficiency(units, *sides), f"{units} motor units at {sides[0]} x {sides[1]} points"
    )
    maps = [
        efficiency_map(bundle, supply_pressure, path, forces, strains, resistance, scheme)
        for path in paths
    ]
    return tables.efficiency(maps), maps


def _rising(strains: list[float] | None) -> None:
    if strains is not None and any(b <= a for a, b in itertools.pairwise(strains)):
        raise InvalidInputError("--strain", "must rise from each value to the next", None)
