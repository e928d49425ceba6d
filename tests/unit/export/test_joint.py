"""The inverse of a joint in C chooses as `Joint.pressures` on the law, within the table's error."""

import ctypes
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import fascicle as fs
from fascicle.control import JointStatus
from fascicle.export import table_code, write_table

from .conftest import STRICT


ARM, STRAIN, OUTSIDE = 0.05, 0.12, 4
DOUBLE, FLOAT = ctypes.c_double, ctypes.c_float
# regula falsi ends where the pressure stands still; a torque is met to rounding of some 100 N m
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def unlike(thick):
    """Two unlike motor units between plates, and a muscle of another length."""
    shorter = fs.Muscle(0.28, 15e-3, 2e-3, math.radians(27), "latex")
    units = [fs.MotorUnit(thick, 2), fs.MotorUnit(shorter)]
    return fs.Joint(fs.Bundle(units, 3e5, length=0.29), shorter, 0.04, strain=0.1)


@pytest.fixture
def build(compile_c, tmp_path):
    def build(joint, flags=("-O2",), **options):
        return compile_c(write_table(joint, tmp_path, "elbow", **options)[1], flags)

    return build


def stated_errors(joint, **options):
    """Largest errors of the torque [N·m], in the inner half of the angles and at all; median, 99 %
    and both largest errors of the stiffness [N·m/rad]; roundings of both in single precision.
    """
    header = table_code(joint, "elbow", **options)[0]
    text = header[header.index("The joint:") : header.index("#ifndef")]
    return [float(number) for number in re.findall(r"([\d.e+-]+) N m", text)]


def pressures_in_c(library, angle, torque, stiffness, supply, kind=DOUBLE):
    """Status, pressures, and reached torque and stiffness, of each demand."""
    pressure, reached, rows = (kind * 2)(), (kind * 2)(), []
    for demand in np.broadcast(angle, torque, stiffness, supply):
        status = library.elbow_pressures(*map(kind, demand), pressure, reached)
        rows.append([status, *pressure, *reached])
    status, first, second, *result = np.array(rows).T
    return status, np.stack([first, second]), *result


def state_in_c(library, pressures, angle, kind=DOUBLE):
    """Torque, and stiffness with open and shut valves, at each point."""
    results, rows = [kind() for _ in range(3)], []
    for first, second, theta in zip(*pressures, angle, strict=True):
        point = (kind * 2)(first, second), kind(theta)
        assert library.elbow_joint(*point, *map(ctypes.byref, results)) == 0
        rows.append([result.value for result in results])
    return np.array(rows).T


def torque_of(joint, pressures, angle):
    """Torque [N·m] by the muscles' own forces."""
    total = 0.0
    sides = (joint.agonist, 1), (joint.antagonist, -1)
    for (bundle, sign), P in zip(sides, pressures, strict=True):
        strain = joint.strain + sign * joint.moment_arm * angle / float(bundle.length)
        rows = np.repeat(P[:, None], len(bundle.motor_units), axis=1)
        total = total + sign * joint.moment_arm * bundle.force(rows, strain)
    return total


def demands(count):
    """Demands over the whole range of angles of `joint`, some of them out of reach."""
    rng = np.random.default_rng(3)
    return rng.uniform(-1, 1, count), rng.uniform(-80, 80, count), rng.uniform(0, 600, count)


def test_a_torque_and_a_stiffness_of_an_independent_computation(joint, build):
    angle = np.array([math.radians(10)])
    status, P, *reached = pressures_in_c(build(joint), angle, 5.0, 60.0, 1e6)
    assert status == JointStatus.REACHED
    np.testing.assert_allclose(np.ravel(reached), [5.0, 60.0], rtol=ROUNDING)
    torque, _, median, *_ = stated_errors(joint)
    assert abs(torque_of(joint, P, angle) - 5.0) <= torque
    assert abs(joint.stiffness(*P, angle) - 60.0) <= median
    # the law's own pressures are apart by these errors over its slopes there
    expected, h = np.array([[134.406e3], [86.442e3]]), 100.0
    slopes = np.empty((2, 2))
    for k in range(2):
        step = h * np.eye(2)[k][:, None]
        for row, value in enumerate((torque_of, lambda j, P, x: j.stiffness(*P, x))):
            change = value(joint, expected + step, angle) - value(joint, expected - step, angle)
            slopes[row, k] = change[0] / (2 * h)
    bound = np.abs(np.linalg.inv(slopes)) @ [torque, median]
    assert np.all(np.abs(P - expected)[:, 0] <= bound)


@pytest.mark.parametrize("count", [50, pytest.param(600, marks=pytest.mark.slow)])
def test_it_chooses_as_python_does_on_the_law(count, joint, build):
    angle, torque, stiffness = demands(count)
    status, P, *reached = pressures_in_c(build(joint), angle, torque, stiffness, 1e6)
    expected = joint.pressures(angle, torque, stiffness)
    assert np.mean(status == expected.status) > 0.98  # others: within the table's error of a limit
    assert set(status) == {0, 1, 2, 3}
    met = status == JointStatus.REACHED
    np.testing.assert_allclose(reached[0][met], torque[met], atol=ROUNDING)
    np.testing.assert_allclose(reached[1][met], stiffness[met], atol=ROUNDING * 600)
    inner_torque, largest_torque, *errors = stated_errors(joint)
    inner = np.abs(angle) < 0.59  # of 1.19
    # the law's torque and stiffness at these pressures, of the demand or of what is the nearest
    miss = np.abs(torque_of(joint, P, angle) - reached[0])
    assert np.max(miss) <= largest_torque and np.max(miss[inner]) <= inner_torque
    miss = np.abs(joint.stiffness(*P, angle) - reached[1])
    assert np.median(miss) <= errors[0] and np.quantile(miss, 0.99) <= errors[1]
    assert np.max(miss) <= errors[3] and np.max(miss[inner]) <= errors[2]
    same = status == expected.status
    full = same & (status == JointStatus.TORQUE_OUT_OF_REACH)
    np.testing.assert_array_equal(P[:, full], np.stack(expected[:2])[:, full])
    assert np.all(np.abs(reached[1] - expected.stiffness)[same & (status > 0)] <= errors[3])


@pytest.mark.parametrize("strain", [0.12, 0.25])
def test_a_weak_supply_reaches_the_same_torques(strain, thick, build):
    """Stretched or far contracted, a torque out of reach is one beyond the nearest of the ends."""
    weak = fs.Bundle([fs.MotorUnit(thick)], supply_pressure=1e5)
    pair = fs.Joint(weak, weak, ARM, strain)
    rng = np.random.default_rng(2)
    demand = rng.uniform(-0.6, 0.6, 60), rng.uniform(-60, 60, 60), np.full(60, 100.0)
    status, P, *reached = pressures_in_c(build(pair), *demand, 1e5)
    expected = pair.pressures(*demand)
    assert np.mean(status == expected.status) > 0.95 and len(set(status)) > 1
    same = status == expected.status
    largest = stated_errors(pair)[1]
    np.testing.assert_allclose(reached[0][same], expected.torque[same], rtol=0, atol=largest)
    beyond = same & (status == JointStatus.TORQUE_OUT_OF_REACH)
    np.testing.assert_array_equal(P[:, beyond], np.stack(expected[:2])[:, beyond])


def test_bundles_have_one_pressure_and_another_supply_is_a_lower_one(unlike, build):
    library = build(unlike)
    rng = np.random.default_rng(5)
    angle, P = rng.uniform(-0.5, 0.5, 40), rng.uniform(0, 3e5, (2, 40))
    torque, *stiffness = state_in_c(library, P, angle)
    _, largest, *errors = stated_errors(unlike)
    assert np.max(np.abs(torque - torque_of(unlike, P, angle))) <= largest
    for value, valves in zip(stiffness, ("open", "shut"), strict=True):
        miss = np.abs(value - unlike.stiffness(*P, angle, valves=valves))
        # what the gas adds is smooth: its error is far below that of the force's second slope
        assert np.max(miss) <= errors[3] and np.median(miss) <= errors[1]
    # the pressures themselves may be others: an antagonist in its dip isn't asked for
    for supply in (3e5, 1.5e5):
        status, P, *reached = pressures_in_c(library, angle, torque, stiffness[0], supply)
        limited = unlike.antagonist.replace(supply_pressure=supply)
        reference = fs.Joint(unlike.agonist, limited, 0.04, strain=0.1)
        expected = reference.pressures(angle, torque, stiffness[0])
        assert np.mean(status == expected.status) > 0.95 and np.max(P) <= supply
        met = status == JointStatus.REACHED
        assert 0.1 < np.mean(met) < 1
        for value, demand in zip(reached, (torque, stiffness[0]), strict=True):
            np.testing.assert_allclose(value[met], demand[met], atol=ROUNDING * 600)


def test_single_precision_is_off_by_no_more_than_its_header_states(joint, build):
    flags = ("-O2", "-Wdouble-promotion", "-Wconversion")
    library = build(joint, flags, precision="float")
    *_, torque_rounding, stiffness_rounding = stated_errors(joint, precision="float")
    tables = joint.agonist.motor_units[0].muscle.table(1e6, shape=(33, 41))
    rng = np.random.default_rng(7)
    angle = np.float32(rng.uniform(-1, 1, 1000)).astype(float)
    P = np.float32(rng.uniform(0, 1e6, (2, 1000))).astype(float)
    torque, open_stiffness, _ = state_in_c(library, P, angle, FLOAT)
    strains = STRAIN + np.array([[1], [-1]]) * ARM * angle / 0.3
    first, second = (tables.lookup_at(*side) for side in zip(P, strains, strict=True))
    expected = ARM * (first.force - second.force)
    slope = -(ARM**2) / 0.3 * (first.force_by_strain + second.force_by_strain)
    assert 0 < np.max(np.abs(torque - expected)) <= torque_rounding
    assert 0 < np.max(np.abs(open_stiffness - slope)) <= stiffness_rounding
    demand = demands(200)
    status, P, *reached = pressures_in_c(library, *demand, 1e6, FLOAT)
    met = status == JointStatus.REACHED
    assert np.mean(met) > 0.3
    # one rounding of the search, one of what is reported
    assert np.max(np.abs(reached[0] - demand[1])[met]) <= 2 * torque_rounding
    assert np.max(np.abs(reached[1] - demand[2])[met]) <= 2 * stiffness_rounding


def test_the_docs_example_compiles_and_prints_what_they_show(joint, compile_c, tmp_path):
    text = (Path(__file__).parents[3] / "docs" / "export.md").read_text(encoding="utf-8")
    example = re.search(r"```c\n((?:(?!```).)*elbow_pressures.*?)```", text, re.DOTALL)
    shown = re.search(r"\$ ./reach\n(.*?)```", text, re.DOTALL)
    source = write_table(joint, tmp_path, "elbow")[1]
    compile_c(source)  # skips without gcc
    (tmp_path / "reach.c").write_text(example[1])
    command = ["gcc", *STRICT, "-o", tmp_path / "reach", tmp_path / "reach.c", source, "-lm"]
    subprocess.run(command, check=True)
    result = subprocess.run([tmp_path / "reach"], capture_output=True, text=True, check=True)
    assert result.stdout == shown[1]


def test_outside_of_the_table_it_has_a_status(joint, build):
    library = build(joint, ["-O0"])
    for demand in (
        (1.5, 0.0, 60.0, 1e6), (math.nan, 0.0, 60.0, 1e6), (0.0, math.nan, 60.0, 1e6),
        (0.0, 0.0, math.inf, 1e6), (0.0, 0.0, 60.0, 0.0), (0.0, 0.0, 60.0, math.nan),
    ):  # fmt: skip
        status, P, *reached = pressures_in_c(library, *demand)
        assert status == OUTSIDE and np.all(np.isnan([*P, *reached]))
    pressure = (DOUBLE * 2)()
    assert library.elbow_pressures(*map(DOUBLE, (0.1, 5.0, 60.0, 1e6)), pressure, None) == 0
    assert library.elbow_joint(pressure, DOUBLE(0.1), None, None, None) == 0
    for P, angle in (((-1.0, 1e5), 0.0), ((1e5, 2e6), 0.0), ((1e5, 1e5), -1.5)):
        torque = DOUBLE()
        point = (DOUBLE * 2)(*P), DOUBLE(angle)
        assert library.elbow_joint(*point, ctypes.byref(torque), None, None) == 1
        assert math.isnan(torque.value)
