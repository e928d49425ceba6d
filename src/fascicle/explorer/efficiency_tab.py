"""Tab of efficiency: maps over the force-strain space, and averages by number of motor units."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
import panel as pn
from bokeh.models import ColorBar, HoverTool, LinearColorMapper, Title
from bokeh.models.glyphs import Image, Line, Scatter
from bokeh.palettes import Cividis256

from ..bundle import Bundle
from ..bundle.efficiency import (
    PATHS,
    EfficiencyMap,
    average_efficiency,
    constant_cross_section,
    efficiency_map,
)
from ..muscle import Muscle
from ..plot.theme import CLEAR, FIGURES, Colors
from .background import LatestResult
from .state import Session, View, scaled
from .tab import Tab, card, remarks_html
from .theme import NARROW, STACKED, TALL, WRAPPED, Chart, equal_column
from .widgets import Message, dropdown, html_table, pane, status_line, unit_factor


COUNTS = (1, 2, 3, 4, 5)  # of motor units; the first is the single equivalent motor unit
_KINDS = {"with resistance": "resisted", "without resistance": "free",
          "loss due to resistance": "difference"}  # fmt: skip
# in the place of the map and the averages until they are computed
_CARDS = {
    "Drawing the map …": "How much of the fluid's energy becomes work, at every strain and force"
    " that this bundle reaches: with its muscles' resistance, and without.",
    "Averages come next …": "What more motor units in the same cross-section save.",
}


@dataclass(frozen=True)
class Maps:
    """Efficiency maps with resistance, `resisted`, and `free` of it, on the same points."""

    resisted: EfficiencyMap
    free: EfficiencyMap

    @property
    def difference(self) -> np.ndarray:
        """Efficiency lost to resistance [-], at points that both reach."""
        return self.free.efficiency - self.resisted.efficiency


@lru_cache(maxsize=16)  # visitors share it
def efficiency_maps(bundle: Bundle, path: str) -> Maps:
    """Maps of a `bundle` along a `path`, on the points of the one with resistance."""
    resisted = efficiency_map(bundle, path=path, resistance=True)
    free = efficiency_map(
        bundle, path=path, force=resisted.force, strain=resisted.strain, resistance=False
    )
    return Maps(resisted, free)


def equivalent_muscle(view: View) -> Muscle:
    """Single muscle with the cross-section of the whole bundle."""
    radius = float(view.muscle.outer_radius)
    total = sum(unit.count * float(view.muscle_of(unit).outer_radius) ** 2 for unit in view.units)
    return scaled(view.muscle, float(np.sqrt(total)) / radius)


@lru_cache(maxsize=16)  # visitors share it
def average_efficiencies(whole: Muscle, supply: float, path: str) -> dict[bool, np.ndarray]:
    """Average efficiency [-] of `COUNTS` equal units, with resistance under `True`.

    **Arguments:**

    - `whole`: muscle with the cross-section of all units.
    - `supply`: supply pressure [Pa].
    - `path`: "isobaric" or "isotonic".
    """
    bundles = [constant_cross_section(whole, count, supply) for count in COUNTS]
    return {
        resistance: np.array([
            average_efficiency(bundle, path=path, resistance=resistance) for bundle in bundles
        ])
        for resistance in (True, False)
    }  # fmt: skip


class EfficiencyView(Tab):
    """Widgets and figures of efficiency."""

    name: ClassVar[str] = "efficiency"
    fields: ClassVar[tuple[str, ...]] = (
        "muscle", "units", "supply", "scheme", "shown", "path", "distance",
    )  # fmt: skip

    def __init__(self, session: Session, colors: Colors):
        """**Arguments:** those of `Tab`."""
        super().__init__(session, colors)
        self._updating = False
        self._result: Maps | None = None
        self._path = dropdown("Path", list(PATHS), width=200)
        self._path.param.watch(self._set_path, "value")
        self._kind = dropdown("Map", _KINDS, width=230)
        self._kind.param.watch(lambda _: self._show_other_map(), "value")
        self._add_map()
        self._add_averages()
        self._status, self._numbers = pane(height=22), pane()
        self._notes = pane(sizing_mode="stretch_width")
        self.maps = LatestResult(self._show, self._fail)
        self.averages = LatestResult(self._show_averages, self._fail)
        self.cards = [card(title, text) for title, text in _CARDS.items()]
        self.figures = [
            pn.Column(
                pn.pane.Bokeh(chart.figure, margin=0, stylesheets=[TALL]), margin=0, visible=False,
                sizing_mode="stretch_width", stylesheets=[NARROW],
            )
            for chart in (self.map, self.bars)
        ]  # fmt: skip
        self.panel = pn.Column(
            pn.Row(self._path, self._kind, self._numbers, margin=0, stylesheets=[WRAPPED]),
            self._notes, self._status,
            pn.Row(*(pn.Column(*both, margin=0, **equal_column())
                     for both in zip(self.cards, self.figures, strict=True)),
                   sizing_mode="stretch_width", margin=0, stylesheets=[STACKED]),
            sizing_mode="stretch_width", margin=0,
        )  # fmt: skip
        self.message = Message(self.panel, self.panel[0])

    def draw(self, view: View) -> None:
        """Show a `view`."""
        self._updating = True
        self._path.value = view.path
        self._updating = False
        self._notes.object = remarks_html(view, "efficiency")
        self._status.object = status_line("computing the map")
        self.maps.request(lambda: efficiency_maps(view.bundle, view.path))

    def _set_path(self, event: Any) -> None:
        if not self._updating:
            self.session.change(path=event.new)

    def _fail(self, text: str) -> None:
        self._status.object = ""
        self.message.show(text, self.session.view.shown)
        for waiting in self.cards:
            waiting.visible = False

    def _replace_card(self, index: int) -> None:
        self.cards[index].visible, self.figures[index].visible = False, True

    def _add_map(self) -> None:
        colors = self.colors
        chart = self.map = Chart(colors, "Contraction ε [–]", "Force F [N]", room=320)
        self._mapper = LinearColorMapper(palette=Cividis256, low=0, high=1, nan_color=CLEAR)
        self._image = chart.source("image", "x", "y", "dw", "dh", name="efficiency")
        image = chart.draw(self._image, Image(image="image", x="x", y="y", dw="dw", dh="dh",
                                              color_mapper=self._mapper))  # fmt: skip
        bar = ColorBar(
            color_mapper=self._mapper, major_label_text_color=colors.ink,
            background_fill_color=colors.paper, width=12,
        )  # fmt: skip
        chart.figure.add_layout(bar, "right")
        title = Title(
            text="Efficiency η [–]", align="center", text_color=colors.ink, text_font=FIGURES,
            text_font_style="normal", text_font_size="14px",
        )  # fmt: skip
        chart.figure.add_layout(title, "right")  # the bar's own would stand at its foot
        self._hover = HoverTool(renderers=[image])
        chart.figure.add_tools(self._hover)

    def _add_averages(self) -> None:
        colors = self.colors
        label = "Motor units in the same cross-section (1: a single one)"
        chart = self.bars = Chart(colors, label, "Average efficiency [–]", room=320)
        self._means = {}
        for resistance, dash, color, marker in (
            (True, "solid", colors.curves[0], "circle"),
            (False, "dashed", colors.curves[1], "square"),
        ):
            source = chart.source("x", "y", name=f"average_{resistance}".lower())
            legend = f"with{'' if resistance else 'out'} resistance"
            line = Line(x="x", y="y", line_color=color, line_dash=dash, line_width=2.4)
            chart.draw(source, line, legend)
            chart.draw(source, Scatter(x="x", y="y", fill_color=color, line_color=color,
                                       marker=marker, size=9), legend)  # fmt: skip
            self._means[resistance] = source
        chart.figure.xaxis.ticker = list(COUNTS)
        chart.add_legend("bottom_right")

    def _show(self, result: Maps) -> None:
        self._result = result
        self._replace_card(0)
        self._show_map(result)
        view = self.session.view
        self.message.show("")
        self._numbers.object = html_table(
            ("this bundle", "average efficiency"),
            [("with resistance", f"{result.resisted.average:.4f}"),
             ("without", f"{result.free.average:.4f}")],
        )  # fmt: skip
        self._status.object = status_line("computing averages by number of units")
        whole = equivalent_muscle(view)
        self.averages.request(lambda: average_efficiencies(whole, view.supply, view.path))

    def _show_other_map(self) -> None:
        if self._result is not None:
            with pn.io.unlocked():
                self._show_map(self._result)

    def _show_map(self, result: Maps) -> None:
        unit, kind = self.session.view.shown["force"], self._kind.value
        values = result.difference if kind == "difference" else getattr(result, kind).efficiency
        strain, force = result.resisted.strain, result.resisted.force / unit_factor(unit, "force")
        d_strain, d_force = strain[1] - strain[0], force[1] - force[0]
        finite = values[np.isfinite(values)]
        highest = float(finite.max()) if finite.size else 1.0
        lowest = min(0.0, float(finite.min())) if finite.size else 0.0
        self._mapper.update(low=lowest, high=max(highest, 1e-6))
        self._image.data = {
            "image": [np.asarray(values, dtype=np.float32)],
            "x": [strain[0] - d_strain / 2], "y": [force[0] - d_force / 2],
            "dw": [strain[-1] - strain[0] + d_strain], "dh": [force[-1] - force[0] + d_force],
        }  # fmt: skip
        ends = float(strain[-1] + d_strain), float(force[-1] + d_force)
        self.map.set_ranges((0.0, ends[0]), (0.0, ends[1]))
        self.map.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        place = [("ε", "$x{0.000}"), ("F", f"$y{{0.0}} {unit}")]
        self._hover.tooltips = [("η", "@image{0.000}"), *place]

    def _show_averages(self, averages: dict[bool, np.ndarray]) -> None:
        self._replace_card(1)
        for resistance, values in averages.items():
            self._means[resistance].data = {"x": list(COUNTS), "y": values}
        every = np.concatenate(list(averages.values()))
        low, high = float(every.min()), float(every.max())
        room = max(0.1 * (high - low), 0.005)
        self.bars.set_ranges((COUNTS[0] - 0.3, COUNTS[-1] + 0.3), (low - room, high + room))
        self._status.object = ""
