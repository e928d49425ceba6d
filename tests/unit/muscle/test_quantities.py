"""Forces at many pressures and strains: by NumPy and by JAX."""

import jax
import jax.numpy as jnp
import numpy as np
from numpy.testing import assert_allclose

import fascicle as fs


MUSCLE = fs.example("kim2021_figure_6")


def test_rows_of_muscles_go_with_a_field():
    length = np.linspace(0.1, 0.2, 40)[:, None]
    rows = MUSCLE.replace(length=length)
    P, eps = np.full((40, 1), 2e5), np.linspace(0, 0.3, 100)
    found = jax.jit(fs.Muscle.force)(rows, jnp.asarray(P), jnp.asarray(eps))
    assert_allclose(found, rows.force(P, eps), rtol=1e-11, atol=1e-10)


def test_derivatives_of_arrays_are_those_of_single_points():
    random = np.random.default_rng(0)
    P, eps = map(jnp.asarray, random.uniform([[[0.0]]] * 2, [[[4e5]], [[0.3]]], (2, 17, 61)))
    slopes = jax.jit(jax.grad(lambda *point: MUSCLE.force(*point).sum(), argnums=(0, 1)))
    single = jax.jit(jax.vmap(jax.grad(MUSCLE.force, argnums=(0, 1))))
    for found, wanted in zip(slopes(P, eps), single(P.ravel(), eps.ravel()), strict=True):
        assert_allclose(found.ravel(), wanted, rtol=1e-9, atol=1e-11 * np.abs(wanted).max())
    response = jax.jit(MUSCLE.response)(P, eps)
    assert_allclose(response.region, MUSCLE.response(np.asarray(P), np.asarray(eps)).region)
