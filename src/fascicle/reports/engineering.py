"""What an engineer asks of a design first, in words: does it do the task, with how much to spare,
how large is it, how heavy, what does it take and cost. The console and the page say the same.
"""

import numpy as np

from ..design.catalog import describe_cheapest
from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import BY_WEIGHT, OBJECTIVES, Limit, allowed_miss_fraction
from ..design.summary import STANDARD_GRAVITY, Summary
from ..units import figures, pretty


HEADS = ("case", "force", "stroke", "contraction", "gives up to", "to spare", "")
REACHED, MISSED = "reached", "MISSED"
_FORMATS = {"m": "length", "N": "force", "J": "energy"}
_LITER = 1e-3  # m³


def shown(name: str, value: float) -> str:
    """An objective's `value` [SI] for a reader; `name` [-]."""
    unit = OBJECTIVES[name].unit
    if unit in _FORMATS:
        return pretty(value, _FORMATS[unit])
    return figures(value)


def words(name: str) -> str:
    """An objective's `name` [-] as words."""
    return name.replace("_", " ")


def sizes(found: SearchResult, designs: Designs, place: int) -> str:
    """A design's muscles in a line.

    **Arguments:**

    - `found`: by a search [-].
    - `designs`: some of the search's [-].
    - `place`: which of them [-].

    **Returns:** the line [-].
    """
    there = designs.counts[place] > 0
    radii = dict.fromkeys(figures(1e3 * r) for r in designs.radius[place][there])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[place][there])
    angle = np.degrees(designs.angle[place, 0])
    text = (
        f"L₀ {pretty(designs.length[place], 'length')}, r₀ {', '.join(radii)} mm,"
        f" t₀ {', '.join(walls)} mm, α₀ {angle:.3g}°"
    )
    names = list(designs.drawings)
    name = names[designs.kind[place]]
    if name in found.catalog.products:
        return f"{found.catalog.products[name].name}, {text}"
    return text if len(names) == 1 else f"{text}, {name}"


def demand(found: SearchResult) -> str:
    """What a design must do, in words; `found` [-] by a search."""
    share = allowed_miss_fraction(found.limits)
    if share <= 0:
        return "reach every load case"
    return f"miss no more than {100 * share:.4g} % of the load cases, by number and by weight"


def headline(found: SearchResult, summary: Summary) -> list[str]:
    """What is recommended, with which margin, and why.

    **Arguments:**

    - `found`: by a search that found a design [-].
    - `summary`: of the cheapest [-].

    **Returns:** sentences [-].
    """
    place = found.recommended
    assert place is not None
    first = f"Take {called(summary)}, {sizes(found, found.designs, place)}."
    margin = f"margin: {_margin(summary)}."
    many, every = int(found.allowed.sum()), found.judged == len(found.index)
    if many == 1 and every:
        return [
            first,
            margin,
            f"It is the only one of {found.judged} designs that can {demand(found)} within all"
            " limits.",
        ]
    which = f"the {many} designs" if every else f"those of {found.judged} judged designs"
    return [
        first,
        margin,
        f"It is the cheapest of {which} that {demand(found)}, and keep all limits;"
        f" cheapest: {describe_cheapest(found.catalog, found.space.drawings)}.",
    ]


def margin_warning(found: SearchResult, summary: Summary) -> str:
    """What to say of a recommended design whose margin is small.

    **Arguments:**

    - `found`: by a search that found a design [-].
    - `summary`: of the cheapest [-].

    **Returns:** sentences, or none where the margin is large enough [-].
    """
    if Limit(least=found.least_margin).holds(summary.relative_margin):
        return ""
    i, least = _closest(summary), _percent(found.least_margin)
    force, largest = (
        pretty(x[i], "force") for x in (summary.cases.task.force, summary.cases.largest)
    )
    text = (
        f"the margin is {_percent(summary.relative_margin)}: case {i + 1} asks for {force}, where"
        f" this bundle is computed to give {largest}. That is below {least} ([limits] margin)."
        " Computed forces can be off by tens of percent, and by more where the braid angle is a"
        " degree off, so it may not do the task."
    )
    if (place := found.cheapest_with_margin) is None:
        return f"{text} No design of this search has {least}: look for larger or more muscles."
    better = found.all_designs(np.array([place]))
    return (
        f"{text} The cheapest design that has {least} is {better.labels[0]},"
        f' {sizes(found, better, 0)}: relative_margin = {{ at_least = "{least}" }} in [limits]'
        " takes it."
    )


def called(summary: Summary) -> str:
    """A design's composition in words; `summary` [-] of it."""
    many = "muscle" if summary.muscles == 1 else "muscles"
    units = "motor unit" if summary.valves == 1 else "motor units"
    split = "" if summary.valves == 1 else f" ({summary.label})"
    return f"{summary.muscles} {many} in {summary.valves} {units}{split}"


def case_rows(summary: Summary, most: int) -> tuple[list[list[str]], str]:
    """A row for each load case, as of `HEADS`.

    **Arguments:**

    - `summary`: of a design [-].
    - `most`: how many rows [-]; of more, those with least to spare are taken.

    **Returns:** the rows, and what was left out of them, in words [-].
    """
    cases = summary.cases
    task = cases.task
    places = np.arange(len(task))
    if len(task) > most:
        places = np.sort(np.argsort(cases.relative)[:most])
    strain, stroke = task.strain_of(cases.length), task.stroke_of(cases.length)
    rows = [
        [
            str(i + 1),
            pretty(task.force[i], "force"),
            pretty(stroke[i], "length"),
            f"{100 * strain[i]:.3g} %",
            pretty(cases.largest[i], "force"),
            pretty(cases.spare[i], "force"),
            REACHED if cases.reached[i] else MISSED,
        ]
        for i in places.tolist()
    ]
    missed = int(np.sum(~cases.reached))
    left = "" if len(task) <= most else f"the {most} of {len(task)} with least to spare; "
    return rows, f"{left}{len(task) - missed} of {len(task)} reached"


def facts(found: SearchResult, summary: Summary) -> dict[str, str]:
    """What there is to know of a design besides its load cases.

    **Arguments:**

    - `found`: by a search [-].
    - `summary`: of one of its designs [-].

    **Returns:** sentences by what they are about [-].
    """
    cases = summary.cases
    stroke = cases.task.stroke_of(cases.length)
    told = {
        "stroke": f"{pretty(stroke.max(), 'length')} of {pretty(cases.length, 'length')} at rest",
        "mass": _mass(summary, found.catalog.density),
        cases.task.fluid: _fluid(summary),
        f"cost of {cases.task.fluid}": _cost(found, summary),
        "price": _price(found, summary),
        "outer diameter": f"{pretty(summary.diameter_at_rest, 'length')} at rest,"
        f" {pretty(summary.diameter, 'length')} at the largest contraction"
        + (" with unfed units bowed out" if summary.valves > 1 else ""),
        "valves": f"{summary.valves}, one for each motor unit",
    }
    if (product := summary.product) is not None:
        source = f"; figures: {product.source}" if product.source else ""
        told["product"] = (
            f"{summary.muscles} × {product.name}, {pretty(cases.length, 'length')}{source}"
        )
    share = allowed_miss_fraction(found.limits)
    missed = int(np.sum(~cases.reached))
    if share > 0 and missed:
        weight = float(np.average(~cases.reached, weights=cases.task.weight))
        told["missed"] = (
            f"{missed} of {len(cases.task)} load cases, {100 * weight:.3g} % by weight; the task"
            f" file lets {100 * found.limits[BY_WEIGHT].most:.4g} % go"
        )
    return told


def _closest(summary: Summary) -> int:
    """The load case, of those that are reached, with the least to spare of what it asks for."""
    cases = summary.cases
    return int(np.argmin(np.where(cases.reached, cases.relative, np.inf)))


def _margin(summary: Summary) -> str:
    cases = summary.cases
    if not cases.reached.all():
        short = pretty(-float(cases.spare[cases.worst]), "force")
        return f"none: case {cases.worst + 1} misses {short}"
    i = _closest(summary)
    spare, largest = float(cases.spare[i]), float(cases.largest[i])
    text = (
        f"{_percent(summary.relative_margin)}, {pretty(spare, 'force')} to spare at case {i + 1},"
        f" which could lift {pretty(largest, 'force')},"
        f" {pretty(spare / STANDARD_GRAVITY, 'mass', 3)} more"
    )
    if cases.tightest != i:
        least = pretty(float(cases.spare[cases.tightest]), "force")
        text += f"; the fewest newtons are {least}, at case {cases.tightest + 1}"
    if np.isfinite(summary.load_factor):
        text += (
            f"; all loads could be {figures(np.floor(1e3 * summary.load_factor) / 1e3)} times as"
            " large"
        )
    return text


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _mass(summary: Summary, density: float | None) -> str:
    product = summary.product
    if product is not None and product.mass is not None and summary.mass is not None:
        return f"{pretty(summary.mass, 'mass', 3)} of muscles, by the catalog"
    rubber = f"{figures(1e6 * summary.bladders, 3)} cm³ of bladder"
    if summary.mass is None:
        return f'not known: {rubber}, no density given ([design] density = "… kg/m^3")'
    return (
        f"{pretty(summary.mass, 'mass', 3)} of bladders ({rubber} at {density:g} kg/m³), without"
        " braid and fittings"
    )


def _fluid(summary: Summary) -> str:
    cases = summary.cases
    one, largest = cases.fluid_of_a_cycle / _LITER, float(cases.fluid.max()) / _LITER
    if cases.task.time is not None:
        cycle = "a cycle, once through all load cases and back to the first"
    else:
        cycle = (
            "a cycle, from rest to a load case and back (mean by weight;"
            f" {figures(largest, 3)} at most)"
        )
    if cases.task.fluid == "liquid":
        return f"{figures(one, 3)} liters {cycle}"
    return f"{figures(one, 3)} normal liters {cycle}; at 20 °C and 100 kPa (ISO 8778)"


def _cost(found: SearchResult, summary: Summary) -> str:
    catalog, fluid = found.catalog, summary.cases.task.fluid
    if summary.cost_of_a_cycle is None:
        unit = '"… EUR/m^3" or energy = ' if fluid == "air" else ""
        key = "air" if fluid == "air" else "energy"
        return f'no price given ([prices] {key} = {unit}"… EUR/kWh")'
    text = f"{figures(1000 * summary.cost_of_a_cycle, 3)} {catalog.currency} for 1000 cycles"
    if fluid == "air" and catalog.air is None:
        text += ", compressed without losses: a compressor takes more"
    return text


def _price(found: SearchResult, summary: Summary) -> str:
    catalog = found.catalog
    if summary.price is not None:
        return f"{figures(summary.price, 6)} {catalog.currency}, of muscles and valves"
    known = []
    if summary.price_of_muscles is not None:
        known.append(f"muscles {figures(summary.price_of_muscles, 6)} {catalog.currency}")
    if catalog.valve is not None:
        known.append(f"valves {figures(summary.valves * catalog.valve, 6)} {catalog.currency}")
    if known:
        missing = "a valve" if catalog.valve is None else "the muscles"
        return f"{known[0]}; no price of {missing} given"
    return "no price given ([prices] valve, muscle; or a catalog's)"
