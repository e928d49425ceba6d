"""Results as labelled tables for the command line, Python and pages."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bundle import Bundle, recruitment
from ..bundle.energetics import EfficiencyMap
from ..core.types import Values
from ..core.validation import to_si
from ..muscle import Muscle
from .labelled import Table, Variable, build_table


if TYPE_CHECKING:
    from ..control import Cascade, ControlMetrics, JointPressures
    from ..design.designs import Designs
    from ..design.exhaustive_search import SearchResult
    from ..design.summary import Summary
    from ..dynamics import Audit, Plant, Trajectory

_PRESSURE, _STRAIN = "gauge pressure", "contraction over length at rest"
_FORCE, _BLOCKED = "pulling force, equation (27)", "force at rest length"
_FREE = "strain of zero force"
_COLLAPSE = "strain of collapse, inf where the muscle never collapses"
_STABLE = "true where the force falls as the strain rises"
_INDEX = "index in the space of designs"
_ON_FRONT = "true if no other design is better in all objectives"
# terms of the energy ledger, control metrics and stores, each with its meaning
_LEDGER = {
    "supplied": "from the supply", "valve": "lost in valves", "exhaust": "lost in warm exhaust",
    "mixing": "lost in mixing", "wall": "lost through walls", "fluid_work": "on the muscles",
    "mismatch": "error of the volume's integration", "mass": "into the chambers",
    "enthalpy": "into the chambers", "heat": "out through walls",
    "displaced": "absolute, on the muscles", "pull": "on the load",
    "damper": "lost in the damper", "stop": "lost in the stop", "friction": "lost in friction",
    "motor": "of a given motion",
}  # fmt: skip
# of metrics, "output": unit of the controlled output, "force": of its force
_METRICS = (
    ("drawdown", "output", "deepest fall while the demand didn't fall"),
    ("dip", "N", "deepest dip of a unit at the strains of the run"),
    ("rms", "output", "root mean square of the error while the demand was reachable"),
    ("largest_error", "output", "largest error while the demand was reachable"),
    ("lag", "s", "delay at which the output follows best"),
    ("supply_energy", "J", "exergy drawn from the supply"),
    ("fluid", "kg", "drawn from the supply"),
    ("recruited", "-", "number of recruitments of units"),
    ("unreachable", "-", "demands that no policy could reach"),
    ("moments", "-", "demands in all"),
    ("first", "s", "first unreachable demand"),
    ("last", "s", "last unreachable demand"),
    ("short", "force", "largest force or moment that an unreachable demand lacks"),
)
_STORES = {
    "fluid": "exergy of a gas, energy of a liquid", "muscles": "in the muscles",
    "motion": "kinetic", "load": "potential", "stop": "in the stop's springs",
    "friction": "in friction's springs",
}  # fmt: skip
# columns, their fields, units and meanings
_BALANCE = (
    ("balance", "name", "-", "balanced quantity"),
    ("left_over", "residual", "J", "in kg of the fluid's mass"),
    ("left_over_share", "relative_residual", "-", "of the largest term"),
    ("closes_within", "tolerance", "-", "largest share of a balance that closes"),
    ("closes", "closes", "-", "true if the balance closes"),
)
_EVENT = (
    ("event", "name", str, "-", "event in the run"),
    ("event_first", "first", float, "s", "first time"),
    ("event_last", "last", float, "s", "last time"),
    ("event_trusted", "trusted", bool, "-", "true if the run can be trusted all the same"),
)


def muscle_force(muscle: Muscle, pressures: Values, strains: Values) -> Table:
    """A muscle's force and its parts over rows of `pressures` [Pa] and `strains` [-]."""
    P, eps = _si_array(pressures, "pressures", "Pa"), _si_array(strains, "strain", "-")
    response, dims = muscle.response(P[:, None], eps), "pressure strain"
    regions = "0 tension, 1 post-buckling, 2 post-collapse, 3 straight compression"
    return build_table(
        ("pressure", "pressure", P, "Pa", _PRESSURE),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", dims, response.force, "N", _FORCE),
        ("mesh", dims, response.mesh, "N", "the braid's part of the force"),
        ("bladder", dims, response.bladder, "N", "the stretched bladder's part"),
        ("bending", dims, response.bending, "N", "the rest, from the bent bladder"),
        ("region", dims, response.region, "-", regions),
        ("free_strain", "pressure", muscle.free_strain(P), "-", _FREE),
        ("collapse_strain", "pressure", muscle.collapse_strain(P), "-", _COLLAPSE),
    )


def muscle_table(muscle: Muscle, pressures: Values, strains: Values = None) -> Table:
    """A muscle's force, conjugate volume and deflection over rows of `pressures` [Pa] and `strains`
    [-], for programs that interpolate: in a cycle the volume makes no energy with the force.

    `strains`: default: 101 even ones from the table's end to its other.
    """
    P, dims = _si_array(pressures, "pressures", "Pa"), "pressure strain"
    source = muscle.table(max(float(np.max(P)), 1.0))
    eps = np.linspace(*source.strains, 101) if strains is None else strains
    eps = _si_array(eps, "strain", "-")
    error = f"pulling force, within {source.errors[2]:.2g} N of the law"
    points, volume = (P[:, None], eps), "conjugate volume of the fluid, equation (V3)"
    return build_table(
        ("pressure", "pressure", P, "Pa", _PRESSURE),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", dims, source.force(*points), "N", error),
        ("volume", dims, source.conjugate_volume(*points), "m³", volume),
        ("deflection", dims, source.deflection(*points), "m", "of the axis from the line"),
    )


def force_comparison(
    muscles: Mapping[str, Muscle], pressures: Values, strains: Values, chosen_strain: float
) -> Table:
    """Force of several `muscles` over a row of `strains` [-], with each one's blocked force, free
    strain and force at a `chosen_strain` [-]; `pressures`: one for each muscle [Pa].
    """
    P, eps = _si_array(pressures, "pressures", "Pa"), _si_array(strains, "strain", "-")
    pairs = list(zip(muscles.values(), P, strict=True))
    chosen = "force at the chosen strain"
    columns = (
        ("blocked_force", Muscle.blocked_force, "N", _BLOCKED),
        ("free_strain", Muscle.free_strain, "-", _FREE),
        ("collapse_strain", Muscle.collapse_strain, "-", _COLLAPSE),
        ("chosen_strain", lambda *_: chosen_strain, "-", "strain of comparison"),
        ("chosen_force", lambda muscle, P: muscle.force(P, chosen_strain), "N", chosen),
    )
    return build_table(
        ("curve", "curve", list(muscles), "-", "name of the curve"),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "curve strain", [muscle.force(P, eps) for muscle, P in pairs], "N", _FORCE),
        ("pressure", "curve", P, "Pa", _PRESSURE),
        *((name, "curve", [of(*pair) for pair in pairs], *text) for name, of, *text in columns),
    )


def muscle_free_strain(muscle: Muscle, pressures: Values) -> Table:
    """A muscle's free strain, blocked force and collapse over a row of `pressures` [Pa]."""
    P = _si_array(pressures, "pressures", "Pa")
    about = "bending moment at which the bladder collapses"
    return build_table(
        ("pressure", "pressure", P, "Pa", _PRESSURE),
        ("free_strain", "pressure", muscle.free_strain(P), "-", _FREE),
        ("blocked_force", "pressure", muscle.blocked_force(P), "N", _BLOCKED),
        ("collapse_strain", "pressure", muscle.collapse_strain(P), "-", _COLLAPSE),
        ("collapse_moment", "pressure", muscle.collapse_moment(P), "N m", about),
    )


def bundle_force(bundle: Bundle, states: Values, strains: Values, resistance: bool = True) -> Table:
    """Force of a bundle and of its motor units, a state a row, over a row of `strains` [-].

    `states`: rows of pressures [Pa], one for each motor unit; `resistance`: true if units past
    their own free strain push back.
    """
    P, eps = _si_array(states, "states", "Pa"), _si_array(strains, "strain", "-")
    forces = bundle.unit_forces(P[:, None, :], eps, resistance)
    total = forces.sum(axis=-1)
    return build_table(
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "state strain", total, "N", "pulling force of the bundle"),
        ("unit_force", "state strain motor_unit", forces, "N", "of each motor unit"),
    )


def bundle_equilibria(bundle: Bundle, states: Values, resistance: bool = True) -> Table:
    """A bundle's free strain, and all strains of zero force with their stability; NaN beyond a
    state's last one. `states` [Pa] and `resistance` as for `bundle_force`.
    """
    P = _si_array(states, "states", "Pa")
    equilibria = bundle.equilibria(P, resistance)
    size = max(int(equilibria.count.max()), 1)
    strain, stable = equilibria.strain[:, :size], equilibria.stable[:, :size]
    # the first zero of the force is the free strain, by definition
    return build_table(
        ("free_strain", "state", strain[:, 0], "-", "smallest strain of zero force"),
        ("pressures", "state motor_unit", P, "Pa", "of each motor unit"),
        ("equilibria", "state equilibrium", strain, "-", "strains of zero force"),
        ("stable", "state equilibrium", stable, "-", _STABLE),
    )


def space(workspace: recruitment.Workspace) -> Table:
    """A bundle's recruitment states and their overlap, from `fascicle.recruitment.workspace`."""
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
    """States and pressures of a bundle that give a row of `forces` [N] at a row of `strains` [-].

    `solution`: from `fascicle.recruitment.recruit` for each force, down, and strain, across. In the
    table, `solution_pressure` is NaN beyond a demand's last solution.
    """
    F, eps = _si_array(forces, "forces", "N"), _si_array(strains, "strain", "-")
    size = max(int(solution.count.max()), 1)
    pressure, state, stable = (
        getattr(solution.solutions, name)[..., :size] for name in ("pressure", "state", "stable")
    )
    last = solution.unit[..., None] - 1
    throttled = np.take_along_axis(solution.pressures, last, axis=-1)[..., 0]
    status = "0 reached, 1 demand above all reachable forces, 2 below: then the nearest"
    dims = "demand strain solution"
    return build_table(
        ("demand", "demand", F, "N", "demanded force"),
        ("strain", "strain", eps, "-", _STRAIN),
        ("force", "demand strain", solution.force, "N", "pulling force that is reached"),
        ("state", "demand strain", solution.state, "-", "recruitment state, counted from 1"),
        ("throttled_pressure", "demand strain", throttled, "Pa", "of the unit recruited last"),
        ("pressures", "demand strain motor_unit", solution.pressures, "Pa", "of each motor unit"),
        ("status", "demand strain", solution.status, "-", status),
        ("stable", "demand strain", solution.stable, "-", _STABLE),
        ("solutions", "demand strain", solution.count, "-", "number of solutions"),
        ("solution_pressure", dims, pressure, "Pa", "throttled, of each solution"),
        ("solution_state", dims, state, "-", "of each solution, else 0"),
        ("solution_stable", dims, stable, "-", "of each solution"),
    )


def joint_pressures(solution: "JointPressures") -> Table:
    """Pressures of a joint's two sides: `solution` [SI] for a row of demands."""
    status = "0 reached, 1 stiffness too high, 2 too low, 3 torque out of reach: then the nearest"
    return build_table(
        ("agonist", "demand", solution.agonist, "Pa", "gauge pressure of the agonist"),
        ("antagonist", "demand", solution.antagonist, "Pa", "gauge pressure of the antagonist"),
        ("torque", "demand", solution.torque, "N*m", "torque that is reached"),
        ("stiffness", "demand", solution.stiffness, "N*m/rad", "stiffness with open valves"),
        ("status", "demand", solution.status, "-", status),
    )


def efficiency(maps: Sequence[EfficiencyMap]) -> Table:
    """A bundle's efficiencies and their averages over the points that are reached.

    `maps`: from `fascicle.energetics.efficiency_map`, a path each, on one grid.
    """
    grids = np.stack([path.efficiency for path in maps])
    counts = np.isfinite(grids).sum(axis=(1, 2))
    averages = np.where(counts > 0, np.nansum(grids, axis=(1, 2)) / np.maximum(counts, 1), np.nan)
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


def simulated(
    plant: "Plant",
    run: "Trajectory",
    audit: "Audit | None" = None,
    controller: "Cascade | None" = None,
    reference: Any = None,
) -> Table:
    """A `run` of a `plant` in time, a step a row, its events, with an `audit` the remainder of each
    balance, and with a `controller` and its `reference`, the demand at each step [SI], the control
    metrics.
    """
    from ..dynamics import events
    from ..dynamics.outputs import LEDGER, STATUS, STORES

    outputs, unit = run.outputs, plant.load.unit
    bits = ", ".join(f"{1 << index} {name}" for index, name in enumerate(STATUS))
    columns = (
        ("pressure", outputs.pressures, "Pa", "gauge, in each unit's chamber"),
        ("temperature", outputs.temperatures, "K", "in each unit's chamber"),
        ("strain", outputs.strains, "-", "contraction over length at rest"),
        ("force", outputs.forces, "N", "pulling force of the unit's muscles together"),
        ("volume", outputs.volumes, "m³", "of fluid in the unit's muscles, without dead volume"),
        ("fluid_mass", outputs.masses, "kg", "in each unit's chamber"),
        ("supply_opening", outputs.supply, "-", "share of the valve open to the supply"),
        ("exhaust_opening", outputs.exhaust, "-", "share of the valve open to the room"),
        ("drawn", outputs.drawn, "kg/s", "flow from the supply into the chamber"),
        ("vented", outputs.vented, "kg/s", "flow from the chamber to the room"),
    )
    rows: list[tuple] = [
        ("time", "time", run.time, "s", "from the start"),
        ("position", "time", outputs.position, unit, "of the load, rising in contraction"),
        ("velocity", "time", outputs.velocity, f"{unit}/s", "of the load"),
        ("motor_unit", "motor_unit", np.arange(plant.units) + 1, "-", "in the recruitment order"),
        ("bundle", "motor_unit", np.asarray(plant.sides) + 1, "-", "to which the unit belongs"),
        ("muscles", "motor_unit", plant.counts, "-", "in the unit"),
        *(
            (name, "time motor_unit", np.broadcast_to(x, (len(run.time), plant.units)), *texts)
            for name, x, *texts in columns
        ),
        ("supply_pressure", "time", outputs.supply_pressure, "Pa", "gauge"),
        ("valve", "valve", np.arange(run.commands.shape[-1]) + 1, "-", "that has a command"),
        ("command", "time valve", run.commands, "-", "until the next step"),
        ("status", "time", outputs.status, "-", f"sum of the flags {bits}"),
    ]
    if controller is not None:
        rows += _tracking_variables(controller, run, reference)
    for name, energy in zip(LEDGER, np.asarray(run.ledger).T, strict=True):
        about = f"cumulative: {_LEDGER[name]}"
        rows.append((f"account_{name}", "time", energy, "kg" if name == "mass" else "J", about))
    for name, energy in zip(STORES, np.asarray(outputs.store).T, strict=True):
        rows.append((f"stored_{name}", "time", energy, "J", f"stored: {_STORES[name]}"))
    if audit is not None:
        for name, field, *texts in _BALANCE:
            values = [getattr(balance, field) for balance in audit.balances]
            rows.append((name, "balance", values, *texts))
    run_events = events(run)
    for name, field, kind, *texts in _EVENT:
        values = np.array([getattr(event, field) for event in run_events], kind)
        rows.append((name, "event", values, *texts))
    return build_table(*rows)


def policy_table(
    controllers: Mapping[str, "Cascade"],
    metrics: list["ControlMetrics"],
    is_trusted: Sequence[bool],
) -> Table:
    """Control metrics of policies, a row each, with the front of drawdown against supply energy:
    `controllers` by policy, and of each one's run the `metrics` and whether its audit trusts it.
    """
    from ..control import pareto_front

    best = pareto_front([x.drawdown for x in metrics], [x.supply_energy for x in metrics])
    about = "true if no other policy has a smaller drawdown at no more energy, or the reverse"
    return build_table(
        ("policy", "policy", list(controllers), "-", "order of recruitment in time"),
        *_metric_variables(next(iter(controllers.values())), metrics, "policy"),
        ("on_front", "policy", best, "-", about),
        ("trusted", "policy", is_trusted, "-", "true if the audit doubts nothing"),
    )


def _tracking_variables(controller: "Cascade", run: "Trajectory", reference: Any) -> list[tuple]:
    """Demand, output, reach and metrics of a controlled run; the last step's also at the end."""
    from ..control import control_metrics, controlled_output, reachability

    units, reach = _output_units(controller), reachability(controller, run.outputs, reference)
    demand, reachable, lacking = (
        np.append(values, values[-1])
        for values in (np.asarray(reference, float), reach.is_reachable, reach.shortfall)
    )
    output, of = controlled_output(controller, run), controller.of
    return [
        ("demand", "time", demand, units["output"], f"of {of}, until the next step"),
        ("controlled", "time", output, units["output"], f"controlled {of}"),
        ("reachable", "time", reachable, "-", "true if the muscles can reach the demand"),
        ("short", "time", lacking, units["force"], "part of the demand that the muscles lack"),
        *_metric_variables(controller, [control_metrics(controller, run, reference)], ""),
    ]


def _metric_variables(
    controller: "Cascade", metrics: list["ControlMetrics"], dims: str
) -> list[tuple]:
    """Control metrics of one run, or of several along the dimension `dims`."""
    rows, units = [], _output_units(controller)
    for name, unit, about in _METRICS:
        values = [getattr(run, name) for run in metrics]
        values = values if dims else values[0]
        rows.append((f"control_{name}", dims, values, units.get(unit, unit), about))
    return rows


def _output_units(controller: "Cascade") -> dict[str, str]:
    """Units of a `_METRICS`' "output" and "force"."""
    unit = controller.plant.load.unit
    force = "N·m" if unit == "rad" else "N"
    return {"output": unit if controller.of == "position" else force, "force": force}


def front_variables(result: "SearchResult") -> dict[str, Variable]:
    """Variables of the designs on the front: objectives, also under scatter, composition, sizes."""
    indices = result.front
    recommended = np.arange(len(indices)) == result.recommended
    about = "cheapest, without prices the best compromise, of the front"
    rows: list[tuple] = [
        ("design", "design", result.index[indices], "-", _INDEX),
        *_objectives({name: values[indices] for name, values in result.values.items()}),
        ("recommended", "design", recommended, "-", about),
        ("front", "design", np.ones(len(indices), bool), "-", _ON_FRONT),
    ]
    prices = result.catalog.price(result.designs)
    if not np.all(np.isnan(prices)):
        about = f"of muscles and valves, in {result.catalog.currency}"
        rows.append(("price", "design", prices, "-", about))
    if result.safety is not None:
        spread, about = result.safety.spread, "share of draws that meet the task and all limits"
        rows.append(("probability", "design", spread.probability, "-", about))
        for percent in (5, 50, 95):
            texts = f"{percent} % quantile of: ", f"_q{percent:02}"
            rows += _objectives(spread.quantile(percent / 100), *texts)
    return build_table(*rows) | design_variables(result.designs)


def case_variables(summary: "Summary") -> Table:
    """Table of one design's load cases, a case a row, its mass and diameter."""
    cases, task, fluid = summary.cases, summary.cases.task, summary.cases.task.fluid
    kind = "normal volume at 20 °C and 100 kPa (ISO 8778)" if fluid == "air" else "volume"
    mass, diameter = (np.nan if x is None else x for x in (summary.mass, summary.diameter))
    spare = "spare force, negative for a case that isn't reached"
    return build_table(
        ("case", "case", np.arange(1, len(task) + 1), "-", "load case, as in the task"),
        ("case_force", "case", task.force, "N", "demanded"),
        ("case_stroke", "case", task.stroke_of(cases.length), "m", "demanded"),
        ("case_strain", "case", task.strain_of(cases.length), "-", "demanded of this design"),
        ("case_largest_force", "case", cases.largest, "N", "largest force at this strain"),
        ("case_spare", "case", cases.spare, "N", spare),
        ("case_reached", "case", cases.reached, "-", "true if the case is reached"),
        ("case_state", "case", cases.state, "-", "recruitment state that meets it, 0 for none"),
        ("case_fluid", "case", cases.fluid, "m³", f"{fluid} from rest to it and back, {kind}"),
        ("fluid_of_a_cycle", "", cases.fluid_of_a_cycle, "m³", f"{fluid}, {kind}"),
        ("mass", "", mass, "kg", "as in the report, NaN if unknown"),
        ("outer_diameter", "", diameter, "m", "at the largest contraction"),
    )


def all_design_variables(result: "SearchResult") -> Table:
    """Table of all evaluated designs, a row each."""
    front = np.isin(np.arange(len(result.index)), result.front)
    return build_table(
        ("design", "design", result.index, "-", _INDEX),
        *_objectives(result.values),
        ("allowed", "design", result.allowed, "-", "true if it meets all limits"),
        ("front", "design", front, "-", _ON_FRONT),
    )


def design_variables(designs: "Designs") -> Table:
    """Table of composition and sizes, a design a row."""
    drawings = np.array(list(designs.drawings), object)[designs.kind]
    sizes = (designs.radius, designs.wall, designs.angle)
    radius, wall, angle = (np.where(designs.counts == 0, np.nan, size) for size in sizes)
    unit, about_sizes = np.arange(1, designs.counts.shape[1] + 1), "of the unit's muscles at rest"
    return build_table(
        ("unit", "unit", unit, "-", "motor unit, in the order of recruitment"),
        ("composition", "design", np.array(designs.labels, object), "-"),
        ("drawing", "design", drawings, "-", "muscle that gives material and laws"),
        ("count", "design unit", designs.counts, "-", "muscles in the unit"),
        ("length", "design", designs.length, "m", "of the muscles at rest"),
        ("outer_radius", "design unit", radius, "m", about_sizes),
        ("wall_thickness", "design unit", wall, "m", about_sizes),
        ("braid_angle", "design unit", angle, "rad", "from the axis, at rest"),
    )


def _objectives(values: dict[str, np.ndarray], prefix: str = "", suffix: str = "") -> list[tuple]:
    """Rows for `build_table`, one for each objective."""
    from ..design.objectives import OBJECTIVES

    rows = []
    for name, column in values.items():
        unit, about = OBJECTIVES[name].unit, f"{prefix}{OBJECTIVES[name].about}"
        rows.append((f"{name}{suffix}", "design", column, unit, about))
    return rows


def _si_array(values: Values, name: str, unit: str) -> np.ndarray:
    return np.asarray(to_si(values, name, unit))
