"""Results as labelled tables for the command line, Python and pages alike.

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
from .labelled import Table, build_table
from .run_tables import simulated as simulated  # noqa: PLC0414 public here, as the others


_PRESSURE, _STRAIN = "gauge pressure", "contraction over length at rest"
_COLLAPSE = "strain of collapse, inf where the muscle never collapses"
_STABLE = "true where the force falls as the strain rises"


def muscle_force(muscle: Muscle, pressures: Values, strains: Values) -> Table:
    """A muscle's force and its parts.

    **Arguments:**

    - `muscle`: the muscle.
    - `pressures`: a row of them [Pa].
    - `strains`: a row of them [-].

    **Returns:** a table, in the order of the JSON.
    """
    P, eps = _row(pressures, "pressures", "Pa"), _row(strains, "strain", "-")
    response = muscle.response(P[:, None], eps)
    regions = "0 tension, 1 post-buckling, 2 post-collapse, 3 straight compression"
    return build_table(
        ("pressure", "pressure", P, "Pa", _PRESSURE),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "pressure strain", response.force, "N", "pulling force, equation (27)"),
        ("mesh", "pressure strain", response.mesh, "N", "the braid's part of the force"),
        ("bladder", "pressure strain", response.bladder, "N", "the stretched bladder's part"),
        ("bending", "pressure strain", response.bending, "N", "the rest, from the bent bladder"),
        ("region", "pressure strain", response.region, "-", regions),
        ("free_strain", "pressure", muscle.free_strain(P), "-", "strain of zero force"),
        ("collapse_strain", "pressure", muscle.collapse_strain(P), "-", _COLLAPSE),
    )


def muscle_free_strain(muscle: Muscle, pressures: Values) -> Table:
    """A muscle's free strain, blocked force and collapse.

    **Arguments:**

    - `muscle`: the muscle.
    - `pressures`: a row of them [Pa].

    **Returns:** a table, a pressure a row.
    """
    P = _row(pressures, "pressures", "Pa")
    about = "bending moment at which the bladder collapses"
    return build_table(
        ("pressure", "pressure", P, "Pa", _PRESSURE),
        ("free_strain", "pressure", muscle.free_strain(P), "-", "strain of zero force"),
        ("blocked_force", "pressure", muscle.blocked_force(P), "N", "force at rest length"),
        ("collapse_strain", "pressure", muscle.collapse_strain(P), "-", _COLLAPSE),
        ("collapse_moment", "pressure", muscle.collapse_moment(P), "N m", about),
    )


def bundle_force(bundle: Bundle, states: Values, strains: Values, resistance: bool = True) -> Table:
    """A bundle's force, and that of its motor units.

    **Arguments:**

    - `bundle`: the bundle.
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `strains`: a row of them [-].
    - `resistance`: true if units past their own free strain push back.

    **Returns:** a table, a state a row.
    """
    P, eps = _row(states, "states", "Pa"), _row(strains, "strain", "-")
    forces = bundle.unit_forces(P[:, None, :], eps, resistance)
    total = forces.sum(axis=-1)
    return build_table(
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "state strain", total, "N", "pulling force of the bundle"),
        ("unit_force", "state strain motor_unit", forces, "N", "of each motor unit"),
    )


def bundle_equilibria(bundle: Bundle, states: Values, resistance: bool = True) -> Table:
    """A bundle's free strain, and all strains of zero force with their stability.

    **Arguments:**

    - `bundle`: the bundle.
    - `states`: pressures [Pa], one for each motor unit in each state.
    - `resistance`: true if units past their own free strain push back.

    **Returns:** a table; `equilibria` is NaN beyond a state's last one.
    """
    P = _row(states, "states", "Pa")
    equilibria = bundle.equilibria(P, resistance)
    size = max(int(equilibria.count.max()), 1)
    # the first zero of the force is the free strain, by definition
    free = equilibria.strain[:, 0]
    return build_table(
        ("free_strain", "state", free, "-", "smallest strain of zero force"),
        ("pressures", "state motor_unit", P, "Pa", "of each motor unit"),
        (
            "equilibria",
            "state equilibrium",
            equilibria.strain[:, :size],
            "-",
            "strains of zero force",
        ),
        ("stable", "state equilibrium", equilibria.stable[:, :size], "-", _STABLE),
    )


def space(workspace: recruitment.Space) -> Table:
    """A bundle's recruitment states and their overlap.

    **Arguments:** `workspace`: from `fascicle.recruitment.space`.

    **Returns:** a table, a state a row.
    """
    overlap = recruitment.overlap(workspace)
    pairs = np.asarray(overlap.states, dtype=int).reshape(-1, 2)
    about = "of each state at each throttled pressure"
    return build_table(
        ("level", "level", workspace.level, "Pa", "throttled pressure"),
        ("strain", "strain", workspace.strain, "-", _STRAIN),
        ("force", "state level strain", workspace.force, "N", about),
        ("low", "state strain", workspace.low, "N", "least force of each state"),
        ("high", "state strain", workspace.high, "N", "largest force of each state"),
        ("overlap_states", "pair one_of_pair", pairs, "-", "states that overlap"),
        ("overlap_low", "pair strain", overlap.low, "N", "lower edge of the overlap"),
        ("overlap_high", "pair strain", overlap.high, "N", "upper edge of the overlap"),
        ("overlap_area", "pair", overlap.area, "N", "force times strain"),
        ("supply_pressure", "", workspace.supply_pressure, "Pa", "of the supply"),
        ("scheme", "", workspace.scheme, "-", "of recruitment"),
    )


def recruited(solution: recruitment.RecruitmentResult, forces: Values, strains: Values) -> Table:
    """States and pressures of a bundle that give demanded forces at strains.

    **Arguments:**

    - `solution`: from `fascicle.recruitment.recruit` for each force, down, and strain, across.
    - `forces`: a row of demanded forces [N].
    - `strains`: a row of strains [-].

    **Returns:** a table; `solution_pressure` is NaN beyond a demand's last solution.
    """
    F, eps = _row(forces, "forces", "N"), _row(strains, "strain", "-")
    size = max(int(solution.count.max()), 1)
    pressure, state, stable = (
        getattr(solution.solutions, name)[..., :size] for name in ("pressure", "state", "stable")
    )
    throttled = np.take_along_axis(solution.pressures, solution.unit[..., None] - 1, axis=-1)
    status = "0 reached, 1 demand above what is reachable, 2 below: then the nearest"
    return build_table(
        ("demand", "demand", F, "N", "demanded force"),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "demand strain", solution.force, "N", "pulling force that is reached"),
        ("state", "demand strain", solution.state, "-", "recruitment state, counted from 1"),
        (
            "throttled_pressure",
            "demand strain",
            throttled[..., 0],
            "Pa",
            "of the unit recruited last",
        ),
        ("pressures", "demand strain motor_unit", solution.pressures, "Pa", "of each motor unit"),
        ("status", "demand strain", solution.status, "-", status),
        ("stable", "demand strain", solution.stable, "-", _STABLE),
        ("solutions", "demand strain", solution.count, "-", "number of solutions"),
        (
            "solution_pressure",
            "demand strain solution",
            pressure,
            "Pa",
            "throttled, of each solution",
        ),
        ("solution_state", "demand strain solution", state, "-", "of each solution, else 0"),
        ("solution_stable", "demand strain solution", stable, "-", "of each solution"),
    )


def efficiency(maps: Sequence[EfficiencyMap]) -> Table:
    """A bundle's efficiencies, along each path.

    **Arguments:** `maps`: from `fascicle.energetics.efficiency_map`, a path each, on one grid.

    **Returns:** a table, with the average over the points that are reached.
    """
    grids = np.stack([path.efficiency for path in maps])
    reached = np.isfinite(grids)
    counts = reached.sum(axis=(1, 2))
    sums = np.where(reached, grids, 0.0).sum(axis=(1, 2))
    averages = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    states = np.stack([path.state for path in maps])
    return build_table(
        ("path", "path", [path.path for path in maps], "-", "how the point is reached"),
        ("force", "force", maps[0].force, "N", "pulling force"),
        ("strain", "strain", maps[0].strain, "-", _STRAIN),
        ("efficiency", "path force strain", grids, "-", "work over fluid energy, equation (30)"),
        ("state", "path force strain", states, "-", "state of the highest efficiency"),
        ("average", "path", averages, "-", "over the points reached"),
        ("reached", "path", counts / grids[0].size, "-", "share of the points"),
    )


def _row(values: Values, name: str, unit: str) -> np.ndarray:
    """An array [SI] of values [SI], or of text and quantities with units."""
    return np.asarray(to_si(values, name, unit))
