"""The buckled shape's two numbers, against bisection of the equations as they stand."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.muscle.buckling.kim2021 import bow_ratio, compression_at_moment


SLENDER = np.array([0.1, 1.0, 6.0, 25.0, 300.0, 4e3])  # c of L0/r0 from 1 to some 250


def share(c, xi):
    """u of (16a) by bisection in its logarithm."""
    b = c * xi * (1 - xi) ** 4 / (1 + xi)
    low, high = np.full_like(b, -60.0), np.zeros_like(b)
    for _ in range(80):
        u = np.exp(middle := (low + high) / 2)
        w = -np.expm1(middle)
        h = np.sqrt(1 - w * xi / (2 - xi)) / (1 - w * xi)
        low, high = np.where(u * h < b * w, middle, low), np.where(u * h < b * w, high, middle)
    return np.exp((low + high) / 2)


def height(c, xi):
    return np.sqrt(xi * share(c, xi)) * (1 - xi) ** -1.5


@pytest.fixture(scope="module")
def field():
    # to 0.72: the largest strain of the domain from the smallest free strain
    return np.meshgrid(np.logspace(-1, 5, 61), np.linspace(1e-6, 0.72, 120), indexing="ij")


def test_the_share_that_bows_is_that_of_the_equation(field):
    c, xi = field
    assert_allclose(xi * bow_ratio(c, xi), share(c, xi), rtol=1e-13)
    assert_allclose(xi * jax.jit(bow_ratio)(c, xi), share(c, xi), rtol=1e-13)


def test_without_compression_the_share_is_its_limit():
    assert_allclose(bow_ratio(SLENDER, 0.0), SLENDER, rtol=1e-14)
    slope = jax.jit(jax.vmap(jax.grad(bow_ratio, 1), (0, None)))(jnp.asarray(SLENDER), 0.0)
    # u/xi = c (1 - 5 xi) / (1 + 3/4 xi + c xi), to first order
    assert_allclose(slope, -SLENDER * (SLENDER + 5.75), rtol=1e-12)


def test_a_vanishing_moment_has_the_slope_of_its_limit():
    # ξ = m/√c to first order; (16c) as it stands has two roots that meet there, and a slope of 0
    slope = jax.vmap(jax.grad(lambda c, m: compression_at_moment(c, m)[0], 1), (0, None))
    assert_allclose(slope(jnp.asarray(SLENDER), 0.0), 1 / np.sqrt(SLENDER), rtol=1e-14)


@pytest.mark.parametrize("part", [1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999, 1 - 1e-7])
def test_a_moment_is_first_reached_there(part):
    places = np.linspace(0, 1, 20_001)[1:-1]
    for c in SLENDER:
        heights = height(c, places)
        top = heights.max()
        xi, reached = compression_at_moment(c, part * top)
        assert reached
        # a place, seen from a height, is as sharp as the slope: none at the peak
        assert_allclose(height(c, np.asarray(xi)), part * top, rtol=1e-12)
        assert xi <= places[np.argmax(heights)] + 1e-4


def test_a_moment_above_the_peak_is_never_reached():
    places = np.linspace(0, 1, 20_001)[1:-1]
    for c in SLENDER:
        top = height(c, places).max()
        # the grid's peak is low by the square of its step
        xi, reached = compression_at_moment(c, top * (1 + 1e-6))
        assert not reached and np.isfinite(xi)
