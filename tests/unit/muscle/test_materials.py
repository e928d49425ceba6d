import jax
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.materials import LATEX, MATERIALS, SILICONE_KIM2021


def test_energy_of_a_stretch():
    # λ1 = 2, λ2 = 1: I1 = 4 + 1 + 1/4, I2 = 1/4 + 1 + 4, both 2.25 above 3
    rubber = fs.MooneyRivlin(100e3, 40e3)
    assert_allclose(rubber.energy(4.0, 1.0), 2.25 * 140e3, rtol=1e-15)
    # λ1 = λ2 = 2: I1 = 8 + 1/16, I2 = 1/2 + 16
    assert_allclose(rubber.energy(4.0, 4.0), 100e3 * 5.0625 + 40e3 * 13.5, rtol=1e-15)


def test_rest_is_the_energy_minimum():
    energy = LATEX.energy
    assert LATEX.energy(1.0, 1.0) == 0
    assert_allclose(jax.grad(energy, (0, 1))(1.0, 1.0), 0, atol=1e-9)  # of 1e5 Pa
    (a, b), (_, c) = jax.hessian(energy, (0, 1))(1.0, 1.0)
    assert a > 0 and a * c - b**2 > 0


def test_modulus_is_the_slope_of_uniaxial_tension():
    def energy(stretch):  # an incompressible bar: λ2² = 1/λ1
        return LATEX.energy(stretch**2, 1 / stretch)

    assert_allclose(jax.hessian(energy)(1.0), 6 * (118.4e3 + 105.7e3), rtol=1e-12)
    assert_allclose(LATEX.youngs_modulus, 1.3446e6, rtol=1e-12)


def test_named_materials():
    assert MATERIALS["latex"] is LATEX is fs.materials.LATEX
    assert (LATEX.c10, LATEX.c01, LATEX.poisson_ratio) == (118.4e3, 105.7e3, 0.5)
    silicone = SILICONE_KIM2021
    assert (silicone.c10, silicone.c01, silicone.youngs_modulus) == (88.8e3, 79.3e3, 1.78e6)


def test_from_youngs_modulus_keeps_latexs_ratio():
    rubber = fs.MooneyRivlin.from_youngs_modulus(2e6, 0.45)
    assert_allclose(6 * (rubber.c10 + rubber.c01), 2e6, rtol=1e-15)
    assert_allclose(rubber.c10 / rubber.c01, 118.4 / 105.7, rtol=1e-14)
    assert rubber.youngs_modulus == 2e6 and rubber.poisson_ratio == 0.45
    latex = fs.MooneyRivlin.from_youngs_modulus(6 * (118.4e3 + 105.7e3))
    assert_allclose(latex.c10, LATEX.c10, rtol=1e-15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"c10": 0.0}, r"^`c10` must be positive and finite, got 0 Pa\.$"),
        ({"c01": -1.0}, r"^`c01` must be positive and finite, got -1 Pa\.$"),
        (
            {"youngs_modulus": float("nan")},
            r"^`youngs_modulus` must be positive and finite, got nan",
        ),
        ({"poisson_ratio": 0.6}, r"^`poisson_ratio` must lie in \[0, 0\.5\].*, got 0\.6"),
        ({"poisson_ratio": "half"}, r"^`poisson_ratio` must be .*, got 'half'"),
    ],
)
def test_refuses_what_is_no_rubber(change, message):
    with pytest.raises(ValueError, match=message):
        fs.MooneyRivlin(**{"c10": 1e5, "c01": 1e5} | change)
