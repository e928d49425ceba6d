"""Base of the tabs, and slow computations in threads and processes, which stop nobody's slider.

A tab is drawn when it is open, and only if its content has changed.
"""

import asyncio
import multiprocessing
import re
import signal
import threading
import traceback
import warnings
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
import panel as pn
from bokeh.document import Document
from matplotlib.figure import Figure

from ..plot.theme import Colors, to_bytes
from ..results import Table
from .state import Session, View, changed
from .widgets import Message, QuantitySlider, button, pane, status_line, unit_factor, wide_pane


_MOST_JOBS = 2  # at once, in threads and in processes; others wait
_WORKERS = ThreadPoolExecutor(_MOST_JOBS, thread_name_prefix="fascicle")
WAITING = ThreadPoolExecutor(_MOST_JOBS, thread_name_prefix="fascicle-job")  # of minutes
_RUNNING: set["Future[Any]"] = set()
_WAIT = 0.5  # s between two looks at a tab that isn't open
Outcome = tuple[Any, ValueError | None]  # of a computation: result, and error
_Result = TypeVar("_Result")


class Export(NamedTuple):
    """Content of a tab, as a table of `variables` and a `figure`; `stem` of the files' names."""

    stem: str
    variables: Table
    figure: Callable[[], Figure]

    def content(self, suffix: str) -> bytes:
        """Bytes of a picture (svg, png, pdf) or of the data (csv), by `suffix`."""
        if suffix == "csv":
            return self.variables.to_csv().encode()
        return to_bytes(self.figure(), suffix)


def output_stem(name: str, kind: str) -> str:
    """Name of an output of some `kind`, without its suffix, after the `name` of its input."""
    # the name is a visitor's: nothing in it may leave a folder
    base = Path(name.replace("\\", "/")).name
    base = re.sub(r"\.(toml|csv|txt|tsv)$", "", base, flags=re.IGNORECASE)
    stem = re.sub(r"[^\w.-]+", "_", base).strip(".-") or "file"
    return f"{stem}_{kind}"


class Tab:
    """Base class of the page's tabs: `draw` draws the view anew after a change of one of its
    `fields`, `follow` updates what is drawn after other changes; `panel`: of the tab.
    """

    name: ClassVar[str]
    fields: ClassVar[tuple[str, ...]]
    panel: pn.Row

    def __init__(self, session: Session, colors: Colors):
        self.session, self.colors = session, colors
        self.status, self.notes, self.message = pane(height=22), wide_pane(margin=(2, 8)), Message()
        self._drawn: View | None = None
        session.watch(lambda _, after: self.refresh() if after.tab == self.name else None)

    def is_open(self) -> bool:
        return self.session.view.tab == self.name

    def refresh(self) -> None:
        """Draw the session's view, or follow what changed since it was drawn."""
        before, view = self._drawn, self.session.view
        self._drawn = view
        if before is None or changed(before, view, *self.fields):
            self.draw(view)
        elif before is not view:
            self.follow(before, view)

    def draw(self, view: View) -> None:
        raise NotImplementedError

    def follow(self, before: View, after: View) -> None:
        """Update only what depends on fields of the view outside `fields`, such as a slider's."""

    def export(self) -> Export:
        """Picture and data of what is drawn; `ValueError` where there is nothing yet."""
        raise NotImplementedError

    def unit(self, dimension: str) -> tuple[str, float]:
        """Unit shown of a `dimension`, and its value [SI]."""
        unit = self.session.view.display_units[dimension]
        return unit, unit_factor(unit, dimension)

    def stem(self, kind: str) -> str:
        """Name of a file of some `kind` from this tab, without its suffix."""
        return output_stem(self.session.view.name, kind)

    def fail(self, error: ValueError | str) -> None:
        """Show the error of a computation, and end its status."""
        self.status.object = ""
        self.message.show(error)


class StrainTab(Tab):
    """A tab with a slider of the view's contraction, up to the strain `top` [-] of its figure."""

    top = 0.3

    def __init__(self, session: Session, colors: Colors, label: str = "Contraction ε"):
        super().__init__(session, colors)
        self.strain = QuantitySlider(
            label, "strain", "strain", lambda value: session.change(strain=value)
        )

    def show_strain(self, view: View) -> None:
        self.strain.show(min(view.strain, self.top), "", self.top)

    def set_strain(self, strain: float, _: float = 0.0) -> None:
        """Move the point to a `strain` [-] that is drawn, with a pointer's digits."""
        self.session.change(strain=round(float(np.clip(strain, 0.0, self.top)), 4))


def session_document() -> Document | None:
    """Document of the visitor's session; `None` in a notebook, or a test."""
    doc = pn.state.curdoc
    return doc if doc is not None and doc.session_context else None


def _is_alive(doc: Document) -> bool:
    """True while somebody has the page of a document."""
    return doc.session_context is not None and not doc.session_context.destroyed


class LatestResult:
    """Runs one computation at a time in a thread of `workers`, then that of the latest request, if
    it is newer. On the loop, `show` takes a result, and `fail` an error, once `is_open` is true:
    Panel gives what changes in a hidden tab style sheets from another machine.
    """

    def __init__(
        self,
        show: Callable[[Any], object],
        fail: Callable[[ValueError | str], object],
        is_open: Callable[[], bool] = lambda: True,
        workers: ThreadPoolExecutor = _WORKERS,
    ):
        self._show, self._fail, self._workers, self._is_open = show, fail, workers, is_open
        self._latest: Callable[[], object] | None = None
        self._busy, self._task = False, None

    def request(self, compute: Callable[[], object]) -> None:
        """Run `compute` in a thread, and show what it returns unless it is dropped."""
        self._latest, doc = compute, session_document()
        if doc is None:
            self._show_outcome(result_and_error(compute))
        elif not self._busy:  # else it starts when the running one has ended
            self._start(doc, compute)

    def drop(self) -> None:
        self._latest = None

    def _start(self, doc: Document, compute: Callable[[], object]) -> None:
        self._busy = True
        future = self._workers.submit(result_and_error, compute)
        _RUNNING.add(future)
        future.add_done_callback(_RUNNING.discard)

        def deliver(outcome: Outcome) -> None:
            self._busy = False
            if (latest := self._latest) is None:
                return
            if latest is not compute:
                self._start(doc, latest)
            self._show_outcome(outcome)

        async def wait() -> None:
            outcome = await asyncio.wrap_future(future)
            while not self._is_open() and self._latest is not None and _is_alive(doc):
                await asyncio.sleep(_WAIT)
            if _is_alive(doc):
                # on the loop: a document that sends its changes loses a callback of a thread
                doc.add_next_tick_callback(lambda: deliver(outcome))

        self._task = asyncio.get_running_loop().create_task(wait())

    def _show_outcome(self, outcome: Outcome) -> None:
        result, error = outcome
        with pn.io.unlocked():  # one message to the browser
            if error is None:
                self._show(result)
            else:
                self._fail(error)


class Job:
    """A computation that a visitor starts, and may cancel: a button for each, a bar that moves, and
    a line in the status of a `tab`; `show` takes its result.
    """

    def __init__(
        self,
        tab: Tab,
        label: str,
        start: Callable[[], object],
        show: Callable[[Any], object],
        **style: Any,
    ):
        self._tab, self._show, self._cancelled = tab, show, threading.Event()
        self._latest = LatestResult(self._end, tab.fail, tab.is_open, WAITING)
        self.run = button(label, start, color="primary", **style)
        self.cancel = button("Cancel", self.stop, disabled=True, **style)
        html = f'<div role="progressbar" aria-label="{label}"><div></div></div>'
        self.bar = wide_pane(html, visible=False)

    def start(self, text: str, compute: Callable[[Callable[[], bool]], object]) -> None:
        """Start `compute`, whose argument says whether it is canceled; `text` for the status."""
        event = self._cancelled = threading.Event()
        self._set_running(True)
        self._tab.message.show("")
        self._tab.status.object = status_line(text)
        self._latest.request(lambda: (event, result_and_error(lambda: compute(event.is_set))))

    def stop(self) -> None:
        """Cancel what is running."""
        if self.bar.visible:
            self._cancelled.set()
            self._set_running(False)
            self._tab.status.object = status_line("Canceled.")

    def _end(self, ended: tuple[threading.Event, Outcome]) -> None:
        event, (result, error) = ended
        if event is self._cancelled and not event.is_set():
            self._set_running(False)
            self._tab.status.object = ""
            if error is None:
                self._show(result)
            else:
                self._tab.fail(error)

    def _set_running(self, running: bool) -> None:
        self.bar.visible = self.run.disabled = running
        self.cancel.disabled = not running


def is_computing() -> bool:
    """True while a computation is running."""
    return bool(_RUNNING)


def result_and_error(compute: Callable[[], object]) -> Outcome:
    """Result of `compute`, or its error; the log has one that isn't a visitor's."""
    try:
        return compute(), None
    except (ValueError, ImportError) as error:  # a visitor's mistake, or an extra that is missing
        return None, error if isinstance(error, ValueError) else ValueError(str(error))
    except Exception:  # noqa: BLE001 whatever it is, the server goes on
        traceback.print_exc()
        return None, ValueError("This could not be computed; see the server's log.")


@lru_cache(maxsize=1)
def _processes() -> ProcessPoolExecutor:
    """Worker processes, started by the first job; each keeps what it has compiled."""
    context = multiprocessing.get_context("spawn")  # a fork would copy the server's sockets
    return ProcessPoolExecutor(_MOST_JOBS, context, initializer=_prepare_process)


def _prepare_process() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's
    warnings.simplefilter("ignore")  # a job collects its own


def run_job(function: Callable[..., _Result], *arguments: object) -> _Result:
    """Result of `function` in a worker process; all is pickled. `ValueError` if it ends."""
    try:
        return _processes().submit(function, *arguments).result()
    except BrokenProcessPool:
        _processes.cache_clear()  # the next job has new processes
        raise ValueError("The computation ended early: too little memory?") from None


def stop_jobs() -> None:
    """End all worker processes, whose jobs nobody waits for any more."""
    if _processes.cache_info().currsize:
        _processes().shutdown(wait=False, cancel_futures=True)
        _processes.cache_clear()
    for process in multiprocessing.active_children():
        process.kill()
