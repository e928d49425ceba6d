import jax
import jax.numpy as jnp
import numpy as np
import pytest

from fascicle.core.once import traced_once


@pytest.fixture
def counted():
    """A function, and the list of what it was asked with."""
    asked = []

    def cube(row, x):
        asked.append(x)
        return row["of"] * x**3

    return traced_once(cube), asked


def test_a_program_goes_through_it_once(counted):
    cube, asked = counted
    row = {"of": np.array([1.0, 2.0])}

    def program(x):
        for _ in range(5):
            x = cube(row, x)
        return x

    x = np.array([0.5, 0.25])
    y = jax.jit(program)(x)
    assert len(asked) == 1
    np.testing.assert_allclose(y, program(x), rtol=1e-15)
    assert len(asked) == 6  # NumPy's, each time
    assert not [one for one in asked[1:] if isinstance(one, jax.Array)]


def test_another_shape_is_another_trace(counted):
    cube, asked = counted
    jax.jit(lambda x: cube({"of": 1.0}, x) + cube({"of": 1.0}, x[0]))(jnp.ones(3))
    assert [np.shape(x) for x in asked] == [(3,), ()]


def test_it_has_the_derivatives_and_batches_of_what_it_is_made_of(counted):
    cube, _ = counted
    x = jnp.array([1.0, 2.0])
    slopes = jax.vmap(jax.grad(lambda x: cube({"of": 2.0}, x)))(x)
    np.testing.assert_allclose(slopes, 6 * x**2, rtol=1e-15)


def test_it_leaves_no_call_in_a_program(counted):
    cube, _ = counted
    program = jax.make_jaxpr(lambda x: cube({"of": 2.0}, x))(1.0)
    assert {one.primitive.name for one in program.eqns} == {"integer_pow", "mul"}
