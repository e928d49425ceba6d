"""The numbers of the chosen law have fields, with units, and what they say is the muscle's."""

import pytest

import fascicle as fs
from fascicle.explorer.muscle_inputs import MuscleInputs
from fascicle.explorer.state import Session, view_of
from fascicle.muscle import LAWS


@pytest.fixture
def page():
    """A muscle's inputs, and their session."""
    session = Session(view_of(fs.example("kim2021_figure_6"), "six"))
    inputs = MuscleInputs(session)
    session.watch(lambda _, after: inputs.show(after))
    inputs.show(session.view)
    return inputs, session


@pytest.mark.parametrize("kind", LAWS)
def test_each_law_has_a_field_for_each_of_its_numbers_and_choices(kind, page):
    inputs, session = page
    own = inputs.laws[kind]
    for name, law in LAWS[kind].items():
        own.select.value = name
        assert type(getattr(session.view.muscle, kind)) is law
        assert [*own.fields] == [one.name for one in law.constants()]
        assert [*own.choices] == [one.name for one in law.switches()]


def test_a_number_typed_is_the_muscles(page):
    inputs, session = page
    own = inputs.laws["tension"]
    own.select.value = "tondu_lopez"
    assert own.fields["decay_pressure"].input.value == "100 kPa"
    own.fields["decay_pressure"].input.value = "2 bar"
    own.fields["strain_factor"].input.value = "1.2"
    law = session.view.muscle.tension
    assert (law.decay_pressure, law.strain_factor) == (2e5, 1.2)
    assert own.fields["decay_pressure"].input.value == "200 kPa"
    session.change(shown=session.view.shown | {"pressure": "bar"})
    assert own.fields["decay_pressure"].input.value == "2 bar"


def test_a_choice_and_a_factor_are_the_muscles(page):
    inputs, session = page
    inputs.laws["tension"].select.value = "kothera2009"
    inputs.laws["tension"].choices["pressure_term"].value = "ideal"
    inputs.laws["collapse"].fields["factor"].input.value = "0.8"
    muscle = session.view.muscle
    assert muscle.tension == fs.tension.Kothera2009("ideal")
    assert muscle.collapse == fs.collapse.Kim2021Collapse(0.8)


def test_what_cannot_be_is_said_at_its_field(page):
    inputs, session = page
    own = inputs.laws["tension"]
    own.select.value = "tondu_lopez"
    before = session.view
    for text, said in (("-3", "must leave the factor positive"), ("3 kPa", "must be a number")):
        own.fields["strain_factor_rise"].input.value = text
        assert said in own.fields["strain_factor_rise"].error
    own.fields["decay_pressure"].input.value = "-1 kPa"
    assert "Decay pressure must be positive" in own.fields["decay_pressure"].error
    assert session.view is before
