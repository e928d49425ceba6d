"""Joint readings against a muscle's attachment points and virtual work. All data are synthetic."""

import numpy as np
import oracle_joint as oracle
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.records import load, loads
from fascicle.records.joint import read_arm_table


A, B = 0.15, 0.03  # m: attachment points on the two links
REST = 0.0  # rad: straight
MUSCLE = fs.example("kim2021_slenderness_10")
ANGLES = np.radians(np.arange(0, 61, 3.0))
PRESSURES = np.array([0.0, 100e3, 200e3, 300e3])


def joint_csv(column=False):
    """Torques of the muscle on the hinge, from geometry and virtual work alone."""
    rest = oracle.muscle_length(REST, A, B)
    head = "pressure [kPa],angle [deg],torque [N m]" + ",moment arm [mm]" * column
    rows, truth = [head], []
    for P in PRESSURES:
        for angle in ANGLES:
            strain = (rest - oracle.muscle_length(angle, A, B)) / rest
            force = float(MUSCLE.force(P, strain))
            torque = oracle.torque(force, angle, A, B)
            arm = f",{1e3 * oracle.moment_arm(angle, A, B):.9f}" * column
            rows.append(f"{P / 1e3},{np.degrees(angle):.9f},{torque:.12f}{arm}")
            truth.append((P, strain, force))
    return "\n".join(rows) + "\n", np.array(truth).T, rest


@pytest.mark.parametrize("column", [True, False])
def test_a_joint_recovers_force_and_contraction(tmp_path, column):
    text, (P, strain, force), rest = joint_csv(column)
    path = tmp_path / "knee.csv"
    path.write_text(text)
    fine = np.radians(np.arange(-1, 62, 0.5)).tolist()
    arms = {"angle": fine, "arm": [oracle.moment_arm(angle, A, B) for angle in fine]}
    options = {} if column else {"moment_arm": arms}
    record = load(path, rest_length=rest, zeros={"angle": REST}, **options)
    arm = np.array([oracle.moment_arm(angle, A, B) for angle in ANGLES])
    used = np.tile(arm > 0.1 * arm.max(), PRESSURES.size)
    assert len(record) == used.sum() < used.size
    counts = {finding.code: finding.data.get("count") for finding in record.findings}
    assert counts["record.short_arms"] == used.size - used.sum()
    assert_allclose(record.pressure, P[used])
    # the trapezoid errs by (largest curvature of the arm) * step^2 / 12 * range: arms here curve by
    # less than 2 b = 0.06 m/rad^2
    step = np.radians(3.0 if column else 0.5)
    limit = 0.06 * step**2 / 12 * ANGLES[-1] / rest
    assert_allclose(record.strain, strain[used], rtol=0, atol=limit)
    # linear between a table's angles, which are among those of the readings: rounded text only
    assert_allclose(record.force, force[used], rtol=1e-6, atol=1e-6)
    assert_allclose(record.moment_arm, np.tile(arm, PRESSURES.size)[used], rtol=1e-6)


def test_the_integral_of_a_table_is_that_of_its_lines():
    angles, arms = [-0.4, 0.1, 0.3, 1.2], [0.01, 0.03, -0.005, 0.02]
    table = read_arm_table({"angle": angles, "arm": arms})
    for start, end in ((-0.4, 1.2), (0.2, 0.95), (0.8, -0.1)):
        walked = oracle.walked_shortening(start, end, angles, arms)
        # midpoints are exact on lines, but for the steps in which two lines meet
        assert_allclose(table.shortening(np.array(end), start), walked, rtol=0, atol=1e-9)
    inner = np.linspace(-0.4, 1.2, 17)
    expected = [oracle.arm_between(angle, angles, arms) for angle in inner]
    assert_allclose(table.arm_at(inner), expected, rtol=1e-12, atol=1e-15)


def test_a_constant_arm_is_a_pulley():
    text = "p [kPa],theta [rad],tau [Nm]\n200,0.5,1.5\n200,1.0,0.75\n200,1.5,0.15\n"
    record = loads(text, moment_arm="30 mm", rest_length="300 mm", zeros={"angle": "0.5 rad"})
    assert_allclose(record.strain, [0, 0.05, 0.1], atol=1e-15)
    assert_allclose(record.force, [50, 25, 5])
