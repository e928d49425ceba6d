import numpy as np
import pytest

from fascicle import plot
from fascicle.files import example
from fascicle.muscle import Muscle
from fascicle.plot.style import SINGLE, in_kilopascals, new_figure


MUSCLE = example("kim2021_figure_6")
assert isinstance(MUSCLE, Muscle)
PRESSURES, STRAINS = np.array([0.0, 34.5e3, 137.9e3]), np.linspace(0.0, 0.3, 31)


def test_ticks_have_their_printed_size_whoever_draws():
    figure, axes = new_figure()
    axes[0, 0].plot([0, 1], [0, 1])
    figure.canvas.draw()
    sizes = {label.get_fontsize() for label in axes[0, 0].get_xticklabels()}
    assert sizes == {7.0}


def test_drawing_leaves_the_global_style_alone():
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    plot.to_bytes(plot.free_strain([0.0, 1e5], {"a": [0.0, 0.1]}), "png")
    assert dict(mpl.rcParams) == before


def test_a_figure_is_as_wide_as_a_column():
    figure, _ = new_figure(width=SINGLE)
    assert figure.get_figwidth() * 25.4 == pytest.approx(88)


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_the_same_drawing_gives_the_same_file(kind):
    files = [plot.to_bytes(plot.free_strain([0.0, 1e5], {"a": [0.0, 0.1]}), kind) for _ in range(2)]
    assert files[0] == files[1]
    assert len(files[0]) > 1000


def test_pressures_are_named_in_kilopascals():
    assert [in_kilopascals(P) for P in (0.0, 34.5e3, 413.7e3)] == ["0 kPa", "34.5 kPa", "413.7 kPa"]


def test_force_over_strain_shows_the_law():
    axes = plot.force_strain(MUSCLE, PRESSURES, STRAINS).axes[0]
    drawn = {line.get_label(): line.get_ydata() for line in axes.lines}
    for P in PRESSURES:
        np.testing.assert_allclose(drawn[in_kilopascals(P)], MUSCLE.force(P, STRAINS), rtol=1e-12)


def test_components_add_up_to_the_force():
    figure = plot.force_strain(MUSCLE, PRESSURES, STRAINS, components=True)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == len(PRESSURES)
    for axes in panels:
        lines = {line.get_label(): line for line in axes.lines}
        total = lines["$F_{total}$"].get_ydata()
        mesh = lines["$F'_{mesh}$, along the bent arc"].get_ydata()
        wall = lines["$F_{bladder}$ with bending $F'_b$"].get_ydata()
        np.testing.assert_allclose(mesh + wall, total, atol=1e-12)


def test_too_many_panels_are_refused():
    with pytest.raises(ValueError, match="at most 4"):
        plot.force_strain(MUSCLE, np.linspace(0, 1e5, 5), STRAINS, components=True)


def test_a_notebook_shows_a_figure_before_pyplot_made_one():
    formatters = pytest.importorskip("IPython.core.formatters", reason="no IPython: make setup")
    found, _ = formatters.DisplayFormatter().format(MUSCLE.plot())
    assert found["image/png"].startswith(b"\x89PNG")
