"""Tab of pinned curves: several muscles' forces in one figure, and a table of their differences."""

import html
import math
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..plot.curves import force_comparison
from ..plot.theme import DASHES, Colors
from ..results import tables
from ..units import pretty
from . import widgets as ui
from .chart import Chart, hover_tooltips, other_colors, padded_range, screen_height
from .muscle_curves import (
    POINTS,
    MuscleCurves,
    alternative_laws,
    law_label,
    muscle_curves,
    strain_limit,
    with_alternative,
)
from .remarks import validity_warnings
from .state import Pin, Session, Unit, View, changed
from .tab import Export, StrainTab
from .texts import TEXTS


_OWN_LAWS = "as the muscle has them"
_LINE_WIDTH = 2.4  # pixels of a curve; dashes are as many times longer
_ANGLE_STEP = 0.9  # ratio of braid angles of the example: 33 to 29.7 degrees
MOST_PINS = 6  # more colors and dashes can't be told apart
LONGEST_NAME = 40  # characters: a line of a phone
_ROUNDING = 1e-6  # N or -: a smaller reference is zero but for rounding, and has no percentage


def difference_text(value: float, reference: float, form: str) -> str:
    """A `value` in a `form`, and by how many percent of the size of a `reference` it differs."""
    if not math.isfinite(value):
        return "never"
    text = format(value, form)
    if math.isfinite(reference) and value != reference and abs(reference) > _ROUNDING:
        text += f" ({100 * (value - reference) / abs(reference):+.1f} %)"
    return text.replace("-", "−")


def add_pin(pins: tuple[Pin, ...], name: str, muscle: Muscle, pressure: float) -> tuple[Pin, ...]:
    """The `pins`, and a new one with a `name` that no other has; an error if they are too many."""
    if len(pins) >= MOST_PINS:
        rule = f"must be {MOST_PINS} curves at most, as many as can be told apart"
        raise InvalidInputError("pins", rule, len(pins) + 1, "remove one")
    # a spreadsheet takes a leading =, +, - or @ for a formula
    line = sanitize_line(str(name), LONGEST_NAME).lstrip("=+-@ ") or "muscle"
    names = {pin.name for pin in pins}
    candidates = (line, *(f"{line} ({i})" for i in range(2, MOST_PINS + 2)))
    free_name = next(candidate for candidate in candidates if candidate not in names)
    return (*pins, Pin(free_name, muscle, float(pressure)))


def name_difference(first: Muscle, second: Muscle) -> str:
    """Sizes, material and laws of the `second` muscle that the first has not, in words."""
    parts = [
        f"{label.lower()} {pretty(float(getattr(second, name)), dimension)}"
        for name, (label, dimension) in ui.SIZES.items()
        if getattr(first, name) != getattr(second, name)
    ]
    parts += ["other material"] * (first.material != second.material)
    laws = (getattr(second, kind) for kind in LAWS if getattr(first, kind) != getattr(second, kind))
    parts += [law.name.replace("_", " ") for law in laws]
    return ", ".join(parts + ["other tuning"] * (first.tuning != second.tuning))


def pin_muscle(session: Session, muscle: Muscle) -> str:
    """Pin a `muscle` at the view's pressure; returns its name: what differs from the first pin, or
    the name of the view's muscle and the pressure.
    """
    view = session.view
    label = name_difference(view.pins[0].muscle, muscle) if view.pins else ""
    if not label or view.pins[0].pressure != view.pressure:
        unit = view.display_units["pressure"]
        at = ui.format_quantity(view.pressure, unit, "pressure", 4)
        label = f"{label or view.name.removesuffix('.toml')}, {at}"
    pins = add_pin(view.pins, label, muscle, view.pressure)
    session.change(pins=pins)
    return pins[-1].name


class CompareView(StrainTab):
    """Widgets and figure of pinned curves."""

    name: ClassVar[str] = "compare"
    fields: ClassVar[tuple[str, ...]] = ("pins", "muscle", "display_units")

    def __init__(self, session: Session, colors: Colors):
        super().__init__(session, colors, "Contraction ε to compare at")
        names = "Pressure P", "pressure", "pressure"
        self._pressure = ui.QuantitySlider(*names, lambda value: session.change(pressure=value))
        self._law, self._rows = ui.dropdown("Laws", [_OWN_LAWS]), ui.column()
        self._pin_curves: list[MuscleCurves] = []
        # room for header, slider, legend and the head of the table
        chart = Chart(colors, "Contraction ε [–]", "Force F [N]", screen_height(430))
        self.chart = chart
        chart.add_zero_line()
        self._curves = chart.add("compared", line_width=_LINE_WIDTH)
        self._hover = chart.add_hover([])
        self._points = chart.add("compared_points")
        chart.on_hold(self.set_strain)
        self._table = ui.wide_pane(margin=(8, 8))
        shown = (self.strain.panel, chart.new_pane(), self._table)
        self._comparison = ui.column(self.notes, *shown)
        example = ui.button("Try two braid angles", self.pin_example)
        self._empty = ui.column(ui.pane(TEXTS["compare"]["empty"]), example, kind="framed")
        title = ui.pane(ui.heading("Pin another curve"))
        pin = ui.button("Pin this curve", self._pin, color="primary")
        inputs = (title, self._pressure.panel, self._law, pin, self.message.pane, self._rows)
        main = ui.column(self._empty, self._comparison)
        self.panel = ui.row(ui.side_column(*inputs, width=318), main)

    @property
    def _colors(self) -> list[str]:
        return other_colors(self.colors, len(DASHES))

    def draw(self, view: View) -> None:
        self._show_pressure(view)
        keys = alternative_laws(view.muscle)
        options = {_OWN_LAWS: "", **{law_label(key): key for key in keys}}
        law = self._law.value if self._law.value in options.values() else ""
        self._law.param.update(options=options, value=law)
        self._rows.objects = [
            ui.button(f"Remove {pin.name}", partial(self._remove, pin)) for pin in view.pins
        ]
        self.message.show("")
        self._empty.visible, self._comparison.visible = not view.pins, bool(view.pins)
        if not view.pins:
            return
        unit, scale = self.unit("force")
        self.top = max(strain_limit(pin.muscle, pin.pressure) for pin in view.pins)
        curves = [muscle_curves(pin.muscle, pin.pressure, 0.0, self.top) for pin in view.pins]
        self._pin_curves, forces = curves, [curve.force / scale for curve in curves]
        self._curves.data = {
            "xs": [curve.strain for curve in curves],
            "ys": forces,
            "color": self._colors[: len(curves)],
            "dash": [_dash(i) for i in range(len(curves))],
            "label": [pin.name for pin in view.pins],
        }
        self.chart.set_ranges((0.0, self.top), padded_range(np.concatenate(forces), 0.06))
        self.chart.figure.yaxis[0].axis_label = f"Force F [{unit}]"
        self._hover.tooltips = [("", "@label"), *hover_tooltips(unit)]
        self.notes.object = _warnings_html(view)
        self._show_strain(view)

    def follow(self, before: View, after: View) -> None:
        self._show_pressure(after)
        if changed(before, after, "strain") and after.pins:
            self._show_strain(after)

    def export(self) -> Export:
        """Table and figure of the pinned curves, to download."""
        view = self.session.view
        if not view.pins:
            raise ValueError("Pin a curve first: there is nothing to download yet.")
        strain, chosen = np.linspace(0.0, self.top, POINTS), min(view.strain, self.top)
        muscles = {pin.name: pin.muscle for pin in view.pins}
        arguments = muscles, [pin.pressure for pin in view.pins], strain, chosen
        variables = tables.force_comparison(*arguments)
        return Export(self.stem("compare"), variables, lambda: force_comparison(*arguments))

    def pin_example(self) -> None:
        """Pin the current muscle, and the same with a smaller braid angle."""
        view = self.session.view
        angle = float(view.muscle.braid_angle) * _ANGLE_STEP
        with self.message.errors():
            for muscle in (view.muscle, view.muscle.replace(braid_angle=angle)):
                pin_muscle(self.session, muscle)

    def _show_pressure(self, view: View) -> None:
        self._pressure.show(view.pressure, view.display_units["pressure"], view.supply)

    def _pin(self) -> None:
        """Pin the view's muscle, with the chosen law."""
        muscle, law = self.session.view.muscle, self._law.value
        with self.message.errors():
            pin_muscle(self.session, with_alternative(muscle, law) if law else muscle)

    def _show_strain(self, view: View) -> None:
        """Show forces at the view's contraction, and the table."""
        (unit, scale), strain = self.unit("force"), min(view.strain, self.top)
        self.show_strain(view)
        curves = self._pin_curves
        forces = [float(pin.muscle.force(pin.pressure, strain)) / scale for pin in view.pins]
        colors = self._colors[: len(forces)]
        self._points.data = {"x": [strain] * len(forces), "y": forces, "color": colors}
        columns: dict[str, tuple[str, list[float]]] = {
            f"Blocked force [{unit}]": (".4g", [curve.blocked / scale for curve in curves]),
            "Free strain [–]": (".4f", [curve.free_strain for curve in curves]),
            "Collapse strain [–]": (".4f", [curve.collapse_strain for curve in curves]),
            f"Force at ε = {strain:.4g} [{unit}]": (".4g", forces),
        }
        rows = [
            [f"{self._sample(i)} {html.escape(pin.name)}"]
            + [difference_text(values[i], values[0], form) for form, values in columns.values()]
            for i, pin in enumerate(view.pins)
        ]
        table = ui.html_table(["curve", *columns], rows)
        note = "Percentages are of the first curve's magnitude."
        self._table.object = f'<div class="compared">{table}</div><p class="small note">{note}</p>'

    def _sample(self, index: int) -> str:
        dashes = " ".join(map(str, _dash(index)))
        return (
            '<svg width="34" height="10" aria-hidden="true"><line x1="0" x2="34" y1="5" y2="5"'
            f' stroke="{self._colors[index]}" stroke-width="3" stroke-dasharray="{dashes}"/></svg>'
        )

    def _remove(self, pin: Pin) -> None:
        self.session.change(
            pins=tuple(other for other in self.session.view.pins if other is not pin)
        )


def _dash(index: int) -> list[int]:
    """Lengths of dashes and gaps of a curve [pixel]; none of a solid one."""
    return [round(length * _LINE_WIDTH) for length in DASHES[index]]


def _warnings_html(view: View) -> str:
    """Validity warnings of all pins."""
    lines: list[str] = []
    for pin in view.pins:
        pinned_view = replace(view, muscle=pin.muscle, supply=pin.pressure, units=(Unit(),))
        lines += [f"{pin.name}: {text}" for text in validity_warnings(pinned_view, "muscle")]
    return "".join(f'<p class="warning">{ui.text_html(line)}</p>' for line in lines)
