"""Tables of a search for designs: the front, every evaluated design, one design's load cases."""

import numpy as np

from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import OBJECTIVES
from ..design.summary import Summary
from .labelled import Table, Variable, build_table


_INDEX = "index in the space of designs"
_ON_FRONT = "true if no other design is better in all objectives"


def front_variables(result: SearchResult) -> dict[str, Variable]:
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
        for fraction in (0.05, 0.5, 0.95):
            prefix, suffix = f"{100 * fraction:g} % quantile of: ", f"_q{100 * fraction:02.0f}"
            rows += _objectives(spread.quantile(fraction), prefix, suffix)
    return build_table(*rows) | design_variables(result.designs)


def case_variables(summary: Summary) -> Table:
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


def all_design_variables(result: SearchResult) -> Table:
    """Table of all evaluated designs, a row each."""
    front = np.isin(np.arange(len(result.index)), result.front)
    return build_table(
        ("design", "design", result.index, "-", _INDEX),
        *_objectives(result.values),
        ("allowed", "design", result.allowed, "-", "true if it meets all limits"),
        ("front", "design", front, "-", _ON_FRONT),
    )


def design_variables(designs: Designs) -> Table:
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
    rows = []
    for name, column in values.items():
        unit, about = OBJECTIVES[name].unit, f"{prefix}{OBJECTIVES[name].about}"
        rows.append((f"{name}{suffix}", "design", column, unit, about))
    return rows
