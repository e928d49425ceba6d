"""What commands compute: results as labelled variables, each with its unit and meaning."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.schemes import scheme_of
from ..core.refused import Refused
from ..energetics.efficiency import efficiency_map
from ..muscle import Muscle
from ..results.labelled import Variable
from .memory import check_memory, of_efficiency, of_equilibria, of_recruitment, of_space


def muscle_force(
    muscle: Muscle, pressures: list[float], strains: list[float]
) -> dict[str, Variable]:
    """A muscle's force and what makes it up.

    **Arguments:**

    - `muscle`: whose [-].
    - `pressures`: a list [Pa].
    - `strains`: a list [-].

    **Returns:** variables by name [-], in the order of the JSON.
    """
    P, eps = np.asarray(pressures), np.asarray(strains)
    found = muscle.response(P[:, None], eps)
    free, collapse = muscle.free_strain(P), muscle.collapse_strain(P)
    regions = "0 tension, 1 post-buckling, 2 post-collapse, 3 straight compression"
    dims = ("pressure", "strain")
    return {
        "pressure": Variable(("pressure",), P, "Pa", "gauge pressure"),
        "strain": Variable(("strain",), eps, "-", "contraction over length at rest"),
        "force": Variable(dims, found.force, "N", "pulling force, equation (27)"),
        "mesh": Variable(dims, found.mesh, "N", "the braid's part of the force"),
        "bladder": Variable(dims, found.bladder, "N", "the stretched bladder's part"),
        "bending": Variable(dims, found.bending, "N", "the rest, from the bent bladder"),
        "region": Variable(dims, found.region, "-", regions),
        "free_strain": Variable(("pressure",), free, "-", "strain of zero force"),
        "collapse_strain": Variable(
            ("pressure",), collapse, "-", "strain of collapse, inf where it never does"
        ),
    }


def muscle_free_strain(muscle: Muscle, pressures: list[float]) -> dict[str, Variable]:
    """A muscle's free strain, blocked force and collapse.

    **Arguments:**

    - `muscle`: whose [-].
    - `pressures`: a list [Pa].

    **Returns:** variables by name [-].
    """
    P = np.asarray(pressures)
    return {
        "pressure": Variable(("pressure",), P, "Pa", "gauge pressure"),
        "free_strain": Variable(("pressure",), muscle.free_strain(P), "-", "strain of zero force"),
        "blocked_force": Variable(
            ("pressure",), muscle.blocked_force(P), "N", "force at rest length"
        ),
        "collapse_strain": Variable(
            ("pressure",),
            muscle.collapse_strain(P),
            "-",
            "strain of collapse, inf where it never does",
        ),
        "collapse_moment": Variable(
            ("pressure",),
            muscle.collapse_moment(P),
            "N m",
            "bending moment at which the bladder collapses",
        ),
    }


def bundle_force(
    bundle: Bundle, states: list[list[float]], strains: list[float], resistance: bool
) -> dict[str, Variable]:
    """A bundle's force, and that of its motor units.

    **Arguments:**

    - `bundle`: whose [-].
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `strains`: a list [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** variables by name [-].
    """
    P, eps = np.asarray(states), np.asarray(strains)
    forces = bundle.unit_forces(P[:, None, :], eps, resistance)
    dims = ("state", "strain")
    return {
        "strain": Variable(("strain",), eps, "-", "contraction over length at rest"),
        "force": Variable(dims, forces.sum(axis=-1), "N", "pulling force of the bundle"),
        "unit_force": Variable((*dims, "motor_unit"), forces, "N", "of each motor unit"),
    }


def bundle_equilibria(
    bundle: Bundle, states: list[list[float]], resistance: bool
) -> dict[str, Variable]:
    """A bundle's free strain, and all strains of zero force with their stability.

    **Arguments:**

    - `bundle`: whose [-].
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** variables by name [-]; `equilibria` is NaN where there are fewer.
    """
    P = np.asarray(states)
    check_memory(of_equilibria(P.shape[1], len(P)), f"{P.shape[1]} motor units in {len(P)} states")
    found = bundle.equilibria(P, resistance)
    most = max(int(found.count.max()), 1)
    dims = ("state", "equilibrium")
    return {
        # the first zero of the force is the free strain, by definition
        "free_strain": Variable(
            ("state",), found.strain[:, 0], "-", "smallest strain of zero force"
        ),
        "pressures": Variable(("state", "motor_unit"), P, "Pa", "of each motor unit"),
        "equilibria": Variable(dims, found.strain[:, :most], "-", "strains of zero force"),
        "stable": Variable(
            dims, found.stable[:, :most], "-", "whether the force falls with strain there"
        ),
    }


def bundle_space(
    bundle: Bundle,
    supply_pressure: float | None,
    levels: list[float] | None,
    strains: list[float] | None,
    resistance: bool,
    scheme: str | None,
) -> tuple[dict[str, Variable], Any]:
    """A bundle's recruitment states and their overlap.

    **Arguments:**

    - `bundle`: whose [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `levels`: throttled pressures [Pa], or `None`.
    - `strains`: a rising list [-], or `None`.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: by name [-], or `None` for the bundle's own.

    **Returns:** variables by name, and the space itself [-].
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
    overlap = recruitment.overlap(space)
    pairs = np.asarray(overlap.states, dtype=int).reshape(-1, 2)
    edge, shared = ("state", "strain"), ("pair", "strain")
    curves = ("state", "level", "strain")
    return {
        "level": Variable(("level",), space.level, "Pa", "throttled pressure"),
        "strain": Variable(("strain",), space.strain, "-", "contraction over length at rest"),
        "force": Variable(curves, space.force, "N", "of each state at each throttled pressure"),
        "low": Variable(edge, space.low, "N", "least force of each state"),
        "high": Variable(edge, space.high, "N", "largest force of each state"),
        "overlap_states": Variable(("pair", "one_of_pair"), pairs, "-", "states that overlap"),
        "overlap_low": Variable(shared, overlap.low, "N", "lower edge of the overlap"),
        "overlap_high": Variable(shared, overlap.high, "N", "upper edge of the overlap"),
        "overlap_area": Variable(("pair",), overlap.area, "N", "force times strain"),
        "supply_pressure": Variable((), np.asarray(space.supply_pressure), "Pa", "the supply's"),
        "scheme": Variable((), np.asarray(space.scheme), "-", "of recruitment"),
    }, space


def bundle_recruit(
    bundle: Bundle,
    forces: list[float],
    strains: list[float],
    supply_pressure: float | None,
    scheme: str | None,
    resistance: bool,
) -> dict[str, Variable]:
    """The states and pressures of a bundle that give forces at strains.

    **Arguments:**

    - `bundle`: whose [-].
    - `forces`: demanded, a list [N].
    - `strains`: a list [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `scheme`: by name [-], or `None` for the bundle's own.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** variables by name [-]; `solution_pressure` is NaN where there are fewer.
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
    most = max(int(found.count.max()), 1)
    every = recruitment.Solutions(*(each[..., :most] for each in found.solutions))
    throttled = np.take_along_axis(found.pressures, found.unit[..., None] - 1, axis=-1)[..., 0]
    dims = ("demand", "strain")
    of_each, of_unit = (*dims, "solution"), (*dims, "motor_unit")
    reached = "0 reached, 1 demand above what is reachable, 2 below: then the nearest"
    return {
        "demand": Variable(("demand",), F, "N", "demanded force"),
        "strain": Variable(("strain",), eps, "-", "contraction over length at rest"),
        "force": Variable(dims, found.force, "N", "pulling force that is reached"),
        "state": Variable(dims, found.state, "-", "recruitment state, counted from 1"),
        "throttled_pressure": Variable(dims, throttled, "Pa", "of the unit recruited last"),
        "pressures": Variable(of_unit, found.pressures, "Pa", "of each motor unit"),
        "status": Variable(dims, found.status, "-", reached),
        "stable": Variable(dims, found.stable, "-", "whether the force falls with strain there"),
        "solutions": Variable(dims, found.count, "-", "how many there are"),
        "solution_pressure": Variable(of_each, every.pressure, "Pa", "throttled, of each solution"),
        "solution_state": Variable(of_each, every.state, "-", "of each solution, else 0"),
        "solution_stable": Variable(of_each, every.stable, "-", "of each solution"),
    }


def is_free(bundle: Bundle, scheme: str | None) -> bool:
    """Whether a `bundle`'s units have a pressure each, by its own `scheme` or by this one [-]."""
    return (bundle.scheme if scheme is None else scheme_of(scheme)).independent


def bundle_efficiency(
    bundle: Bundle,
    supply_pressure: float | None,
    paths: Sequence[str],
    forces: list[float] | None,
    strains: list[float] | None,
    resistance: bool,
    scheme: str | None,
) -> tuple[dict[str, Variable], list[Any]]:
    """A bundle's efficiencies, along each path.

    **Arguments:**

    - `bundle`: whose [-].
    - `supply_pressure`: [Pa]; `None` for the bundle's own.
    - `paths`: "isobaric", "isotonic" [-].
    - `forces`: a list [N], or `None`.
    - `strains`: a rising list [-], or `None`.
    - `resistance`: whether units past their own free strain push back [-].
    - `scheme`: by name [-], or `None` for the bundle's own.

    **Returns:** variables by name, and the maps themselves [-].
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
    grids = np.stack([one.efficiency for one in maps])
    reached = np.isfinite(grids)
    counts = reached.sum(axis=(1, 2))
    sums = np.where(reached, grids, 0.0).sum(axis=(1, 2))
    averages = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    dims = ("path", "force", "strain")
    return {
        "path": Variable(("path",), np.asarray(paths), "-", "how the point is reached"),
        "force": Variable(("force",), maps[0].force, "N", "pulling force"),
        "strain": Variable(("strain",), maps[0].strain, "-", "contraction over length at rest"),
        "efficiency": Variable(dims, grids, "-", "work over fluid energy, equation (30)"),
        "state": Variable(dims, np.stack([one.state for one in maps]), "-", "that is best there"),
        "average": Variable(("path",), averages, "-", "over the points reached"),
        "reached": Variable(("path",), counts / grids[0].size, "-", "share of the points"),
    }, maps


def _rising(strains: list[float] | None) -> None:
    if strains is not None and any(b <= a for a, b in itertools.pairwise(strains)):
        raise Refused("--strain", "must rise from each value to the next", None)
