"""Results of runs that take too long for the pages: a stride with and without friction
compensation; a fit of a clipped record.

python docs/runs.py docs/_static/runs.json
"""

import argparse
import json
from pathlib import Path

import numpy as np

import fascicle as fs
from fascicle import control
from fascicle.records import VirtualDynamometer
from fascicle.report.calibration_words import warning_lines
from fascicle.units import pretty


def stride_error(compensate: bool) -> float:
    """Root mean square error of a stride's angle [deg]."""
    gait = fs.example("joint_gait").with_policy(compensate=compensate)
    metrics = control.control_metrics(gait.control.controller, gait.run(), gait.control.reference)
    return float(f"{np.degrees(metrics.rms):.5g}")


def clipped_fit() -> list[str]:
    """Lines on a fit of a synthetic record that is clipped at zero."""
    truth = fs.example("kim2021_slenderness_10")
    muscle = fs.Muscle(
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
    return [*values, *(f"- {line}" for line in warning_lines(calibration))]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    path = parser.parse_args().path
    gait = {"compensated": stride_error(True), "not": stride_error(False)}
    results = {"gait": gait, "clipped": clipped_fit()}
    path.write_text(json.dumps(results) + "\n", encoding="utf-8")
