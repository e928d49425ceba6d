"""Summary of a search in words, for the terminal and the page: a design's margin, size, mass,
fluid and cost; or, if no design does the task, the nearest one, its misses, and the remedies.
"""

import math
from dataclasses import replace

import numpy as np

from ..core.errors import missing_extra
from ..design.catalog import describe_cheapest
from ..design.cycle import (
    LARGEST_OVERSHOOT,
    WIDEST_BORE,
    CycleRun,
    ValveSizing,
    fit_valves,
    run_cycle,
)
from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import BY_WEIGHT, OBJECTIVES, Limit, allowed_miss_fraction, other_limits
from ..design.remedies import Remedy, remedies
from ..design.scatter import Safety
from ..design.summary import STANDARD_GRAVITY, Summary, size_for_cases, summarize_result
from ..units import DIMENSIONS, format_digits, pretty


HEADS = ("case", "demanded force", "stroke", "contraction", "available force", "spare force", "")
REACHED, MISSED = "reached", "MISSED"
_DIMENSIONS = {"m": "length", "N": "force", "J": "energy"}  # by an objective's unit
_REMEDY_DIMENSIONS = {"supply_pressure": "pressure", "radius": "length", "length": "length"}
_LITER = 1e-3  # m³
_UNKNOWN = "unknown: "  # begins a fact without a number, and what to give in the task file


def format_objective(name: str, value: float) -> str:
    """Text of an objective's `value` [SI], by its `name`."""
    unit = OBJECTIVES[name].unit
    return pretty(value, _DIMENSIONS[unit]) if unit in _DIMENSIONS else format_digits(value)


def objective_label(name: str) -> str:
    """Name of an objective with spaces, such as "largest force"."""
    return name.replace("_", " ")


def objective_head(name: str) -> str:
    """Label of an objective for a column head; `[-]` follows if it has no unit."""
    return objective_label(name) + " [-]" * (OBJECTIVES[name].unit == "-")


def muscle_sizes(result: SearchResult, designs: Designs, index: int) -> str:
    """Sizes of the muscles of one of the `designs` of a search, with an `index`, in a line."""
    used = designs.counts[index] > 0
    radii = dict.fromkeys(format_digits(1e3 * r) for r in designs.radius[index][used])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[index][used])
    text = (
        f"length {pretty(designs.length[index], 'length')}, radius {', '.join(radii)} mm,"
        f" wall {', '.join(walls)} mm, braid {np.degrees(designs.angle[index, 0]):.3g}°"
    )
    names = list(designs.drawings)
    name = names[designs.kind[index]]
    if name in result.catalog.products:
        return f"{result.catalog.products[name].name}, {text}"
    return text if len(names) == 1 else f"{text}, {name}"


def task_requirement(result: SearchResult) -> str:
    """Words after "must": reach every load case, or miss no more than a share of them."""
    miss = allowed_miss_fraction(result.limits)
    if miss <= 0:
        return "reach every load case"
    return f"miss no more than {100 * miss:.4g} % of the load cases, by number and by weight"


def design_name(index: int) -> str:
    """Name of a reported design, by its `index` counted from 0: that of its row and its file."""
    return f"design {index + 1}"


def composition_text(summary: Summary) -> str:
    """Composition of a design in words."""
    muscles = "muscle" if summary.muscles == 1 else "muscles"
    if summary.valves == 1:
        return f"{summary.muscles} {muscles} in 1 motor unit"
    return f"{summary.muscles} {muscles} in {summary.valves} motor units ({summary.label})"


def summary_lines(result: SearchResult, summary: Summary) -> list[str]:
    """Lines on the recommended design for the terminal: at most twelve without a warning."""
    recommendation, margin, *reasons = headline(result, summary)
    facts = design_facts(result, summary)
    warnings = [f"warning: {text}" for text in design_warnings(result, summary)]
    lines = [recommendation, margin, *warnings, *reasons]
    gaps = []
    if "valves" in facts:
        facts["valves"] += f"; life: {facts.pop('life')}"
    for name, text in facts.items():
        if text.startswith(_UNKNOWN):
            gaps.append(f"{name} ({text.removeprefix(_UNKNOWN)})")
        else:
            lines.append(f"{name}: {text}")
    if gaps:
        lines.append(f"unknown: {', '.join(gaps)}")
    if (index := result.compromise) is not None and index != result.recommended:
        sizes = muscle_sizes(result, result.designs, index)
        lines.append(
            f"alternative: {design_name(index)} ({result.designs.labels[index]}, {sizes}), the best"
            " compromise of all objectives"
        )
    return lines


def headline(result: SearchResult, summary: Summary) -> list[str]:
    """Sentences on the recommended design: its sizes, its margin, and the reason."""
    index = result.recommended
    assert index is not None
    allowed, complete = int(result.allowed.sum()), result.judged == len(result.index)
    requirement, sizes = task_requirement(result), muscle_sizes(result, result.designs, index)
    if allowed == 1 and complete:
        reason = (
            f"It is the only one of {result.judged} designs that can {requirement} and keeps all"
            " limits."
        )
    else:
        designs = f"the {allowed}" if complete else f"{result.judged} evaluated"
        meaning = describe_cheapest(result.catalog, result.space.drawings)
        reason = (
            f"It is the cheapest on the front of {designs} designs that {requirement} and keep all"
            f" limits; cheapest means {meaning}."
        )
        safety = result.safety
        if safety is not None and safety.judged > safety.safe:
            number = safety.judged - safety.safe
            ending = "design holds" if number == 1 else "designs hold"
            reason += f" {number} other {ending} in too few draws to be on the front."
    take = f"Take {design_name(index)}: {composition_text(summary)}, {sizes}."
    return [take, f"margin: {_margin_text(summary)}.", *safety_lines(result), reason]


def low_margin_heads(result: SearchResult) -> list[str]:
    """Head of the column of `low_margin`, if designs were judged in draws."""
    return [] if result.safety is None else ["relative margin, 5th percentile [-]"]


def low_margin(result: SearchResult, index: int) -> list[str]:
    """Margin that 95 % of the draws of a reported design with an `index` have, if there are any."""
    if result.safety is None:
        return []
    return [format_objective("relative_margin", float(result.safety.margin_quantiles[index]))]


def safety_lines(result: SearchResult) -> list[str]:
    """A line on the draws in which the recommended design holds, and what was assumed."""
    safety, index = result.safety, result.recommended
    if safety is None or index is None:
        return []
    low, uncertainty = float(safety.margin_quantiles[index]), safety.uncertainty
    return [
        f"safety: holds in {_percent(safety.probability)} of {uncertainty.draws} draws of scatter"
        f" ({_percent(uncertainty.share)} needed); margin {_percent(low)} at the 5th percentile;"
        f" standard deviations: {uncertainty.assumptions}."
    ]


def _margin_text(summary: Summary) -> str:
    cases = summary.cases
    if not cases.reached.all():
        short = pretty(-float(cases.spare[cases.worst]), "force")
        return f"none: case {cases.worst + 1} misses {short}"
    i = _closest_case(summary)
    spare = float(cases.spare[i])
    text = (
        f"{_percent(summary.relative_margin)} at case {i + 1}: {_demand_and_supply(summary, i)},"
        f" {pretty(spare, 'force')} to spare (weight of"
        f" {pretty(spare / STANDARD_GRAVITY, 'mass', 3)})"
    )
    if cases.tightest != i:
        smallest = pretty(float(cases.spare[cases.tightest]), "force")
        text += f"; least force to spare: {smallest} at case {cases.tightest + 1}"
    if np.isfinite(summary.load_factor):
        factor = format_digits(np.floor(1e3 * summary.load_factor) / 1e3)
        text += f"; all loads could be {factor} times as large"
    return text


def _closest_case(summary: Summary) -> int:
    """Index of the reached load case with the least force to spare, relative to its demand."""
    cases = summary.cases
    return int(np.argmin(np.where(cases.reached, cases.relative, np.inf)))


def _demand_and_supply(summary: Summary, case: int) -> str:
    demanded, available = (
        pretty(float(x[case]), "force") for x in (summary.cases.task.force, summary.cases.largest)
    )
    return f"{demanded} demanded, {available} available"


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"


def design_warnings(result: SearchResult, summary: Summary) -> list[str]:
    """Warnings on the recommended design: a cycle that it fails, and a small margin."""
    cycle = (
        f"it fails its cycle in the run over time: {summary.run_failure}. Allow more time in"
        " [cycle], or damp the load."
    )
    margin = margin_warning(result, summary)
    return [*[cycle] * bool(summary.run_failure), *[margin] * bool(margin)]


def margin_warning(result: SearchResult, summary: Summary) -> str:
    """Warning of a small margin of the recommended design; empty if it is large enough."""
    if Limit(least=result.least_margin).holds(summary.relative_margin):
        return ""
    i, threshold = _closest_case(summary), _percent(result.least_margin)
    text = (
        f"the margin is {_percent(summary.relative_margin)}: {_demand_and_supply(summary, i)} at"
        f" case {i + 1}. That is below {threshold} ([limits] margin). Computed forces can be off by"
        " tens of percent, and by more if the braid angle is a degree off: it may fail the task."
    )
    if result.safety is not None:  # another one may hold in too few draws
        return text
    if (index := result.cheapest_with_margin) is None:
        return f"{text} No design of this search has {threshold}: add larger or more muscles."
    better = result.all_designs(np.array([index]))
    return (
        f"{text} The cheapest design that has {threshold} is {better.labels[0]},"
        f" {muscle_sizes(result, better, 0)}: to get it, write"
        f' relative_margin = {{ at_least = "{threshold}" }} in [limits].'
    )


def case_rows(summary: Summary, limit: int) -> tuple[list[list[str]], str]:
    """Rows of load cases under `HEADS`, and a caption that counts the cases reached. The rows stay
    in the task's order: all of them, or the `limit` with the least to spare.
    """
    cases, task = summary.cases, summary.cases.task
    indices = np.arange(len(task))
    caption = f"{int(np.sum(cases.reached))} of {len(task)} reached"
    if len(task) > limit:
        indices = np.sort(np.argsort(cases.relative)[:limit])
        caption = f"the {limit} of {len(task)} with the least force to spare; {caption}"
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
    cases, product, catalog = summary.cases, summary.product, result.catalog
    stroke, fluid, missed = cases.task.stroke_of(cases.length), cases.task.fluid, ~cases.reached
    facts = {
        "size": f"stroke {pretty(stroke.max(), 'length')} of {pretty(cases.length, 'length')} at"
        f" rest; outer diameter {pretty(summary.diameter_at_rest, 'length')} at rest,"
        f" {pretty(summary.diameter, 'length')} at the largest contraction"
        + (", where vented units bow out" if summary.valves > 1 else ""),
        "mass": _mass(summary, catalog.density),
        fluid: _fluid(summary),
        **({} if summary.sizing is None else {"valves": _valves_text(summary, summary.sizing)}),
        f"cost of {fluid}": f"{_UNKNOWN}give [prices] {'air or ' * (fluid == 'air')}energy",
        "price": _price_text(result, summary),
        "life": "unknown; no source gives cycles for this muscle",
    }
    if summary.cost_of_a_cycle is not None:
        cost = (
            f"{format_digits(1000 * summary.cost_of_a_cycle, 3)} {catalog.currency} for 1000 cycles"
        )
        if fluid == "air" and catalog.air is None:
            cost += ", compressed without losses: a compressor takes more"
        facts[f"cost of {fluid}"] = cost
    if product is not None:
        source = f"; figures: {product.source}" if product.source else ""
        length = pretty(cases.length, "length")
        facts["product"] = f"{summary.muscles} × {product.name}, {length}{source}"
    if allowed_miss_fraction(result.limits) > 0 and missed.any():
        weight = float(np.average(missed, weights=cases.task.weight))
        facts["missed"] = (
            f"{missed.sum()} of {len(cases.task)} load cases, {100 * weight:.3g} % by weight; the"
            f" task file allows {100 * result.limits[BY_WEIGHT].most:.4g} %"
        )
    return facts


def _mass(summary: Summary, density: float | None) -> str:
    rubber = f"{format_digits(1e6 * summary.bladders, 3)} cm³ of bladder"
    if summary.mass is None:
        return f"{_UNKNOWN}give [design] density; {rubber}"
    mass = pretty(summary.mass, "mass", 3)
    if summary.product is not None and summary.product.mass is not None:
        return f"{mass} of muscles, by the catalog"
    return f"{mass} of bladders ({rubber} at {density:g} kg/m³), without braid and fittings"


def _fluid(summary: Summary) -> str:
    cases = summary.cases
    mean, largest = cases.fluid_of_a_cycle / _LITER, float(cases.fluid.max()) / _LITER
    cycle = "for a cycle through all load cases and back to the first"
    if cases.task.time is None:
        cycle = (
            "for a cycle from rest to a load case and back (weighted mean;"
            f" the largest takes {format_digits(largest, 3)})"
        )
    if cases.task.fluid == "liquid":
        return f"{format_digits(mean, 3)} liters {cycle}"
    return f"{format_digits(mean, 3)} normal liters {cycle}; at 20 °C and 100 kPa (ISO 8778)"


def _valves_text(summary: Summary, sizing: ValveSizing) -> str:
    """Valves and hoses for the cycle, the air that it takes, and the run in time."""
    cycle, text = sizing.cycle, ""
    hose = "" if cycle.hose_length is None else pretty(cycle.hose_length, "length", 3)
    demand = f"to contract and release within {pretty(cycle.time, 'time', 3)}"
    if not sizing.feasible:
        return (
            f"none is enough {demand}: a hose of {hose} up to {1e3 * WIDEST_BORE:g} mm wide lets"
            " too little air through; take a shorter hose, or more time, in [cycle]"
        )
    conductances = [format_digits(1e8 * C, 3) for C in sizing.conductance]
    values = dict.fromkeys(conductances)
    units = f" (units {', '.join(map(str, range(1, 1 + len(conductances))))})"
    text = (
        f"each needs C of {', '.join(values if len(values) == 1 else conductances)} L/(s·bar)"
        f"{units if len(values) > 1 else ''} at b = {cycle.b:g} {demand}: at case {sizing.case + 1}"
        f" fills in {pretty(sizing.fill, 'time', 3)}, vents in {pretty(sizing.vent, 'time', 3)}"
    )
    if sizing.time < cycle.time:
        text += " without inertia, as the load swings"
    if sizing.bore is not None:
        text += f"; hoses of {hose} at least {1e3 * sizing.bore:g} mm wide"
    names = dict.fromkeys(
        "none of the catalog" if valve is None else valve.name for valve in sizing.valves
    )
    text += f"; smallest verified valve: {', '.join(names)}"
    text += (
        f"; {format_digits(6e4 * summary.flow, 3)} normal liters a minute,"
        f" {format_digits(summary.supply_power, 3)} W of compression"
    )
    return f"{text}; {summary.run}" if summary.run else text


def run_cycle_of(result: SearchResult, summary: Summary) -> Summary:
    """The `summary` of the recommended design of a `result`, with its run in time if it has valves
    for a cycle, enlarged until the run passes; without JAX, with what to install.
    """
    sizing, index = summary.sizing, result.cheapest
    if sizing is None or not sizing.feasible or index is None:
        return summary
    cases, case = summary.cases, sizing.run_case
    if case is None:
        return replace(summary, run="run over time: left out, no load case does work")
    task, design = cases.task, result.all_designs(np.array([index]))
    force, stroke = float(task.force[case]), float(task.stroke_of(cases.length)[case])
    bundle = design.bundle(0, task)
    try:
        fitted, run = fit_valves(
            sizing,
            lambda time: size_for_cases(design, cases, sizing.cycle, time),
            lambda candidate: run_cycle(bundle, force, stroke, candidate),
        )
    except ModuleNotFoundError as error:  # of JAX
        missing = missing_extra(error)
        if missing is None:
            raise
        return replace(summary, run=f"run over time: left out, {missing}")
    passes, text = run.passes(sizing.cycle.time), _run_text(run, sizing)
    verdict = "passes" if passes else "FAILS"
    if case != sizing.case:
        verdict = f"{verdict} at case {case + 1}"
    return replace(
        summary, sizing=fitted, run=f"run over time: {verdict}, {text}",
        run_failure="" if passes else text,
    )  # fmt: skip


def _run_text(run: CycleRun, sizing: ValveSizing) -> str:
    """Course of a run in words, with how far it went beyond the stroke."""
    time = sizing.cycle.time
    if np.isnan(run.lifted):
        arrival = f"{pretty(run.highest, 'length', 3)} of {pretty(run.stroke, 'length', 3)}"
        return f"it contracts by {arrival} within {pretty(2 * time, 'time', 3)}"
    text = f"contracted after {pretty(run.lifted, 'time', 3)}, "
    if np.isnan(run.released):
        return f"{text}not released within {pretty(2 * time, 'time', 3)}"
    return (
        f"{text}released after {pretty(run.released, 'time', 3)}; it swings"
        f" {_percent(max(run.overshoot, 0.0))} of the stroke too far, to"
        f" {pretty(run.highest, 'length', 3)} ({_percent(LARGEST_OVERSHOOT)} allowed)"
    )


def _price_text(result: SearchResult, summary: Summary) -> str:
    catalog = result.catalog
    if summary.price is not None:
        return f"{format_digits(summary.price, 6)} {catalog.currency}, of muscles and valves"
    if summary.price_of_muscles is not None:
        return (
            f"{format_digits(summary.price_of_muscles, 6)} {catalog.currency}, of muscles; the"
            " price of a valve is unknown"
        )
    if catalog.valve is not None:
        valves = format_digits(summary.valves * catalog.valve, 6)
        return f"{valves} {catalog.currency}, of valves; the price of the muscles is unknown"
    return f"{_UNKNOWN}give [prices] valve and muscle, or a catalog"


class InfeasibleResult:
    """Search without a recommended design: the `summary` of the nearest `design`, and the `changes`
    with which it would reach the task.
    """

    def __init__(self, result: SearchResult):
        """**Arguments:** `result`: of a search that evaluated at least one design."""
        assert result.nearest is not None
        self.result, self.index = result, result.nearest
        self.summary: Summary = summarize_result(result, self.index)
        self.design = result.all_designs(np.array([self.index]))
        self.reaches = bool(result.reaches_task[self.index])
        miss, product = allowed_miss_fraction(result.limits), self.summary.product
        self.changes: list[Remedy] = (
            [] if self.reaches
            else remedies(self.design, 0, result.task, miss, result.limits, product)
        )  # fmt: skip

    @property
    def keeps(self) -> bool:
        """True if the nearest design keeps all other limits."""
        return not self._broken_limits()

    def lines(self) -> list[str]:
        """All sentences: verdict, limits, nearest design, remedies."""
        lines = [self.verdict(), *self.limit_counts(), self.nearest()]
        if self.changes:
            lines += [
                "Changes that would reach the task without scatter, each by itself:",
                *self.remedies(),
            ]
        return lines

    def verdict(self) -> str:
        """Sentence that no design is recommended."""
        result, requirement = self.result, task_requirement(self.result)
        complete, reaching = result.judged == len(result.index), int(result.reaches_task.sum())
        if result.safety is not None:
            return self._unsafe_verdict(result.safety)
        if reaching and complete:
            return (
                f"{reaching} of {result.judged} designs {requirement}, but none of them"
                " keeps all other limits: none is recommended."
            )
        limits = "" if complete or not other_limits(result.limits) else " within the other limits"
        return (
            f"No design is recommended: none of the {result.judged} evaluated designs can"
            f" {requirement}{limits}."
        )

    def _unsafe_verdict(self, safety: Safety) -> str:
        uncertainty, allowed = safety.uncertainty, int(self.result.allowed.sum())
        judged = "" if safety.complete else f" of the {safety.judged} that were judged"
        return (
            f"No design is recommended: {allowed} of {self.result.judged} designs"
            f" {task_requirement(self.result)} and keep all limits at their nominal sizes, but"
            f" none{judged} holds in {_percent(uncertainty.share)} of {uncertainty.draws} draws:"
            f" the surest in {_percent(safety.probability)}. Standard deviations:"
            f" {uncertainty.assumptions}."
            " Larger or more muscles and more pressure are surer; to accept less, write"
            f' safety = "{np.floor(100 * safety.probability):.0f} %" in [limits].'
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
        return lines + [f"{name} must not be used: {reason}." for name, reason in excluded]

    def nearest(self) -> str:
        """Sentence on the nearest design and its largest miss."""
        cases, broken = self.summary.cases, self._broken_limits()
        text = f"{composition_text(self.summary)}, {muscle_sizes(self.result, self.design, 0)}"
        limits = f" It breaks other limits: {', '.join(broken)}." if broken else ""
        if self.result.safety is not None:
            percent = _percent(self.summary.relative_margin)
            return f"The surest is {text}. Its margin at nominal sizes is {percent}."
        if self.reaches:
            return f"The nearest reaches every load case: {text}.{limits}"
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
                "A braid with a smaller angle contracts further. If your task is a stroke in mm,"
                " write stroke instead of strain: longer muscles then need less contraction."
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
        none = "no number" if muscles else "no value"
        if self._too_far(remedy):
            condition = f"at {top}" if remedy.what == "supply_pressure" else "at this pressure"
            range_ = f" up to {top}" if remedy.what == "length" else ""
            return (
                f"{label}: {none}{range_} is enough: {condition} these muscles contract by"
                f" {100 * remedy.free_strain:.3g} % at most, case {case} demands"
                f" {100 * self._strain(remedy):.3g} %."
            )
        short = pretty(remedy.short, "force")
        return f"{label}: {none} up to {top} is enough: there case {case} still misses {short}."

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
                text += f", above the {measured} up to which the tuning was measured"
            if remedy.what == "radius":
                text += ", walls in proportion"
        broken = []
        for name, number in remedy.breaks:
            limit = self.result.limits[name]
            end = limit.most if number > limit.most else limit.least
            given, bound = (format_objective(name, x) for x in (number, end))
            given = "just beyond it" if given == bound else given
            broken.append(f"{objective_label(name)} {given}, limited to {bound}")
        return f"{text}; it then breaks a limit: {', '.join(broken)}" if broken else text


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
