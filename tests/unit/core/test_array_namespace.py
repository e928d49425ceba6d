"""Numbers on their own: equal to NumPy's results for arrays of them."""

import numpy as np
import pytest

from fascicle.core.array_namespace import maximum, minimum, where


NUMBERS = (-np.inf, -1.0, 0.0, 2.5, np.inf, np.nan)


@pytest.mark.parametrize("kind", [float, np.float64])
@pytest.mark.parametrize("y", NUMBERS)
def test_minimum_and_maximum_of_two_numbers(y, kind):
    for x in NUMBERS:
        for ours, theirs in ((minimum, np.minimum), (maximum, np.maximum)):
            result = ours(kind(x), y)
            np.testing.assert_array_equal(result, theirs(x, y))
            assert type(result) is np.float64


def test_numbers_are_chosen_without_conversion():
    assert where(np.bool_(True), 1.5, 2) == 1.5
    assert where(False, 1.5, np.float64(2)) == 2
    assert type(where(np.array([True]), 1.5, 2.0)) is np.ndarray
