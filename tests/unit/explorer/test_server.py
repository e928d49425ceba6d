"""Ports that others have, pages in the order of their visitors, and what the log says."""

import asyncio
import logging
import socket
from types import SimpleNamespace

import pytest
from tornado.ioloop import IOLoop

import fascicle as fs
from fascicle.explorer import server
from fascicle.explorer.state import View


SHOWN = View("kim2021_figure_6", fs.example("kim2021_figure_6"))


@pytest.fixture
def taken():
    """A port that somebody listens on."""
    with socket.socket() as somebody:
        somebody.bind(("127.0.0.1", 0))
        somebody.listen()
        yield somebody.getsockname()[1]


# tornado leaves the socket open that it couldn't bind
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_where_somebody_was_faster_the_next_port_is_taken(taken, monkeypatch):
    free, asked = server.free_port, []

    def seemed_free(host, port):
        asked.append(port)
        return taken if len(asked) == 1 else free(host, port)

    monkeypatch.setattr(server, "free_port", seemed_free)
    loop = IOLoop(make_current=False)
    try:
        started, port = server.listening(SHOWN, "127.0.0.1", None, loop)
        started.stop()
    finally:
        loop.close()
    assert len(asked) == 2 and port not in (0, taken)


def test_a_port_that_was_asked_for_is_not_another(taken):
    with pytest.raises(OSError, match=f"can't listen on 127.0.0.1, port {taken}"):
        server.free_port("127.0.0.1", taken)


class Lock:
    """A visitor's session: what was drawn is sent a while after."""

    def __init__(self, name, events):
        self.name, self.events = name, events

    async def with_document_locked(self, draw, *arguments):
        draw(*arguments)
        await asyncio.sleep(0.01)  # the socket is slower than the loop
        self.events.append(f"{self.name} sent")


def test_a_page_is_sent_before_the_next_one_is_drawn(caplog):
    events = []

    def drawn(name):
        events.append(f"{name} drawn")
        if name == "second":
            raise RuntimeError(name)

    async def visit():
        queue = server.Openings()
        for name in ("first", "second", "gone", "last"):
            session = Lock(name, events)
            context = SimpleNamespace(session=session, destroyed=name == "gone")
            doc = SimpleNamespace(session_context=context)
            queue.add(doc, lambda name=name: drawn(name))
        while "last sent" not in events:
            await asyncio.sleep(0.01)

    with caplog.at_level(logging.CRITICAL, "fascicle.explorer.server"):
        asyncio.run(asyncio.wait_for(visit(), 30))
    assert events == [
        f"{name} {what}" for name in ("first", "second", "last") for what in ("drawn", "sent")
    ]


def test_an_error_of_the_web_server_is_one_line_that_shows_every_sign():
    record = logging.LogRecord("bokeh", logging.ERROR, "", 1, "wrong\n message: %r", ("x" * 900,),
                               (ValueError, ValueError("a\nb\x1b[31m"), None))  # fmt: skip
    line = server._OneLine().format(record)
    assert line.startswith("fascicle explorer: wrong: ValueError: a b") and "\x1b" not in line
    assert "\n" not in line and "x" * 9 not in line
