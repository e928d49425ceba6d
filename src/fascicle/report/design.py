"""The page of a search for a bundle: what to take, how to drive it, and what it costs."""

import textwrap
import warnings
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ..bundle.recruitment import overlap, workspace
from ..core.findings import Severity
from ..design.answer import Answer
from ..design.objectives import OBJECTIVES, SHARES, Limit, allowed_miss_fraction
from ..plot.theme import GRAY, SINGLE, VERMILION, new_figure, single_axes, styled
from ..plot.workspace import task as draw_task
from ..units import pretty
from . import design_summary as text
from .page import mark, picture, render


_SHOWN = 30  # designs of the front in a table: a page's length
_CASES = 60  # load cases in the table: as many as are read
_LINKS = 8  # files beside the page: a line of links
_CURVES = 7  # pressures of the force-strain space, as of `fascicle space`
_A4 = 8.27, 11.69  # inches
_SHEET_CASES = 15  # load cases on one page
_SHEET_LINE, _SHEET_LINES = 112, 58  # characters on a line of it, and lines above the pictures


def report(
    answer: Answer,
    date: str,
    files: list[str],
    seconds: float | None = None,
    notes: Sequence[str] = (),
) -> str:
    """Page of a search, as HTML.

    `date`: of the day, such as "2026-05-04"; `files`: names of those beside the page; `seconds`:
    duration of the search [s]; `notes`: on omitted products and fit errors.
    """
    result = answer.result
    cases = text.cases_table(answer.summary, _CASES)
    rows = [[*row, mark(last != text.MISSED, last, last, "fails")] for *row, last in cases.rows]
    tables = (text.splits_table(answer), text.front_table(answer, _SHOWN))
    return render(
        "design.html",
        title=f"Design: {text.objective_label(result.task.name)}",
        date=date,
        headline=text.headline(answer),
        findings=[
            (
                "note" if finding.severity is Severity.NOTE else "warning",
                text.words(finding, answer),
            )
            for finding in text.further_findings(answer)
        ],
        changes=text.remedy_lines(answer),
        offers=text.offers_table(answer) if result.offers else None,
        parts=text.parts(answer),
        cases=cases._replace(rows=rows),
        facts=[f"{name}: {fact}" for name, fact in text.facts(answer).items()],
        tables=[table for table in tables if table is not None],
        plane=picture(plane(answer)),
        trade_offs=picture(trade_offs(answer)) if len(result.front) > 1 else None,
        sketch=picture(sketch(answer)),
        notes=notes,
        terms=_terms(answer),
        files=files[:_LINKS],
        supply=pretty(result.task.supply_pressure, "pressure"),
        seconds=seconds,
        result=result,
    )


def plane(answer: Answer, ax: Axes | None = None) -> Figure:
    """Figure of the force-strain space of the design, its curves labeled with pressures, with the
    task in it.
    """
    task, cases = answer.result.task, answer.summary.cases
    design = answer.result.all_designs(np.array([answer.index]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the cases warned of a tuning's range
        space = workspace(design.bundle(0, task), levels=_CURVES)
    strain = task.strain_of(cases.length)
    return draw_task(space, overlap(space), task.force, strain, task.weight, cases.reached, ax)


@styled
def sheet(answer: Answer, date: str, notes: Sequence[str] = ()) -> Figure:
    """Figure of one page: what to take, parts, pressures and facts, and below them the sketch and
    the force-strain space; `date`, `notes`: as of `report`.
    """
    figure, axes = new_figure(1, 2, *_A4)
    figure.set_layout_engine("constrained", rect=(0.05, 0.03, 0.9, 0.27))
    sketch(answer, axes[0, 0])
    plane(answer, axes[0, 1])
    facts = (f"{name}: {fact}" for name, fact in text.facts(answer).items())
    further = (text.words(finding, answer) for finding in text.further_findings(answer))
    sentences = [*text.headline(answer), *further, *text.remedy_lines(answer)]
    cases = text.plain_table(text.cases_table(answer.summary, _SHEET_CASES))
    body = [*sentences, "", *text.parts(answer), cases, *facts, *notes]
    lines = [
        wrapped
        for line in "\n".join(body).splitlines()
        for wrapped in textwrap.wrap(line, _SHEET_LINE, subsequent_indent="  ") or [""]
    ]
    if len(lines) > _SHEET_LINES:
        lines[_SHEET_LINES - 1 :] = ["… more is in report.html"]
    task = answer.result.task
    supply, name = pretty(task.supply_pressure, "pressure"), text.objective_label(task.name)
    title = f"Design: {name}, supply {supply}, {date}"
    figure.suptitle(title, x=0.06, y=0.98, ha="left")
    figure.text(0.06, 0.955, "\n".join(lines), va="top", fontsize=7.5, family="monospace")
    return figure


@styled
def trade_offs(answer: Answer) -> Figure:
    """Figure of the front: each objective over the first one, the offers by name."""
    result = answer.result
    first, *names = result.senses
    figure, axes = new_figure(1, max(1, len(names)), width=SINGLE * max(1, len(names)))
    for ax, name in zip(axes.flat, names or [first], strict=False):
        x, y = (result.values[n][result.front] for n in (first, name))
        ax.plot(x, y, "o", color=GRAY, markersize=4)
        for index, offers in text.offer_names(result).items():
            ax.plot(x[index], y[index], "o", color=VERMILION, markersize=5)
            ax.annotate(offers, (x[index], y[index]), fontsize=6, rotation=20)
        x_label, y_label = (
            f"{text.objective_label(n)} [{OBJECTIVES[n].unit}]" for n in (first, name)
        )
        ax.set(xlabel=x_label, ylabel=y_label)
    return figure


@styled
def sketch(answer: Answer, ax: Axes | None = None) -> Figure:
    """Figure of the muscles side by side at rest, seen along the axis, with sizes; numbers are
    motor units.
    """
    summary = answer.summary
    design = answer.result.all_designs(np.array([answer.index]))
    counts, radii = design.counts[0], design.radius[0]
    figure, ax = single_axes(ax, SINGLE, SINGLE)
    outer = summary.diameter_at_rest / 2
    ax.add_patch(Circle((0, 0), outer, fill=False, linestyle="--", color=GRAY))
    largest, unit_of = float(radii.max()), np.repeat(np.arange(len(counts)), counts)
    # rings of as many as fit side by side: a sketch, not the densest packing
    ring, angle = (0.0 if len(unit_of) == 1 else outer - largest), 0.0
    for unit in unit_of:
        if angle >= 2 * np.pi * (1 - 1e-9):
            ring, angle = max(ring - 2 * largest, 0.0), 0.0
        center = (ring * np.cos(angle), ring * np.sin(angle))
        ax.add_patch(Circle(center, radii[unit], fill=False))
        ax.annotate(f"{unit + 1}", center, ha="center", va="center")
        angle += 2 * np.arcsin(min(1.0, largest / ring)) if ring > 0 else 2 * np.pi
    ax.set(xlim=(-1.1 * outer, 1.1 * outer), ylim=(-1.1 * outer, 1.1 * outer), aspect="equal")
    ax.set_axis_off()
    length, width = (pretty(x, "length") for x in (summary.cases.length, 2 * outer))
    ax.set_title(f"length {length}, diameter {width}")
    return figure


def _terms(answer: Answer) -> list[str]:
    """Sentences on the task, objectives and limits."""
    result = answer.result
    fraction = allowed_miss_fraction(result.limits)
    hint = "" if fraction else " To allow it to miss a share, write [limits] not_reached."
    terms = [f"Every design must {text.task_requirement(result)}.{hint}"]
    senses = {"min": ", less is better", "max": ", more is better", None: ", only recorded"}
    for name in dict.fromkeys([*result.reported_objectives, *(SHARES if fraction else ())]):
        limit = result.limits.get(name, Limit())
        bounds = [
            f"{word} {text.format_objective(name, bound)}"
            for word, bound in (("at least", limit.least), ("at most", limit.most))
            if np.isfinite(bound)
        ]
        limits = f"; limited to {' and '.join(bounds)}" if bounds else ""
        sense = senses[result.senses.get(name)]
        terms.append(f"`{name}`{sense}{limits}: {OBJECTIVES[name].about}.")
    return terms
