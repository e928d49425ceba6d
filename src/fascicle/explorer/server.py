"""Server of the explorer, for this machine alone unless another address is given.

Panel's, with logs of single lines and a check of each request: Bokeh checks
the `Origin` of a websocket alone, but pages of strangers can make a browser ask for anything here.
They can't forge `Host`, the stranger's name even if that points at this machine (DNS rebinding).
"""

import asyncio
import contextlib
import errno
import ipaddress
import logging
import re
import secrets
import signal
import socket
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel as pn
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.server.util import bind_sockets
from panel.io.application import build_applications
from panel.io.resources import DIST_DIR
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.iostream import StreamClosedError
from tornado.routing import Matcher, Rule
from tornado.web import Application, OutputTransform, RequestHandler
from tornado.websocket import WebSocketClosedError

from ..io.sanitize import sanitize_line
from ..report.page import render
from .link import from_query, has_state
from .page import Page, prepare_document
from .state import Session, View
from .tab import stop_jobs
from .widgets import column, page_colors, page_css


PORT = 5006  # Bokeh's
_ATTEMPTS = 20  # ports that are tried if the first is taken
_LARGEST_MESSAGE = 16 * 2**20  # bytes from a browser: an uploaded file and its coding
_CLOSED_SESSION = 15_000  # ms until a closed session is freed
_LINE = 300  # characters of a line in the terminal
_SENDING = 0.02  # s for the loop to send a page; a longer pause would delay the next visitor
_LOCAL = ("127.0.0.1", "localhost", "::1")  # only this machine reaches them
_ANY_ADDRESS = ("0.0.0.0", "::")  # noqa: S104 compared, not bound
_HOST = re.compile(r"(?P<name>\[[0-9a-f:.%]+\]|[^\s@/#?\[\]:]+)(?::\d{1,5})?")
# of Panel, to embed the page elsewhere and to import modules: the explorer needs none
_CLOSED = ("/autoload.js", "/components/", "/metadata")
_SESSION_NAMES = {"bokeh-session-id", "bokeh-token"}  # that two visitors would share


def serve(
    view: View,
    host: str = "127.0.0.1",
    port: int | None = None,
    show: bool = True,
    print_line: Callable[[str], None] = print,
    allowed: Sequence[str] = (),
) -> None:
    """Serve the explorer, with the `view` for each visitor, until Ctrl-C or SIGTERM.

    It listens on `host` and `port` (5006 or the next free one), and answers to `allowed` names
    besides its own, such as a proxy's; `show` opens a browser, `print_line` takes each line for the
    terminal. `OSError` where it can't listen there.
    """
    handler = logging.StreamHandler()
    handler.setFormatter(LineFormatter())
    for name in ("bokeh", "tornado.application"):
        log = logging.getLogger(name)
        log.handlers, log.propagate = [handler], False
    for name in ("bokeh", "tornado.access", "tornado.general"):
        logging.getLogger(name).setLevel(logging.ERROR)

    async def run() -> None:
        pn.extension()
        loop, stop = asyncio.get_running_loop(), asyncio.Event()
        loop.set_exception_handler(_handle_exception)
        server = start_server(view, host, port, allowed)
        for number in (signal.SIGINT, signal.SIGTERM):
            with contextlib.suppress(RuntimeError, ValueError):  # outside of the main thread
                loop.add_signal_handler(number, stop.set)
        server.start()
        if host not in _LOCAL:
            print_line(
                f"listening on {host}: anyone who reaches port {server.port} of this machine can"
                " use the explorer and its processor, without password or encryption."
            )
        name = "127.0.0.1" if host in _ANY_ADDRESS else f"[{host}]" if ":" in host else host
        print_line(f"fascicle explorer at http://{name}:{server.port}/ (Ctrl-C stops it)")
        if show:
            server.show("/")
        await stop.wait()
        # connections of open pages end with the loop, which is no error
        logging.getLogger("tornado.application").setLevel(logging.CRITICAL)
        server.stop()
        stop_jobs()

    with warnings.catch_warnings():
        # warnings are for the visitor, on the page: the terminal may be somebody else's
        warnings.simplefilter("ignore", UserWarning)
        asyncio.run(run())
    print_line("stopped.")


def start_server(
    view: View, host: str, port: int | None, allowed: Sequence[str] = ()
) -> BaseServer:
    """Server, not yet started; without a `port` on the first free one of 5006 to 5025, or any."""
    sockets, drawing = _bind(host, port), asyncio.Lock()
    app = BokehTornado(
        build_applications({"/": lambda: page(view, drawing)}, title="fascicle"),
        extra_websocket_origins=["*"],  # `reject_reason` checks it, and the host, too
        ico_path=str(DIST_DIR / "images" / "favicon.ico"),
        unused_session_lifetime_milliseconds=_CLOSED_SESSION,
        check_unused_sessions_milliseconds=2_000,
        websocket_max_message_size_bytes=_LARGEST_MESSAGE,
        sign_sessions=True,
        secret_key=secrets.token_bytes(32),
    )
    guard(app, host, allowed)
    http = HTTPServer(app, max_buffer_size=_LARGEST_MESSAGE)
    http.add_sockets(sockets)
    return BaseServer(IOLoop.current(), app, http)


def _bind(host: str, port: int | None) -> list[socket.socket]:
    """Sockets at the `port`, or at the first free one."""
    candidates = [port] if port is not None else [*range(PORT, PORT + _ATTEMPTS), 0]
    for number in candidates:
        try:
            sockets = bind_sockets(host, number)[0]
        except OSError as error:
            if error.errno != errno.EADDRINUSE or number == candidates[-1]:
                reason = error.strerror or str(error)
                raise OSError(f"can't listen on {host}, port {number}: {reason}.") from None
            continue
        # connections send each message at once: else the next one waits up to 40 ms for the
        # browser's receipt of the last (Nagle's algorithm and TCP's delayed receipts)
        for listener in sockets:
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return sockets
    raise AssertionError  # the last candidate returns or raises


def page(start: View, drawing: asyncio.Lock) -> pn.Column:
    """Page of one visitor: the view of its address, or the `start` view.

    It is empty until its browser is connected: a request without a browser costs little. Pages are
    drawn one at a time under the lock `drawing`, and each is sent before the next begins: the first
    visitor of many doesn't wait for the last.
    """
    arguments = (pn.state.session_args or {}).items()
    query = {key: values[0].decode("utf-8", "replace") for key, values in arguments if values}
    theme = query.get("theme", "")
    pn.config.global_css = [page_css(page_colors(theme))]
    shell = column()

    async def fill() -> None:
        async with drawing:
            view, opened, errors = from_query(query, start)
            session = Session(view, opened, pn.io.unlocked)
            shell.objects = [Page(session, theme, errors, not has_state(query)).panel]
            await asyncio.sleep(_SENDING)

    active = query.get("tab", start.tab)
    prepare_document(pn.state.curdoc, active, follow_preference=not theme)
    pn.state.onload(fill)
    return shell


def reject_reason(
    path: str, headers: Mapping[str, str], host: str, allowed: Sequence[str] = ()
) -> tuple[int, str] | None:
    """Status and sentence for a request to reject, or `None`; arguments as of `serve`."""
    requested = headers.get("Host", "").lower()
    name, allowed_names = _host_name(requested), set(map(_host_name, allowed))
    names = {*_LOCAL, *allowed_names}
    if host not in _LOCAL:
        names |= {host.lower(), socket.gethostname().lower(), socket.getfqdn().lower()}
        with contextlib.suppress(ValueError):
            ipaddress.ip_address(name)
            names.add(name)  # which no stranger can make to point elsewhere
    if name not in names:
        return 403, (
            f"This explorer isn't called `{sanitize_line(requested, 80)}`: this request may come"
            " from the page of a stranger. If the name is yours, start it with `--allow-host`."
        )
    # same name and port; a name that was allowed may stand before another server's port
    origin = headers.get("Origin", f"http://{requested}").lower().partition("://")[2]
    if origin != requested and _host_name(origin) not in allowed_names:
        return 403, "Only the explorer's own page may talk to it."
    closed = path.startswith(_CLOSED) or "%00" in path  # a NUL, at which the system's calls fail
    return (404, "This page doesn't exist.") if closed else None


def guard(app: Application, host: str, allowed: Sequence[str]) -> None:
    """Let a tornado `app` reject requests before any of its own rules, and protect its answers."""

    class RejectedRequests(Matcher):
        """Requests with a `reject_reason`."""

        def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
            reason = reject_reason(request.path, request.headers, host, allowed)
            if _SESSION_NAMES & {*map(str.lower, (*request.arguments, *request.headers))}:
                reason = reason or (403, "A link can't choose the session it opens.")
            if request.host.startswith("["):
                # Panel splits it at the colon: an IPv6 address would end in a page of status 500
                request.host = "localhost" + request.host.partition("]")[2]
            return None if reason is None else {"target_kwargs": {"reason": reason}}

    app.default_router.rules.insert(0, Rule(RejectedRequests(), _RejectPage))
    app.add_transform(_ProtectedAnswer)


class _ProtectedAnswer(OutputTransform):
    """Headers of every answer: no other site shows it in a frame, no browser guesses its type."""

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        headers["Content-Security-Policy"] = "frame-ancestors 'self'"
        headers["X-Content-Type-Options"] = "nosniff"
        return status_code, headers, chunk


class _RejectPage(RequestHandler):
    """Answers a rejected request by a page with the reason, and its status."""

    def initialize(self, reason: tuple[int, str]) -> None:
        self._reason = reason

    def prepare(self) -> None:
        status, text = self._reason
        self.set_status(status)
        title = "This explorer can't be opened like that"
        self.finish(render("rejected.html", title=title, reason=text, footer="fascicle"))


def _host_name(host: str) -> str:
    """Name in a `Host` header, without its port; empty where there is none."""
    match = _HOST.fullmatch(host.lower())
    return match["name"].strip("[]").rstrip(".") if match else ""


class LineFormatter(logging.Formatter):
    """Formats a log record as one line, without its traceback: its text is a visitor's."""

    def format(self, record: logging.LogRecord) -> str:
        text = record.getMessage().split("\n", 1)[0]
        error = record.exc_info[1] if record.exc_info else None
        reason = f": {type(error).__name__}: {error}" if error else ""
        return sanitize_line(f"fascicle explorer: {text}{reason}", _LINE)


def _handle_exception(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Report an exception of the loop, unless it only says that a page was closed."""
    if not isinstance(context.get("exception"), StreamClosedError | WebSocketClosedError):
        loop.default_exception_handler(context)
