"""Base of the tabs, and slow computations in threads, so that a fit stops nobody's slider.

A tab is drawn when it is open, and only if its content has changed.
"""

import asyncio
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, ClassVar

import panel as pn

from ..plot.theme import Colors
from .chart import replace_colors
from .state import Session, View, changed
from .theme import pane
from .widgets import Message, QuantitySlider, status_line, unit_factor
from .worker import result_and_error


_WORKERS = ThreadPoolExecutor(2, thread_name_prefix="fascicle")  # a fit, and a map beside it
_RUNNING: set["Future[Any]"] = set()
_PERIOD = 500  # ms between the seconds that a progress shows
Outcome = tuple[Any, ValueError | None]  # of a computation: result, and error


class Tab:
    """Base class of the page's tabs: `draw` draws the view anew, `follow` updates what is drawn.

    `panel`: of the tab. `fields`: of the view; after a change of one of them the tab is drawn anew,
    after other changes updated.
    """

    name: ClassVar[str]
    fields: ClassVar[tuple[str, ...]]
    panel: Any

    def __init__(self, session: Session, colors: Colors):
        self.session, self.colors = session, colors
        self.status = pane(height=22)
        self.notes = pane(margin=(2, 8), sizing_mode="stretch_width")
        self.message = Message()
        self.downloads: list[Any] = []  # buttons of files of what is drawn
        self.download_message = Message()  # where a file can't be made
        self._drawn: View | None = None
        session.watch(lambda _, after: self.refresh() if after.tab == self.name else None)

    def is_open(self) -> bool:
        """True while the page shows this tab."""
        return self.session.view.tab == self.name

    def refresh(self) -> None:
        """Draw the session's view, or follow what changed since it was drawn."""
        before, view = self._drawn, self.session.view
        if before is view:
            return
        self._drawn = view
        if before is None or changed(before, view, *self.fields):
            self.enable(self.downloads, True)
            self.download_message.show("")
            self.draw(view)
        else:
            self.follow(before, view)

    def draw(self, view: View) -> None:
        """Draw all that the tab shows of a `view`."""
        raise NotImplementedError

    def follow(self, before: View, after: View) -> None:
        """Update only what depends on fields of the view outside `fields`, such as a slider's."""

    def set_colors(self, colors: Colors) -> None:
        """Replace the colors of the figures; what the tab shows is drawn anew when it is open."""
        figures = (pane.object for pane in self.panel.select(pn.pane.Bokeh))
        replace_colors(figures, self.colors, colors)
        self.colors, self._drawn = colors, None

    def unit(self, dimension: str) -> tuple[str, float]:
        """Unit shown of a `dimension`, and its value [SI]."""
        unit = self.session.view.display_units[dimension]
        return unit, unit_factor(unit, dimension)

    def strain_slider(self, label: str = "Contraction ε") -> QuantitySlider:
        """A slider of the view's contraction."""
        return QuantitySlider(
            label, "strain", "strain", lambda value: self.session.change(strain=value)
        )

    def fail(self, error: ValueError | str) -> None:
        """Show the error of a computation, and end its status: there is nothing to download."""
        self.status.object = ""
        self.enable(self.downloads, False)
        self.message.show(error, self.session.view.display_units)

    @staticmethod
    def enable(buttons: Iterable[Any], enabled: bool) -> None:
        """Enable or disable `buttons`."""
        for button in buttons:
            button.disabled = not enabled


def session_document() -> Any:
    """Document of the visitor's session; `None` in a notebook, or a test."""
    doc = pn.state.curdoc
    return doc if doc is not None and doc.session_context else None


def _is_alive(doc: Any) -> bool:
    """True while somebody has the page of a document."""
    return bool(doc.session_context) and not doc.session_context.destroyed


class Progress:
    """A bar that moves while a computation of unknown duration runs, and a line with its time."""

    def __init__(self, label: str, status: Any, is_open: Callable[[], bool]):
        """Progress with a `label` for screen readers; `status` is the pane of the line, which
        changes while `is_open` is true.
        """
        self._is_open = is_open
        html = f'<div role="progressbar" aria-label="{label}"><div></div></div>'
        self.bar = pane(html, visible=False, sizing_mode="stretch_width")
        self._status, self._timer = status, None

    def start(self, text: Callable[[float], str]) -> None:
        """Show the `text` of the seconds since now."""
        start_time = time.monotonic()

        def show() -> None:
            if self._is_open():
                self._status.object = status_line(text(time.monotonic() - start_time))

        show()
        self.bar.visible = True
        if session_document():
            self._timer = pn.state.add_periodic_callback(show, period=_PERIOD)

    def stop(self) -> None:
        """Hide bar and text."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        self.bar.visible, self._status.object = False, ""


def is_computing() -> bool:
    """True while a computation is running."""
    return bool(_RUNNING)


class LatestResult:
    """Runs one computation at a time in a thread, and shows the result of the latest request."""

    def __init__(
        self,
        show: Callable[[Any], None],
        fail: Callable[[ValueError | str], None],
        workers: ThreadPoolExecutor = _WORKERS,
        is_open: Callable[[], bool] = lambda: True,
    ):
        """On the loop, `show` takes a result, and `fail` an error, once `is_open` is true: Panel
        gives what changes in a hidden tab style sheets from another machine. `workers` are its
        threads.
        """
        self._show, self._fail, self._workers, self._is_open = show, fail, workers, is_open
        self._latest: Callable[[], Any] | None = None
        self._busy, self._task = False, None

    def request(self, compute: Callable[[], Any]) -> None:
        """Run `compute` in a thread, and show what it returns unless there is a later request."""
        self._latest, doc = compute, session_document()
        if doc is None:
            self._show_outcome(result_and_error(compute))
        elif not self._busy:  # else it starts when the running one has ended
            self._start(doc, compute)

    def drop(self) -> None:
        """Drop the result of the running computation."""
        self._latest = None

    def _start(self, doc: Any, compute: Callable[[], Any]) -> None:
        """Run `compute` in a thread; at its end show its result, or start a newer request."""
        self._busy = True

        def deliver(outcome: Outcome) -> None:
            self._busy = False
            if self._latest is compute:
                self._show_outcome(outcome)
            elif self._latest is not None:
                self._start(doc, self._latest)

        async def wait() -> None:
            outcome = await asyncio.wrap_future(future)
            while not self._is_open() and self._latest is compute and _is_alive(doc):
                await asyncio.sleep(_PERIOD / 1e3)
            if _is_alive(doc):
                # on the loop: a document that sends its changes loses a callback of a thread
                doc.add_next_tick_callback(lambda: deliver(outcome))

        future = self._workers.submit(result_and_error, compute)
        _RUNNING.add(future)
        future.add_done_callback(_RUNNING.discard)
        self._task = asyncio.get_running_loop().create_task(wait())

    def _show_outcome(self, outcome: Outcome) -> None:
        result, error = outcome
        with pn.io.unlocked():  # one message to the browser
            if error is None:
                self._show(result)
            else:
                self._fail(error)
