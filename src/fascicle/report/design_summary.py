"""Words of a search: what to take and why, what it costs, what drives it; or what is missing.

The terminal and the page take the same lines and tables.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..core.findings import Finding
from ..design.answer import Answer, Remedy
from ..design.cycle import BAND, WIDEST_BORE
from ..design.designs import Designs
from ..design.exhaustive_search import SearchResult
from ..design.objectives import BY_WEIGHT, OBJECTIVES, allowed_miss_fraction
from ..design.summary import STANDARD_GRAVITY, Summary
from ..units import DIMENSIONS, format_digits, pretty


MISSED = "MISSED"
_DIMENSIONS = {"m": "length", "N": "force", "J": "energy"}  # by an objective's unit
_REMEDY_DIMENSIONS = {
    "supply_pressure": "pressure",
    "radius": "length",
    "braid_angle": "angle",
    "length": "length",
}
_LITER = 1e-3  # m³
_LARGE = 2.0  # share from which a factor reads better than percent
_ROBUSTNESS = {
    "weaker": "muscles 10 % weaker",
    "supply": "supply 0.5 bar lower",
    "failure": "one muscle fails",
}


class Table(NamedTuple):
    """A table for readers: its title, heads, rows and caption."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    caption: str = ""


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
    return text if len(names) == 1 and not result.catalog.products else f"{name}: {text}"


def task_requirement(result: SearchResult) -> str:
    """Words after "must": reach every load case, or miss no more than a share of them."""
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


def headline(answer: Answer) -> list[str]:
    """First sentences: what to take, how safe it is, and why; or that nothing is recommended."""
    result, summary = answer.result, answer.summary
    design = result.all_designs(np.array([answer.index]))
    sizes = f"{composition_text(summary)}, {muscle_sizes(result, design, 0)}"
    if not answer.is_recommended:
        return [words(answer.findings[0], answer), _nearest_text(answer, sizes)]
    lines = [f"Take design {(result.recommended or 0) + 1}: {sizes}."]
    if (safety := result.safety) is not None:
        low = np.quantile(safety.spread.values["relative_margin"][result.recommended], 0.05)
        lines.append(
            f"safety: holds in {percent(safety.probability)} of {safety.uncertainty.draws} draws of"
            f" scatter ({percent(safety.uncertainty.share)} needed); margin"
            f" {percent(low)} at the 5th percentile; standard deviations:"
            f" {safety.uncertainty.assumptions}."
        )
    objectives = ", ".join(map(objective_label, result.senses))
    designs = "the safe designs" if safety is not None else "the designs that keep all limits"
    reason = {
        "cheapest": f"It has the lowest price of muscles and valves of {designs}.",
        "compromise": f"It is the best compromise of {objectives} among {designs}.",
    }[next(iter(result.offers))]
    return [lines[0], f"margin: {_margin_text(summary)}.", *lines[1:], reason]


def _nearest_text(answer: Answer, sizes: str) -> str:
    """Sentence on the nearest, or surest, design and its largest miss."""
    cases, result = answer.summary.cases, answer.result
    if result.safety is not None:
        margin = percent(answer.summary.relative_margin)
        return f"The surest is {sizes}. Its margin at nominal sizes is {margin}."
    if cases.reached.all():
        return f"The nearest reaches every load case: {sizes}."
    i, missed = cases.worst, int(np.sum(~cases.reached))
    force = float(cases.largest[i])
    response = f"it gives {pretty(force, 'force')}" if force > 0 else "it only pushes"
    return (
        f"The nearest is {sizes}. It misses {missed} of {len(cases.task)} load cases, worst case"
        f" {i + 1} by {pretty(-float(cases.spare[i]), 'force')}:"
        f" {pretty(float(cases.task.force[i]), 'force')} at"
        f" {100 * cases.task.strain_of(cases.length)[i]:.3g} % contraction, where {response}."
    )


def _margin_text(summary: Summary) -> str:
    cases = summary.cases
    reached = np.flatnonzero(cases.reached)
    i = int(reached[np.argmin(cases.relative[reached])])
    spare = float(cases.spare[i])
    return (
        f"{percent(summary.relative_margin)} at case {i + 1}:"
        f" {pretty(float(cases.task.force[i]), 'force')} demanded,"
        f" {pretty(float(cases.largest[i]), 'force')} available, {pretty(spare, 'force')} to spare"
        f" (weight of {pretty(spare / STANDARD_GRAVITY, 'mass', 3)})"
    )


def offers_table(answer: Answer) -> Table:
    """Table of what is offered, and the surest design that isn't safe; a row each."""
    result, safety = answer.result, answer.result.safety
    roles: dict[int, list[str]] = {}
    for name, index in result.offers.items():
        roles.setdefault(int(result.front[index]), []).append(name)
    rows = [(row, ", ".join(names)) for row, names in roles.items()]
    if safety is not None and safety.nearest_unsafe is not None and rows:
        rows.append((safety.nearest_unsafe, f"unsafe: {percent(safety.nearest_share)} of draws"))
    return _designs_table(result, rows, "Offers", "each offer is safe" if safety else "")


def front_table(answer: Answer, most: int) -> Table:
    """Table of the Pareto front, at most so many designs."""
    result = answer.result
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
    designs = result.all_designs(np.array([row for row, _ in rows], int))
    price = result.catalog.price(designs)
    names = result.reported_objectives
    heads = ["design", "units", *map(objective_label, names)]
    priced = bool(np.isfinite(price).any())
    cells = [
        [
            name,
            designs.labels[i],
            *(
                format_objective(n, float(result.values[n][row]))
                for n in result.reported_objectives
            ),
            *([f"{price[i]:.6g} {result.catalog.currency}"] if priced else []),
            muscle_sizes(result, designs, i),
        ]
        for i, (row, name) in enumerate(rows)
    ]
    return Table(title, [*heads, *(["price"] * priced), "sizes"], cells, caption)


def splits_table(answer: Answer) -> Table | None:
    """Table of what more motor units buy and cost at the task; `None` if there is no choice."""
    splits = answer.splits
    if splits is None or len(splits.designs) < 2:
        return None
    names = [n for n in splits.values if n != "relative_margin"]
    rows = [
        [
            str(int(splits.designs.units[i])),
            splits.designs.labels[i],
            *(format_objective(name, float(splits.values[name][i])) for name in names),
        ]
        for i in range(len(splits.designs))
    ]
    heads = ["valves", "units", *map(objective_label, names)]
    return Table("The same muscles in more motor units, each number at its best", heads, rows)


def cases_table(summary: Summary, limit: int) -> Table:
    """Table of the load cases with the pressures that hold them: all of them, or the `limit` with
    the least to spare, in the task's order.
    """
    cases, task = summary.cases, summary.cases.task
    indices = np.arange(len(task))
    caption = f"{int(np.sum(cases.reached))} of {len(task)} reached"
    if len(task) > limit:
        indices = np.sort(np.argsort(cases.relative)[:limit])
        caption = f"the {limit} of {len(task)} with the least force to spare; {caption}"
    if np.isfinite(summary.held_open).any():
        caption += "; held open: where the load goes if a valve stays open to the supply"
    strain, stroke = task.strain_of(cases.length), task.stroke_of(cases.length)
    rows = [
        [
            str(i + 1),
            pretty(task.force[i], "force"),
            pretty(stroke[i], "length"),
            f"{100 * strain[i]:.3g} %",
            *(pretty(P, "pressure") for P in cases.pressures[i]),
            pretty(cases.largest[i], "force"),
            percent(cases.relative[i]),
            pretty(summary.held_open[i], "length"),
            "reached" if cases.reached[i] else MISSED,
        ]
        for i in indices.tolist()
    ]
    units = [f"P{unit + 1}" for unit in range(cases.pressures.shape[1])]
    ends = ["available", "margin", "held open", ""]
    title = f"Load cases and pressures, {composition_text(summary)}"
    return Table(title, ["case", "force", "stroke", "contraction", *units, *ends], rows, caption)


def facts(answer: Answer) -> dict[str, str]:
    """Facts on a design besides its load cases, by topic."""
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
    if product is not None:
        source = f"; figures: {product.source}" if product.source else ""
        design = result.all_designs(np.array([answer.index]))
        name = list(design.drawings)[int(design.kind[0])]
        if not name.startswith(product.name):  # a file's drawings have the nominal length
            name = f"{product.name}, {pretty(cases.length, 'length')}"
        lines["product"] = f"{summary.muscles} × {name}{source}"
    if summary.mass is not None:
        whole = product is not None and product.mass is not None
        of = "muscles" if whole else "bladders, without braid and fittings"
        lines["mass"] = f"{pretty(summary.mass, 'mass', 3)} of {of}"
    volume = "normal liters" if fluid == "air" else "liters"
    cost = ""
    if summary.cost_of_a_cycle is not None:
        amount = format_digits(1000 * summary.cost_of_a_cycle, 3)
        cost = f"; {amount} {catalog.currency} for 1000 cycles"
    cycle = "from rest to a load case and back" if cases.task.time is None else "of the task"
    used = format_digits(cases.fluid_of_a_cycle / _LITER, 3)
    lines[fluid] = f"{used} {volume} for a cycle {cycle}{cost}"
    lines["valves"] = _valves_text(answer)
    if summary.price is not None:
        price = format_digits(summary.price, 6)
        lines["price"] = f"{price} {catalog.currency}, of muscles and valves"
    margins = (
        f"{_ROBUSTNESS[key]}: "
        + (f"margin {percent(value)}" if value >= 0 else f"short by {percent(-value)}")
        for key, value in answer.robustness.items()
    )
    lines["robustness"] = "; ".join(margins)
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


def _valves_text(answer: Answer) -> str:
    """Valves that hold the pressures, and valves and hoses for the cycle, in words."""
    summary = answer.summary
    sizing = summary.sizing
    partial = np.any(
        (summary.cases.pressures > 0)
        & (summary.cases.pressures < 0.999 * summary.cases.task.supply_pressure)
    )
    kind = "a proportional valve or regulator" if partial else "an on/off 3/2 valve"
    text = f"{kind} for each motor unit"
    if partial:
        text += " (or a 3/3 valve with closed center, or an on/off valve and a stop)"
    if sizing is None or not sizing.feasible:
        return text
    conductances = dict.fromkeys(format_digits(1e8 * C, 3) for C in sizing.conductance)
    names = dict.fromkeys(v.name if v else "none of the catalog" for v in sizing.valves)
    text += (
        f"; C of {', '.join(conductances)} L/(s·bar) at b = {sizing.cycle.b:g}, smallest verified:"
        f" {', '.join(names)}; case {sizing.case + 1} fills in {pretty(sizing.fill, 'time', 3)},"
        f" vents in {pretty(sizing.vent, 'time', 3)}"
    )
    if sizing.bore is not None:
        text += f"; hoses at least {1e3 * sizing.bore:g} mm wide"
    text += (
        f"; {format_digits(6e4 * summary.flow, 3)} normal liters a minute,"
        f" {format_digits(summary.supply_power, 3)} W of compression"
    )
    if (run := answer.run) is not None and math.isfinite(run.lifted):
        force = summary.cases.task.force[sizing.run_case]
        # of the smoothest way up: half a wave of the load's position
        peak = force * (1 + np.pi**2 * run.stroke / 2 / sizing.cycle.lift**2 / STANDARD_GRAVITY)
        verdict = "passes" if run.passes(sizing.cycle) else "FAILS"
        text += (
            f"; run over time at these pressures: {verdict}, lifted after"
            f" {pretty(run.lifted, 'time', 3)}, released after {pretty(run.released, 'time', 3)},"
            f" overshoot {percent(max(run.overshoot, 0.0))} ({percent(BAND)} allowed); peak force"
            f" with acceleration {pretty(float(peak), 'force', 3)}"
        )
    return text


def remedy_lines(answer: Answer) -> list[str]:
    """Sentences on the levers, one for each change."""
    return [_remedy_text(remedy, answer) for remedy in answer.changes]


def _remedy_text(remedy: Remedy, answer: Answer) -> str:
    label, safe = objective_label(remedy.what), answer.result.safety is not None
    dimension = _REMEDY_DIMENSIONS.get(remedy.what, "")
    most = pretty(remedy.most, dimension) if dimension else f"{remedy.most:.0f}"
    if remedy.value is None:
        reason = "reaches the task" if not remedy.reaches else "keeps every limit"
        reason += " safely" if safe and remedy.reaches else ""
        return f"{label}: no value up to {most} {reason}."
    if remedy.what == "muscles":
        *counts, last = [
            int(n) for n in answer.result.all_designs(np.array([answer.index])).counts[0] if n
        ]
        units = "+".join(str(n) for n in [*counts, last + round(remedy.value - remedy.now)])
        return f"{label}: {remedy.value:.0f} of this size instead of {remedy.now:.0f} ({units})."
    up = remedy.value >= remedy.now
    text = f"{_rounded(remedy.value, dimension, up)} instead of {pretty(remedy.now, dimension)}"
    if remedy.what == "supply_pressure" and remedy.value > remedy.measured:
        measured = pretty(remedy.measured, dimension)
        text += f", above the {measured} up to which the tuning was measured"
    return f"{label}: {text}{', walls in proportion' * (remedy.what == 'radius')}."


def _rounded(value: float, dimension: str, up: bool) -> str:
    """Text of a sufficient value [SI]: four figures, never rounded towards too little."""
    kind = DIMENSIONS[dimension]
    size = float(kind.factors[kind.common])
    decimals = 3 - math.floor(math.log10(value / size))
    # a round number must not become the next one
    scaled = value / size * 10.0**decimals
    number = math.ceil(scaled * (1 - 1e-12)) if up else math.floor(scaled * (1 + 1e-12))
    return pretty(number / 10.0**decimals * size, dimension, 4)


Data = Mapping[str, Any]


def _unsafe(data: Data, answer: Answer) -> str:
    return (
        f"No design is recommended: {data['allowed']} of {answer.result.judged} designs"
        f" {task_requirement(answer.result)} and keep all limits at their nominal sizes, but none"
        f" holds in {percent(data['demanded'])} of the draws: the surest in"
        f" {percent(data['share'])}. To accept less, write"
        f' safety = "{np.floor(100 * data["share"]):.0f} %" in [limits].'
    )


def _out_of_reach(_: Data, answer: Answer) -> str:
    return (
        f"No design is recommended: none of the {answer.result.judged} evaluated designs can"
        f" {task_requirement(answer.result)}."
    )


def _limits_broken(data: Data, answer: Answer) -> str:
    return (
        f"{data['reaching']} of {answer.result.judged} designs {task_requirement(answer.result)},"
        " but none of them keeps all other limits: none is recommended."
    )


def _limit_costs(data: Data, _: Answer) -> str:
    name = data["objective"]
    low, high = (format_objective(name, data[key]) for key in ("least", "most"))
    return (
        f"{objective_label(name)}: {data['keeping']} designs keep its limit; all lie between {low}"
        f" and {high}."
    )


def _small_margin(data: Data, _: Answer) -> str:
    return (
        f"the margin is {percent(data['margin'])}, below {percent(data['least'])} ([limits]"
        " margin). Computed forces can be off by tens of percent: it may fail the task."
    )


def _no_valve(data: Data, _: Answer) -> str:
    hose = pretty(data["hose_length"] or 0.0, "length", 3)
    return (
        f"no valve is fast enough: a hose of {hose} up to {1e3 * WIDEST_BORE:g} mm wide lets too"
        " little air through. Take a shorter hose, or more time, in [cycle]."
    )


def _held_open(data: Data, answer: Answer) -> str:
    cases = answer.summary.cases
    stroke = pretty(float(cases.task.stroke_of(cases.length)[data["case"]]), "length", 3)
    return (
        f"an on/off valve held open lets the load of case {data['case'] + 1} go to"
        f" {pretty(data['position'], 'length', 3)} instead of {stroke}: hold the pressures, or use"
        " a stop."
    )


_CATALOGUE: dict[str, Callable[[Data, Answer], str]] = {
    "design.unsafe": _unsafe,
    "design.out_of_reach": _out_of_reach,
    "design.limits_broken": _limits_broken,
    "design.limit_costs": _limit_costs,
    "design.product_excluded": lambda d, _: f"{d['product']} must not be used: {d['reason']}.",
    "design.small_margin": _small_margin,
    "design.no_valve": _no_valve,
    "design.cycle_failed": lambda *_: (
        "it fails its cycle in the run over time. Allow more time in [cycle], or damp the load."
    ),
    "design.judged_in_part": lambda d, _: f"only {d['judged']} designs were judged in draws.",
    "design.held_open": _held_open,
}


def words(finding: Finding, answer: Answer) -> str:
    """A finding in words."""
    return _CATALOGUE[finding.code](finding.data, answer)
