"""Results of runs that take too long for the pages: error maps of sines, with 1 + 4 muscles and as
one unit of five; a stride with and without friction compensation; a fit of a clipped record.

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


def sine_map(name: str, policy: str) -> dict[str, Any]:
    """Errors [-] and efficiency [-] of a scenario with a policy, over frequency and amplitude."""
    scenario = fs.example(name)
    controller = scenario.with_policy(policy).control.controller
    response = control.frequency_response(
        scenario.plant, controller, MEAN, AMPLITUDES, FREQUENCIES, scenario.start
    )
    works = control.shaft_work(response, SUPPLY, fluid.OIL.reference_density)
    return {
        "error": _round(response.error),
        "efficiency": {unit: _round(response.work / work) for unit, work in works.items()},
        "trusted": bool(np.all(response.is_valid)),
        "held": bool(np.all(response.reachable_share == 1)),
    }


def stride_error(compensate: bool) -> float:
    """Root mean square error of a stride's angle [deg]."""
    gait = fs.example("joint_gait").with_policy(compensate=compensate)
    metrics = control.control_metrics(gait.control.controller, gait.run(), gait.control.reference)
    return float(f"{np.degrees(metrics.rms):.5g}")


def clipped_fit() -> list[str]:
    """Lines on a fit of a synthetic record that is clipped at zero."""
    truth = fs.example("kim2021_slenderness_10")
    muscle = fs.Muscle.from_dimensions(
        length=truth.length,
        outer_radius=truth.outer_radius,
        wall_thickness=truth.wall_thickness,
        braid_angle=truth.braid_angle,
        material="silicone_kim2021",
    )
    record = VirtualDynamometer(samples=20, clip=True).record(truth, seed=4)
    calibration = fs.calibrate.fit(record, muscle)
    values = [
        f"{estimate.name:24s} {pretty(estimate.value, estimate.dimension, 3):>12s}"
        f"   identifiable: {estimate.identifiable}"
        for estimate in calibration.parameters
    ]
    return [*values, *(f"- {line}" for line in calibration.warnings)]


def _round(values: np.ndarray) -> list[list[float]]:
    """Values with five digits."""
    return [[float(f"{x:.5g}") for x in row] for row in values]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    path = parser.parse_args().path
    sines = {"frequencies": FREQUENCIES, "amplitudes": AMPLITUDES}
    sines |= {"runs": {run: sine_map(*scenario) for run, scenario in SINES.items()}}
    gait = {"compensated": stride_error(True), "not": stride_error(False)}
    results = {"sines": sines, "gait": gait, "clipped": clipped_fit()}
    path.write_text(json.dumps(results) + "\n", encoding="utf-8")
