"""Widgets of the explorer: quantities with units, buttons, tables, and messages in page words."""

import html
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import panel as pn

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line
from ..units import DIMENSIONS, parse
from .theme import WHOLE_ROW, WIDGET_CSS


_STEPS = {"kPa": 1.0, "psi": 0.2, "bar": 0.01}
_HIDDEN_LABEL = "label { position: absolute; left: -9999px; }"  # for screen readers alone
_PERIOD = 120  # ms from step to step of a sweep
SWEEP_STEPS = 80  # from one end to the other
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
# of arguments in the library's messages, the labels on the page
_LABELS = {
    "length": "Length at rest", "outer_radius": "Bladder radius", "count": "Number of muscles",
    "wall_thickness": "Wall thickness", "braid_angle": "Braid angle", "radius": "Radius",
    "supply": "Supply pressure", "supply_pressure": "Supply pressure", "units": "Motor units",
    "pressure": "Pressure", "strain": "Contraction ε", "rest_length": "Rest length",
    "splits": "Splits", "compare": "Compare with", "fit": "What to fit",
}  # fmt: skip


def unit_factor(unit: str, dimension: str) -> float:
    """SI value [SI] of one `unit` of a `dimension`."""
    return float(DIMENSIONS[dimension].factors[unit])


def format_quantity(value: float, unit: str, dimension: str, digits: int = 6) -> str:
    """A `value` [SI] in a `unit`, as a field shows it."""
    return f"{value / unit_factor(unit, dimension):.{digits}g} {unit}".strip()


def parse_field(text: str, dimension: str, unit: str, name: str) -> float:
    """Quantity [SI] in the `text` of a field; a bare number is in the field's `unit`.

    **Raises:** `ValueError` in the library's words.
    """
    bare = text.strip()
    try:
        float(bare)
    except ValueError:
        return parse(bare, dimension, name)
    return parse(f"{bare} {unit}".strip(), dimension, name)


def message_in_units(text: str, units: Mapping[str, str]) -> str:
    """A message with its amounts in the units that the page shows, six digits each.

    **Arguments:**

    - `text`: the library's message, with amounts such as `0.008 m` or `(0, 1] m`.
    - `units`: units shown, by dimension.
    """
    for dimension, unit in units.items():
        kind = DIMENSIONS[dimension]
        for written in {kind.si, kind.shown} - {unit, ""}:
            by = float(kind.factors[written]) / float(kind.factors[unit])
            # no unit that only begins like it: m², m/s, N*m
            amount = rf"(?<![\w.])({_NUMBER})(?:, ({_NUMBER}))?([\])]?) {re.escape(written)}"
            text = re.sub(
                rf"{amount}(?![\w/*^·²³])",
                lambda match, by=by, unit=unit: (
                    ", ".join(f"{float(x) * by:.6g}" for x in match.groups()[:2] if x)
                    + f"{match[3]} {unit}"
                ),
                text,
            )
    return text


def page_message(
    error: ValueError | str, units: Mapping[str, str] | None = None, **labels: str
) -> str:
    """A message of the library with the page's `labels` for arguments, and its units."""
    names = _LABELS | labels
    text = re.sub(r"`(\w+)`", lambda match: names.get(match[1], match[0]), str(error))
    return message_in_units(text, units or {})


class Message:
    """A line for an error, below what it is about; it takes its place once there is one."""

    def __init__(self, column: Any, after: Any = None):
        """**Arguments:** `column`: that it stands in; `after`: the part above it, or the last."""
        self.column, self._after, self._pane = column, after, None

    @property
    def text(self) -> str:
        """HTML of the line; empty where there is no error."""
        return "" if self._pane is None else str(self._pane.object)

    def show(self, error: ValueError | str, units: Mapping[str, str] | None = None) -> None:
        """Show an `error` in the page's labels and `units`, or nothing where it is empty."""
        text = page_message(error, units)
        if self._pane is None:
            if not text:
                return
            self._pane = pane((0, 8, 4, 8), sizing_mode="stretch_width", styles=WHOLE_ROW)
        if text and self._pane not in self.column.objects:
            parts = self.column.objects
            index = len(parts) if self._after is None else parts.index(self._after) + 1
            self.column.insert(index, self._pane)
        red = "color:var(--bad);background:var(--alarm);border-left:3px solid var(--bad)"
        style = f"{red};padding:3px 8px;font-size:12.5px;border-radius:2px"
        clean = html.escape(sanitize_line(text))
        self._pane.object = f'<div role="alert" style="{style}">{clean}</div>' if text else ""
        self._pane.visible = bool(text)


def widget(kind: Any, label: str, **options: Any) -> Any:
    """A Panel widget of a `kind` in the page's style, as wide as there is room."""
    defaults = {"sizing_mode": None if "width" in options else "stretch_width", "margin": (2, 8)}
    sheets = [WIDGET_CSS, *options.pop("stylesheets", [])]
    return kind(label=label, stylesheets=sheets, **defaults | options)


def dropdown(label: str, options: Mapping[str, str] | Iterable[str], **more: Any) -> Any:
    """A drop-down list of `options`, by label where it is a mapping."""
    choices = dict(options) if isinstance(options, Mapping) else list(options)
    return widget(pn.widgets.Select, label, options=choices, **more)


def button(label: str, on_click: Callable[[], None] | None, **options: Any) -> Any:
    """A button that calls `on_click`."""
    made = widget(pn.widgets.Button, label, **{"sizing_mode": None} | options)
    if on_click is not None:
        made.on_click(lambda _: on_click())
    return made


def pane(margin: Any = (0, 8), **options: Any) -> Any:
    """An empty HTML pane."""
    return pn.pane.HTML("", margin=margin, **options)


class Field:
    """A text field of a quantity with its unit; errors appear below it."""

    def __init__(
        self, label: str, name: str, dimension: str, set_value: Callable[[float], None],
        **options: Any,
    ):  # fmt: skip
        """**Arguments:**

        - `label`: above the field.
        - `name`: argument of the value in the library's messages.
        - `dimension`: of the value.
        - `set_value`: takes the value [SI]; its `ValueError` appears below the field.
        - `options`: of the widget.
        """
        self.label, self.name, self._dimension, self._set = label, name, dimension, set_value
        self._unit, self._updating = "", False
        self.input = widget(pn.widgets.TextInput, label, **options)
        self.message: Message | None = None
        self.input.param.watch(self._on_input, "value")

    def place(self, column: Any, after: Any = None) -> None:
        """Show errors in the `column`, below the field or the part `after`."""
        self.message = Message(column, after or self.input)

    @property
    def error(self) -> str:
        """HTML of the error; empty where there is none."""
        return self.message.text if self.message else ""

    def show(self, value: float, unit: str) -> None:
        """Show a `value` [SI] in a `unit`."""
        self._unit, self._updating = unit, True
        self.input.value = format_quantity(value, unit, self._dimension, 5)
        self._updating = False
        self.refuse("")

    def refuse(self, error: ValueError | str) -> None:
        """Show an `error` below the field, in its unit and by its label."""
        if self.message:
            text = page_message(error, {self._dimension: self._unit}, **{self.name: self.label})
            self.message.show(text)

    def _on_input(self, event: Any) -> None:
        if self._updating:
            return
        try:
            self._set(parse_field(event.new, self._dimension, self._unit, self.name))
            self.refuse("")
        except ValueError as error:
            self.refuse(error)


class StepSlider(pn.widgets.FloatSlider):
    """A slider whose every step counts at once; Panel's own waits 50 ms for the next one."""

    _debounce = 1


class QuantitySlider:
    """A slider with a field beside it, for one quantity in the unit shown."""

    def __init__(
        self, label: str, name: str, dimension: str, set_value: Callable[[float], None]
    ):  # fmt: skip
        """**Arguments:** those of `Field`."""
        self._label, self._dimension, self._set = label, dimension, set_value
        self._unit, self._top, self._end, self._updating = "", 1.0, 1.0, False
        self.slider = widget(
            StepSlider, label, start=0, end=1, step=0.01, show_value=False, margin=(4, 14, 4, 12)
        )
        self.field = Field(f"{label}, typed", name, dimension, self._on_field, width=106,
                           margin=(8, 8, 0, 8), stylesheets=[_HIDDEN_LABEL])  # fmt: skip
        self.field.label = label
        self.slider.param.watch(self._on_slider, "value")
        row = pn.Row(self.slider, self.field.input, margin=0, sizing_mode="stretch_width")
        self.panel = pn.Column(row, margin=0, sizing_mode="stretch_width", styles=WHOLE_ROW)
        self.field.place(self.panel, row)

    def show(self, value: float, unit: str, top: float) -> None:
        """Show a `value` [SI] of at most `top` [SI] in a `unit`."""
        scale = unit_factor(unit, self._dimension)
        step = _STEPS.get(unit, 0.001)
        end = float(f"{top / scale:.9g}")  # no step further than the top
        self._updating = True
        if (unit, end) != (self._unit, self._end):
            self._unit, self._end = unit, end
            label = f"{self._label} [{unit or '–'}]"
            self.slider.param.update(label=label, start=0, end=end, step=step)
        self._top = top
        position = value / scale
        if abs(self.slider.value - position) > step / 2:
            self.slider.value = float(np.clip(position, 0, end))
        self.field.show(value, unit)
        self._updating = False

    def _on_slider(self, event: Any) -> None:
        if not self._updating:
            # decimals as they are read: 0.1 kPa × 3 is 0.3 kPa; the end is the top's, which no
            # decimals of this unit may be
            value = parse(f"{event.new:.9g} {self._unit}".strip(), self._dimension)
            self._take(self._top if event.new >= self._end else min(value, self._top))

    def _on_field(self, value: float) -> None:
        scale = unit_factor(self._unit, self._dimension)
        if not 0 <= value <= self._top * (1 + 1e-6):  # typed with six digits, it may round up
            rule = f"must lie in [0, {self._top / scale:.6g}] {self._unit or '-'}"
            given = f"{value / scale:.6g} {self._unit}".strip()
            raise InvalidInputError(self.field.name, rule, value, shown=given)
        self._take(min(value, self._top))

    def _take(self, value: float) -> None:
        try:
            self._set(value)
        except ValueError as error:
            self.field.refuse(error)


class Sweep:
    """A button that moves a value on, step by step, until it is pressed again."""

    def __init__(self, label: str, step: Callable[[], bool]):
        """**Arguments:** `label`: of what is swept; `step`: moves it, and is false at the end."""
        self._step, self._timer = step, None
        self.button = widget(pn.widgets.Toggle, "", margin=(4, 8), sizing_mode=None)
        self.set_label(label)
        self.button.param.watch(self._on_toggle, "value")

    def set_label(self, label: str) -> None:
        """Name what is swept."""
        self.button.label = f"▶ Sweep {label}"

    def _on_toggle(self, event: Any) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if event.new and pn.state.curdoc is not None:
            self._timer = pn.state.add_periodic_callback(self._advance, period=_PERIOD)

    def _advance(self) -> None:
        if not self._step():
            self.button.value = False


def heading(text: str) -> str:
    """A small title in HTML."""
    style = "font-weight:600;font-size:13px;margin:10px 0 2px"
    return f'<div style="{style}">{html.escape(text)}</div>'


def status_line(text: str) -> str:
    """A quiet line in HTML that says what is going on."""
    return f'<div role="status" style="font-size:13px;opacity:.8">{text}</div>' if text else ""


def volume_text(value: float, length: str) -> str:
    """A volume [m³] in the unit that goes with a unit of `length`."""
    if length == "in":
        return f"{value / unit_factor('in', 'length') ** 3:.4g} in³"
    return f"{value * 1e6:.4g} cm³"


def moment_text(value: float, units: Mapping[str, str]) -> str:
    """A moment [N·m] in the `units` of force and length, meters for millimeters."""
    length = "m" if units["length"] == "mm" else units["length"]
    scale = unit_factor(units["force"], "force") * unit_factor(length, "length")
    return f"{value / scale:.4g} {units['force']}·{length}"


def readout_table(rows: Mapping[str, str]) -> str:
    """A table in HTML of names and values."""
    texts = {name: f"−{text[1:]}" if text[:1] == "-" else text for name, text in rows.items()}
    cells = "".join(
        f'<tr><th style="text-align:left;font-weight:400;opacity:.75;padding:1px 14px 1px 0">{name}'
        f'</th><td style="font-variant-numeric:tabular-nums">{text}</td></tr>'
        for name, text in texts.items()
    )
    return f'<table style="font-size:13.5px;border-collapse:collapse">{cells}</table>'


def html_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in HTML with a row of `heads`."""
    style = "padding:2px 14px 2px 0;text-align:left;font-variant-numeric:tabular-nums"
    top = "".join(f'<th style="{style};font-weight:600">{head}</th>' for head in heads)
    body = "".join(
        "<tr>" + "".join(f'<td style="{style}">{cell}</td>' for cell in row) + "</tr>"
        for row in rows
    )
    return f'<table style="font-size:13.5px;border-collapse:collapse"><tr>{top}</tr>{body}</table>'
