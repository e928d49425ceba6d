"""Words of a search: what to take and why, what it costs, what drives it; or what is missing.

The terminal and the page take the same lines and tables.
"""

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..core.findings import Finding
from ..design.answer import Answer, Remedy, extrapolations
from ..design.cycle import BAND, WIDEST_BORE, CycleRun
from ..design.designs import Designs, label
from ..design.exhaustive_search import SearchResult
from ..design.objectives import BY_WEIGHT, OBJECTIVES, allowed_miss_fraction
from ..design.scatter import Uncertainty
from ..design.summary import STANDARD_GRAVITY, Summary
from ..units import DIMENSIONS, format_digits, pretty
from .words import Part, render
from .words import words as words_of_code


MISSED = "MISSED"
_DIMENSIONS = {"m": "length", "N": "force", "J": "energy"}  # by an objective's unit
_REMEDY_DIMENSIONS = {"supply_pressure": "pressure", "braid_angle": "angle"}  # else a length
_LITER = 1e-3  # m³
_BASES = {
    "given": "given",
    "fit": "error of the fit",
    "assumed": "assumed, as the muscle isn't calibrated",
    "product": "assumed, as products have other sizes than the muscles that were fitted",
}
_LARGE = 2.0  # share from which a factor reads better than percent
_ROBUSTNESS = {
    "weaker": "muscles 10 % weaker",
    "supply": "supply 0.5 bar lower",
    "failure": "one muscle fails",
}


class Table(NamedTuple):
    """A table for readers."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    caption: str = ""


def plain_table(table: Table) -> str:
    """Lines of a table for text of one width."""
    rows = [table.heads, *table.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)
    return "\n".join(["", table.title, *lines, ""])


def format_objective(name: str, value: float) -> str:
    """Text of an objective's `value` [SI], by its `name`."""
    if name == "relative_margin":
        return percent(value)
    unit = OBJECTIVES[name].unit
    return pretty(value, _DIMENSIONS[unit]) if unit in _DIMENSIONS else format_digits(value)


def objective_label(name: str) -> str:
    """Name of an objective with spaces, such as "largest force"."""
    return name.replace("_", " ")


def percent(fraction: float) -> str:
    """Text of a fraction: in percent, from 200 % on as a factor."""
    return f"{fraction:.3g}×" if fraction >= _LARGE else f"{100 * fraction:.3g} %"


def task_requirement(result: SearchResult) -> str:
    """Words after "must": reach every load case, or miss no more than a share of them."""
    miss = allowed_miss_fraction(result.limits)
    if miss <= 0:
        return "reach every load case"
    return f"miss no more than {100 * miss:.4g} % of the load cases, by number and by weight"


def _muscle_sizes(result: SearchResult, designs: Designs, index: int) -> str:
    used = designs.counts[index] > 0
    radii = dict.fromkeys(format_digits(1e3 * r) for r in designs.radius[index][used])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[index][used])
    text = (
        f"length {pretty(designs.length[index], 'length')}, radius {', '.join(radii)} mm,"
        f" wall {', '.join(walls)} mm, braid {np.degrees(designs.angle[index, 0]):.3g}°"
    )
    names = list(designs.drawings)
    is_named = len(names) > 1 or result.catalog.products
    return f"{names[designs.kind[index]]}: {text}" if is_named else text


def _composition(summary: Summary) -> str:
    muscles = f"{summary.muscles} muscle{'s' * (summary.muscles != 1)}"
    units = f"motor units ({summary.label})" if summary.valves > 1 else "motor unit"
    return f"{muscles} in {summary.valves} {units}"


def assumptions(uncertainty: Uncertainty) -> str:
    """Standard deviations of random draws in a line."""
    scatter, covariance = uncertainty.scatter, ", constants by the calibration's covariance"
    return (
        f"length {percent(scatter.length)}, wall {percent(scatter.wall_thickness)}, braid angle"
        f" {np.degrees(scatter.braid_angle):.3g}°, all forces {percent(scatter.model_error)}"
        f" ({_BASES[uncertainty.basis]}){covariance if uncertainty.muscles is not None else ''}"
    )


def headline(answer: Answer) -> list[str]:
    """First sentences: what to take, how safe it is, and why; or that nothing is recommended."""
    result, summary, safety = answer.result, answer.summary, answer.result.safety
    design = result.all_designs(np.array([answer.index]))
    sizes = f"{_composition(summary)}, {_muscle_sizes(result, design, 0)}"
    if not answer.is_recommended:
        return [words(answer.findings[0], answer), _nearest_text(answer, sizes)]
    lines = [f"Take design {(result.recommended or 0) + 1}: {sizes}."]
    lines.append(f"margin: {_margin_text(summary)}.")
    designs = "the designs that keep all limits"
    if safety is not None:
        designs, judged = "the safe designs", safety.uncertainty
        lines.append(
            f"safety: holds in {percent(safety.probability)} of {judged.draws} draws of scatter"
            f" ({percent(judged.share)} needed); margin {percent(safety.low_margin)} at the 5th"
            f" percentile; standard deviations: {assumptions(judged)}."
        )
    objectives = ", ".join(map(objective_label, result.senses))
    reason = f"It is the best compromise of {objectives} among {designs}."
    if "cheapest" in result.offers:
        reason = f"It has the lowest price of muscles and valves of {designs}."
    return [*lines, reason]


def _nearest_text(answer: Answer, sizes: str) -> str:
    """Sentence on the nearest, or surest, design and its largest miss."""
    cases = answer.summary.cases
    if answer.findings[0].code == "design.unsafe":
        margin = percent(answer.summary.relative_margin)
        return f"The surest is {sizes}. Its margin at nominal sizes is {margin}."
    if cases.reached.all():
        return f"The nearest reaches every load case: {sizes}."
    i, missed = int(np.argmin(cases.relative)), int(np.sum(~cases.reached))
    force, strain = float(cases.largest[i]), cases.task.strain_of(cases.length)[i]
    response = f"it gives {pretty(force, 'force')}" if force > 0 else "it only pushes"
    misses = f"{missed} of {len(cases.task)} load cases, worst case {i + 1}"
    return (
        f"The nearest is {sizes}. It misses {misses if len(cases.task) > 1 else 'the load case'} by"
        f" {pretty(-cases.spare[i], 'force')}: {pretty(cases.task.force[i], 'force')} at"
        f" {100 * strain:.3g} % contraction, where {response}."
    )


def _margin_text(summary: Summary) -> str:
    cases = summary.cases
    reached = np.flatnonzero(cases.reached)
    i = int(reached[np.argmin(cases.relative[reached])])
    demanded, available, spare = (x[i] for x in (cases.task.force, cases.largest, cases.spare))
    return (
        f"{percent(summary.relative_margin)} at case {i + 1}: {pretty(demanded, 'force')} demanded,"
        f" {pretty(available, 'force')} available, {pretty(spare, 'force')} to spare"
        f" (weight of {pretty(spare / STANDARD_GRAVITY, 'mass', 3)})"
    )


def offer_names(result: SearchResult) -> dict[int, str]:
    """Names of the offers by index on the front, such as "simplest, most efficient"."""
    names: dict[int, str] = {}
    for name, index in result.offers.items():
        names[index] = f"{names[index]}, {name}" if index in names else name
    return names


def offers_table(answer: Answer) -> Table:
    """Table of what is offered, and the surest design that isn't safe; a row each."""
    result, safety = answer.result, answer.result.safety
    rows = [(int(result.front[index]), names) for index, names in offer_names(result).items()]
    note = "each offer is safe" if safety else ""
    if safety is not None and safety.nearest_unsafe is not None and rows:
        rows.append((safety.nearest_unsafe, f"unsafe: {percent(safety.nearest_share)} of draws"))
        note = "each offer but the one named unsafe is safe"
    return _designs_table(result, rows, "Offers", note)


def front_table(answer: Answer, most: int) -> Table | None:
    """Table of the Pareto front, at most so many designs; `None` if there is no choice."""
    result = answer.result
    if len(result.front) < 2:
        return None
    rows = [(int(row), str(i + 1)) for i, row in enumerate(result.front[:most])]
    count = f"{result.judged} designs"
    if result.judged == len(result.index):
        reaching, allowed = int(result.reaches_task.sum()), int(result.allowed.sum())
        count += f", {reaching} {task_requirement(result)}, {allowed} also keep all limits"
    safe = " safe" * (result.safety is not None and result.safety.holds)
    more = "; more are in the files" if len(result.front) > most else ""
    caption = f"{count}, {len(result.front)}{safe} on the front{more}"
    return _designs_table(result, rows, "Front: no other design is better in all", caption)


def _designs_table(
    result: SearchResult, rows: list[tuple[int, str]], title: str, caption: str
) -> Table:
    """Table of recorded designs, by index and name."""
    indices = np.array([row for row, _ in rows], int)
    designs, names = result.all_designs(indices), result.reported_objectives
    columns = {"design": [name for _, name in rows], "units": designs.labels}
    for name in names:
        values = result.values[name][indices].tolist()
        columns[objective_label(name)] = [format_objective(name, value) for value in values]
    price = result.catalog.price(designs)
    if np.isfinite(price).any():
        columns["price"] = [f"{value:.6g} {result.catalog.currency}" for value in price]
    columns["sizes"] = [_muscle_sizes(result, designs, i) for i in range(len(rows))]
    codes = [[x.code for x in extrapolations(result, row)] for row, _ in rows]
    if any(codes):
        quantities = [[re.split(r"[._]", code)[1] for code in row] for row in codes]
        columns["extrapolated"] = [", ".join(row) or "-" for row in quantities]
    return Table(
        title, list(columns), list(map(list, zip(*columns.values(), strict=True))), caption
    )


def splits_table(answer: Answer) -> Table | None:
    """Table of what more motor units buy and cost at the task; `None` if there is no choice."""
    splits = answer.splits
    if splits is None or len(splits.designs) < 2:
        return None
    names = [name for name in splits.values if name != "relative_margin"]
    valves, units = map(str, splits.designs.units), splits.designs.labels
    columns = [[format_objective(n, x) for x in splits.values[n].tolist()] for n in names]
    rows = list(map(list, zip(valves, units, *columns, strict=True)))
    heads = ["valves", "units", *map(objective_label, names)]
    return Table("The same muscles in more motor units, each number at its best", heads, rows)


def cases_table(summary: Summary, limit: int) -> Table:
    """Table of the load cases with the pressures that hold them: all of them, or the `limit` with
    the least to spare, in the task's order.
    """
    cases, task = summary.cases, summary.cases.task
    indices = np.arange(len(task))
    captions = [f"{int(np.sum(cases.reached))} of {len(task)} reached"] if len(task) > 1 else []
    if len(task) > limit:
        indices = np.sort(np.argsort(cases.relative)[:limit])
        captions.insert(0, f"the {limit} of {len(task)} with the least force to spare")
    if np.isfinite(summary.held_open).any():
        captions.append("held open: where the load goes if a valve stays open to the supply")
    strain, stroke = task.strain_of(cases.length), task.stroke_of(cases.length)
    rows = [
        {
            "case": str(i + 1),
            "force": pretty(task.force[i], "force"),
            "stroke": pretty(stroke[i], "length"),
            "contraction": f"{100 * strain[i]:.3g} %",
            **{f"P{u + 1}": pretty(P, "pressure") for u, P in enumerate(cases.pressures[i])},
            "available": pretty(cases.largest[i], "force"),
            "margin": percent(cases.relative[i]),
            "held open": pretty(summary.held_open[i], "length"),
            "": "reached" if cases.reached[i] else MISSED,
        }
        for i in indices.tolist()
    ]
    title = f"Load cases and pressures, {_composition(summary)}"
    return Table(title, list(rows[0]), [list(row.values()) for row in rows], "; ".join(captions))


def facts(answer: Answer) -> dict[str, str]:
    """A line of text on a design for each topic, such as its size, mass or price."""
    summary, result = answer.summary, answer.result
    cases, product, catalog = summary.cases, summary.product, result.catalog
    stroke, fluid = cases.task.stroke_of(cases.length), cases.task.fluid
    size = (
        f"stroke {pretty(stroke.max(), 'length')} of {pretty(cases.length, 'length')} at rest;"
        f" outer diameter {pretty(summary.diameter_at_rest, 'length')} at rest,"
        f" {pretty(summary.diameter, 'length')} at the largest contraction"
    )
    if summary.stretch > 0:
        size += f"; vented, the load stretches it by {pretty(summary.stretch, 'length', 3)}"
    lines = {"size": size}
    if summary.mass is not None:
        known = product is not None and product.mass is not None
        of = "muscles" if known else "bladders, without braid and fittings"
        lines["mass"] = f"{pretty(summary.mass, 'mass', 3)} of {of}"
    volume = "normal liters" if fluid == "air" else "liters"
    cycle = "from rest to a load case and back" if cases.task.time is None else "of the task"
    used = format_digits(cases.fluid_of_a_cycle / _LITER, 3)
    lines[fluid] = f"{used} {volume} for a cycle {cycle}"
    if summary.cost_of_a_cycle is not None:
        amount = format_digits(1000 * summary.cost_of_a_cycle, 3)
        lines[fluid] += f"; {amount} {catalog.currency} for 1000 cycles"
    lines |= _cycle_texts(summary, answer.run)
    if summary.price is not None:
        price = format_digits(summary.price, 6)
        lines["price"] = f"{price} {catalog.currency}, of muscles and valves"
    lines["robustness"] = "; ".join(
        f"{_ROBUSTNESS[key]}: {'margin' if value >= 0 else 'short by'} {percent(abs(value))}"
        for key, value in answer.robustness.items()
    )
    missed = ~cases.reached
    if allowed_miss_fraction(result.limits) > 0 and missed.any():
        weight = float(np.average(missed, weights=cases.task.weight))
        lines["missed"] = (
            f"{missed.sum()} of {len(cases.task)} load cases, {100 * weight:.3g} % by weight; the"
            f" task file allows {100 * result.limits[BY_WEIGHT].most:.4g} %"
        )
    gaps = {
        "mass ([design] density)": summary.mass,
        "price ([prices])": summary.price,
        f"cost of {fluid} ([prices])": summary.cost_of_a_cycle,
    }
    unknown = [name for name, value in gaps.items() if value is None]
    lines["unknown"] = ", ".join([*unknown, "life and burst pressure: no source gives them"])
    return lines


def _time_text(time: float) -> str:
    return pretty(time, "time", 3) if math.isfinite(time) else "never"


def _cycle_texts(summary: Summary, run: CycleRun | None) -> dict[str, str]:
    """Times and air of the cycle, and its run over time, in words, by topic."""
    sizing = summary.sizing
    if sizing is None or not sizing.feasible:
        return {}
    cycle = (
        f"case {sizing.case + 1} fills in {pretty(sizing.fill, 'time', 3)}, vents in"
        f" {pretty(sizing.vent, 'time', 3)}; {format_digits(6e4 * summary.flow, 3)} normal liters a"
        f" minute, {format_digits(summary.supply_power, 3)} W of compression"
    )
    if run is None or not math.isfinite(run.lifted):
        return {"cycle": cycle}
    verdict = "passes" if run.passes(sizing.cycle) else "FAILS"
    ran = (
        f"{verdict} at these pressures and such valves, without friction: lifted after"
        f" {_time_text(run.lifted)}, released after {_time_text(run.released)},"
        f" overshoot {percent(max(run.overshoot, 0.0))} ({percent(BAND)} allowed), peak force"
        f" {pretty(run.peak_force, 'force', 3)}"
    )
    return {"cycle": cycle, "run over time": ran}


def parts(answer: Answer) -> list[str]:
    """Lines on what to buy or make for the recommended design, with known prices, and sources."""
    if not answer.is_recommended:
        return []
    summary, catalog, sizing = answer.summary, answer.result.catalog, answer.summary.sizing
    design, product = answer.result.all_designs(np.array([answer.index])), summary.product

    def part(number: int, *words: str, price: float | None = None, source: str = "") -> str:
        known = price is not None and np.isfinite(price)
        prices = [f"{price:.6g} {catalog.currency} each"] if known else []
        return f"{number} × {', '.join([*words, *prices])}" + f"; figures: {source}" * bool(source)

    source = "" if product is None else product.source
    price, size = float(catalog.muscle_price(design)[0]), _muscle_sizes(answer.result, design, 0)
    lines = [part(summary.muscles, "muscle", size, price=price, source=source)]
    cases, kind = summary.cases, "on/off 3/2 valve"
    filled, below = cases.pressures > 0, cases.pressures < 0.999 * cases.task.supply_pressure
    if is_throttled := bool(np.any(filled & below)):
        kind = (
            "proportional valve or regulator (or 3/3 valve with closed center, or on/off valve and"
            " a stop)"
        )
    if sizing is None or not sizing.feasible:
        return [*lines, part(summary.valves, kind, price=catalog.valve)]
    for valve in dict.fromkeys(sizing.valves):
        units = [C for C, v in zip(sizing.conductance, sizing.valves, strict=True) if v is valve]
        flow = (
            f"C of {format_digits(1e8 * max(units), 3)} L/(s·bar) or more at b = {sizing.cycle.b:g}"
        )
        name, source = "such as no valve of the catalog has", ""
        if valve is not None:
            name, source = f"such as {valve.name} has", valve.source
            if is_throttled:
                name += f" (on/off, {valve.kind}: fits with a stop alone)"
            elif valve.kind != "3/2":
                name += f" ({valve.kind}, one outlet plugged)"
        lines.append(part(len(units), kind, flow, name, price=catalog.valve, source=source))
    if sizing.bore is not None:
        length = pretty(sizing.cycle.hose_length or 0.0, "length", 3)
        width = f"{length} long, {1e3 * sizing.bore:g} mm wide or more"
        lines.append(part(summary.valves, "hose", width))
    return lines


def remedy_lines(answer: Answer) -> list[str]:
    """Lines of a list on the levers, one for each change, below a heading; or none."""
    lines = [f"- {_remedy_text(remedy, answer)}" for remedy in answer.changes]
    return ["Changes that would make it safe, each by itself:", *lines] if lines else []


def _remedy_text(remedy: Remedy, answer: Answer) -> str:
    name, dimension = objective_label(remedy.what), _REMEDY_DIMENSIONS.get(remedy.what, "length")
    if remedy.value is None:
        is_count = remedy.what == "muscles"
        most = f"{remedy.most:.0f}" if is_count else pretty(remedy.most, dimension)
        reason = "keeps every limit" if remedy.reaches else "reaches the task"
        reason += " safely" * (answer.result.safety is not None and remedy.reaches)
        return f"{name}: no value up to {most} {reason}."
    if remedy.what == "muscles":
        counts = answer.result.all_designs(np.array([answer.index])).counts[0]
        counts = counts[counts > 0]
        counts[-1] += round(remedy.value - remedy.now)
        units = label(counts)
        return f"{name}: {remedy.value:.0f} of this size instead of {remedy.now:.0f} ({units})."
    sufficient = _rounded(remedy.value, dimension, remedy.value >= remedy.now)
    text = f"{name}: {sufficient} instead of {pretty(remedy.now, dimension)}"
    pressures = answer.result.all_designs(np.array([answer.index])).drawing(0).tuning.pressures
    is_table = remedy.what == "supply_pressure" and pressures.size > 1
    if is_table and remedy.value > pressures.max():
        measured = pretty(float(pressures.max()), dimension)
        text += f", above the {measured} up to which the tuning was measured"
    return f"{text}{', walls in proportion' * (remedy.what == 'radius')}."


def _rounded(value: float, dimension: str, up: bool) -> str:
    """Text of a sufficient value [SI]: four figures, never rounded towards too little."""
    kind = DIMENSIONS[dimension]
    size = float(kind.factors[kind.common])
    step = 10.0 ** (math.floor(math.log10(value / size)) - 3) * size
    # a round number must not become the next one
    scaled = value / step
    number = math.ceil(scaled * (1 - 1e-12)) if up else math.floor(scaled * (1 + 1e-12))
    return pretty(number * step, dimension, 4)


def _held_open(data: Mapping[str, Any]) -> str:
    cases = data["answer"].summary.cases
    stroke = pretty(float(cases.task.stroke_of(cases.length)[data["case"]]), "length", 3)
    return (
        f"an on/off valve held open lets the load of case {data['case'] + 1} go to"
        f" {pretty(data['position'], 'length', 3)} instead of {stroke}: hold the pressures, or use"
        " a stop."
    )


def _designs_can(count: int, data: Mapping[str, Any]) -> str:
    """Words for a `count` of the evaluated designs that do the task."""
    result = data["answer"].result
    can = f"{count or 'none'} of {result.judged} designs can"
    if result.judged == 1:
        can = "the design can" if count else "the design can't"
    return f"{can} {task_requirement(result)}"


_CATALOGUE: dict[str, Part] = {
    "design.unsafe": lambda data: (
        f"No design is recommended: none holds in {percent(data['demanded'])} of the draws; the"
        f" surest holds in {percent(data['share'])}. At nominal sizes"
        f" {_designs_can(data['allowed'], data)} and keep all"
        f' limits. To accept less, write safety = "{np.floor(100 * data["share"]):.0f} %"'
        " in [limits]."
    ),
    "design.out_of_reach": lambda data: f"No design is recommended: {_designs_can(0, data)}.",
    "design.limits_broken": lambda data: (
        f"No design is recommended: {_designs_can(data['reaching'], data)}, but not within all"
        " other limits."
    ),
    "design.limit_costs": lambda data: (
        f"the limit on {objective_label(data['objective'])} excludes {data['costs']} of the"
        f" {data['reaching']} designs that do the task: theirs is"
        f" {format_objective(data['objective'], data['least'])} to"
        f" {format_objective(data['objective'], data['most'])}."
    ),
    "design.small_margin": lambda data: (
        f"the margin is {percent(data['margin'])}, below {percent(data['least'])} ([limits]"
        " margin). Computed forces can be off by tens of percent: it may fail the task."
    ),
    "design.no_valve": lambda data: (
        "No design is recommended: no valve is fast enough for the best, a hose of"
        f" {pretty(data['hose_length'] or 0.0, 'length', 3)} up to {1e3 * WIDEST_BORE:g} mm wide"
        " lets too little air through. Take a shorter hose, or"
        " more time, in [cycle]."
    ),
    "design.cycle_failed": lambda data: (
        "No design is recommended: the best fails its cycle in the run over time, lifted after"
        f" {_time_text(data['lifted'])}, released after {_time_text(data['released'])}, overshoot"
        f" {percent(max(data['overshoot'], 0.0))}. Allow more time in [cycle], or damp the load."
    ),
    "design.held_open": _held_open,
}


def further_findings(answer: Answer) -> list[Finding]:
    """Findings that the headline doesn't have."""
    return answer.findings[0 if answer.is_recommended else 1 :]


def words(finding: Finding, answer: Answer) -> str:
    """A finding in words, a sentence."""
    if finding.code in _CATALOGUE:
        return render(_CATALOGUE[finding.code], {**finding.data, "answer": answer})
    return f"{words_of_code(finding)}."
