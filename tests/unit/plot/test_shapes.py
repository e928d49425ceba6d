import numpy as np
import pytest

from fascicle import plot
from fascicle.files import example
from fascicle.muscle import Muscle
from fascicle.plot.shapes import _fibers, outlines


MUSCLE = example("kim2021_figure_6")
assert isinstance(MUSCLE, Muscle)
REST, COLLAPSED = outlines(MUSCLE, [0.0, 34.5e3], [0.0, 0.25])


def test_a_muscle_at_rest_has_its_sizes():
    assert REST.z[-1] == pytest.approx(0.127)
    assert pytest.approx(6.35e-3) == REST.above
    assert np.all(REST.y == 0)


def test_fibers_lie_at_the_braid_angle():
    # where a fiber passes the axis it is seen at its true angle
    seen = 0
    for piece in _fibers(REST, 0.0):
        crossing = np.flatnonzero(np.diff(np.sign(piece[:, 1])))
        for i in crossing:
            dz, dy = piece[i + 1] - piece[i]
            # a chord of the sinusoid over half a millimeter: second order in the step
            assert np.degrees(np.arctan2(abs(dy), dz)) == pytest.approx(33, abs=0.1)
            seen += 1
    assert seen > 10


def test_walls_touch_at_the_hinge():
    height = COLLAPSED.above + COLLAPSED.below
    assert height.min() == pytest.approx(2 * 1.6e-3)
    assert height[0] == pytest.approx(2 * COLLAPSED.radius)


def test_after_collapse_the_tube_keeps_its_radius():
    collapse = float(MUSCLE.collapse_strain(34.5e3))
    (at,) = outlines(MUSCLE, [34.5e3], [collapse])
    assert pytest.approx(at.radius) == COLLAPSED.radius


def test_states_are_drawn_to_one_scale():
    figure = plot.shapes(MUSCLE, {"rest": (0.0, 0.0), "collapsed": (34.5e3, 0.25)})
    (axes,) = figure.axes
    width, height = figure.get_size_inches()
    per_mm = [
        width / np.diff(axes.get_xlim())[0],
        height / np.diff(axes.get_ylim())[0],
    ]
    assert per_mm[0] == pytest.approx(per_mm[1])
