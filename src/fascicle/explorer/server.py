"""The server: on this machine alone unless told otherwise."""

import asyncio
import contextlib
import errno
import gc
import logging
import socket
import warnings
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import panel as pn
from panel.io.state import set_curdoc
from tornado.ioloop import IOLoop

from ..io.sanitize import sanitize_line
from .allowed_hosts import EVERYWHERE, LOOPBACK, guard, names_of
from .browser import attach
from .link import from_query
from .page import build, opening
from .state import Session, View
from .stopping import Stop
from .theme import NARROW, look_of, page_css


PORT = 5006
_TRIES = 20  # ports that are tried if the first is taken
_MESSAGE = 16 * 2**20  # bytes of one message from a browser: an uploaded file and its coding
_UNUSED = 15_000  # ms until a closed session is freed
_BETWEEN = 1e-3  # s between two pages that are drawn: what waits on the loop has its turn
_LINE = 300  # characters of a line in the terminal


def serve(
    view: View,
    host: str = "127.0.0.1",
    port: int | None = None,
    show: bool = True,
    say: Callable[[str], None] = print,
    allowed: Sequence[str] = (),
) -> None:
    """Serve the explorer until it is interrupted.

    **Arguments:**

    - `view`: what a visitor sees first [-].
    - `host`: the address to listen on [-].
    - `port`: the port [-]; left out, 5006 or the next free one.
    - `show`: whether a browser is opened [-].
    - `say`: takes each line for the terminal [-].
    - `allowed`: names besides its own that it answers to, a proxy's say [-].

    **Raises:** `OSError` where it can't listen there.
    """
    quiet_logs()
    with Stop(say) as stop, _loop() as loop, warnings.catch_warnings():
        # who reads the page is told there: the terminal is somebody else's
        warnings.simplefilter("ignore", UserWarning)
        pn.extension()
        server, chosen = listening(view, host, port, loop)
        guard(server._tornado, names_of(host, allowed))
        server.start()
        if host not in LOOPBACK:
            say(
                f"listening on {host}: whoever reaches this machine's port {chosen} can use the"
                " explorer, without password or encryption, and its processor with it."
            )
        url = f"http://{_shown(host)}:{chosen}/"
        say(f"fascicle explorer at {url} (Ctrl-C stops it)")
        if show:
            loop.call_later(0.1, _open, url)
        stop.runs(loop)
        # what is there before the first page is there to the end: no collection needs to look at it
        gc.collect()
        gc.freeze()
        try:
            loop.start()
        finally:
            gc.unfreeze()
        server.stop()
    say("stopped.")


def listening(view: View, host: str, port: int | None, loop: Any) -> tuple[Any, int]:
    """A server on a `loop` [-] and the port that it has [-]: where that is left open and somebody
    else was faster, the next free one. Other arguments as those of `serve`.
    """
    left, queue = _TRIES, Openings()
    while True:
        chosen = free_port(host, port)
        try:
            server = pn.serve(
                {"/": lambda: page(view, queue)},
                port=chosen,
                address=host,
                # whose page may open a websocket is the guard's to say
                websocket_origin=["*"],
                show=False,
                start=False,
                title="fascicle",
                verbose=False,
                threaded=False,
                loop=loop,
                unused_session_lifetime_milliseconds=_UNUSED,
                check_unused_sessions_milliseconds=2_000,
                websocket_max_message_size=_MESSAGE,
                http_server_kwargs={"max_buffer_size": _MESSAGE},
            )
        except OSError as error:
            left -= 1
            if error.errno != errno.EADDRINUSE or not left:
                raise
        else:
            return server, chosen


class Openings:
    """Pages that wait to be drawn: one after another, each sent before the next one is begun."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Any, Callable[[], None]]] = deque()
        self._busy = False

    def add(self, doc: Any, fill: Callable[[], None]) -> None:
        """Let `fill` [-] draw the page of a Bokeh document [-], once it is its turn."""
        self._waiting.append((doc, fill))
        if not self._busy:
            self._busy = True
            IOLoop.current().add_callback(self._run)

    async def _run(self) -> None:
        try:
            while self._waiting:
                doc, fill = self._waiting.popleft()
                if doc.session_context and not doc.session_context.destroyed:
                    with set_curdoc(doc):
                        await doc.session_context.session.with_document_locked(_logged, fill)
                # others' moves, and what was computed for the tab that was opened, come between
                await asyncio.sleep(_BETWEEN)
        finally:
            self._busy = False


def _logged(fill: Callable[[], None]) -> None:
    try:
        fill()
    except Exception:  # whatever it is, the next visitor's page is drawn
        logging.getLogger(__name__).exception("a page could not be drawn")


def quiet_logs() -> None:
    """Log of the web server: errors alone, a line each. Their text is whatever a visitor sent."""
    handler = logging.StreamHandler()
    handler.setFormatter(_OneLine())
    log = logging.getLogger("bokeh")
    log.handlers, log.propagate = [handler], False
    for name in ("bokeh", "tornado.access", "tornado.general"):
        logging.getLogger(name).setLevel(logging.ERROR)


class _OneLine(logging.Formatter):
    """A record as one line, without its traceback."""

    def format(self, record: logging.LogRecord) -> str:
        text = record.getMessage().split("\n", 1)[0]
        error = record.exc_info[1] if record.exc_info else None
        why = f": {type(error).__name__}: {error}" if error else ""
        return sanitize_line(f"fascicle explorer: {text}{why}", _LINE)


def page(start: View, queue: Openings) -> Any:
    """The page of one visitor, as the address asks for it; `start` is what is shown else [-], and
    `queue` holds the pages that wait to be drawn [-].

    It is empty until its browser is there: what asks for it and goes again costs nothing.
    """
    query = {
        key: values[0].decode("utf-8", "replace")
        for key, values in (pn.state.session_args or {}).items()
        if values
    }
    theme = "dark" if query.get("theme") == "dark" else "default"
    look = look_of(theme)
    pn.config.raw_css = [page_css(look)]
    shell = pn.Column(opening(look), sizing_mode="stretch_width", margin=0, stylesheets=[NARROW])

    def fill() -> None:
        view, refused = from_query(query, start)
        asked = "theme" in query
        shell.objects = [build(Session(view, pn.io.unlocked), theme, refused, asked)]

    doc = pn.state.curdoc
    attach(doc, prefers="theme" not in query)
    pn.state.onload(lambda: queue.add(doc, fill))
    return shell


def free_port(host: str, port: int | None) -> int:
    """The `port` [-] if it is free on `host` [-]; left out, the first free one from 5006 on."""
    tried = [port] if port is not None else [*range(PORT, PORT + _TRIES), 0]
    for one in tried:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, one))
            except OSError as error:
                if port is not None or one == 0:
                    why = error.strerror or str(error)
                    raise OSError(f"can't listen on {host}, port {one}: {why}.") from None
                continue
            return int(probe.getsockname()[1])
    raise OSError(f"no free port on {host}.")


def _shown(host: str) -> str:
    if host in EVERYWHERE:
        return "127.0.0.1"
    return f"[{host}]" if ":" in host else host


def _open(url: str) -> None:
    import webbrowser

    with contextlib.suppress(webbrowser.Error):
        webbrowser.open(url)


@contextlib.contextmanager
def _loop() -> Any:
    """A loop of its own, the current one meanwhile."""
    inner = asyncio.new_event_loop()
    inner.set_exception_handler(_unless_closed)
    asyncio.set_event_loop(inner)
    try:
        yield IOLoop.current()
    finally:
        asyncio.set_event_loop(None)


def _unless_closed(loop: Any, context: dict[str, Any]) -> None:
    """Report what went wrong on a `loop` [-], save that a page was closed meanwhile."""
    from tornado.iostream import StreamClosedError
    from tornado.websocket import WebSocketClosedError

    if not isinstance(context.get("exception"), StreamClosedError | WebSocketClosedError):
        loop.default_exception_handler(context)
