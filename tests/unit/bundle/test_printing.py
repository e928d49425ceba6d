"""Bundles and their results print as small tables with units."""

import pytest

import fascicle as fs


BUNDLE = fs.example("kim2021_bundle_1_4")


def test_a_bundle_prints_its_units_supply_and_scheme():
    lines = str(BUNDLE).splitlines()
    assert "  supply pressure  413.7 kPa" in lines and "  scheme           orderly" in lines
    assert lines[-1].split()[:4] == ["2", "4", "127", "mm"]
    assert "<table" in BUNDLE._repr_html_()
    assert str(fs.MotorUnit(BUNDLE.motor_units[0].muscle, 4)).startswith("Motor unit of 4 ×")


def test_equilibria_print_strains_and_mark_unstable_ones():
    result = BUNDLE.equilibria([69e3, 0.0])
    assert str(result).splitlines()[-1].split()[1].startswith(f"{result.strain[0]:.4f}")
    muscle = fs.example("kim2021_slenderness_8")
    pair = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)])
    # Table 1's slenderness 8 as 1 + 4 at 69 kPa: three strains of zero force, the second unstable
    assert "u: unstable" in str(pair.equilibria([344.7e3, 69e3]))


def test_recruitment_prints_pressures_and_names_unreached_demands():
    result = BUNDLE.recruit([100.0, 5000.0], 0.1)
    lines = str(result).splitlines()
    assert lines[3].split()[2] == f"{result.pressures[0, 0] / 1e3:.4g}"
    assert "above what is reachable" in lines[4]
    assert str(result.solutions).splitlines()[0] == "Solutions, 3"
    many = BUNDLE.recruit([100.0, *[5000.0] * 12], 0.1).solutions
    assert "2, 3, 4, 5, 6, 7, 8, 9 and 4 more" in str(many)


def test_workspace_prints_the_reach_of_each_state():
    workspace = BUNDLE.workspace(413.7e3, 5, [0.0, 0.1, 0.2])
    largest = float(BUNDLE.force([413.7e3, 413.7e3], 0.0))
    assert str(workspace).splitlines()[-1].split() == ["2", f"{largest:.4g}", "0.2000"]
    assert "<table" in workspace._repr_html_()


def test_efficiency_map_prints_average_and_best():
    result = BUNDLE.efficiency_map(413.7e3, "isobaric", [50.0, 5000.0], [0.05, 0.1])
    lines = str(result).splitlines()
    assert "  reached  2 of 4 points" in lines
    assert f"  average  {result.average:.4f}" in lines
    assert lines[-1].startswith(f"  best     {result.efficiency[0].max():.4f} at 50 N, strain 0.")
    none = BUNDLE.efficiency_map(413.7e3, "isobaric", [5000.0], [0.05, 0.1])
    assert "reached  0 of 2 points" in str(none) and "average" not in str(none)


def test_reversal_prints_its_turn():
    assert "kPa" in str(BUNDLE.reversal())
    assert "none" in str(BUNDLE.reversal(resistance=False))


def test_plot_draws_the_workspace_or_the_units():
    assert BUNDLE.plot().axes[0].get_xlabel() == "Contraction ε [–]"
    labels = BUNDLE.plot(["50 psi", 0.0]).axes[0].get_legend_handles_labels()[1]
    assert labels[-1] == "bundle" and labels[0].startswith("unit 1: 1 × 344.7")
    with pytest.raises(fs.InvalidInputError) as error:
        BUNDLE.replace(supply_pressure=None).plot()
    assert error.value.argument == "pressures"
