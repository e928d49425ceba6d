"""Bundles and their answers print as small tables with units."""

import pytest

import fascicle as fs


BUNDLE = fs.example("kim2021_bundle_1_4")


def test_a_bundle_prints_its_units_supply_and_scheme():
    lines = str(BUNDLE).splitlines()
    assert lines[0] == "Bundle of 2 motor units"
    assert "  supply pressure  413.7 kPa" in lines and "  scheme           orderly" in lines
    assert lines[-1].split()[:4] == ["2", "4", "127", "mm"]
    assert "<table" in BUNDLE._repr_html_()
    assert str(fs.MotorUnit(BUNDLE.motor_units[0].muscle, 4)).startswith("Motor unit of 4 ×")


def test_equilibria_mark_the_unstable_ones():
    text = str(BUNDLE.equilibria([69e3, 0.0]))
    found = BUNDLE.equilibria([69e3, 0.0])
    assert text.splitlines()[-1].split()[1].startswith(f"{found.strain[0]:.4f}")
    three = fs.example("kim2021_slenderness_8")
    pair = fs.Bundle([fs.MotorUnit(three), fs.MotorUnit(three, 4)])
    # Table 1's slenderness 8 as 1 + 4 at 69 kPa: three strains of zero force, the second unstable
    several = str(pair.equilibria([344.7e3, 69e3]))
    assert "u: unstable" in several


def test_recruited_pressures_are_told_with_what_was_not_reached():
    found = fs.recruitment.recruit(BUNDLE, [50.0, 5000.0], 0.1)
    lines = str(found).splitlines()
    assert lines[0] == "Recruitment, 2 points"
    assert lines[3].split()[2] == f"{found.pressures[0, 0] / 1e3:.4g}"
    assert "above what is reachable" in lines[4] and "nearest force" in lines[-1]
    assert str(found.solutions).startswith("Solutions, 1")
    none = fs.recruitment.recruit(BUNDLE, 5000.0, 0.1).solutions
    assert "none for demand 1: it can't be reached" in str(none)
    # what has none is named among others, and what has several says so
    both = fs.recruitment.recruit(BUNDLE, [100.0, 5000.0], 0.1)
    assert str(both.solutions).splitlines()[0] == "Solutions, 3"
    assert "none for demand 2: it can't be reached" in str(both.solutions)
    assert "of several solutions the first" in str(both)
    many = fs.recruitment.recruit(BUNDLE, [100.0, *[5000.0] * 12], 0.1).solutions
    assert "none for demand 2, 3, 4, 5, 6, 7, 8, 9 and 4 more" in str(many)


def test_a_space_tells_what_each_state_reaches():
    space = fs.recruitment.workspace(BUNDLE, 413.7e3, 5, [0.0, 0.1, 0.2])
    lines = str(space).splitlines()
    assert lines[0] == "Workspace" and "  supply pressure  413.7 kPa" in lines
    largest = float(BUNDLE.force([413.7e3, 413.7e3], 0.0))
    assert lines[-1].split() == ["2", f"{largest:.4g}", "0.2000"]
    assert "<table" in space._repr_html_()


def test_a_map_of_efficiency_tells_its_average_and_its_best():
    found = fs.energetics.efficiency_map(BUNDLE, 413.7e3, "isobaric", [50.0, 5000.0], [0.05, 0.1])
    lines = str(found).splitlines()
    assert "  reached  2 of 4 points" in lines
    assert f"  average  {found.average:.4f}" in lines
    assert lines[-1].startswith(f"  best     {found.efficiency[0].max():.4f} at 50 N, strain 0.")
    none = fs.energetics.efficiency_map(BUNDLE, 413.7e3, "isobaric", [5000.0], [0.05, 0.1])
    assert "reached  0 of 2 points" in str(none) and "average" not in str(none)


def test_a_reversal_is_told_in_words():
    text = str(fs.reversal.reversal(BUNDLE))
    assert "lowest" in text and "kPa" in text
    assert "never falls" in str(fs.reversal.reversal(BUNDLE, resistance=False))


def test_a_bundle_draws_its_space_or_its_units():
    assert BUNDLE.plot().axes[0].get_xlabel() == "Contraction ε [–]"
    labels = BUNDLE.plot(["50 psi", 0.0]).axes[0].get_legend_handles_labels()[1]
    assert labels[-1] == "bundle" and labels[0].startswith("unit 1: 1 × 344.7")
    with pytest.raises(fs.InvalidInputError, match="has no supply pressure"):
        BUNDLE.replace(supply_pressure=None).plot()
