"""The header, and the explorer in a notebook's cell."""

import asyncio
import io
from dataclasses import replace

import numpy as np
import panel as pn
import pytest
from bokeh.models import ColumnDataSource

import fascicle as fs
from fascicle.explorer import panel
from fascicle.explorer.page import Page
from fascicle.explorer.state import TABS, Pin, Session, view_of
from fascicle.files import dumps, loads
from fascicle.plot.theme import DARK, LIGHT
from refusing import refuses_at


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")


@pytest.fixture
def header():
    return Page(Session(SIX)).header


def test_an_example_replaces_an_own_muscle_and_undo_brings_it_back(header):
    session = header._session
    own = view_of(fs.example("kim2021_figure_9").replace(length=0.2), "mine.toml")
    session.open(own)
    assert header._example.value == "(own)"
    header._example.value = "kim2021_figure_6"
    assert session.view.name == "kim2021_figure_6"
    header.undo.clicks += 1
    assert session.view.muscle is own.muscle and header._example.value == "(own)"
    header.redo.clicks += 1
    assert session.view.name == "kim2021_figure_6"


@pytest.mark.parametrize(("theme", "colors"), [("", LIGHT), ("default", LIGHT), ("dark", DARK)])
def test_a_page_has_the_colors_of_its_theme(theme, colors):
    assert f"--paper: {colors.paper}" in Page(Session(SIX), theme).panel.stylesheets[-1]


def test_an_empty_file_is_refused(header):
    before = header._session.view
    header.file.param.update(value=None, filename="none.toml")  # Panel's event of one
    assert "none.toml" in header.message.text
    assert header._session.view is before


def test_a_file_is_not_saved_under_the_name_of_its_input(header):
    session, muscle = header._session, SIX.muscle
    for name in ("muscle.toml", "muscle_copy.toml", "my.muscle.toml", "odd name", "../muscle"):
        for suffix, kind in (("", "_copy.toml"), (", changed", "_changed.toml")):
            session.show(view_of(muscle, name + suffix))
            saved, raw = header._file()
            assert saved.endswith(kind) and saved != name and "/" not in saved
            assert dumps(loads(raw.decode()).motor_units[0].muscle) == dumps(muscle)


def shown(tab):
    """Page with a `tab` that has something to download."""
    view = replace(SIX, tab=tab, pins=(Pin("one", SIX.muscle, SIX.pressure),))
    page = Page(Session(view))
    if tab == "data":
        page.open_view.open_example()
    return page


@pytest.mark.parametrize("tab", TABS[:4])
def test_pictures_and_data_of_a_tab_are_downloaded(tab):
    page = shown(tab)
    formats = [("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")]
    suffix, start = formats[TABS.index(tab) % 3]
    name, raw = page.header._tab_file(suffix)
    assert name.endswith(suffix) and raw.startswith(start)
    name, raw = page.header._tab_file("csv")
    rows = np.genfromtxt(io.BytesIO(raw), delimiter=",", names=True, deletechars="", dtype=None)
    if tab == "muscle":
        force = SIX.muscle.force(SIX.pressure, rows["strain_[-]"])
        np.testing.assert_allclose(rows["force_[N]"], force, rtol=1e-9, atol=1e-9)
    assert rows.size > 10
    if tab in ("muscle", "bundle"):
        name, raw = page.header._web_page()
        assert name == "kim2021_figure_6_page.html" and b"</html>" in raw


@pytest.mark.parametrize("tab", TABS[2:])
def test_nothing_to_download_is_said_on_the_page(tab):
    page = Page(Session(replace(SIX, tab=tab)))
    buttons = page.panel.select(pn.widgets.FileDownload)
    (button,) = [button for button in buttons if "PNG" in button.label]
    with pytest.raises(asyncio.CancelledError):
        button.callback()
    assert page.header.message.text


def test_sliders_of_a_cell_move_the_curve():
    layout = panel("kim2021_figure_6")
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


def test_a_cell_of_a_muscle_of_a_bundle_and_of_an_unknown_name():
    for name in ("kim2021_figure_6", "kim2021_bundle_1_1"):
        assert panel(fs.example(name), theme="dark").select(pn.Tabs)
    with refuses_at("kim2021_figure_66: "):
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
