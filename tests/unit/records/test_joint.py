"""Records of a joint: torque and angle instead of force and length. All data are synthetic."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from asked import asked
from fascicle.calibrate import fit
from fascicle.records import dumps, join, load, loads
from fascicle.report.calibration_words import verdict_lines
from refusing import refuses, refuses_at


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


@pytest.mark.parametrize(
    ("header", "options"),
    [
        ("P [kPa],angle [deg],torque [N m]", {}),
        ("p_kPa,joint_angle_deg,torque_Nm", {}),
        ("Druck [kPa],Gelenkwinkel [°],Drehmoment [N·m]", {}),
        ("pressure [kPa],Position [deg],Load torque [Nm]", {}),
        ("a,b,c", {"columns": "pressure[kPa],angle[deg],torque[Nm]"}),
        ("P [kPa],b,c", {"columns": {"angle": "b", "torque": "c"},
                         "units": {"angle": "deg", "torque": "N-m"}}),
    ],
)  # fmt: skip
def test_columns_of_a_joint(header, options):
    check(loads(f"{header}\n{ROWS}", **JOINT, **options))


def test_other_units_zeros_and_directions():
    def table(angle, torque):
        return "".join(f"200,{a},{t}\n" for a, t in zip(angle, torque, strict=True))

    turned = table([-np.radians(a) for a in ANGLE], [8.8507457673787 * t for t in TORQUE])
    text = "P [kPa],angle [rad],torque [lbf in]\n" + turned
    options = JOINT | {"zeros": {"angle": "-10 deg"}, "signs": {"angle": "extension"}}
    check(loads(text, **options))
    shifted = table(ANGLE, [t + 0.25 for t in TORQUE])
    zeros = {"angle": "10 deg", "torque": "0.25 Nm"}
    check(loads("P [kPa],angle [deg],torque [Nm]\n" + shifted, **JOINT | {"zeros": zeros}))
    check(loads(TEXT.replace(",angle [deg]", ",arm_deg").replace("torque", "moment"),
                columns={"angle": "arm_deg"}, units={"angle": "deg"}, **JOINT))  # fmt: skip


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


def test_what_is_missing_is_asked_for():
    for change, choice in (
        ({"moment_arm": None}, ("moment_arm", "", "25 mm")),
        ({"zeros": None}, ("zeros", "angle", "0 deg")),
        ({"rest_length": None}, ("rest_length", "", "")),
        ({"zeros": {"angle": "70 deg"}}, ("signs", "angle", "extension positive")),
    ):
        assert asked(TEXT, **JOINT | change)[0] == choice


def test_a_pull_that_grows_with_contraction_has_the_wrong_direction():
    rows = "".join(f"200,{a},{1 + a / 50}\n" for a in range(-40, 41, 10))
    text = "P [kPa],angle [deg],torque [N m]\n" + rows
    options = JOINT | {"zeros": {"angle": "0 deg"}}
    assert asked(text, **options)[0][:2] == ("signs", "angle")
    record = loads(text, **options, signs={"angle": "extension positive"})
    assert np.corrcoef(record.strain, record.force)[0, 1] < -0.99


def test_arms_that_are_too_short_or_unknown():
    rows = "".join(f"200,{a},{0.1 * m},{m}\n" for a, m in zip(ANGLE, (20, 30, 1, 30), strict=True))
    text = "P [kPa],angle [deg],torque [N m],moment arm [mm]\n" + rows
    options = {"rest_length": REST, "zeros": {"angle": "10 deg"}}
    record = loads(text, **options)
    assert_allclose(record.force, 100)  # that below 10 % of the longest arm is left out
    # trapezoids over 30 deg each
    shortening = np.radians(30) * 0.025 * np.array([0, 1, 1])
    assert_allclose(record.strain, shortening / REST)
    noisy = text.replace("200,40.0,3.0,30\n", "200,40.0,3.0,30\n200,40.0,0.5,5\n")
    beyond = {"angle": ["0 deg", "50 deg"], "arm": ["20 mm", "30 mm"]}
    for wrong, given, place in (
        (noisy, options, "<text>, line 1, column `angle [deg]`: "),
        (text, options | {"zeros": {"angle": "100 deg"}}, "<text>, line 1, column `angle [deg]`: "),
        (TEXT, JOINT | {"moment_arm": beyond}, "<text>, line 4, column `angle [deg]`: "),
        (f"{text.splitlines()[0]}\n9,0,0,0\n9,1,0,0\n", options, "<text>, line 1, column "),
        (TEXT, JOINT | {"moment_arm": "0.025 mm"}, "<text>, line 2, column `torque [N m]`: "),
        (TEXT, JOINT | {"moment_arm": 0.0}, "`moment_arm` "),
    ):
        with refuses_at(place):
            loads(wrong, **given)


def test_a_force_beside_an_angle_and_a_torque_beside_a_length():
    text = "P [kPa],angle [deg],F [N]\n200,10,80\n200,40,48\n"
    record = loads(text, **JOINT)
    assert_allclose(record.force, [80, 48])
    assert_allclose(record.strain[1], ARM * np.radians(30) / REST)
    text = "P [kPa],L [mm],torque [Nm]\n200,200,2\n200,180,1\n"
    record = loads(text, moment_arm=ARM, rest_length=REST)
    assert_allclose(record.force, [80, 40])
    assert_allclose(record.strain, [0, 0.1])
    # a joint held at one angle
    text = "P [kPa],torque [Nm]\n100,1\n200,2\n"
    record = loads(text, **JOINT, constants={"angle": "40 deg"})
    assert_allclose(record.strain, ARM * np.radians(30) / REST)


def test_other_columns_do_not_make_a_joint():
    text = "P [kPa],L [mm],F [N],angle [deg],torque [Nm],lever [mm]\n200,180,9,x,,\n"
    record = loads(text, rest_length=REST)
    assert_allclose(record.force, 9)
    assert record.moment_arm is None
    with refuses("columns"):
        loads("P [kPa],F [N],braid angle [deg]\n100,9,25\n", rest_length=REST)


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
    lines, _ = verdict_lines(calibration)
    assert lines[1].count("N*m") == 2  # the error, and the largest torque
