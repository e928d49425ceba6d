"""Figures of free strain: curves open where they jump, units and markers named."""

import numpy as np
import pytest

import fascicle as fs
from fascicle import plot
from fascicle.bundle.reversal import free_strain_curve, reversal
from fascicle.plot.curves import free_strain_states


SUPPLY = 344.7e3
BUNDLE = fs.example("kim2021_bundle_1_4")


def draw(states, resistance=True):
    figure = free_strain_states(BUNDLE, states, BUNDLE.free_strain(states, resistance), resistance)
    ax = figure.axes[0]
    return ax, [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize("count", [2, 60])
def test_a_curve_is_open_where_it_jumps(count):
    P = np.linspace(0.0, SUPPLY, count)
    ax, labels = draw(np.stack([np.full(count, SUPPLY), P], axis=-1))
    line, dots, jump, turn = ax.get_lines()
    eps = line.get_ydata()
    assert np.isnan(eps).sum() == 1
    # the curve is smooth: the 0.035 of the jump are nowhere bridged
    assert np.nanmax(np.abs(np.diff(eps))) < 0.004
    np.testing.assert_array_equal(dots.get_xdata(), P / 1e3)
    exact = reversal(BUNDLE, 2, SUPPLY)
    assert exact.jump
    np.testing.assert_allclose(jump.get_xdata(), exact.pressure / 1e3, rtol=1e-6)
    assert turn.get_xdata()[0] == pytest.approx(exact.pressure / 1e3, rel=1e-6)
    # both stand before the same jump, as near as their searches come
    assert turn.get_ydata()[0] == pytest.approx(exact.free_strain, abs=1e-5)
    assert "unit 2" in ax.get_xlabel() and "kPa" in ax.get_xlabel()
    assert labels == ["$P_{1}$ = 344.7 kPa", "computed", "jump", "reversal point"]


def test_a_curve_that_turns_by_a_jump_is_open_there():
    P = np.linspace(0.0, SUPPLY, 101)
    strains = {"1 + 4": free_strain_curve(BUNDLE, 2, P, SUPPLY)}
    strains["free"] = free_strain_curve(BUNDLE, 1, P, SUPPLY)
    ax = plot.free_strain(P, strains, "P₂", {"1 + 4": reversal(BUNDLE, 2, SUPPLY)}).axes[0]
    line, whole, jump = ax.get_lines()
    assert np.isnan(line.get_ydata()).sum() == 1 and np.isfinite(whole.get_ydata()).all()
    assert jump.get_linestyle() == ":" and np.ptp(jump.get_ydata()) > 0.03
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(strains)
