import math

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.muscle.tension import Meller2014, TonduLopez


ANGLE = math.radians(33)
SIZES = (0.127, 6.35e-3, 1.6e-3, ANGLE)
IDEAL = fs.Muscle(*SIZES, tension="ideal")
P = np.array([[0.0], [34.5e3], [300e3], [1e6]])
EPS = np.linspace(-0.1, 0.2, 7)


def muscle(law):
    return fs.Muscle(*SIZES, tension=law)


@pytest.mark.parametrize("name", ["tondu_lopez", "meller2014"])
def test_by_name_alone_it_is_the_ideal_law(name):
    assert np.array_equal(muscle(name).response(P, EPS).mesh, IDEAL.response(P, EPS).mesh)
    assert np.array_equal(muscle(name).free_strain(P), IDEAL.free_strain(P))
    assert np.array_equal(muscle(name).force(P, 0.4), IDEAL.force(P, 0.4))


def test_tondu_lopez_is_the_formula_in_print():
    a, b = 3 / math.tan(ANGLE) ** 2, 1 / math.sin(ANGLE) ** 2
    k = 0.4 * np.exp(-P / 1e5) + 1.1
    law = TonduLopez(strain_factor=1.1, strain_factor_rise=0.4, decay_pressure=1e5)
    expected = math.pi * 6.35e-3**2 * P * (a * (1 - k * EPS) ** 2 - b)
    # a (1 − kε)² and b may nearly cancel: of the force at rest
    assert_allclose(
        law.components(IDEAL.bladder, P, EPS)[0], expected, rtol=1e-12, atol=1e-12 * 500
    )
    assert_allclose(muscle(law).free_strain(P[:, 0]), (1 - math.sqrt(b / a)) / k[:, 0], rtol=1e-13)


def test_meller_restores_what_was_measured():
    law = Meller2014.from_measured(IDEAL.braid, 2e5, free_strain=0.25, blocked_force=80.0)
    made = muscle(law)
    assert_allclose(made.free_strain(2e5), 0.25, rtol=1e-14)
    assert_allclose(made.blocked_force(2e5), 80.0, rtol=1e-14)
    # both factors are constants: other pressures follow
    assert_allclose(made.free_strain(1e5), 0.25, rtol=1e-14)
    assert_allclose(made.blocked_force(1e5), 40.0, rtol=1e-14)
    assert_allclose(law.strain_factor, IDEAL.free_strain(2e5) / 0.25, rtol=1e-14)


def test_an_offset_counts_against_the_corrected_force():
    law, c1 = Meller2014(1.2, 0.8), jnp.asarray(3.0)
    found = law.free_strain(IDEAL.bladder, 1e5, lambda P: c1 + 0 * P)
    assert_allclose(law.components(IDEAL.bladder, 1e5, found)[0], 3.0, rtol=1e-13)
