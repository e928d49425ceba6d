"""Fields and sliders of quantities: text with a unit, and the library's own words beside it."""

import html
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import panel as pn

from ..io.sanitize import sanitize_line
from ..units import DIMENSIONS, parse
from .theme import Look, widget_css


_STEPS = {"kPa": 1.0, "psi": 0.2, "bar": 0.01}
_UNSEEN_LABEL = "label { position: absolute; left: -9999px; }"  # read aloud, not shown


class Slider(pn.widgets.FloatSlider):
    """A slider whose every step counts at once: Panel's own waits 50 ms for the next one."""

    _debounce = 1


def factor(unit: str, dimension: str) -> float:
    """SI value [SI] of one `unit` [-] of a `dimension` [-]."""
    return float(DIMENSIONS[dimension].factors[unit])


def shown(value: float, unit: str, dimension: str, digits: int = 6) -> str:
    """A `value` [SI] in a `unit` [-], as a field shows it."""
    return f"{value / factor(unit, dimension):.{digits}g} {unit}".strip()


def read(text: str, dimension: str, unit: str, name: str) -> float:
    """What a field's `text` [-] says [SI]; a bare number is in the `unit` [-] shown.

    **Raises:** `ValueError`, in the library's words.
    """
    bare = text.strip()
    try:
        float(bare)
    except ValueError:
        return parse(bare, dimension, name)
    return parse(f"{bare} {unit}".strip(), dimension, name)


class Message:
    """A line for what is wrong, right below the field that it is about."""

    def __init__(self, name: str):
        """**Arguments:** `name`: the field's [-]."""
        self.name = name
        self.pane = pn.pane.HTML(
            "", visible=False, sizing_mode="stretch_width", margin=(0, 8, 4, 8)
        )

    @property
    def text(self) -> str:
        """What it says [-]."""
        return str(self.pane.object)

    def say(self, text: str) -> None:
        """Show `text` [-], or nothing where it is empty."""
        red = "color:var(--bad);background:var(--alarm);border-left:3px solid var(--bad)"
        style = f"{red};padding:3px 8px;font-size:12.5px;border-radius:2px"
        clean = html.escape(sanitize_line(text))
        self.pane.object = f'<div role="alert" style="{style}">{clean}</div>' if text else ""
        self.pane.visible = bool(text)


class Field:
    """A quantity as text with its unit. What can't be read is said below it."""

    def __init__(
        self, look: Look, label: str, name: str, dimension: str, set_value: Callable[[float], None]
    ):
        """**Arguments:**

        - `look`: the page's [-].
        - `label`: above it [-].
        - `name`: of the value, as the library's messages have it [-].
        - `dimension`: of the value [-].
        - `set_value`: takes the value [SI]; its `ValueError` is said at the field.
        """
        self.name, self._dimension, self._set = name, dimension, set_value
        self._unit, self._silent = "", False
        self.input = pn.widgets.TextInput(
            label=label, stylesheets=[widget_css(look)], sizing_mode="stretch_width", margin=(2, 8)
        )
        self.message = Message(name)
        self.input.param.watch(self._typed, "value")
        self.panel = pn.Column(self.input, self.message.pane, margin=0, sizing_mode="stretch_width")

    def show(self, value: float, unit: str) -> None:
        """Show a `value` [SI] in a `unit` [-]."""
        self._unit, self._silent = unit, True
        self.input.value = shown(value, unit, self._dimension, 5)
        self._silent = False
        self.message.say("")

    def _typed(self, event: Any) -> None:
        if self._silent:
            return
        try:
            self._set(read(event.new, self._dimension, self._unit, self.name))
            self.message.say("")
        except ValueError as error:
            self.refuse(error)

    def refuse(self, error: ValueError) -> None:
        """Say an `error` [-] below it, in the unit shown."""
        self.message.say(in_units(str(error), {self._dimension: self._unit}))


class Dial:
    """A slider with a field beside it, for one quantity in the unit shown."""

    def __init__(
        self, look: Look, label: str, name: str, dimension: str, set_value: Callable[[float], None]
    ):
        """**Arguments:** those of `Field` [-]."""
        self._label, self._dimension, self._set = label, dimension, set_value
        self._unit, self._top, self._end, self._silent = "", 1.0, 1.0, False
        css = widget_css(look)
        self.slider = Slider(
            label=label, start=0, end=1, step=0.01, show_value=False, stylesheets=[css],
            sizing_mode="stretch_width", margin=(4, 14, 4, 12),
        )  # fmt: skip
        self.field = Field(look, f"{label}, typed", name, dimension, self._typed)
        self.field.input.stylesheets = [css, _UNSEEN_LABEL]
        self.field.input.width, self.field.panel.width = 106, 130
        self.field.input.sizing_mode = self.field.panel.sizing_mode = None
        self.field.input.margin = (8, 8, 0, 8)
        self.slider.param.watch(self._slid, "value")
        row = pn.Row(self.slider, self.field.input, margin=0, sizing_mode="stretch_width")
        self.panel = pn.Column(row, self.field.message.pane, margin=0, sizing_mode="stretch_width")

    def show(self, value: float, unit: str, top: float) -> None:
        """Show a `value` [SI] of at most `top` [SI] in a `unit` [-]."""
        scale = factor(unit, self._dimension)
        step = _STEPS.get(unit, 0.001)
        end = float(f"{top / scale:.9g}")  # no step further than can be
        title = f"{self._label} [{unit or '–'}]"
        self._silent = True
        if (unit, end) != (self._unit, self._end):
            self._unit, self._end = unit, end
            self.slider.param.update(label=title, start=0, end=end, step=step)
        self._top = top
        at = value / scale
        if abs(self.slider.value - at) > step / 2:
            self.slider.value = float(np.clip(at, 0, end))
        self.field.show(value, unit)
        self._silent = False

    def _slid(self, event: Any) -> None:
        if not self._silent:
            # decimals as they are read: 0.1 kPa × 3 is 0.3 kPa; the end is the top's, which no
            # decimals of this unit may be
            value = parse(f"{event.new:.9g} {self._unit}".strip(), self._dimension)
            self._take(self._top if event.new >= self._end else min(value, self._top))

    def _typed(self, value: float) -> None:
        scale = factor(self._unit, self._dimension)
        if not 0 <= value <= self._top * (1 + 1e-6):
            raise ValueError(
                f"`{self.field.name}` must lie in [0, {self._top / scale:.6g}]"
                f" {self._unit or '-'}, got {value / scale:.6g} {self._unit}.".replace(" .", ".")
            )
        self._take(min(value, self._top))  # as it is shown, it may round up

    def _take(self, value: float) -> None:
        try:
            self._set(value)
        except ValueError as error:
            self.field.refuse(error)


def choice(look: Look, label: str, options: Mapping[str, str] | Sequence[str], **more: Any) -> Any:
    """A drop-down list [-] named `label` [-] of `options` [-]."""
    given: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (2, 8)} | more
    options = dict(options) if isinstance(options, Mapping) else list(options)
    return pn.widgets.Select(label=label, options=options, stylesheets=[widget_css(look)], **given)


def button(look: Look, label: str, does: Callable[[], None], **more: Any) -> Any:
    """A button [-] named `label` [-] that `does` [-] something."""
    made = pn.widgets.Button(label=label, stylesheets=[widget_css(look)], **more)
    made.on_click(lambda _: does())
    return made


def heading(text: str) -> Any:
    """A small title [-]."""
    style = "font-weight:600;font-size:13px;margin:6px 0 0"
    return pn.pane.HTML(f'<div style="{style}">{html.escape(text)}</div>', margin=(4, 8, 0, 8))


def guarded(message: Message, act: Callable[[], None]) -> None:
    """Do `act` [-]; a `ValueError` is said in `message` [-]."""
    try:
        act()
        message.say("")
    except ValueError as error:
        message.say(str(error))


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"


def in_units(text: str, units: Mapping[str, str]) -> str:
    """A refusal in the units shown.

    **Arguments:**

    - `text`: the library's [-], with amounts such as `0.008 m` or `(0, 1] m`.
    - `units`: shown, by dimension [-].

    **Returns:** the same [-] with its amounts in those units, six digits of each.
    """
    for dimension, unit in units.items():
        kind = DIMENSIONS[dimension]
        for written in {kind.si, kind.shown} - {unit, ""}:
            by = float(kind.factors[written]) / float(kind.factors[unit])
            # no unit that only begins like it: m², m/s, N*m
            found = rf"(?<![\w.])({_NUMBER})(?:, ({_NUMBER}))?([\])]?) {re.escape(written)}"
            text = re.sub(
                rf"{found}(?![\w/*^·²³])",
                lambda match, by=by, unit=unit: (
                    ", ".join(f"{float(x) * by:.6g}" for x in match.groups()[:2] if x)
                    + f"{match[3]} {unit}"
                ),
                text,
            )
    return text


def volume(value: float, length: str) -> str:
    """A volume's `value` [m³] beside lengths in a unit `length` [-]."""
    if length == "in":
        return f"{value / factor('in', 'length') ** 3:.4g} in³"
    return f"{value * 1e6:.4g} cm³"


def moment(value: float, units: Mapping[str, str]) -> str:
    """A moment's `value` [N·m] in the `units` shown [-] of force and length, meters for
    millimeters.
    """
    length = "m" if units["length"] == "mm" else units["length"]
    scale = factor(units["force"], "force") * factor(length, "length")
    return f"{value / scale:.4g} {units['force']}·{length}"


def table(rows: dict[str, str]) -> str:
    """Two columns [-] of what and how much [-]."""
    rows = {what: f"−{told[1:]}" if told[:1] == "-" else told for what, told in rows.items()}
    cells = "".join(
        f'<tr><th style="text-align:left;font-weight:400;opacity:.75;padding:1px 14px 1px 0">{what}'
        f'</th><td style="font-variant-numeric:tabular-nums">{value}</td></tr>'
        for what, value in rows.items()
    )
    return f'<table style="font-size:13.5px;border-collapse:collapse">{cells}</table>'


_PERIOD = 120  # ms from step to step
STEPS = 80  # from one end to the other


class Sweep:
    """The button; `step` is called each time, and says whether to go on."""

    def __init__(self, look: Look, label: str, step: Callable[[], bool]):
        """**Arguments:** `look`: the page's [-]; `label`: what is swept [-]; `step` [-]."""
        self._step, self._timer = step, None
        self.button = pn.widgets.Toggle(stylesheets=[widget_css(look)], margin=(4, 8))
        self.name(label)
        self.button.param.watch(self._pressed, "value")

    def name(self, label: str) -> None:
        """Call it by what is swept: `label` [-]."""
        self.button.label = f"▶ Sweep {label}"

    def _pressed(self, event: Any) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if event.new and pn.state.curdoc is not None:
            self._timer = pn.state.add_periodic_callback(self._on, period=_PERIOD)

    def _on(self) -> None:
        if not self._step():
            self.button.value = False
