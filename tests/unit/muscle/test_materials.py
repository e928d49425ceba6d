import jax
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.materials import LATEX


def test_energy_of_a_stretch():
    # λ1 = 2, λ2 = 1: I1 = 4 + 1 + 1/4, I2 = 1/4 + 1 + 4, both 2.25 above 3
    rubber = fs.MooneyRivlin(100e3, 40e3)
    assert_allclose(rubber.energy(4.0, 1.0), 2.25 * 140e3, rtol=1e-15)
    # λ1 = λ2 = 2: I1 = 8 + 1/16, I2 = 1/2 + 16
    assert_allclose(rubber.energy(4.0, 4.0), 100e3 * 5.0625 + 40e3 * 13.5, rtol=1e-15)


def test_rest_is_the_energy_minimum():
    energy = LATEX.energy
    assert LATEX.energy(1.0, 1.0) == 0
    assert_allclose(jax.jit(jax.grad(energy, (0, 1)))(1.0, 1.0), 0, atol=1e-9)  # of 1e5 Pa
    (a, b), (_, c) = jax.jit(jax.hessian(energy, (0, 1)))(1.0, 1.0)
    assert a > 0 and a * c - b**2 > 0


def test_modulus_is_the_slope_of_uniaxial_tension():
    def energy(stretch):  # an incompressible bar: λ2² = 1/λ1
        return LATEX.energy(stretch**2, 1 / stretch)

    assert_allclose(jax.jit(jax.hessian(energy))(1.0), 6 * (118.4e3 + 105.7e3), rtol=1e-12)
    assert_allclose(LATEX.youngs_modulus, 1.3446e6, rtol=1e-12)


def test_from_youngs_modulus_keeps_latexs_ratio():
    rubber = fs.MooneyRivlin.from_youngs_modulus(2e6, 0.45)
    assert_allclose(6 * (rubber.c10 + rubber.c01), 2e6, rtol=1e-15)
    assert_allclose(rubber.c10 / rubber.c01, 118.4 / 105.7, rtol=1e-14)
    assert rubber.youngs_modulus == 2e6 and rubber.poisson_ratio == 0.45
    latex = fs.MooneyRivlin.from_youngs_modulus(6 * (118.4e3 + 105.7e3))
    assert_allclose(latex.c10, LATEX.c10, rtol=1e-15)
