"""Trees of numbers as keys."""

import jax.numpy as jnp
import numpy as np

import fascicle as fs
from fascicle.core.same import Same


def test_the_same_numbers_are_the_same():
    of = {Same(fs.example("kim2021_figure_6")): 1}
    one = fs.example("kim2021_figure_6")
    assert Same(one) in of and Same(one).tree is one
    assert Same(one.replace(length=0.128)) not in of
    assert Same(one.replace(buckling="elastica")) not in of
    assert Same(one) != one


def test_of_another_library_kind_or_shape_they_are_others():
    x = np.arange(6.0)
    others = (jnp.asarray(x), x.astype(int), x.reshape(2, 3), list(x))
    assert all(Same(other) != Same(x) for other in others)
    assert Same(x.copy()) == Same(x) and Same(-0.0) != Same(0.0)
