"""What the data's tab shows before there are data: what to bring, how it looks, one to try."""

from typing import Any

import panel as pn

from ...plot.theme import APART, LARGE, SMALL, TEXT, WIDE
from ..curves.measured import MOST_ROWS
from ..parts.look import NARROW, STACKED


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
