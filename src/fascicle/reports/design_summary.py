"""Summary of a search in words, for the terminal and the page: a design's margin, size, mass,
fluid and cost; or, where no design does the task, the nearest one, its misses, and the remedies.
"""

import math

import numpy as np

from ..design.catalog import describe_cheapest
from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import BY_WEIGHT, OBJECTIVES, Limit, allowed_miss_fraction, other_limits
from ..design.remedies import Remedy, remedies
from ..design.summary import STANDARD_GRAVITY, Summary, summarize_result
from ..units import DIMENSIONS, figures, pretty


HEADS = ("case", "force", "stroke", "contraction", "gives up to", "to spare", "")
REACHED, MISSED = "reached", "MISSED"
_FORMATS = {"m": "length", "N": "force", "J": "energy"}
_LITER = 1e-3  # m³
_DIMENSIONS = {"supply_pressure": "pressure", "radius": "length", "length": "length"}


def format_objective(name: str, value: float) -> str:
    """An objective's `value` [SI] for a reader; `name` [-]."""
    unit = OBJECTIVES[name].unit
    if unit in _FORMATS:
        return pretty(value, _FORMATS[unit])
    return figures(value)


def objective_label(name: str) -> str:
    """An objective's `name` [-] as words."""
    return name.replace("_", " ")


def muscle_sizes(result: SearchResult, designs: Designs, index: int) -> str:
    """A design's muscles in a line.

    **Arguments:**

    - `result`: by a search [-].
    - `designs`: some of the search's [-].
    - `index`: which of them [-].

    **Returns:** the line [-].
    """
    there = designs.counts[index] > 0
    radii = dict.fromkeys(figures(1e3 * r) for r in designs.radius[index][there])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[index][there])
    angle = np.degrees(designs.angle[index, 0])
    text = (
        f"L₀ {pretty(designs.length[index], 'length')}, r₀ {', '.join(radii)} mm,"
        f" t₀ {', '.join(walls)} mm, α₀ {angle:.3g}°"
    )
    names = list(designs.drawings)
    name = names[designs.kind[index]]
    if name in result.catalog.products:
        return f"{result.catalog.products[name].name}, {text}"
    return text if len(names) == 1 else f"{text}, {name}"


def task_requirement(result: SearchResult) -> str:
    """What a design must do, in words; `result` [-] by a search."""
    share = allowed_miss_fraction(result.limits)
    if share <= 0:
        return "reach every load case"
    return f"miss no more than {100 * share:.4g} % of the load cases, by number and by weight"


def headline(result: SearchResult, summary: Summary) -> list[str]:
    """What is recommended, with which margin, and why.

    **Arguments:**

    - `result`: by a search that found a design [-].
    - `summary`: of the cheapest [-].

    **Returns:** sentences [-].
    """
    index = result.recommended
    assert index is not None
    first = f"Take {composition_text(summary)}, {muscle_sizes(result, result.designs, index)}."
    margin = f"margin: {_margin(summary)}."
    many, every = int(result.allowed.sum()), result.judged == len(result.index)
    if many == 1 and every:
        return [
            first,
            margin,
            f"It is the only one of {result.judged} designs that can {task_requirement(result)}"
            " within all limits.",
        ]
    which = f"the {many} designs" if every else f"those of {result.judged} judged designs"
    return [
        first,
        margin,
        f"It is the cheapest of {which} that {task_requirement(result)}, and keep all limits;"
        f" cheapest: {describe_cheapest(result.catalog, result.space.drawings)}.",
    ]


def margin_warning(result: SearchResult, summary: Summary) -> str:
    """What to say of a recommended design whose margin is small.

    **Arguments:**

    - `result`: by a search that found a design [-].
    - `summary`: of the cheapest [-].

    **Returns:** sentences, or none where the margin is large enough [-].
    """
    if Limit(least=result.least_margin).holds(summary.relative_margin):
        return ""
    i, least = _closest(summary), _percent(result.least_margin)
    force, largest = (
        pretty(x[i], "force") for x in (summary.cases.task.force, summary.cases.largest)
    )
    text = (
        f"the margin is {_percent(summary.relative_margin)}: case {i + 1} asks for {force}, where"
        f" this bundle is computed to give {largest}. That is below {least} ([limits] margin)."
        " Computed forces can be off by tens of percent, and by more where the braid angle is a"
        " degree off, so it may not do the task."
    )
    if (index := result.cheapest_with_margin) is None:
        return f"{text} No design of this search has {least}: look for larger or more muscles."
    better = result.all_designs(np.array([index]))
    return (
        f"{text} The cheapest design that has {least} is {better.labels[0]},"
        f' {muscle_sizes(result, better, 0)}: relative_margin = {{ at_least = "{least}" }} in'
        " [limits] takes it."
    )


def composition_text(summary: Summary) -> str:
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


def design_facts(result: SearchResult, summary: Summary) -> dict[str, str]:
    """What there is to know of a design besides its load cases.

    **Arguments:**

    - `result`: by a search [-].
    - `summary`: of one of its designs [-].

    **Returns:** sentences by what they are about [-].
    """
    cases = summary.cases
    stroke = cases.task.stroke_of(cases.length)
    facts = {
        "stroke": f"{pretty(stroke.max(), 'length')} of {pretty(cases.length, 'length')} at rest",
        "mass": _mass(summary, result.catalog.density),
        cases.task.fluid: _fluid(summary),
        f"cost of {cases.task.fluid}": _cost(result, summary),
        "price": _price(result, summary),
        "outer diameter": f"{pretty(summary.diameter_at_rest, 'length')} at rest,"
        f" {pretty(summary.diameter, 'length')} at the largest contraction"
        + (" with unfed units bowed out" if summary.valves > 1 else ""),
        "valves": f"{summary.valves}, one for each motor unit",
    }
    if (product := summary.product) is not None:
        source = f"; figures: {product.source}" if product.source else ""
        facts["product"] = (
            f"{summary.muscles} × {product.name}, {pretty(cases.length, 'length')}{source}"
        )
    share = allowed_miss_fraction(result.limits)
    missed = int(np.sum(~cases.reached))
    if share > 0 and missed:
        weight = float(np.average(~cases.reached, weights=cases.task.weight))
        facts["missed"] = (
            f"{missed} of {len(cases.task)} load cases, {100 * weight:.3g} % by weight; the task"
            f" file lets {100 * result.limits[BY_WEIGHT].most:.4g} % go"
        )
    return facts


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
    mean, largest = cases.fluid_of_a_cycle / _LITER, float(cases.fluid.max()) / _LITER
    if cases.task.time is not None:
        cycle = "a cycle, once through all load cases and back to the first"
    else:
        cycle = (
            "a cycle, from rest to a load case and back (mean by weight;"
            f" {figures(largest, 3)} at most)"
        )
    if cases.task.fluid == "liquid":
        return f"{figures(mean, 3)} liters {cycle}"
    return f"{figures(mean, 3)} normal liters {cycle}; at 20 °C and 100 kPa (ISO 8778)"


def _cost(result: SearchResult, summary: Summary) -> str:
    catalog, fluid = result.catalog, summary.cases.task.fluid
    if summary.cost_of_a_cycle is None:
        unit = '"… EUR/m^3" or energy = ' if fluid == "air" else ""
        key = "air" if fluid == "air" else "energy"
        return f'no price given ([prices] {key} = {unit}"… EUR/kWh")'
    text = f"{figures(1000 * summary.cost_of_a_cycle, 3)} {catalog.currency} for 1000 cycles"
    if fluid == "air" and catalog.air is None:
        text += ", compressed without losses: a compressor takes more"
    return text


def _price(result: SearchResult, summary: Summary) -> str:
    catalog = result.catalog
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


class InfeasibleResult:
    """What is told of a search that found no design: the `summary` of the nearest and what would
    make it reach the task, `changes`, none where it does.
    """

    def __init__(self, result: SearchResult):
        """**Arguments:** `result`: by a search that judged at least one design [-]."""
        assert result.nearest is not None
        self.result, self.index = result, result.nearest
        self.summary: Summary = summarize_result(result, result.nearest)
        self.design = result.all_designs(np.array([result.nearest]))
        self.reaches = bool(result.reaches_task[result.nearest])
        self.changes: list[Remedy] = []
        if not self.reaches:
            share = allowed_miss_fraction(result.limits)
            self.changes = remedies(
                self.design, 0, result.task, share, result.limits, self.summary.product
            )

    @property
    def keeps(self) -> bool:
        """Whether the nearest keeps all other limits [-]."""
        return not self._broken_limits()

    def lines(self) -> list[str]:
        """All of it in sentences [-]."""
        lines = [self.verdict(), *self.limit_counts(), self.nearest()]
        if self.changes:
            lines += ["What would reach it, each by itself:", *self.remedies()]
        return lines

    def verdict(self) -> str:
        """That there is none, in a sentence."""
        result, all_kept = self.result, self.result.judged == len(self.result.index)
        reach = int(result.reaches_task.sum())
        if reach and all_kept:
            return (
                f"{reach} of {result.judged} designs {task_requirement(result)}, but none of them"
                " keeps all other limits: none is recommended."
            )
        rest = "" if all_kept or not other_limits(result.limits) else " within the other limits"
        return (
            f"No design is recommended: none of the {result.judged} that were judged can"
            f" {task_requirement(result)}{rest}."
        )

    def limit_counts(self) -> list[str]:
        """Which limit leaves how many designs, in sentences [-]."""
        return [*limit_counts(self.result), *(f"{name}: {why}." for name, why in self._barred())]

    def nearest(self) -> str:
        """Which design comes nearest, and by how much it misses what, in a sentence."""
        cases, broken = self.summary.cases, self._broken_limits()
        which = f"{composition_text(self.summary)}, {muscle_sizes(self.result, self.design, 0)}"
        rest = f" It breaks other limits: {', '.join(broken)}." if broken else ""
        if self.reaches:
            return f"One that reaches all: {which}.{rest}"
        i, missed = cases.worst, int(np.sum(~cases.reached))
        asked, gives = float(cases.task.force[i]), float(cases.largest[i])
        share = f" ({-100 * float(cases.relative[i]):.3g} %)" if asked > 0 else ""
        strain = 100 * cases.task.strain_of(cases.length)[i]
        does = f"gives {pretty(gives, 'force')}" if gives > 0 else "only pushes"
        return (
            f"The nearest is {which}. It misses {missed} of {len(cases.task)} load cases, worst"
            f" case {i + 1} by {pretty(-float(cases.spare[i]), 'force')}{share}:"
            f" {pretty(asked, 'force')} at {strain:.3g} % contraction, where it {does}.{rest}"
        )

    def remedies(self) -> list[str]:
        """What would reach the task, a sentence for each change [-]."""
        lines = [self._remedy_text(remedy) for remedy in self.changes]
        if (
            any(self._too_far(remedy) for remedy in self.changes)
            and self.result.task.stroke is None
        ):
            lines.append(
                "A braid with a smaller angle contracts further; a stroke in mm, stroke instead of"
                " strain, asks less of longer muscles."
            )
        return lines

    def _broken_limits(self) -> list[str]:
        values, index = self.result.values, self.index
        return [
            f"{objective_label(name)} {format_objective(name, float(values[name][index]))}"
            for name, limit in other_limits(self.result.limits).items()
            if not limit.holds(values[name][index])
        ]

    def _barred(self) -> list[tuple[str, str]]:
        return [
            (f"{name} may not be used", why) for name, why in self.result.excluded_products.items()
        ]

    def _too_far(self, remedy: Remedy) -> bool:
        strain = self._strain(remedy)
        return remedy.value is None and remedy.largest <= 0 and strain > remedy.free_strain

    def _strain(self, remedy: Remedy) -> float:
        length = remedy.most if remedy.what == "length" else self.summary.cases.length
        return float(self.result.task.strain_of(length)[remedy.worst])

    def _remedy_text(self, remedy: Remedy) -> str:
        what = objective_label(remedy.what)
        if remedy.value is not None:
            return f"{what}: {self._change(remedy)}{self._broken(remedy)}."
        top = (
            f"{remedy.most:.0f}"
            if remedy.what == "muscles"
            else _up(remedy.most, _DIMENSIONS[remedy.what])
        )
        none = "no number" if remedy.what == "muscles" else "none"
        if self._too_far(remedy):
            at = f"at {top}" if remedy.what == "supply_pressure" else "at this pressure"
            upto = f" up to {top}" if remedy.what == "length" else ""
            return (
                f"{what}: {none}{upto} does: {at} these muscles contract by"
                f" {100 * remedy.free_strain:.3g} % at most, case {remedy.worst + 1} asks for"
                f" {100 * self._strain(remedy):.3g} %."
            )
        return (
            f"{what}: {none} up to {top} does: there case {remedy.worst + 1} still misses"
            f" {pretty(remedy.short, 'force')}."
        )

    def _change(self, remedy: Remedy) -> str:
        assert remedy.value is not None
        if remedy.what == "muscles":
            *held, last = [int(n) for n in self.design.counts[0] if n]
            units = "+".join(str(n) for n in [*held, last + round(remedy.value - remedy.now)])
            return f"{remedy.value:.0f} of this size instead of {remedy.now:.0f} ({units})"
        kind = _DIMENSIONS[remedy.what]
        text = f"{_up(remedy.value, kind)} instead of {pretty(remedy.now, kind)}"
        if remedy.what == "supply_pressure" and remedy.value > remedy.measured:
            text += (
                f", beyond the {pretty(remedy.measured, kind)} that the tuning was measured up to"
            )
        return f"{text}, walls in proportion" if remedy.what == "radius" else text

    def _broken(self, remedy: Remedy) -> str:
        lines = []
        for name, value in remedy.breaks:
            limit = self.result.limits[name]
            end = limit.most if value > limit.most else limit.least
            lines.append(
                f"{objective_label(name)} {format_objective(name, value)}, limited to"
                f" {format_objective(name, end)}"
            )
        return f"; it breaks a limit then: {', '.join(lines)}" if lines else ""


def summarize_search(result: SearchResult) -> Summary | InfeasibleResult:
    """The recommended design, summarized, or what is told where there is none; `result` [-]."""
    return (
        InfeasibleResult(result)
        if result.cheapest is None
        else summarize_result(result, result.cheapest)
    )


def limit_counts(result: SearchResult) -> list[str]:
    """Which other limit leaves how many designs, where none keeps all; `result` [-]."""
    lines = []
    for name, limit in other_limits(result.limits).items():
        values = result.values[name]
        kept = int(np.sum(limit.holds(values)))
        if kept == len(values) or result.judged > len(result.index):
            continue
        lines.append(
            f"{objective_label(name)}: {kept} of {len(values)} designs keep its limit; they lie"
            f" between {format_objective(name, float(values.min()))} and"
            f" {format_objective(name, float(values.max()))}."
        )
    return lines


def _up(value: float, dimension: str) -> str:
    """A value that is enough [SI] for a reader: four figures, none of them rounded down."""
    kind = DIMENSIONS[dimension]
    size = float(kind.factors[kind.shown])
    places = 3 - math.floor(math.log10(value / size))
    # what is a round number already must not become the next one
    figure = math.ceil(value / size * 10.0**places * (1 - 1e-12)) / 10.0**places
    return pretty(figure * size, dimension, 4)
