"""Inputs of the data tab: how a record is read and what is fitted; and the tab without a record."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel as pn

from ..muscle import Muscle
from ..plot.theme import APART, LARGE, SMALL, TEXT, WIDE
from .measured import AUTOMATIC, MOST_ROWS, TUNING, ReadOptions, fittable_names
from .theme import NARROW, PAIRS, STACKED, WHOLE_ROW
from .widgets import dropdown, parse_field, widget


ROLES = ("pressure", "force", "strain", "displacement", "length")  # of columns that have fields
_AUTOMATIC = "(automatic)"
_CHOSEN = "constants of your choice"
_TITLE = "Your own muscle, as it was measured"
_TEXT = (
    "Open a dynamometer's CSV: pressure, force, and strain, length or displacement, with units in"
    " its header. Its readings appear here beside this muscle's curves; then the muscle is tuned to"
    f" them, with an interval for each constant. At most {MOST_ROWS} rows; they stay in this"
    " session's memory. No record at hand? There is a synthetic one of this muscle, a little"
    " thicker and steeper than drawn."
)
# a form to fill in: nobody's readings
_FORM = """pressure [kPa],strain [-],force [N]
100,0.00,…
100,0.02,…
200,0.00,…"""


class RecordInputs:
    """Fields for what a record's file doesn't say; a change reads it again."""

    def __init__(self, on_change: Callable[[], None]):
        """**Arguments:** `on_change`: is called when a field changed."""
        self._on_change, self._updating = on_change, False
        self._headers: Sequence[str] = ()
        self.columns: dict[str, Any] = {}
        self.units: dict[str, Any] = {}
        self.length = widget(
            pn.widgets.TextInput, "Rest length, if the record doesn't have it", styles=WHOLE_ROW
        )
        self.clipped = widget(
            pn.widgets.Checkbox, "A force of exactly 0 means 0 or less", margin=(6, 8),
            styles=WHOLE_ROW,
        )  # fmt: skip
        self._toggle = widget(pn.widgets.Toggle, "Show columns and units", margin=(4, 8))
        self._toggle.param.watch(lambda event: self.show_columns(event.new), "value")
        self._always = [self.length, self.clipped, self._toggle]
        self.panel = pn.Column(
            *self._always, margin=0, sizing_mode="stretch_width", stylesheets=[PAIRS]
        )
        self._watch(self.length, self.clipped)

    def show_columns(self, shown: bool) -> None:
        """Show the fields of columns and units, or hide them."""
        if shown and not self.columns:  # made once they are needed: most records don't
            self.columns = {role: dropdown(f"Column of {role}", [_AUTOMATIC]) for role in ROLES}
            self.units = {role: widget(pn.widgets.TextInput, f"Unit of {role}") for role in ROLES}
            self.offer(self._headers)
            self._watch(*self.columns.values(), *self.units.values())
        pairs = [w for role in self.columns for w in (self.columns[role], self.units[role])]
        self.panel.objects = [*self._always, *(pairs if shown else ())]
        self._toggle.value = shown

    def offer(self, headers: Sequence[str]) -> None:
        """Offer the columns of a file by their `headers`."""
        self._updating, self._headers = True, headers
        for column in self.columns.values():
            column.options = [_AUTOMATIC, *headers]
            column.value = _AUTOMATIC
        self._updating = False

    def options(self, shown: Mapping[str, str]) -> ReadOptions:
        """Options in the fields; a bare rest length is in the unit `shown`.

        **Raises:** `ValueError` for a rest length that can't be read.
        """
        text = self.length.value.strip()
        rest = parse_field(text, "length", shown["length"], "rest_length") if text else None
        columns = {r: w.value for r, w in self.columns.items() if w.value != _AUTOMATIC}
        units = {r: w.value.strip() for r, w in self.units.items() if w.value.strip()}
        return ReadOptions(self.clipped.value, rest, columns, units)

    def _watch(self, *widgets: Any) -> None:
        for each in widgets:
            each.param.watch(lambda _: None if self._updating else self._on_change(), "value")


class FitInputs:
    """Choice of what is fitted: automatic, the paper's tuning, or constants by name."""

    def __init__(self) -> None:
        kinds = {"what the data determine": AUTOMATIC, "the paper's tuning": TUNING,
                 _CHOSEN: _CHOSEN}  # fmt: skip
        self.kind = dropdown("What to fit", kinds)
        self.names = widget(
            pn.widgets.MultiSelect, "Constants (Ctrl for several)", size=6, visible=False
        )
        self.kind.param.watch(self._choose, "value")

    def offer(self, muscle: Muscle) -> None:
        """Offer the constants of a `muscle`."""
        self.names.options = {name.replace("_", " "): name for name in fittable_names(muscle)}

    @property
    def chosen(self) -> tuple[str, ...]:
        """Names to fit, as `measured.fit_record` takes them."""
        return tuple(self.names.value) if self.kind.value == _CHOSEN else (self.kind.value,)

    def _choose(self, event: Any) -> None:
        self.names.visible = event.new == _CHOSEN


def empty_state_panel(example: Any) -> Any:
    """Framed panel above the muscle's curves; `example` is the button of an example record."""
    text = (
        f'<h2 style="font-size:{LARGE}px;margin:0 0 var(--apart)">{_TITLE}</h2>'
        f'<p style="margin:0;font-size:{TEXT}px;max-width:76ch">{_TEXT}</p>'
    )
    form = (
        f'<p style="margin:0 0 var(--near);font-size:{SMALL}px">Such a file begins with</p>'
        '<pre style="margin:0;padding:var(--apart);white-space:pre-wrap;'
        f"font:{SMALL}px/1.5 var(--mono);color:var(--soft);background:var(--raised);"
        f'border-radius:var(--round)">{_FORM}</pre>'
    )
    left = pn.Column(
        pn.pane.HTML(text, sizing_mode="stretch_width", margin=(0, APART, APART, APART)), example,
        margin=0, styles={"flex": "3 1 0", "min-width": "0"}, sizing_mode="stretch_width",
        stylesheets=[NARROW],
    )  # fmt: skip
    right = pn.pane.HTML(form, margin=0, styles={"flex": "2 1 0", "min-width": "0"},
                         sizing_mode="stretch_width")  # fmt: skip
    frame = {"border": "2px dashed var(--line)", "border-radius": "var(--round)",
             "padding": "var(--wide)", "gap": f"{WIDE}px"}  # fmt: skip
    return pn.Row(
        left, right, styles=frame, sizing_mode="stretch_width", margin=APART, stylesheets=[STACKED]
    )
