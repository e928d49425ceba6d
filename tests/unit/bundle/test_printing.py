"""Bundles and their results print as small tables with units."""

import pytest

import fascicle as fs


BUNDLE = fs.example("kim2021_bundle_1_4")


def test_a_bundle_prints_its_units_supply_and_scheme():
    lines = str(BUNDLE).splitlines()
    assert "  supply pressure  413.7 kPa" in lines and "  scheme           orderly" in lines
    assert lines[-1].split()[:4] == ["2", "4", "127", "mm"]
    assert not hasattr(BUNDLE, "_repr_html_")


def test_results_print_their_numbers():
    zeros = BUNDLE.equilibria([69e3, 0.0])
    demands = BUNDLE.recruit([100.0, 5000.0], 0.1)
    for result, number in (
        (zeros, f"{zeros.strain[0]:.4f}"),
        (demands, f"{demands.pressures[0, 0] / 1e3:.4g}"),
    ):
        assert number in str(result)


def test_plot_draws_the_workspace_or_the_units():
    assert fs.plot.bundle_force_strain(BUNDLE).axes[0].get_xlabel() == "Contraction ε [–]"
    labels = (
        fs.plot.bundle_force_strain(BUNDLE, ["50 psi", 0.0]).axes[0].get_legend_handles_labels()[1]
    )
    assert labels[-1] == "bundle" and labels[0].startswith("unit 1: 1 × 344.7")
    with pytest.raises(fs.InvalidInputError) as error:
        fs.plot.bundle_force_strain(BUNDLE.replace(supply_pressure=None))
    assert error.value.argument == "pressures"
