"""Sliders and fields: values in the unit shown, and errors by the page's labels."""

from dataclasses import replace

import pytest
from bokeh.core.properties import value

import fascicle as fs
from fascicle.explorer.bundle_tab import BundleView, UnitRows
from fascicle.explorer.chart import Chart
from fascicle.explorer.muscle_inputs import MuscleInputs
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.widgets import QuantitySlider, message_in_units, page_message
from fascicle.muscle import LAWS
from fascicle.plot.theme import DARK, LIGHT
from fascicle.units import parse


BUNDLE = view_of(fs.example("kim2021_bundle_1_4"), "kim2021_bundle_1_4")
SUPPLY = 413.7e3


def connect(kind, session):
    """Inputs of a `kind` that follow the views of a `session`, and the session."""
    inputs = kind(session)
    session.watch(lambda _, after: inputs.show(after))
    inputs.show(session.view)
    return inputs, session


@pytest.fixture
def page():
    """Inputs of a muscle, and their session."""
    return connect(MuscleInputs, Session(view_of(fs.example("kim2021_figure_6"), "six")))


@pytest.fixture
def rows():
    """Rows of a bundle's units, and their session."""
    return connect(UnitRows, Session(BUNDLE))


@pytest.fixture
def dial():
    """A slider of pressure, and the values that it gave."""
    values = []
    dial = QuantitySlider("Pressure P", "pressure", "pressure", values.append)
    return dial, values


def test_a_value_that_is_restored_is_no_change(page):
    inputs, session = page
    session.open(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"))
    length = inputs.fields["length"].input
    before = length.value
    length.value = "150 mm"
    assert session.view.name == "kim2021_figure_6, changed"
    length.value = before
    assert session.view.name == "kim2021_figure_6"
    # after a link to a changed example, too
    session.open(view_of(session.view.muscle.replace(length=0.2), "kim2021_figure_6, changed"))
    length.value = before
    assert session.view.name == "kim2021_figure_6"


@pytest.mark.parametrize("unit", ["kPa", "psi", "bar"])
def test_a_slider_ends_at_the_supply(unit, dial):
    dial, values = dial
    dial.show(1e5, unit, SUPPLY)
    dial.slider.value = dial.slider.end
    assert values == [SUPPLY]
    dial.field.input.value = f"{dial.slider.end:.6g}"  # with the digits of the limits in messages
    assert values[1:] == [pytest.approx(SUPPLY, rel=1e-6)] and max(values) == SUPPLY
    assert not dial.field.message.text


def test_a_slider_gives_its_own_decimals(dial):
    dial, values = dial
    dial.show(1e5, "psi", SUPPLY)
    dial.slider.value = 0.1 * 202
    assert values == [parse("20.2 psi", "pressure")]


def test_a_message_has_the_limits_of_a_slider(dial):
    dial, _ = dial
    dial.show(1e5, "kPa", SUPPLY)
    dial.field.input.value = "414"
    message = dial.field.message
    assert "Pressure P must lie in [0, 413.7] kPa, got 414 kPa." in message.text
    dial.field.input.value = "100 kPa"  # the value shown before
    assert not message.text


@pytest.mark.parametrize("kind", LAWS)
def test_each_law_has_a_field_for_each_of_its_constants_and_options(kind, page):
    inputs, session = page
    law_inputs = inputs.laws[kind]
    for name, law in LAWS[kind].items():
        law_inputs.select.value = name
        assert type(getattr(session.view.muscle, kind)) is law
        assert [*law_inputs.fields] == [constant.name for constant in law.constants()]
        assert [*law_inputs.choices] == [switch.name for switch in law.switches()]


def test_constants_and_options_change_the_muscle(page):
    inputs, session = page
    tension = inputs.laws["tension"]
    tension.select.value = "tondu_lopez"
    assert tension.fields["decay_pressure"].input.value == "100 kPa"
    tension.fields["decay_pressure"].input.value = "2 bar"
    tension.fields["strain_factor"].input.value = "1.2"
    law = session.view.muscle.tension
    assert (law.decay_pressure, law.strain_factor) == (2e5, 1.2)
    assert tension.fields["decay_pressure"].input.value == "200 kPa"
    session.change(display_units={**session.view.display_units, "pressure": "bar"})
    assert tension.fields["decay_pressure"].input.value == "2 bar"
    tension.select.value = "kothera2009"
    tension.choices["pressure_term"].value = "ideal"
    inputs.laws["collapse"].fields["factor"].input.value = "0.8"
    assert session.view.muscle.tension == fs.tension.Kothera2009("ideal")
    assert session.view.muscle.collapse == fs.collapse.Kim2021Collapse(0.8)


def test_an_impossible_constant_is_refused_at_its_field(page):
    inputs, session = page
    tension = inputs.laws["tension"]
    tension.select.value = "tondu_lopez"
    before = session.view
    for name, text, expected in (
        ("strain_factor_rise", "-3", "must leave the factor positive"),
        ("strain_factor_rise", "3 kPa", "must be a number"),
        ("decay_pressure", "-1 kPa", "Decay pressure must be positive"),
    ):
        tension.fields[name].input.value = text
        assert expected in tension.fields[name].message.text
    assert session.view is before


@pytest.mark.parametrize(
    ("text", "expected"),
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
def test_amounts_in_messages_have_the_units_shown(text, expected):
    units = {"pressure": "psi", "length": "in", "force": "N"}
    assert message_in_units(text, units) == expected


def test_an_argument_without_a_label_is_written_as_words():
    error = fs.InvalidInputError("decay_pressure", "must be positive", -1.0)
    assert page_message(error) == "Decay pressure must be positive, got -1.0."


@pytest.mark.parametrize(("unit", "text"), [("mm", "8 mm and 6.35 mm"), ("in", "0.314961 in and")])
def test_a_field_shows_its_error_in_its_unit(unit, text, page):
    inputs, session = page
    session.change(display_units={**session.view.display_units, "length": unit})
    field = inputs.fields["wall_thickness"]
    field.input.value = "8 mm"
    assert text in field.message.text
    inputs.fields["outer_radius"].input.value = "1 mm"
    assert inputs.fields["outer_radius"].message.text  # a rule between two is shown at both
    assert "1.6 mm" in field.message.text or "0.0629921 in" in field.message.text


@pytest.mark.parametrize(
    ("count", "expected"),
    [(100, "got 104 in all"), (0, "got 0."), (-3, "got -3."), (None, "must be a whole number")],
)
def test_impossible_counts_are_refused_with_the_rule(count, expected, rows):
    rows, session = rows
    number = rows.rows[0].count
    assert number.start is None and number.end is None  # with which the browser refuses silently
    number.value = count
    assert expected in rows.message.text
    if count is not None:
        assert "1 or more in each motor unit and 60 in all" in rows.message.text
    assert session.view is BUNDLE
    number.value = 2
    assert session.view.units[0].count == 2 and not rows.message.text


def test_a_radius_out_of_reach_is_refused_by_its_own_name(rows):
    radius = rows[0].rows[1].radius
    radius.input.value = "100"
    assert "Radius must be 0.635 mm to 63.5 mm" in radius.message.text
    assert "got 100 mm" in radius.message.text


def test_every_point_of_the_bundles_picture_is_in_its_legend():
    tab = BundleView(Session(replace(BUNDLE, tab="bundle")), DARK)
    tab.refresh()
    items = tab.chart.figure.legend[0].items
    entries = {getattr(item.label, "value", None): item for item in items}
    for name in ("equilibria (hollow: unstable)", "this contraction"):
        assert entries[name].visible
    target = entries["the chosen point"]
    assert not target.visible
    tab.try_point()
    assert target.visible


def test_the_typeface_of_labels_is_no_column():
    chart = Chart(LIGHT, "x", "y", "300px")
    chart.add_labels(chart.new_source("x y label"))
    assert chart.figure.center[-1].text_font == value("DejaVu Sans")
