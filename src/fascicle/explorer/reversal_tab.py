"""The reversal's tab: how feeding a second unit first shortens the reach."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import panel as pn

from ..bundle import Bundle, MotorUnit
from ..bundle.reversal import Reversal, free_strain_curve, reversal
from ..muscle import Muscle
from ..plot.curves import split_at_reversal
from .background import Latest, shared
from .link import parse_splits
from .state import Session, View
from .tab import Tab, remarks, status
from .theme import STACKED, TALL, Look, key, plain_figure, set_range, source_of, widget_css
from .widgets import factor


POINTS = 97


@dataclass(frozen=True)
class Split:
    """One split: `counts` of muscles by unit [-]; free strains `resisted` and `free` of
    resistance [-] over `pressure` [Pa]; where they turn.
    """

    counts: tuple[int, ...]
    pressure: np.ndarray
    resisted: np.ndarray
    free: np.ndarray
    turn: Reversal

    @property
    def name(self) -> str:
        """As it is written: 1 + 4."""
        return " + ".join(map(str, self.counts))


def through(one: Split) -> tuple[np.ndarray, np.ndarray]:
    """A split's curve through its turning point, as it is drawn: with a gap where it jumps.

    **Arguments:** `one`: the split [-].

    **Returns:** pressures [Pa] and free strains [-], NaN in the gap.
    """
    return split_at_reversal(one.pressure, one.resisted, one.turn)[0]


def jump(one: Split) -> tuple[np.ndarray, np.ndarray]:
    """The two ends of a split's jump.

    **Arguments:** `one`: the split [-].

    **Returns:** pressures [Pa] and free strains [-]; empty where it doesn't jump.
    """
    return split_at_reversal(one.pressure, one.resisted, one.turn)[1]


def split_curves(muscle: Muscle, splits: tuple[tuple[int, ...], ...], supply: float) -> list[Split]:
    """The free strain of each split as its second unit is fed, the first at supply.

    **Arguments:**

    - `muscle`: of which all units are [-].
    - `splits`: how many of it each unit has [-].
    - `supply`: the highest pressure [Pa].

    **Returns:** strains [-] over pressures [Pa].
    """
    pressure = np.linspace(0.0, supply, POINTS)
    out = []
    for counts in splits:
        bundle = Bundle([MotorUnit(muscle, count) for count in counts], supply)
        resisted, free = (
            free_strain_curve(bundle, 2, pressure, supply, resistance)
            for resistance in (True, False)
        )
        out.append(Split(counts, pressure, resisted, free, reversal(bundle, 2, supply)))
    return out


class ReversalView(Tab):
    """Widgets and figure of gradient reversal."""

    name: ClassVar[str] = "reversal"
    fields: ClassVar[tuple[str, ...]] = ("muscle", "units", "supply", "splits", "shown")

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        super().__init__(session, look)
        self._silent = False
        self._splits = pn.widgets.TextInput(
            label="Splits of the same muscles, side by side: 1+4, 2+3", max_width=420,
            sizing_mode="stretch_width", stylesheets=[widget_css(look)], margin=(2, 8),
        )  # fmt: skip
        self._splits.param.watch(self._typed, "value")
        fig = plain_figure(look, "Pressure P2", "Free strain of the bundle [–]", room=300)
        self.figure = fig
        self._turns = source_of({"x": [], "y": [], "color": [], "label": []}, name="turns")
        for kind, dash, width in (("resisted", "solid", 3), ("free", "dashed", 1.8)):
            source = source_of({"xs": [], "ys": [], "color": [], "label": []},
                                      name=f"reversal_{kind}")  # fmt: skip
            fig.multi_line("xs", "ys", source=source, color="color", line_width=width,
                           line_dash=dash)  # fmt: skip
            setattr(self, f"_{kind}", source)
        self._jumps = source_of({"xs": [], "ys": [], "color": []}, name="reversal_jumps")
        fig.multi_line("xs", "ys", source=self._jumps, color="color", line_width=2,
                       line_dash="dotted")  # fmt: skip
        fig.scatter(
            "x", "y", source=self._turns, size=11, color="color", marker="inverted_triangle"
        )
        fig.text("x", "y", "label", source=self._turns, x_offset=8, y_offset=16,
                 text_color=look.ink, text_font_size="12px")  # fmt: skip
        self._key = pn.pane.HTML("", sizing_mode="stretch_width", margin=(0, 8))
        self._table = pn.pane.HTML("", margin=(8, 8))
        self._status = pn.pane.HTML("", margin=(0, 8), height=22)
        self._notes = pn.pane.HTML("", margin=(8, 8), width=330)
        self._found = Latest(self._show, self._failed)
        about = pn.pane.HTML(
            '<div style="max-width:330px;font-size:13.5px;opacity:.85">The first unit is at supply'
            " pressure. Where the second one, as it is fed, resists more at first than it did"
            " empty, the bundle's free strain falls, turns, and only then rises; where the curve"
            " is dotted it jumps. Dashed: what a model without resistance says.</div>",
            margin=(8, 8),
        )
        self.panel = pn.Row(
            pn.Column(self._splits, self.message.pane, self._status, self._key,
                      pn.pane.Bokeh(fig, stylesheets=[TALL]),
                      sizing_mode="stretch_width", margin=0),
            pn.Column(about, self._notes, self._table, width=360, margin=0),
            sizing_mode="stretch_width", margin=0, stylesheets=[STACKED],
        )  # fmt: skip

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        self._silent = True
        self._splits.value = ", ".join("+".join(map(str, split)) for split in view.splits)
        self._silent = False
        self._notes.object = remarks(view, "reversal")
        self._status.object = status("computing")
        self._found.ask(lambda: shared(split_curves, view.muscle, view.splits, view.supply))

    def _typed(self, event: Any) -> None:
        if self._silent:
            return
        try:
            self.session.change(splits=parse_splits(event.new))
            self.message.say("")
        except ValueError as error:
            self.message.say(str(error))

    def _failed(self, text: str) -> None:
        self._status.object = ""
        self.message.say(text)

    def _show(self, found: list[Split]) -> None:
        unit = self.session.view.shown["pressure"]
        scale, cycle = factor(unit, "pressure"), self.look.curves
        colors = [cycle[i % len(cycle)] for i in range(len(found))]
        for kind in ("resisted", "free"):
            drawn = [
                through(one) if kind == "resisted" else (one.pressure, one.free) for one in found
            ]
            getattr(self, f"_{kind}").data = {
                "xs": [pressure / scale for pressure, _ in drawn],
                "ys": [strain for _, strain in drawn],
                "color": colors,
                "label": [
                    one.name + ("" if kind == "resisted" else ", without resistance")
                    for one in found
                ],
            }
        jumps = [jump(one) for one in found]
        self._jumps.data = {
            "xs": [pressure / scale for pressure, _ in jumps],
            "ys": [strain for _, strain in jumps],
            "color": colors,
        }
        turning = [
            (one, color) for one, color in zip(found, colors, strict=True) if one.turn.depth > 0
        ]
        self._turns.data = {
            "x": [one.turn.pressure / scale for one, _ in turning],
            "y": [one.turn.free_strain for one, _ in turning],
            "color": [color for _, color in turning],
            "label": [f"−{one.turn.depth:.4f}" for one, _ in turning],
        }
        self._key.object = key([
            *((one.name, color, "solid") for one, color in zip(found, colors, strict=True)),
            ("without resistance", self.look.soft, "dashed"),
        ])  # fmt: skip
        values = np.concatenate([np.r_[one.resisted, one.free] for one in found])
        low, high = float(values.min()), float(values.max())
        room = max(0.1 * (high - low), 0.004)
        set_range(self.figure.x_range, 0.0, found[0].pressure[-1] / scale)
        set_range(self.figure.y_range, low - room, high + room)
        self.figure.xaxis[0].axis_label = f"Pressure of the second unit P2 [{unit}]"
        self._status.object = ""
        self.message.say("")
        rows = [
            (one.name, *(
                (f"{one.turn.pressure / scale:.4g} {unit}", f"{one.turn.depth:.4f}",
                 "jump" if one.turn.jump else "smooth")
                if one.turn.depth > 0 else ("none", "0", "")
            ))
            for one in found
        ]  # fmt: skip
        self._table.object = grid(("split", "turns at", "depth", "how"), rows)


def grid(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table [-] with `heads` [-]."""
    style = "padding:2px 14px 2px 0;text-align:left;font-variant-numeric:tabular-nums"
    top = "".join(f'<th style="{style};font-weight:600">{head}</th>' for head in heads)
    body = "".join(
        "<tr>" + "".join(f'<td style="{style}">{cell}</td>' for cell in row) + "</tr>"
        for row in rows
    )
    return f'<table style="font-size:13.5px;border-collapse:collapse"><tr>{top}</tr>{body}</table>'
