"""The inverse of an antagonistic joint: there and back, out of reach, bundles, and refusals."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

import fascicle as fs
from fascicle.control import JointStatus
from fascicle.core.errors import InvalidInputError


ARM, STRAIN, ANGLE = 0.05, 0.12, math.radians(10)


def torque_at(joint, result, angle):
    """Torque [N·m] by the muscles' own forces."""
    muscle = joint.agonist.motor_units[0].muscle
    shortening = ARM * angle / 0.3
    first = muscle.force(result.agonist, STRAIN + shortening)
    return ARM * (first - muscle.force(result.antagonist, STRAIN - shortening))


def test_pressures_of_a_torque_and_a_stiffness(joint):
    result = joint.pressures(ANGLE, 5.0, 60.0)
    assert result.status == JointStatus.REACHED
    # of an independent computation
    assert_allclose([result.agonist, result.antagonist], [134.406e3, 86.442e3], atol=1)
    assert_allclose([result.torque, result.stiffness], [5.0, 60.0], rtol=1e-9)
    h = 1e-5  # rad: the stiffness is the slope of the torque, valves open
    slope = (torque_at(joint, result, ANGLE + h) - torque_at(joint, result, ANGLE - h)) / (2 * h)
    assert_allclose(-slope, 60.0, rtol=1e-6)


def test_batches_come_back(joint):
    angle, torque = np.meshgrid([-0.2, 0.0, 0.15], [-10.0, 0.0, 20.0])
    result = joint.pressures(angle, torque, 120.0)
    assert result.agonist.shape == (3, 3)
    assert_array_equal(result.status, JointStatus.REACHED)
    assert_allclose(torque_at(joint, result, angle), torque, atol=1e-8)
    assert_allclose(result.stiffness, 120.0, rtol=1e-8)
    # mirrored demands have mirrored pressures
    other = joint.pressures(-angle, -torque, 120.0)
    assert_allclose(other.agonist, result.antagonist, rtol=1e-6)


def test_shut_valves_keep_the_gas(thick, joint):
    pressures = np.array([134.406e3, 86.442e3])
    strains = STRAIN + np.array([1, -1]) * ARM * ANGLE / 0.3
    room = 101325.0

    def torque(turn):
        """Torque [N·m] after a small turn [rad], at the pressures that keep P V*."""
        forces = []
        for sign, P, eps in zip((1, -1), pressures, strains, strict=True):
            moved = eps + sign * ARM * turn / 0.3
            content = (P + room) * thick.conjugate_volume(P, eps)

            def excess(p, moved=moved, content=content):
                return (p + room) * thick.conjugate_volume(p, moved) - content

            forces.append(thick.force(brentq(excess, 0.5 * P, 2 * P, xtol=1e-6), moved))
        return ARM * (forces[0] - forces[1])

    slope = (torque(1e-3) - torque(-1e-3)) / 2e-3
    shut = joint.stiffness(*pressures, ANGLE, valves="shut")
    assert_allclose(shut, -slope, rtol=1e-4)
    assert_allclose(joint.stiffness(*pressures, ANGLE), 60.0, rtol=1e-4)
    assert shut > 60.0


def test_out_of_reach_is_a_status_and_the_nearest(joint):
    low, high = joint.stiffness_range(ANGLE, 5.0)
    result = joint.pressures(ANGLE, [5.0, 5.0, 900.0, -900.0], [low / 2, 2 * high, 60.0, 60.0])
    unreachable = [JointStatus.TORQUE_OUT_OF_REACH] * 2
    expected = [JointStatus.STIFFNESS_TOO_LOW, JointStatus.STIFFNESS_TOO_HIGH, *unreachable]
    assert_array_equal(result.status, expected)
    assert_allclose(result.torque[:2], 5.0, rtol=1e-9)
    assert_allclose(result.stiffness[:2], [low, high])
    assert_array_equal(result.agonist[2:], [1e6, 0.0])
    assert_array_equal(result.antagonist[2:], [0.0, 1e6])
    assert np.all(np.isnan(joint.stiffness_range(ANGLE, 900.0)))


@pytest.mark.parametrize("strain", [0.12, 0.25])
def test_a_torque_is_reached_between_the_largest_and_the_least(thick, strain):
    weak = fs.Bundle([fs.MotorUnit(thick)], supply_pressure=1e5)
    rng = np.random.default_rng(2)
    angle, torque = rng.uniform(-0.6, 0.6, 60), rng.uniform(-60, 60, 60)
    result = fs.Joint(weak, weak, ARM, strain).pressures(angle, torque, 100.0)
    # each muscle empty or full: far contracted, it resists more when it is full
    first, second = (
        [thick.force(P, strain + sign * ARM * angle / 0.3) for P in (0.0, 1e5)] for sign in (1, -1)
    )
    torques = ARM * np.array([one - other for one in first for other in second])
    nearest = np.clip(torque, torques.min(axis=0), torques.max(axis=0))
    np.testing.assert_allclose(result.torque, nearest, atol=1e-8)
    unreachable = result.status == JointStatus.TORQUE_OUT_OF_REACH
    assert_array_equal(unreachable, nearest != torque)
    assert 0.1 < np.mean(unreachable) < 1


def test_bundles_have_one_pressure_and_their_supply(thick, joint):
    pair = fs.Bundle([fs.MotorUnit(thick, 2)], supply_pressure=3e5)
    result = fs.Joint(pair, pair, ARM, STRAIN).pressures(ANGLE, 10.0, 120.0)
    single = joint.pressures(ANGLE, 5.0, 60.0)
    assert_allclose([*result[:2]], [*single[:2]], rtol=1e-9)
    assert fs.Joint(pair, pair, ARM, STRAIN).pressures(0.0, 1e3, 0.0).agonist == 3e5


@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda m: fs.Joint(m, "muscle", ARM), "agonist and antagonist"),
        (lambda m: fs.Joint(m, m, -ARM), "moment_arm"),
        (lambda m: fs.Joint(m, m, ARM).pressures(math.nan, 0.0, 1.0), "angle"),
        (lambda m: fs.Joint(m, m, ARM).pressures(9.0, 0.0, 1.0), "strain"),
    ],
)
def test_invalid_input_is_refused(thick, call, argument):
    with pytest.raises(InvalidInputError) as error:
        call(thick)
    assert error.value.argument == argument
