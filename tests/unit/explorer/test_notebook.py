"""In a notebook's cell: the same tabs, and a slider that moves the same curve."""

import numpy as np
import panel as pn
import pytest
from bokeh.models import ColumnDataSource

import fascicle as fs
from fascicle.explorer import panel


@pytest.mark.parametrize(
    "target", ["kim2021_figure_6", fs.example("kim2021_figure_6")], ids=["by name", "a muscle"]
)
def test_a_cell_shows_tabs_whose_sliders_move_the_curve(target):
    layout = panel(target)
    (tabs,) = layout.select(pn.Tabs)
    assert len(tabs) == 5
    pressure = next(
        one for one in layout.select(pn.widgets.FloatSlider) if one.label.startswith("Pressure P [")
    )
    (curve,) = (
        source
        for pane in layout.select(pn.pane.Bokeh)
        for source in pane.object.select({"type": ColumnDataSource, "name": "chosen"})
    )
    pressure.value = 200.0  # kPa
    expected = fs.example("kim2021_figure_6").force(200e3, curve.data["strain"])
    np.testing.assert_allclose(curve.data["force"], expected, rtol=1e-9, atol=1e-9)


def test_a_bundle_and_an_unknown_name():
    assert panel(fs.example("kim2021_bundle_1_1"), theme="dark").select(pn.Tabs)
    with pytest.raises(OSError, match="kim2021_figure_66"):
        panel("kim2021_figure_66")
