"""Figures of a calibration: they draw no more than was measured."""

from dataclasses import replace

import numpy as np

from fascicle.plot import to_bytes
from fascicle.report.calibration_figures import FitPlot, draw_fit, draw_residuals


P = np.array([0.0, 100e3, 200e3])
STRAIN = np.tile(np.linspace(0, 0.3, 100), (3, 1))
FORCE = (P[:, None] / 2e3) * (1 - 4 * STRAIN) - 1.0
FIT = FitPlot(
    pressure=P,
    strain=STRAIN,
    force=FORCE,
    censored=np.zeros(STRAIN.shape, bool),
    residual=0.1 * np.sin(40 * STRAIN),
    noise=0.1,
    curve_strain=STRAIN,
    curve_force=FORCE,
    half_width=np.full(STRAIN.shape, 0.2),
)


def points(ax, marker):
    return [line for line in ax.lines if line.get_marker() == marker and len(line.get_xdata())]


def test_a_measured_push_is_enlarged_in_a_second_panel():
    assert FIT.resists
    _, zoom, _ = draw_fit(FIT).axes  # the color bar has axes of its own
    low, high = zoom.get_ylim()
    assert low < FORCE.min() < 0 < high < -FORCE.min()
    pull = replace(FIT, force=np.abs(FORCE))
    assert not pull.resists and len(draw_fit(pull).axes) == 2


def test_clipped_readings_have_their_own_mark_and_are_no_push():
    clipped = FORCE < 0
    data = replace(FIT, force=np.where(clipped, 0.0, FORCE), censored=clipped)
    assert not data.resists
    figure = draw_fit(data)
    assert points(figure.axes[0], "v") and points(figure.axes[0], "o")
    assert all(np.all(line.get_ydata() == 0) for line in points(figure.axes[0], "v"))
    assert "clipped" in " ".join(text.get_text() for text in figure.legends[0].texts)


def test_many_points_are_thinned_and_none_is_drawn_twice():
    strains = [line.get_xdata() for line in points(draw_fit(FIT).axes[0], "o")]
    assert len(strains) == len(P)
    for strain in strains:
        assert len(strain) == len(set(strain)) == 40
        assert (strain.min(), strain.max()) == (0, 0.3)


def test_rows_that_are_filled_up_are_left_out():
    strain, force = STRAIN.copy(), FORCE.copy()
    strain[0, 5:], force[0, 5:] = np.nan, np.nan
    ax = draw_fit(replace(FIT, strain=strain, force=force)).axes[0]
    assert min(len(line.get_xdata()) for line in points(ax, "o")) == 5


def test_one_pressure_without_a_band_can_be_drawn():
    names = ("pressure", "strain", "force", "censored", "residual", "curve_strain", "curve_force")
    first = {name: getattr(FIT, name)[:1] for name in names}
    data = replace(FIT, **first, half_width=None)
    for draw in (draw_fit, draw_residuals):
        assert to_bytes(draw(data), "png").startswith(b"\x89PNG")
