"""The page of a run in time: what moved, where every joule went, and whether to believe it."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..plot.style import to_bytes
from ..plot.trajectory import MOST, energy_balances, traces
from .controlled import beyond, demanded, judged, told
from .page import Page


if TYPE_CHECKING:
    from ..dynamics import Audit, Balance, Trajectory
    from ..files import Scenario

_INCH = 0.0254  # m


def report(
    scenario: "Scenario",
    run: "Trajectory",
    audited: "Audit | None",
    doubts: Sequence[str],
    date: str,
) -> str:
    """The page.

    **Arguments:**

    - `scenario`: that ran [-].
    - `run`: of it [SI].
    - `audited`: its balances [-]; none for a chamber that keeps none.
    - `doubts`: why it can't be trusted, in words [-]; empty where it can.
    - `date`: of the day [-], such as "2026-05-04".

    **Returns:** the page as HTML [-].
    """
    from ..dynamics import events

    page = Page(f"Simulated: {scenario.name.replace('_', ' ')}")
    page.paragraph(_verdict(doubts, audited), "lead")
    page.points(f"Why not: {one}." for one in doubts)
    page.points(scenario.notes)
    for one in events(run):
        if one.trusted:
            page.paragraph(f"`{one.name}` from {one.first:.4g} s to {one.last:.4g} s: {one.words}.")
    page.paragraph(_what(scenario, run))
    if scenario.source:
        page.paragraph(f"Where its figures come from: {scenario.source}.")
    page.paragraph("A simulation: nothing on this page was measured.", "note")

    if scenario.controlled is not None:
        _control(page, scenario, run)
    page.heading("What moved", "traces")
    figure = traces(scenario.plant, run, demanded(scenario, run))
    page.picture(to_bytes(figure, "svg"), "svg", "Position, pressures, forces and valves over time",
                 figure.get_figwidth() * _INCH)  # fmt: skip
    page.paragraph(_caption(scenario, run), "note")
    page.table(*_moments(scenario, run))

    page.heading("Where every joule went", "energies")
    if audited is None:
        page.paragraph(f"Not known: {doubts[0]}.")
    else:
        _energies(page, audited)
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")


def _control(page: Page, scenario: "Scenario", run: "Trajectory") -> None:
    made, plant = scenario.controlled, scenario.plant
    assert made is not None
    of, what = made.controller.of, judged(made, run)
    page.heading("What its control was worth", "control")
    page.paragraph(f"The {of} was controlled, by the policy `{made.policy}`.")
    page.table(["", ""], ([escape(words), figure] for words, figure in told(plant, of, what)))
    if out := beyond(plant, of, what):
        page.paragraph(f"{out}.")
    page.paragraph(
        "The drawdown is how far it fell while its demand didn't; the dip is what the next unit"
        " takes, as it is fed, before it gives.",
        "note",
    )


def _verdict(doubts: Sequence[str], audited: "Audit | None") -> str:
    if doubts:
        return "This run can't be trusted."
    assert audited is not None
    worst = max(audited.balances, key=lambda one: one.share)
    return (
        f"All {len(audited.balances)} balances close: at worst {worst.share:.0e} of the largest"
        f" term is left over, in the {worst.name}."
    )


def _what(scenario: "Scenario", run: "Trajectory") -> str:
    plant = scenario.plant
    units = " and ".join(
        " + ".join(f"{int(unit.count)}" for unit in bundle.motor_units) for bundle in plant.bundles
    )
    parts = ", ".join(
        type(part).__name__
        for part in (plant.load, plant.chamber, plant.supply, plant.valve, plant.spool)
    )
    return (
        f"Muscles in motor units: {units}. Parts: {parts}. {run.time[-1]:g} s in"
        f" {len(run.time) - 1} steps of {1e3 * scenario.dt:g} ms with {run.substeps} substeps each,"
        f" as {run.pace.part if run.pace else 'was asked'} needs."
    )


def _caption(scenario: "Scenario", run: "Trajectory") -> str:
    thinned = ""
    if len(run.time) > MOST:
        thinned = (
            f" Curves are drawn through at most {MOST} of {len(run.time)} moments, the least and"
            " the largest of each stretch among them."
        )
    stop = " Hatched: the stop's." if scenario.plant.load.stop is not None else ""
    turns = scenario.plant.load.unit == "rad"
    way = "where the first bundle pulls" if turns else "as the bundle contracts"
    return f"The load's coordinate rises {way}.{stop}{thinned}"


def _moments(scenario: "Scenario", run: "Trajectory") -> tuple[list[str], list[list[str]]]:
    seen, plant = run.seen, scenario.plant
    unit, factor = ("°", 180 / np.pi) if plant.load.unit == "rad" else ("mm", 1e3)
    q = factor * np.asarray(seen.position)
    heads = ["", "time [s]", f"position [{unit}]",
             *(f"P{i + 1} [kPa]" for i in range(plant.units)), "supply [kPa]"]  # fmt: skip
    marks = {"start": 0, "lowest": int(q.argmin()), "highest": int(q.argmax()), "end": len(q) - 1}
    rows = [
        [
            name,
            f"{run.time[k]:g}",
            f"{q[k]:.2f}",
            *(f"{round(float(P) / 1e3, 1) + 0.0:.1f}" for P in seen.pressures[k]),
            f"{seen.supply_pressure[k] / 1e3:.1f}",
        ]
        for name, k in marks.items()
    ]
    return heads, rows


def _energies(page: Page, audited: "Audit") -> None:
    drawn = [one for one in audited.balances if one.unit == "J" and one.name != "first law"]
    figure = energy_balances(drawn)
    page.picture(to_bytes(figure, "svg"), "svg", "Where energy came from and where it went",
                 figure.get_figwidth() * _INCH)  # fmt: skip
    page.paragraph(
        "Each panel is to a scale of its own: what the fluid does on the muscles is what comes into"
        " the second, their pull what comes into the third.",
        "note",
    )
    heads = ["balance", "came in", "went to", "left over", "of the largest term", ""]
    page.table(heads, (_row(one) for one in audited.balances))
    page.paragraph(
        "Each term is an integral of its own, none is what the others leave: what is left over says"
        " how well the run can be believed.",
        "note",
    )


def _row(one: "Balance") -> list[str]:
    kind, sign, word = ("holds", "✓", "closes") if one.closes else ("fails", "✗", "doesn't close")
    return [
        escape(one.name),
        _terms(one.into, one.unit),
        _terms(one.went, one.unit),
        f"{one.left:.1e} {one.unit}",
        f"{one.share:.0e}, up to {one.closes_within:g} passes",
        f'<span class="{kind}">{sign}\u00a0{word}</span>',
    ]


def _terms(terms: dict[str, float], unit: str) -> str:
    return "<br>".join(f"{escape(name)}: {x + 0.0:.4g} {unit}" for name, x in terms.items())
