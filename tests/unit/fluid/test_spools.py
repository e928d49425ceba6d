import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid


NONE = np.zeros(0)


def test_direct_opens_to_supply_above_zero_and_to_exhaust_below():
    of = fluid.Direct()
    u = np.array([-1.0, -0.25, 0.0, 0.5, 1.0])
    supply, exhaust = of.openings(u, NONE)
    assert_allclose(supply, [0, 0, 0, 0.5, 1], atol=0)
    assert_allclose(exhaust, [1, 0.25, 0, 0, 0], atol=0)
    assert of.state_count(5) == 0
    assert of.rate(u, NONE).shape == (0,)


def test_overlap_is_a_dead_band():
    of = fluid.Direct(overlap=0.2)
    supply, exhaust = of.openings(np.array([-1, -0.6, -0.2, 0.1, 0.2, 0.6, 1.0]), NONE)
    assert_allclose(supply, [0, 0, 0, 0, 0, 0.5, 1], atol=1e-15)
    assert_allclose(exhaust, [1, 0.5, 0, 0, 0, 0, 0], atol=1e-15)


def test_servovalve_follows_in_first_order():
    of = fluid.Servovalve(0.01, overlap=0.1)
    u, x = np.array([1.0, -1.0, 0.3]), np.array([0.0, 0.5, 0.3])
    assert_allclose(of.rate(u, x), [100, -150, 0], atol=1e-12)
    # what is open is where the spool is, not where it should be
    assert_allclose(of.openings(u, x).supply, fluid.Direct(0.1).openings(x, NONE).supply, atol=0)
    assert of.state_count(3) == 3


@pytest.mark.parametrize("command", [-0.9, -0.3, 0.0, 0.25, 0.6, 1.0])
def test_pulses_open_a_valve_in_the_mean(command):
    of = fluid.Solenoid(0.02, 0.002, 0.001)
    clock = (np.arange(4000) + 0.5) / 1000  # four periods
    supply, exhaust = (z.mean() for z in of.openings(command + 0 * clock, clock))
    mean = supply - exhaust
    assert_allclose(of.command_at(mean), command, atol=1e-3)
    expected = {0.0: 0.0, 1.0: 1.0}.get(command, np.sign(command) * (abs(command) - 0.05))
    assert_allclose(mean, expected, atol=1e-3)
    assert_allclose(of.rate(np.zeros(2), np.zeros(2)), 50.0)


@pytest.mark.parametrize("overlap", [0.0, 0.2])
@pytest.mark.parametrize("at", [-1.0, -0.2, 0.0, 0.1, 0.2, 1.0])
def test_slopes_are_those_of_differences_at_the_edges_too(at, overlap):
    of = fluid.Direct(overlap)
    found = jax.jacrev(lambda u: of.openings(u, NONE))(np.array([at]))
    step = 1e-6
    up, down = (of.openings(np.array([at + s]), NONE) for s in (step, -step))
    for slope, high, low in zip(found, up, down, strict=True):
        assert_allclose(slope[0, 0], (high - low)[0] / (2 * step), atol=1e-8)
