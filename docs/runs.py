"""Runs that pages only tell of: maps of sines, by one muscle and four others and by five as one;
a stride with and without friction fed forward; and a fit of a record whose load cell can't push.

python docs/runs.py docs/_static/runs.json
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import fascicle as fs
from fascicle import control, fluid
from fascicle.records import VirtualDynamometer
from fascicle.units import pretty


FREQUENCIES, AMPLITUDES = [0.5, 1.0, 1.5, 2.0], [2e-3, 4e-3, 6e-3, 8e-3, 10e-3]  # Hz, m
MEAN, SUPPLY = 12.7e-3, 413.7e3  # m, Pa
SINES = {
    "threshold": ("sine_1_4", "threshold"),
    "hand_over": ("sine_1_4", "hand_over"),
    "one unit of five": ("sine_1x5", "orderly"),
}


def told(name: str, policy: str) -> dict[str, Any]:
    """A map of a scenario [-] with a policy [-]: errors [-], and the system's efficiency [-]."""
    scenario = fs.example(name)
    controller = scenario.with_policy(policy).control.controller
    found = control.frequency_response(
        scenario.plant, controller, MEAN, AMPLITUDES, FREQUENCIES, scenario.start
    )
    spent = control.shaft_work(found, SUPPLY, fluid.OIL.reference_density)
    return {
        "error": _short(found.error),
        "efficiency": {unit: _short(found.work / work) for unit, work in spent.items()},
        "trusted": bool(np.all(found.is_valid)),
        "held": bool(np.all(found.reachable_share == 1)),
    }


def missed(compensate: bool) -> float:
    """The root mean square of what a stride is missed by [deg]."""
    one = fs.example("joint_gait").with_policy(compensate=compensate)
    worth = control.control_metrics(one.control.controller, one.run(), one.control.reference)
    return float(f"{np.degrees(worth.rms):.5g}")


def clipped() -> list[str]:
    """What a fit says of a synthetic record that is clipped at zero [-]."""
    truth = fs.example("kim2021_slenderness_10")
    muscle = fs.Muscle.from_dimensions(
        length=truth.length,
        outer_radius=truth.outer_radius,
        wall_thickness=truth.wall_thickness,
        braid_angle=truth.braid_angle,
        material="silicone_kim2021",
    )
    record = VirtualDynamometer(samples=20, clip=True).record(truth, seed=4)
    pulled = fs.calibrate.fit(record, muscle)
    values = [
        f"{one.name:24s} {pretty(one.value, one.dimension, 3):>12s}"
        f"   identifiable: {one.identifiable}"
        for one in pulled.parameters
    ]
    return [*values, *(f"- {line}" for line in pulled.warnings)]


def _short(values: np.ndarray) -> list[list[float]]:
    return [[float(f"{x:.5g}") for x in row] for row in values]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    path = parser.parse_args().path
    sines = {"frequencies": FREQUENCIES, "amplitudes": AMPLITUDES}
    sines |= {"runs": {run: told(*which) for run, which in SINES.items()}}
    gait = {"compensated": missed(True), "not": missed(False)}
    every = {"sines": sines, "gait": gait, "clipped": clipped()}
    path.write_text(json.dumps(every) + "\n", encoding="utf-8")
