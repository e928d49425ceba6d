"""`fascicle simulate`: a bundle driven in time, and where the energy went."""

import datetime as dt
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from ..inputs import read_scenario
from ..options import AsCsv, AsJson, Out, Plot, Replace
from ..outputs import Outputs, say
from ..printed import decimals, number, show
from ..problems import UserError, refusing
from ..telling import telling


def complete_scenario(incomplete: str) -> list[str]:
    """Named scenarios that begin so [-]."""
    from ...files import scenarios

    return [name for name in scenarios() if name.startswith(incomplete)]


Scenario = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO.toml",
        help="Bundle, load, fluid, supply, valves and schedule, or a named one: lift_gas, lift_oil,"
        " joint_step, ramp_hand_over, supply_runs_dry; `fascicle init --scenario` writes one.",
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
_DISTRUSTED = 1
# of arrays up to so many bytes; what has been set is respected
LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=100000000"
_EVENTS = 20  # that are printed


def run(
    scenario: Scenario,
    as_json: AsJson = False,
    as_csv: AsCsv = False,
    out: Out = None,
    plot: Plot = None,
    report: Report = None,
    overwrite: Replace = False,
) -> int:
    """A bundle driven in time, and where every joule went.

    Where a balance doesn't close, or something happened that forbids to trust the run, it says so
    and ends with exit code 1.
    """
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    _check(report, overwrite)
    # a loop as one function of machine code, not a task for each of its operations
    os.environ.setdefault("XLA_FLAGS", LOOPS)
    with telling("reading the scenario") as tell:
        read = read_scenario(scenario)
        from ...results.simulated import simulated

        steps = round(read.duration / read.dt)
        tell(f"simulating {read.duration:g} s in {steps} steps")
        with refusing():
            found = read.run()
        tell("where the energy went")
        audited, doubts = _audited(read.plant, found)
        table = simulated(read.plant, found, audited)

    def draw() -> Any:
        from ...plot.simulated import traces

        return traces(read.plant, found)

    title = f"Simulation of {read.name}"
    outputs.give(
        table, lambda: _print(read, found, audited), draw, title=title, notes=_told(read, doubts)
    )
    if report is not None:
        from ...core.atomic import write_text
        from ...files.ours import replacing
        from ...reports.simulated import report as made

        today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        page = made(read, found, audited, doubts, today)
        with refusing("--report "), replacing(report, overwrite):
            write_text(report, page)
        if not (as_json or as_csv):
            say(f"wrote {report}")
    if doubts:
        sys.stdout.flush()  # in this order, also where both go to one place
        sys.stderr.write(f"{read.name}: the run can't be trusted: {'; '.join(doubts)}\n")
        return _DISTRUSTED
    return 0


def _check(report: str | None, overwrite: bool) -> None:
    if report is None:
        return
    from ...core.atomic import check_writable
    from ...files.ours import check_file

    if Path(report).suffix.lower() != ".html":
        raise UserError(f"--report {report!r}: its name must end in .html.")
    with refusing("--report "):
        check_writable(report)
        check_file(report, overwrite)


def _audited(plant: Any, found: Any) -> tuple[Any, list[str]]:
    """The audit, or none of a chamber that keeps no balance, and why not to trust the run."""
    from ...dynamics import audit, events

    audited, doubts = None, []
    try:
        audited = audit(plant, found)
    except ValueError as error:
        doubts.append(str(error).rstrip("."))
    doubts += [
        f"the {one.name} doesn't close, {one.share:.1e} of its largest term is left over"
        f" ({one.closes_within:g} would pass)"
        for one in (audited.balances if audited else ())
        if not one.closes
    ]
    doubts += [
        f"{one.name} from {one.first:g} s, {one.words}" for one in events(found) if not one.trusted
    ]
    return audited, doubts


def _told(read: Any, doubts: list[str]) -> str:
    notes = [*read.notes, *(["can't be trusted: " + "; ".join(doubts)] if doubts else [])]
    return " ".join(notes)


def _print(read: Any, found: Any, audited: Any) -> None:
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
    if audited is not None:
        _balances(audited)
    happened = events(found)
    for one in happened[:_EVENTS]:
        say(f"{one.name} from {one.first:.4g} s to {one.last:.4g} s: {one.words}")


def _worth(read: Any, found: Any) -> None:
    from ...control import worth

    made = read.controlled
    what = worth(made.controller, found, made.reference)
    turns = read.plant.load.unit == "rad"
    force, place = ("N·m", ("deg", 57.29577951308232)) if turns else ("N", ("mm", 1e3))
    unit, factor = place if made.controller.of == "position" else (force, 1.0)
    rows = [
        [f"drawdown while the demand rises, {unit}", f"{factor * what.drawdown:.4g}"],
        ["deepest dip of a unit on the way, N", f"{what.dip:.4g}"],
        [f"root mean square of the error, {unit}", f"{factor * what.rms:.4g}"],
        [f"largest error, {unit}", f"{factor * what.largest_error:.4g}"],
        ["lag, ms", f"{1e3 * what.lag:.4g}"],
        ["energy from the supply, J", f"{what.supply_energy:.4g}"],
        ["fluid from the supply, g", f"{1e3 * what.fluid:.4g}"],
        ["times that a unit was recruited", f"{what.recruited}"],
    ]
    show(f"Control of {made.controller.of}", ["", ""], rows)
    if what.unreachable:
        say(
            f"note: {what.unreachable} of {what.moments} demands can't be reached at the supply's"
            " pressure, whatever the policy: errors and lag are of the others"
        )


def _balances(audited: Any) -> None:
    rows = [
        [
            one.name.replace(" of ", "\nof "),
            "\n".join([*_terms(one.into, one.unit, ""), *_terms(one.went, one.unit, "to ")]),
            f"{one.share:.0e}",
            "closes" if one.closes else "DOES NOT CLOSE",
        ]
        for one in audited.balances
    ]
    told = "left over: as a share of the largest term; terms that are zero aren't told"
    show("Balances", ["balance", "what came and went", "left over", ""], rows, told)


def _terms(terms: dict[str, float], unit: str, mark: str) -> list[str]:
    return [f"{mark}{name} {value:.3g} {unit}" for name, value in terms.items() if value]
