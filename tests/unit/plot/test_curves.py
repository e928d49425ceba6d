"""Figures of free strain: curves open where they jump, units and markers named."""

import numpy as np
import pytest

import fascicle as fs
from fascicle import plot
from fascicle.bundle.reversal import free_strain_curve, reversal
from fascicle.plot.curves import free_strain_states, split_at_jumps


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


def test_states_of_the_other_units_are_curves_of_their_own():
    P = np.linspace(0.0, SUPPLY, 5)
    states = np.array([(first, second) for first in (200e3, 300e3) for second in P[::-1]])
    ax, labels = draw(states, resistance=False)
    assert labels == ["$P_{1}$ = 200 kPa", "$P_{1}$ = 300 kPa", "computed"]
    assert all(np.all(np.diff(line.get_xdata()) > 0) for line in ax.get_lines())


def test_a_muscle_has_no_unit():
    muscle = fs.example("kim2021_figure_6")
    P = np.linspace(0.0, SUPPLY, 4)
    ax = free_strain_states(muscle, P, muscle.free_strain(P)).axes[0]
    assert ax.get_xlabel() == "Pressure P [kPa]"
    assert np.isfinite(ax.get_lines()[0].get_ydata()).all()


def test_a_steep_curve_does_not_jump_and_every_jump_is_noticed():
    x = np.linspace(0.0, 1.0, 11)

    def steep(x):
        return np.tanh((x - 0.33) * 1e4)

    def stairs(x):
        return np.floor(3.5 * x)

    (_, y), jumps = split_at_jumps(x, steep(x), steep)
    assert not jumps and np.isfinite(y).all()
    (pressures, y), jumps = split_at_jumps(x, stairs(x), stairs)
    assert np.isnan(y).sum() == len(jumps) == 3
    np.testing.assert_allclose([ends[0] for ends, _ in jumps], np.arange(1, 4) / 3.5)
    assert np.all(np.diff(pressures) >= 0)


def test_a_curve_that_turns_by_a_jump_is_open_there():
    P = np.linspace(0.0, SUPPLY, 101)
    strains = {"1 + 4": free_strain_curve(BUNDLE, 2, P, SUPPLY)}
    strains["free"] = free_strain_curve(BUNDLE, 1, P, SUPPLY)
    ax = plot.free_strain(P, strains, "P₂", {"1 + 4": reversal(BUNDLE, 2, SUPPLY)}).axes[0]
    line, whole, jump = ax.get_lines()
    assert np.isnan(line.get_ydata()).sum() == 1 and np.isfinite(whole.get_ydata()).all()
    assert jump.get_linestyle() == ":" and np.ptp(jump.get_ydata()) > 0.03
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(strains)
