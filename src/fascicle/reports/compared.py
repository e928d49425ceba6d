"""The page of one scenario under all policies, and the words of its table."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, NamedTuple

from matplotlib.figure import Figure

from ..plot.style import to_bytes
from ..plot.trajectory import Demand, display_unit
from .controlled import beyond
from .page import Page


if TYPE_CHECKING:
    from ..control import ControlMetrics
    from ..dynamics import Plant, Trajectory
    from ..files import Scenario
    from ..files.controlled import Controlled

_INCH = 0.0254  # m
_PLAIN = "threshold"  # against which energies are told


class Ran(NamedTuple):
    """A policy's run: how it was `controlled` [-], the `run` [SI], what it was `worth` [SI], what
    it was `demanded` [SI], and `doubts` whether it can be trusted, in words [-].
    """

    controlled: "Controlled"
    run: "Trajectory"
    worth: "ControlMetrics"
    demanded: Demand
    doubts: list[str]


def heads(plant: "Plant", of: str) -> list[str]:
    """Heads of the table [-], of a `plant` [-] that is controlled `of` [-]."""
    _, unit = display_unit(plant, of)
    share = ["of D"] if of == "force" else []
    return ["policy", f"drawdown {unit}", *share, f"rms {unit}", "lag ms", "energy J",
            "more than\nthreshold", "fluid g", "recruited", "front", ""]  # fmt: skip


def rows(plant: "Plant", of: str, runs: Mapping[str, Ran], best: Sequence[bool]) -> list[list[str]]:
    """Rows of the table [-]: of a `plant` [-] that is controlled `of` [-], the `runs` by policy
    [SI], and which are the `best` [-].
    """
    factor, _ = display_unit(plant, of)
    plain = runs[_PLAIN].worth.supply_energy
    made = []
    for (name, one), on_front in zip(runs.items(), best, strict=True):
        what = one.worth
        share = [f"{what.drawdown / what.dip:.3f}" if what.dip else "-"] if of == "force" else []
        more = f"{100 * (what.supply_energy / plain - 1):+.1f} %" if plain else "-"
        made.append([
            name, f"{factor * what.drawdown:.4g}", *share, f"{factor * what.rms:.4g}",
            f"{1e3 * what.lag:.4g}", f"{what.supply_energy:.4g}", more, f"{1e3 * what.fluid:.4g}",
            f"{what.recruited}", "front" if on_front else "",
            "can't be trusted" if one.doubts else "",
        ])  # fmt: skip
    return made


def notes(scenario: "Scenario", runs: Mapping[str, Ran]) -> list[str]:
    """What must be said beside the table of `runs` [SI] of a `scenario` [-], in words [-]."""
    first = next(iter(runs.values()))
    of = first.demanded.quantity
    told = []
    if scenario.plant.units == 1:
        told.append("there is one motor unit: nothing is handed over, policies differ by nothing")
    if of == "position":
        told.append("D, the dip of force, is no measure of a position: the drawdown stands alone")
    worst = max((one.worth for one in runs.values()), key=lambda what: what.unreachable)
    if worst.unreachable:
        told.append(beyond(scenario.plant, of, worst))
    return told


def report(
    scenario: "Scenario", runs: Mapping[str, Ran], best: Sequence[bool], figure: Figure, date: str
) -> str:
    """The page.

    **Arguments:**

    - `scenario`: that ran [-].
    - `runs`: by policy [SI].
    - `best`: which of them are on the front [-].
    - `figure`: of them [-].
    - `date`: of the day [-], such as "2026-05-04".

    **Returns:** the page as HTML [-].
    """
    of = next(iter(runs.values())).demanded.quantity
    page = Page(f"Policies: {scenario.name.replace('_', ' ')}")
    told = [name for name, on_front in zip(runs, best, strict=True) if on_front]
    lead = "On the front of drawdown against energy from the supply"
    page.paragraph(f"{lead}: {', '.join(f'`{name}`' for name in told)}.", "lead")
    page.points(f"{note}." for note in notes(scenario, runs))
    page.points(
        f"`{name}` can't be trusted: {'; '.join(one.doubts)}."
        for name, one in runs.items() if one.doubts
    )  # fmt: skip
    if scenario.source:
        page.paragraph(f"Where its figures come from: {scenario.source}.")
    page.paragraph("Simulations: nothing on this page was measured.", "note")
    page.picture(to_bytes(figure, "svg"), "svg", "Drawdown against energy, and errors over time",
                 figure.get_figwidth() * _INCH)  # fmt: skip
    table = rows(scenario.plant, of, runs, best)
    page.table(
        [head.replace("\n", " ") for head in heads(scenario.plant, of)],
        ([escape(cell) for cell in row] for row in table),
    )
    page.paragraph(
        f"Control of {of}. The drawdown is how far it fell while its demand didn't; D is the"
        " deepest dip of a unit at the strains that were passed, what it takes as it is fed"
        " before it gives. Energies are what the fluid could have done that was drawn.",
        "note",
    )
    from .. import __version__

    return page.text(f"Made on {date} by fascicle {__version__}.")
