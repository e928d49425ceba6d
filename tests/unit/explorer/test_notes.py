"""What no picture tells by itself is said beside it."""

import math
from dataclasses import replace

import numpy as np
import pytest

import fascicle as fs
from fascicle.bundle.reversal import Reversal
from fascicle.explorer.link import from_query
from fascicle.explorer.muscle_curves import (
    MOST_COMPARED,
    muscle_curves,
    region_strips,
    strain_limit,
)
from fascicle.explorer.muscle_tab import MuscleView
from fascicle.explorer.reversal_tab import POINTS, SplitCurve
from fascicle.explorer.state import TABS, Session, Unit, view_of
from fascicle.explorer.tab import (
    branches_text,
    equilibria_text,
    notes,
    tuning_note,
    validity_warnings,
)
from fascicle.explorer.theme import LIGHT
from fascicle.muscle.fitted_length import with_fitted_length


SIX = view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6")
TUNED = view_of(fs.example("kim2021_slenderness_10"), "kim2021_slenderness_10")
OTHER = fs.Muscle.from_dimensions(0.127, 9e-3, 2.25e-3, math.radians(28))


@pytest.mark.parametrize("tab", TABS)
def test_where_the_picture_is_all_there_is_nothing_is_said(tab):
    assert notes(SIX, tab) == []
    assert validity_warnings(SIX, tab) == validity_warnings(TUNED, tab) == []


def test_a_radius_out_of_proportion_is_doubted_in_the_units_shown():
    with pytest.warns(UserWarning, match="unusual"):  # of the radius, and of the proportions
        wide = SIX.muscle.replace(outer_radius=1.0, wall_thickness=0.05)
    for tab in ("muscle", "bundle", "reversal", "efficiency"):
        (told,) = validity_warnings(replace(SIX, muscle=wide), tab)
        assert "127 mm" in told and "1000 mm" in told


def test_muscles_that_plates_stretch_are_doubted():
    short = SIX.muscle.replace(length=0.12)
    units = (Unit(1), Unit(1, own=short))
    for distance, number in ((0.127, 1), (0.1201, 0)):
        view = replace(SIX, units=units, pressures=(1e5, 1e5), distance=distance)
        assert len(validity_warnings(view, "bundle")) == number
        assert validity_warnings(view, "muscle") == []


def test_a_fit_at_another_length_is_doubted():
    fitted = with_fitted_length(fs.example("kim2021_slenderness_10"), 0.127, ends=False)
    assert validity_warnings(replace(TUNED, muscle=fitted), "muscle") == []
    with pytest.warns(UserWarning, match="fitted at"):
        longer = fitted.replace(length=0.2)
    for tab in ("muscle", "bundle", "reversal", "efficiency"):
        # thinner muscles of a bundle are of the same fit: it is said once
        view = replace(TUNED, muscle=longer, units=(Unit(1), Unit(2, 0.5)))
        (told,) = validity_warnings(view, tab)
        assert told.startswith(
            "The muscle was fitted at a length of 127 mm and its length is now 200 mm"
        )
    # a unit of its own is looked at where it is drawn
    view = replace(SIX, units=(Unit(1), Unit(2, own=longer)))
    assert validity_warnings(view, "muscle") == [] and len(validity_warnings(view, "bundle")) == 1


def test_constants_of_another_muscle_are_doubted_also_where_they_are_only_compared():
    festo = replace(SIX, muscle=SIX.muscle.replace(tension="sarosi"))
    for tab in ("muscle", "bundle", "reversal", "efficiency"):
        (told,) = validity_warnings(festo, tab)
        assert told.startswith("`sarosi` was fitted to a Festo DMSP-20-200N")
    compared = replace(SIX, compared=("tension:sarosi", "tension:ideal", "buckling:elastica"))
    assert validity_warnings(compared, "muscle") == [told]
    assert validity_warnings(compared, "bundle") == []


def test_pressures_above_those_measured_are_doubted():
    tuning = fs.Tuning(pressures=[1e5, 3e5], c1=[0.0, 1.0], c2=[1.0, 1.1])
    view = replace(SIX, muscle=SIX.muscle.replace(tuning=tuning), supply=3e5)
    assert validity_warnings(view, "bundle") == []
    (told,) = validity_warnings(replace(view, supply=4e5), "bundle")
    assert told.startswith("The tuning was measured up to 300 kPa and is held constant above it")


def test_another_muscle_than_the_bundles_is_named():
    unlike = replace(SIX, units=(Unit(1), Unit(2, own=OTHER)))
    assert "muscle of unit 1" in notes(unlike, "muscle")[0]
    assert "unit 1's muscle" in notes(unlike, "reversal")[0]
    assert "unit 1's muscle" in notes(unlike, "efficiency")[0]
    assert notes(unlike, "bundle") == []
    thinner = replace(SIX, units=(Unit(1), Unit(2, 0.5)))
    assert notes(thinner, "muscle") == []
    assert "unit 1's muscle" in notes(thinner, "reversal")[0]


def test_a_tuning_for_another_size_is_named():
    assert notes(TUNED, "muscle") == notes(TUNED, "bundle") == []
    assert "measured on a muscle of another size" in notes(TUNED, "efficiency")[0]
    thinner = replace(TUNED, units=(Unit(1), Unit(2, 0.5)))
    assert "another size" in notes(thinner, "bundle")[0]
    changed = replace(TUNED, name="kim2021_slenderness_10, changed")
    assert "another size" in notes(changed, "muscle")[0]


def test_a_tuning_is_told_in_the_units_shown():
    assert tuning_note(SIX.muscle, "kPa") == ""
    told = tuning_note(fs.example("kim2021_bundle_1_4").motor_units[0].muscle, "kPa")
    for part in ("Young's modulus × 0.95", "collapse moment × 0.75", "transition rate β = 100",
                 "hinge stiffness × (0.83 + 0.0092 per kPa)"):  # fmt: skip
        assert part in told
    assert "C₁" not in told and "dead band" not in told
    rows = fs.Tuning(pressures=[1e5, 3e5], c1=[0.0, 1.0], c2=[1.0, 1.1], dead_band=2e4)
    told = tuning_note(SIX.muscle.replace(tuning=rows), "bar")
    assert "C₁ and C₂ in 3 rows up to 3 bar, dead band 0.2 bar." in told
    assert "modulus" not in told and "β" not in told


def test_a_transition_rate_that_was_not_fitted_is_not_said_to_be_tuning_note():
    """A fit writes the muscle's own rate into its tuning."""
    own = float(SIX.muscle.transition_rate)
    beside = fs.Tuning(collapse_moment_factor=0.8, transition_rate=own)
    assert "β" not in tuning_note(SIX.muscle.replace(tuning=beside), "kPa")
    assert "0.8" in tuning_note(SIX.muscle.replace(tuning=beside), "kPa")
    alone = fs.Tuning(transition_rate=own)
    assert tuning_note(SIX.muscle.replace(tuning=alone), "kPa") == ""
    other = fs.Tuning(transition_rate=2 * own)
    assert f"β = {2 * own:g}" in tuning_note(SIX.muscle.replace(tuning=other), "kPa")


def test_a_tuning_is_said_above_the_muscle():
    for name, there in (("kim2021_figure_6", False), ("kim2021_bundle_1_4", True)):
        tab = MuscleView(Session(view_of(fs.example(name), name)), LIGHT)
        tab.refresh()
        assert ("This muscle is tuned: " in tab.notes.object) == there


def test_a_handful_of_laws_is_compared_and_no_two_look_alike():
    names = ("buckling:elastica", "tension:ideal", "collapse:wood1958", "tension:bolen")
    tab = MuscleView(Session(replace(SIX, compared=names)), LIGHT)
    tab.refresh()
    shown = tab.others.data
    taken = {*LIGHT.curves[:3], LIGHT.ink}
    assert len(set(shown["color"]) - taken) == len(set(shown["dash"])) == MOST_COMPARED
    tab.compare.value = [*names, "ends:compliant"]
    assert "Compare with must be 4 laws at most" in tab.message.text
    assert tab.session.view.compared == names == tuple(tab.compare.value)
    tab.compare.value = list(names[1:])
    assert not tab.message.text and tab.session.view.compared == names[1:]


def test_all_equilibria_are_told():
    strain, stable = np.array([0.186, 0.195, 0.230]), np.array([True, False, True])
    told = equilibria_text(strain, stable)
    assert told == "0.1860; it also rests at 0.1950 (not stable), 0.2300"
    assert equilibria_text(strain[:1], stable[:1]) == "0.1860"
    assert "none" in equilibria_text(strain[:0], stable[:0])


@pytest.mark.parametrize("pressure", [0.0, 34.5e3])
def test_the_strips_are_the_regions_of_the_law(pressure):
    """A stubby muscle shortens straight past its free strain: it isn't called buckled."""
    muscle = fs.Muscle.from_dimensions(
        0.03, 6.35e-3, 1.6e-3, math.radians(22), buckling="elastica",
        material=fs.materials.SILICONE_KIM2021,
    )  # fmt: skip
    top = strain_limit(muscle, 413.7e3)
    found = muscle_curves(muscle, pressure, 0.2, 413.7e3, top)
    ran = region_strips(found.strain[-1], found.regions)
    assert ran[0][0] == 0
    assert ran[-1][1] == top
    for left, right, region in ran:
        assert int(muscle.response(pressure, (left + right) / 2).region) == region
    assert 3 in [region for _, _, region in ran]


def test_strips_of_the_papers_law_begin_at_its_kinks():
    top = strain_limit(SIX.muscle, SIX.supply)
    found = muscle_curves(SIX.muscle, 137.9e3, 0.1, SIX.supply, top)
    ran = region_strips(found.strain[-1], found.regions)
    assert [region for _, _, region in ran] == [0, 1, 2]
    assert ran[1][0] == pytest.approx(float(SIX.muscle.free_strain(137.9e3)), abs=1e-9)
    assert ran[2][0] == pytest.approx(float(SIX.muscle.collapse_strain(137.9e3)), abs=1e-9)


def test_other_branches_are_told_with_their_strains():
    strain = np.linspace(0, 0.4, 5)
    assert branches_text(strain, np.zeros(5, bool)) == ""
    several = np.array([False, False, True, True, False])
    assert branches_text(strain, several).startswith("ε 0.200 to 0.300; the curve shows the branch")


@pytest.mark.parametrize("jump", [False, True])
@pytest.mark.parametrize("at", [0.0, 1.0, 41.7, 95.9])
def test_a_curve_goes_through_its_turning_point_and_breaks_where_it_jumps(jump, at):
    pressure = np.linspace(0.0, 96.0, POINTS)
    strain = np.where(pressure < at, 0.25, 0.2)
    one = SplitCurve((1, 4), pressure, strain, strain, Reversal(at, 0.19, 0.06, 0.25, jump))
    P, drawn = one.drawn
    assert P.size == drawn.size == POINTS + 1 + jump
    assert np.all(np.diff(P) >= 0)
    assert np.nanmin(drawn) == 0.19
    assert np.isnan(drawn).sum() == jump
    flat = replace(one, turn=replace(one.turn, depth=0.0))
    assert flat.drawn[1] is flat.resisted


def test_a_link_cannot_ask_for_more_than_the_supply():
    query = {"supply": "100 kPa", "pressure": "300 kPa", "pressures": "90 kPa,200 kPa"}
    view, refused = from_query(query, SIX)
    assert refused == ["link: `pressure` must be at most the supply's, 100kPa."]
    assert (view.pressure, view.pressures) == (1e5, (9e4, 1e5))
    view, refused = from_query({"supply": "100 kPa"}, SIX)
    assert not refused
    assert view.pressure == 1e5


def test_other_laws_are_drawn_at_once():
    law = fs.Muscle.from_dimensions(0.127, 9e-3, 2.25e-3, math.radians(28), buckling="elastica")
    view = MuscleView(Session(replace(SIX, muscle=law)), LIGHT)
    view.refresh()
    assert len(view.chosen.data["force"]) > 0
