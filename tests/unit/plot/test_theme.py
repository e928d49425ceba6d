import os
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

from fascicle import plot
from fascicle.core.errors import InvalidInputError
from fascicle.files import example
from fascicle.plot.theme import CYCLE, in_kilopascals, new_figure


MUSCLE = example("kim2021_figure_6")
PRESSURES, STRAINS = np.array([0.0, 34.5e3, 137.9e3]), np.linspace(0.0, 0.3, 31)


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
def test_a_drawing_is_reproducible_and_leaves_the_global_style_alone(kind):
    before = dict(mpl.rcParams)
    files = [plot.to_bytes(plot.free_strain([0.0, 1e5], {"a": [0.0, 0.1]}), kind) for _ in range(2)]
    assert files[0] == files[1] and len(files[0]) > 1000
    assert dict(mpl.rcParams) == before


def test_force_over_strain_shows_the_law():
    axes = plot.force_strain(MUSCLE, PRESSURES, STRAINS).axes[0]
    curves = {line.get_label(): line.get_ydata() for line in axes.lines}
    for P in PRESSURES:
        np.testing.assert_allclose(curves[in_kilopascals(P)], MUSCLE.force(P, STRAINS), rtol=1e-12)


def test_components_add_up_to_the_force():
    figure = plot.force_strain(MUSCLE, PRESSURES, STRAINS, components=True)
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == len(PRESSURES)
    for axes in panels:
        mesh, wall, total = (line.get_ydata() for line in axes.lines[-3:])
        np.testing.assert_allclose(mesh + wall, total, atol=1e-12)


def test_too_many_panels_and_panels_on_given_axes_are_refused():
    with pytest.raises(InvalidInputError) as error:
        plot.force_strain(MUSCLE, np.linspace(0, 1e5, 5), STRAINS, components=True)
    assert (error.value.argument, error.value.value) == ("pressures", 5)
    with pytest.raises(InvalidInputError) as error:
        plot.force_strain(MUSCLE, components=True, ax=new_figure()[1][0, 0])
    assert error.value.argument == "ax"


def test_a_notebook_shows_a_figure_before_pyplot_made_one():
    formatters = pytest.importorskip("IPython.core.formatters", reason="no IPython: make setup")
    data, _ = formatters.DisplayFormatter().format(plot.force_strain(MUSCLE))
    assert data["image/png"].startswith(b"\x89PNG")


PYPLOT = """
import sys
import matplotlib.pyplot as plt
import fascicle as fs
from fascicle import plot
muscle, bundle = fs.example("kim2021_figure_6"), fs.example("kim2021_bundle_1_4")
figure = plot.force_strain(muscle)
plt.savefig(sys.argv[1])
assert plt.imread(sys.argv[1])[..., :3].min() < 0.5  # not a blank page
assert plt.gcf() is figure
plot.to_bytes(figure, "png")
assert not plt.get_fignums()  # a notebook doesn't show it once more
figure, (first, second, third) = plt.subplots(1, 3)
assert plot.force_strain(muscle, [1e5], ax=first) is figure
assert plot.bundle_force_strain(bundle, ax=second) is figure
assert plot.bundle_force_strain(bundle, [3e5, 1e5], ax=third) is figure
assert all(ax.lines for ax in (first, second, third)) and len(plt.get_fignums()) == 1
"""


def test_pyplot_knows_figures_and_its_axes_are_drawn_on(tmp_path):
    """In a process of its own: other tests run without pyplot."""
    command = [sys.executable, "-c", PYPLOT, tmp_path / "x.png"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_notebooks_backend_stays_interactive(tmp_path):
    # as IPython's does, this backend makes matplotlib interactive as it is first used
    (tmp_path / "notebook_backend.py").write_text(
        "import matplotlib\nfrom matplotlib.backends.backend_agg import FigureCanvasAgg\n"
        "matplotlib.interactive(True)\nFigureCanvas = FigureCanvasAgg\n"
    )
    code = (
        "import matplotlib, matplotlib.pyplot, fascicle as fs\n"
        "fs.plot.force_strain(fs.example('kim2021_figure_6'))\nassert matplotlib.is_interactive()\n"
    )
    paths = [str(tmp_path), os.environ.get("PYTHONPATH", "")]
    environ = os.environ | {
        "MPLBACKEND": "module://notebook_backend", "PYTHONPATH": os.pathsep.join(paths)
    }  # fmt: skip
    subprocess.run([sys.executable, "-c", code], check=True, env=environ)


def test_curves_without_a_color_take_the_house_colors_in_order():
    _, axes = new_figure()
    curves = [axes[0, 0].plot([0, 1])[0].get_color() for _ in CYCLE]
    assert curves == [*CYCLE]
