"""Style of the page: colors, style sheets, and rows and columns that follow the window's width.

Colors, typeface and spacing are those of `plot.theme`, as in figures, reports and docs; the page
sets them as CSS variables, which every widget inherits.
"""

from typing import Any
from urllib.parse import quote

import panel as pn

from ..plot.theme import DARK, LIGHT, SANS, SMALL, TEXT, WHITE, Colors, css


# rows that become columns on a narrow page, a phone's
_STACKED = """
@media (max-width: 860px) {
  :host { flex-direction: column !important; height: auto !important; min-width: 0 !important; }
  :host > div { width: 100% !important; min-width: 0 !important; max-width: 100% !important;
    height: auto !important; flex: 0 0 auto !important; }
}
"""
# Panel keeps a row as wide as all its parts side by side
NARROW = "@media (max-width: 860px) { :host, :host > div { min-width: 0 !important; } }"
# a long column that scrolls beside the figure; a shadow at its end shows that there is more
_SCROLLED = """
@media (min-width: 861px) { :host { max-height: calc(100vh - 190px); overflow-y: auto;
  background: linear-gradient(var(--paper), var(--paper)) bottom / 100% 24px no-repeat local,
    linear-gradient(transparent, var(--line)) bottom / 100% 18px no-repeat scroll; } }
"""
_BELOW_FIGURE = "@media (max-width: 860px) { :host { order: 2; } }"
# on a phone one row for the file, one for its buttons, one for units
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
WRAPPED = f":host {{ flex-wrap: wrap !important; }} {NARROW}"
# two fields a row; a widget with `WHOLE_ROW` takes both columns
PAIRS = """
:host { display: grid !important; grid-template-columns: 1fr 1fr; grid-auto-flow: dense;
  align-content: start; }
"""
WHOLE_ROW = {"grid-column": "1 / -1"}
_FILL: dict[str, Any] = {"margin": 0, "sizing_mode": "stretch_width"}


def page_colors(theme: str) -> Colors:
    """Colors of a page with the `theme` "dark", or of a light one."""
    return DARK if theme == "dark" else LIGHT


def column(*parts: Any, **options: Any) -> Any:
    """A column as wide as there is room."""
    return pn.Column(*parts, **_FILL | {"stylesheets": [NARROW]} | options)


def equal_column(*parts: Any) -> Any:
    """A column as wide as its neighbors, whatever its content."""
    return column(*parts, styles={"flex": "1 1 0", "min-width": "0"})


def side_column(*parts: Any, width: int) -> Any:
    """A scrolling column of inputs, below the figure on a narrow page; `width` in pixels."""
    sheets = [_SCROLLED, _BELOW_FIGURE]
    return pn.Column(*parts, width=width, margin=(0, 8, 0, 0), stylesheets=sheets)


def row(*parts: Any, **options: Any) -> Any:
    """A row as wide as there is room, a column on a narrow page."""
    return pn.Row(*parts, **_FILL | {"stylesheets": [_STACKED]} | options)


def height_css(height: str) -> str:
    """Style sheet of a figure of a `height` in CSS, whatever holds it."""
    return f":host {{ height: {height} !important; flex: 0 0 auto !important; }}"


def page_css(colors: Colors) -> str:
    """Style sheet of the page's head, or of its outermost element, as in a notebook."""
    # the browser's own arrow of a list is black on dark pages, too
    path = f"<path d='M1 1l4 5 4-5' fill='none' stroke='{colors.ink}' stroke-width='1.6'/>"
    arrow = f"<svg xmlns='http://www.w3.org/2000/svg' width='10' height='8'>{path}</svg>"
    return f"""
:root, :host {{ {css(colors)}
  --arrow: url("data:image/svg+xml,{quote(arrow)}");
  --design-background-color: var(--paper); --design-background-text-color: var(--ink);
  --design-surface-color: var(--raised); --design-surface-text-color: var(--ink);
  --design-primary-color: var(--accent); color-scheme: {"dark" if colors.dark else "light"}; }}
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
