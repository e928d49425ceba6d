"""Style of the page: colors, style sheets, and rows and columns that follow the window's width.

Colors, typeface and spacing are those of `plot.theme`, as in figures, reports and docs; the page
sets them as CSS variables, which every widget inherits. The sheets tell kinds of rows, columns and
panes apart by their classes.
"""

from pathlib import Path
from typing import Any
from urllib.parse import quote

import panel as pn

from ..plot.theme import DARK, LARGE, LIGHT, SMALL, TEXT, WHITE, Colors, css


_FOLDER = Path(__file__).parent
WIDGET_CSS = (_FOLDER / "widgets.css").read_text(encoding="utf-8")
LAYOUT_CSS = (_FOLDER / "layout.css").read_text(encoding="utf-8")


def page_colors(theme: str) -> Colors:
    """Colors of a page with the `theme` "dark", or of a light one."""
    return DARK if theme == "dark" else LIGHT


def column(*parts: Any, kind: str = "", **options: Any) -> Any:
    """A column as wide as there is room, of some `kind`: "equal" width, or "pairs" of fields."""
    return _layout(pn.Column, parts, f"narrow {kind}", options)


def side_column(*parts: Any, width: int) -> Any:
    """A scrolling column of inputs, below the figure on a narrow page; `width` in pixels."""
    options = {"width": width, "margin": (0, 8, 0, 0), "sizing_mode": None}
    return _layout(pn.Column, parts, "side", options)


def row(*parts: Any, kind: str = "stacked", **options: Any) -> Any:
    """A row as wide as there is room; a "stacked" one is a column on a narrow page."""
    return _layout(pn.Row, parts, kind, options)


def _layout(layout: Any, parts: Any, kind: str, options: dict[str, Any]) -> Any:
    """Panel's `layout` of `parts` with the classes `kind`; `options` before the page's own."""
    defaults = {"margin": 0, "sizing_mode": "stretch_width", "stylesheets": [LAYOUT_CSS]}
    return layout(*parts, css_classes=kind.split(), **defaults | options)


def pane(text: str = "", margin: Any = (0, 8), **options: Any) -> Any:
    """A pane of HTML."""
    return pn.pane.HTML(text, margin=margin, **{"stylesheets": [LAYOUT_CSS]} | options)


def height_css(height: str) -> str:
    """Style sheet of a figure of a `height` in CSS, whatever holds it."""
    return f":host {{ height: {height} !important; flex: 0 0 auto !important; }}"


def page_css(colors: Colors) -> str:
    """Style sheet of a whole page, for its head or, in a notebook, for its root element."""
    # the browser's own arrow of a list is black on dark pages, too
    path = f"<path d='M1 1l4 5 4-5' fill='none' stroke='{colors.ink}' stroke-width='1.6'/>"
    arrow = f"<svg xmlns='http://www.w3.org/2000/svg' width='10' height='8'>{path}</svg>"
    return f"""
:root, :host {{ {css(colors)}
  --small: {SMALL}px; --text: {TEXT}px; --large: {LARGE}px; --on-deep: {WHITE};
  --arrow: url("data:image/svg+xml,{quote(arrow)}");
  --design-background-color: var(--paper); --design-background-text-color: var(--ink);
  --design-surface-color: var(--raised); --design-surface-text-color: var(--ink);
  --design-primary-color: var(--accent); color-scheme: {"dark" if colors.dark else "light"}; }}
:host, html, body {{ margin: 0; background: var(--paper); color: var(--ink);
  font: {TEXT}px/1.4 var(--sans); }}
"""
