import numpy as np
import pytest
from numpy.testing import assert_allclose

from fascicle.bundle.crossings import _extremum


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("outside", [-3.0, -0.1, 1.1, 8.0])
@pytest.mark.parametrize("inside", [0.05, 0.5, 0.9])
def test_a_cubic_turns_where_its_slope_vanishes(inside, outside, sense):
    """Whose slope is that of a parabola with one zero in the cell, and one beyond it."""
    a, b = inside, outside
    right = sense * (1 / 3 - (a + b) / 2 + a * b)
    slopes = (sense * a * b, sense * (1 - a) * (1 - b))
    ends = (np.float64(x) for x in (0.0, right, *slopes))
    assert_allclose(_extremum(*ends), a, rtol=1e-12)


def test_a_curve_that_does_not_turn_is_cut_in_the_middle():
    values = (np.float64(x) for x in (0.0, 1.0, 1.0, 1.0))
    assert _extremum(*values) == 0.5
