"""Slow work beside the server's loop, so that one visitor's fit stops nobody's slider."""

import traceback
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock
from typing import Any, TypeVar

import jax
import numpy as np
import panel as pn


_WORKERS = ThreadPoolExecutor(2, thread_name_prefix="fascicle")
_RUNNING: set["Future[Any]"] = set()


def working() -> bool:
    """Whether anything is being computed [-]."""
    return bool(_RUNNING)


class Latest:
    """One result at a time: of what is asked for, only the newest is shown."""

    def __init__(self, show: Callable[[Any], None], fail: Callable[[str], None]):
        """**Arguments:**

        - `show`: takes a result [-], on the server's loop.
        - `fail`: takes the message of a `ValueError` [-], likewise.
        """
        self._show, self._fail, self._asked = show, fail, 0
        self._busy, self._next = False, None

    def ask(self, compute: Callable[[], Any]) -> None:
        """Compute beside the loop, and show the result unless another was asked for since."""
        self._asked += 1
        doc = pn.state.curdoc
        if doc is None or not doc.session_context:  # a notebook, or a test
            self._finish(self._asked, _tried(compute))
            return
        if self._busy:
            self._next = compute  # the ones between are skipped
            return
        self._start(doc, compute)

    def _start(self, doc: Any, compute: Callable[[], Any]) -> None:
        self._busy, asked = True, self._asked

        def done(future: "Future[Any]") -> None:
            _RUNNING.discard(future)
            if doc.session_context and not doc.session_context.destroyed:
                doc.add_next_tick_callback(lambda: self._landed(doc, asked, future.result()))

        future = _WORKERS.submit(_tried, compute)
        _RUNNING.add(future)
        future.add_done_callback(done)

    def _landed(self, doc: Any, asked: int, outcome: tuple[Any, str | None]) -> None:
        self._busy = False
        waiting, self._next = self._next, None
        if waiting is not None:
            self._start(doc, waiting)
            return
        self._finish(asked, outcome)

    def _finish(self, asked: int, outcome: tuple[Any, str | None]) -> None:
        found, message = outcome
        if asked != self._asked:
            return
        # all that follows goes to the browser as one message
        with pn.io.unlocked():
            if message is None:
                self._show(found)
            else:
                self._fail(message)


def _tried(compute: Callable[[], Any]) -> tuple[Any, str | None]:
    """What `compute` [-] gives, or why not [-]."""
    try:
        return compute(), None
    except ValueError as error:
        return None, str(error)
    except Exception:  # noqa: BLE001 whatever it is, the session goes on; the log has it
        traceback.print_exc()
        return None, "this could not be computed; the server's log says why."


T = TypeVar("T")
MOST = 64  # results; the largest, two maps of efficiency, take 0.25 MB
_KEPT: "OrderedDict[Any, Future[Any]]" = OrderedDict()
_LOCK = Lock()


def shared(compute: Callable[..., T], *arguments: Any) -> T:
    """What `compute` [-] gives for its `arguments` [-]: as it was kept, or computed now.

    Nobody may change what is returned. What raises isn't kept.
    """
    key = (compute, *_told(arguments))
    with _LOCK:
        found = _KEPT.get(key)
        first = found is None
        if found is None:
            found = _KEPT[key] = Future()
        _KEPT.move_to_end(key)
        while len(_KEPT) > MOST:
            _KEPT.popitem(last=False)
    if first:
        try:
            found.set_result(compute(*arguments))
        except BaseException as error:  # noqa: BLE001 whoever waits for it is told, too
            with _LOCK:
                _KEPT.pop(key, None)
            found.set_exception(error)
    return found.result()


def _told(arguments: Any) -> tuple[Any, Any]:
    """What `arguments` [-] are made of, to be compared: their kind, and each number's bits."""
    leaves, kind = jax.tree.flatten(arguments)
    exact = (one if isinstance(one, str) else np.asarray(one) for one in leaves)
    return kind, tuple(
        one if isinstance(one, str) else (one.dtype.str, one.shape, one.tobytes()) for one in exact
    )
