"""The header, and the explorer in a notebook's cell."""

import numpy as np
import panel as pn
import pytest
from bokeh.models import ColumnDataSource

import fascicle as fs
from fascicle.explorer import panel
from fascicle.explorer.page import Header, Page
from fascicle.explorer.state import TABS, Session, view_of
from fascicle.plot.theme import DARK, LIGHT


@pytest.fixture
def header():
    session = Session(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"))
    return Header(session, "default", False, print, print)


@pytest.mark.parametrize("answer", ["_replace", "_keep"])
def test_an_example_does_not_replace_an_own_muscle_without_asking(header, answer):
    session = header._session
    header._example.value = "kim2021_figure_9"
    assert session.view.name == "kim2021_figure_9" and not header.question.visible
    own = view_of(fs.example("kim2021_figure_9").replace(length=0.2), "mine.toml")
    session.open(own)
    header._example.value = "kim2021_figure_6"
    assert session.view is own and header.question.visible
    getattr(header, answer)()
    assert not header.question.visible
    assert (session.view is own) == (answer == "_keep")
    assert header._example.value == ("(own)" if answer == "_keep" else "kim2021_figure_6")


def test_another_theme_keeps_the_history_and_the_record():
    session = Session(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"))
    page = Page(session)
    session.change(tab="data", strain=0.2)
    page._views["data"].open_example()
    record, past = page._views["data"].record, session._past
    for paper in (DARK.paper, LIGHT.paper):
        page.header.theme_switch.clicks += 1
        assert f"--paper: {paper}" in page.panel.stylesheets[-1]
    assert session._past is past and session.can_undo
    assert page._views["data"].record is record is not None


def test_an_empty_file_is_refused(header):
    before = header._session.view
    header.file.param.update(value=None, filename="none.toml")  # Panel's event of one
    assert "none.toml" in header.message.text
    assert header._session.view is before


def test_a_file_is_not_saved_under_the_name_of_its_input(header):
    assert header.save.filename == "kim2021_figure_6.toml"
    muscle = header._session.view.muscle
    for name in ("muscle.toml", "muscle_copy.toml", "my.muscle.toml", "odd name"):
        header._session.show(view_of(muscle, name))
        assert header.save.filename.endswith("_copy.toml") and header.save.filename != name
        header._session.show(view_of(muscle, f"{name}, changed"))
        assert header.save.filename.endswith("_changed.toml") and header.save.filename != name
    header._session.show(view_of(muscle, "../muscle.toml"))
    assert header.save.filename == "muscle_copy.toml"


@pytest.mark.parametrize(
    "target", ["kim2021_figure_6", fs.example("kim2021_figure_6")], ids=["by name", "a muscle"]
)
def test_sliders_of_a_cell_move_the_curve(target):
    layout = panel(target)
    (tabs,) = layout.select(pn.Tabs)
    assert len(tabs) == len(TABS)
    sliders = layout.select(pn.widgets.FloatSlider)
    pressure = next(slider for slider in sliders if slider.label.startswith("Pressure P ["))
    (curve,) = (
        source
        for pane in layout.select(pn.pane.Bokeh)
        for source in pane.object.select({"type": ColumnDataSource, "name": "curve"})
    )
    pressure.value = 200.0  # kPa
    expected = fs.example("kim2021_figure_6").force(200e3, curve.data["strain"])
    np.testing.assert_allclose(curve.data["force"], expected, rtol=1e-9, atol=1e-9)


def test_a_cell_of_a_bundle_and_of_an_unknown_name():
    assert panel(fs.example("kim2021_bundle_1_1"), theme="dark").select(pn.Tabs)
    with pytest.raises(OSError, match="kim2021_figure_66"):
        panel("kim2021_figure_66")


def test_a_record_that_is_opened_in_the_header_goes_to_the_tab_data():
    session = Session(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"))
    page = Page(session)
    rows = b"".join(b"100,%g,%g\n" % (i / 50, 10 - i) for i in range(8))
    raw = b"pressure [kPa],strain [-],force [N]\n" + rows
    page.header.file.param.update(value=raw, filename="mine.CSV")
    data = page._views["data"]
    assert session.view.tab == "data" and len(data.record) == 8
    assert data.file_name == "mine.CSV" and not page.header.message.text
    page.header.file.param.update(value=b"no record", filename="bad.csv")
    assert data.record is None and data.message.text and not page.header.message.text
    page.header.file.param.update(value=raw, filename="again.csv")
    assert len(data.record) == 8 and not data.message.text
