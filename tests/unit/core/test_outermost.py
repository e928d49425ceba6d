"""Programs of their own: what JAX compiles for parts of others, in wider registers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fascicle as fs
from fascicle.core import outermost
from fascicle.core.outermost import Outermost


X = np.linspace(0.1, 3.0, 1000)


def law(x, y):
    return jnp.exp(-x) / (y + x)


@pytest.fixture
def kinds():
    """What is asked for: a program of its own, or a part of another."""
    called, force = [], Outermost(law)

    def told(kind, function):
        def call(*arrays, **named):
            called.append(kind)
            return function(*arrays, **named)

        return call

    force._part, force._whole = told("part", force._part), told("whole", force._whole)
    return force, called


def test_concrete_values_are_a_program_of_their_own(kinds):
    (force, called), points = kinds, jnp.asarray(X)
    assert_allclose(force(X, y=2.0), law(X, 2.0), rtol=1e-14)
    assert_allclose(jax.jit(lambda s: s * force(points, 2.0))(3.0), 3 * law(X, 2.0))
    assert called == ["whole", "whole"]


def test_traced_ones_are_parts(kinds):
    force, called = kinds
    assert_array_equal(jax.jit(force)(X, 2.0), jax.jit(law)(X, 2.0))
    slope = jax.grad(lambda y: force(1.0, y))(2.0)
    assert_allclose(slope, -np.exp(-1.0) / 9)
    assert_allclose(jax.vmap(force, (0, None))(X, 2.0), law(X, 2.0), rtol=1e-14)
    assert called == ["part"] * 3
    assert "exp" in force.lower(X, 2.0).as_text()


def test_constants_may_be_traced():
    def of(y):
        return Outermost(law, jnp.asarray(1.0) * y)(2.0)

    assert_allclose(jax.grad(of)(1.0), jax.grad(lambda y: law(y, 2.0))(1.0))


def test_a_wish_that_is_not_known_is_none(monkeypatch):
    monkeypatch.setattr(outermost, "_WISHES", {"xla_cpu_no_such_wish": "512"})
    outermost._granted.cache_clear()
    try:
        assert_allclose(Outermost(law)(X, 2.0), law(X, 2.0), rtol=1e-14)
        assert not outermost._granted("cpu")
        assert not outermost._granted("gpu")
    finally:
        outermost._granted.cache_clear()


def test_many_points_of_numpys_within_a_program():
    muscle = fs.example("kim2021_figure_6")
    P, eps = np.linspace(0.0, 4e5, 250_000), np.linspace(0.0, 0.3, 250_000)
    within = jax.jit(lambda s: s * jnp.sum(muscle.force(P, eps)))(2.0)
    assert_allclose(within, 2 * np.sum(muscle.force(P, eps)), rtol=1e-12)
