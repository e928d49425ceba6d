"""Widgets of the explorer: quantities with units, buttons, tables, and messages in page words."""

import html
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import panel as pn

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line
from ..units import DIMENSIONS, parse
from .theme import WIDGET_CSS, column, pane, row


# label and dimension of each size of a muscle
SIZES = {
    "length": ("Length at rest", "length"),
    "outer_radius": ("Bladder radius", "length"),
    "wall_thickness": ("Wall thickness", "length"),
    "braid_angle": ("Braid angle", "angle"),
}
_STEPS = {"kPa": 1.0, "psi": 0.2, "bar": 0.01}  # of a slider, in its unit: a percent at most
_STRAIN_STEP = 0.001  # of a slider: two pixels
WHOLE_ROW: dict[str, Any] = {"css_classes": ["whole-row"]}  # of a "pairs" column
_SWEEP_PERIOD = 120  # ms from step to step: slow enough to see a muscle fold
_INVALID_CSS = ".bk-input { border: 2px solid var(--bad); }"
SWEEP_STEPS = 80  # from one end to the other
# in a message of the library
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"
# labels on the page of arguments in the library's messages
_LABELS = {
    "length": "Length at rest", "outer_radius": "Bladder radius", "count": "Number of muscles",
    "wall_thickness": "Wall thickness", "braid_angle": "Braid angle", "radius": "Radius",
    "supply": "Supply pressure", "supply_pressure": "Supply pressure", "units": "Motor units",
    "pressure": "Pressure", "pressures": "Pressures", "strain": "Contraction ε",
    "rest_length": "Rest length",
    "fit": "What to fit", "scheme": "Recruitment", "path": "Path", "show": "Units",
    "plate_distance": "Distance between the plates", "load": "Load",
}  # fmt: skip


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
    if length_unit == "in":
        return "in³", unit_factor("in", "length") ** 3
    return "cm³", 1e-6


def parse_field(text: str, dimension: str, unit: str, name: str) -> float:
    """Quantity [SI] in the `text` of a field; a bare number is in the field's `unit`."""
    bare = text.strip()
    try:
        float(bare)
    except ValueError:
        return parse(bare, dimension, name)
    return parse(f"{bare} {unit}".strip(), dimension, name)


def message_in_units(text: str, units: Mapping[str, str]) -> str:
    """A `text` of the library, its amounts in the page's `units`, by dimension."""
    for dimension, unit in units.items():
        kind = DIMENSIONS[dimension]
        for written in {kind.si, kind.common} - {unit, ""}:
            scale = float(kind.factors[written]) / float(kind.factors[unit])

            def convert(match: re.Match[str], scale: float = scale, unit: str = unit) -> str:
                numbers = (f"{float(x) * scale:.6g}" for x in match.groups()[:2] if x)
                return f"{', '.join(numbers)}{match[3]} {unit}"

            # no unit that only begins like it: m², m/s, N*m
            amount = rf"(?<![\w.])({_NUMBER})(?:, ({_NUMBER}))?([\])]?) {re.escape(written)}"
            text = re.sub(rf"{amount}(?![\w/*^·²³])", convert, text)
    return text


def page_message(
    error: ValueError | str, units: Mapping[str, str] | None = None, **labels: str
) -> str:
    """A message of the library with the page's `labels` for arguments, and its units."""
    names = _LABELS | labels
    if isinstance(error, InvalidInputError):
        names = {error.argument: error.argument.replace("_", " ").capitalize()} | names
    text = re.sub(r"`(\w+)`", lambda match: names.get(match[1], match[0]), str(error))
    return message_in_units(text, units or {})


class Message:
    """A line for an error, visible while there is one."""

    def __init__(self) -> None:
        self.pane = pane(
            margin=(0, 8, 4, 8), sizing_mode="stretch_width", visible=False, **WHOLE_ROW
        )

    @property
    def text(self) -> str:
        """HTML of the error that is shown, or empty."""
        return str(self.pane.object)

    def show(
        self, error: ValueError | str, units: Mapping[str, str] | None = None, **labels: str
    ) -> None:
        """Show an `error` in the page's `labels` and `units`, or nothing where it is empty."""
        text = text_html(sanitize_line(page_message(error, units, **labels)))
        line = f'<div role="alert">{text}</div>' if text else ""
        self.pane.param.update(object=line, visible=bool(text))

    @contextmanager
    def errors(self, units: Mapping[str, str] | None = None, **labels: str) -> Iterator[None]:
        """Show a `ValueError` of the block as `show` does, or nothing where there is none."""
        try:
            yield
            self.show("")
        except ValueError as error:
            self.show(error, units, **labels)


def decode_upload(raw: bytes, name: str, kind: str, limit: int) -> str:
    """Text of an uploaded file of a `kind`; `ValueError` with its `name` for an empty file, one
    above the `limit` in bytes, and one that isn't UTF-8.
    """
    if not raw:
        raise ValueError(f"{name}: the file is empty, 0 bytes.")
    if len(raw) > limit:
        raise ValueError(f"{name}: a {kind} file may have {limit} bytes, got {len(raw)}.")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{name}: not a text file in UTF-8.") from None


def widget(
    kind: Any, label: str, on_change: Callable[[Any], object] | None = None, **options: Any
) -> Any:
    """A Panel widget of a `kind` in the page's style, as wide as there is room.

    `on_change` is called with its new value.
    """
    defaults = {"sizing_mode": None if "width" in options else "stretch_width", "margin": (2, 8)}
    result = kind(label=label, stylesheets=[WIDGET_CSS], **defaults | options)
    if on_change is not None:
        result.param.watch(lambda event: on_change(event.new), "value")
    return result


def dropdown(
    label: str,
    options: Mapping[str, str] | Iterable[str],
    on_change: Callable[[str], object] | None = None,
    **more: Any,
) -> Any:
    """A drop-down list of `options`, by label where it is a mapping."""
    choices = dict(options) if isinstance(options, Mapping) else list(options)
    return widget(pn.widgets.Select, label, on_change, options=choices, **more)


def file_input(
    label: str, accept: str, on_file: Callable[[bytes, str], object], **options: Any
) -> Any:
    """A button that opens a file, of which `on_file` takes the bytes and the name."""

    def open_file(*_: Any) -> None:
        if result.value or result.filename:
            on_file(result.value or b"", str(result.filename or "file")[-60:])

    result = widget(pn.widgets.FileInput, label, accept=accept, **options)
    # an empty file changes nothing but the name
    result.param.watch(open_file, ["value", "filename"])
    return result


def button(label: str, on_click: Callable[[], None] | None, **options: Any) -> Any:
    """A button that calls `on_click`."""
    result = widget(pn.widgets.Button, label, **{"sizing_mode": None} | options)
    if on_click is not None:
        result.on_click(lambda _: on_click())
    return result


class Field:
    """A text field of a quantity with its unit; errors appear below it."""

    def __init__(
        self, label: str, name: str, dimension: str, set_value: Callable[[Any], None],
        optional: bool = False, **options: Any,
    ):  # fmt: skip
        """Field of an argument's `name`; a `ValueError` of `set_value` appears below it.

        An `optional` one may be empty, for `None`.
        """
        self.label, self.name, self._dimension, self._set = label, name, dimension, set_value
        self._optional, self._unit, self._text = optional, "", ""
        self.input = widget(pn.widgets.TextInput, label, self._on_input, **options)
        self.message = Message()
        self.widgets = (self.input, self.message.pane)

    def show(self, value: float | None, unit: str) -> None:
        """Show a `value` [SI] in a `unit`, or none."""
        text = "" if value is None else format_quantity(value, unit, self._dimension, 5)
        self._unit, self._text = unit, text
        self.input.value = self._text
        self._clear()

    def _clear(self) -> None:
        """Take back the error, if there is one."""
        self.message.show("")
        self.input.stylesheets = [WIDGET_CSS]

    def show_error(self, error: ValueError | str) -> None:
        """Show an `error` below the field, whose border is red, in its unit and by its label."""
        self.input.stylesheets = [WIDGET_CSS, _INVALID_CSS]
        self.message.show(error, {self._dimension: self._unit}, **{self.name: self.label})

    def _on_input(self, text: str) -> None:
        if text == self._text:  # the page's own, or typed again after an error
            self._clear()
            return
        try:
            value = None
            if text.strip() or not self._optional:
                value = parse_field(text, self._dimension, self._unit, self.name)
            self._set(value)
            self.show(value, self._unit)
        except ValueError as error:
            self.show_error(error)


class _StepSlider(pn.widgets.FloatSlider):
    """A slider whose every step counts at once; Panel's own waits 50 ms for the next one."""

    _debounce = 1


class QuantitySlider:
    """A slider with a field beside it, for one quantity in the unit shown."""

    def __init__(self, label: str, name: str, dimension: str, set_value: Callable[[float], None]):
        self._label, self._dimension, self._set = label, dimension, set_value
        self._unit, self._top, self._updating = "", 1.0, False
        self.slider = widget(
            _StepSlider, label, self._on_slider, start=0, end=1, step=0.01, show_value=False,
            margin=(4, 14, 4, 12),
        )  # fmt: skip
        self.field = Field(f"{label}, typed", name, dimension, self._on_field, width=106,
                           margin=(8, 8, 0, 8), css_classes=["hidden-label"])  # fmt: skip
        self.field.label = label
        inputs = row(self.slider, self.field.input, kind="")
        self.panel = column(inputs, self.field.message.pane, kind="whole-row")

    def show(self, value: float, unit: str, top: float) -> None:
        """Show a `value` [SI] of at most `top` [SI] in a `unit`."""
        scale, step = unit_factor(unit, self._dimension), _STEPS.get(unit, _STRAIN_STEP)
        end = float(f"{top / scale:.9g}")  # no step further than the top
        self._updating, self._unit, self._top = True, unit, top
        label = f"{self._label} [{unit or '–'}]"
        self.slider.param.update(label=label, end=end, step=step)
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
        scale = unit_factor(self._unit, self._dimension)
        if not 0 <= value <= self._top * (1 + 1e-6):  # typed with six digits, it may round up
            rule = f"must lie in [0, {self._top / scale:.6g}] {self._unit or '-'}"
            value_text = f"{value / scale:.6g} {self._unit}".strip()
            raise InvalidInputError(self.field.name, rule, value, shown=value_text)
        self._set(min(value, self._top))


class Sweep:
    """A button that moves a value on, step by step, until it is pressed again."""

    def __init__(self, label: str, step: Callable[[], bool]):
        """Sweep of the value of a `label`; `step` moves it, and returns False at the end."""
        self._step, self._timer = step, None
        self.button = widget(
            pn.widgets.Toggle, "", self._on_toggle, margin=(4, 8), sizing_mode=None
        )
        self.set_label(label)

    def set_label(self, label: str) -> None:
        """Name the value."""
        self.button.label = f"▶ Sweep {label}"

    def _on_toggle(self, pressed: bool) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if pressed and pn.state.curdoc is not None:
            self._timer = pn.state.add_periodic_callback(self._advance, period=_SWEEP_PERIOD)

    def _advance(self) -> None:
        """Move the value a step, and release the button at the end."""
        if not self._step():
            self.button.value = False


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


def html_legend(curves: list[tuple[str, str, str]]) -> str:
    """A legend that wraps: name, color and CSS line style of each of the `curves`."""
    entries = "".join(
        f'<span><i style="border-top-style:{line};border-top-color:{color}"></i>{name}</span>'
        for name, color, line in curves
    )
    return f'<div class="legend">{entries}</div>'
