"""Tables of a search for designs: the front, every evaluated design, one design's load cases."""

from typing import Any

import numpy as np

from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import OBJECTIVES
from ..design.robust import Spread
from ..design.summary import Summary
from .labelled import Variable


def front_variables(found: SearchResult, sure: Spread | None = None) -> dict[str, Variable]:
    """Front of a search, a design a row, and the recommended design if it isn't on the front.

    `sure`: the designs' robustness, or `None`. Objectives come first, then composition and sizes.
    """
    indices = found.reported
    recommended = np.zeros(len(indices), bool)
    if found.recommended is not None:
        recommended[found.recommended] = True
    on_front = np.arange(len(indices)) < len(found.front)
    about = "cheapest of the designs that do the task within the limits"
    return {
        "design": Variable(("design",), found.index[indices], "-", "index in the space of designs"),
        **_objectives({name: values[indices] for name, values in found.values.items()}),
        "recommended": Variable(("design",), recommended, "-", about),
        "front": Variable(("design",), on_front, "-", "whether no other betters it"),
        **_prices(found),
        **({} if sure is None else _sure(sure)),
        **design_variables(found.designs),
    }


def case_variables(summary: Summary) -> dict[str, Variable]:
    """Performance of one design at each load case, a case a row, its mass and diameter."""
    cases = summary.cases
    task, fluid = cases.task, cases.task.fluid
    kind = "normal volume at 20 °C and 100 kPa (ISO 8778)" if fluid == "air" else "volume"

    def each(values: Any, unit: str, about: str) -> Variable:
        return Variable(("case",), np.asarray(values), unit, about)

    def one(value: Any, unit: str, about: str) -> Variable:
        return Variable((), np.asarray(np.nan if value is None else value), unit, about)

    return {
        "case": each(np.arange(1, len(task) + 1), "-", "load case, as in the task"),
        "case_force": each(task.force, "N", "demanded"),
        "case_stroke": each(task.stroke_of(cases.length), "m", "demanded"),
        "case_strain": each(task.strain_of(cases.length), "-", "demanded of this design"),
        "case_largest_force": each(cases.largest, "N", "that the design gives there"),
        "case_spare": each(cases.spare, "N", "force to spare, negative where it isn't reached"),
        "case_reached": each(cases.reached, "-", "whether it is reached"),
        "case_state": each(cases.state + 1, "-", "recruitment state that meets it"),
        "case_fluid": each(cases.fluid, "m³", f"{fluid} from rest to it and back, {kind}"),
        "fluid_of_a_cycle": one(cases.fluid_of_a_cycle, "m³", f"{fluid}, {kind}"),
        "mass": one(summary.mass, "kg", "as the report says, NaN if not known"),
        "outer_diameter": one(summary.diameter, "m", "at the largest contraction"),
    }


def every_variables(found: SearchResult) -> dict[str, Variable]:
    """All evaluated designs, a row each, by index."""
    front = np.zeros(len(found.index), bool)
    front[found.front] = True
    return {
        "design": Variable(("design",), found.index, "-", "index in the space of designs"),
        **_objectives(found.values),
        "allowed": Variable(("design",), found.allowed, "-", "whether it keeps all limits"),
        "front": Variable(("design",), front, "-", "whether no other betters it"),
    }


def design_variables(designs: Designs) -> dict[str, Variable]:
    """Composition and sizes, a design a row."""
    names = list(designs.drawings)
    gone = designs.counts == 0

    def sizes(values: np.ndarray) -> np.ndarray:
        return np.where(gone, np.nan, values)

    def by_unit(values: Any, unit: str, about: str) -> Variable:
        return Variable(("design", "unit"), values, unit, about)

    unit = np.arange(1, designs.counts.shape[1] + 1)
    return {
        "unit": Variable(("unit",), unit, "-", "motor unit, in the order of recruitment"),
        "composition": Variable(("design",), np.array(designs.labels, object), "-"),
        "drawing": Variable(
            ("design",), np.array([names[i] for i in designs.kind], object), "-",
            "muscle whose material and laws are taken",
        ),
        "count": by_unit(designs.counts, "-", "muscles in the unit"),
        "length": Variable(("design",), designs.length, "m", "of the muscles at rest"),
        "outer_radius": by_unit(sizes(designs.radius), "m", "of the unit's muscles at rest"),
        "wall_thickness": by_unit(sizes(designs.wall), "m", "of the unit's muscles at rest"),
        "braid_angle": by_unit(sizes(designs.angle), "rad", "from the axis, at rest"),
    }  # fmt: skip


def _prices(found: SearchResult) -> dict[str, Variable]:
    prices = found.catalog.price(found.designs)
    if np.all(np.isnan(prices)):
        return {}
    about = f"of muscles and valves, in {found.catalog.currency}"
    return {"price": Variable(("design",), prices, "-", about)}


def _sure(sure: Spread) -> dict[str, Variable]:
    about = "share of draws that meet the task and all limits"
    told = {"probability": Variable(("design",), sure.probability, "-", about)}
    for share in (0.05, 0.5, 0.95):
        for name, one in sure.quantile(share).items():
            key = f"{name}_q{100 * share:02.0f}"
            words = f"{100 * share:g} % quantile of: {OBJECTIVES[name].about}"
            told[key] = Variable(("design",), one, OBJECTIVES[name].unit, words)
    return told


def _objectives(values: dict[str, np.ndarray]) -> dict[str, Variable]:
    return {
        name: Variable(("design",), one, OBJECTIVES[name].unit, OBJECTIVES[name].about)
        for name, one in values.items()
    }
