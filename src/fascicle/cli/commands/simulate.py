"""`fascicle simulate`: a bundle driven in time, its energy balance, and policies compared."""

import datetime as dt
import math
import sys
from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import read_scenario
from ..options import argument, flag, option
from ..outputs import (
    Outputs,
    check_file,
    count_decimals,
    number,
    print_line,
    print_table,
    status,
    write_text,
)  # fmt: skip


_UNTRUSTED = 1  # exit code
_MAX_EVENTS = 20  # printed lines: about a screen
_ROUNDING = 1e-14  # of a balance's largest term: smaller ones are rounded zeros


def _complete_scenario(incomplete: str) -> list[str]:
    from ...files import scenarios

    return [name for name in scenarios() if name.startswith(incomplete)]


def run(
    scenario: str = argument(
        "SCENARIO.toml",
        "Scenario file: bundle, load, fluid, supply, valves and schedule; or a named one, such as"
        " lift_gas, ramp_hand_over or joint_gait; `fascicle init --scenario` writes one.",
        autocompletion=_complete_scenario,
    ),
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    plot: str | None = options.PLOT,
    report: str | None = option("Page with traces and energies: .html.", metavar="PATH"),
    policy: str | None = option(
        "Control policy: orderly, batch, threshold, energy_aware, hand_over, pre_charge, fast_cross"
        " or auto; default: the scenario's.",
        metavar="NAME",
    ),
    compare: bool = flag("Comparison of all policies, drawdown against energy.", "--compare"),
    compensate: bool | None = option(
        "Friction feedforward; default: the scenario's.", "--compensate/--no-compensate"
    ),
    overwrite: bool = options.OVERWRITE,
) -> int:
    """Simulate a bundle over time and report its energy balance.

    Exit code 1 if a balance does not close, or an event makes the run untrustworthy.
    """
    outputs = Outputs(as_json, as_csv, out, plot, overwrite)
    if report is not None:
        check_file("--report", report, overwrite, [".html"])
    if compare and policy is not None:
        raise UserError("--compare runs every policy: drop --policy.")
    with status("reading the scenario") as update:
        study = read_scenario(scenario)
        if policy is not None or compensate is not None:
            with user_errors():
                study = study.with_policy(policy, compensate)
        if not compare:
            update(f"simulating {study.duration:g} s in {round(study.duration / study.dt)} steps")
            return _simulate(study, outputs, report)
    return _compare(study, outputs, report)


def _simulate(study: Any, outputs: Outputs, report: str | None) -> int:
    from ...results.run_tables import simulated

    with user_errors():
        result = study.run()
    balances, doubts = audit_run(study.plant, result)
    control = study.control
    controller = () if control is None else (control.controller, control.reference)

    def draw() -> Any:
        from ...plot.trajectory import traces
        from ...reports.simulation import run_demand

        return traces(study.plant, result, run_demand(study, result))

    notes = [*study.notes, *([f"can't be trusted: {'; '.join(doubts)}"] if doubts else [])]
    outputs.write(
        simulated(study.plant, result, balances, *controller),
        lambda: _print(study, result, balances),
        draw,
        title=f"Simulation of {study.name}",
        notes=" ".join(notes),
    )
    if report is not None:
        from ...reports.simulation import report as page

        _write_report(report, outputs, page(study, result, balances, doubts, _today()))
    return _print_doubts({f"{study.name}: the run": doubts})


def _compare(study: Any, outputs: Outputs, report: str | None) -> int:
    """Run all policies on one scenario; returns the exit code."""
    if study.control is None:
        raise UserError(f"--compare: {study.name} is commanded by a schedule; it needs [control].")
    from ...control import POLICIES
    from ...plot.trajectory import PolicyCosts, policies
    from ...reports import simulation as pages
    from ...results.run_tables import policy_table

    runs: dict[str, Any] = {}
    with status("simulating") as update:
        for index, policy in enumerate(POLICIES, start=1):
            update(f"simulating {policy}, policy {index} of {len(POLICIES)}")
            with user_errors():
                variant = study.with_policy(policy)
                result = variant.run()
            _, doubts = audit_run(variant.plant, result)
            demand = pages.run_demand(variant, result)
            assert demand is not None
            metrics = pages.control_worth(variant.control, result)
            runs[policy] = pages.PolicyRun(variant.control, result, metrics, demand, doubts)
    metrics = [run.worth for run in runs.values()]
    controllers = {name: run.control.controller for name, run in runs.items()}
    table = policy_table(controllers, metrics, [not run.doubts for run in runs.values()])
    front = table["on_front"].values.tolist()
    quantity = study.control.controller.of
    notes = [f"{note}." for note in pages.policy_notes(study, runs)]

    def draw() -> Any:
        drawdowns, energies = zip(*((m.drawdown, m.supply_energy) for m in metrics), strict=True)
        pairs = {name: (run.run, run.demand) for name, run in runs.items()}
        return policies(study.plant, pairs, PolicyCosts([*drawdowns], [*energies], front))

    def print_policies() -> None:
        print_table(
            f"Policies on {study.name}, control of {quantity}",
            pages.policy_heads(study.plant, quantity),
            pages.policy_rows(study.plant, quantity, runs, front),
            "front: no other policy has less drawdown for as much energy, or takes less energy for"
            " as much drawdown",
        )
        for note in notes:
            print_line(f"note: {note}")

    title = f"Policies of {study.name}"
    outputs.write(table, print_policies, draw, title=title, notes=" ".join(notes))
    if report is not None:
        _write_report(report, outputs, pages.policy_report(study, runs, front, draw(), _today()))
    return _print_doubts({f"{study.name}, {name}": run.doubts for name, run in runs.items()})


def audit_run(plant: Any, result: Any) -> tuple[Any, list[str]]:
    """Audit of a run, `None` for a chamber without a balance; and reasons not to trust the run."""
    from ...dynamics import audit, events

    audited, doubts = None, []
    try:
        audited = audit(plant, result)
    except ValueError as error:
        doubts.append(str(error).rstrip("."))
    doubts += [
        f"the {balance.name} doesn't close: its residual is {balance.share:.1e} of its largest"
        f" term, more than {balance.closes_within:g}"
        + (f": {balance.remedy}" if balance.remedy else "")
        for balance in (audited.balances if audited else ())
        if not balance.closes
    ]
    doubts += [
        f"{event.name} from {event.first:g} s, {event.words}"
        for event in events(result)
        if not event.trusted
    ]
    return audited, doubts


def _today() -> str:
    return f"{dt.datetime.now().astimezone():%Y-%m-%d}"


def _write_report(path: str, outputs: Outputs, page: str) -> None:
    write_text("--report", path, outputs.overwrite, page)
    if not (outputs.as_json or outputs.as_csv):
        print_line(f"wrote {path}")


def _print_doubts(doubts: dict[str, list[str]]) -> int:
    """Print reasons not to trust runs; returns the exit code."""
    sys.stdout.flush()  # keeps the order if both streams go to one file
    for run, reasons in doubts.items():
        if reasons:
            print_line(f"{run} can't be trusted: {'; '.join(reasons)}", error=True)
    return _UNTRUSTED if any(doubts.values()) else 0


def _print(study: Any, result: Any, audited: Any) -> None:
    from ...dynamics import events

    outputs, plant = result.outputs, study.plant
    balances = audited.balances if audited else ()
    print_line(
        f"{study.name}: {result.time[-1]:g} s in {len(result.time) - 1} steps of"
        f" {1e3 * study.dt:g} ms, {result.substeps} substeps each"
    )
    if balances:
        closed = sum(balance.closes for balance in balances)
        print(f"{closed} of {len(balances)} balances close")
    for note in study.notes:
        print_line(f"note: {note}")
    unit, factor = ("deg", math.degrees(1)) if plant.load.unit == "rad" else ("mm", 1e3)
    position = factor * outputs.position
    decimals = count_decimals(position)
    steps = {"start": 0, "lowest": position.argmin(), "highest": position.argmax(), "end": -1}
    rows = [
        [
            name,
            f"{result.time[k]:g}",
            number(float(position[k]), decimals),
            *(
                number(float(P) / 1e3, 1)
                for P in (*outputs.pressures[k], outputs.supply_pressure[k])
            ),
        ]
        for name, k in steps.items()
    ]
    pressures = [f"P{index + 1} [kPa]" for index in range(plant.units)]
    heads = ["", "time [s]", f"position [{unit}]", *pressures, "supply [kPa]"]
    print_table("Positions of the load", heads, rows)
    if study.control is not None:
        _print_control(study, result)
    if balances:
        _print_balances(balances)
    for event in events(result)[:_MAX_EVENTS]:
        print_line(f"{event.name} from {event.first:.4g} s to {event.last:.4g} s: {event.words}")


def _print_control(study: Any, result: Any) -> None:
    from ...reports.simulation import control_worth, unreachable_message, worth_rows

    control, plant = study.control, study.plant
    metrics, quantity = control_worth(control, result), control.controller.of
    rows = worth_rows(plant, quantity, metrics)
    print_table(f"Control of {quantity} by {control.policy}", ["metric", "value"], rows)
    if message := unreachable_message(plant, quantity, metrics):
        print_line(f"note: {message}")


def _print_balances(balances: Any) -> None:
    rows = []
    for balance in balances:
        terms = balance.into | {f"to {name}": value for name, value in balance.went.items()}
        smallest = _ROUNDING * max(map(abs, terms.values()))
        lines = [
            f"{name} {value:.3g} {balance.unit}"
            for name, value in terms.items()
            if abs(value) > smallest
        ]
        # on lines of their own, so that a narrow terminal keeps them next to their balance
        verdict = f"{balance.share:.0e}\n" + ("closes" if balance.closes else "DOES NOT\nCLOSE")
        rows.append([balance.name.replace(" of ", "\nof "), "\n".join(lines), verdict])
    caption = "residual: relative to the largest term; zero terms omitted"
    print_table("Balances", ["balance", "terms [J, kg]", "residual [-]"], rows, caption)
