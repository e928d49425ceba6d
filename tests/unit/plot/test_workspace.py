import numpy as np

from fascicle.bundle import Bundle, MotorUnit
from fascicle.bundle.energetics import efficiency_map
from fascicle.bundle.recruitment import overlap
from fascicle.files import example
from fascicle.plot import to_bytes
from fascicle.plot.workspace import efficiency, workspace


MUSCLE = example("kim2021_figure_9")
PAIR = Bundle([MotorUnit(MUSCLE), MotorUnit(MUSCLE)], 413.7e3)


def test_a_workspace_shows_every_curve_of_both_states():
    result = PAIR.workspace(levels=3, strain=np.linspace(0, 0.26, 14))
    axes = workspace(result, overlap(result)).axes[0]
    curves = [line.get_ydata() for line in axes.lines[1:]]  # the first is the zero
    np.testing.assert_array_equal(curves, result.force.reshape(6, -1))
    labels = axes.get_legend_handles_labels()[1]
    assert sorted(labels) == ["overlap of the states", "recruitment state 1", "recruitment state 2"]


def test_a_map_is_drawn_over_its_own_grid():
    result = efficiency_map(
        PAIR, force=np.linspace(50, 700, 14), strain=np.linspace(0.02, 0.24, 12), path="isotonic"
    )
    figure = efficiency(result)
    values = figure.axes[0].collections[0].get_array()
    np.testing.assert_array_equal(np.ma.filled(values, np.nan).reshape(14, 12), result.efficiency)
    assert b"<image" in to_bytes(figure, "svg")  # one picture, not a thousand paths
