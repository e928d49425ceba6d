"""The page of a search for a bundle: does it do the task, then what each choice costs."""

import warnings
from html import escape

import numpy as np

from ..bundle.workspace import overlap, space
from ..design.exhaustive_search import SearchResult
from ..design.objectives import OBJECTIVES, SHARES, allowed_miss_fraction
from ..design.robust import Spread
from ..design.summary import Summary
from ..files import dumps
from ..plot.theme import to_bytes
from ..plot.workspace import task as draw_task
from ..units import pretty
from .design_summary import (
    HEADS,
    MISSED,
    InfeasibleResult,
    case_rows,
    design_facts,
    format_objective,
    headline,
    margin_warning,
    muscle_sizes,
    objective_label,
    summarize_search,
    task_requirement,
)
from .interactive import SCRIPT, STYLE, Axis, parallel, scaled, scatter
from .page import Page


_INCH = 0.0254  # m
_SHOWN = 30  # designs of the front in the table
_CASES = 60  # load cases in the table
_LINKED = 8  # files beside the page
_OTHERS = 3000  # points drawn behind the front
_CURVES = 7  # of the plane


def report(
    result: SearchResult,
    date: str,
    files: list[str],
    seconds: float | None = None,
    sure: Spread | None = None,
    notes: tuple[str, ...] = (),
    answered: Summary | InfeasibleResult | None = None,
) -> str:
    """The page.

    **Arguments:**

    - `result`: by the search [-].
    - `date`: of the day [-], such as "2026-05-04".
    - `files`: written beside the page [-].
    - `seconds`: that the search took [s], if known.
    - `sure`: how the front's designs come out [-], if that was asked.
    - `notes`: on what the search left out [-].
    - `answered`: what `answer` says of it [-]; left out, it is asked.

    **Returns:** the page as HTML [-].
    """
    task = result.task
    page = Page(f"Which bundle: {objective_label(task.name)}")
    page.html(STYLE)
    answered = summarize_search(result) if answered is None else answered
    if isinstance(answered, InfeasibleResult):
        _unreached(page, answered)
    else:
        _recommended(page, result, answered)
    took = "" if seconds is None else f" in {seconds:.1f} s"
    kept = "."
    if result.cheapest is not None:
        kept = f"; {_kept(result)}{len(result.front)} are bettered by no other."
    page.paragraph(f"{result.judged} designs were judged at {len(task)} load cases{took}{kept}")
    origin = task.source or "not said"
    page.paragraph(
        f"The task's figures: {origin}. Supply {pretty(task.supply_pressure, 'pressure')},"
        f" {task.scheme} recruitment."
    )
    page.points(notes)
    page.files(files if len(files) <= _LINKED else files[:_LINKED])
    if result.cheapest is not None:
        texts = [design_text(result, index) for index in range(len(result.reported))]
        _compromise(page, result)
        _front(page, result, texts)
        if sure is not None:
            _sure(page, result, sure)
        _table(page, result)
        _files(page, result)
    _terms(page, result)
    page.html(SCRIPT)
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")


def design_text(result: SearchResult, index: int) -> str:
    """A design in a few lines; `result` [-], its `index` among those that are told [-]."""
    designs = result.designs
    lines = [
        f"{designs.labels[index]}{_number(int(result.index[result.reported[index]]))}",
        muscle_sizes(result, designs, index),
        *["recommended"] * (index == result.recommended),
        *["best compromise"] * (index == result.compromise),
    ]
    row = result.reported[index]
    lines += [
        f"{objective_label(name)}: {format_objective(name, float(result.values[name][row]))}"
        for name in result.reported_objectives
    ]
    return "\n".join(lines)


def compromise(result: SearchResult) -> list[str]:
    """The front's best compromise, in sentences; `result` [-] isn't empty."""
    index = result.compromise
    assert index is not None
    row = result.front[index]
    lines = [
        f"Best compromise of the objectives: {result.designs.labels[index]},"
        f" {muscle_sizes(result, result.designs, index)}. Of the designs that no other betters it"
        " is the one whose worst objective is least bad, each counted from the best to the worst on"
        " the front."
    ]
    for name, sense in result.senses.items():
        on_front = result.values[name][result.front]
        best = on_front.max() if sense == "max" else on_front.min()
        own = result.values[name][row]
        text = f"{objective_label(name)}: {format_objective(name, float(own))}"
        if own == best:
            lines.append(f"{text}, the best there is on the front.")
            continue
        where = int(np.flatnonzero(on_front == best)[0])
        lines.append(
            f"{text}; the best on the front is {format_objective(name, float(best))}, by"
            f" {result.designs.labels[where]}."
        )
    return lines


def _number(index: int) -> str:
    return f"  (design {index})" if index >= 0 else ""


def _kept(result: SearchResult) -> str:
    """How many keep the limits, where all were kept that were judged."""
    if result.judged > len(result.index):
        return f"of those that {task_requirement(result)} and keep all limits "
    reach, keep = int(result.reaches_task.sum()), int(result.allowed.sum())
    return f"{reach} {task_requirement(result)}, {keep} keep all limits too, of which "


def _recommended(page: Page, result: SearchResult, summary: Summary) -> None:
    take, margin, *why = headline(result, summary)
    page.paragraph(take, "lead")
    page.paragraph(f"{margin[0].upper()}{margin[1:]}")
    if warning := margin_warning(result, summary):
        page.paragraph(f"Warning: {warning}", "warning")
    for sentence in why:
        page.paragraph(sentence)
    page.heading("Does it do the task?", "cases")
    _cases(page, summary)
    page.points(f"{name}: {text}" for name, text in design_facts(result, summary).items())
    page.paragraph(
        "All of this holds for muscles as drawn; [scatter] in the task file tells how sure it is"
        " for muscles as they come out.",
        "note",
    )
    assert result.cheapest is not None
    _plane(page, result, result.cheapest, summary)


def _unreached(page: Page, none: InfeasibleResult) -> None:
    page.paragraph(none.verdict(), "lead")
    page.points(none.limit_counts())
    page.heading("The nearest design", "nearest")
    page.paragraph(none.nearest())
    _cases(page, none.summary)
    if none.changes:
        page.heading("What would reach it, each by itself", "remedies")
        page.points(none.remedies())
    _plane(page, none.result, none.index, none.summary)


def _cases(page: Page, summary: Summary) -> None:
    rows, caption = case_rows(summary, _CASES)
    marked = [[*map(escape, row[:-1]), _mark(row[-1])] for row in rows]
    page.table(HEADS, marked)
    page.paragraph(f"{caption[0].upper()}{caption[1:]}.", "note")


def _mark(verdict: str) -> str:
    kind, sign = ("fails", "✗") if verdict == MISSED else ("holds", "✓")
    return f'<span class="{kind}">{sign}\u00a0{verdict}</span>'


def _compromise(page: Page, result: SearchResult) -> None:
    page.heading("By the objectives", "compromise")
    first, *others = compromise(result)
    page.paragraph(first)
    page.points(others)


def _front(page: Page, result: SearchResult, texts: list[str]) -> None:
    page.heading("What each choice costs", "front")
    listed = {name: result.values[name][result.reported] for name in result.reported_objectives}
    axes = {name: scaled(listed, name, OBJECTIVES[name].unit) for name in listed}
    names, chosen, second = list(result.senses), result.recommended, result.compromise
    first = axes[names[0]]
    rest = np.flatnonzero(result.allowed)
    rest = rest[:: max(1, len(rest) // _OTHERS)]
    for name in names[1:] or ["margin"]:
        if name == names[0]:
            continue
        x, y = (
            scaled({key: result.values[key][rest]}, key, OBJECTIVES[key].unit).values
            for key in (name, names[0])
        )
        page.html(f"<figure>{scatter(axes[name], first, texts, chosen, (x, y), second)}</figure>")
    page.paragraph(
        "Dots: designs of the front, and the recommended one, in orange; the best compromise has a"
        " dark rim. Gray: other designs within the limits. With the mouse on a dot or line its"
        " design is told, and marked in every picture.",
        "note",
    )
    if len(axes) > 1:
        page.heading("All objectives of the front", "parallel", 3)
        every: list[Axis] = list(axes.values())
        page.html(f"<figure>{parallel(every, texts, chosen, second)}</figure>")


def _plane(page: Page, result: SearchResult, index: int, summary: Summary) -> None:
    """The force-strain space of a kept design, with the task in it."""
    page.heading("The bundle's forces and the task", "space")
    task, cases = result.task, summary.cases
    bundle = result.all_designs(np.array([index])).bundle(0, task)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a tuning's range was told with the cases
        plane = space(bundle, levels=_CURVES)
    figure = draw_task(
        plane, overlap(plane), task.force, task.strain_of(cases.length), task.weight, cases.reached
    )
    title = "Force-strain space and the points demanded"
    page.picture(to_bytes(figure, "svg"), "svg", title, figure.get_figwidth() * _INCH)


def _sure(page: Page, result: SearchResult, sure: Spread) -> None:
    page.heading("How sure", "sure")
    draws = sure.met.shape[1]
    page.paragraph(
        f"Each design in {draws} draws of what no two muscles have alike: the share of draws that"
        f" {task_requirement(result)} and keep all limits. Objectives: 5 % to 95 % of the draws."
    )
    low, high = sure.quantile(0.05), sure.quantile(0.95)
    stays = sure.front(result.senses)
    names = list(result.senses)
    heads = ["", "units", "meets the task", *(n.replace("_", " ") for n in names), "still on"]
    rows = [
        [
            str(index + 1),
            result.designs.labels[index],
            f"{100 * sure.probability[index]:.0f} %",
            *(
                escape(
                    " to ".join(format_objective(n, float(ends[n][index])) for ends in (low, high))
                )
                for n in names
            ),
            "yes" if stays[index] else "no",
        ]
        for index in range(min(len(sure.met), _SHOWN))
    ]
    page.table(heads, rows)
    page.paragraph(
        "Still on: no other betters what nine in ten draws do at least as well as.", "note"
    )


def _table(page: Page, result: SearchResult) -> None:
    page.heading("The front", "table")
    designs = result.designs
    heads = ["", "units", "muscles", *map(objective_label, result.reported_objectives)]
    some = [*range(min(len(result.front), _SHOWN)), result.recommended]
    rows = [
        [
            str(index + 1),
            f"<strong>{designs.labels[index]}</strong>"
            if index == result.recommended
            else designs.labels[index],
            escape(muscle_sizes(result, designs, index)),
            *(
                escape(format_objective(n, float(result.values[n][result.reported[index]])))
                for n in result.reported_objectives
            ),
        ]
        for index in sorted({index for index in some if index is not None})
    ]
    page.table(heads, rows)
    beside = "" if result.cheapest in result.front else ", and isn't on the front"
    page.paragraph(f"The recommended design is set in bold{beside}.", "note")
    if len(result.front) > _SHOWN:
        page.paragraph(f"The first {_SHOWN} of {len(result.front)}; all are in the files.", "note")


def _files(page: Page, result: SearchResult) -> None:
    page.heading("Bundles as files", "toml")
    designs = result.designs
    for index in sorted({*range(min(len(designs), _SHOWN)), result.recommended or 0}):
        text = dumps(designs.bundle(index, result.task))
        state = " open" if index == result.recommended else ""
        page.html(
            f"<details{state}><summary>{index + 1}: {escape(designs.labels[index])}</summary>"
            f"<pre><code>{escape(text)}</code></pre></details>"
        )


def _terms(page: Page, result: SearchResult) -> None:
    page.heading("What is judged", "terms")
    share = allowed_miss_fraction(result.limits)
    points = [
        f"Every design must {task_requirement(result)}."
        + ("" if share else " A share that may be missed would be said in [limits] not_reached.")
    ]
    for name in dict.fromkeys([*result.reported_objectives, *(n for n in SHARES if share)]):
        one = OBJECTIVES[name]
        sense = {"min": ", less is better", "max": ", more is better"}
        wanted = sense[result.senses[name]] if name in result.senses else ", only recorded"
        limit = result.limits.get(name)
        bounds = []
        if limit is not None and np.isfinite(limit.least):
            bounds.append(f"at least {format_objective(name, limit.least)}")
        if limit is not None and np.isfinite(limit.most):
            bounds.append(f"at most {format_objective(name, limit.most)}")
        kept = f"; limited to {' and '.join(bounds)}" if bounds else ""
        points.append(f"`{name}`{wanted}{kept}: {one.about}.")
    page.points(points)
