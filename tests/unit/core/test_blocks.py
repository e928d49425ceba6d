"""Blocks: the same as the whole, however arrays broadcast, and however many points are left."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fascicle.core import blocks


@pytest.fixture
def few(monkeypatch):
    """Blocks of eight points, and the shapes that a function was called with."""
    monkeypatch.setattr(blocks, "_POINTS", 8)
    called = []

    def law(a, b):
        called.append((np.shape(a), np.shape(b)))
        return a * 10 + b

    return law, called


@pytest.mark.parametrize(
    ("first", "second", "cut"),
    [
        ((32,), (32,), ((8,), (8,))),
        ((37,), (37,), ((8,), (8,))),  # prime: the last one reaches back
        ((40, 1), (5,), ((1, 1), (1, 5))),  # a field: rows by what is solved for
        ((12, 1), (50,), ((1, 1), (1, 50))),
        ((5,), (40, 1), ((1, 1), (40, 1))),
        ((), (37,), ((1,), (8,))),  # nothing to solve for again
        ((37,), (), ((8,), (1,))),
        ((1, 1), (3, 37), ((1, 1), (3, 2))),
        ((2, 37, 1), (2, 1, 3), ((2, 1, 1), (2, 1, 3))),
    ],
)
def test_blocks_are_the_whole(few, first, second, cut):
    law, called = few
    random = np.random.default_rng(0)
    a, b = (jnp.asarray(random.integers(0, 1000, shape), float) for shape in (first, second))
    found = jax.jit(lambda a, b: blocks.in_blocks(law, a, b))(a, b)
    assert_array_equal(found, np.asarray(a) * 10 + np.asarray(b))
    assert called[0] == cut


def test_few_points_and_numpys_are_left_whole(few):
    law, called = few
    assert blocks.in_blocks(law, jnp.arange(16.0), 1.0).shape == (16,)
    assert type(blocks.in_blocks(law, np.arange(1000.0), 1.0)) is np.ndarray
    assert called == [((16,), ()), ((1000,), ())]


def test_blocks_are_mapped_and_differentiated(few):
    law, _ = few
    a = jnp.arange(74.0).reshape(2, 37)
    found = jax.vmap(lambda row: blocks.in_blocks(lambda a, b: law(a, b) ** 2, row, row))(a)
    assert_array_equal(found, (11 * a) ** 2)
    slope = jax.grad(lambda a: blocks.in_blocks(lambda a, b: a * b, a, a).sum())(a[0])
    assert_array_equal(slope, 2 * a[0])
