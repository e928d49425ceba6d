"""The motor units' rows: how many muscles, how thick, at what pressure."""

from dataclasses import replace
from typing import Any

import panel as pn

from ...core.errors import InvalidInputError
from ..parts.look import Look, widget_css
from ..parts.widgets import Dial, Field, Message, button, shown
from ..state import MOST_UNITS, SIZES, Session, Unit, View, check_units


class UnitRows:
    """A row for each motor unit, added and removed at the end."""

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self._session, self._look, self._silent = session, look, False
        self.message = Message("units")
        self._rows = pn.Column(margin=0, sizing_mode="stretch_width")
        self._parts: list[tuple[Any, Field, Dial, Any]] = []
        buttons = pn.Row(
            button(look, "Add a unit", self._add, width=110, margin=(4, 4, 4, 8)),
            button(look, "Remove the last", self._remove, width=130, margin=4),
            margin=0,
        )
        self.panel = pn.Column(
            buttons, self.message.pane, self._rows, margin=0, sizing_mode="stretch_width"
        )

    def show(self, view: View) -> None:
        """Show the units of a `view` [-]."""
        self._silent = True
        while len(self._parts) > len(view.units):
            self._parts.pop()
        while len(self._parts) < len(view.units):
            self._parts.append(self._row(len(self._parts)))
        if len(self._rows) != len(self._parts):
            self._rows.objects = [part[3] for part in self._parts]
        for (count, radius, _, _), unit in zip(self._parts, view.units, strict=True):
            count.value = unit.count
            muscle = view.muscle_of(unit)
            radius.show(float(muscle.outer_radius), view.shown["length"])
        self._silent = False
        self.message.say("")
        self.press(view)

    def press(self, view: View) -> None:
        """Show the pressures of a `view` [-]."""
        for (_, _, dial, _), pressure in zip(self._parts, view.pressures, strict=True):
            dial.show(pressure, view.shown["pressure"], view.supply)

    def _row(self, i: int) -> tuple[Any, Field, Dial, Any]:
        count = pn.widgets.IntInput(
            label=f"Unit {i + 1}: muscles", value=1, width=118, margin=(2, 8),
            stylesheets=[widget_css(self._look)],  # its limits are told, here: the browser's aren't
        )  # fmt: skip
        count.param.watch(lambda event: self._counted(i, event.new), "value")
        radius = Field(
            self._look, "Radius", "outer_radius", "length", lambda value: self._resize(i, value)
        )
        dial = Dial(
            self._look,
            f"Pressure P{i + 1}",
            "pressure",
            "pressure",
            lambda value: self._press(i, value),
        )
        row = pn.Row(count, radius.panel, margin=0, sizing_mode="stretch_width")
        return count, radius, dial, pn.Column(row, dial.panel, margin=(0, 0, 6, 0))

    def _counted(self, i: int, count: int | None) -> None:
        if self._silent:
            return
        if count is None:
            self.message.say("`count` must be a whole number of muscles, got none.")
            return
        self._try(replace(self._session.view.units[i], count=count), i)

    def _resize(self, i: int, radius: float) -> None:
        view = self._session.view
        unit = view.units[i]
        base = view.muscle if unit.own is None else unit.own
        size = radius / float(base.outer_radius)
        if not SIZES[0] <= size <= SIZES[1]:
            unit = view.shown["length"]
            low, high = (shown(by * float(base.outer_radius), unit, "length") for by in SIZES)
            rule = f"must be {low} to {high}, a tenth to ten times the muscle's"
            raise InvalidInputError("radius", rule, radius, shown=shown(radius, unit, "length"))
        if unit.own is not None:
            from ..state import scaled

            self._become(i, replace(unit, own=scaled(unit.own, size)))
        else:
            self._become(i, replace(unit, size=size))

    def _press(self, i: int, pressure: float) -> None:
        pressures = list(self._session.view.pressures)
        pressures[i] = pressure
        self._session.change(pressures=tuple(pressures))

    def _add(self) -> None:
        view = self._session.view
        if len(view.units) >= MOST_UNITS:
            self.message.say(f"`units` must be at most {MOST_UNITS} motor units.")
            return
        self._session.change(units=(*view.units, Unit()), pressures=(*view.pressures, 0.0))
        self.message.say("")

    def _remove(self) -> None:
        view = self._session.view
        if len(view.units) == 1:
            self.message.say("`units` must be at least 1 motor unit.")
            return
        self._session.change(units=view.units[:-1], pressures=view.pressures[:-1])
        self.message.say("")

    def _try(self, unit: Unit, i: int) -> None:
        try:
            self._become(i, unit)
            self.message.say("")
        except ValueError as error:
            self.message.say(str(error))

    def _become(self, i: int, unit: Unit) -> None:
        units = list(self._session.view.units)
        units[i] = unit
        check_units(tuple(units))
        self._session.change(units=tuple(units))
