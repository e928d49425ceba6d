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

from ..core.validation import BareNumberWarning
from ..plot.shapes import outlines
from ..plot.theme import Colors, mix
from ..results import Table
from .state import MOST_MUSCLES, MOST_UNITS


if TYPE_CHECKING:
    from ..dynamics import Plant, PlantOutputs
    from ..files import Scenario
    from ..report.simulation import PolicyRun

MOST_SAMPLES = 601  # of a run on the page: a chart has as many pixels on a small screen
MOST_STEPS = 20_000  # of a run: with every policy a visitor's tables take a hundred megabytes
# by the regions of a muscle's response
STATES = ("pulling", "buckled", "collapsed", "pushing straight")
ALPHAS, HATCHED = (0.85, 0.4, 0.12, 0.85), (False, False, True, False)  # of a tube in each state
_ALONG = 25  # points of either side of a tube: a hinge is sharp on a page
_GAP = 5.0  # mm between muscles
_PLATE, _BLOCK, _MARK = 6.0, (44.0, 26.0), 1.2  # mm: thickness; width and height; half of a line
_AROUND = 40  # points of a pulley
_TENDON = 1.0  # mm, half its width
_DROP = 70.0  # mm from the lowest plate to a pulley's middle
_HEADROOM, _FOOT = 54.0, 8.0  # mm for labels above, and below


class Drawing(NamedTuple):
    """Polygons of a bundle in time [mm], y upward from the upper plate.

    - `tubes`: frame, unit, point, axis: outline of one muscle of each unit, at x = 0.
    - `states`: frame, unit: index of `STATES`.
    - `muscles`: unit and x of each muscle.
    - `rigid`: frame, polygon, corner, axis: what moves without bending; `rigid_kinds` of each.
    - `fixed`: polygon, corner, axis: what stands still; `fixed_kinds` of each.
    - `labels`: x of the middle of each unit, and the width that it has.
    - `extent`: left, right, low, high.
    """

    tubes: np.ndarray
    states: np.ndarray
    muscles: list[tuple[int, float]]
    rigid: np.ndarray
    rigid_kinds: list[str]
    fixed: list[np.ndarray]
    fixed_kinds: list[str]
    labels: list[tuple[float, float]]
    extent: tuple[float, float, float, float]


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
    from ..dynamics import audit
    from ..report import simulation as reports
    from ..results.tables import simulated

    run, control = study.run(), study.control
    audited = audit(study.plant, run)
    controller, reference = (None, None) if control is None else control[:2]
    table = simulated(study.plant, run, audited, controller, reference)
    policy_run = demand = None
    rows = sample_rows(len(run.time))
    if control is not None:
        tracking = reports.run_demand(study, run)
        assert tracking is not None
        control_metrics = reports.run_metrics(control, run)
        policy_run = reports.PolicyRun(control, run, control_metrics, tracking, audited.doubts)
        if tracking.quantity == "position":
            demand = np.append(tracking.demand, tracking.demand[-1])[rows]
    drawing = bundle_drawing(study.plant, run.outputs, rows, demand)
    # as `control.controlled_output` of a force
    arms = np.asarray(study.plant.lengths * study.plant.gains)
    pull = np.sum(arms * np.asarray(run.outputs.forces), axis=-1)
    notes = [*notes, *reports.scenario_notes(study)]
    return PolicyResult(label, table, pull, rows, drawing, notes, audited.doubts), policy_run


def sample_rows(moments: int) -> np.ndarray:
    """Indices of at most `MOST_SAMPLES` even samples of so many `moments`, with the last one."""
    stride = -(-(moments - 1) // (MOST_SAMPLES - 1)) or 1
    return np.unique(np.r_[np.arange(0, moments, stride), moments - 1])


# the drawing


def rigid_colors(colors: Colors) -> dict[str, str]:
    """Colors by kind of what is drawn around muscles: plates, rods, load, pulley, arm, demand."""
    return {
        "plate": colors.fitting, "rod": colors.soft, "load": colors.soft, "held": colors.edge,
        "pulley": mix(colors.soft, colors.paper, 0.5), "arm": colors.ink, "demand": colors.bad,
    }  # fmt: skip


def bundle_drawing(
    plant: "Plant", outputs: "PlantOutputs", rows: np.ndarray, demand: np.ndarray | None
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
    parts = _RigidParts(len(rows))
    positions, labels, spans = _place_units(array, np.asarray(plant.counts), sides)
    for unit, x in positions:
        if rods[:, unit].max() > 0.1:  # mm: else it can't be seen
            parts.bar(x, -rods[:, unit], 0.0 * rods[:, unit], "rod")
    for side, (left, right) in enumerate(spans):
        parts.box(left, right, plates[:, side] - _PLATE, plates[:, side], "plate")
        parts.fix([(left, 0), (right, 0), (right, _PLATE), (left, _PLATE)], "plate")
    if plant.load.unit == "rad":
        bottom = _add_joint(parts, plant, q, plates, spans, demand)
    else:
        bottom = _add_load(parts, plant, q, plates[:, 0], spans[0], demand)
    extent = (spans[0][0] - _GAP, spans[-1][1] + _GAP, bottom - _FOOT, _HEADROOM)
    return Drawing(
        array.astype(np.float32), np.stack(states, axis=1).astype(np.int8), positions,
        np.stack(parts.rigid, axis=1).astype(np.float32), parts.rigid_kinds, parts.fixed,
        parts.fixed_kinds, labels, extent,
    )  # fmt: skip


def _tube_outlines(muscle: object, pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Outlines [mm] of a muscle that hangs from y = 0, at each `pressure` [Pa] and `strain` [-]."""
    shapes = []
    for shape in outlines(muscle, pressure, strain):  # type: ignore[arg-type]
        sides = [
            np.stack([shape.y + r * shape.normal[1], -(shape.z + r * shape.normal[0])], axis=1)
            for r in (shape.above, -shape.below)
        ]
        points = np.linspace(0, len(shape.z) - 1, _ALONG).astype(int)
        shapes.append(np.concatenate([sides[0][points], sides[1][points[::-1]]]))
    return 1e3 * np.array(shapes)


def _place_units(
    tubes: np.ndarray, counts: np.ndarray, sides: np.ndarray
) -> tuple[list[tuple[int, float]], list[tuple[float, float]], list[tuple[float, float]]]:
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


Point = tuple[np.ndarray | float, np.ndarray | float]  # x, y [mm], numbers or one a frame


class _RigidParts:
    """Collector of polygons [mm] of plates, rods and load: `rigid` ones that move, for each frame,
    and `fixed` ones.
    """

    def __init__(self, frames: int):
        self._frames = frames
        self.rigid: list[np.ndarray] = []
        self.rigid_kinds: list[str] = []
        self.fixed: list[np.ndarray] = []
        self.fixed_kinds: list[str] = []

    def corners(self, points: list[Point], kind: str) -> None:
        """Add a polygon of four corners x, y [mm], each a number or one for each frame."""
        shape = (self._frames,)
        polygon = [np.stack([np.broadcast_to(z, shape) for z in point], axis=1) for point in points]
        self.rigid.append(np.stack(polygon, axis=1))
        self.rigid_kinds.append(kind)

    def box(self, left: float, right: float, low: np.ndarray, high: np.ndarray, kind: str) -> None:
        """Add a box [mm]."""
        self.corners([(left, low), (right, low), (right, high), (left, high)], kind)

    def bar(self, x: float, low: np.ndarray, high: np.ndarray, kind: str) -> None:
        """Add a thin upright bar at `x` [mm]."""
        self.box(x - _TENDON, x + _TENDON, low, high, kind)

    def line(self, start: Point, end: Point, half: float, kind: str) -> None:
        """Add a line from `start` to `end` [mm], of `half` its width [mm]."""
        (a, b), (c, d) = start, end
        length = np.hypot(np.subtract(c, a), np.subtract(d, b))
        u, v = half * np.subtract(d, b) / length, half * np.subtract(c, a) / length
        self.corners([(a - u, b + v), (c - u, d + v), (c + u, d - v), (a + u, b - v)], kind)

    def fix(self, points: list[tuple[float, float]], kind: str) -> None:
        """Add a polygon that stands still [mm]."""
        self.fixed.append(np.array(points, float))
        self.fixed_kinds.append(kind)


def _add_load(
    parts: _RigidParts, plant: "Plant", q: np.ndarray, plate: np.ndarray, span: tuple[float, float],
    demand: np.ndarray | None,
) -> float:  # fmt: skip
    """Add a load that moves straight; returns the lowest y [mm]."""
    middle, (width, height) = (span[0] + span[1]) / 2, _BLOCK
    top = plate - _PLATE - 0.4 * height
    parts.bar(middle, top, plate - _PLATE, "rod")
    kind = "held" if plant.load.prescribed else "load"
    parts.box(middle - width / 2, middle + width / 2, top - height, top, kind)
    if demand is not None:
        # where the lower plate's upper face should be
        target = plate + 1e3 * (demand - q)
        parts.box(span[0] - _GAP, span[1] + _GAP, target - _MARK / 2, target + _MARK / 2, "demand")
    return float((top - height).min())


def _add_joint(
    parts: _RigidParts, plant: "Plant", q: np.ndarray, plates: np.ndarray,
    spans: list[tuple[float, float]], demand: np.ndarray | None,
) -> float:  # fmt: skip
    """Add the pulley that two bundles turn, and its arm; returns the lowest y [mm]."""
    radius = 1e3 * float(plant.load.radius)  # type: ignore[attr-defined]
    y = float(plates.min()) - _DROP
    for (left, right), plate, rim in zip(spans, plates.T, (-radius, radius), strict=True):
        parts.line(((left + right) / 2, plate - _PLATE), (rim, y), _TENDON, "rod")
    turn = 2 * np.pi * np.arange(_AROUND) / _AROUND
    circle = zip(radius * np.cos(turn), y + radius * np.sin(turn), strict=True)
    parts.fix([(float(a), float(b)) for a, b in circle], "pulley")
    arm = 2.5 * radius  # the bundle on the left pulls it forward, to the left
    ends = [("arm", q, 3.0)] + ([] if demand is None else [("demand", demand, _MARK / 2)])
    for kind, angle, half in ends:
        end = (-arm * np.sin(angle), y - arm * np.cos(angle))
        parts.line((0.0, y), end, half, kind)
    return y - arm
