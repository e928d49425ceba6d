"""The page of a search for a bundle: the recommended design, then the cost of each choice."""

import warnings
from typing import Any

import numpy as np
from markupsafe import Markup

from ..bundle.recruitment import overlap, workspace
from ..design.exhaustive_search import SearchResult
from ..design.objectives import OBJECTIVES, SHARES, allowed_miss_fraction
from ..design.summary import Summary, summarize_result
from ..files import dumps
from ..plot.workspace import task as draw_task
from ..units import pretty
from .design_summary import (
    HEADS,
    MISSED,
    InfeasibleResult,
    case_rows,
    composition_text,
    design_facts,
    design_name,
    design_warnings,
    format_objective,
    headline,
    low_margin,
    low_margin_heads,
    muscle_sizes,
    objective_head,
    objective_label,
    summarize_search,
    task_requirement,
)
from .interactive import objective_axis, parallel_coordinates, scatter
from .page import mark, picture, render


_SHOWN = 30  # designs of the front in a table: a page's length
_CASES = 60  # load cases in the table: as many as are read
_CASES_OF_EACH = 10  # load cases of each design of the front
_LINKS = 8  # files beside the page: a line of links
_POINTS = 3000  # drawn behind the front: more make the page large
_CURVES = 7  # pressures of the force-strain space, as of `fascicle space`


def report(
    result: SearchResult,
    date: str,
    files: list[str],
    seconds: float | None = None,
    notes: tuple[str, ...] = (),
    answer: Summary | InfeasibleResult | None = None,
) -> str:
    """Page of a search, as HTML.

    **Arguments:**

    - `result`: of the search.
    - `date`: of the day, such as "2026-05-04".
    - `files`: names of the files beside the page.
    - `seconds`: duration of the search [s], or `None`.
    - `notes`: on omitted products and fit errors.
    - `answer`: of `summarize_search`; default: it is computed.
    """
    answer = summarize_search(result) if answer is None else answer
    infeasible = answer if isinstance(answer, InfeasibleResult) else None
    summary = answer.summary if isinstance(answer, InfeasibleResult) else answer
    index = infeasible.index if infeasible else result.cheapest
    assert index is not None
    rows, caption = case_rows(summary, _CASES)
    requirement, complete = task_requirement(result), result.judged == len(result.index)
    counts = f"of those that {requirement} and keep all limits, "
    if complete:
        reaching, allowed = int(result.reaches_task.sum()), int(result.allowed.sum())
        counts = f"{reaching} {requirement}, {allowed} also keep all limits; of these, "
    values: dict[str, Any] = {}
    if infeasible is None:
        facts = design_facts(result, summary)
        values |= {
            "headline": headline(result, summary),
            "warnings": design_warnings(result, summary),
            "facts": [f"{name}: {text}" for name, text in facts.items()],
        }
    if result.front.size:
        values |= {"compromise": compromise(result), **_pictures(result), **_tables(result)}
    return render(
        "design.html", title=f"Design: {objective_label(result.task.name)}", date=date,
        result=result, infeasible=infeasible, seconds=seconds, heads=HEADS, caption=caption,
        counts=counts, notes=notes, safety=result.safety,
        rows=[_mark_result(row) for row in rows],
        space=_plane(result, index, summary), files=files[:_LINKS], limit=_SHOWN,
        supply=pretty(result.task.supply_pressure, "pressure"),
        requirement=requirement, terms=_terms(result), **values,
    )  # fmt: skip


def _plane(result: SearchResult, index: int, summary: Summary) -> Any:
    """Picture of the force-strain space of a design, with the task in it."""
    task, cases = result.task, summary.cases
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the cases warned of a tuning's range
        plane = workspace(result.all_designs(np.array([index])).bundle(0, task), levels=_CURVES)
    strain = task.strain_of(cases.length)
    return picture(draw_task(plane, overlap(plane), task.force, strain, task.weight, cases.reached))


def design_text(result: SearchResult, index: int) -> str:
    """A design in a few lines, by its `index` among the reported ones."""
    designs, row = result.designs, result.front[index]
    number = int(result.index[row])
    return "\n".join([
        f"{design_name(index)}: {designs.labels[index]}"
        + (f"  (number {number} of the space)" if number >= 0 else ""),
        muscle_sizes(result, designs, index),
        *["recommended"] * (index == result.recommended),
        *["best compromise"] * (index == result.compromise),
        *(f"{objective_label(name)}: {format_objective(name, float(result.values[name][row]))}"
          for name in result.reported_objectives),
    ])  # fmt: skip


def compromise(result: SearchResult) -> list[str]:
    """Sentences on the best compromise; none if no design is safe."""
    if (index := result.compromise) is None:
        return []
    row, labels = result.front[index], result.designs.labels
    lines = [
        f"Best compromise of all objectives: {labels[index]},"
        f" {muscle_sizes(result, result.designs, index)}. On a scale from the best to the worst"
        " value on the front, no other design has a better worst objective."
    ]
    for name, sense in result.senses.items():
        front = result.values[name][result.front]
        best, value = (front.max() if sense == "max" else front.min()), result.values[name][row]
        text = f"{objective_label(name)}: {format_objective(name, float(value))}"
        if value == best:
            lines.append(f"{text}, the best on the front.")
        else:
            label = labels[int(np.flatnonzero(front == best)[0])]
            best_text = format_objective(name, float(best))
            lines.append(f"{text}; the best on the front is {best_text}, by {label}.")
    return lines


def _pictures(result: SearchResult) -> dict[str, Any]:
    """Pictures of the front: objectives against the first one, and all of them."""
    texts = [design_text(result, index) for index in range(len(result.front))]
    marks = result.recommended, result.compromise

    def scaled_axis(name: str, rows: Any) -> Any:
        return objective_axis(result.values[name][rows], name, OBJECTIVES[name].unit)

    axes = {name: scaled_axis(name, result.front) for name in result.reported_objectives}
    allowed = np.flatnonzero(result.allowed)
    allowed = allowed[:: max(1, len(allowed) // _POINTS)]
    first, *names = result.senses
    return {
        "scatters": [
            scatter(
                axes[name], axes[first], texts, marks[0],
                (scaled_axis(name, allowed).values, scaled_axis(first, allowed).values), marks[1],
            )
            for name in names or ["margin"] if name != first
        ],
        "parallel": parallel_coordinates([*axes.values()], texts, *marks)
        if len(axes) > 1 else None,
    }  # fmt: skip


def _tables(result: SearchResult) -> dict[str, Any]:
    """Tables of the front and of its scatter, and a section for each design."""
    designs, names = result.designs, result.reported_objectives
    indices = sorted({*range(min(len(result.front), _SHOWN)), result.recommended or 0})
    bold = Markup("<strong>{}</strong>").format
    tables: dict[str, Any] = {
        "front_heads": [
            "design", "muscles by unit", "sizes", *map(objective_head, names),
            *low_margin_heads(result),
        ],
        "front_rows": [
            [
                _link(index),
                (bold if index == result.recommended else str)(designs.labels[index]),
                muscle_sizes(result, designs, index),
                *(format_objective(name, float(result.values[name][result.front[index]]))
                  for name in names),
                *low_margin(result, index),
            ]
            for index in indices
        ],
        "sections": [_section(result, index) for index in indices],
    }  # fmt: skip
    if result.safety is not None:
        spread = result.safety.spread
        drawn = [name for name in result.senses if name in spread.values]
        low, high = spread.quantile(0.05), spread.quantile(0.95)
        stays = spread.front({name: result.senses[name] for name in drawn}) if drawn else None
        tables["scatter_heads"] = [
            "design",
            "units",
            "draws that meet the task",
            *map(objective_label, drawn),
            "robust",
        ]
        tables["scatter_rows"] = [
            [
                _link(index), designs.labels[index], f"{100 * spread.probability[index]:.0f} %",
                *(f"{format_objective(name, low[name][index])} to"
                  f" {format_objective(name, high[name][index])}" for name in drawn),
                "yes" if stays is None or stays[index] else "no",
            ]
            for index in indices
        ]  # fmt: skip
    return tables


def _link(index: int) -> Markup:
    """Number of a reported design, as a link to its section."""
    return Markup('<a href="#design-{0}">{0}</a>').format(index + 1)


def _section(result: SearchResult, index: int) -> dict[str, Any]:
    """Section of a reported design: name, composition, facts, load cases, and the bundle's file."""
    summary = summarize_result(result, int(result.front[index]))
    rows, caption = case_rows(summary, _CASES_OF_EACH)
    facts = design_facts(result, summary)
    return {
        "anchor": f"design-{index + 1}",
        "name": f"{design_name(index)}: {composition_text(summary)}",
        "marks": design_text(result, index).splitlines()[1:],
        "facts": [f"{name}: {text}" for name, text in facts.items()],
        "rows": [_mark_result(row) for row in rows],
        "caption": caption,
        "toml": dumps(result.designs.bundle(index, result.task)),
        "open": index == result.recommended,
    }


def _mark_result(row: list[str]) -> list[Any]:
    """Row of a load case whose last cell, reached or missed, is a mark."""
    return [*row[:-1], mark(row[-1] != MISSED, row[-1], row[-1], "fails")]


def _terms(result: SearchResult) -> list[str]:
    """Sentences on the task, objectives and limits."""
    fraction = allowed_miss_fraction(result.limits)
    hint = "" if fraction else " To allow it to miss a share, write [limits] not_reached."
    terms = [f"Every design must {task_requirement(result)}.{hint}"]
    senses = {"min": ", less is better", "max": ", more is better", None: ", only recorded"}
    for name in dict.fromkeys([*result.reported_objectives, *(n for n in SHARES if fraction)]):
        bounds = []
        if (limit := result.limits.get(name)) is not None:
            bounds = [
                f"{word} {format_objective(name, bound)}"
                for word, bound in (("at least", limit.least), ("at most", limit.most))
                if np.isfinite(bound)
            ]
        limits = f"; limited to {' and '.join(bounds)}" if bounds else ""
        sense = senses[result.senses.get(name)]
        terms.append(f"`{name}`{sense}{limits}: {OBJECTIVES[name].about}.")
    return terms
