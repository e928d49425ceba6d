"""Loads: forces are slopes of their potentials, stops push one way; what parts refuse."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle import dynamics
from fascicle.core.errors import InvalidInputError
from fascicle.dynamics import Coulomb, Dahl, MaxwellSlip, Schedule, Stop


LOADS = [
    dynamics.HangingMass(5.0),
    dynamics.InertiaSpringDamper(5.0, 2e3, 10.0, rest=0.01, force_outside=20.0),
    dynamics.AntagonisticJoint(0.01, 0.02, 0.01, gravity_moment=0.7),
]


@pytest.mark.parametrize("load", LOADS, ids=lambda load: type(load).__name__)
def test_force_is_the_slope_of_the_potential(load):
    for q in (-0.4, 0.0, 0.013, 0.7):
        assert_allclose(load.force(q), -jax.grad(load.potential)(q), rtol=1e-12, atol=1e-14)
        stiff = -jax.grad(load.force)(q)
        assert stiff <= load.stiffness * (1 + 1e-12)


def test_a_stop_pushes_one_way_only():
    stop = Stop(-0.1, 0.2, 1e4, 1e2)
    q = np.array([-0.11, -0.1, 0.0, 0.2, 0.21])
    assert_allclose(stop.force(q, 0 * q)[0], [-100, 0, 0, 0, 100], rtol=1e-12)
    # it doesn't pull back what leaves faster than its spring pushes
    assert_array_equal(stop.force(np.array([0.21, -0.11]), np.array([-2.0, 2.0]))[0], 0)


def test_a_stop_reports_its_damper_separately():
    stop = Stop(-0.1, 0.2, 1e4, 1e2)
    for q in (-0.15, 0.25):
        spring = jax.grad(stop.energy)(q)
        for v in (-9.0, -1.0, 0.0, 1.0, 9.0):
            total, damped = stop.force(np.float64(q), np.float64(v))
            assert_allclose(total - damped, spring, rtol=1e-12)
            assert damped * v >= 0  # which never gives energy


def test_velocity_is_the_derivative_of_the_motion():
    load = dynamics.PrescribedMotion(0.01, 0.005, 3.0)
    for t in (0.0, 0.03, 0.2):
        _, speed = jax.jvp(lambda t: load.motion_at(t, 0.0, 0.0)[0], (t,), (1.0,))
        assert_allclose(load.motion_at(t, 0.0, 0.0)[1], speed, rtol=1e-12)
    assert dynamics.PrescribedMotion(0.01).motion_at(0.7, 0.5, 0.5) == (0.01, 0.0)


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda: dynamics.HangingMass(0.0), "mass"),
        (lambda: dynamics.HangingMass("5"), "mass"),
        (lambda: dynamics.InertiaSpringDamper(1.0, -1.0), "spring_stiffness"),
        (lambda: dynamics.AntagonisticJoint(0.01, 0.0), "radius"),
        (lambda: dynamics.PrescribedMotion(0.0, 0.01), "frequency"),
        (lambda: Stop(0.2, 0.1), "low"),
        (lambda: MaxwellSlip(0.0, 1.0), "stiffness"),
        (lambda: MaxwellSlip([1e3, 2e3], 1.0), "slip_force"),
        (lambda: MaxwellSlip(1e3, 1.0, -1e-5), "slip_force_slope"),
        (lambda: Dahl(1e3, 0.0), "slip_force"),
        (lambda: Coulomb(1e3, 0.0), "velocity"),
        (lambda: Schedule([0.1, 0.2], [0, 1]), "times"),
        (lambda: Schedule([0, 0.2, 0.1], [0, 1, 0]), "times"),
        (lambda: Schedule([0, np.nan], [0, 1]), "times"),
        (lambda: Schedule([0, 1], [0, 1.01]), "commands"),
        (lambda: Schedule([0, 1], [0, 1, 0]), "commands"),
    ],
)
def test_invalid_input_is_refused(make, argument):
    with pytest.raises(InvalidInputError) as error:
        make()
    assert error.value.argument == argument
