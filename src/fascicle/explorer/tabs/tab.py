"""What tabs other than the muscle's share: drawn when looked at, and only if something changed."""

import html
from typing import Any, ClassVar

import panel as pn

from ...plot.theme import APART, FAR, LARGE, TEXT
from ..parts.look import NARROW, Look
from ..parts.notes import doubts, notes
from ..parts.widgets import Message
from ..state import Session, View, changed


# of a bar for what lasts nobody knows how long
_BAR = """<style>
@keyframes to-and-fro { from { left: 0; } to { left: 70%; } }
.bar { position: relative; height: 8px; border-radius: var(--round); background: var(--line);
  overflow: hidden; margin: var(--near) 0; }
.bar div { position: absolute; width: 30%; height: 100%; background: var(--accent);
  animation: to-and-fro 1.2s ease-in-out infinite alternate; }
@media (prefers-reduced-motion: reduce) { .bar div { animation: none; width: 100%; } }
</style>"""


class Tab:
    """A tab that is drawn anew where one of its fields of the view changes."""

    name: ClassVar[str]
    fields: ClassVar[tuple[str, ...]]
    panel: Any

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self.session, self.look = session, look
        self.message = Message(self.name)
        self._stale = True
        session.watch(self._changed)

    def refresh(self) -> None:
        """Draw it, if anything that it shows has changed since it was drawn."""
        if self._stale:
            self._stale = False
            self.draw(self.session.view)

    def draw(self, view: View) -> None:
        """Show a `view` [-]."""
        raise NotImplementedError

    def moved(self, before: View, after: View) -> None:
        """Follow what is not among the fields: a slider."""

    def _changed(self, before: View, after: View) -> None:
        if changed(before, after, *self.fields):
            self._stale = True
        if after.tab != self.name:
            return
        if self._stale:
            self.refresh()
        else:
            self.moved(before, after)


def moving(what: str) -> str:
    """A bar [-] that moves while `what` [-] is done."""
    return f'{_BAR}<div class="bar" role="progressbar" aria-label="{what}"><div></div></div>'


def card(title: str, text: str, *more: Any) -> Any:
    """A framed panel [-] where a picture will be: a `title` and a `text` [-], and `more` [-]."""
    told = (
        f'<h2 style="font-size:{LARGE}px;margin:0 0 var(--apart)">{title}</h2>'
        f'<p style="margin:0;font-size:{TEXT}px">{text}</p>'
    )
    framed = {"border": "2px dashed var(--line)", "border-radius": "var(--round)",
              "padding": "var(--wide)", "max-width": "640px"}  # fmt: skip
    return pn.Column(
        pn.pane.HTML(told, sizing_mode="stretch_width"), *more,
        styles=framed, sizing_mode="stretch_width", align="center", margin=(FAR, APART),
        stylesheets=[NARROW],
    )  # fmt: skip


def remarks(view: View, tab: str) -> str:
    """What a reader must know of what a `tab` [-] shows of a `view` [-], doubts marked [-]."""
    marked = "border-left:3px solid var(--bad);padding-left:var(--apart);margin:var(--near) 0"
    told = (f'<p style="{marked}">{html.escape(one)}</p>' for one in doubts(view, tab))
    return "".join(told) + status(" ".join(notes(view, tab)))


def status(text: str) -> str:
    """A quiet line [-] that says what is going on [-]."""
    return f'<div role="status" style="font-size:13px;opacity:.8">{text}</div>' if text else ""
