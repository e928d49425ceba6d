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
    assert of.command_count(5) == 5 and of.state_count(5) == 0
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
    assert of.command_count(3) == of.state_count(3) == 3


def test_orderly_valve_recruits_in_sequence():
    of = fluid.OrderlyValve(4, 0.01)
    x = np.linspace(-1, 1, 201)[:, None]
    supply, exhaust = of.openings(x, x)
    assert supply.shape == (201, 4)
    assert np.all(supply[0] == 0) and np.all(exhaust[0] == 1)  # all vented
    assert np.all(supply[-1] == 1) and np.all(exhaust[-1] == 0)  # all at the supply
    assert np.all(supply * exhaust == 0)
    assert np.all(np.diff(supply, axis=0) >= 0) and np.all(np.diff(exhaust, axis=0) <= 0)
    # no unit opens to the supply before the one ahead of it is wide open
    assert np.all((supply[:, 1:] == 0) | (supply[:, :-1] == 1))
    for unit in range(4):
        at = np.array([of.closing_command(unit)])
        supply, exhaust = of.openings(at, at)
        assert_allclose(supply, np.arange(4) < unit, atol=1e-14)
        assert_allclose(exhaust, np.arange(4) > unit, atol=1e-14)
    assert of.command_count(4) == of.state_count(4) == 1
    assert_allclose(of.rate(np.array([1.0]), np.array([0.5])), [50], rtol=1e-14)


def test_an_orderly_valve_of_one_port_is_a_servovalve():
    x = np.linspace(-1, 1, 21)[:, None]
    one = fluid.OrderlyValve(1, 0.01, 0.2).openings(x, x)
    for of_one, of_other in zip(one, fluid.Servovalve(0.01, 0.2).openings(x, x), strict=True):
        assert_allclose(of_one, of_other, atol=1e-15)


@pytest.mark.parametrize("overlap", [0.0, 0.2])
@pytest.mark.parametrize("at", [-1.0, -0.2, 0.0, 0.1, 0.2, 1.0])
def test_slopes_are_those_of_differences_at_the_edges_too(at, overlap):
    of = fluid.Direct(overlap)
    found = jax.jacrev(lambda u: of.openings(u, NONE))(np.array([at]))
    step = 1e-6
    up, down = (of.openings(np.array([at + s]), NONE) for s in (step, -step))
    for slope, high, low in zip(found, up, down, strict=True):
        assert_allclose(slope[0, 0], (high - low)[0] / (2 * step), atol=1e-8)


def test_under_jit_and_vmap():
    of = fluid.OrderlyValve(3, 0.01, 0.1)
    x = np.linspace(-1, 1, 7)[:, None]
    plain = of.openings(x, x)
    batched = jax.jit(jax.vmap(of.openings))(x, x)
    for one, other in zip(plain, batched, strict=True):
        assert type(one) is np.ndarray
        assert_allclose(one, other, atol=1e-15)
