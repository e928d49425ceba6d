"""Runs of a scenario for the page, in a worker process, in which the simulator is imported.

A run gives the table of `fascicle simulate`, all steps of it, and the drawing at a number of
`samples`, at which the page plays it.
"""

import logging
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..results import Table
from .state import MOST_MUSCLES, MOST_UNITS
from .time_drawing import Drawing, bundle_drawing


if TYPE_CHECKING:
    from ..files import Scenario
    from ..report.simulation import PolicyRun

MOST_SAMPLES = 601  # of a run on the page: a chart has as many pixels on a small screen
MOST_STEPS = 20_000  # of a run: with every policy a visitor's tables take a hundred megabytes


class PolicyResult(NamedTuple):
    """A run by a `policy`, "" for a schedule.

    `table` of all steps, and `pull` of all muscles on the load at each [SI]; `rows`: indices of the
    samples; `drawing` at them; `notes` on the scenario and warnings; `doubts`: reasons not to trust
    the run.
    """

    policy: str
    table: Table
    pull: np.ndarray
    rows: np.ndarray
    drawing: Drawing
    notes: list[str]
    doubts: list[str]


class SimulationResult(NamedTuple):
    """Runs of a scenario under several policies.

    `quantity` controlled: "force", "position" or "" for a schedule; `rotary`: true for a joint;
    `heads` and `policy_rows` of the table of policies, as `fascicle simulate --compare` prints it,
    and `notes` on it.
    """

    name: str
    quantity: str
    rotary: bool
    runs: list[PolicyResult]
    heads: list[str]
    policy_rows: list[list[str]]
    notes: list[str]


def run_policies(text: str, name: str, policies: Sequence[str]) -> SimulationResult:
    """Run the scenario of a `text` under each of the `policies`, or its own if there are none."""
    from ..control import pareto_front
    from ..report import simulation as reports

    study, notes = _read_limited_scenario(text, name)
    results, runs = [], {}
    for variant, label in _variants(study, policies):
        result, run = _run_policy(variant, label, [] if results else notes)
        results.append(result)
        if run is not None:
            runs[label] = run
    quantity, heads, table_rows, remarks = "", [], [], []
    if runs:
        assert study.control is not None
        quantity, metrics = study.control.controller.of, [run.metrics for run in runs.values()]
        fronts = pareto_front(
            [x.drawdown for x in metrics], [x.supply_energy for x in metrics]
        ).tolist()
        heads, table_rows = reports.policy_cells(study.plant, quantity, runs, fronts)
        remarks = reports.policy_notes(study, runs)
    rotary = study.plant.load.unit == "rad"
    return SimulationResult(name, quantity, rotary, results, heads, table_rows, remarks)


def _read_limited_scenario(text: str, name: str) -> tuple["Scenario", list[str]]:
    """A scenario within the page's limits, and warnings about it."""
    for library in ("jax", "matplotlib"):
        logging.getLogger(library).setLevel(logging.CRITICAL)
    from ..core.validation import disable_pressure_unit_warning
    from ..files.scenario import loads_scenario

    disable_pressure_unit_warning()  # files have units
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        study = loads_scenario(text, name, name=Path(name).stem)
    steps, plant = round(study.duration / study.dt), study.plant
    remedy = "use `fascicle simulate`"
    if steps > MOST_STEPS:
        raise ValueError(f"{name}: a run may have {MOST_STEPS} steps here, got {steps}: {remedy}.")
    muscles = int(np.sum(plant.counts))
    if plant.units > MOST_UNITS or muscles > MOST_MUSCLES:
        raise ValueError(
            f"{name}: the page draws {MOST_UNITS} motor units and {MOST_MUSCLES} muscles at most,"
            f" got {plant.units} and {muscles}: {remedy}."
        )
    notes = [str(entry.message) for entry in caught if entry.category is UserWarning]
    return study, list(dict.fromkeys(notes))


def _variants(study: "Scenario", policies: Sequence[str]) -> Any:
    """The scenario under each of the `policies`, with a label."""
    if study.control is None or not policies:
        yield study, "" if study.control is None else study.control.policy
        return
    for policy in policies:
        variant = study.with_policy(policy)
        assert variant.control is not None
        chosen = variant.control.policy
        yield variant, policy if policy == chosen else f"{policy} ({chosen})"


def _run_policy(
    study: "Scenario", label: str, notes: list[str]
) -> tuple[PolicyResult, "PolicyRun | None"]:
    """Run a `study`: its result, with `notes` before its own, and its row of the table of policies
    if it has a policy.
    """
    from ..dynamics.audit import audit_run
    from ..report import simulation as reports
    from ..results.tables import simulated

    run, control = study.run(), study.control
    audit, doubts = audit_run(study.plant, run)
    controller, reference = (None, None) if control is None else control[:2]
    table = simulated(study.plant, run, audit, controller, reference)
    policy_run = demand = None
    rows = sample_rows(len(run.time))
    if control is not None:
        tracking = reports.run_demand(study, run)
        assert tracking is not None
        control_metrics = reports.run_metrics(control, run)
        policy_run = reports.PolicyRun(control, run, control_metrics, tracking, doubts)
        if tracking.quantity == "position":
            demand = np.append(tracking.demand, tracking.demand[-1])[rows]
    drawing = bundle_drawing(study.plant, run.outputs, rows, demand)
    # as `control.controlled_output` of a force
    arms = np.asarray(study.plant.lengths * study.plant.gains)
    pull = np.sum(arms * np.asarray(run.outputs.forces), axis=-1)
    notes = [*notes, *study.notes]
    return PolicyResult(label, table, pull, rows, drawing, notes, doubts), policy_run


def sample_rows(moments: int) -> np.ndarray:
    """Indices of at most `MOST_SAMPLES` even samples of so many `moments`, with the last one."""
    stride = -(-(moments - 1) // (MOST_SAMPLES - 1)) or 1
    return np.unique(np.r_[np.arange(0, moments, stride), moments - 1])
