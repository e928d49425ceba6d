"""How a record is to be read, where it doesn't say it itself: rest length, columns and units; and
what is to be fitted to it.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel as pn

from ..muscle import Muscle
from ..plot.theme import APART, LARGE, SMALL, TEXT, WIDE
from .measured import FOUND, MOST_ROWS, TUNING, Reading, fittable
from .theme import NARROW, STACKED, Look, widget_css
from .widgets import choice
from .widgets import read as read_field


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


_TITLE = "Your own muscle, as it was measured"
_TEXT = (
    "Open a dynamometer's CSV: pressure, force, and strain, length or displacement, with units in"
    " its header. Its readings appear here beside this muscle's curves; then the muscle is tuned to"
    f" them, with how sure each constant is. At most {MOST_ROWS} rows; they stay in this session's"
    " memory. No record at hand? There is a synthetic one of this muscle, a little thicker and"
    " steeper than drawn."
)
# a form to fill in: nobody's readings
_FORM = """pressure [kPa],strain [-],force [N]
100,0.00,…
100,0.02,…
200,0.00,…"""


def invitation(begin: Any) -> Any:
    """A framed panel [-] above this muscle's own curves; `begin`: the button of an example [-]."""
    told = (
        f'<h2 style="font-size:{LARGE}px;margin:0 0 var(--apart)">{_TITLE}</h2>'
        f'<p style="margin:0;font-size:{TEXT}px;max-width:76ch">{_TEXT}</p>'
    )
    form = (
        f'<p style="margin:0 0 var(--near);font-size:{SMALL}px">Such a file begins with</p>'
        '<pre style="margin:0;padding:var(--apart);white-space:pre-wrap;'
        f"font:{SMALL}px/1.5 var(--mono);color:var(--soft);background:var(--raised);"
        f'border-radius:var(--round)">{_FORM}</pre>'
    )
    words = pn.Column(
        pn.pane.HTML(told, sizing_mode="stretch_width", margin=(0, APART, APART, APART)), begin,
        margin=0, styles={"flex": "3 1 0", "min-width": "0"}, sizing_mode="stretch_width",
        stylesheets=[NARROW],
    )  # fmt: skip
    file = pn.pane.HTML(form, margin=0, styles={"flex": "2 1 0", "min-width": "0"},
                        sizing_mode="stretch_width")  # fmt: skip
    framed = {"border": "2px dashed var(--line)", "border-radius": "var(--round)",
              "padding": "var(--wide)", "gap": f"{WIDE}px"}  # fmt: skip
    return pn.Row(
        words, file, styles=framed, sizing_mode="stretch_width", margin=APART,
        stylesheets=[STACKED],
    )  # fmt: skip
