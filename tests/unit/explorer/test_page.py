"""The header, and the explorer in a notebook's cell."""

from collections import Counter

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


def test_a_message_on_a_link_goes_with_the_next_change(header):
    header.message.show("link: `strain` can't be read.")
    header._session.change(tab="bundle")
    header._session.change(display_units={"pressure": "kPa", "length": "mm", "force": "lbf"})
    assert header.message.text
    header._session.change(strain=0.2)
    assert not header.message.text


@pytest.mark.parametrize("answer", ["_replace", "_keep"])
def test_an_example_does_not_replace_an_own_muscle_without_asking(header, answer):
    session = header._session
    header._example.value = "kim2021_figure_9"
    assert session.view.name == "kim2021_figure_9" and not header.question.visible
    own = view_of(fs.example("kim2021_figure_9").replace(length=0.2), "mine.toml")
    session.open(own)
    header._example.value = "kim2021_figure_6"
    assert session.view is own and header.question.visible
    assert "kim2021_figure_6 would replace mine.toml" in header._question.object
    getattr(header, answer)()
    assert not header.question.visible
    assert (session.view is own) == (answer == "_keep")
    assert header._example.value == ("(own)" if answer == "_keep" else "kim2021_figure_6")


def test_a_measured_muscle_opens_as_it_was_fitted(header):
    for name in fs.catalog:
        header._example.value = name
        assert header._session.view.name == name
        assert header._session.view.muscle == fs.catalog[name].muscle


def test_buttons_of_the_history_are_enabled_while_there_is_one(header):
    assert header.undo.disabled and header.reset.disabled
    header._session.change(strain=0.2)
    assert not header.undo.disabled and not header.reset.disabled
    header._session.undo()
    assert header.undo.disabled and header.reset.disabled


def page_of(theme):
    """Page in a `theme` with a bundle, all of whose tabs were open, and its session."""
    session = Session(view_of(fs.example("kim2021_bundle_1_4"), "kim2021_bundle_1_4"))
    session.change(load=20.0)
    page = Page(session, theme)
    for tab in TABS:
        session.change(tab=tab)
        if tab == "compare":
            page._views[tab].pin_example()
        elif tab == "data":
            page._views[tab].open_example()
    return page, session


def colors_of(page):
    """Numbers of all colors of the figures of the tabs that were open."""
    colors = Counter()
    for name, tab in page._views.items():
        tab.refresh()
        for pane in tab.panel.select(pn.pane.Bokeh):
            for model in pane.object.references():
                names = [name for name in model.properties() if name.endswith("_color")]
                values = {name: getattr(model, name) for name in names}
                values |= model.data if isinstance(model, ColumnDataSource) else {}
                for key, value in values.items():
                    texts = value if isinstance(value, list) else [value]
                    colors.update(
                        (name, type(model).__name__, key, text)
                        for text in texts
                        if isinstance(text, str) and text.startswith("#")
                    )
    return colors


def test_another_theme_changes_all_colors_and_keeps_the_history():
    page, session = page_of("default")
    dark_page, _ = page_of("dark")
    light, past = colors_of(page), session._past
    assert light != colors_of(dark_page)
    record = page._views["data"].record
    for theme, expected in (("dark", colors_of(dark_page)), ("light", light)):
        page.header.theme_switch.clicks += 1
        assert colors_of(page) == expected
        assert (
            f"Use {'light' if theme == 'dark' else 'dark'} page" == page.header.theme_switch.label
        )
        paper = DARK.paper if theme == "dark" else LIGHT.paper
        assert f"--paper: {paper}" in page.panel.stylesheets[-1]
    assert session._past is past and session.can_undo
    assert page._views["data"].record is record is not None


def test_an_empty_file_is_refused(header):
    before = header._session.view
    header.file.param.update(value=None, filename="none.toml")  # Panel's event of one
    assert "none.toml: the file is empty, 0 bytes." in header.message.text
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
