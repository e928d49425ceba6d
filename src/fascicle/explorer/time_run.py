"""Runs of a scenario for the page, in a worker process, in which the simulator is imported.

The table has all steps, as that of `fascicle simulate`; the drawing those that the page plays.
"""

import logging
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.validation import BareNumberWarning
from ..muscle import Muscle
from ..plot.shapes import outlines
from ..plot.theme import Colors, mix
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
_PLATE, _BLOCK, _MARK = 6.0, (44.0, 26.0), 1.2  # mm: thickness; width and height; half of a line
_AROUND = 40  # points of a pulley
_TENDON = 1.0  # mm, half its width
_DROP = 70.0  # mm from the lowest plate to a pulley's middle
_HEADROOM, _FOOT = 54.0, 8.0  # mm for labels above, and below

Number = np.ndarray | float  # one for each frame, or for all
Point = tuple[Number, Number]  # x, y [mm]
Spans = list[tuple[float, float]]  # [mm]
Demand = np.ndarray | None  # of position at each frame [SI]


class Drawing(NamedTuple):
    """Polygons of a bundle in time [mm], y upward from the upper plate.

    - `tubes`: frame, unit, point, axis: outline of one muscle of each unit, at x = 0.
    - `states`: frame, unit: index of `STATES`.
    - `muscles`: unit and x of each muscle.
    - `rigid`: frame, polygon, corner, axis: what moves without bending; `rigid_kinds` of each.
    - `fixed`: kind and corners of what stands still.
    - `labels`: x of the middle of each unit, and the width that it has.
    - `extent`: left, right, low, high.
    """

    tubes: np.ndarray
    states: np.ndarray
    muscles: list[tuple[int, float]]
    rigid: np.ndarray
    rigid_kinds: list[str]
    fixed: list[tuple[str, np.ndarray]]
    labels: list[tuple[float, float]]
    extent: tuple[float, float, float, float]


class PolicyResult(NamedTuple):
    """A run by a `policy`, "" for a schedule.

    `table` of all steps, and `pull` of all muscles on the load at each [SI]; `rows`: indices of the
    samples; `drawing` at them; `doubts`: reasons not to trust the run.
    """

    policy: str
    table: Table
    pull: np.ndarray
    rows: np.ndarray
    drawing: Drawing
    doubts: list[str]


class SimulationResult(NamedTuple):
    """Runs of a scenario under several policies.

    `quantity` controlled: "force", "position" or "" for a schedule; `rotary`: true for a joint;
    `heads` and `policy_rows` of the table of policies, as `fascicle simulate --compare` prints it;
    `notes` on scenario and table.
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
    from ..dynamics import audit
    from ..report import simulation as reports
    from ..report.words import notes as findings_notes
    from ..report.words import words
    from ..results.tables import simulated

    study, notes = _read_limited_scenario(text, name)
    results, runs = [], {}
    for policy in policies or [""]:
        variant = study.with_policy(policy) if policy else study
        run, control, label, demand = variant.run(), variant.control, "", None
        audited = audit(variant.plant, run)
        rows = sample_rows(len(run.time))
        if control is not None:
            label = control.policy
            if policy and policy != label:  # that of fewer units, say
                label = f"{policy} ({label})"
            runs[label] = reports.policy_run(variant, run, audited.doubts)
            if control.controller.of == "position":
                demand = np.append(control.reference, control.reference[-1])[rows]
        controlled = (None, None) if control is None else control[:2]
        table = simulated(variant.plant, run, audited, *controlled)
        # as `control.controlled_output` of a force
        arms = np.asarray(variant.plant.lengths * variant.plant.gains)
        pull = np.sum(arms * np.asarray(run.outputs.forces), axis=-1)
        drawing = bundle_drawing(variant.plant, run.outputs, rows, demand)
        doubts = [words(finding) for finding in audited.doubts]
        results.append(PolicyResult(label, table, pull, rows, drawing, doubts))
        notes += findings_notes(variant.findings)
    quantity, heads, table_rows = "", [], []
    if study.control is not None:
        quantity, metrics = study.control.controller.of, [run.metrics for run in runs.values()]
        front = pareto_front([x.drawdown for x in metrics], [x.supply_energy for x in metrics])
        heads, table_rows = reports.policy_cells(study.plant, quantity, runs, front.tolist())
        notes += reports.policy_notes(study, runs)
    rotary, notes = study.plant.load.unit == "rad", list(dict.fromkeys(notes))
    return SimulationResult(name, quantity, rotary, results, heads, table_rows, notes)


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


def rigid_colors(colors: Colors) -> dict[str, str]:
    """Colors by kind of what is drawn around muscles: plates, rods, load, pulley, arm, demand."""
    return {
        "plate": colors.fitting, "rod": colors.soft, "load": colors.soft, "held": colors.edge,
        "pulley": mix(colors.soft, colors.paper, 0.5), "arm": colors.ink, "demand": colors.bad,
    }  # fmt: skip


def bundle_drawing(
    plant: "Plant", outputs: "PlantOutputs", rows: np.ndarray, demand: Demand
) -> Drawing:
    """Drawing of a run's `outputs` [SI] at the indices `rows`; `demand`: of position [SI] there."""
    P, eps = np.asarray(outputs.pressures)[rows], np.asarray(outputs.strains)[rows]
    q = np.asarray(outputs.position)[rows]
    muscles = [unit.muscle for bundle in plant.bundles for unit in bundle.motor_units]
    low, high = (np.asarray(end) for end in plant.muscles.strains)
    tubes, states = [], []
    for unit, muscle in enumerate(muscles):
        pressure = np.maximum(P[:, unit], 0.0)
        bounded = np.clip(eps, low, high)[:, unit]
        tubes.append(_tube_outlines(muscle, pressure, bounded))
        response = muscle.law.at(pressure[:, None]).response(bounded[:, None])
        states.append(np.asarray(response.region)[:, 0])
    # a unit of shorter muscles hangs on a rod, which keeps its length
    lengths = 1e3 * np.asarray(plant.lengths) * (1 - eps)
    sides = np.asarray(plant.sides)
    plates = np.stack(
        [-lengths[:, sides == side].max(axis=1) for side in range(len(plant.bundles))], axis=1
    )
    rods = -plates[:, sides] - lengths
    array = np.stack(tubes, axis=1)
    array[..., 1] -= rods[:, :, None]
    parts = _Parts(len(rows))
    positions, labels, spans = _place_units(array, np.asarray(plant.counts), sides)
    for unit, x in positions:
        if rods[:, unit].max() > 0.1:  # mm: else it can't be seen
            parts.box(x, _TENDON, -rods[:, unit], 0.0, "rod")
    for side, (left, right) in enumerate(spans):
        middle, half = (left + right) / 2, (right - left) / 2
        parts.box(middle, half, plates[:, side] - _PLATE, plates[:, side], "plate")
        corners = [(left, 0), (right, 0), (right, _PLATE), (left, _PLATE)]
        parts.fixed.append(("plate", np.array(corners)))
    add = _add_joint if plant.load.unit == "rad" else _add_load
    bottom = add(parts, plant, q, plates, spans, demand)
    extent = (spans[0][0] - _GAP, spans[-1][1] + _GAP, bottom - _FOOT, _HEADROOM)
    kinds, rigid = zip(*parts.rigid, strict=True)
    tubes, states = array.astype(np.float32), np.stack(states, axis=1).astype(np.int8)
    rigid = np.stack(rigid, axis=1).astype(np.float32)
    return Drawing(tubes, states, positions, rigid, [*kinds], parts.fixed, labels, extent)


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
    tubes: np.ndarray, counts: np.ndarray, sides: np.ndarray
) -> tuple[list[tuple[int, float]], Spans, Spans]:
    """Unit and x of each muscle; middle and width of each unit; left and right of each bundle."""
    positions, labels, spans, x = [], [], [], 0.0
    for side in range(sides.max() + 1):
        start = x
        for unit in np.flatnonzero(sides == side).tolist():
            left, right = tubes[:, unit, :, 0].min(), tubes[:, unit, :, 0].max()
            begin = x
            for _ in range(int(counts[unit])):
                positions.append((unit, float(x + _GAP / 2 - left)))
                x += float(right - left) + _GAP
            labels.append(((begin + x) / 2, x - begin))
        width = max(x - start, _BLOCK[0] + 2 * _GAP)
        spans.append((start, x))
        x = start + width + 6 * _GAP  # to the other bundle
    middle = (spans[0][0] + spans[-1][1]) / 2
    return (
        [(unit, x - middle) for unit, x in positions],
        [(x - middle, width) for x, width in labels],
        [(left - middle, right - middle) for left, right in spans],
    )


class _Parts:
    """Plates, rods and load: kinds and polygons [mm] of `rigid` ones that move, with four corners
    for each frame, and of `fixed` ones.
    """

    def __init__(self, frames: int):
        self._frames = frames
        self.rigid: list[tuple[str, np.ndarray]] = []
        self.fixed: list[tuple[str, np.ndarray]] = []

    def _add(self, points: list[Point], kind: str) -> None:
        corners = [[np.broadcast_to(z, (self._frames,)) for z in point] for point in points]
        self.rigid.append((kind, np.moveaxis(np.array(corners), -1, 0)))

    def box(self, x: float, half: float, low: np.ndarray, high: Number, kind: str) -> None:
        """Add an upright box around `x`, of `half` its width [mm]."""
        left, right = x - half, x + half
        self._add([(left, low), (right, low), (right, high), (left, high)], kind)

    def line(self, start: Point, end: Point, half: float, kind: str) -> None:
        """Add a line from `start` to `end`, of `half` its width [mm]."""
        (a, b), (c, d) = start, end
        length = np.hypot(np.subtract(c, a), np.subtract(d, b))
        u, v = half * np.subtract(d, b) / length, half * np.subtract(c, a) / length
        self._add([(a - u, b + v), (c - u, d + v), (c + u, d - v), (a + u, b - v)], kind)


def _add_load(
    parts: _Parts, plant: "Plant", q: np.ndarray, plates: np.ndarray, spans: Spans, demand: Demand
) -> float:
    """Add a load that moves straight; returns the lowest y [mm]."""
    (left, right), plate, (width, height) = spans[0], plates[:, 0], _BLOCK
    middle, top = (left + right) / 2, plate - _PLATE - 0.4 * height
    parts.box(middle, _TENDON, top, plate - _PLATE, "rod")
    kind = "held" if plant.load.prescribed else "load"
    parts.box(middle, width / 2, top - height, top, kind)
    if demand is not None:
        # where the lower plate's upper face should be
        target = plate + 1e3 * (demand - q)
        half = (right - left) / 2 + _GAP
        parts.box(middle, half, target - _MARK / 2, target + _MARK / 2, "demand")
    return float((top - height).min())


def _add_joint(
    parts: _Parts, plant: "Plant", q: np.ndarray, plates: np.ndarray, spans: Spans, demand: Demand
) -> float:
    """Add the pulley that two bundles turn, and its arm; returns the lowest y [mm]."""
    radius = 1e3 * float(plant.load.radius)  # type: ignore[attr-defined]
    y = float(plates.min()) - _DROP
    for (left, right), plate, rim in zip(spans, plates.T, (-radius, radius), strict=True):
        parts.line(((left + right) / 2, plate - _PLATE), (rim, y), _TENDON, "rod")
    turn = 2 * np.pi * np.arange(_AROUND) / _AROUND
    circle = np.stack([radius * np.cos(turn), y + radius * np.sin(turn)], axis=1)
    parts.fixed.append(("pulley", circle))
    arm = 2.5 * radius  # the bundle on the left pulls it forward, to the left
    ends = [("arm", q, 3.0)] + ([] if demand is None else [("demand", demand, _MARK / 2)])
    for kind, angle, half in ends:
        parts.line((0.0, y), (-arm * np.sin(angle), y - arm * np.cos(angle)), half, kind)
    return y - arm
