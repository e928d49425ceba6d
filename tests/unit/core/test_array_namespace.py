"""Numbers by themselves: the same as NumPy's arrays of them."""

import numpy as np
import pytest

from fascicle.core.array_namespace import maximum, minimum, where


SOME = (-np.inf, -1.0, 0.0, 2.5, np.inf, np.nan)


@pytest.mark.parametrize("kind", [float, np.float64])
@pytest.mark.parametrize("y", SOME)
@pytest.mark.parametrize("x", SOME)
def test_the_smaller_and_the_larger_of_two_numbers(x, y, kind):
    for ours, theirs in ((minimum, np.minimum), (maximum, np.maximum)):
        found = ours(kind(x), y)
        np.testing.assert_array_equal(found, theirs(x, y))
        assert type(found) is np.float64


def test_numbers_are_chosen_as_they_are():
    assert where(np.bool_(True), 1.5, 2) == 1.5
    assert where(False, 1.5, np.float64(2)) == 2
    assert type(where(np.array([True]), 1.5, 2.0)) is np.ndarray
