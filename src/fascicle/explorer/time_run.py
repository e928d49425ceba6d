"""Runs of a scenario for the page, in a worker process, in which the simulator is imported.

The table has all steps, as that of `fascicle simulate`; the drawing those that the page plays.
"""

import logging
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from ..core.validation import BareNumberWarning
from ..muscle import Muscle
from ..plot.shapes import outlines
from ..plot.theme import Colors
from ..plot.trajectory import traces
from ..results import Table
from .state import MOST_MUSCLES, MOST_UNITS


if TYPE_CHECKING:
    from ..dynamics import Plant, PlantOutputs
    from ..files import Scenario

MOST_SAMPLES = 601  # of a run on the page: a chart has as many pixels on a small screen
MOST_STEPS = 20_000  # of a run: with every policy a visitor's tables take a hundred megabytes
# by the regions of a muscle's response
STATES = ("pulling", "buckled", "collapsed", "pushing straight")
ALPHAS, HATCHES = (0.85, 0.4, 0.12, 0.85), (" ", " ", "right_diagonal_line", " ")
_ALONG = 25  # points of either side of a tube: a hinge is sharp on a page
_GAP = 5.0  # mm between muscles
_PLATE, _BLOCK, _MARK = 6.0, (44.0, 26.0), 1.2  # mm: thickness; width and height; of a line
_ROD = 1.0  # mm, half its width
_HEADROOM, _FOOT = 54.0, 8.0  # mm for labels above, and below

Demand = np.ndarray | None  # of position at each frame [SI]


class Drawing(NamedTuple):
    """Polygons of a bundle in time [mm], y upward from the upper plate.

    - `tubes`: frame, unit, point, axis: outline of one muscle of each unit, at x = 0.
    - `states`: frame, unit: index of `STATES`.
    - `muscles`: unit and x of each muscle.
    - `boxes`: kind, left and right of plates, rods and load; `heights`: frame, box, low and high.
    - `labels`: x of the middle of each unit, and the width that it has.
    - `extent`: left, right, low, high.
    """

    tubes: np.ndarray
    states: np.ndarray
    muscles: list[tuple[int, float]]
    boxes: list[tuple[str, float, float]]
    heights: np.ndarray
    labels: list[tuple[float, float]]
    extent: tuple[float, float, float, float]


class Measures(NamedTuple):
    """How well a policy follows its demand: `drawdown`, `dip` and `rms` error [N] of a force, or
    [m] of a position, and the `energy` from the supply [J].
    """

    drawdown: float
    dip: float
    rms: float
    energy: float


class PolicyResult(NamedTuple):
    """A run by a `policy`, "" for a schedule.

    `table` of all steps, and `pull` of all muscles on the load at each [SI]; `rows`: indices of the
    samples; `drawing` at them; `figure`: as of the command; `doubts`: reasons not to trust the run;
    `measures`: none of a schedule.
    """

    policy: str
    table: Table
    pull: np.ndarray
    rows: np.ndarray
    drawing: Drawing
    figure: Figure
    doubts: list[str]
    measures: Measures | None


class SimulationResult(NamedTuple):
    """Runs of a scenario under several policies.

    `quantity` controlled: "force", "position" or "" for a schedule; `notes` on the runs.
    """

    name: str
    quantity: str
    runs: list[PolicyResult]
    notes: list[str]


def run_policies(text: str, name: str, policies: Sequence[str]) -> SimulationResult:
    """Run the scenario of a `text` under each of the `policies`, or its own if there are none."""
    from ..dynamics import audit
    from ..report import simulation as reports
    from ..report.words import notes as findings_notes
    from ..report.words import words
    from ..results.tables import simulated

    study, notes = _read_limited_scenario(text, name)
    results, runs = [], {}
    for policy in policies or [""]:
        variant = study.with_policy(policy) if policy else study
        run, control, label, demand, measures = variant.run(), variant.control, "", None, None
        audited = audit(variant.plant, run)
        rows = sample_rows(len(run.time))
        if control is not None:
            label = control.policy
            if policy and policy != label:  # that of fewer units, say
                label = f"{policy} ({label})"
            runs[label] = reports.policy_run(variant, run, audited.doubts)
            metrics = runs[label].metrics
            measures = Measures(metrics.drawdown, metrics.dip, metrics.rms, metrics.supply_energy)
            if control.controller.of == "position":
                demand = np.append(control.reference, control.reference[-1])[rows]
        controlled = (None, None) if control is None else control[:2]
        table = simulated(variant.plant, run, audited, *controlled)
        # as `control.controlled_output` of a force
        arms = np.asarray(variant.plant.lengths * variant.plant.gains)
        pull = np.sum(arms * np.asarray(run.outputs.forces), axis=-1)
        drawing = bundle_drawing(variant.plant, run.outputs, rows, demand)
        doubts = [words(finding) for finding in audited.doubts]
        figure = traces(variant.plant, run, runs[label].tracking if label else None)
        results.append(PolicyResult(label, table, pull, rows, drawing, figure, doubts, measures))
        notes += findings_notes(variant.findings)
    if study.control is not None:
        notes += reports.policy_notes(study, runs)
    quantity = "" if study.control is None else study.control.controller.of
    return SimulationResult(name, quantity, results, [*dict.fromkeys(notes)])


def _read_limited_scenario(text: str, name: str) -> tuple["Scenario", list[str]]:
    """A scenario within the page's limits, and warnings about it."""
    for library in ("jax", "matplotlib"):
        logging.getLogger(library).setLevel(logging.CRITICAL)
    from ..files.scenario import loads_scenario

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        warnings.simplefilter("ignore", BareNumberWarning)  # files have units
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
    return study, [str(entry.message) for entry in caught if entry.category is UserWarning]


def sample_rows(moments: int) -> np.ndarray:
    """Indices of at most `MOST_SAMPLES` even samples of so many `moments`, with the last one."""
    stride = -(-(moments - 1) // (MOST_SAMPLES - 1)) or 1
    return np.unique(np.r_[np.arange(0, moments, stride), moments - 1])


def box_colors(colors: Colors) -> dict[str, str]:
    """Colors of boxes by kind: plates, rods, a load that hangs or is held, its demand."""
    return {
        "plate": colors.fitting, "rod": colors.soft, "load": colors.soft, "held": colors.edge,
        "demand": colors.bad,
    }  # fmt: skip


def bundle_drawing(
    plant: "Plant", outputs: "PlantOutputs", rows: np.ndarray, demand: Demand
) -> Drawing:
    """Drawing of a run's `outputs` [SI] at the indices `rows`; `demand`: of position [SI] there."""
    P, eps = np.asarray(outputs.pressures)[rows], np.asarray(outputs.strains)[rows]
    low, high = (np.asarray(end) for end in plant.muscles.strains)
    tubes, states = [], []
    for unit, muscle in enumerate(unit.muscle for unit in plant.bundles[0].motor_units):
        pressure = np.maximum(P[:, unit], 0.0)
        bounded = np.clip(eps, low, high)[:, unit]
        tubes.append(_tube_outlines(muscle, pressure, bounded))
        response = muscle.law.at(pressure[:, None]).response(bounded[:, None])
        states.append(np.asarray(response.region)[:, 0])
    # a unit of shorter muscles hangs on a rod, which keeps its length
    lengths = 1e3 * np.asarray(plant.lengths) * (1 - eps)
    plate = -lengths.max(axis=1)
    rods = -plate[:, None] - lengths
    array = np.stack(tubes, axis=1)
    array[..., 1] -= rods[:, :, None]
    muscles, labels, half = _place_units(array, np.asarray(plant.counts))
    width, height = _BLOCK
    top = plate - _PLATE - 0.4 * height
    boxes = [
        ("plate", half, 0.0, 0.0, _PLATE), ("plate", half, 0.0, plate - _PLATE, plate),
        ("rod", _ROD, 0.0, top, plate - _PLATE),
        ("held" if plant.load.prescribed else "load", width / 2, 0.0, top - height, top),
    ]  # fmt: skip
    hung = [(unit, x) for unit, x in muscles if rods[:, unit].max() > 0.1]  # mm, to be seen
    boxes += [("rod", _ROD, x, -rods[:, unit], 0.0) for unit, x in hung]
    if demand is not None:  # where the lower plate's upper face should be
        target = plate + 1e3 * (demand - np.asarray(outputs.position)[rows])
        boxes.append(("demand", half + _GAP, 0.0, target - _MARK / 2, target + _MARK / 2))
    heights = np.array([np.broadcast_arrays(*box[3:], plate)[:2] for box in boxes])
    reach = max(half, width / 2) + _GAP
    return Drawing(
        tubes=array.astype(np.float32),
        states=np.stack(states, axis=1).astype(np.int8),
        muscles=muscles,
        boxes=[(kind, x - half_width, x + half_width) for kind, half_width, x, *_ in boxes],
        heights=np.moveaxis(heights, -1, 0).astype(np.float32),
        labels=labels,
        extent=(-reach, reach, float((top - height).min()) - _FOOT, _HEADROOM),
    )


def _tube_outlines(muscle: Muscle, pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Outlines [mm] of a muscle that hangs from y = 0, at each `pressure` [Pa] and `strain` [-]."""
    shapes = []
    for shape in outlines(muscle, pressure, strain):
        sides = [
            np.stack([shape.y + r * shape.normal[1], -(shape.z + r * shape.normal[0])], axis=1)
            for r in (shape.above, -shape.below)
        ]
        points = np.linspace(0, len(shape.z) - 1, _ALONG).astype(int)
        shapes.append(np.concatenate([sides[0][points], sides[1][points[::-1]]]))
    return 1e3 * np.array(shapes)


def _place_units(
    tubes: np.ndarray, counts: np.ndarray
) -> tuple[list[tuple[int, float]], list[tuple[float, float]], float]:
    """Unit and x of each muscle; middle and width of each unit; half of all their width [mm]."""
    low, high = tubes[..., 0].min(axis=(0, 2)), tubes[..., 0].max(axis=(0, 2))
    pitch = high - low + _GAP  # of each unit's muscles
    ends = np.cumsum(counts * pitch)
    starts, half = ends - counts * pitch, float(ends[-1]) / 2
    muscles = [
        (unit, float(starts[unit] + k * pitch[unit] + _GAP / 2 - low[unit]) - half)
        for unit, count in enumerate(counts.astype(int).tolist())
        for k in range(count)
    ]
    middles = (starts + ends) / 2 - half
    return muscles, list(zip(middles.tolist(), (ends - starts).tolist(), strict=True)), half
