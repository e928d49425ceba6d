"""`fascicle simulate`: a bundle driven in time, and where the energy went."""

import datetime as dt
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ..audited import audited
from ..inputs import read_scenario
from ..options import AsCsv, AsJson, Out, Plot, Replace
from ..outputs import Outputs, say
from ..printed import decimals, number, show
from ..problems import UserError, refusing
from ..telling import telling
from .simulate_compare import compare as comparing


def complete_scenario(incomplete: str) -> list[str]:
    """Named scenarios that begin so [-]."""
    from ...files import scenarios

    return [name for name in scenarios() if name.startswith(incomplete)]


Scenario = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO.toml",
        help="Bundle, load, fluid, supply, valves and schedule, or a named one, such as lift_gas,"
        " ramp_hand_over or joint_gait; `fascicle init --scenario` writes one.",
        autocompletion=complete_scenario,
        show_default=False,
    ),
]
Report = Annotated[
    str | None,
    typer.Option(
        "--report",
        metavar="PATH",
        help="Also write a page with traces and energies there: .html.",
        show_default=False,
    ),
]
Policy = Annotated[
    str | None,
    typer.Option(
        "--policy",
        metavar="NAME",
        help="Control by this policy, not the scenario's: orderly, batch, threshold, energy_aware,"
        " hand_over, pre_charge, fast_cross, or auto.",
        show_default=False,
    ),
]
Compare = Annotated[
    bool,
    typer.Option("--compare", help="Run every policy: their dips against their energy."),
]
Compensate = Annotated[
    bool | None,
    typer.Option(
        "--compensate/--no-compensate",
        help="Whether friction is fed forward, whatever the scenario says.",
        show_default=False,
    ),
]
_DISTRUSTED = 1
_EVENTS = 20  # that are printed
_ROUNDED = 1e-14  # of a balance's largest term: what rounding makes of a zero


def run(
    scenario: Scenario,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    report: Report = None,
    policy: Policy = None,
    compare: Compare = False,
    compensate: Compensate = None,
    overwrite: Replace = False,
) -> int:
    """A bundle driven in time, and where every joule went.

    Where a balance doesn't close, or something happened that forbids to trust the run, it says so
    and ends with exit code 1.
    """
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    _check(report, overwrite)
    if compare and policy is not None:
        raise UserError("--compare runs every policy: leave out --policy.")
    with telling("reading the scenario") as tell:
        read = read_scenario(scenario)
        if policy is not None or compensate is not None:
            with refusing():
                read = read.taking(policy, compensate)
        if compare:
            return comparing(read, outputs, report, overwrite)
        from ...results.simulated import simulated

        steps = round(read.duration / read.dt)
        tell(f"simulating {read.duration:g} s in {steps} steps")
        with refusing():
            found = read.run()
        tell("where the energy went")
        balanced, doubts = audited(read.plant, found)
        made = read.controlled
        asked = () if made is None else (made.controller, made.reference)
        table = simulated(read.plant, found, balanced, *asked)

    def draw() -> Any:
        from ...plot.trajectory import traces
        from ...reports.controlled import demanded

        return traces(read.plant, found, demanded(read, found))

    title = f"Simulation of {read.name}"
    outputs.give(
        table, lambda: _print(read, found, balanced), draw, title=title, notes=_told(read, doubts)
    )
    if report is not None:
        from ...files.ours import replacing
        from ...io.atomic import write_text
        from ...reports.simulated import report as made

        today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        with telling("drawing the report"):
            page = made(read, found, balanced, doubts, today)
        with refusing("--report "), replacing(report, overwrite) as draft:
            write_text(draft, page)
        if not (as_json or as_csv):
            say(f"wrote {report}")
    if doubts:
        sys.stdout.flush()  # in this order, also where both go to one place
        say(f"{read.name}: the run can't be trusted: {'; '.join(doubts)}", error=True)
        return _DISTRUSTED
    return 0


def _check(report: str | None, overwrite: bool) -> None:
    if report is None:
        return
    from ...files.ours import check_file
    from ...io.atomic import check_writable

    if Path(report).suffix.lower() != ".html":
        raise UserError(f"--report {report!r}: its name must end in .html.")
    with refusing("--report "):
        check_writable(report)
        check_file(report, overwrite)


def _told(read: Any, doubts: list[str]) -> str:
    notes = [*read.notes, *(["can't be trusted: " + "; ".join(doubts)] if doubts else [])]
    return " ".join(notes)


def _print(read: Any, found: Any, balanced: Any) -> None:
    from ...dynamics import events

    seen, plant = found.seen, read.plant
    for note in read.notes:
        say(f"note: {note}")
    turns = plant.load.unit == "rad"
    shown, factor = ("deg", 57.29577951308232) if turns else ("mm", 1e3)
    substeps = f"{found.substeps} substeps each"
    print(
        f"{found.time[-1]:g} s in {len(found.time) - 1} steps of {1e3 * read.dt:g} ms, {substeps}"
    )
    places = decimals(factor * seen.position)
    rows = [
        [
            name,
            f"{found.time[k]:g}",
            number(factor * float(seen.position[k]), places),
            *(number(float(P) / 1e3, 1) for P in seen.pressures[k]),
            number(float(seen.supply_pressure[k]) / 1e3, 1),
        ]
        for name, k in (("start", 0), ("lowest", seen.position.argmin()),
                        ("highest", seen.position.argmax()), ("end", -1))
    ]  # fmt: skip
    heads = ["", "time s", f"position {shown}",
             *(f"P{unit + 1} kPa" for unit in range(plant.units)), "supply kPa"]  # fmt: skip
    show(f"Positions of the load, from {read.name}", heads, rows)
    if read.controlled is not None:
        _worth(read, found)
    if balanced is not None:
        _balances(balanced)
    happened = events(found)
    for one in happened[:_EVENTS]:
        say(f"{one.name} from {one.first:.4g} s to {one.last:.4g} s: {one.words}")


def _worth(read: Any, found: Any) -> None:
    from ...reports.controlled import beyond, judged, told

    made, plant = read.controlled, read.plant
    what, of = judged(made, found), made.controller.of
    show(f"Control of {of} by {made.policy}", ["", ""], told(plant, of, what))
    if out := beyond(plant, of, what):
        say(f"note: {out}")


def _balances(balanced: Any) -> None:
    rows = [
        [
            one.name.replace(" of ", "\nof "),
            "\n".join(_terms(one)),
            # below one another, so that a narrow terminal keeps them beside their balance
            f"{one.share:.0e}\n" + ("closes" if one.closes else "DOES NOT\nCLOSE"),
        ]
        for one in balanced.balances
    ]
    told = "left over: as a share of the largest term; terms that are zero aren't told"
    show("Balances", ["balance", "what came and went", "left over"], rows, told)


def _terms(balance: Any) -> list[str]:
    least = _ROUNDED * max(map(abs, [*balance.into.values(), *balance.went.values()]))
    return [
        f"{mark}{name} {value:.3g} {balance.unit}"
        for mark, terms in (("", balance.into), ("to ", balance.went))
        for name, value in terms.items()
        if abs(value) > least
    ]
