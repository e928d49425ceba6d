"""Pages of runs in time: one run with its energy balances, and one scenario under all policies."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from ..control import control_metrics, controlled_output, reachability
from ..core.findings import Finding
from ..plot.trajectory import Tracking, display_unit, energy_balances, traces
from ..units import format_digits, pretty
from .page import lines, mark, picture, render
from .words import notes, words


if TYPE_CHECKING:
    from ..control import ControlMetrics
    from ..dynamics import Audit, Balance, Plant, Trajectory
    from ..files import Scenario
    from ..files.scenario import ScenarioControl

_FORCE = {"m": "N", "rad": "N·m"}
_REFERENCE = "threshold"  # the policy that energies are compared with
_ROUNDING = 1e-14  # of a balance's largest term: smaller ones are rounded zeros


class PolicyRun(NamedTuple):
    """A policy's run: its controller in `control`, the `run`, its `metrics`, its demand and
    output in `tracking` [SI], and `doubts`, reasons not to trust it.
    """

    control: "ScenarioControl"
    run: "Trajectory"
    metrics: "ControlMetrics"
    tracking: Tracking
    doubts: Sequence[Finding]


def policy_run(scenario: "Scenario", run: "Trajectory", doubts: Sequence[Finding]) -> PolicyRun:
    """A `run` of a `scenario` that has a policy, with its metrics."""
    control, tracking = scenario.control, run_demand(scenario, run)
    assert control is not None
    assert tracking is not None
    return PolicyRun(control, run, run_metrics(control, run), tracking, doubts)


def report(scenario: "Scenario", run: "Trajectory", audit: "Audit", date: str) -> str:
    """Page of a scenario's `run` [SI] with its `audit`, as HTML; `date` of the day, such as
    "2026-05-04".
    """
    plant, control = scenario.plant, None
    if (controlled := scenario.control) is not None:
        quantity, metrics = controlled.controller.of, run_metrics(controlled, run)
        control = {
            "quantity": quantity,
            "rows": metrics_rows(plant, quantity, metrics),
            "unreachable": unreachable_message(plant, quantity, metrics),
        }
    components = (plant.load, plant.chamber, plant.supply, plant.valve, plant.spool)
    balances = audit.balances
    energies = [entry for entry in balances if entry.unit == "J" and entry.name != "first law"]
    rows = []
    for balance in balances:
        share = f"{balance.relative_residual:.0e}, at most {balance.tolerance:g}"
        closes = mark(balance.closes, "closes", "doesn't close", "fails")
        rows.append([balance.name, *map(lines, balance_terms(balance)), share, closes])
    counts = [[f"{int(unit.count)}" for unit in bundle.motor_units] for bundle in plant.bundles]
    return render(
        "simulation.html",
        title=f"Simulation: {scenario.name.replace('_', ' ')}",
        date=date,
        scenario=scenario,
        run=run,
        doubts=[words(finding) for finding in audit.doubts],
        notes=notes(run_findings(scenario, audit)),
        control=control,
        audit=audit,
        worst=max(balances, key=lambda entry: entry.relative_residual),
        units=" and ".join(" + ".join(bundle) for bundle in counts),
        parts=", ".join(type(component).__name__ for component in components),
        steps=len(run.time) - 1,
        turns=plant.load.unit == "rad",
        traces=picture(traces(plant, run, run_demand(scenario, run))),
        moments=position_table(plant, run),
        energies=picture(energy_balances(energies)),
        balances=rows,
    )


def run_findings(scenario: "Scenario", audit: "Audit") -> list[Finding]:
    """Findings of a run: on the scenario's settings, and of the `audit`."""
    return [*scenario.findings, *audit.findings]


def run_metrics(controlled: "ScenarioControl", run: "Trajectory") -> "ControlMetrics":
    """Metrics of a controlled `run` [SI]."""
    return control_metrics(controlled.controller, run, controlled.reference)


def run_demand(scenario: "Scenario", run: "Trajectory") -> Tracking | None:
    """A run's demand, controlled output and reachable steps [SI]; none for a run by schedule."""
    if (controlled := scenario.control) is None:
        return None
    controller, reference = controlled.controller, controlled.reference
    can = reachability(controller, run.outputs, reference).is_reachable
    return Tracking(controller.of, reference, controlled_output(controller, run), can)


def metrics_rows(plant: "Plant", quantity: str, metrics: "ControlMetrics") -> list[tuple[str, str]]:
    """Rows of the metrics of controlling a `quantity`: labels with units, and numbers."""
    factor, unit = display_unit(plant, quantity)
    rows = [
        (f"drawdown while the demand rises [{unit}]", factor * metrics.drawdown),
        ("deepest dip of force of a motor unit [N]", metrics.dip),
        (f"root mean square of the error [{unit}]", factor * metrics.rms),
        (f"largest error [{unit}]", factor * metrics.largest_error),
        ("lag [ms]", 1e3 * metrics.lag),
        ("energy from the supply [J]", metrics.supply_energy),
        ("fluid from the supply [g]", 1e3 * metrics.fluid),
        ("recruitments of a motor unit [-]", metrics.recruited),
        (f"demands out of reach, of {metrics.moments} [-]", metrics.unreachable),
    ]
    return [(label, f"{number:.4g}") for label, number in rows]


def control_text(scenario: "Scenario") -> str:
    """Quantity that a scenario controls, its policy, and its gains by the keys of a file, or its
    schedule.
    """
    plant = scenario.plant
    if (controlled := scenario.control) is None:
        assert scenario.schedule is not None
        number = len(scenario.schedule.times)
        return f"No control: valves follow a schedule of {number} command{'s' * (number != 1)}"
    controller, is_rotation = controlled.controller, plant.load.unit == "rad"
    gains, prefix = controller.gains, "angular_" if is_rotation else ""
    quantity = "moment" if is_rotation else "force"
    values = {
        "force_gain": format_digits(float(gains.force)),
        "force_integral_time": _time_text(float(gains.force_integral)),
    }
    if controller.of == "position":
        quantity = "joint angle" if is_rotation else "contraction"
        values = {
            "position_gain": pretty(float(gains.position), f"{prefix}stiffness"),
            "integral_time": _time_text(float(gains.integral) / (float(gains.position) or 1.0)),
            "velocity_gain": pretty(float(gains.velocity), f"{prefix}damping"),
        }
    values["pressure_time"] = pretty(float(gains.pressure_time), "time")
    texts = ", ".join(f"{key} {text}" for key, text in values.items())
    return f"Control of {quantity} by {controlled.policy} ({texts})"


def _time_text(rate: float) -> str:
    """Text of the time that a `rate` [1/s] is the inverse of."""
    return "none" if rate == 0 else pretty(1 / rate, "time")


def unreachable_message(plant: "Plant", quantity: str, metrics: "ControlMetrics") -> str:
    """Sentence on unreachable demands; empty if there were none."""
    if not metrics.unreachable:
        return ""
    where = (
        "" if quantity == "position" or plant.load.prescribed else " where the load has moved to"
    )
    lack = f"the force lacks up to {metrics.short:.4g} {_FORCE[plant.load.unit]}"
    if quantity == "position" and metrics.short == 0:
        lack = "they lie outside the range of the load"
    return (
        f"{metrics.unreachable} of {metrics.moments} demands, from {metrics.first:.4g} s to"
        f" {metrics.last:.4g} s, can't be reached at the supply pressure by any policy"
        f"{where}: {lack}; errors and lag are those of the other demands"
    )


def position_table(plant: "Plant", run: "Trajectory") -> tuple[list[str], list[list[str]]]:
    """Heads and rows of positions and pressures at the start, the end and the extremes."""
    factor, unit = display_unit(plant, "position")
    q = factor * np.asarray(run.outputs.position)
    names = [*(f"P{i + 1} [kPa]" for i in range(plant.units)), "supply [kPa]"]
    marks = {"start": 0, "lowest": int(q.argmin()), "highest": int(q.argmax()), "end": len(q) - 1}
    rows = []
    for name, k in marks.items():
        pressures = [*run.outputs.pressures[k], run.outputs.supply_pressure[k]]
        texts = [f"{round(float(P) / 1e3, 1) + 0.0:.1f}" for P in pressures]
        rows.append([name, f"{run.time[k]:g}", f"{q[k]:.2f}", *texts])
    return ["", "time [s]", f"position [{unit}]", *names], rows


def balance_terms(balance: "Balance", digits: int = 4) -> list[list[str]]:
    """Texts of the inputs of a balance, and of its outputs, without rounded zeros."""
    smallest = _ROUNDING * max(map(abs, (balance.inputs | balance.outputs).values()))
    return [
        [f"{name} {x:.{digits}g} {balance.unit}" for name, x in side.items() if abs(x) > smallest]
        for side in (balance.inputs, balance.outputs)
    ]


def policy_report(
    scenario: "Scenario",
    runs: Mapping[str, PolicyRun],
    front: Sequence[bool],
    figure: Figure,
    date: str,
) -> str:
    """Page of one scenario under all policies, as HTML: `runs` by policy [SI], which of them are on
    the `front` of drawdown against energy, their `figure`, and the `date` of the day.
    """
    quantity = next(iter(runs.values())).tracking.quantity
    heads, rows = policy_cells(scenario.plant, quantity, runs, front)
    return render(
        "policies.html",
        title=f"Policies: {scenario.name.replace('_', ' ')}",
        date=date,
        scenario=scenario,
        runs=runs,
        quantity=quantity,
        front=[name for name, on_front in zip(runs, front, strict=True) if on_front],
        notes=policy_notes(scenario, runs),
        figure=picture(figure),
        heads=heads,
        rows=rows,
    )


def policy_cells(
    plant: "Plant", quantity: str, runs: Mapping[str, PolicyRun], front: Sequence[bool]
) -> tuple[list[str], list[list[str]]]:
    """Heads and rows of the table of policies: `runs` by policy [SI], and those on the `front`."""
    factor, unit = display_unit(plant, quantity)
    reference = runs[_REFERENCE].metrics.supply_energy if _REFERENCE in runs else 0.0
    heads, rows = [], []
    for (name, run), on_front in zip(runs.items(), front, strict=True):
        value = run.metrics
        cells = {"policy": name, f"drawdown [{unit}]": f"{factor * value.drawdown:.4g}"}
        if quantity == "force":
            ratio = f"{value.drawdown / value.dip:.3f}" if value.dip else "-"
            cells["drawdown/D [-]"] = ratio
        excess = f"{100 * (value.supply_energy / reference - 1):+.1f}" if reference else "-"
        cells |= {
            f"rms error [{unit}]": f"{factor * value.rms:.4g}",
            "lag [ms]": f"{1e3 * value.lag:.4g}",
            "energy [J]": f"{value.supply_energy:.4g}",
            "energy above threshold's [%]": excess,
            "fluid [g]": f"{1e3 * value.fluid:.4g}",
            "recruitments [-]": f"{value.recruited}",
            "front": "front" if on_front else "",
            "": "can't be trusted" if run.doubts else "",
        }
        heads, rows = [*cells], [*rows, [*cells.values()]]
    return heads, rows


def policy_notes(scenario: "Scenario", runs: Mapping[str, PolicyRun]) -> list[str]:
    """Notes on the table of policies."""
    quantity = next(iter(runs.values())).tracking.quantity
    notes = []
    if scenario.plant.units == 1:
        notes.append("one motor unit alone: nothing is handed over, and policies don't differ")
    if quantity == "position":
        notes.append("drawdown/D is only for scenarios that follow a force: D is a dip of force")
    worst = max((run.metrics for run in runs.values()), key=lambda value: value.unreachable)
    if worst.unreachable:
        notes.append(unreachable_message(scenario.plant, quantity, worst))
    return notes
