import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads
from numpy.testing import assert_allclose

from fascicle.core.roots import root


def residual(theta, x):
    return theta - x**2, -2 * x


def square_root(theta, start=0.5):
    return root(residual, theta, 0.0, 10.0, start)


def with_slope(function):
    """A residual from a function of x alone, its slope by JAX."""
    return lambda _, x: jax.jvp(function, (x,), (jnp.ones_like(x),))


@pytest.mark.parametrize("xp", [np, jnp])
def test_root_is_right_to_the_last_bits(xp):
    # the search stops when a step is below 4 ulp of 1 + |x|
    theta = xp.array([[1e-4, 0.25], [2.0, 81.0]])
    x = square_root(theta)
    assert isinstance(x, xp.ndarray)
    assert_allclose(x, np.sqrt(theta), rtol=0, atol=1e-14)
    assert type(square_root(np.float64(2.0))) is np.float64


def test_root_has_the_implicit_derivatives():
    # of x = √θ: 1/(2x), −1/(4x³) and 3/(8x⁵)
    first = jax.grad(square_root)
    second, third = jax.grad(first), jax.grad(jax.grad(first))
    assert_allclose(third(2.0), 3 / (8 * np.sqrt(2) ** 5), rtol=1e-12)
    assert_allclose(first(2.0), 1 / (2 * np.sqrt(2)), rtol=1e-13)
    assert_allclose(second(2.0), -1 / (4 * np.sqrt(8)), rtol=1e-12)
    check_grads(square_root, (2.0,), order=2, rtol=1e-6)


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda x: -jnp.arctan(50 * (x - 0.03)), 0.03),  # Newton alone diverges
        (lambda x: 0.5 - x**3, 0.5 ** (1 / 3)),  # flat where it starts
        (lambda x: 0.3 - jnp.sqrt(x), 0.09),  # vertical where it starts
        (lambda x: -x, 0.0),  # at the bracket's low end
        (lambda x: 1 - x, 1.0),  # at its high end
        (lambda x: jnp.where(x > 0.7, -1.0, 1.0), 0.7),  # nothing but a jump
    ],
)
def test_root_stays_in_its_bracket(function, expected):
    x = root(with_slope(function), (), *map(jnp.float64, (0.0, 1.0, 0.0)))
    assert_allclose(x, expected, rtol=0, atol=1e-14)


def test_a_flat_residual_moves_no_root():
    # every x solves 0 = 0: no derivative exists, and none must poison a sum as a NaN
    flat = lambda theta, x: (0 * theta * x, 0 * theta)  # noqa: E731
    assert jax.grad(lambda theta: root(flat, theta, 0.0, 1.0, 0.5))(1.0) == 0


def test_the_bracket_has_no_derivative():
    def root_above(low):
        fixed = lambda _, x: (0.5 - x, -1 + 0 * x)  # noqa: E731
        return root(fixed, (), jnp.sqrt(low), 1.0, jnp.sqrt(low))

    assert jax.grad(root_above)(0.0) == 0  # √ has an infinite slope there


def test_root_broadcasts_and_maps():
    theta, shift = jnp.linspace(0.5, 2, 4), jnp.zeros((3, 1))
    x = root(residual, theta + shift, jnp.zeros((3, 1)), 10.0, 1.0)
    assert x.shape == (3, 4) and x.dtype == jnp.float64
    assert_allclose(x, np.broadcast_to(jax.vmap(square_root)(theta), (3, 4)), rtol=1e-14)


@pytest.mark.parametrize("xp", [np, jnp])
def test_a_short_first_step_is_not_the_last(xp):
    # 1e-5 to go, and a curvature that makes Newton's error there larger than the rounding
    def bent(_, x):
        return (0.5 - x) + 1e3 * (0.5 - x) ** 2, -1 - 2e3 * (0.5 - x)

    start = xp.float64(0.5 - 1e-5)
    assert_allclose(root(bent, (), 0.4999, 0.6, start), 0.5, rtol=0, atol=1e-15)
