import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle import fluid


ROOM, WARM = 101325.0, 293.15


def test_air_is_as_dense_as_known():
    # 1.2041 kg/m³ at 20 °C and the standard atmosphere: ICAO's air
    assert_allclose(fluid.AIR.density(ROOM, WARM), 1.2041, rtol=1e-4)
    assert_allclose(fluid.AIR.c_p, 1004.7, rtol=1e-4)
    assert_allclose(fluid.AIR.c_p - fluid.AIR.c_v, 287.05, rtol=1e-14)


def test_exergy_is_zero_in_the_room_alone():
    room = (ROOM, WARM)
    for gas in (fluid.AIR, fluid.NITROGEN):
        assert gas.flow_exergy(ROOM, WARM, *room) == 0
        assert gas.stored_exergy(1.0, ROOM, WARM, *room) == 0
        p, T = np.meshgrid(np.geomspace(1e3, 1e7, 21), np.linspace(200, 500, 13))
        assert np.all(gas.stored_exergy(1.0, p, T, *room) > 0)


def test_nothing_is_finite_with_its_slopes():
    slopes = jax.grad(fluid.AIR.stored_exergy, (0, 1, 2))(0.0, 0.0, WARM, ROOM, WARM)
    assert all(np.isfinite(x) for x in slopes)
    assert fluid.AIR.stored_exergy(0.0, 0.0, WARM, ROOM, WARM) == 0


@pytest.mark.parametrize("liquid", [fluid.OIL, fluid.WATER])
@pytest.mark.parametrize("pressure", [-5e4, 0.0, 4e5, 3e7])
def test_slopes_of_liquids(liquid, pressure):
    rho = liquid.density(pressure)
    assert_allclose(jax.grad(liquid.flow_energy)(pressure), 1 / rho, rtol=1e-13)
    slope = pressure / (liquid.bulk_modulus * rho)
    assert_allclose(jax.grad(liquid.stored_energy)(pressure), slope, rtol=1e-10, atol=1e-20)
    assert_allclose(jax.grad(liquid.density)(pressure), rho / liquid.bulk_modulus, rtol=1e-13)


def test_stored_energy_has_no_seam():
    K = fluid.OIL.bulk_modulus
    below, above = (fluid.OIL.stored_energy(K * x) for x in (0.01 - 1e-12, 0.01 + 1e-12))
    # the quadratic rises by 4e-10 of itself from one to the other
    assert_allclose(below, above, rtol=1e-9)
