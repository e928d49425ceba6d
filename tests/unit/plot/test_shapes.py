import numpy as np
import pytest

from fascicle.files import example
from fascicle.plot.shapes import _fibers, outlines


MUSCLE = example("kim2021_figure_6")
COLLAPSE = float(MUSCLE.collapse_strain(34.5e3))
REST, COLLAPSED, CRITICAL = outlines(MUSCLE, [0.0, 34.5e3, 34.5e3], [0.0, 0.25, COLLAPSE])


def test_a_muscle_at_rest_has_its_sizes():
    assert REST.z[-1] == pytest.approx(0.127)
    assert pytest.approx(6.35e-3) == REST.above
    assert np.all(REST.y == 0)


def test_fibers_lie_at_the_braid_angle():
    # where a fiber passes the axis it is visible at its true angle
    angles = [
        np.degrees(np.arctan2(abs(piece[i + 1, 1] - piece[i, 1]), piece[i + 1, 0] - piece[i, 0]))
        for piece in _fibers(REST, 0.0)
        for i in np.flatnonzero(np.diff(np.sign(piece[:, 1])))
    ]
    assert len(angles) > 10
    # a chord of the sinusoid over half a millimeter: second order in the step
    np.testing.assert_allclose(angles, 33, atol=0.1)


def test_walls_touch_at_the_hinge_of_a_tube_that_keeps_its_radius():
    height = COLLAPSED.above + COLLAPSED.below
    assert height.min() == pytest.approx(2 * 1.6e-3)
    assert height[0] == pytest.approx(2 * COLLAPSED.radius)
    assert pytest.approx(CRITICAL.radius) == COLLAPSED.radius
