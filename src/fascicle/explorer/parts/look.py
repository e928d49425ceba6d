"""How the explorer looks: colors in light and dark, the page's style, and its figures.

Colors are those of `plot.style`, distinct to the color-blind too; the dark page lightens the
ones that would sink into it. Line styles differ as well, so that no color is needed to read.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure
from matplotlib import colormaps
from matplotlib.colors import to_hex

from ...plot.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION


@dataclass(frozen=True)
class Look:
    """Colors of a page: its `ink` on its `paper`, faint lines, and curves."""

    dark: bool
    ink: str
    paper: str
    faint: str
    muted: str
    accent: str
    cycle: tuple[str, ...]
    families: tuple[float, float]

    def pressures(self, count: int) -> list[str]:
        """Colors for `count` rising pressures [-]."""
        low, high = self.families
        steps = [low + (high - low) * i / max(count - 1, 1) for i in range(count)]
        return [to_hex(colormaps["viridis"](x)) for x in steps]


LIGHT = Look(
    False, "#16191d", "#ffffff", "#e4e7ea", "#5c6670", BLUE,
    (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, "#000000", "#767676"), (0.0, 0.82),
)  # fmt: skip
DARK = Look(
    True, "#eef1f4", "#181b1f", "#33393f", "#a9b3bd", SKY,
    (SKY, "#ff8a3d", "#2bc79b", "#e39fc6", ORANGE, "#7fa8ff", "#ffffff", "#9aa3ab"), (0.25, 1.0),
)  # fmt: skip


def look_of(theme: str) -> Look:
    """The look [-] of the page's `theme` [-]."""
    return DARK if theme == "dark" else LIGHT


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
# rows that go on in a next one
WRAPPED = f":host {{ flex-wrap: wrap !important; }} {NARROW}"


# what holds a figure is as high as it
TALL = ":host { height: auto !important; flex: 0 0 auto !important; }"


def plain_figure(look: Look, x: str, y: str, width: int, height: int, **more: Any) -> Any:
    """A figure `width` × `height` pixels [-], its axes labelled `x` and `y` [-] and fixed.

    Fixed ranges keep the picture still while a slider moves.
    """
    given: dict[str, Any] = {
        "tools": "pan,box_zoom,wheel_zoom,reset",
        "x_range": Range1d(start=0, end=1),
        "y_range": Range1d(start=0, end=1),
        "output_backend": "canvas",
    } | more
    # as wide as there is room, and as high as the screen, within limits
    high = f":host {{ height: clamp(340px, 100vh - 310px, {max(height, 760)}px) !important; }}"
    fig = figure(
        width=width, height=height, sizing_mode="stretch_width", stylesheets=[high], **given
    )
    fig.toolbar.logo = None
    fig.toolbar.autohide = True
    fig.background_fill_color = fig.border_fill_color = look.paper
    fig.outline_line_color = None
    fig.min_border_right = 18
    for axis, label in ((fig.xaxis, x), (fig.yaxis, y)):
        axis.axis_label = label
        axis.axis_label_text_color = axis.major_label_text_color = look.ink
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "14px"
        axis.major_label_text_font_size = "12px"
        axis.axis_line_color = axis.major_tick_line_color = look.muted
        axis.minor_tick_line_color = None
    fig.grid.grid_line_color = look.faint
    return fig


def source_of(columns: Mapping[str, Any], name: str | None = None) -> Any:
    """A source of `columns` [-] for figures, found in the browser by its `name` [-]."""
    return ColumnDataSource(data=dict(columns), name=name)


def legend_style(fig: Any, look: Look, location: str = "top_right") -> None:
    """Make the legend of `fig` [-] quiet and readable; a click hides its curve."""
    fig.legend.location = location
    fig.legend.background_fill_color = look.paper
    fig.legend.background_fill_alpha = 0.85
    fig.legend.border_line_color = None
    fig.legend.label_text_color = look.ink
    fig.legend.label_text_font_size = "12px"
    fig.legend.spacing, fig.legend.padding, fig.legend.margin = 1, 6, 4
    fig.legend.glyph_height, fig.legend.label_height = 14, 16
    fig.legend.click_policy = "hide"


def set_range(axis_range: Any, low: float, high: float) -> None:
    """Show `low` to `high` [shown unit], also after the reset tool."""
    axis_range.update(start=low, end=high, reset_start=low, reset_end=high)


def palette_css(look: Look) -> Mapping[str, str]:
    """The page's colors as CSS variables [-] that Panel's own widgets read as well."""
    return {
        "--panel-background-color": look.paper,
        "--panel-on-background-color": look.ink,
        "--panel-surface-color": look.faint,
        "--panel-on-surface-color": look.ink,
        "--panel-primary-color": look.accent,
        "--panel-border-color": look.muted,
        "--background-color": look.paper,
        "--text-color": look.ink,
        "--bokeh-base-font": "14px/1.4 system-ui, 'DejaVu Sans', sans-serif",
    }


def page_css(look: Look) -> str:
    """The page's style sheet [-]."""
    variables = " ".join(f"{name}: {value};" for name, value in palette_css(look).items())
    return f"""
:root, :host {{ {variables} color-scheme: {"dark" if look.dark else "light"}; }}
html, body {{ margin: 0; background: {look.paper}; color: {look.ink};
  font: 14px/1.4 system-ui, "DejaVu Sans", sans-serif; }}
"""


def widget_css(look: Look) -> str:
    """The style sheet [-] of widgets, each of which lives in a shadow root of its own."""
    return f"""
:host {{ --text-color: {look.ink}; color: {look.ink}; font-size: 14px; }}
.bk-input {{ border: 1px solid {look.muted}; border-radius: 4px; background: {look.paper};
  color: {look.ink}; font-size: 14px; padding: 4px 7px; min-height: 30px; }}
select.bk-input {{ appearance: auto; background-image: none; }}
select.bk-input option {{ background: {look.paper}; color: {look.ink}; }}
.bk-input:focus, .bk-btn:focus-visible, .noUi-handle:focus, .bk-tab:focus-visible,
input:focus-visible, a:focus-visible {{
  outline: 3px solid {look.accent}; outline-offset: 1px; box-shadow: none; }}
label, .bk-slider-title {{ color: {look.ink}; font-size: 13px; }}
.bk-btn {{ border-radius: 4px; font-size: 13px; }}
.bk-btn-default {{ background: {look.paper}; color: {look.ink}; border-color: {look.muted}; }}
.bk-btn-default:hover, .bk-btn-default.bk-active {{ background: {look.faint}; color: {look.ink}; }}
.bk-btn-primary {{ background: {LIGHT.accent}; border-color: {LIGHT.accent}; color: #ffffff; }}
.noUi-target {{ background: {look.faint}; border-color: {look.muted}; box-shadow: none; }}
.noUi-handle {{ background: {look.accent}; border-color: {look.accent}; box-shadow: none;
  border-radius: 50%; }}
.noUi-connect {{ background: {look.accent}; }}
.noUi-handle::before, .noUi-handle::after {{ display: none; }}
.bk-tab {{ color: {look.muted}; font-size: 15px; padding: 6px 16px; }}
.bk-tab.bk-active {{ color: {look.ink}; background: {look.paper}; font-weight: 600;
  border-color: {look.muted}; border-bottom-color: {look.paper}; }}
@media (max-width: 480px) {{ .bk-tab {{ font-size: 13.5px; padding: 6px 8px; }} }}
"""
