import jax
import numpy as np
from numpy.testing import assert_allclose

from fascicle import fluid


D, N, V, M = 2e-6, 25.0, 0.9, 0.85
pump = fluid.FixedPump(D, N, V, M)
variable = fluid.VariablePump(D, N, 1e6, 1e5, V, M)


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


def test_variable_pump_holds_its_pressure():
    P = np.array([0.0, 0.9e6, 0.95e6, 1e6, 1.2e6])
    assert_allclose(variable.fraction(P), [1, 1, 0.5, 0, 0], atol=1e-15)
    assert_allclose(variable.flow(P), variable.fraction(P) * pump.flow(P), rtol=1e-14)
    assert_allclose(variable.shaft_power(P), variable.fraction(P) * pump.shaft_power(P), rtol=1e-14)
    assert np.all(variable.lost_power(P) >= 0)


def test_pressure_band_keeps_what_it_was():
    of = fluid.PressureBand(4e5, 6e5)
    P = np.array([3e5, 4e5, 5e5, 6e5, 7e5])
    assert_allclose(of.update(0.0, P), [1, 1, 0, 0, 0], atol=0)
    assert_allclose(of.update(1.0, P), [1, 1, 1, 0, 0], atol=0)
    assert_allclose(of.initial_state(P), [1, 1, 1, 0, 0], atol=0)
    assert_allclose(jax.jit(of.update)(1.0, P), of.update(1.0, P), atol=0)


def test_relief_opens_at_its_pressure():
    of = fluid.Relief(1e6, 1e-7)
    assert_allclose(of.flow(np.array([0.0, 1e6, 1.1e6])), [0, 0, 0.01], atol=1e-16)
    assert_allclose(of.lost_power(1.1e6), 0.01 * fluid.OIL.flow_energy(1.1e6), rtol=1e-13)
    assert_allclose(jax.grad(of.flow)(1.1e6), 1e-7, rtol=1e-14)


def test_slopes_are_finite():
    for of in (pump, variable):
        for P in (0.0, 9e5, 1e6):
            slopes = jax.grad(lambda of, P: of.flow(P) + of.lost_power(P), (0, 1))(of, P)
            assert all(np.isfinite(x) for x in jax.tree.leaves(slopes))
