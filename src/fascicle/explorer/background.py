"""Slow computations beside the server's loop, so that a visitor's fit stops nobody's slider."""

import traceback
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import panel as pn


_WORKERS = ThreadPoolExecutor(2, thread_name_prefix="fascicle")
_RUNNING: set["Future[Any]"] = set()


def is_computing() -> bool:
    """Whether any computation is running."""
    return bool(_RUNNING)


class LatestResult:
    """Result of the latest request; results of earlier ones are dropped."""

    def __init__(self, show: Callable[[Any], None], fail: Callable[[str], None]):
        """**Arguments:** `show`: takes a result, on the loop; `fail`: takes an error's message."""
        self._show, self._fail, self._count = show, fail, 0
        self._busy, self._next = False, None

    def request(self, compute: Callable[[], Any]) -> None:
        """Run `compute` beside the loop, and show what it returns unless there is a later one."""
        self._count += 1
        doc = pn.state.curdoc
        if doc is None or not doc.session_context:  # a notebook, or a test
            self._finish(self._count, _attempt(compute))
        elif self._busy:
            self._next = compute  # those between are skipped
        else:
            self._start(doc, compute)

    def _start(self, doc: Any, compute: Callable[[], Any]) -> None:
        self._busy, count = True, self._count

        def done(future: "Future[Any]") -> None:
            _RUNNING.discard(future)
            if doc.session_context and not doc.session_context.destroyed:
                doc.add_next_tick_callback(lambda: self._deliver(doc, count, future.result()))

        future = _WORKERS.submit(_attempt, compute)
        _RUNNING.add(future)
        future.add_done_callback(done)

    def _deliver(self, doc: Any, count: int, outcome: tuple[Any, str | None]) -> None:
        self._busy = False
        compute, self._next = self._next, None
        if compute is not None:
            self._start(doc, compute)
        else:
            self._finish(count, outcome)

    def _finish(self, count: int, outcome: tuple[Any, str | None]) -> None:
        result, message = outcome
        if count != self._count:
            return
        with pn.io.unlocked():  # one message to the browser
            if message is None:
                self._show(result)
            else:
                self._fail(message)


def _attempt(compute: Callable[[], Any]) -> tuple[Any, str | None]:
    """Result of `compute`, or the message of its error."""
    try:
        return compute(), None
    except ValueError as error:
        return None, str(error)
    except Exception:  # noqa: BLE001 whatever it is, the session goes on; the log has it
        traceback.print_exc()
        return None, "This could not be computed; see the server's log."
