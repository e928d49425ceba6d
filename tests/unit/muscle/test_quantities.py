"""Forces at many pressures and strains: by NumPy and by JAX."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs


MUSCLE = fs.example("kim2021_figure_6")
TUNED = MUSCLE.replace(tuning=fs.Tuning([1e5, 1e6], [2.0, 3.0], [0.9, 1.1], dead_band=2e4))
# its collapse is reached at some pressures alone, so that no series says where
SOMETIMES = MUSCLE.replace(collapse=fs.collapse.Kim2021Collapse(factor=4.0))
MUSCLES = {
    "plain": MUSCLE,
    "tuned": TUNED,
    "sometimes collapsing": SOMETIMES,
    "thin": fs.Muscle.from_dimensions(0.2, 10e-3, 0.2e-3, math.radians(20)),
}


@pytest.mark.parametrize(
    "muscle",
    [
        pytest.param(one, id=name, marks=[pytest.mark.slow] if name in ("tuned", "thin") else [])
        for name, one in MUSCLES.items()
    ],
)
def test_many_pressures_and_a_field_are_numpys(muscle):
    random = np.random.default_rng(0)
    P, eps = random.uniform([[0.0], [-0.05]], [[1e6], [0.5]], (2, 3000))
    down, across = np.linspace(0, 1e6, 60)[:, None], np.linspace(-0.05, 0.5, 300)
    force = jax.jit(muscle.force)
    for pressure, strain in ((P, eps), (down, across), (2e5, eps)):
        wanted = muscle.force(pressure, strain)
        found = force(jnp.asarray(pressure), jnp.asarray(strain))
        assert_allclose(found, wanted, rtol=1e-11, atol=1e-11 * np.abs(wanted).max())


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
