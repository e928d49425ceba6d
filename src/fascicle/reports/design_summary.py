"""Summary of a search in words, for the terminal and the page: a design's margin, size, mass,
fluid and cost; or, if no design does the task, the nearest one, its misses, and the remedies.
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
_DIMENSIONS = {"m": "length", "N": "force", "J": "energy"}  # by an objective's unit
_REMEDY_DIMENSIONS = {"supply_pressure": "pressure", "radius": "length", "length": "length"}
_LITER = 1e-3  # m³


def format_objective(name: str, value: float) -> str:
    """Text of an objective's `value` [SI], by its `name`."""
    unit = OBJECTIVES[name].unit
    return pretty(value, _DIMENSIONS[unit]) if unit in _DIMENSIONS else figures(value)


def objective_label(name: str) -> str:
    """Label of an objective."""
    return name.replace("_", " ")


def muscle_sizes(result: SearchResult, designs: Designs, index: int) -> str:
    """Sizes of a design's muscles in a line.

    **Arguments:**

    - `result`: of a search.
    - `designs`: some of the search's designs.
    - `index`: of the design among them.
    """
    used = designs.counts[index] > 0
    radii = dict.fromkeys(figures(1e3 * r) for r in designs.radius[index][used])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[index][used])
    text = (
        f"L₀ {pretty(designs.length[index], 'length')}, r₀ {', '.join(radii)} mm,"
        f" t₀ {', '.join(walls)} mm, α₀ {np.degrees(designs.angle[index, 0]):.3g}°"
    )
    names = list(designs.drawings)
    name = names[designs.kind[index]]
    if name in result.catalog.products:
        return f"{result.catalog.products[name].name}, {text}"
    return text if len(names) == 1 else f"{text}, {name}"


def task_requirement(result: SearchResult) -> str:
    """Requirement on every design of a search, after "must"."""
    miss = allowed_miss_fraction(result.limits)
    if miss <= 0:
        return "reach every load case"
    return f"miss no more than {100 * miss:.4g} % of the load cases, by number and by weight"


def composition_text(summary: Summary) -> str:
    """Composition of a design in words."""
    muscles = "muscle" if summary.muscles == 1 else "muscles"
    if summary.valves == 1:
        return f"{summary.muscles} {muscles} in 1 motor unit"
    return f"{summary.muscles} {muscles} in {summary.valves} motor units ({summary.label})"


def headline(result: SearchResult, summary: Summary) -> list[str]:
    """Sentences on the recommended design: its sizes, its margin, and the reason."""
    index = result.recommended
    assert index is not None
    allowed, complete = int(result.allowed.sum()), result.judged == len(result.index)
    requirement = task_requirement(result)
    if allowed == 1 and complete:
        reason = (
            f"It is the only one of {result.judged} designs that can {requirement} within all"
            " limits."
        )
    else:
        designs = (
            f"the {allowed} designs" if complete else f"those of {result.judged} judged designs"
        )
        reason = (
            f"It is the cheapest of {designs} that {requirement}, and keep all limits;"
            f" cheapest: {describe_cheapest(result.catalog, result.space.drawings)}."
        )
    sizes = muscle_sizes(result, result.designs, index)
    return [
        f"Take {composition_text(summary)}, {sizes}.", f"margin: {_margin(summary)}.", reason
    ]  # fmt: skip


def _margin(summary: Summary) -> str:
    cases = summary.cases
    if not cases.reached.all():
        short = pretty(-float(cases.spare[cases.worst]), "force")
        return f"none: case {cases.worst + 1} misses {short}"
    i = _closest(summary)
    spare = float(cases.spare[i])
    text = (
        f"{_percent(summary.relative_margin)}, {pretty(spare, 'force')} to spare at case {i + 1},"
        f" which could lift {pretty(float(cases.largest[i]), 'force')},"
        f" {pretty(spare / STANDARD_GRAVITY, 'mass', 3)} more"
    )
    if cases.tightest != i:
        fewest = pretty(float(cases.spare[cases.tightest]), "force")
        text += f"; the fewest newtons are {fewest}, at case {cases.tightest + 1}"
    if np.isfinite(summary.load_factor):
        factor = figures(np.floor(1e3 * summary.load_factor) / 1e3)
        text += f"; all loads could be {factor} times as large"
    return text


def _closest(summary: Summary) -> int:
    """Reached load case with the least force to spare, relative to its demand."""
    cases = summary.cases
    return int(np.argmin(np.where(cases.reached, cases.relative, np.inf)))


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"


def margin_warning(result: SearchResult, summary: Summary) -> str:
    """Warning of a small margin of the recommended design; empty if it is large enough."""
    if Limit(least=result.least_margin).holds(summary.relative_margin):
        return ""
    i, threshold = _closest(summary), _percent(result.least_margin)
    force, largest = (
        pretty(x[i], "force") for x in (summary.cases.task.force, summary.cases.largest)
    )
    text = (
        f"the margin is {_percent(summary.relative_margin)}: case {i + 1} asks for {force}, where"
        f" this bundle is computed to give {largest}. That is below {threshold} ([limits] margin)."
        " Computed forces can be off by tens of percent, and by more where the braid angle is a"
        " degree off, so it may not do the task."
    )
    if (index := result.cheapest_with_margin) is None:
        return f"{text} No design of this search has {threshold}: look for larger or more muscles."
    better = result.all_designs(np.array([index]))
    return (
        f"{text} The cheapest design that has {threshold} is {better.labels[0]},"
        f' {muscle_sizes(result, better, 0)}: relative_margin = {{ at_least = "{threshold}" }} in'
        " [limits] takes it."
    )


def case_rows(summary: Summary, limit: int) -> tuple[list[list[str]], str]:
    """Rows of load cases under `HEADS`, at most `limit` with the least to spare, and a caption."""
    cases, task = summary.cases, summary.cases.task
    indices = np.arange(len(task))
    caption = f"{len(task) - int(np.sum(~cases.reached))} of {len(task)} reached"
    if len(task) > limit:
        indices = np.sort(np.argsort(cases.relative)[:limit])
        caption = f"the {limit} of {len(task)} with least to spare; {caption}"
    strain, stroke = task.strain_of(cases.length), task.stroke_of(cases.length)
    rows = [
        [
            str(i + 1), pretty(task.force[i], "force"), pretty(stroke[i], "length"),
            f"{100 * strain[i]:.3g} %", pretty(cases.largest[i], "force"),
            pretty(cases.spare[i], "force"), REACHED if cases.reached[i] else MISSED,
        ]
        for i in indices.tolist()
    ]  # fmt: skip
    return rows, caption


def design_facts(result: SearchResult, summary: Summary) -> dict[str, str]:
    """Facts on a design besides its load cases, by topic."""
    cases, product = summary.cases, summary.product
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
    if product is not None:
        source = f"; figures: {product.source}" if product.source else ""
        facts["product"] = (
            f"{summary.muscles} × {product.name}, {pretty(cases.length, 'length')}{source}"
        )
    missed = ~cases.reached
    if allowed_miss_fraction(result.limits) > 0 and missed.any():
        weight = float(np.average(missed, weights=cases.task.weight))
        facts["missed"] = (
            f"{missed.sum()} of {len(cases.task)} load cases, {100 * weight:.3g} % by weight; the"
            f" task file lets {100 * result.limits[BY_WEIGHT].most:.4g} % go"
        )
    return facts


def _mass(summary: Summary, density: float | None) -> str:
    if (
        summary.product is not None
        and summary.product.mass is not None
        and summary.mass is not None
    ):
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
    cycle = "a cycle, once through all load cases and back to the first"
    if cases.task.time is None:
        cycle = (
            "a cycle, from rest to a load case and back (mean by weight;"
            f" {figures(largest, 3)} at most)"
        )
    if cases.task.fluid == "liquid":
        return f"{figures(mean, 3)} liters {cycle}"
    return f"{figures(mean, 3)} normal liters {cycle}; at 20 °C and 100 kPa (ISO 8778)"


def _cost(result: SearchResult, summary: Summary) -> str:
    catalog, air = result.catalog, summary.cases.task.fluid == "air"
    if summary.cost_of_a_cycle is None:
        keys = 'air = "… EUR/m^3" or energy' if air else "energy"
        return f'no price given ([prices] {keys} = "… EUR/kWh")'
    text = f"{figures(1000 * summary.cost_of_a_cycle, 3)} {catalog.currency} for 1000 cycles"
    if air and catalog.air is None:
        text += ", compressed without losses: a compressor takes more"
    return text


def _price(result: SearchResult, summary: Summary) -> str:
    catalog = result.catalog
    if summary.price is not None:
        return f"{figures(summary.price, 6)} {catalog.currency}, of muscles and valves"
    if summary.price_of_muscles is not None:
        muscles = figures(summary.price_of_muscles, 6)
        missing = "a valve" if catalog.valve is None else "the muscles"
        return f"muscles {muscles} {catalog.currency}; no price of {missing} given"
    if catalog.valve is not None:
        valves = figures(summary.valves * catalog.valve, 6)
        return f"valves {valves} {catalog.currency}; no price of the muscles given"
    return "no price given ([prices] valve, muscle; or a catalog's)"


class InfeasibleResult:
    """Search without a recommended design: the `summary` of the nearest `design`, and the `changes`
    with which it would reach the task.
    """

    def __init__(self, result: SearchResult):
        """**Arguments:** `result`: of a search that judged at least one design."""
        assert result.nearest is not None
        self.result, self.index = result, result.nearest
        self.summary: Summary = summarize_result(result, result.nearest)
        self.design = result.all_designs(np.array([result.nearest]))
        self.reaches = bool(result.reaches_task[result.nearest])
        self.changes: list[Remedy] = []
        if not self.reaches:
            miss = allowed_miss_fraction(result.limits)
            self.changes = remedies(
                self.design, 0, result.task, miss, result.limits, self.summary.product
            )

    @property
    def keeps(self) -> bool:
        """True if the nearest design keeps all other limits."""
        return not self._broken_limits()

    def lines(self) -> list[str]:
        """All sentences: verdict, limits, nearest design, remedies."""
        lines = [self.verdict(), *self.limit_counts(), self.nearest()]
        if self.changes:
            lines += ["What would reach it, each by itself:", *self.remedies()]
        return lines

    def verdict(self) -> str:
        """Sentence that no design is recommended."""
        result, requirement = self.result, task_requirement(self.result)
        complete, reaching = result.judged == len(result.index), int(result.reaches_task.sum())
        if reaching and complete:
            return (
                f"{reaching} of {result.judged} designs {requirement}, but none of them"
                " keeps all other limits: none is recommended."
            )
        limits = "" if complete or not other_limits(result.limits) else " within the other limits"
        return (
            f"No design is recommended: none of the {result.judged} that were judged can"
            f" {requirement}{limits}."
        )

    def limit_counts(self) -> list[str]:
        """Sentences on how many designs keep each other limit, and on excluded products."""
        result, lines = self.result, []
        for name, limit in other_limits(result.limits).items():
            values = result.values[name]
            count = int(np.sum(limit.holds(values)))
            if count < len(values) and result.judged <= len(result.index):
                low, high = (format_objective(name, float(f(values))) for f in (np.min, np.max))
                lines.append(
                    f"{objective_label(name)}: {count} of {len(values)} designs keep its limit;"
                    f" they lie between {low} and {high}."
                )
        excluded = result.excluded_products.items()
        return lines + [f"{name} may not be used: {reason}." for name, reason in excluded]

    def nearest(self) -> str:
        """Sentence on the nearest design and its largest miss."""
        cases, broken = self.summary.cases, self._broken_limits()
        text = f"{composition_text(self.summary)}, {muscle_sizes(self.result, self.design, 0)}"
        limits = f" It breaks other limits: {', '.join(broken)}." if broken else ""
        if self.reaches:
            return f"One that reaches all: {text}.{limits}"
        i, missed = cases.worst, int(np.sum(~cases.reached))
        demand, force = float(cases.task.force[i]), float(cases.largest[i])
        percent = f" ({-100 * float(cases.relative[i]):.3g} %)" if demand > 0 else ""
        strain = 100 * cases.task.strain_of(cases.length)[i]
        response = f"it gives {pretty(force, 'force')}" if force > 0 else "it only pushes"
        return (
            f"The nearest is {text}. It misses {missed} of {len(cases.task)} load cases, worst"
            f" case {i + 1} by {pretty(-float(cases.spare[i]), 'force')}{percent}:"
            f" {pretty(demand, 'force')} at {strain:.3g} % contraction, where {response}.{limits}"
        )

    def remedies(self) -> list[str]:
        """Sentences on the remedies, one for each change."""
        lines = [self._remedy_text(remedy) for remedy in self.changes]
        if self.result.task.stroke is None and any(map(self._too_far, self.changes)):
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

    def _strain(self, remedy: Remedy) -> float:
        """Strain [-] of the remedy's worst load case."""
        length = remedy.most if remedy.what == "length" else self.summary.cases.length
        return float(self.result.task.strain_of(length)[remedy.worst])

    def _too_far(self, remedy: Remedy) -> bool:
        """True if a change doesn't help since the muscles can't contract so far."""
        strain = self._strain(remedy)
        return remedy.value is None and remedy.largest <= 0 and strain > remedy.free_strain

    def _remedy_text(self, remedy: Remedy) -> str:
        label, case = objective_label(remedy.what), remedy.worst + 1
        muscles = remedy.what == "muscles"
        if remedy.value is not None:
            return f"{label}: {self._change_text(remedy, remedy.value)}."
        dimension = _REMEDY_DIMENSIONS.get(remedy.what, "")
        top = f"{remedy.most:.0f}" if muscles else _round_up(remedy.most, dimension)
        none = "no number" if muscles else "none"
        if self._too_far(remedy):
            condition = f"at {top}" if remedy.what == "supply_pressure" else "at this pressure"
            range_ = f" up to {top}" if remedy.what == "length" else ""
            return (
                f"{label}: {none}{range_} does: {condition} these muscles contract by"
                f" {100 * remedy.free_strain:.3g} % at most, case {case} asks for"
                f" {100 * self._strain(remedy):.3g} %."
            )
        short = pretty(remedy.short, "force")
        return f"{label}: {none} up to {top} does: there case {case} still misses {short}."

    def _change_text(self, remedy: Remedy, value: float) -> str:
        """A change, from the present value, and the limits that it breaks."""
        if remedy.what == "muscles":
            *counts, last = [int(n) for n in self.design.counts[0] if n]
            units = "+".join(str(n) for n in [*counts, last + round(value - remedy.now)])
            text = f"{value:.0f} of this size instead of {remedy.now:.0f} ({units})"
        else:
            dimension = _REMEDY_DIMENSIONS[remedy.what]
            text = f"{_round_up(value, dimension)} instead of {pretty(remedy.now, dimension)}"
            if remedy.what == "supply_pressure" and value > remedy.measured:
                measured = pretty(remedy.measured, dimension)
                text += f", beyond the {measured} that the tuning was measured up to"
            if remedy.what == "radius":
                text += ", walls in proportion"
        broken = []
        for name, number in remedy.breaks:
            limit = self.result.limits[name]
            end = limit.most if number > limit.most else limit.least
            broken.append(
                f"{objective_label(name)} {format_objective(name, number)}, limited to"
                f" {format_objective(name, end)}"
            )
        return f"{text}; it breaks a limit then: {', '.join(broken)}" if broken else text


def summarize_search(result: SearchResult) -> Summary | InfeasibleResult:
    """Summary of the recommended design, or of a search without one."""
    if result.cheapest is None:
        return InfeasibleResult(result)
    return summarize_result(result, result.cheapest)


def _round_up(value: float, dimension: str) -> str:
    """Text of a sufficient value [SI]: four figures, never rounded down."""
    kind = DIMENSIONS[dimension]
    size = float(kind.factors[kind.common])
    decimals = 3 - math.floor(math.log10(value / size))
    # a round number must not become the next one
    number = math.ceil(value / size * 10.0**decimals * (1 - 1e-12)) / 10.0**decimals
    return pretty(number * size, dimension, 4)
