"""Tab of pinned curves: several muscles' forces in one figure, and a table of their differences."""

import html
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np
import panel as pn

from ..core.validation import HIGHEST_PRESSURE, check_interval
from ..files.shipped_files import named_muscles
from ..plot.theme import DASHES, Colors
from .chart import Chart, cycle_colors, padded_range, screen_height
from .exports import comparison_downloads, download_buttons
from .link import linked_pins
from .muscle_curves import alternative_laws, law_label, with_alternative
from .pins import (
    PinQuantity,
    add_pin,
    pin_curve,
    quantities,
    quantity_texts,
    rename_pin,
    shipped_muscle,
    top_strain,
)
from .remarks import validity_warnings
from .state import Pin, Session, Unit, View, changed
from .tab import Tab
from .theme import column, pane, row, side_column
from .widgets import (
    Field,
    Message,
    button,
    dropdown,
    heading,
    status_line,
    text_html,
    widget,
)


_CURRENT, _OWN_LAWS = "the current one", "as the muscle has them"
_LINE_WIDTH = 2.4  # pixels of a curve; dashes are as many times longer
_ANGLE_STEP = 0.9  # ratio of braid angles of the example: 33 to 29.7 degrees
_EMPTY = (
    "<h2>Compare curves</h2><p>Pin the force of a muscle at a pressure, change the muscle or the"
    " pressure, and pin it again: the curves lie over one another here, and a table shows their"
    " differences. <i>Pin this curve</i> is in the tab Muscle, too.</p>"
)


class PinButton:
    """Button that pins the current muscle's curve at its pressure; `result` is a line about it."""

    def __init__(self, session: Session):
        self._session = session
        self._message = Message()
        self._status = pane(margin=(0, 8), css_classes=["live"])
        pin = button("Pin this curve", self._pin, margin=(8, 8, 2, 8))
        self.panel = column(pin, sizing_mode=None)
        self.result = column(self._status, self._message.pane)

    def _pin(self) -> None:
        """Pin the muscle shown at its pressure, or show an error below."""
        view, self._status.object = self._session.view, ""
        with self._message.errors():
            _pin_muscle(self._session, view.name, view.muscle, view.pressure)
            name = html.escape(self._session.view.pins[-1].name)
            self._status.object = f'<p class="small">Pinned in Compare as “{name}”.</p>'


class PinForm:
    """Inputs of a curve to pin: the current or a shipped muscle, a law, and a pressure."""

    def __init__(self, session: Session):
        self._session, self._view_pressure, self._pressure_value = session, -1.0, 0.0
        names = [_CURRENT, *named_muscles()]
        self._muscle = dropdown("Muscle", names, lambda _: self._offer_laws())
        self._law = dropdown("Laws", [_OWN_LAWS])
        self._pressure = Field("Pressure P", "pressure", "pressure", self._set_pressure)
        self._message = Message()
        pin = button("Pin this curve", self._pin, color="primary")
        self.widgets = (
            self._muscle, self._law, *self._pressure.widgets, pin, self._message.pane,
        )  # fmt: skip

    def show(self, view: View) -> None:
        """Show the laws and units of a `view`, and its pressure if it is another one."""
        if view.pressure != self._view_pressure:
            self._view_pressure = self._pressure_value = view.pressure
        self._pressure.show(self._pressure_value, view.display_units["pressure"])
        self._offer_laws()

    def _selected_muscle(self) -> Any:
        name = self._muscle.value
        return self._session.view.muscle if name == _CURRENT else shipped_muscle(name)

    def _offer_laws(self) -> None:
        keys = alternative_laws(self._selected_muscle())
        options = {_OWN_LAWS: "", **{law_label(key): key for key in keys}}
        law = self._law.value if self._law.value in options.values() else ""
        self._law.param.update(options=options, value=law)

    def _set_pressure(self, value: float) -> None:
        closed = (True, True)
        check_interval(value, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", closed)
        self._pressure_value = value

    def _pin(self) -> None:
        view, muscle = self._session.view, self._selected_muscle()
        name = view.name if self._muscle.value == _CURRENT else self._muscle.value
        with self._message.errors():
            if self._law.value:
                muscle = with_alternative(muscle, self._law.value)
            _pin_muscle(self._session, name, muscle, self._pressure_value)


class CompareView(Tab):
    """Widgets and figure of pinned curves."""

    name: ClassVar[str] = "compare"
    fields: ClassVar[tuple[str, ...]] = ("pins", "muscle", "pressure", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors)
        self._form = PinForm(session)
        self._names: list[Any] = []
        self._rows = column()
        self._strain = self.strain_slider("Contraction ε to compare at")
        chart = self.chart = Chart(
            colors, "Contraction ε [–]", "Force F [N]", screen_height(430)
        )  # room for header, slider, legend and the head of the table
        chart.add_zero_line()
        self._curves = chart.add(
            "multi_line", "xs ys color dash label", "compared", line_dash="dash",
            line_width=_LINE_WIDTH,
        )  # fmt: skip
        self._hover = chart.add_hover("")
        self._points = chart.add(
            "scatter", "x y color", "compared_points", size=11, marker="diamond",
            line_color=colors.paper, fill_color="color",
        )  # fmt: skip
        chart.on_click(self._move_strain)
        self._legend = pane(sizing_mode="stretch_width", margin=(4, 8))
        self._table = pane(sizing_mode="stretch_width", margin=(8, 8))
        pinned = (self._strain.panel, self._legend, chart.new_pane(), self._table)
        downloads = row(
            *download_buttons(
                lambda: comparison_downloads(session.view, session.input_names),
                self.download_message,
            ),
            kind="wrapped", sizing_mode=None,
        )  # fmt: skip
        self._comparison = column(self.notes, *pinned, downloads, self.download_message.pane)
        example = button("Try two braid angles", self.pin_example)
        self._empty = column(pane(_EMPTY), example, kind="framed")
        side = side_column(
            pane(heading("Pin another curve")), *self._form.widgets, self._rows, self.message.pane,
            width=318,
        )  # fmt: skip
        self.panel = row(side, column(self._empty, self._comparison))

    @property
    def _colors(self) -> list[str]:
        """Colors of curves, in their order."""
        return cycle_colors(self.colors, len(DASHES))

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        self._form.show(view)
        self._show_rows(view)
        self.message.show("")
        exist = bool(view.pins)
        self._empty.visible, self._comparison.visible = not exist, exist
        if not exist:
            return
        unit, scale = self.unit("force")
        top = top_strain(view.pins)
        curves = [pin_curve(pin.muscle, pin.pressure, top) for pin in view.pins]
        number = len(curves)
        self._curves.data = {
            "xs": [curve.strain for curve in curves],
            "ys": [curve.force / scale for curve in curves],
            "color": self._colors[:number],
            "dash": [_dash(i) for i in range(number)],
            "label": [pin.name for pin in view.pins],
        }
        forces = np.concatenate([curve.force for curve in curves]) / scale
        self.chart.set_ranges((0.0, top), padded_range(forces, 0.06))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = [
            ("", "@label"), ("ε", "$snap_x{0.0000}"), ("F", f"$snap_y{{0.00}} {unit}")
        ]  # fmt: skip
        entries = (
            f"<span>{self._sample(i)}{html.escape(pin.name)}</span>"
            for i, pin in enumerate(view.pins)
        )
        self._legend.object = f'<div class="legend">{"".join(entries)}</div>'
        self.notes.object = _notes_html(view)
        self._show_strain(view)

    def follow(self, before: View, after: View) -> None:
        """Update what depends on the contraction."""
        if changed(before, after, "strain") and after.pins:
            self._show_strain(after)

    def pin_example(self) -> None:
        """Pin the current muscle, and the same with a smaller braid angle."""
        view = self.session.view
        angle = float(view.muscle.braid_angle) * _ANGLE_STEP
        with self.message.errors():
            for muscle in (view.muscle, view.muscle.replace(braid_angle=angle)):
                _pin_muscle(self.session, view.name, muscle, view.pressure)

    def _show_strain(self, view: View) -> None:
        """Show forces at the view's contraction, and the table."""
        top = top_strain(view.pins)
        strain = min(view.strain, top)
        self._strain.show(strain, "", top)
        values = quantities(view.pins, strain)
        _, scale = self.unit("force")
        forces = values[-1].values
        self._points.data = {
            "x": [strain] * len(forces),
            "y": [force / scale for force in forces],
            "color": self._colors[: len(forces)],
        }
        tables = "".join(self._table_html(quantity, view.pins) for quantity in values)
        self._table.object = f'<div class="tables">{tables}</div>'

    def _table_html(self, quantity: PinQuantity, pins: tuple[Pin, ...]) -> str:
        unit = self.unit("force")[0] if quantity.dimension == "force" else ""
        heads = "".join(f"<th>{text}</th>" for text in ("curve", "value", "difference", "percent"))
        lines = "".join(
            f"<tr><th><div>{self._sample(i)}<span>{html.escape(pin.name)}</span></div></th>"
            + "".join(f"<td>{text}</td>" for text in texts)
            + "</tr>"
            for i, (pin, texts) in enumerate(zip(pins, quantity_texts(quantity, unit), strict=True))
        )
        caption = f"{quantity.label} [{unit or '–'}]"
        return f"<table><caption>{caption}</caption><tr>{heads}</tr>{lines}</table>"

    def _sample(self, index: int) -> str:
        """Line of a curve as an image in HTML."""
        dashes = " ".join(map(str, _dash(index)))
        return (
            '<svg width="34" height="10" aria-hidden="true"><line x1="0" x2="34" y1="5" y2="5"'
            f' stroke="{self._colors[index]}" stroke-width="3" stroke-dasharray="{dashes}"/></svg>'
        )

    def _show_rows(self, view: View) -> None:
        """Show a name and a button to remove it for each curve."""
        number = len(view.pins)
        if number != len(self._names):  # rows that stay keep the focus
            self._names = self._names[:number]
            self._names += [self._make_name_input(i) for i in range(len(self._names), number)]
            rows = self._rows.objects[1 : number + 1]
            rows += [self._make_row(i) for i in range(len(rows), number)]
            self._rows.objects = [pane(heading("Pinned curves")), *rows] if rows else []
        for name, pin in zip(self._names, view.pins, strict=True):
            name.value = pin.name

    def _make_name_input(self, index: int) -> Any:
        label = f"Name of curve {index + 1}"
        return widget(pn.widgets.TextInput, label, partial(self._rename, index))

    def _make_row(self, index: int) -> Any:
        remove = button(
            f"Remove {index + 1}", lambda: self._remove(index), margin=(20, 8, 2, 0), width=90
        )
        return row(self._names[index], remove, kind="")

    def _rename(self, index: int, name: str) -> None:
        if name == self.session.view.pins[index].name:  # the page's own
            return
        with self.message.errors(name=f"Name of curve {index + 1}"):
            self.session.change(pins=rename_pin(self.session.view.pins, index, name))

    def _remove(self, index: int) -> None:
        pins = self.session.view.pins
        self.session.change(pins=(*pins[:index], *pins[index + 1 :]))

    def _move_strain(self, event: Any) -> None:
        if event.x is not None and 0 <= event.x <= top_strain(self.session.view.pins):
            self.session.change(strain=round(float(event.x), 4))


def _pin_muscle(session: Session, name: str, muscle: Any, pressure: float) -> None:
    """Pin a `muscle` at a `pressure` [Pa]; `InvalidInputError` if it can't be."""
    view = session.view
    session.change(pins=add_pin(view.pins, name, muscle, pressure, view.display_units["pressure"]))


def _dash(index: int) -> list[int]:
    """Lengths of dashes and gaps of a curve [pixel]; none of a solid one."""
    return [round(length * _LINE_WIDTH) for length in DASHES[index]]


def _notes_html(view: View) -> str:
    """Validity warnings of all pins, and a note on those that the link leaves out."""
    lines: list[str] = []
    for pin in view.pins:
        pinned_view = replace(view, muscle=pin.muscle, supply=pin.pressure, units=(Unit(),))
        lines += [f"{pin.name}: {text}" for text in validity_warnings(pinned_view, "muscle")]
    warnings = "".join(f'<p class="warning">{text_html(line)}</p>' for line in lines)
    number = linked_pins(view)
    left_out = f"The link has room for the first {number} of these curves only."
    return warnings + status_line(left_out if number < len(view.pins) else "")
