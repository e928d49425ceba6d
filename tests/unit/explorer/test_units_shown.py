"""What is refused is told in the units shown, and by names that stand on the page."""

import pytest
from bokeh.core.properties import value

import fascicle as fs
from fascicle.explorer.bundle_tab import BundleView, UnitRows
from fascicle.explorer.muscle_inputs import MuscleInputs
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.theme import DARK, LIGHT, Chart
from fascicle.explorer.widgets import message_in_units


BUNDLE = view_of(fs.example("kim2021_bundle_1_4"), "kim2021_bundle_1_4")
SHOWN = {"pressure": "psi", "length": "in", "force": "N"}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("`a` must be less than `b`, got 0.0508 m and 0.0254 m.",
         "`a` must be less than `b`, got 2 in and 1 in."),
        ("must lie in (0, 1.27] m, got 127 mm.", "must lie in (0, 50] in, got 5 in."),
        ("must lie in [0, 6.89476e+06] Pa (gauge), got -1e-400 Pa.",
         "must lie in [0, 1000] psi (gauge), got -0 psi."),
        ("3 m² of cross section, 2 m/s, 5 N*m, 4 N, 300 MPa",
         "3 m² of cross section, 2 m/s, 5 N*m, 4 N, 300 MPa"),
        ("no number: `127`, v2 mm", "no number: `127`, v2 mm"),
    ],
)  # fmt: skip
def test_amounts_are_told_in_the_units_shown(text, told):
    assert message_in_units(text, SHOWN) == told


@pytest.mark.parametrize(("unit", "got"), [("mm", "8 mm and 6.35 mm"), ("in", "0.314961 in and")])
def test_a_field_refuses_in_its_unit(unit, got):
    inputs = MuscleInputs(session := Session(BUNDLE))
    session.change(shown={**BUNDLE.shown, "length": unit})
    inputs.show(session.view)
    field = inputs.fields["wall_thickness"]
    field.input.value = "8 mm"
    assert got in field.error


@pytest.mark.parametrize(
    ("count", "told"),
    [(100, "got 104 in all"), (0, "got 0."), (-3, "got -3."), (None, "must be a whole number")],
)
def test_counts_that_cannot_be_are_refused_with_the_rule(count, told):
    session = Session(BUNDLE)
    rows = UnitRows(session)
    rows.show(session.view)
    session.watch(lambda _, after: rows.show(after))
    number = rows.rows[0][0]
    assert number.start is None and number.end is None  # with which the browser refuses silently
    number.value = count
    assert told in rows.message.text
    if count is not None:
        assert "1 or more in each motor unit and 60 in all" in rows.message.text
    assert session.view is BUNDLE
    number.value = 2
    assert session.view.units[0].count == 2 and not rows.message.text


def test_a_radius_out_of_reach_is_refused_by_its_own_name():
    session = Session(BUNDLE)
    rows = UnitRows(session)
    rows.show(session.view)
    radius = rows.rows[1][1]
    radius.input.value = "100"
    assert "Radius must be 0.635 mm to 63.5 mm" in radius.error
    assert "got 100 mm" in radius.error


def test_every_point_of_the_bundles_picture_is_in_its_legend():
    tab = BundleView(Session(BUNDLE), DARK)
    tab.refresh()
    items = tab.chart.figure.legend[0].items
    told = {
        one.label.value: one
        for one in items
        if one.label == value(getattr(one.label, "value", None))
    }
    for name in ("at rest (hollow: not stable)", "this contraction"):
        assert told[name].visible
    asked = told["the chosen point"]
    assert not asked.visible
    tab.try_point()
    assert asked.visible


def test_the_typeface_of_tags_is_no_column():
    chart = Chart(LIGHT, "x", "y", room=300)
    chart.tags(chart.source("x", "y", "label"))
    assert chart.figure.center[-1].text_font == value("DejaVu Sans")
