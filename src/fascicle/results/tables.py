"""Results as labelled tables: what the command line prints, and Python and pages show alike.

A `Table` holds variables by name, each with its dimensions, unit and meaning; it leaves as an
`xarray.Dataset`, as CSV or JSON, or as a file of any of these.
"""

from collections.abc import Sequence

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.efficiency import EfficiencyMap
from ..core.types import Values
from ..core.validation import to_si
from ..muscle import Muscle
from .labelled import Table, Variable
from .run_tables import simulated as simulated  # noqa: PLC0414 a table as the others are


def muscle_force(muscle: Muscle, pressures: Values, strains: Values) -> Table:
    """A muscle's force and what makes it up.

    **Arguments:**

    - `muscle`: whose [-].
    - `pressures`: a row of them [Pa].
    - `strains`: a row of them [-].

    **Returns:** a table [-], in the order of the JSON.
    """
    P, eps = _row(pressures, "pressures", "Pa"), _row(strains, "strain", "-")
    found = muscle.response(P[:, None], eps)
    free, collapse = muscle.free_strain(P), muscle.collapse_strain(P)
    regions = "0 tension, 1 post-buckling, 2 post-collapse, 3 straight compression"
    dims = ("pressure", "strain")
    return Table(
        {
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
    )


def muscle_free_strain(muscle: Muscle, pressures: Values) -> Table:
    """A muscle's free strain, blocked force and collapse.

    **Arguments:**

    - `muscle`: whose [-].
    - `pressures`: a row of them [Pa].

    **Returns:** a table [-].
    """
    P = _row(pressures, "pressures", "Pa")
    return Table(
        {
            "pressure": Variable(("pressure",), P, "Pa", "gauge pressure"),
            "free_strain": Variable(
                ("pressure",), muscle.free_strain(P), "-", "strain of zero force"
            ),
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
    )


def bundle_force(bundle: Bundle, states: Values, strains: Values, resistance: bool = True) -> Table:
    """A bundle's force, and that of its motor units.

    **Arguments:**

    - `bundle`: whose [-].
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `strains`: a row of them [-].
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** a table [-].
    """
    P, eps = _row(states, "states", "Pa"), _row(strains, "strain", "-")
    forces = bundle.unit_forces(P[:, None, :], eps, resistance)
    dims = ("state", "strain")
    return Table(
        {
            "strain": Variable(("strain",), eps, "-", "contraction over length at rest"),
            "force": Variable(dims, forces.sum(axis=-1), "N", "pulling force of the bundle"),
            "unit_force": Variable((*dims, "motor_unit"), forces, "N", "of each motor unit"),
        }
    )


def bundle_equilibria(bundle: Bundle, states: Values, resistance: bool = True) -> Table:
    """A bundle's free strain, and all strains of zero force with their stability.

    **Arguments:**

    - `bundle`: whose [-].
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** a table [-]; `equilibria` is NaN where there are fewer.
    """
    P = _row(states, "states", "Pa")
    found = bundle.equilibria(P, resistance)
    most = max(int(found.count.max()), 1)
    dims = ("state", "equilibrium")
    return Table(
        {
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
    )


def space(found: recruitment.Space) -> Table:
    """A bundle's recruitment states and their overlap.

    **Arguments:** `found`: by `fascicle.recruitment.space` [-].

    **Returns:** a table [-].
    """
    overlap = recruitment.overlap(found)
    pairs = np.asarray(overlap.states, dtype=int).reshape(-1, 2)
    edge, shared = ("state", "strain"), ("pair", "strain")
    curves = ("state", "level", "strain")
    return Table(
        {
            "level": Variable(("level",), found.level, "Pa", "throttled pressure"),
            "strain": Variable(("strain",), found.strain, "-", "contraction over length at rest"),
            "force": Variable(curves, found.force, "N", "of each state at each throttled pressure"),
            "low": Variable(edge, found.low, "N", "least force of each state"),
            "high": Variable(edge, found.high, "N", "largest force of each state"),
            "overlap_states": Variable(("pair", "one_of_pair"), pairs, "-", "states that overlap"),
            "overlap_low": Variable(shared, overlap.low, "N", "lower edge of the overlap"),
            "overlap_high": Variable(shared, overlap.high, "N", "upper edge of the overlap"),
            "overlap_area": Variable(("pair",), overlap.area, "N", "force times strain"),
            "supply_pressure": Variable(
                (), np.asarray(found.supply_pressure), "Pa", "the supply's"
            ),
            "scheme": Variable((), np.asarray(found.scheme), "-", "of recruitment"),
        }
    )


def recruited(found: recruitment.RecruitmentResult, forces: Values, strains: Values) -> Table:
    """The states and pressures of a bundle that give forces at strains.

    **Arguments:**

    - `found`: by `fascicle.recruitment.recruit` for each force, down, and strain, across [-].
    - `forces`: those that were demanded, a row of them [N].
    - `strains`: at which, a row of them [-].

    **Returns:** a table [-]; `solution_pressure` is NaN where there are fewer.
    """
    F, eps = _row(forces, "forces", "N"), _row(strains, "strain", "-")
    most = max(int(found.count.max()), 1)
    every = recruitment.Solutions(*(each[..., :most] for each in found.solutions))
    throttled = np.take_along_axis(found.pressures, found.unit[..., None] - 1, axis=-1)[..., 0]
    dims = ("demand", "strain")
    of_each, of_unit = (*dims, "solution"), (*dims, "motor_unit")
    reached = "0 reached, 1 demand above what is reachable, 2 below: then the nearest"
    return Table(
        {
            "demand": Variable(("demand",), F, "N", "demanded force"),
            "strain": Variable(("strain",), eps, "-", "contraction over length at rest"),
            "force": Variable(dims, found.force, "N", "pulling force that is reached"),
            "state": Variable(dims, found.state, "-", "recruitment state, counted from 1"),
            "throttled_pressure": Variable(dims, throttled, "Pa", "of the unit recruited last"),
            "pressures": Variable(of_unit, found.pressures, "Pa", "of each motor unit"),
            "status": Variable(dims, found.status, "-", reached),
            "stable": Variable(
                dims, found.stable, "-", "whether the force falls with strain there"
            ),
            "solutions": Variable(dims, found.count, "-", "how many there are"),
            "solution_pressure": Variable(
                of_each, every.pressure, "Pa", "throttled, of each solution"
            ),
            "solution_state": Variable(of_each, every.state, "-", "of each solution, else 0"),
            "solution_stable": Variable(of_each, every.stable, "-", "of each solution"),
        }
    )


def efficiency(maps: Sequence[EfficiencyMap]) -> Table:
    """A bundle's efficiencies, along each path.

    **Arguments:** `maps`: by `fascicle.energetics.efficiency_map`, a path each, of one grid [-].

    **Returns:** a table [-], with the average over the points that are reached.
    """
    grids = np.stack([one.efficiency for one in maps])
    reached = np.isfinite(grids)
    counts = reached.sum(axis=(1, 2))
    sums = np.where(reached, grids, 0.0).sum(axis=(1, 2))
    averages = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    dims = ("path", "force", "strain")
    return Table(
        {
            "path": Variable(
                ("path",), np.asarray([one.path for one in maps]), "-", "how the point is reached"
            ),
            "force": Variable(("force",), maps[0].force, "N", "pulling force"),
            "strain": Variable(("strain",), maps[0].strain, "-", "contraction over length at rest"),
            "efficiency": Variable(dims, grids, "-", "work over fluid energy, equation (30)"),
            "state": Variable(
                dims, np.stack([one.state for one in maps]), "-", "that is best there"
            ),
            "average": Variable(("path",), averages, "-", "over the points reached"),
            "reached": Variable(("path",), counts / grids[0].size, "-", "share of the points"),
        }
    )


def _row(values: Values, name: str, unit: str) -> np.ndarray:
    """An array [SI] of `values` [SI], or of text and quantities with units."""
    return np.asarray(to_si(values, name, unit))
