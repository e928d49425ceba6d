import jax
import numpy as np
from numpy.testing import assert_allclose

from fascicle import fluid


D, N, V, M = 2e-6, 25.0, 0.9, 0.85
pump = fluid.FixedPump(D, N, V, M)


def test_fixed_pump():
    P = np.array([0.0, 1e5, 1e6])
    assert_allclose(pump.flow(P), D * N * V * 850.0, rtol=1e-14)
    assert_allclose(pump.shaft_power(P), D * N * P / M, rtol=1e-14)
    # of the liquid's power η_v η_m arrive, but for half of P/K, which compressing it takes
    arrived = 1 - pump.lost_power(1e6) / pump.shaft_power(1e6)
    assert_allclose(arrived, V * M * (1 - 1e6 / (2 * 1.4e9)), rtol=1e-6)
    assert np.all(pump.lost_power(P) >= 0)


def test_perfect_pump_loses_what_it_takes_to_compress_alone():
    of = fluid.FixedPump(D, N)
    assert_allclose(of.lost_power(1e6), D * N * 1e6 * 1e6 / (2 * 1.4e9), rtol=1e-3)


def test_switched_off_it_does_nothing():
    assert pump.flow(1e6, 0.0) == pump.shaft_power(1e6, 0.0) == pump.lost_power(1e6, 0.0) == 0


def test_switch_keeps_its_state_between_its_pressures():
    of = fluid.FixedPump(D, N, switch_on=4e5, switch_off=6e5)
    P = np.array([3e5, 4e5, 5e5, 6e5, 7e5])
    assert_allclose(of.update_switch(0.0, P), [1, 1, 0, 0, 0], atol=0)
    assert_allclose(of.update_switch(1.0, P), [1, 1, 1, 0, 0], atol=0)
    assert_allclose(of.initial_switch(P), [1, 1, 1, 0, 0], atol=0)
    assert_allclose(jax.jit(of.update_switch)(1.0, P), of.update_switch(1.0, P), atol=0)
    assert_allclose(pump.update_switch(1.0, P), 1, atol=0)  # without pressures it always runs
