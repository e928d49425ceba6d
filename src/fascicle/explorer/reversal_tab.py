"""Tab of gradient reversal: feeding a second unit first shortens the bundle's reach."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.models.glyphs import MultiLine, Scatter, Text

from ..bundle import Bundle, MotorUnit
from ..bundle.reversal import Reversal, free_strain_curve, reversal
from ..muscle import Muscle
from ..plot.curves import split_at_reversal
from ..plot.theme import Colors
from .background import LatestResult
from .link import parse_splits
from .state import Session, View
from .tab import Tab, remarks_html
from .theme import STACKED, TALL, Chart, html_legend
from .widgets import Message, html_table, pane, status_line, unit_factor, widget


POINTS = 97
_ABOUT = (
    '<div style="max-width:330px;font-size:13.5px;opacity:.85">The first unit is at supply'
    " pressure. Where the second one, as it is fed, resists more at first than it did empty, the"
    " bundle's free strain falls, turns, and only then rises; where the curve is dotted it jumps."
    " Dashed: a model without resistance.</div>"
)


@dataclass(frozen=True)
class SplitCurve:
    """Free strain of a split of muscles over the second unit's pressure.

    `counts` of muscles by unit; free strains with resistance, `resisted`, and `free` of it [-]
    over `pressure` [Pa]; where they `turn`.
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
    """Curves of several splits, the first unit at supply pressure.

    **Arguments:**

    - `muscle`: of all units.
    - `splits`: numbers of muscles of the units of each split.
    - `supply`: the highest pressure [Pa].
    """
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
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "splits", "shown")

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** those of `Tab`."""
        super().__init__(session, colors)
        self._updating = False
        self._splits = widget(
            pn.widgets.TextInput, "Splits of the same muscles, such as 1+4, 2+3", max_width=420
        )
        self._splits.param.watch(self._set_splits, "value")
        chart = self.chart = Chart(
            colors, "Pressure P2", "Free strain of the bundle [–]", room=300
        )  # fmt: skip
        sources = []
        for name, dash, width in (("resisted", "solid", 3), ("free", "dashed", 1.8),
                                  ("jumps", "dotted", 2)):  # fmt: skip
            source = chart.source("xs", "ys", "color", "label", name=f"reversal_{name}")
            chart.draw(source, MultiLine(xs="xs", ys="ys", line_color="color", line_width=width,
                                         line_dash=dash))  # fmt: skip
            sources.append(source)
        self._resisted, self._free, self._jumps = sources
        self._turns = chart.source("x", "y", "color", "label", name="turns")
        chart.draw(self._turns, Scatter(x="x", y="y", size=11, marker="inverted_triangle",
                                        fill_color="color", line_color="color"))  # fmt: skip
        chart.draw(self._turns, Text(x="x", y="y", text="label", x_offset=8, y_offset=16,
                                     text_color=colors.ink, text_font_size="12px"))  # fmt: skip
        self._legend = pane(sizing_mode="stretch_width")
        self._table, self._notes = pane((8, 8)), pane((8, 8), width=330)
        self._status = pane(height=22)
        self._curves = LatestResult(self._show, self._fail)
        left = pn.Column(
            self._splits, self._status, self._legend,
            pn.pane.Bokeh(chart.figure, stylesheets=[TALL]), sizing_mode="stretch_width", margin=0,
        )  # fmt: skip
        self.message = Message(left, self._splits)
        self.panel = pn.Row(
            left,
            pn.Column(pn.pane.HTML(_ABOUT, margin=(8, 8)), self._notes, self._table, width=360,
                      margin=0),
            sizing_mode="stretch_width", margin=0, stylesheets=[STACKED],
        )  # fmt: skip

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self._updating = True
        self._splits.value = ", ".join("+".join(map(str, split)) for split in view.splits)
        self._updating = False
        self._notes.object = remarks_html(view, "reversal")
        self._status.object = status_line("computing")
        self._curves.request(lambda: split_curves(view.muscle, view.splits, view.supply))

    def _set_splits(self, event: Any) -> None:
        if self._updating:
            return
        try:
            self.session.change(splits=parse_splits(event.new))
            self.message.show("")
        except ValueError as error:
            self.message.show(error)

    def _fail(self, text: str) -> None:
        self._status.object = ""
        self.message.show(text, self.session.view.shown)

    def _show(self, curves: list[SplitCurve]) -> None:
        unit = self.session.view.shown["pressure"]
        scale, cycle = unit_factor(unit, "pressure"), self.colors.curves
        colors = [cycle[i % len(cycle)] for i in range(len(curves))]
        for source, lines, suffix in (
            (self._resisted, [curve.drawn for curve in curves], ""),
            (self._free, [(c.pressure, c.free) for c in curves], ", without resistance"),
            (self._jumps, [curve.jump for curve in curves], ", jump"),
        ):
            source.data = {
                "xs": [pressure / scale for pressure, _ in lines],
                "ys": [strain for _, strain in lines],
                "color": colors,
                "label": [curve.name + suffix for curve in curves],
            }
        turning = [
            (curve.turn, color)
            for curve, color in zip(curves, colors, strict=True)
            if curve.turn.depth > 0
        ]
        self._turns.data = {
            "x": [turn.pressure / scale for turn, _ in turning],
            "y": [turn.free_strain for turn, _ in turning],
            "color": [color for _, color in turning],
            "label": [f"−{turn.depth:.4f}" for turn, _ in turning],
        }
        self._legend.object = html_legend([
            *((curve.name, color, "solid") for curve, color in zip(curves, colors, strict=True)),
            ("without resistance", self.colors.soft, "dashed"),
        ])  # fmt: skip
        values = np.concatenate([np.r_[curve.resisted, curve.free] for curve in curves])
        low, high = float(values.min()), float(values.max())
        room = max(0.1 * (high - low), 0.004)
        highest = float(curves[0].pressure[-1]) / scale
        self.chart.set_ranges((0.0, highest), (low - room, high + room))
        self.chart.figure.xaxis[0].axis_label = f"Pressure of the second unit P2 [{unit}]"
        self._status.object = ""
        self.message.show("")
        rows = []
        for curve in curves:
            turn = curve.turn
            place = (
                f"{turn.pressure / scale:.4g} {unit}", f"{turn.depth:.4f}",
                "jump" if turn.jump else "smooth",
            )  # fmt: skip
            rows.append((curve.name, *(place if turn.depth > 0 else ("none", "0", ""))))
        self._table.object = html_table(("split", "turns at", "depth", "course"), rows)
