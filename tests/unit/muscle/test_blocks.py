"""Blocks give what the function gives at once, whatever the shapes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.muscle import blocks
from fascicle.muscle.blocks import in_blocks


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(blocks, "_POINTS", 64)


@pytest.mark.parametrize(
    "shapes",
    [
        ((), ()), ((63,), ()), ((1000,), (1000,)), ((997,), ()), ((), (997,)),
        ((40, 1), (50,)), ((1, 50), (40, 1)), ((40, 1), (1, 500)), ((2, 1), (1009,)),
        ((3, 1, 70), (5, 1)), ((1, 1), (1, 300)), ((0, 1), (500,)),
    ],
)  # fmt: skip
def test_shape_and_values_are_those_of_the_whole(shapes):
    rng = np.random.default_rng(0)
    first, second = (jnp.asarray(rng.normal(size=shape)) for shape in shapes)
    both = in_blocks(lambda x, y: (x * y, jnp.broadcast_to(x, (x + y).shape)), first, second)
    assert_array_equal(both[0], first * second)
    assert_array_equal(both[1], jnp.broadcast_to(first, (first + second).shape))


def test_no_block_is_much_larger_than_meant():
    seen = []

    def function(x, y):
        seen.append(np.broadcast_shapes(x.shape, y.shape))
        return x + y

    in_blocks(function, jnp.ones((1000, 1)), jnp.ones(10))
    in_blocks(function, jnp.ones((2, 1)), jnp.ones(10_000))
    assert max(np.prod(shape) for shape in seen) <= 64


def test_derivatives_go_through_blocks():
    rng = np.random.default_rng(1)
    x, y = jnp.asarray(rng.normal(size=(30, 1))), jnp.asarray(rng.normal(size=21))

    def total(function):
        return jax.grad(lambda x, y: jnp.sum(jnp.cos(function(x, y))), (0, 1))(x, y)

    whole, apart = total(lambda x, y: x**2 * y), total(lambda x, y: in_blocks(_square, x, y))
    for a, b in zip(whole, apart, strict=True):
        assert_allclose(b, a, rtol=1e-13)


def _square(x, y):
    return x**2 * y


def test_a_muscles_force_is_the_same_in_blocks(monkeypatch):
    muscle = fs.example("kim2021_slenderness_10")
    P, eps = np.linspace(0, 4e5, 23)[:, None], np.linspace(-0.1, 0.4, 31)
    apart = muscle.response(P, eps)
    monkeypatch.setattr(blocks, "_POINTS", 2**16)
    jax.clear_caches()
    whole = muscle.response(P, eps)
    # roots end within their own rounding, in blocks or not
    assert_allclose(apart.force, whole.force, rtol=0, atol=1e-11)
    assert_array_equal(apart.region, whole.region)


def test_muscles_each_with_its_points_are_left_whole():
    angle = np.linspace(0.4, 0.7, 200)
    muscles = fs.Muscle.from_dimensions(0.1, 0.006, 0.0015, angle)
    each = [fs.Muscle.from_dimensions(0.1, 0.006, 0.0015, a).force(2e5, 0.05) for a in angle[::67]]
    assert_allclose(muscles.force(2e5, 0.05)[::67], each, rtol=1e-12)
