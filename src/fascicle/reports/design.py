"""The page of a search for a bundle: what is best for the task, and what each choice costs."""

from html import escape

import numpy as np

from ..bundle.recruitment import overlap, space
from ..describe import dumps
from ..design.objectives import OBJECTIVES
from ..design.robust import Spread
from ..design.searching import Found
from ..plot.style import to_bytes
from ..plot.task import task as draw_task
from ..units import pretty
from .interactive import SCRIPT, STYLE, Axis, parallel, scaled, scatter
from .page import Page


_INCH = 0.0254  # m
_SHOWN = 30  # designs of the front in the table
_LINKED = 8  # files beside the page
_OTHERS = 3000  # points drawn behind the front
_FORMATS = {"m": "length", "N": "force", "J": "energy"}


def report(
    found: Found,
    date: str,
    files: list[str],
    seconds: float | None = None,
    sure: Spread | None = None,
) -> str:
    """The page.

    **Arguments:**

    - `found`: by the search [-].
    - `date`: of the day [-], such as "2026-05-04".
    - `files`: written beside the page [-].
    - `seconds`: that the search took [s], if known.
    - `sure`: how the front's designs come out [-], if that was asked.

    **Returns:** the page as HTML [-].
    """
    task, chosen = found.task, found.recommended
    page = Page(f"Which bundle: {task.name.replace('_', ' ')}")
    page.html(STYLE)
    took = "" if seconds is None else f" in {seconds:.1f} s"
    page.paragraph(
        f"{found.judged} designs were judged at {len(task)} points of the task{took};"
        f" {_kept(found)}{len(found.front)} are bettered by no other.",
        "lead",
    )
    origin = task.source or "not said"
    page.paragraph(
        f"The task's figures: {origin}. Supply {pretty(task.supply_pressure, 'pressure')},"
        f" {task.scheme} recruitment."
    )
    page.files(files if len(files) <= _LINKED else files[:_LINKED])
    if chosen is None:
        page.heading("No design keeps the limits", "none")
        page.points(nothing_left(found))
    else:
        texts = [told(found, place) for place in range(len(found.front))]
        _recommendation(page, found, chosen)
        _front(page, found, texts, chosen)
        _space(page, found, chosen)
        if sure is not None:
            _sure(page, found, sure)
        _table(page, found)
        _files(page, found, chosen)
    _terms(page, found)
    page.html(SCRIPT)
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")


def told(found: Found, place: int) -> str:
    """A design of the front in a few lines; `found` [-], `place` on the front [-]."""
    designs = found.designs
    lines = [
        f"{designs.labels[place]}{_number(int(found.index[found.front[place]]))}",
        sizes(found, place),
    ]
    lines += [
        f"{name.replace('_', ' ')}: {shown(name, float(values[found.front[place]]))}"
        for name, values in found.values.items()
    ]
    return "\n".join(lines)


def _number(index: int) -> str:
    return f"  (design {index})" if index >= 0 else ""


def _kept(found: Found) -> str:
    """How many keep the limits, where all were kept that were judged."""
    if found.judged > len(found.index):
        return "of those that keep the limits "
    return f"{int(found.allowed.sum())} keep the limits, of which "


def sizes(found: Found, place: int) -> str:
    """A design's muscles in a line; `found` [-], `place` on the front [-]."""
    designs = found.designs
    there = designs.counts[place] > 0
    radii = dict.fromkeys(f"{1e3 * r:.4g}" for r in designs.radius[place][there])
    walls = dict.fromkeys(f"{1e3 * t:.3g}" for t in designs.wall[place][there])
    angle = np.degrees(designs.angle[place, 0])
    text = (
        f"L₀ {1e3 * designs.length[place]:.4g} mm, r₀ {', '.join(radii)} mm,"
        f" t₀ {', '.join(walls)} mm, α₀ {angle:.3g}°"
    )
    names = list(designs.drawings)
    return text if len(names) == 1 else f"{text}, {names[designs.kind[place]]}"


def shown(name: str, value: float) -> str:
    """An objective's `value` [SI] for a reader; `name` [-]."""
    unit = OBJECTIVES[name].unit
    if unit in _FORMATS:
        return pretty(value, _FORMATS[unit])
    return f"{value:.4g}"


def recommendation(found: Found) -> list[str]:
    """Why the recommended design is, in sentences; `found` [-] isn't empty."""
    place = found.recommended
    assert place is not None
    row = found.front[place]
    label = found.designs.labels[place]
    lines = [
        f"Take {label}: {sizes(found, place)}. Of the designs that no other betters it is the one"
        " whose worst objective is least bad, each counted from the best to the worst on the front."
    ]
    for name, sense in found.senses.items():
        on_front = found.values[name][found.front]
        best = on_front.max() if sense == "max" else on_front.min()
        own = found.values[name][row]
        words = f"{name.replace('_', ' ')}: {shown(name, float(own))}"
        if own == best:
            lines.append(f"{words}, the best there is on the front.")
            continue
        where = int(np.flatnonzero(on_front == best)[0])
        lines.append(
            f"{words}; the best on the front is {shown(name, float(best))}, by"
            f" {found.designs.labels[where]}."
        )
    return lines


def nothing_left(found: Found) -> list[str]:
    """Which limit leaves how many designs, where none keeps all; `found` [-]."""
    lines = []
    for name, limit in found.limits.items():
        values = found.values[name]
        kept = int(np.sum((values >= limit.least) & (values <= limit.most)))
        lines.append(
            f"{name.replace('_', ' ')}: {kept} of {len(values)} designs keep it; they reach from"
            f" {shown(name, float(values.min()))} to {shown(name, float(values.max()))}."
        )
    return lines


def _recommendation(page: Page, found: Found, chosen: int) -> None:
    page.heading("Recommendation", "recommendation")
    first, *others = recommendation(found)
    page.paragraph(first, "lead")
    page.points(others)
    if "not_reached" in found.values and found.values["not_reached"][found.front[chosen]] > 0:
        page.paragraph("It doesn't reach all of the task: see the plane below.", "note")


def _front(page: Page, found: Found, texts: list[str], chosen: int) -> None:
    page.heading("What each choice costs", "front")
    on_front = {name: values[found.front] for name, values in found.values.items()}
    axes = {name: scaled(on_front, name, OBJECTIVES[name].unit) for name in on_front}
    names = list(found.senses)
    first = axes[names[0]]
    rest = np.flatnonzero(found.allowed)
    rest = rest[:: max(1, len(rest) // _OTHERS)]
    for name in names[1:] or ["valves"]:
        if name not in axes:
            continue
        x, y = (
            scaled({key: found.values[key][rest]}, key, OBJECTIVES[key].unit).values
            for key in (name, names[0])
        )
        page.html(f"<figure>{scatter(axes[name], first, texts, chosen, (x, y))}</figure>")
    page.paragraph(
        "Dots: designs of the front, the recommended one in orange; gray: other designs within the"
        " limits. With the mouse on a dot or line its design is told, and marked in every picture.",
        "note",
    )
    if len(axes) > 1:
        page.heading("All objectives of the front", "parallel", 3)
        every: list[Axis] = list(axes.values())
        page.html(f"<figure>{parallel(every, texts, chosen)}</figure>")


def _space(page: Page, found: Found, chosen: int) -> None:
    page.heading("The recommended bundle and the task", "space")
    task = found.task
    bundle = found.designs.bundle(chosen, task)
    supply = np.full(len(bundle.motor_units), task.supply_pressure)
    largest = float(bundle.free_strain(supply, resistance=False))
    strain = np.unique(np.concatenate([np.linspace(0.0, largest, 161), task.strain]))
    plane = space(bundle, strain=strain)
    at = np.searchsorted(strain, task.strain)
    covered = (plane.low[:, at] <= task.force + 1e-9) & (task.force <= plane.high[:, at] + 1e-9)
    figure = draw_task(
        plane, overlap(plane), task.force, task.strain, task.weight, covered.any(axis=0)
    )
    title = "Force-strain space and the points demanded"
    page.picture(to_bytes(figure, "svg"), "svg", title, figure.get_figwidth() * _INCH)


def _sure(page: Page, found: Found, sure: Spread) -> None:
    page.heading("How sure", "sure")
    draws = sure.met.shape[1]
    page.paragraph(
        f"Each design in {draws} draws of what no two muscles have alike. It meets the task if it"
        " reaches every point and keeps all limits. Objectives: 5 % to 95 % of the draws."
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


def _table(page: Page, found: Found) -> None:
    page.heading("The front", "table")
    designs = found.designs
    heads = ["", "units", "muscles", *(name.replace("_", " ") for name in found.values)]
    rows = [
        [
            str(place + 1),
            f"<strong>{designs.labels[place]}</strong>"
            if place == found.recommended
            else designs.labels[place],
            escape(sizes(found, place)),
            *(escape(shown(n, float(v[found.front[place]]))) for n, v in found.values.items()),
        ]
        for place in range(min(len(found.front), _SHOWN))
    ]
    page.table(heads, rows)
    if len(found.front) > _SHOWN:
        page.paragraph(f"The first {_SHOWN} of {len(found.front)}; all are in the files.", "note")


def _files(page: Page, found: Found, chosen: int) -> None:
    page.heading("Bundles as files", "toml")
    designs = found.designs
    for place in range(min(len(found.front), _SHOWN)):
        text = dumps(designs.bundle(place, found.task))
        state = " open" if place == chosen else ""
        page.html(
            f"<details{state}><summary>{place + 1}: {escape(designs.labels[place])}</summary>"
            f"<pre><code>{escape(text)}</code></pre></details>"
        )


def _terms(page: Page, found: Found) -> None:
    page.heading("What is judged", "terms")
    points = []
    for name in found.values:
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
