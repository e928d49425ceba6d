"""`fascicle simulate`: a bundle driven in time, its energy balance, and policies compared."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import fascicle as fs

from .. import files
from . import options
from .errors import UserError, user_errors
from .inputs import read_scenario
from .options import Text, argument, flag, option, with_options
from .outputs import PICTURES, Outputs, check_file, today, write_picture, write_text
from .terminal import print_line, print_table, print_text, status


if TYPE_CHECKING:
    from ..core.findings import Finding

_UNTRUSTED = 1  # exit code


@with_options("outputs", Outputs)
def simulate(
    outputs: Outputs,
    scenario: str = argument(
        "SCENARIO.toml",
        "Scenario file: bundle, load, fluid, supply, valves and schedule; or a named one, such as"
        " lift_gas, ramp_hand_over or joint_gait; `fascicle init --scenario` writes one. Of a"
        " muscle or bundle: it lifts --mass as in lift_gas.",
        autocompletion=lambda: [*files.scenarios()],
    ),
    units: options.Units = None,
    mass: Text = option(
        "Mass that a muscle or bundle lifts: 10kg; default: half of a unit's blocked force.",
        "MASS",
    ),
    report: Text = option("HTML page with traces and energy balances.", "PATH"),
    bode: Text = option(
        "Bode diagram about the end of the run, and of the pressure loops: PNG, SVG or PDF.", "PATH"
    ),
    policy: Text = option("Policy, such as batch or hand_over; default: the file's.", "NAME"),
    compare: bool = flag("Comparison of all policies: drawdown against energy.", "--compare"),
    compensate: bool | None = option(
        "Friction feedforward; default: the scenario's.", names="--compensate/--no-compensate"
    ),
) -> int:
    """Simulate a bundle over time and check its energy balance.

    Exit code 1 if a balance does not close, or an event makes the run untrustworthy.
    """
    if report is not None:
        check_file("--report", report, outputs.overwrite, [".html"])
    if bode is not None:
        check_file("--bode", bode, outputs.overwrite, PICTURES)
    if compare and (policy is not None or bode is not None):
        raise UserError("--compare runs every policy: drop --policy and --bode.")
    study = read_scenario(scenario, units, mass)
    if policy is not None or compensate is not None:
        with user_errors():
            study = study.with_policy(policy, compensate)
    if compare:
        return _compare_policies(study, outputs, report)
    return _simulate(study, outputs, report, bode)


def _simulate(
    study: "files.Scenario", outputs: Outputs, report: str | None, bode: str | None
) -> int:
    """Run a scenario once, print and write the results; returns the exit code."""
    from ..report import simulation as pages
    from ..report import words

    steps = f"{study.duration:g} s in {round(study.duration / study.dt)} steps"
    with status(f"simulating {steps}"), user_errors():
        result = study.run()
    audit = fs.dynamics.audit(study.plant, result)
    doubts = audit.doubts
    control = study.control
    controlled = (control.controller, control.reference) if control else (None, None)

    def figure() -> Any:
        from ..plot.trajectory import traces

        return traces(study.plant, result, pages.run_demand(study, result))

    findings = pages.run_findings(study, audit)
    notes = words.notes(findings)
    if doubts:
        notes.append(f"can't be trusted: {'; '.join(map(words.words, doubts))}.")
    outputs.write(
        fs.tables.simulated(study.plant, result, audit, *controlled),
        lambda: _print(study, result, audit),
        figure,
        title=f"Simulation of {study.name}",
        notes=" ".join(notes),
        findings=[finding.to_json() for finding in findings],
    )
    if report is not None:
        _write_report(report, outputs, pages.report(study, result, audit, today()))
    if bode is not None:
        from ..plot.frequency import bode as draw_bode

        with status("linearizing"), user_errors("--bode: "):
            drawn = draw_bode(study.plant, result.end, controlled[0])
        write_picture("--bode", bode, outputs.overwrite, drawn)
        if not (outputs.as_json or outputs.as_csv):
            print_line(f"wrote {bode}")
    return _print_doubts({f"{study.name}: the run": doubts})


def _compare_policies(study: "files.Scenario", outputs: Outputs, report: str | None) -> int:
    """Run all policies on one scenario; returns the exit code."""
    if study.control is None:
        raise UserError(f"--compare: {study.name} is commanded by a schedule; it needs [control].")
    from ..plot.trajectory import policies
    from ..report import simulation as pages

    runs: dict[str, Any] = {}
    with status("simulating") as update:
        for index, policy in enumerate(fs.control.POLICIES, start=1):
            update(f"simulating {policy}, policy {index} of {len(fs.control.POLICIES)}")
            with user_errors():
                variant = study.with_policy(policy)
                result = variant.run()
            doubts = fs.dynamics.audit(variant.plant, result).doubts
            runs[policy] = pages.policy_run(variant, result, doubts)
    metrics = [run.metrics for run in runs.values()]
    controllers = {name: run.control.controller for name, run in runs.items()}
    table = fs.tables.policy_table(controllers, metrics, [not run.doubts for run in runs.values()])
    front = table["on_front"].values.tolist()
    quantity = study.control.controller.of
    notes = [f"{note}." for note in pages.policy_notes(study, runs)]

    def figure() -> Any:
        pairs = {name: (run.run, run.tracking) for name, run in runs.items()}
        drawdowns, energies = (
            [getattr(m, x) for m in metrics] for x in ("drawdown", "supply_energy")
        )
        return policies(study.plant, pairs, drawdowns, energies, front)

    def print_policies() -> None:
        for note in notes:
            print_text(f"note: {note}")
        print_table(
            f"Policies on {study.name}, control of {quantity}",
            *pages.policy_cells(study.plant, quantity, runs, front),
            "front: no other policy is as good in drawdown and energy, and better in one; D:"
            " deepest dip of force of a motor unit; energy above threshold's: above that of the"
            " policy `threshold`",
        )

    title = f"Policies of {study.name}"
    findings = [
        {"policy": name, **finding.to_json()}
        for name, run in runs.items()
        for finding in run.doubts
    ]
    outputs.write(
        table, print_policies, figure, title=title, notes=" ".join(notes), findings=findings
    )
    if report is not None:
        _write_report(report, outputs, pages.policy_report(study, runs, front, figure(), today()))
    return _print_doubts({f"{study.name}, {name}": run.doubts for name, run in runs.items()})


def _write_report(path: str, outputs: Outputs, page: str) -> None:
    write_text("--report", path, outputs.overwrite, page)
    if not (outputs.as_json or outputs.as_csv):
        print_line(f"wrote {path}")


def _print_doubts(doubts: "dict[str, Sequence[Finding]]") -> int:
    """Print reasons not to trust runs; returns the exit code."""
    from ..report.words import words

    sys.stdout.flush()  # keeps the order if both streams go to one file
    for run, findings in doubts.items():
        if findings:
            reasons = "; ".join(map(words, findings))
            print_line(f"{run} can't be trusted: {reasons}", error=True)
    return _UNTRUSTED if any(doubts.values()) else 0


def _print(
    study: "files.Scenario",
    result: "fs.dynamics.Trajectory",
    audit: "fs.dynamics.Audit",
) -> None:
    from ..report import simulation as pages
    from ..report import words

    plant, control = study.plant, study.control
    balances = audit.balances
    steps = f"{len(result.time) - 1} steps of {1e3 * study.dt:g} ms"
    closed = sum(balance.closes for balance in balances)
    verdict = "can be trusted" if audit.closes else "can't be trusted"
    verdict += f": {closed} of {len(balances)} balances close"
    print_text(f"{study.name}: {result.time[-1]:g} s in {steps}; the run {verdict}.")
    print_text(f"{pages.control_text(study)}.")
    rows = []
    if control is not None:
        quantity, metrics = control.controller.of, pages.run_metrics(control, result)
        rows = pages.metrics_rows(plant, quantity, metrics)
        if message := pages.unreachable_message(plant, quantity, metrics):
            print_text(f"note: {message}")
    for note in words.notes(pages.run_findings(study, audit)):
        print_text(f"note: {note}")
    print_table("Positions of the load", *pages.position_table(plant, result))
    if rows:
        print_table("Quality of control", ["metric", "value"], rows)
    rows = []
    for balance in balances:
        closes = "closes" if balance.closes else "DOES NOT\nCLOSE"
        residual = f"{balance.relative_residual:.0e}\n{closes}"
        name = balance.name.replace(" of ", "\nof ")
        rows.append([name, *map("\n".join, pages.balance_terms(balance, 3)), residual])
    caption = "residual: inputs less outputs, over the largest term; zero terms are omitted"
    heads = ["balance", "inputs [J,kg]", "outputs [J,kg]", "residual [-]"]
    print_table("Balances", heads, rows, caption)


COMMANDS = {"simulate": simulate}
