"""The page of a search for a bundle: does it do the task, then what each choice costs."""

import warnings
from html import escape

import numpy as np

from ..bundle.space import overlap, space
from ..design.exhaustive_search import SearchResult
from ..design.objectives import OBJECTIVES, SHARES, allowed_miss_fraction
from ..design.robust import Spread
from ..design.summary import Summary
from ..files import dumps
from ..plot.style import to_bytes
from ..plot.workspace import task as draw_task
from ..units import pretty
from .engineering import (
    HEADS,
    MISSED,
    case_rows,
    demand,
    facts,
    headline,
    margin_warning,
    shown,
    sizes,
    words,
)
from .interactive import SCRIPT, STYLE, Axis, parallel, scaled, scatter
from .page import Page
from .unreached import Unreached, answer


_INCH = 0.0254  # m
_SHOWN = 30  # designs of the front in the table
_CASES = 60  # load cases in the table
_LINKED = 8  # files beside the page
_OTHERS = 3000  # points drawn behind the front
_CURVES = 7  # of the plane


def report(
    found: SearchResult,
    date: str,
    files: list[str],
    seconds: float | None = None,
    sure: Spread | None = None,
    notes: tuple[str, ...] = (),
    answered: Summary | Unreached | None = None,
) -> str:
    """The page.

    **Arguments:**

    - `found`: by the search [-].
    - `date`: of the day [-], such as "2026-05-04".
    - `files`: written beside the page [-].
    - `seconds`: that the search took [s], if known.
    - `sure`: how the front's designs come out [-], if that was asked.
    - `notes`: on what the search left out [-].
    - `answered`: what `answer` says of it [-]; left out, it is asked.

    **Returns:** the page as HTML [-].
    """
    task = found.task
    page = Page(f"Which bundle: {words(task.name)}")
    page.html(STYLE)
    answered = answer(found) if answered is None else answered
    if isinstance(answered, Unreached):
        _unreached(page, answered)
    else:
        _recommended(page, found, answered)
    took = "" if seconds is None else f" in {seconds:.1f} s"
    kept = "."
    if found.cheapest is not None:
        kept = f"; {_kept(found)}{len(found.front)} are bettered by no other."
    page.paragraph(f"{found.judged} designs were judged at {len(task)} load cases{took}{kept}")
    origin = task.source or "not said"
    page.paragraph(
        f"The task's figures: {origin}. Supply {pretty(task.supply_pressure, 'pressure')},"
        f" {task.scheme} recruitment."
    )
    page.points(notes)
    page.files(files if len(files) <= _LINKED else files[:_LINKED])
    if found.cheapest is not None:
        texts = [told(found, place) for place in range(len(found.reported))]
        _compromise(page, found)
        _front(page, found, texts)
        if sure is not None:
            _sure(page, found, sure)
        _table(page, found)
        _files(page, found)
    _terms(page, found)
    page.html(SCRIPT)
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")


def told(found: SearchResult, place: int) -> str:
    """A design in a few lines; `found` [-], its `place` among those that are told [-]."""
    designs = found.designs
    lines = [
        f"{designs.labels[place]}{_number(int(found.index[found.reported[place]]))}",
        sizes(found, designs, place),
        *["recommended"] * (place == found.recommended),
        *["best compromise"] * (place == found.compromise),
    ]
    lines += [
        f"{words(name)}: {shown(name, float(found.values[name][found.reported[place]]))}"
        for name in found.reported_objectives
    ]
    return "\n".join(lines)


def compromise(found: SearchResult) -> list[str]:
    """The front's best compromise, in sentences; `found` [-] isn't empty."""
    place = found.compromise
    assert place is not None
    row = found.front[place]
    lines = [
        f"Best compromise of the objectives: {found.designs.labels[place]},"
        f" {sizes(found, found.designs, place)}. Of the designs that no other betters it is the one"
        " whose worst objective is least bad, each counted from the best to the worst on the front."
    ]
    for name, sense in found.senses.items():
        on_front = found.values[name][found.front]
        best = on_front.max() if sense == "max" else on_front.min()
        own = found.values[name][row]
        text = f"{words(name)}: {shown(name, float(own))}"
        if own == best:
            lines.append(f"{text}, the best there is on the front.")
            continue
        where = int(np.flatnonzero(on_front == best)[0])
        lines.append(
            f"{text}; the best on the front is {shown(name, float(best))}, by"
            f" {found.designs.labels[where]}."
        )
    return lines


def _number(index: int) -> str:
    return f"  (design {index})" if index >= 0 else ""


def _kept(found: SearchResult) -> str:
    """How many keep the limits, where all were kept that were judged."""
    if found.judged > len(found.index):
        return f"of those that {demand(found)} and keep all limits "
    reach, keep = int(found.reaches_task.sum()), int(found.allowed.sum())
    return f"{reach} {demand(found)}, {keep} keep all limits too, of which "


def _recommended(page: Page, found: SearchResult, summary: Summary) -> None:
    take, margin, *why = headline(found, summary)
    page.paragraph(take, "lead")
    page.paragraph(f"{margin[0].upper()}{margin[1:]}")
    if warning := margin_warning(found, summary):
        page.paragraph(f"Warning: {warning}", "warning")
    for sentence in why:
        page.paragraph(sentence)
    page.heading("Does it do the task?", "cases")
    _cases(page, summary)
    page.points(f"{name}: {text}" for name, text in facts(found, summary).items())
    page.paragraph(
        "All of this holds for muscles as drawn; [scatter] in the task file tells how sure it is"
        " for muscles as they come out.",
        "note",
    )
    assert found.cheapest is not None
    _plane(page, found, found.cheapest, summary)


def _unreached(page: Page, none: Unreached) -> None:
    page.paragraph(none.verdict(), "lead")
    page.points(none.left())
    page.heading("The nearest design", "nearest")
    page.paragraph(none.nearest())
    _cases(page, none.summary)
    if none.ways:
        page.heading("What would reach it, each by itself", "remedies")
        page.points(none.remedies())
    _plane(page, none.found, none.place, none.summary)


def _cases(page: Page, summary: Summary) -> None:
    rows, caption = case_rows(summary, _CASES)
    marked = [[*map(escape, row[:-1]), _mark(row[-1])] for row in rows]
    page.table(HEADS, marked)
    page.paragraph(f"{caption[0].upper()}{caption[1:]}.", "note")


def _mark(verdict: str) -> str:
    kind, sign = ("fails", "✗") if verdict == MISSED else ("holds", "✓")
    return f'<span class="{kind}">{sign}\u00a0{verdict}</span>'


def _compromise(page: Page, found: SearchResult) -> None:
    page.heading("By the objectives", "compromise")
    first, *others = compromise(found)
    page.paragraph(first)
    page.points(others)


def _front(page: Page, found: SearchResult, texts: list[str]) -> None:
    page.heading("What each choice costs", "front")
    listed = {name: found.values[name][found.reported] for name in found.reported_objectives}
    axes = {name: scaled(listed, name, OBJECTIVES[name].unit) for name in listed}
    names, chosen, second = list(found.senses), found.recommended, found.compromise
    first = axes[names[0]]
    rest = np.flatnonzero(found.allowed)
    rest = rest[:: max(1, len(rest) // _OTHERS)]
    for name in names[1:] or ["margin"]:
        if name == names[0]:
            continue
        x, y = (
            scaled({key: found.values[key][rest]}, key, OBJECTIVES[key].unit).values
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


def _plane(page: Page, found: SearchResult, place: int, summary: Summary) -> None:
    """The force-strain space of a kept design, with the task in it."""
    page.heading("The bundle's forces and the task", "space")
    task, cases = found.task, summary.cases
    bundle = found.all_designs(np.array([place])).bundle(0, task)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a tuning's range was told with the cases
        plane = space(bundle, levels=_CURVES)
    figure = draw_task(
        plane, overlap(plane), task.force, task.strain_of(cases.length), task.weight, cases.reached
    )
    title = "Force-strain space and the points demanded"
    page.picture(to_bytes(figure, "svg"), "svg", title, figure.get_figwidth() * _INCH)


def _sure(page: Page, found: SearchResult, sure: Spread) -> None:
    page.heading("How sure", "sure")
    draws = sure.met.shape[1]
    page.paragraph(
        f"Each design in {draws} draws of what no two muscles have alike: the share of draws that"
        f" {demand(found)} and keep all limits. Objectives: 5 % to 95 % of the draws."
    )
    low, high = sure.quantile(0.05), sure.quantile(0.95)
    stays = sure.front(found.senses)
    names = list(found.senses)
    heads = ["", "units", "meets the task", *(n.replace("_", " ") for n in names), "still on"]
    rows = [
        [
            str(place + 1),
            found.designs.labels[place],
            f"{100 * sure.probability[place]:.0f} %",
            *(
                escape(f"{shown(n, float(low[n][place]))} to {shown(n, float(high[n][place]))}")
                for n in names
            ),
            "yes" if stays[place] else "no",
        ]
        for place in range(min(len(sure.met), _SHOWN))
    ]
    page.table(heads, rows)
    page.paragraph(
        "Still on: no other betters what nine in ten draws do at least as well as.", "note"
    )


def _table(page: Page, found: SearchResult) -> None:
    page.heading("The front", "table")
    designs = found.designs
    heads = ["", "units", "muscles", *map(words, found.reported_objectives)]
    some = [*range(min(len(found.front), _SHOWN)), found.recommended]
    rows = [
        [
            str(place + 1),
            f"<strong>{designs.labels[place]}</strong>"
            if place == found.recommended
            else designs.labels[place],
            escape(sizes(found, designs, place)),
            *(
                escape(shown(n, float(found.values[n][found.reported[place]])))
                for n in found.reported_objectives
            ),
        ]
        for place in sorted({place for place in some if place is not None})
    ]
    page.table(heads, rows)
    beside = "" if found.cheapest in found.front else ", and isn't on the front"
    page.paragraph(f"The recommended design is set in bold{beside}.", "note")
    if len(found.front) > _SHOWN:
        page.paragraph(f"The first {_SHOWN} of {len(found.front)}; all are in the files.", "note")


def _files(page: Page, found: SearchResult) -> None:
    page.heading("Bundles as files", "toml")
    designs = found.designs
    for place in sorted({*range(min(len(designs), _SHOWN)), found.recommended or 0}):
        text = dumps(designs.bundle(place, found.task))
        state = " open" if place == found.recommended else ""
        page.html(
            f"<details{state}><summary>{place + 1}: {escape(designs.labels[place])}</summary>"
            f"<pre><code>{escape(text)}</code></pre></details>"
        )


def _terms(page: Page, found: SearchResult) -> None:
    page.heading("What is judged", "terms")
    share = allowed_miss_fraction(found.limits)
    points = [
        f"Every design must {demand(found)}."
        + ("" if share else " A share that may be missed would be said in [limits] not_reached.")
    ]
    for name in dict.fromkeys([*found.reported_objectives, *(n for n in SHARES if share)]):
        one = OBJECTIVES[name]
        sense = {"min": ", less is better", "max": ", more is better"}
        wanted = sense[found.senses[name]] if name in found.senses else ", only recorded"
        limit = found.limits.get(name)
        bounds = []
        if limit is not None and np.isfinite(limit.least):
            bounds.append(f"at least {shown(name, limit.least)}")
        if limit is not None and np.isfinite(limit.most):
            bounds.append(f"at most {shown(name, limit.most)}")
        kept = f"; limited to {' and '.join(bounds)}" if bounds else ""
        points.append(f"`{name}`{wanted}{kept}: {one.about}.")
    page.points(points)
