"""The server: warm before it says where it is, on this machine alone unless told otherwise."""

import asyncio
import contextlib
import logging
import signal
import socket
import threading
from collections.abc import Callable
from typing import Any

import panel as pn

from .address import from_query
from .look import look_of, page_css
from .page import build
from .state import Session, View


PORT = 5006
_TRIES = 20  # ports that are tried if the first is taken
_MESSAGE = 16 * 2**20  # bytes of one message from a browser: an uploaded file and its coding
_UNUSED = 15_000  # ms until a closed session is freed
_LOOPBACK = ("127.0.0.1", "localhost", "::1")


def serve(
    view: View,
    host: str = "127.0.0.1",
    port: int | None = None,
    show: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Serve the explorer until it is interrupted.

    **Arguments:**

    - `view`: what a visitor sees first [-].
    - `host`: the address to listen on [-].
    - `port`: the port [-]; left out, 5006 or the next free one.
    - `show`: whether a browser is opened [-].
    - `say`: takes each line for the terminal [-].

    **Raises:** `OSError` where it can't listen there.
    """
    logging.getLogger("bokeh").setLevel(logging.ERROR)
    logging.getLogger("tornado.access").setLevel(logging.ERROR)
    chosen = free_port(host, port)
    stop = _Stop()
    warm(view)
    pn.extension()
    url = f"http://{_shown(host)}:{chosen}/"
    with _loop() as loop:
        server = pn.serve(
            {"/": lambda: page(view)},
            port=chosen,
            address=host,
            websocket_origin=origins(host, chosen),
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
        server.start()
        if host not in _LOOPBACK:
            say(
                f"listening on {host}: whoever reaches this machine's port {chosen} can use the"
                " explorer, without password or encryption, and its processor with it."
            )
        say(f"fascicle explorer at {url} (Ctrl-C stops it)")
        if show:
            loop.call_later(0.1, _open, url)
        stop.ends(loop)
        if not stop.asked:
            loop.start()
        server.stop()
    say("stopped.")


class _Stop:
    """Ctrl-C as a wish: raised while JAX compiles, an interrupt would be swallowed there."""

    def __init__(self) -> None:
        self.asked, self._loop = False, None
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, self._wish)

    def ends(self, loop: Any) -> None:
        """End this `loop` [-] when it is wished."""
        self._loop = loop

    def _wish(self, *_: object) -> None:
        self.asked = True
        if self._loop is not None:
            self._loop.add_callback_from_signal(self._loop.stop)


def page(start: View) -> Any:
    """The page of one visitor, as the address asks for it; `start` is what is shown else [-]."""
    query = {
        key: values[0].decode("utf-8", "replace")
        for key, values in (pn.state.session_args or {}).items()
        if values
    }
    theme = "dark" if query.get("theme") == "dark" else "default"
    view, refused = from_query(query, start)
    pn.config.raw_css = [page_css(look_of(theme))]
    return build(Session(view, pn.io.unlocked), theme, refused)


def warm(view: View) -> None:
    """Compile what the sliders call, with the shapes that they call it with."""
    from .muscle_curves import picture, widest
    from .tube import solid

    found = picture(
        view.muscle, view.pressure, view.strain, view.supply, widest(view.muscle, view.supply)
    )
    solid(view.muscle, found, view.strain)


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


def origins(host: str, port: int) -> list[str]:
    """The names [-] a page may come from to talk to this server: a stranger's page may not."""
    names = {"localhost", "127.0.0.1"}
    if host not in _LOOPBACK:
        names |= {host, socket.gethostname(), socket.getfqdn()}
        with contextlib.suppress(OSError):
            found = socket.getaddrinfo(socket.gethostname(), None)
            names |= {str(entry[4][0]) for entry in found if ":" not in str(entry[4][0])}
        names |= _own_address()
    return sorted(f"{name}:{port}" for name in names)


def _own_address() -> set[str]:
    """The address [-] of this machine on its way out; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # reserved for documentation
            return {str(probe.getsockname()[0])}
        except OSError:
            return set()


def _shown(host: str) -> str:
    if host in ("0.0.0.0", "::"):  # noqa: S104 compared, not bound
        return "127.0.0.1"
    return f"[{host}]" if ":" in host else host


def _open(url: str) -> None:
    import webbrowser

    with contextlib.suppress(webbrowser.Error):
        webbrowser.open(url)


@contextlib.contextmanager
def _loop() -> Any:
    """A loop of its own, the current one meanwhile."""
    from tornado.ioloop import IOLoop

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
