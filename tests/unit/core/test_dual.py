import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.core.arrays import least, most, nodes, spread, stack, total, where
from fascicle.core.dual import _RULES, Dual, seeded, slopes_of


ONE = [rule for rule in _RULES if rule.nin == 1]
TWO = [rule for rule in _RULES if rule.nin == 2]


def both_slopes(function, *values):
    """The slopes that NumPy finds of a function, and JAX's."""
    duals = seeded(values)
    found = slopes_of(function(*duals), sum(np.size(x) for x in values))
    by = jax.jacfwd(function, tuple(range(len(values))))(*map(jnp.asarray, values))
    shape = np.shape(function(*values))
    return found, np.concatenate([np.reshape(x, (*shape, -1)) for x in by], axis=-1)


@pytest.mark.parametrize("ufunc", ONE, ids=lambda ufunc: ufunc.__name__)
def test_functions_of_one_have_the_slopes_of_jax(ufunc):
    function = lambda x: (jnp if isinstance(x, jax.Array) else np).__dict__[ufunc.__name__](x)  # noqa: E731
    found, by = both_slopes(function, np.array([0.1, 0.5, 0.9]))
    assert_allclose(found, by, rtol=1e-14)


@pytest.mark.parametrize("ufunc", TWO, ids=lambda ufunc: ufunc.__name__)
def test_functions_of_two_have_the_slopes_of_jax(ufunc):
    def function(x, y):
        library = jnp if isinstance(x, jax.Array) else np
        return library.__dict__[ufunc.__name__](x, y)

    # the last are equal: a kink of `minimum` and `maximum`
    found, by = both_slopes(function, np.array([0.1, 2.0, 0.5]), np.array([3.0, 0.7, 0.5]))
    assert_allclose(found, by, rtol=1e-14)


def test_kinks_have_the_slopes_of_jax():
    found, by = both_slopes(lambda x: abs(x) + x**2 + x**0, np.array([-1.0, 0.0, 1.0]))
    assert_allclose(found, by, rtol=1e-14)


def test_entries_that_move_take_their_slopes_along():
    def moved(x, y):
        rows = stack([x, y * x, 1.0 + 0.0 * x])
        picked = where(rows > 0.5, rows, y)[..., None, 1:]
        nodal = nodes((1.0, 2.0), x) * x
        return total(rows) + least(rows) * most(rows) + total(picked)[0, 0] + total(nodal)

    found, by = both_slopes(moved, np.array([0.3, 0.8, 0.6]), np.array([0.7, 2.0, 0.1]))
    assert_allclose(found, by, rtol=1e-14)


def test_shapes_that_broadcast_and_are_joined():
    def joined(x, y):
        library = jnp if isinstance(x, jax.Array) else np
        table = spread(x) * y + library.broadcast_to(y, (2, 3))
        whole = library.concatenate([table, spread(x)], axis=-1)
        place = np.array([[2], [0]])
        taken = library.take_along_axis(whole, place, axis=1)
        a, _ = library.broadcast_arrays(x[0], y)
        return library.reshape(whole, (-1,))[3:6] * taken[0] + a

    found, by = both_slopes(joined, np.array([0.3, 0.8]), np.array([0.7, 2.0, 0.1]))
    assert_allclose(found, by, rtol=1e-14)


def test_what_would_lose_slopes_is_refused():
    (x,) = seeded([np.array([1.0, 2.0])])
    with pytest.raises(TypeError, match="without them"):
        np.asarray(x)
    with pytest.raises(TypeError):
        np.cumsum(x)
    with pytest.raises(KeyError):
        np.sinh(x)


def test_values_alone_are_compared_and_counted():
    x = Dual(np.array([1.0, 3.0]), np.ones((2, 1)))
    assert np.array_equal(x > 2, [False, True]) and isinstance(x > 2, np.ndarray)
    assert np.shape(x) == x.shape == (2,) and np.ndim(x) == x.ndim == 1 and x.size == 2
    assert np.argmax(x) == 1
