"""Searches that begin where a few roots say end where they would have."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.polynomial import chebyshev
from numpy.testing import assert_allclose

from fascicle.core.guided import _BEND, _OFF, guided, lines
from fascicle.core.roots import root, searched


END = 3.0


def cubic(x, jump=0.0):
    """y³ + y = x + 1, and the root of another equation after it."""

    def falling(x, y):
        return x + 1 - y - y**3, -1 - 3 * y**2

    first = root(falling, x + jump * (x > 1), 0.0, 4.0, 4.0)
    return first, root(falling, first, 0.0, 4.0, 4.0)


def test_a_few_roots_say_where_others_are():
    known = lines(cubic, END)
    assert [line.steps for line in known] == [1, 1]
    x = np.linspace(0, END, 1001)
    asked = []

    def falling(x, y):
        asked.append(1)
        return x + 1 - y - y**3, -1 - 3 * y**2

    far = searched(falling, x, 0.0, 4.0, 4.0 + 0 * x)
    own = len(asked)
    with guided(known, x, END):
        near = searched(falling, x, 0.0, 4.0, 4.0 + 0 * x)
    assert len(asked) - own < own / 2
    assert_allclose(near, far, rtol=1e-12)


def test_a_line_is_as_long_as_its_accuracy_asks():
    """One term less, and it is further off than a step of Newton's makes good."""
    x = np.linspace(0, END, 2001)
    place = 2 * (1 + _BEND) * x / (x + _BEND * END) - 1
    most, steps = _OFF[0]
    for exact, line in zip(cubic(x), lines(cubic, END), strict=True):
        assert line.steps == steps
        whole, less = (chebyshev.chebval(place, line.series[:n]) for n in (None, -1))
        # between the nodes that were looked at it may be a little further off
        assert np.max(np.abs(whole - exact) / (1 + exact)) < 1.2 * most
        assert np.max(np.abs(less - exact) / (1 + exact)) > 0.8 * most


@pytest.mark.parametrize("jump", [0.0, 0.5])
def test_guided_searches_end_where_others_do(jump):
    """Also past the end, below zero, and across a jump, of which no series says anything."""
    known = lines(lambda x: cubic(x, jump), END)
    assert (known[0].steps == 0) == (jump != 0)
    x = jnp.linspace(-0.5, 3 * END, 500)

    def found(x):
        with guided(known, x, END):
            return jnp.stack(cubic(x, jump))

    def plain(x):
        return jnp.stack(cubic(x, jump))

    for mapped in (jax.jit(found), jax.vmap(found, out_axes=1)):
        assert_allclose(mapped(x), plain(x), rtol=1e-14)
    slopes = (jax.grad(lambda x, f=f: f(x).sum())(x) for f in (found, plain))
    assert_allclose(*slopes, rtol=1e-13)


def test_a_search_on_the_way_of_another_is_not_told():
    def outer(x, y):
        inner = searched(lambda _, z: (x + y - z, -1.0 + 0 * z), x, 0.0, 9.0, 0 * y)
        return 3 - y - 0 * inner, -1.0 + 0 * y

    assert len(lines(lambda x: searched(outer, x, 0.0, 9.0, 0 * x), END)) == 1


def test_without_a_line_a_search_begins_where_it_would():
    x = np.linspace(0, END, 5)

    def more():
        with guided((), x, END):
            return cubic(x)

    assert_allclose(more(), cubic(x), rtol=0)
