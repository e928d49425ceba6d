"""Figures with labeled axes of fixed ranges, which keep the picture still while a slider moves.

Line styles differ as well as colors, so that no color is needed to read a figure.
"""

import tomllib
from collections.abc import Callable
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
from bokeh.core.properties import value
from bokeh.events import Pan, PanEnd, Press, Tap
from bokeh.models import ColumnDataSource, CustomJS, HoverTool, LabelSet, LegendItem, Range1d, Span
from bokeh.plotting import figure
from matplotlib import colormaps
from matplotlib.colors import to_hex
from numpy.typing import ArrayLike

from ..plot.theme import FIGURES, Colors
from .widgets import LAYOUT_CSS


_STYLES: dict[str, dict[str, Any]] = tomllib.loads(
    Path(__file__).with_name("figures.toml").read_text(encoding="utf-8")
)
_VIRIDIS = {False: (0.0, 0.82), True: (0.38, 1.0)}  # part that contrasts with a light, a dark page
# the server feels a hand in the figure at most every 40 ms, unless a tool of the toolbar has it
_HOLD = """
const drag = cb_obj.event_name.startsWith("pan");
if (cb_obj.x == null || drag && figure.toolbar.gestures.pan.active) return;
const now = performance.now(), kind = cb_obj.event_name;
// a drag ends where it last was: one that the browser takes over to scroll ends at (0, 0)
if (kind !== "panend") hand.place = {x: [cb_obj.x], y: [cb_obj.y]};
if (kind === "pan" && now - (hand.last ?? 0) < 40) return;
hand.last = now;
hand.data = hand.place;
"""
# a finger moves the point sideways, and scrolls the page up and down; the layer of events is in
# another shadow tree, but a browser does only what all elements around it allow
_TOUCH = ":host { touch-action: pan-y; }"
# arguments of glyphs that are columns' names
_COLUMNS: dict[str, dict[str, str]] = {
    "line": {},
    "multi_line": {"xs": "xs", "ys": "ys", "line_color": "color"},
    "patches": {"xs": "xs", "ys": "ys"},
    "quad": {"left": "left", "right": "right"},
    "scatter": {"x": "x", "y": "y"},
    "segment": {"x0": "x", "y0": "y", "x1": "x", "y1": "place"},
    "text": {"x": "x", "y": "y", "text": "label"},
}


def pressure_colors(colors: Colors, count: int) -> list[str]:
    """Colors for `count` rising pressures on a page of these `colors`."""
    low, high = _VIRIDIS[colors.dark]
    return [to_hex(colormaps["viridis"](x)) for x in np.linspace(low, high, max(count, 2))][:count]


def unit_colors(colors: Colors, count: int) -> list[str]:
    """Colors of `count` motor units, blue and orange first; they come again where they are few."""
    return list(islice(cycle(colors.curves), count))


def other_colors(colors: Colors, count: int) -> list[str]:
    """Colors of `count` curves, never blue or orange; their line styles differ, too."""
    return list(islice(cycle((*colors.curves[2:4], colors.soft, colors.ink)), count))


def screen_height(margin: int) -> str:
    """Height of a figure in CSS that leaves a `margin` of so many pixels on the screen."""
    # on a phone little higher than wide: the sliders stay on the screen
    height = f"clamp(340px, min(100vh - {margin}px - var(--story, 0px), 110vw), 1200px)"
    return f"var(--figure-height, {height})"  # of the story on a phone


def hover_tooltips(unit: str) -> list[tuple[str, str]]:
    """Rows of a tooltip above a curve: contraction, and force in a `unit`."""
    return [("ε", "$snap_x{0.0000}"), ("F", f"$snap_y{{0.00}} {unit}")]


def padded_range(values: ArrayLike, fraction: float, minimum: float = 0.0) -> tuple[float, float]:
    """Range of `values`, wider on both sides by a `fraction` of it, and by `minimum` or more."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    gap = max(fraction * (high - low), minimum)
    return low - gap, high + gap


class Chart:
    """A figure and its sources, in the style of `figures.toml`."""

    def __init__(self, colors: Colors, x: str, y: str, height: str, **options: Any):
        """Figure with axes labeled `x` and `y`, or none, and a `height` in CSS."""
        self.colors = colors
        fig: Any = figure(
            x_range=Range1d(start=0, end=1),
            y_range=Range1d(start=0, end=1),
            x_axis_type="auto" if x else None,
            y_axis_type="auto" if y else None,
            stylesheets=[f":host {{ height: {height} !important; flex: 0 0 auto !important; }}"],
            active_drag=None,
            **self._style("figure") | options,
        )
        self.figure = fig
        self.describe(f"{y} over {x}" if x else "Drawing")
        fig.toolbar.update(logo=None, autohide=True)
        fig.update(min_border_right=18 if x else 0, **self._style("ground"))
        for axis, label in zip(fig.axis, (x, y), strict=False):
            axis.update(axis_label=label, **self._style("axis"))
        for grid in fig.grid:
            grid.grid_line_color = colors.line

    def _style(self, name: str) -> dict[str, Any]:
        return {
            key: getattr(self.colors, entry[1:]) if str(entry).startswith("@") else entry
            for key, entry in _STYLES[name].items()
        }

    def describe(self, text: str) -> None:
        """Say what the figure shows, for those who don't see it."""
        self.figure.html_attributes = {"role": "figure", "aria-label": text}

    def new_pane(self) -> pn.pane.Bokeh:
        style = {"css_classes": ["figure"], "stylesheets": [LAYOUT_CSS]}
        return pn.pane.Bokeh(self.figure, margin=0, **style)

    def new_source(self, columns: str, name: str | None = None) -> Any:
        """An empty source with `columns`, such as "x y"; tests find it by its `name`."""
        return ColumnDataSource(data={column: [] for column in columns.split()}, name=name)

    def add(self, style_name: str, name: str = "", source: Any = None, **style: Any) -> Any:
        """Draw a `source`, by default a new one of the same `name`, in a style; returns it."""
        options = self._style(style_name) | style
        kind, columns = options.pop("kind"), options.pop("columns")
        source = source or self.new_source(columns, name or style_name)
        getattr(self.figure, kind)(source=source, **_COLUMNS[kind] | options)
        return source

    def add_zero_line(self) -> None:
        """Draw the axis of zero force, of any length."""
        line = Span(location=0, dimension="width", line_color=self.colors.soft, level="underlay")
        self.figure.add_layout(line)

    def add_labels(self, source: Any, **options: Any) -> None:
        """Write the `label`s of a `source` at its points, readable on every curve."""
        font: Any = value(FIGURES)  # a bare text would be a column's name
        place: dict[str, Any] = {"x": "x", "y": "y", "text": "label", "text_font": font}
        style = place | self._style("labels") | options
        self.figure.add_layout(LabelSet(source=source, **style))

    def add_hover(self, tooltips: list[tuple[str, str]], **options: Any) -> HoverTool:
        """Add and return a tool with `tooltips` on the glyph that was drawn last."""
        tool = HoverTool(renderers=[self.figure.renderers[-1]], tooltips=tooltips, **options)
        self.figure.add_tools(tool)
        return tool

    def add_force_hover(self) -> HoverTool:
        """Add and return a tool that shows strain and force of the curve that was drawn last."""
        return self.add_hover(hover_tooltips("N"), mode="vline", line_policy="interp")

    def on_hold(self, callback: Callable[[float, float], None]) -> None:
        """Call `callback` with the place [shown units] of each click, and of a hand that drags."""
        hand = self.new_source("x y")
        code = CustomJS(args={"hand": hand, "figure": self.figure}, code=_HOLD)
        for event in (Tap, Press, Pan, PanEnd):
            self.figure.js_on_event(event, code)
        self.figure.stylesheets = [*self.figure.stylesheets, _TOUCH]
        hand.on_change("data", lambda _attr, _old, new: callback(new["x"][0], new["y"][0]))

    def style_legend(self, **options: Any) -> list[LegendItem]:
        """Style the legend, whose entries hide their curves at a click, and return its entries."""
        (legend,) = self.figure.legend
        legend.update(**self._style("legend") | options)
        return legend.items

    def set_ranges(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Show these ranges [shown unit], also after the reset tool."""
        for axis_range, (low, high) in ((self.figure.x_range, x), (self.figure.y_range, y)):
            axis_range.update(start=low, end=high, reset_start=low, reset_end=high)
