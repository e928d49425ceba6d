"""Tab of gradient reversal: pressure in a second unit lowers the free strain at first."""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
import panel as pn

from ..bundle import Bundle, MotorUnit
from ..bundle.reversal import Reversal, free_strain_curve, reversal
from ..muscle import Muscle
from ..plot.curves import split_at_reversal
from ..plot.theme import Colors
from .chart import Chart, cycle_colors, padded_range, screen_height
from .link import parse_splits
from .remarks import remarks_html
from .state import Session, View
from .tab import LatestResult, Tab
from .theme import column, pane, row
from .widgets import html_legend, html_table, status_line, widget


POINTS = 97  # of pressure: steps of 4 kPa at 60 psi, smooth on a screen
_SIDE = 360  # pixels, of the column with the table
_EXPLANATION = (
    '<div style="max-width:330px;font-size:13.5px;opacity:.85">The first motor unit is at supply'
    " pressure, the second is being filled. At first the second may resist more than when it was"
    " empty: the bundle's free strain falls, and rises only past the reversal point (triangle)."
    " Dotted: a jump. Dashed: a model without resistance.</div>"
)


@dataclass(frozen=True)
class SplitCurve:
    """Free strain of a split of muscles over the second unit's pressure.

    `counts` of muscles by unit; free strains with resistance, `resisted`, and `free` of it [-]
    over `pressure` [Pa]; the `turn` of the former.
    """

    counts: tuple[int, ...]
    pressure: np.ndarray
    resisted: np.ndarray
    free: np.ndarray
    turn: Reversal

    @property
    def name(self) -> str:
        """Counts as they are written, such as 1 + 4."""
        return " + ".join(map(str, self.counts))

    @property
    def drawn(self) -> tuple[np.ndarray, np.ndarray]:
        """Pressures [Pa] and free strains [-] through the turning point, NaN where it jumps."""
        return split_at_reversal(self.pressure, self.resisted, self.turn)[0]

    @property
    def jump(self) -> tuple[np.ndarray, np.ndarray]:
        """Pressures [Pa] and free strains [-] of both ends of the jump; empty without one."""
        return split_at_reversal(self.pressure, self.resisted, self.turn)[1]


@lru_cache(maxsize=16)  # visitors share it
def split_curves(
    muscle: Muscle, splits: tuple[tuple[int, ...], ...], supply: float
) -> list[SplitCurve]:
    """Curves of several splits of a muscle, the first unit at `supply` pressure [Pa]."""
    pressure = np.linspace(0.0, supply, POINTS)
    curves = []
    for counts in splits:
        bundle = Bundle([MotorUnit(muscle, count) for count in counts], supply)
        resisted, free = (
            free_strain_curve(bundle, 2, pressure, supply, resistance)
            for resistance in (True, False)
        )
        curves.append(SplitCurve(counts, pressure, resisted, free, reversal(bundle, 2, supply)))
    return curves


class ReversalView(Tab):
    """Widgets and figure of gradient reversal."""

    name: ClassVar[str] = "reversal"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "splits", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self._splits = widget(
            pn.widgets.TextInput, "Splits of the same muscles, such as 1+4, 2+3",
            self._set_splits, max_width=420,
        )  # fmt: skip
        chart = self.chart = Chart(
            colors, "Pressure P2", "Free strain of the bundle [–]", screen_height(300)
        )
        self._lines = {
            name: chart.add("multi_line", "xs ys color label", f"reversal_{name}", line_width=width,
                            line_dash=dash)
            for name, dash, width in (("resisted", "solid", 3), ("free", "dashed", 1.8),
                                      ("jumps", "dotted", 2))
        }  # fmt: skip
        self._turns = chart.add(
            "scatter", "x y color label", "turns", size=11, marker="inverted_triangle",
            color="color",
        )  # fmt: skip
        chart.figure.text("x", "y", source=self._turns, text="label", x_offset=8, y_offset=16,
                          text_color=colors.ink, text_font_size="12px")  # fmt: skip
        self._legend = pane(sizing_mode="stretch_width")
        self._table = pane(margin=(8, 8))
        self._curves = LatestResult(self._show_curves, self.fail)
        left = column(self._splits, self.message.pane, self.status, self._legend, chart.new_pane())
        explanation = pane(_EXPLANATION, (8, 8))
        self.panel = row(
            left, pn.Column(explanation, self.notes, self._table, width=_SIDE, margin=0)
        )

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        self._splits.value = ", ".join("+".join(map(str, split)) for split in view.splits)
        self.notes.object = remarks_html(view, "reversal")
        self.status.object = status_line("computing")
        self._curves.request(lambda: split_curves(view.muscle, view.splits, view.supply))

    def _set_splits(self, text: str) -> None:
        with self.message.errors():
            self.session.change(splits=parse_splits(text))

    def _show_curves(self, curves: list[SplitCurve]) -> None:
        unit, scale = self.unit("pressure")
        colors = cycle_colors(self.colors, len(curves))
        for name, lines, suffix in (
            ("resisted", [curve.drawn for curve in curves], ""),
            ("free", [(c.pressure, c.free) for c in curves], ", without resistance"),
            ("jumps", [curve.jump for curve in curves], ", jump"),
        ):
            self._lines[name].data = {
                "xs": [pressure / scale for pressure, _ in lines],
                "ys": [strain for _, strain in lines],
                "color": colors,
                "label": [curve.name + suffix for curve in curves],
            }
        reversals = [
            (curve.turn.pressure / scale, curve.turn.free_strain, color, f"−{curve.turn.depth:.4f}")
            for curve, color in zip(curves, colors, strict=True)
            if curve.turn.depth > 0
        ]
        columns = map(list, zip(*reversals, strict=True)) if reversals else ([],) * 4
        self._turns.data = dict(zip(("x", "y", "color", "label"), columns, strict=True))
        self._legend.object = html_legend([
            *((curve.name, color, "solid") for curve, color in zip(curves, colors, strict=True)),
            ("without resistance", self.colors.soft, "dashed"),
        ])  # fmt: skip
        strains = np.concatenate([np.r_[curve.resisted, curve.free] for curve in curves])
        highest = float(curves[0].pressure[-1]) / scale
        self.chart.set_ranges((0.0, highest), padded_range(strains, 0.1, 0.004))
        self.chart.figure.xaxis[0].axis_label = f"Pressure of the second unit P2 [{unit}]"
        self.status.object = ""
        self.message.show("")
        rows = [
            (curve.name, f"{curve.turn.pressure / scale:.4g} {unit}", f"{curve.turn.depth:.4f}",
             "jump" if curve.turn.jump else "smooth")
            if curve.turn.depth > 0 else (curve.name, "none", "0", "")
            for curve in curves
        ]  # fmt: skip
        depths = "; ".join(f"{name}: {depth} at {at}" for name, at, depth, _ in rows)
        self.chart.describe(
            "Free strain of the bundle over the pressure of the second unit. Depth of the reversal"
            f" of each split: {depths.replace('0 at none', 'none')}."
        )
        self._table.object = html_table(("split", "reversal at", "depth [–]", "course"), rows)
