import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.test_util import check_grads
from numpy.testing import assert_allclose

import fascicle as fs


L0, R0, T0, ANGLE = 0.127, 6.35e-3, 1.6e-3, np.radians(33)
bladder = fs.Muscle(L0, R0, T0, ANGLE).bladder


def test_section():
    ri = R0 - T0
    assert_allclose(bladder.inner_radius, ri, rtol=1e-15)
    assert_allclose(bladder.area, np.pi * (R0**2 - ri**2), rtol=1e-15)
    assert_allclose(bladder.second_moment, np.pi / 4 * (R0**4 - ri**4), rtol=1e-15)
    assert_allclose(bladder.volume, bladder.area * L0, rtol=1e-15)


def test_gradients_and_batches():
    check_grads(jax.jit(bladder.force), (0.1,), order=2, rtol=1e-5)  # of finite differences
    assert bladder.force(jnp.zeros((2, 3))).shape == (2, 3)
    slopes = eqx.filter_grad(lambda b: b.force(0.2))(bladder)
    assert all(np.isfinite(leaf) for leaf in jax.tree.leaves(slopes))
    # the force is linear in the two constants: Euler's theorem on homogeneous functions
    material = bladder.material
    total = material.c10 * slopes.material.c10 + material.c01 * slopes.material.c01
    assert_allclose(total, bladder.force(0.2), rtol=1e-13)
