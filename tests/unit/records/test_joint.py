"""Records of a joint: torque and angle instead of force and length. All data are synthetic."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.calibrate import fit
from fascicle.records import dumps, join, load, loads
from refusing import refuses


ANGLE = [10.0, 40.0, 70.0, 40.0]  # deg
TORQUE = [2.0, 1.2, 0.3, 1.3]  # N m
ROWS = "".join(f"200,{a},{t}\n" for a, t in zip(ANGLE, TORQUE, strict=True))
TEXT = "P [kPa],angle [deg],torque [N m]\n" + ROWS
ARM, REST = 0.025, 0.2  # m
JOINT = {"moment_arm": ARM, "rest_length": REST, "zeros": {"angle": "10 deg"}}


def check(record):
    assert_allclose(record.force, np.array(TORQUE) / ARM)
    assert_allclose(record.strain, ARM * np.radians(np.array(ANGLE) - 10) / REST, atol=1e-12)
    assert_allclose(record.moment_arm, ARM)


def test_the_sidecar_has_the_geometry(tmp_path):
    path = tmp_path / "knee.csv"
    path.write_text(TEXT)
    toml = 'rest_length = "200 mm"\nangle_at_rest = "10 deg"\n'
    path.with_suffix(".toml").write_text(toml + 'moment_arm = "25 mm"\n')
    check(load(path))
    for arm in ('["25 mm", "25 mm"]', '"25mm,25mm"'):
        table = f'[moment_arm]\nangle = "0deg:90deg:90deg"\narm = {arm}\n'
        path.with_suffix(".toml").write_text(toml + table)
        check(load(path))
    for text in (
        'moment_arm = "-5 mm"', "moment_arm = 5", '[moment_arm]\nangles = ["0 deg"]',
        '[moment_arm]\nangle = ["0 deg"]\narm = ["5 mm"]',
        '[moment_arm]\nangle = ["1 deg", "1 deg"]\narm = "5mm,6mm"',
    ):  # fmt: skip
        path.with_suffix(".toml").write_text(toml + text)
        with refuses("moment_arm"):
            load(path)


def test_arms_stay_with_their_readings():
    record = loads(TEXT, **JOINT)
    part = record.only([0, 2])
    assert_array_equal(part.moment_arm, record.moment_arm[[0, 2]])
    assert join([part, record.only([1])]).moment_arm.size == 3
    again = loads(dumps(record))
    for name in ("force", "strain", "moment_arm"):
        assert_array_equal(getattr(again, name), getattr(record, name))


def test_a_fit_to_a_joint_recovers_a_constant():
    truth = fs.Muscle(0.2, 6e-3, 1.5e-3, np.radians(30), "latex")
    angle = np.radians(np.arange(0, 61, 2.0))
    # an arm of which the integral is known: r = 0.02 + 0.01 sin(angle) [m]
    arm = 0.02 + 0.01 * np.sin(angle)
    strain = (0.02 * angle + 0.01 * (1 - np.cos(angle))) / 0.2
    noise, rows = np.random.default_rng(5), []
    for P in (0.0, 100e3, 200e3, 300e3):
        torque = np.asarray(truth.force(P, strain)) * arm + noise.normal(0, 2e-3, arm.size)
        rows += [f"{P},{a!r},{t!r}" for a, t in zip(angle.tolist(), torque.tolist(), strict=True)]
    text = "pressure [Pa],angle [rad],torque [Nm]\n" + "\n".join(rows)
    fine = np.radians(np.arange(0, 61, 0.5))
    table = {"angle": fine, "arm": 0.02 + 0.01 * np.sin(fine)}
    record = loads(text, moment_arm=table, rest_length=0.2, zeros={"angle": 0.0})
    calibration = fit(record, truth.replace(braid_angle=np.radians(33)), ["braid_angle"])
    (estimate,) = calibration.parameters
    deviation = (estimate.high - estimate.low) / (2 * 1.645)  # of a 90 % interval
    assert abs(estimate.value - np.radians(30)) < 4 * deviation
    assert deviation < np.radians(0.05)
    # 2e-3 N m within the scatter of 124 readings, 4 / sqrt(2 * 124)
    assert calibration.torque_rmse == pytest.approx(2e-3, rel=0.26)
