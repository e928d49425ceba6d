"""What tabs other than the muscle's share: drawn when looked at, and only if something changed."""

from typing import Any, ClassVar

from ..parts.look import Look
from ..parts.widgets import Message
from ..state import Session, View, changed


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


def status(text: str) -> str:
    """A quiet line [-] that says what is going on [-]."""
    return f'<div role="status" style="font-size:13px;opacity:.8">{text}</div>' if text else ""
