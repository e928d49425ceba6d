"""Chart of a bundle's free strain over its second unit's pressure, with the reversal point."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..bundle import Bundle
from ..bundle.reversal import Reversal, free_strain_curve, reversal
from ..plot.curves import split_at_reversal
from ..plot.theme import Colors
from .chart import Chart, padded_range
from .state import View
from .tab import LatestResult, Tab
from .theme import column, pane
from .widgets import heading, html_legend, status_line


POINTS = 97  # of pressure: steps of 4 kPa at 60 psi, smooth on a screen
_HEIGHT = "300px"
_EXPLANATION = (
    "Unit 1 is at P1, unit 2 is being filled, later units are vented. At first unit 2 may resist"
    " more than when it was empty: the bundle's free strain falls, and rises only past the reversal"
    " point (triangle)."
)
_NO_CURVE = "Raise P1: the curve is that of a bundle whose unit 1 is pressurized."


class FreeStrainCurve(NamedTuple):
    """Free strain over the second unit's `pressure` [Pa]: with resistance, `resisted`, and `free`
    of it [-]; and the `turn` of the former.
    """

    pressure: np.ndarray
    resisted: np.ndarray
    free: np.ndarray
    turn: Reversal


@lru_cache(maxsize=32)  # visitors share it
def second_unit_curve(bundle: Bundle, first: float) -> FreeStrainCurve:
    """Free strain of a `bundle` over its second unit's pressure, unit 1 at a pressure `first` [Pa],
    later units vented.
    """
    pressure = np.linspace(0.0, first, POINTS)
    resisted, free = (
        free_strain_curve(bundle, 2, pressure, first, resistance) for resistance in (True, False)
    )
    return FreeStrainCurve(pressure, resisted, free, reversal(bundle, 2, first))


class FreeStrainChart:
    """Chart as the layout `panel` of a `tab`; empty for a bundle of one unit."""

    def __init__(self, tab: Tab, colors: Colors):
        self._tab = tab
        chart = self.chart = Chart(colors, "Pressure P2", "Free strain [–]", _HEIGHT)
        self._lines = {
            name: chart.add("multi_line", "xs ys color", f"free_strain_{name}", line_width=width,
                            line_dash=dash)
            for name, dash, width in (("resisted", "solid", 3), ("free", "dashed", 1.8),
                                      ("jump", "dotted", 2))
        }  # fmt: skip
        self._turn = chart.add(
            "scatter", "x y label", "turn", size=11, marker="inverted_triangle",
            line_color=colors.ink, fill_color=colors.ink,
        )  # fmt: skip
        chart.add_labels(self._turn, x_offset=8, y_offset=-18, text_font_size="12px")
        self._point = chart.add_point(name="free_strain_point")
        self._legend = pane()
        self._message = pane(margin=(2, 8), sizing_mode="stretch_width")
        self._figure = column(self._legend, chart.new_pane())
        title = pane(heading("Free strain over the pressure of unit 2"))
        self.panel = column(title, self._figure, self._message)
        self._curves = LatestResult(self._show, tab.fail, is_open=tab.is_open)

    def draw(self, view: View) -> None:
        """Request the curve of a `view`."""
        self.panel.visible = len(view.units) > 1
        first = view.pressures[0]
        self._figure.visible = first > 0
        if not self.panel.visible or not first:
            self._message.object = status_line(_NO_CURVE)
            return
        self._curves.request(lambda: second_unit_curve(view.bundle, first))

    def show_point(self, view: View, free_strain: float) -> None:
        """Mark the `free_strain` [-] at the pressures of a `view`, where it is on the curve."""
        is_on_curve = len(view.units) > 1 and not any(view.pressures[2:])
        is_on_curve &= view.pressures[1:2] <= view.pressures[:1]
        scale = self._tab.unit("pressure")[1]
        point = {"x": [view.pressures[1] / scale], "y": [free_strain]} if is_on_curve else None
        self._point.data = point or {"x": [], "y": []}

    def _show(self, curve: FreeStrainCurve) -> None:
        unit, scale = self._tab.unit("pressure")
        colors, turn = self._tab.colors, curve.turn
        self._legend.object = html_legend([
            ("with resistance", colors.ink, "solid"), ("without", colors.soft, "dashed"),
            ("jump", colors.ink, "dotted"),
        ])  # fmt: skip
        drawn, jump = split_at_reversal(curve.pressure, curve.resisted, turn)
        for name, (pressure, strain), color in (
            ("resisted", drawn, colors.ink),
            ("free", (curve.pressure, curve.free), colors.soft),
            ("jump", jump, colors.ink),
        ):
            self._lines[name].data = {"xs": [pressure / scale], "ys": [strain], "color": [color]}
        falls = turn.depth > 0
        self._turn.data = {
            "x": [turn.pressure / scale] * falls,
            "y": [turn.free_strain] * falls,
            "label": [f"−{turn.depth:.4f}"] * falls,
        }
        highest = float(curve.pressure[-1]) / scale
        strains = np.concatenate([curve.resisted, curve.free])
        self.chart.set_ranges((0.0, highest), padded_range(strains, 0.18, 0.004))
        self.chart.figure.xaxis[0].axis_label = f"Pressure of unit 2 P2 [{unit}]"
        text = (
            f"It falls by {turn.depth:.4f} to {turn.free_strain:.4f}, at"
            f" {turn.pressure / scale:.4g} {unit}{', in a jump' * turn.jump}."
            if falls
            else "It never falls."
        )
        self._message.object = status_line(f"{_EXPLANATION} {text}")
        self.chart.describe(f"Free strain of the bundle over the pressure of unit 2. {text}")
