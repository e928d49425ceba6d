import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.test_util import check_grads
from numpy.testing import assert_allclose

import fascicle as fs


L0, R0, T0, ANGLE = 0.127, 6.35e-3, 1.6e-3, np.radians(33)
bladder = fs.Muscle(L0, R0, T0, ANGLE).bladder
strains = np.linspace(0.95 * (1 - 1 / np.cos(ANGLE)), 0.6, 33)


def closed_form(eps):
    """A dW/dλ, differentiated by hand: λ1 = λ, λ2² = q = (1 − c²λ²)/s², q' = −2c²λ/s²."""
    lam, c, s = 1 - eps, np.cos(ANGLE), np.sin(ANGLE)
    q, dq = (1 - c**2 * lam**2) / s**2, -2 * c**2 * lam / s**2
    dI1 = 2 * lam + dq - 2 / (lam**3 * q) - dq / (lam**2 * q**2)
    dI2 = -2 / lam**3 - dq / q**2 + 2 * lam * q + lam**2 * dq
    return np.pi * (R0**2 - (R0 - T0) ** 2) * (118.4e3 * dI1 + 105.7e3 * dI2)


def test_force_matches_the_closed_form():
    # near straight fibers the terms are thousands of newtons: rtol of the largest suffices
    assert_allclose(bladder.force(strains), closed_form(strains), rtol=1e-11, atol=1e-10)


def test_sign():
    assert_allclose(bladder.force(0.0), 0, atol=1e-12)  # of A·c10 ≈ 6 N
    assert np.all(np.asarray(bladder.force(strains[strains > 0])) < 0)  # pushes when shortened
    assert np.all(np.asarray(bladder.force(strains[strains < 0])) > 0)  # pulls when stretched


def test_section():
    ri = R0 - T0
    assert_allclose(bladder.inner_radius, ri, rtol=1e-15)
    assert_allclose(bladder.area, np.pi * (R0**2 - ri**2), rtol=1e-15)
    assert_allclose(bladder.second_moment, np.pi / 4 * (R0**4 - ri**4), rtol=1e-15)
    assert_allclose(bladder.volume, bladder.area * L0, rtol=1e-15)


def test_gradients_and_batches():
    check_grads(bladder.force, (0.1,), order=2, rtol=1e-5)  # of finite differences
    assert bladder.force(jnp.zeros((2, 3))).shape == (2, 3)
    slopes = eqx.filter_grad(lambda b: b.force(0.2))(bladder)
    assert all(np.isfinite(leaf) for leaf in jax.tree.leaves(slopes))
    # the force is linear in the two constants: Euler's theorem on homogeneous functions
    material = bladder.material
    total = material.c10 * slopes.material.c10 + material.c01 * slopes.material.c01
    assert_allclose(total, bladder.force(0.2), rtol=1e-13)
