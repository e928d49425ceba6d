"""Style and widgets of the page: rows and columns, quantities with units, buttons, tables, errors.

Colors, typeface and spacing are those of `plot.theme`, as in figures, reports and docs; the page
sets them as CSS variables, which every widget inherits.
"""

import asyncio
import html
import io
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import panel as pn

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line
from ..plot.theme import DARK, LARGE, LIGHT, SMALL, TEXT, WHITE, Colors, css
from ..units import DIMENSIONS, parse


_FOLDER = Path(__file__).parent
WIDGET_CSS = (_FOLDER / "widgets.css").read_text(encoding="utf-8")
LAYOUT_CSS = (_FOLDER / "layout.css").read_text(encoding="utf-8")
# label and dimension of each size of a muscle
SIZES = {
    "length": ("Length at rest", "length"),
    "outer_radius": ("Bladder radius", "length"),
    "wall_thickness": ("Wall thickness", "length"),
    "braid_angle": ("Braid angle", "angle"),
}
_STEPS = {"kPa": 1.0, "psi": 0.2, "bar": 0.01}  # of a slider, in its unit: a percent at most
_STRAIN_STEP = 0.001  # of a slider: two pixels
_INVALID_CSS = ":host .bk-input { border: 2px solid var(--bad) !important; }"
# labels on the page of arguments in the library's messages
_LABELS = {name: label for name, (label, _) in SIZES.items()} | {
    "count": "Number of muscles",
    "supply": "Supply pressure",
    "units": "Motor units",
    "strain": "Contraction ε",
    "scheme": "Recruitment",
}


def page_colors(theme: str) -> Colors:
    """Colors of a page with the `theme` "dark", or of a light one."""
    return DARK if theme == "dark" else LIGHT


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


def column(*parts: Any, kind: str = "", **options: Any) -> Any:
    """A column as wide as there is room, of some `kind`: "equal" width, or "pairs" of fields."""
    return pn.Column(*parts, **_layout(f"narrow {kind}", options))


def side_column(*parts: Any, width: int) -> Any:
    """A scrolling column of inputs, below the figure on a narrow page; `width` in pixels."""
    options = {"width": width, "margin": (0, 8, 0, 0), "sizing_mode": None}
    return pn.Column(*parts, **_layout("side", options))


def row(*parts: Any, kind: str = "stacked", **options: Any) -> Any:
    """A row as wide as there is room; a "stacked" one is a column on a narrow page."""
    return pn.Row(*parts, **_layout(kind, options))


def _layout(kind: str, options: dict[str, Any]) -> dict[str, Any]:
    """Options of a layout with the classes `kind`; `options` before the page's own."""
    defaults = {"margin": 0, "sizing_mode": "stretch_width", "stylesheets": [LAYOUT_CSS]}
    return {"css_classes": kind.split()} | defaults | options


def fold(title: str, *parts: Any, kind: str = "", **options: Any) -> Any:
    """A column of a button with a `title`, and of the `parts` that it shows and hides, a row of
    them where their `kind` is "wrapped".
    """
    layout = row if kind == "wrapped" else column
    content = layout(*parts, kind=kind, visible=False)
    toggle = widget(pn.widgets.Toggle, title, **{"margin": (4, 8), "sizing_mode": None} | options)
    toggle.link(content, value="visible")
    return column(toggle, content)


def pane(text: str = "", margin: Any = (0, 8), **options: Any) -> Any:
    """A pane of HTML."""
    return pn.pane.HTML(text, margin=margin, **{"stylesheets": [LAYOUT_CSS]} | options)


def wide_pane(text: str = "", **options: Any) -> Any:
    """A pane of HTML as wide as there is room."""
    return pane(text, sizing_mode="stretch_width", **options)


def unit_factor(unit: str, dimension: str) -> float:
    """Value [SI] of one `unit` of a `dimension`."""
    return float(DIMENSIONS[dimension].factors[unit])


def field_unit(dimension: str, display_units: Mapping[str, str]) -> str:
    """Unit of a field of a `dimension`: the one that the page shows, else the common one."""
    return display_units.get(dimension, DIMENSIONS[dimension].common)


def format_quantity(value: float, unit: str, dimension: str, digits: int = 6) -> str:
    """A `value` [SI] in a `unit`, as a field shows it."""
    return f"{value / unit_factor(unit, dimension):.{digits}g} {unit}".strip()


def volume_unit(length_unit: str) -> tuple[str, float]:
    """Unit of a volume beside lengths in a `length_unit`, and its value [m³]."""
    return ("in³", unit_factor("in", "length") ** 3) if length_unit == "in" else ("cm³", 1e-6)


def parse_field(text: str, dimension: str, unit: str, name: str) -> float:
    """Quantity [SI] in the `text` of a field; a bare number is in the field's `unit`."""
    text = text.strip()
    with suppress(ValueError):
        float(text)
        text = f"{text} {unit}".strip()
    return parse(text, dimension, name)


def check_limit(value: float, top: float, name: str, dimension: str, unit: str) -> None:
    """Raise `InvalidInputError` in the shown `unit` for a `value` [SI] outside of [0, `top`]."""
    if not 0 <= value <= top * (1 + 1e-6):  # typed with six digits, it may round up
        rule = f"must lie in [0, {top / unit_factor(unit, dimension):.6g}] {unit or '-'}"
        text = format_quantity(value, unit, dimension)
        raise InvalidInputError(name, rule, value, shown=text)


def page_message(error: ValueError | str, **labels: str) -> str:
    """A message of the library in one line, with the page's labels for arguments."""
    line = str(error)
    if isinstance(error, InvalidInputError):
        default = error.argument.replace("_", " ").capitalize()
        labels = _LABELS | labels
        line = error.line(labels.get(error.argument, default))
        line = re.sub(r"`(\w+)`", lambda name: labels.get(name[1], name[0]), line)
    return sanitize_line(line)


class Message:
    """A line for an error, visible while there is one."""

    def __init__(self) -> None:
        self.pane = wide_pane(margin=(0, 8, 4, 8), visible=False, css_classes=["whole-row"])

    @property
    def text(self) -> str:
        return str(self.pane.object)

    def show(self, error: ValueError | str, **labels: str) -> None:
        """Show an `error` in the page's `labels`, or nothing where it is empty."""
        text = text_html(page_message(error, **labels))
        line = f'<div role="alert">{text}</div>' if text else ""
        self.pane.param.update(object=line, visible=bool(text))

    @contextmanager
    def errors(self) -> Iterator[None]:
        """Show a `ValueError` of the block, or nothing where there is none."""
        try:
            yield
            self.show("")
        except ValueError as error:
            self.show(error)


def widget(
    kind: type[pn.widgets.Widget],
    label: str,
    on_change: Callable[[Any], object] | None = None,
    **options: Any,
) -> Any:
    """A Panel widget in the page's style, as wide as there is room."""
    defaults = {"sizing_mode": None if "width" in options else "stretch_width", "margin": (2, 8)}
    result = kind(label=label, stylesheets=[WIDGET_CSS], **defaults | options)
    if on_change is not None:
        result.param.watch(lambda event: on_change(event.new), "value")
    return result


def dropdown(
    label: str,
    options: dict[str, str] | Iterable[str],
    on_change: Callable[[str], object] | None = None,
    **more: Any,
) -> Any:
    """A drop-down list of `options`, by label where it is a dictionary."""
    choices = options if isinstance(options, dict) else list(options)
    return widget(pn.widgets.Select, label, on_change, options=choices, **more)


def file_input(
    label: str, accept: str, on_file: Callable[[bytes, str], object], **options: Any
) -> Any:
    """A button that opens a file; `on_file` takes its bytes and name."""

    def open_file(*_: object) -> None:
        if result.value or result.filename:
            on_file(result.value or b"", str(result.filename or "file")[-60:])

    result = widget(pn.widgets.FileInput, label, accept=accept, **options)
    # an empty file changes nothing but the name
    result.param.watch(open_file, ["value", "filename"])
    return result


def decode_upload(raw: bytes, name: str, limit: int) -> str:
    """Text of an uploaded file; `ValueError` for none, more bytes than the `limit`, or no UTF-8."""
    if not raw:
        raise ValueError(f"{name}: the file is empty, 0 bytes.")
    if len(raw) > limit:
        raise ValueError(f"{name}: the file may have {limit} bytes, got {len(raw)}.")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{name}: not a text file in UTF-8.") from None


def button(label: str, on_click: Callable[[], object] | None, **options: Any) -> Any:
    """A button that calls `on_click`."""
    result = widget(pn.widgets.Button, label, **{"sizing_mode": None} | options)
    if on_click is not None:
        result.on_click(lambda _: on_click())
    return result


def download_button(
    label: str, content: Callable[[], tuple[str, bytes]], message: Message, **options: Any
) -> Any:
    """Button that downloads the file of `content`, or shows in a `message` why there is none."""

    def make_file() -> io.BytesIO:
        try:
            result.filename, raw = content()
        except ValueError as error:
            message.show(error)
            raise asyncio.CancelledError from None  # nothing to send
        message.show("")
        return io.BytesIO(raw)

    style = {"filename": "fascicle", "width": 150, "margin": (2, 4)} | options
    result = widget(pn.widgets.FileDownload, label, callback=make_file, **style)
    return result


class Field:
    """A text field of the argument `name`: a quantity of a `dimension`, with its unit, or a text
    without one; a `ValueError` of `set_value` appears below it. An `optional` one may be empty, for
    `None`.
    """

    def __init__(
        self,
        label: str,
        name: str,
        dimension: str,
        set_value: Callable[[Any], object],
        optional: bool = False,
        **options: Any,
    ):
        self.label, self.name, self._dimension, self._set = label, name, dimension, set_value
        self._optional, self._unit, self._text = optional, "", ""
        self.input = widget(pn.widgets.TextInput, label, self._on_input, **options)
        self.message = Message()
        self.widgets = (self.input, self.message.pane)

    def show(self, value: float | str | None, unit: str) -> None:
        """Show a `value` [SI] in a `unit`, a text, or nothing."""
        if self.message.pane.visible:  # a slider shows a value at each step
            self.show_error("")
        self._show_value(value, unit)

    def _show_value(self, value: float | str | None, unit: str) -> None:
        if value is None or isinstance(value, str):
            text = value or ""
        else:
            text = format_quantity(value, unit, self._dimension, 5)
        self._unit, self._text, self.input.value = unit, text, text

    def show_error(self, error: ValueError | str) -> None:
        """Show an `error` below the field, whose border is red; nothing where it is empty."""
        self.input.stylesheets = [WIDGET_CSS, *[_INVALID_CSS] * bool(error)]
        self.message.show(error, **{self.name: self.label})

    def _on_input(self, text: str) -> None:
        if text == self._text:  # the page's own, or typed again after an error
            self.show_error("")
            return
        try:
            value: float | str | None = text.strip()
            if not value and self._optional:
                value = None
            elif self._dimension:
                value = parse_field(text, self._dimension, self._unit, self.name)
            self.show_error("")
            self._set(value)  # whose result may be an error of this field
            self._show_value(value, self._unit)
        except ValueError as error:
            self.show_error(error)


class _StepSlider(pn.widgets.FloatSlider):
    """A slider whose every step counts at once; Panel's own waits 50 ms for the next one."""

    _debounce = 1


class QuantitySlider:
    """A slider with a field beside it, for one quantity in the unit shown."""

    def __init__(self, label: str, name: str, dimension: str, set_value: Callable[[float], object]):
        self._label, self._dimension, self._set = label, dimension, set_value
        self._unit, self._top, self._updating = "", 1.0, False
        style = {"step": 0.01, "show_value": False, "margin": (4, 14, 4, 12)}
        self.slider = widget(_StepSlider, label, self._on_slider, start=0, end=1, **style)
        style = {"width": 106, "margin": (8, 8, 0, 8), "css_classes": ["hidden-label"]}
        self.field = Field(f"{label}, typed", name, dimension, self._on_field, **style)
        self.field.label = label
        inputs = row(self.slider, self.field.input, kind="")
        self.panel = column(inputs, self.field.message.pane, kind="whole-row")

    def show(self, value: float, unit: str, top: float) -> None:
        """Show a `value` [SI] of at most `top` [SI] in a `unit`."""
        scale, step = unit_factor(unit, self._dimension), _STEPS.get(unit, _STRAIN_STEP)
        end = float(f"{top / scale:.9g}")  # no step further than the top
        self._updating, self._unit, self._top = True, unit, top
        self.slider.param.update(label=f"{self._label} [{unit or '–'}]", end=end, step=step)
        position = value / scale
        if abs(self.slider.value - position) > step / 2:
            self.slider.value = float(np.clip(position, 0, end))
        self.field.show(value, unit)
        self._updating = False

    def _on_slider(self, position: float) -> None:
        if self._updating:
            return
        # decimals as they are read: 0.1 kPa × 3 is 0.3 kPa; the end is the top's, which no
        # decimals of this unit may be
        value = parse(f"{position:.9g} {self._unit}".strip(), self._dimension)
        try:
            self._set(self._top if position >= self.slider.end else min(value, self._top))
        except ValueError as error:
            self.field.show_error(error)

    def _on_field(self, value: float) -> None:
        check_limit(value, self._top, self.field.name, self._dimension, self._unit)
        self._set(min(value, self._top))


def text_html(text: str) -> str:
    """A `text` in HTML, with what stands between backticks as code."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", html.escape(text))


def heading(text: str) -> str:
    """A small title in HTML."""
    return f'<div class="heading">{html.escape(text)}</div>'


def status_line(text: str) -> str:
    """A quiet line in HTML on the state of a computation; `text` isn't escaped."""
    return f'<div role="status">{text}</div>' if text else ""


def readout_table(rows: Mapping[str, str]) -> str:
    """A table in HTML of names and values, which aren't escaped."""
    texts = {name: f"−{text[1:]}" if text[:1] == "-" else text for name, text in rows.items()}
    lines = "".join(f"<tr><th>{name}</th><td>{text}</td></tr>" for name, text in texts.items())
    return f'<table class="readout">{lines}</table>'


def html_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in HTML with a row of `heads`; cells are HTML and aren't escaped."""
    lines = [f"<th>{'</th><th>'.join(heads)}</th>"]
    lines += [f"<td>{'</td><td>'.join(row)}</td>" for row in rows]
    return f"<table><tr>{'</tr><tr>'.join(lines)}</tr></table>"


def html_legend(curves: Sequence[tuple[str, str, str]]) -> str:
    """A legend that wraps: name, color and CSS line style of each of the `curves`."""
    form = '<span><i style="border-top-style:{2};border-top-color:{1}"></i>{0}</span>'
    return f'<div class="legend">{"".join(form.format(*curve) for curve in curves)}</div>'
