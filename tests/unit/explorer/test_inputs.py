"""Sliders and fields: values in the unit shown, and errors by the page's labels."""

import pytest

import fascicle as fs
from fascicle.explorer.bundle_tab import UnitRows
from fascicle.explorer.muscle_tab import MuscleInputs
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.widgets import SIZES, QuantitySlider
from fascicle.muscle import LAWS
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


def test_a_rule_between_two_sizes_has_the_labels_of_both(page):
    inputs, _ = page
    inputs.fields["wall_thickness"].input.value = "20 mm"
    text = inputs.fields["wall_thickness"].message.text
    assert all(SIZES[name][0] in text for name in ("wall_thickness", "outer_radius"))


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
    assert all(message.text.count(x) for x in ("Pressure P", "[0, 413.7] kPa", "414 kPa"))
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
    for name, text in (("strain_factor_rise", "-3"), ("decay_pressure", "-1 kPa")):
        tension.fields[name].input.value = text
        assert tension.fields[name].message.text
    assert session.view is before


@pytest.mark.parametrize("count", ["100", "0", "2.5", "", "nan"])
def test_impossible_counts_are_refused(count, rows):
    rows, session = rows
    number, _ = rows.rows[0]
    number.input.value = count
    assert number.message.text and len(number.input.stylesheets) == 2  # with a red border
    assert session.view is BUNDLE
    number.input.value = "2"
    assert session.view.units[0].count == 2 and not number.message.text
    assert len(number.input.stylesheets) == 1
