"""How the explorer looks: the page's style in light and dark, and its figures.

Colors, typeface and spacing are those of `plot.theme`, as in figures, reports and docs. Line
styles differ as well, so that no color is needed to read.
"""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, LabelSet, Range1d
from bokeh.plotting import figure
from matplotlib import colormaps
from matplotlib.colors import to_hex

from ..plot.theme import DARK, FIGURES, LIGHT, SANS, SMALL, TEXT, WHITE, Colors, css


Look = Colors
_FAMILIES = {False: (0.0, 0.82), True: (0.38, 1.0)}  # of viridis: what can be seen on the page


def look_of(theme: str) -> Look:
    """The look [-] of the page's `theme` [-]."""
    return DARK if theme == "dark" else LIGHT


def pressure_colors(look: Look, count: int) -> list[str]:
    """Colors [-] for `count` rising pressures [-] on a page of a `look` [-]."""
    low, high = _FAMILIES[look.dark]
    steps = [low + (high - low) * i / max(count - 1, 1) for i in range(count)]
    return [to_hex(colormaps["viridis"](x)) for x in steps]


# rows whose parts stand below one another where the page is narrow, as on a phone
STACKED = """
@media (max-width: 860px) {
  :host { flex-direction: column !important; height: auto !important; min-width: 0 !important; }
  :host > div { width: 100% !important; min-width: 0 !important; max-width: 100% !important;
    height: auto !important; flex: 0 0 auto !important; }
}
"""
# Panel lets nothing be narrower than all its parts side by side
NARROW = """
@media (max-width: 860px) { :host, :host > div { min-width: 0 !important; } }
"""
# a long column that rolls beside the picture, where there is room beside it: a shadow at its end
# says that there is more
ROLLED = """
@media (min-width: 861px) { :host { max-height: calc(100vh - 190px); overflow-y: auto;
  background: linear-gradient(var(--paper), var(--paper)) bottom / 100% 24px no-repeat local,
    linear-gradient(transparent, var(--line)) bottom / 100% 18px no-repeat scroll; } }
"""
# the header's fields: on a phone a row for the file, one for what is done with it, one of units
HEADED = """
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
# what stands beside the picture, below it where the page is narrow
AFTER = "@media (max-width: 860px) { :host { order: 2; } }"
# rows that go on in a next one
WRAPPED = f":host {{ flex-wrap: wrap !important; }} {NARROW}"


def half() -> dict[str, Any]:
    """What makes a column [-] one of several that are equally wide, whatever is in them."""
    return {"sizing_mode": "stretch_width", "styles": {"flex": "1 1 0", "min-width": "0"},
            "stylesheets": [NARROW]}  # fmt: skip


# what holds a figure is as high as it
TALL = ":host { height: auto !important; flex: 0 0 auto !important; }"


def plain_figure(look: Look, x: str, y: str, *, room: int = 322, **more: Any) -> Any:
    """A figure whose axes are labelled `x` and `y` [-] and fixed, as wide as there is, and so high
    that `room` pixels [-] of the screen are left.

    Fixed ranges keep the picture still while a slider moves.
    """
    given: dict[str, Any] = {
        "tools": "pan,box_zoom,wheel_zoom,reset",
        "x_range": Range1d(start=0, end=1),
        "y_range": Range1d(start=0, end=1),
        "output_backend": "canvas",
    } | more
    high = high_css(height_of(room))
    fig = figure(height=500, sizing_mode="stretch_width", stylesheets=[high], **given)
    fig.toolbar.logo = None
    fig.toolbar.autohide = True
    fig.background_fill_color = fig.border_fill_color = look.paper
    fig.outline_line_color = None
    fig.min_border_right = 18
    for axis, label in ((fig.xaxis, x), (fig.yaxis, y)):
        axis.axis_label = label
        axis.axis_label_text_font = axis.major_label_text_font = FIGURES
        axis.axis_label_text_color = axis.major_label_text_color = look.ink
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "14px"
        axis.major_label_text_font_size = "12px"
        axis.axis_line_color = axis.major_tick_line_color = look.soft
        axis.minor_tick_line_color = None
    fig.grid.grid_line_color = look.line
    return fig


def height_of(room: int) -> str:
    """How high a figure is in CSS [-] that leaves `room` pixels [-] of the screen."""
    return f"clamp(340px, 100vh - {room}px, 1200px)"


def high_css(height: str) -> str:
    """The style sheet [-] of a figure of a `height` in CSS [-], whatever holds it."""
    return f":host {{ height: {height} !important; flex: 0 0 auto !important; }}"


def source_of(columns: Mapping[str, Any], name: str | None = None) -> Any:
    """A source of `columns` [-] for figures, found in the browser by its `name` [-]."""
    return ColumnDataSource(data=dict(columns), name=name)


def tags(fig: Any, look: Look, source: ColumnDataSource, **more: Any) -> None:
    """Write the `label`s of a `source` [-] at its points of `fig` [-], readable on every curve."""
    given: dict[str, Any] = {"x_offset": 5, "y_offset": 3, "text_font_size": "11px"} | more
    fig.add_layout(LabelSet(
        x="x", y="y", text="label", source=source, text_color=look.ink,
        text_font=value(FIGURES),  # a bare text would be a column's name
        background_fill_color=look.paper, background_fill_alpha=0.8, **given,
    ))  # fmt: skip


def told(axis: str, unit: str) -> list[tuple[str, str]]:
    """What a pointer above a curve is told [-]: contraction, and `axis` in a `unit` [-]."""
    return [("ε", "$snap_x{0.0000}"), (axis, f"$snap_y{{0.00}} {unit}")]


def key(curves: Sequence[tuple[str, str, str]]) -> str:
    """A legend [-] that wraps: of each of the `curves`, name, color and line in CSS [-]."""
    told = "".join(
        f'<span style="white-space:nowrap"><i style="display:inline-block;width:26px;'
        f'border-top:3px {line} {color};vertical-align:middle;margin-right:6px"></i>{name}</span>'
        for name, color, line in curves
    )
    return f'<div style="display:flex;flex-wrap:wrap;gap:2px 18px;font-size:{SMALL}px">{told}</div>'


def legend_style(fig: Any, look: Look, location: str = "top_right") -> None:
    """Make the legend of `fig` [-] quiet and readable; a click hides its curve."""
    fig.legend.location = location
    fig.legend.background_fill_color = look.paper
    fig.legend.background_fill_alpha = 0.85
    fig.legend.border_line_color = None
    fig.legend.label_text_color = look.ink
    fig.legend.label_text_font_size, fig.legend.label_text_font = "12px", FIGURES
    fig.legend.spacing, fig.legend.padding, fig.legend.margin = 1, 6, 4
    fig.legend.glyph_height, fig.legend.label_height = 14, 16
    fig.legend.click_policy = "hide"


def set_range(axis_range: Any, low: float, high: float) -> None:
    """Show `low` to `high` [shown unit], also after the reset tool."""
    axis_range.update(start=low, end=high, reset_start=low, reset_end=high)


def page_css(look: Look) -> str:
    """The page's style sheet [-], in variables that Panel's own widgets read as well."""
    return f"""
:root, :host {{ {css(look)} color-scheme: {"dark" if look.dark else "light"};
  --panel-background-color: var(--paper); --panel-on-background-color: var(--ink);
  --panel-surface-color: var(--raised); --panel-on-surface-color: var(--ink);
  --panel-primary-color: var(--accent); --panel-border-color: var(--edge);
  --background-color: var(--paper); --text-color: var(--ink);
  --bokeh-base-font: {TEXT}px/1.4 {SANS.replace('"', "'")}; }}
html, body {{ margin: 0; background: var(--paper); color: var(--ink);
  font: {TEXT}px/1.4 var(--sans); }}
"""


def widget_css(look: Look) -> str:
    """The style sheet [-] of widgets, each of which lives in a shadow root of its own."""
    return f"""
:host {{ {css(look)} --text-color: var(--ink); --color: var(--ink); color: var(--ink);
  font: {TEXT}px/1.4 var(--sans); }}
.bk-input {{ border: 1px solid var(--edge); border-radius: var(--round); background: var(--paper);
  color: var(--ink); font: {TEXT}px/1.4 var(--sans); padding: var(--near) var(--apart);
  min-height: 32px; }}
input[type=file].bk-input {{ padding: 1px; height: 32px; }}
input::file-selector-button {{ font: inherit; height: 28px; margin-top: 0; cursor: pointer;
  padding: 0 10px !important; line-height: 26px !important;
  color: var(--ink);
  background: var(--raised); border: 1px solid var(--line); border-radius: var(--round);
  margin-right: var(--apart); }}
input::file-selector-button:hover {{ background: var(--line) !important; color: var(--ink); }}
select.bk-input:not([multiple]) {{ appearance: none; padding-right: 26px;
  background: var(--paper) {_arrow(look)} no-repeat right 8px center; }}
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


def _arrow(look: Look) -> str:
    """The sign of a list [-], in CSS: the browser's own is black on dark pages, too."""
    drawn = f"<path d='M1 1l4 5 4-5' fill='none' stroke='{look.ink}' stroke-width='1.6'/>"
    svg = f"<svg xmlns='http://www.w3.org/2000/svg' width='10' height='8'>{drawn}</svg>"
    return f'url("data:image/svg+xml,{quote(svg)}")'
