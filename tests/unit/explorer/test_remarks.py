"""Warnings and notes beside the pictures."""

import math
from dataclasses import replace

import pytest

import fascicle as fs
from fascicle.explorer.remarks import remarks_html, validity_warnings
from fascicle.explorer.state import TABS, Unit, view_of
from fascicle.muscle.validation import FittedLength
from refusing import warns


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
TUNED = view_of(fs.example("kim2021_slenderness_10"), "kim2021_slenderness_10")
OTHER = fs.Muscle(0.127, 9e-3, 2.25e-3, math.radians(28))
PICTURES = TABS[:2]


@pytest.mark.parametrize("tab", TABS)
def test_a_complete_picture_has_no_remarks(tab):
    assert remarks_html(SIX, tab) == ""
    assert validity_warnings(SIX, tab) == validity_warnings(TUNED, tab) == []


def test_a_radius_out_of_proportion_gives_a_warning():
    with warns("outer_radius"):  # of the radius, and of the proportions
        wide = SIX.muscle.replace(outer_radius=1.0, wall_thickness=0.05)
    for tab in PICTURES:
        assert len(validity_warnings(replace(SIX, muscle=wide), tab)) == 1


def test_muscles_that_the_plates_stretch_give_a_warning():
    units = (Unit(1), Unit(1, own=SIX.muscle.replace(length=0.12)))
    for distance, number in ((0.127, 1), (0.1201, 0)):
        view = replace(SIX, units=units, pressures=(1e5, 1e5), distance=distance)
        assert len(validity_warnings(view, "bundle")) == number
        assert validity_warnings(view, "muscle") == []


def test_a_fit_at_another_length_gives_one_warning():
    fitted = TUNED.muscle.replace(fitted_length=FittedLength(0.127))
    assert validity_warnings(replace(TUNED, muscle=fitted), "muscle") == []
    with warns("127 mm"):
        longer = fitted.replace(length=0.2)
    for tab in PICTURES:
        view = replace(TUNED, muscle=longer, units=(Unit(1), Unit(2)))
        (warning,) = validity_warnings(view, tab)
        assert "127 mm" in warning and "200 mm" in warning
    view = replace(SIX, units=(Unit(1), Unit(2, own=longer)))
    assert validity_warnings(view, "muscle") == [] and len(validity_warnings(view, "bundle")) == 1


def test_constants_of_another_muscle_give_a_warning():
    festo = replace(SIX, muscle=SIX.muscle.replace(tension="sarosi"))
    for tab in PICTURES:
        assert len(validity_warnings(festo, tab)) == 1


def test_pressures_above_those_measured_give_a_warning():
    tuning = fs.Tuning(pressures=[1e5, 3e5], c1=[0.0, 1.0], c2=[1.0, 1.1])
    view = replace(SIX, muscle=SIX.muscle.replace(tuning=tuning), supply=3e5)
    assert validity_warnings(view, "bundle") == []
    assert len(validity_warnings(replace(view, supply=4e5), "bundle")) == 1


def test_notes_on_several_muscles_and_on_a_tuning_for_another_size():
    unequal = replace(SIX, units=(Unit(1), Unit(2, own=OTHER)))
    longer = replace(TUNED, muscle=TUNED.muscle.replace(length=0.2))
    other_law = replace(TUNED, muscle=TUNED.muscle.replace(buckling="elastica"))
    opened = TUNED.muscle
    noted = [(unequal, "muscle"), (longer, "muscle", opened)]
    plain = [(unequal, "bundle"), (TUNED, "bundle")]
    plain += [(other_law, "muscle", opened), (longer, "bundle", opened)]
    assert all('role="status"' in remarks_html(*case) for case in noted)
    assert not any('role="status"' in remarks_html(*case) for case in plain)
