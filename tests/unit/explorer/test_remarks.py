"""Warnings and notes beside the pictures."""

import math
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.explorer.muscle_tab import MuscleView
from fascicle.explorer.remarks import (
    branches_text,
    equilibria_text,
    notes,
    tuning_note,
    validity_warnings,
)
from fascicle.explorer.state import TABS, Session, Unit, view_of
from fascicle.muscle.fitted_length import FittedLength
from fascicle.plot.theme import LIGHT


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
TUNED = view_of(fs.example("kim2021_slenderness_10"), "kim2021_slenderness_10")
OTHER = fs.Muscle.from_dimensions(0.127, 9e-3, 2.25e-3, math.radians(28))
PICTURES = TABS[:2]


@pytest.mark.parametrize("tab", TABS)
def test_a_complete_picture_has_no_remarks(tab):
    assert notes(SIX, tab) == []
    assert validity_warnings(SIX, tab) == validity_warnings(TUNED, tab) == []


def test_a_radius_out_of_proportion_gives_a_warning_in_the_units_shown():
    with pytest.warns(UserWarning, match="unusual"):  # of the radius, and of the proportions
        wide = SIX.muscle.replace(outer_radius=1.0, wall_thickness=0.05)
    for tab in PICTURES:
        (warning,) = validity_warnings(replace(SIX, muscle=wide), tab)
        assert "127 mm" in warning and "1000 mm" in warning


def test_muscles_that_the_plates_stretch_give_a_warning():
    units = (Unit(1), Unit(1, own=SIX.muscle.replace(length=0.12)))
    for distance, number in ((0.127, 1), (0.1201, 0)):
        view = replace(SIX, units=units, pressures=(1e5, 1e5), distance=distance)
        assert len(validity_warnings(view, "bundle")) == number
        assert validity_warnings(view, "muscle") == []


def test_a_fit_at_another_length_gives_one_warning():
    fitted = TUNED.muscle.replace(fitted_length=FittedLength(0.127))
    assert validity_warnings(replace(TUNED, muscle=fitted), "muscle") == []
    with pytest.warns(UserWarning, match="fitted at"):
        longer = fitted.replace(length=0.2)
    for tab in PICTURES:
        # thinner muscles of a bundle are of the same fit
        view = replace(TUNED, muscle=longer, units=(Unit(1), Unit(2, 0.5)))
        (warning,) = validity_warnings(view, tab)
        assert warning.startswith(
            "The muscle was fitted at a length of 127 mm and its length is now 200 mm"
        )
    view = replace(SIX, units=(Unit(1), Unit(2, own=longer)))
    assert validity_warnings(view, "muscle") == [] and len(validity_warnings(view, "bundle")) == 1


def test_constants_of_another_muscle_give_a_warning():
    festo = replace(SIX, muscle=SIX.muscle.replace(tension="sarosi"))
    for tab in PICTURES:
        (warning,) = validity_warnings(festo, tab)
        assert warning.startswith("`sarosi` was fitted to a Festo DMSP-20-200N")


def test_pressures_above_those_measured_give_a_warning():
    tuning = fs.Tuning(pressures=[1e5, 3e5], c1=[0.0, 1.0], c2=[1.0, 1.1])
    view = replace(SIX, muscle=SIX.muscle.replace(tuning=tuning), supply=3e5)
    assert validity_warnings(view, "bundle") == []
    (warning,) = validity_warnings(replace(view, supply=4e5), "bundle")
    assert warning.startswith("The tuning was measured up to 300 kPa and is held constant above it")


def test_a_note_on_several_muscles_of_a_bundle():
    unequal = replace(SIX, units=(Unit(1), Unit(2, own=OTHER)))
    assert "muscle of unit 1" in notes(unequal, "muscle")[0]
    assert notes(unequal, "bundle") == []
    thinner = replace(SIX, units=(Unit(1), Unit(2, 0.5)))
    assert notes(thinner, "muscle") == []


def test_a_note_on_a_tuning_for_another_size():
    assert notes(TUNED, "muscle") == notes(TUNED, "bundle") == []
    thinner = replace(TUNED, units=(Unit(1), Unit(2, 0.5)))
    assert "measured on a muscle of another size" in notes(thinner, "bundle")[0]
    changed = replace(TUNED, name="kim2021_slenderness_10, changed")
    assert "another size" in notes(changed, "muscle")[0]


def test_a_tuning_note_has_the_units_shown():
    assert tuning_note(SIX.muscle, "kPa") == ""
    note = tuning_note(fs.example("kim2021_bundle_1_4").motor_units[0].muscle, "kPa")
    for change in ("Young's modulus × 0.95", "collapse moment × 0.75", "transition rate β = 100",
                   "hinge stiffness × (0.83 + 0.0092 per kPa)"):  # fmt: skip
        assert change in note
    assert "C₁" not in note and "dead band" not in note
    rows = fs.Tuning(pressures=[1e5, 3e5], c1=[0.0, 1.0], c2=[1.0, 1.1], dead_band=2e4)
    note = tuning_note(SIX.muscle.replace(tuning=rows), "bar")
    assert "C₁ and C₂ in 3 rows up to 3 bar, dead band 0.2 bar." in note
    assert "modulus" not in note and "β" not in note


def test_a_transition_rate_that_was_not_fitted_is_not_in_the_note():
    """A fit writes the muscle's own rate into its tuning."""
    rate = float(SIX.muscle.transition_rate)

    def note(**tuning):
        return tuning_note(SIX.muscle.replace(tuning=fs.Tuning(**tuning)), "kPa")

    both = note(collapse_moment_factor=0.8, transition_rate=rate)
    assert "β" not in both and "0.8" in both
    assert note(transition_rate=rate) == ""
    assert f"β = {2 * rate:g}" in note(transition_rate=2 * rate)


@pytest.mark.parametrize(("name", "tuned"), [("kim2021_figure_6", 0), ("kim2021_bundle_1_4", 1)])
def test_a_tuning_note_is_above_the_muscle(name, tuned):
    tab = MuscleView(Session(view_of(fs.example(name), name)), LIGHT)
    tab.refresh()
    assert ("This muscle is tuned: " in tab.notes.object) == tuned


def test_all_equilibria_are_listed():
    strain, stable = np.array([0.186, 0.195, 0.230]), np.array([True, False, True])
    text = "0.1860; it also rests at 0.1950 (unstable), 0.2300"
    assert equilibria_text(strain, stable) == text
    assert equilibria_text(strain[:1], stable[:1]) == "0.1860"
    assert "none" in equilibria_text(strain[:0], stable[:0])


def test_strains_of_other_branches_are_listed():
    strain, several = np.linspace(0, 0.4, 5), np.array([False, False, True, True, False])
    assert branches_text(strain, np.zeros(5, bool)) == ""
    assert branches_text(strain, several).startswith("ε 0.200 to 0.300; the curve shows the branch")
