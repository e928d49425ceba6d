"""How a record is to be read, where it doesn't say it itself: rest length, columns and units; and
what is to be fitted to it.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel as pn

from ...muscle import Muscle
from ..curves.measured import FOUND, TUNING, Reading, fittable
from ..parts.look import Look, widget_css
from ..parts.widgets import choice
from ..parts.widgets import read as read_field


ROLES = ("pressure", "force", "strain", "displacement", "length")  # that have fields
_ITSELF = "(found by itself)"
_OWN = "constants of your choice"


class RecordInputs:
    """Fields for what a record doesn't say; a change is told, and it is read anew."""

    def __init__(self, look: Look, changed: Callable[[], None]):
        """**Arguments:** `look`: the page's [-]; `changed`: is told that a field changed [-]."""
        css = [widget_css(look)]
        given: dict[str, Any] = {"stylesheets": css, "margin": (2, 8)}
        self._changed, self._silent = changed, False
        self.length = pn.widgets.TextInput(
            label="Rest length, if the record doesn't say it", sizing_mode="stretch_width", **given
        )
        self.clipped = pn.widgets.Checkbox(
            label="A force of exactly 0 means 0 or less", stylesheets=css, margin=(6, 8)
        )
        self.columns = {
            role: choice(look, f"Column of {role}", [_ITSELF], sizing_mode="stretch_width")
            for role in ROLES
        }
        self.units = {
            role: pn.widgets.TextInput(label=f"Its unit ({role})", width=170, **given)
            for role in ROLES
        }
        for widget in (self.length, self.clipped, *self.columns.values(), *self.units.values()):
            widget.param.watch(self._told, "value")
        self._open = pn.widgets.Toggle(
            label="Columns and units …", stylesheets=css, margin=(4, 8), width=180
        )
        self._more = pn.Column(
            *(
                pn.Row(self.columns[role], self.units[role], margin=0, sizing_mode="stretch_width")
                for role in ROLES
            ),
            visible=False, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self._open.param.watch(lambda event: self.show(event.new), "value")
        self.panel = pn.Column(
            self.length, self.clipped, self._open, self._more, margin=0, sizing_mode="stretch_width"
        )

    def show(self, more: bool) -> None:
        """Show the fields of columns and units, or hide them."""
        self._more.visible = self._open.value = more

    def offer(self, headers: Sequence[str]) -> None:
        """Offer the columns of a file by their `headers` [-]."""
        self._silent = True
        for widget in self.columns.values():
            widget.options = [_ITSELF, *headers]
            widget.value = _ITSELF
        self._silent = False

    def reading(self, shown: Mapping[str, str]) -> Reading:
        """What the fields say; a bare rest length is in the unit `shown` [-].

        **Raises:** `ValueError` for a rest length that can't be read.
        """
        typed = self.length.value.strip()
        rest = read_field(typed, "length", shown["length"], "rest_length") if typed else None
        columns = {r: one.value for r, one in self.columns.items() if one.value != _ITSELF}
        units = {r: one.value.strip() for r, one in self.units.items() if one.value.strip()}
        return Reading(self.clipped.value, rest, columns, units)

    def _told(self, _: Any) -> None:
        if not self._silent:
            self._changed()


class FitInputs:
    """What is to be fitted: found from the data, the paper's tuning, or constants by name."""

    def __init__(self, look: Look):
        """**Arguments:** `look`: the page's [-]."""
        kinds = {"what the data can tell": FOUND, "the paper's tuning": TUNING, _OWN: _OWN}
        self.kind = choice(look, "What to fit", kinds)
        self.names = pn.widgets.MultiSelect(
            label="Constants (Ctrl for several)", size=6, visible=False,
            stylesheets=[widget_css(look)], sizing_mode="stretch_width", margin=(2, 8),
        )  # fmt: skip
        self.kind.param.watch(self._chose, "value")
        self.panel = pn.Column(self.kind, self.names, margin=0, sizing_mode="stretch_width")

    def offer(self, muscle: Muscle) -> None:
        """Offer the constants of a `muscle` [-]."""
        self.names.options = {name.replace("_", " "): name for name in fittable(muscle)}

    @property
    def chosen(self) -> tuple[str, ...]:
        """What to fit [-], as `measured.fitted` takes it."""
        return tuple(self.names.value) if self.kind.value == _OWN else (self.kind.value,)

    def _chose(self, event: Any) -> None:
        self.names.visible = event.new == _OWN
