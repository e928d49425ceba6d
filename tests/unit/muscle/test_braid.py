import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.test_util import check_grads
from numpy.testing import assert_allclose

from fascicle.muscle.braid import Braid


L0, R0, ANGLE = 0.127, 6.35e-3, np.radians(33)
braid = Braid(jnp.asarray(L0), jnp.asarray(R0), jnp.asarray(ANGLE))
STRAIGHT = 1 - 1 / np.cos(ANGLE)
strains = np.linspace(0.999 * STRAIGHT, 0.6, 33)


def test_fibers_keep_their_length():
    # unrolled, a fiber of n turns is the hypotenuse over L and 2πnr
    turns = L0 * np.tan(ANGLE) / (2 * np.pi * R0)
    L, r = L0 * (1 - strains), np.asarray(braid.radius_at(strains))
    assert_allclose(np.hypot(L, 2 * np.pi * turns * r), L0 / np.cos(ANGLE), rtol=1e-14)
    # arccos loses half the digits where the fibers are nearly straight
    assert_allclose(np.tan(braid.angle_at(strains)), 2 * np.pi * turns * r / L, rtol=1e-10)


def test_at_rest():
    assert braid.squared_stretch(0.0) == 1  # exactly, or a bladder at rest would pull
    assert_allclose(braid.volume(0.0), np.pi * R0**2 * L0, rtol=1e-15)
    assert_allclose(braid.angle_at(0.0), ANGLE, rtol=1e-15)


def test_ends_of_the_domain():
    assert_allclose(
        braid.squared_stretch(STRAIGHT), 0, atol=1e-15
    )  # straight fibers enclose nothing
    free = braid.ideal_free_strain
    assert_allclose(free, 0.3116, atol=5e-5)  # the model's table, four digits
    assert_allclose(np.degrees(braid.angle_at(free)), 54.7356, atol=5e-5)
    # the two terms are of order πr0²P/sin²α0 = 85 N at 2e5 Pa
    assert_allclose(braid.mesh_force(2e5, free), 0, atol=1e-12)


def test_gradients():
    force = jax.jit(lambda P, eps: braid.mesh_force(1e5 * P, eps))
    check_grads(force, (2.0, 0.18), order=2, rtol=1e-6)
    slopes = eqx.filter_grad(lambda b: b.mesh_force(2e5, 0.1))(braid)
    assert_allclose(slopes.radius, 2 * braid.mesh_force(2e5, 0.1) / R0, rtol=1e-13)  # F ∝ r0²
    assert_allclose(slopes.length, 0, atol=1e-9)  # of forces over lengths of 1e3 N/m
    assert np.isfinite(slopes.angle)
    assert np.all(np.isfinite(jax.vmap(jax.grad(braid.radius_at))(strains)))
