"""Style of the explorer: sheets for the page and its widgets, and figures with fixed axes.

Colors, typeface and spacing are those of `plot.theme`, as in figures, reports and docs; the page
sets them as CSS variables, which every widget inherits. Line styles differ as well, so that no
color is needed to read a figure.
"""

from typing import Any
from urllib.parse import quote

from bokeh.core.properties import field, value
from bokeh.models import (
    AllIndices,
    CDSView,
    ColumnDataSource,
    GlyphRenderer,
    LabelSet,
    Legend,
    LegendItem,
    Range1d,
    Selection,
    Span,
    UnionRenderers,
)
from bokeh.models.glyph import Glyph
from bokeh.plotting import figure
from matplotlib import colormaps
from matplotlib.colors import to_hex

from ..plot.theme import DARK, FIGURES, LIGHT, SANS, SMALL, TEXT, WHITE, Colors, css


_VIRIDIS = {False: (0.0, 0.82), True: (0.38, 1.0)}  # part that contrasts with a light, a dark page


def page_colors(theme: str) -> Colors:
    """Colors of a page with the `theme` "dark", or of a light one."""
    return DARK if theme == "dark" else LIGHT


def pressure_colors(colors: Colors, count: int) -> list[str]:
    """Colors for `count` rising pressures on a page of these `colors`."""
    low, high = _VIRIDIS[colors.dark]
    steps = [low + (high - low) * i / max(count - 1, 1) for i in range(count)]
    return [to_hex(colormaps["viridis"](x)) for x in steps]


# rows that become columns on a narrow page, a phone's
STACKED = """
@media (max-width: 860px) {
  :host { flex-direction: column !important; height: auto !important; min-width: 0 !important; }
  :host > div { width: 100% !important; min-width: 0 !important; max-width: 100% !important;
    height: auto !important; flex: 0 0 auto !important; }
}
"""
# Panel keeps a row as wide as all its parts side by side
NARROW = "@media (max-width: 860px) { :host, :host > div { min-width: 0 !important; } }"
# a long column that scrolls beside the figure; a shadow at its end shows that there is more
SCROLLED = """
@media (min-width: 861px) { :host { max-height: calc(100vh - 190px); overflow-y: auto;
  background: linear-gradient(var(--paper), var(--paper)) bottom / 100% 24px no-repeat local,
    linear-gradient(transparent, var(--line)) bottom / 100% 18px no-repeat scroll; } }
"""
# the header: on a phone one row for the file, one for its buttons, one for units
HEADER = """
:host { flex-wrap: wrap !important; }
@media (max-width: 480px) {
  :host { display: grid !important; grid-template-columns: repeat(6, 1fr) !important;
    min-width: 0 !important; }
  :host > div { width: auto !important; min-width: 0 !important; grid-column: span 2; }
  :host > div:nth-of-type(1), :host > div:nth-of-type(2) { grid-column: span 6; }
  :host > div:nth-of-type(3), :host > div:nth-of-type(7) { order: 1; grid-column: span 3;
    margin: 8px !important; }
}
"""
LAST = "@media (max-width: 860px) { :host { order: 2; } }"  # below the figure on a narrow page
WRAPPED = f":host {{ flex-wrap: wrap !important; }} {NARROW}"
# two fields a row; a part with `WHOLE_ROW` takes both places
PAIRS = """
:host { display: grid !important; grid-template-columns: 1fr 1fr; grid-auto-flow: dense;
  align-content: start; }
"""
WHOLE_ROW = {"grid-column": "1 / -1"}
TALL = ":host { height: auto !important; flex: 0 0 auto !important; }"  # as high as its figure


def equal_column() -> dict[str, Any]:
    """Options of a column that is as wide as its neighbors, whatever is in it."""
    return {"sizing_mode": "stretch_width", "styles": {"flex": "1 1 0", "min-width": "0"},
            "stylesheets": [NARROW]}  # fmt: skip


def figure_height(room: int) -> str:
    """Height of a figure in CSS that leaves `room` pixels of the screen."""
    return f"clamp(340px, 100vh - {room}px, 1200px)"


def height_css(height: str) -> str:
    """Style sheet of a figure of a `height` in CSS, whatever holds it."""
    return f":host {{ height: {height} !important; flex: 0 0 auto !important; }}"


class Chart:
    """A figure with labeled axes of fixed ranges, and its sources.

    Fixed ranges keep the picture still while a slider moves. Sources share one selection, and
    glyphs have no second look for selected points: nothing is ever selected, and each model that
    a page has costs the server a few milliseconds.
    """

    def __init__(self, colors: Colors, x: str, y: str, room: int, **options: Any):
        """**Arguments:**

        - `colors`: the page's.
        - `x`, `y`: labels of the axes; empty, it has none.
        - `room`: pixels of the screen that the figure leaves to the rest of the page.
        - `options`: of Bokeh's figure.
        """
        self.colors = colors
        self._selection, self._policy, self._all = Selection(), UnionRenderers(), AllIndices()
        self._entries: list[LegendItem] = []
        defaults: dict[str, Any] = {
            "tools": "pan,box_zoom,wheel_zoom,reset",
            "stylesheets": [height_css(figure_height(room))],
        } | ({} if x else {"x_axis_type": None, "y_axis_type": None})
        fig: Any = figure(
            height=500, sizing_mode="stretch_width", output_backend="canvas",
            x_range=Range1d(start=0, end=1), y_range=Range1d(start=0, end=1),
            **defaults | options,
        )  # fmt: skip
        self.figure = fig
        fig.toolbar.update(logo=None, autohide=True)
        fig.update(
            background_fill_color=colors.paper, border_fill_color=colors.paper,
            outline_line_color=None, min_border_right=18 if x else 0,
        )  # fmt: skip
        for axis, label in ((fig.xaxis[0], x), (fig.yaxis[0], y)) if x else ():
            axis.update(
                axis_label=label, axis_label_text_font=FIGURES, major_label_text_font=FIGURES,
                axis_label_text_color=colors.ink, major_label_text_color=colors.ink,
                axis_label_text_font_style="normal", axis_label_text_font_size="14px",
                major_label_text_font_size="12px", axis_line_color=colors.soft,
                major_tick_line_color=colors.soft, minor_tick_line_color=None,
            )  # fmt: skip
        for grid in fig.grid:
            grid.grid_line_color = colors.line

    def source(self, *columns: str, name: str | None = None) -> Any:
        """An empty source of `columns`; the browser finds it by its `name`."""
        return ColumnDataSource(
            data={column: [] for column in columns}, name=name, selected=self._selection,
            selection_policy=self._policy,
        )  # fmt: skip

    def draw(self, source: Any, glyph: Glyph, legend: str = "") -> GlyphRenderer:
        """Draw a `source` by a `glyph`, with an entry in the `legend`; `@column` for one each."""
        renderer = self.figure.add_glyph(source, glyph, view=CDSView(filter=self._all))
        text: Any = field(legend[1:]) if legend.startswith("@") else value(legend)
        if legend:
            same = [item for item in self._entries if item.label == text]
            if same:
                same[0].renderers = [*same[0].renderers, renderer]
            else:
                self._entries.append(LegendItem(label=text, renderers=[renderer]))
        return renderer

    def add_zero_line(self) -> None:
        """Draw the axis of zero force, of any length."""
        self.figure.add_layout(
            Span(
                location=0,
                dimension="width",
                line_color=self.colors.soft,
                line_width=1,
                level="underlay",
            )
        )

    def tags(self, source: Any, **options: Any) -> None:
        """Write the `label`s of a `source` at its points, readable on every curve."""
        defaults: dict[str, Any] = {"x_offset": 5, "y_offset": 3, "text_font_size": "11px"}
        font: Any = value(FIGURES)  # a bare text would be a column's name
        self.figure.add_layout(LabelSet(
            x="x", y="y", text="label", source=source, text_color=self.colors.ink,
            text_font=font,
            background_fill_color=self.colors.paper, background_fill_alpha=0.8,
            **defaults | options,
        ))  # fmt: skip

    def add_legend(self, location: str = "top_right", glyph_height: int = 14) -> list[LegendItem]:
        """Add the legend, whose entries hide their curves at a click, and return its entries."""
        options: dict[str, Any] = {"padding": 6, "location": location}
        self.figure.add_layout(Legend(
            items=self._entries, **options, background_fill_color=self.colors.paper,
            background_fill_alpha=0.85, border_line_color=None,
            label_text_color=self.colors.ink, label_text_font_size="12px",
            label_text_font=FIGURES, spacing=1, margin=4, glyph_height=glyph_height,
            label_height=16, click_policy="hide",
        ))  # fmt: skip
        return self._entries

    def set_ranges(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Show these ranges [shown unit], also after the reset tool."""
        for axis_range, (low, high) in ((self.figure.x_range, x), (self.figure.y_range, y)):
            axis_range.update(start=low, end=high, reset_start=low, reset_end=high)


def hover_tooltips(axis: str, unit: str) -> list[tuple[str, str]]:
    """Rows of a tooltip above a curve: contraction, and `axis` in a `unit`."""
    return [("ε", "$snap_x{0.0000}"), (axis, f"$snap_y{{0.00}} {unit}")]


def html_legend(curves: list[tuple[str, str, str]]) -> str:
    """A legend that wraps: name, color and CSS line style of each of the `curves`."""
    entries = "".join(
        f'<span style="white-space:nowrap"><i style="display:inline-block;width:26px;'
        f'border-top:3px {line} {color};vertical-align:middle;margin-right:6px"></i>{name}</span>'
        for name, color, line in curves
    )
    style = f"display:flex;flex-wrap:wrap;gap:2px 18px;font-size:{SMALL}px"
    return f'<div style="{style}">{entries}</div>'


def page_variables(colors: Colors) -> dict[str, str]:
    """CSS variables of a page beside those of `plot.theme`: Panel's names, and a list's arrow."""
    # the browser's own arrow is black on dark pages, too
    path = f"<path d='M1 1l4 5 4-5' fill='none' stroke='{colors.ink}' stroke-width='1.6'/>"
    arrow = f"<svg xmlns='http://www.w3.org/2000/svg' width='10' height='8'>{path}</svg>"
    return {
        "--arrow": f'url("data:image/svg+xml,{quote(arrow)}")',
        "--design-background-color": "var(--paper)",
        "--design-background-text-color": "var(--ink)",
        "--design-surface-color": "var(--raised)",
        "--design-surface-text-color": "var(--ink)",
        "--design-primary-color": "var(--accent)",
        "color-scheme": "dark" if colors.dark else "light",
    }


def page_css(colors: Colors) -> str:
    """Style sheet of the page's head, or of its outermost element, as in a notebook."""
    names = " ".join(f"{name}: {value};" for name, value in page_variables(colors).items())
    return f"""
:root, :host {{ {css(colors)} {names} }}
:host, html, body {{ margin: 0; background: var(--paper); color: var(--ink);
  font: {TEXT}px/1.4 var(--sans); }}
"""


WIDGET_CSS = f"""
:host {{ --text-color: var(--ink); --color: var(--ink); color: var(--ink);
  --bokeh-base-font: {TEXT}px/1.4 {SANS.replace('"', "'")}; font: {TEXT}px/1.4 var(--sans); }}
.bk-input {{ border: 1px solid var(--edge); border-radius: var(--round); background: var(--paper);
  color: var(--ink); font: {TEXT}px/1.4 var(--sans); padding: var(--near) var(--apart);
  min-height: 32px; }}
input[type=file].bk-input {{ padding: 1px; height: 32px; }}
input::file-selector-button {{ font: inherit; height: 28px; margin-top: 0; cursor: pointer;
  padding: 0 10px !important; line-height: 26px !important; color: var(--ink);
  background: var(--raised); border: 1px solid var(--line); border-radius: var(--round);
  margin-right: var(--apart); }}
input::file-selector-button:hover {{ background: var(--line) !important; color: var(--ink); }}
select.bk-input:not([multiple]) {{ appearance: none; padding-right: 26px;
  background: var(--paper) var(--arrow) no-repeat right 8px center; }}
select.bk-input option {{ background: var(--paper); color: var(--ink); }}
.bk-input:focus, .bk-btn:focus-visible, .noUi-handle:focus, .bk-tab:focus-visible,
input:focus-visible, a:focus-visible {{
  outline: 3px solid var(--accent); outline-offset: 1px; box-shadow: none; }}
label, .bk-slider-title {{ color: var(--ink); font-size: {SMALL}px; }}
.bk-btn {{ border-radius: var(--round); font: {SMALL}px/1.4 var(--sans); }}
.bk-btn-default {{ background: var(--raised); color: var(--ink); border: 1px solid var(--line); }}
.bk-btn-default:hover, .bk-btn-default.bk-active {{ border-color: var(--edge);
  background: var(--line); color: var(--ink); }}
.bk-btn.bk-btn-primary {{ background: var(--deep) !important; border-color: var(--deep);
  color: {WHITE} !important; }}
.bk-btn.bk-btn-default:disabled, .bk-btn.bk-btn-primary:disabled {{ opacity: 1;
  color: var(--soft) !important; background: var(--paper) !important; cursor: not-allowed;
  border: 1px dashed var(--edge) !important; }}
.noUi-target {{ background: var(--line); border-color: var(--edge); box-shadow: none; }}
.noUi-handle {{ background: var(--accent); border-color: var(--accent); box-shadow: none;
  border-radius: 50%; }}
.noUi-connect {{ background: var(--accent) !important; }}
.noUi-handle::before, .noUi-handle::after {{ display: none; }}
.bk-header {{ border-bottom: 1px solid var(--line) !important; }}
.bk-tab {{ color: var(--soft); font-size: 15px; padding: 6px 16px; border: none;
  border-bottom: 3px solid transparent; background: none; }}
.bk-tab:hover {{ color: var(--ink); }}
.bk-tab.bk-active {{ color: var(--ink); background: none; font-weight: 600; border: none;
  border-bottom: 3px solid var(--accent); }}
@media (max-width: 480px) {{ .bk-tab {{ font-size: 13px; padding: 6px 7px; }} }}
"""
