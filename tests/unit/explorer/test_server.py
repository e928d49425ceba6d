"""Ports that others have, and what the log says."""

import asyncio
import gc
import logging
import socket

import pytest

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
def test_the_next_port_is_taken_unless_one_was_asked_for(taken, monkeypatch):
    monkeypatch.setattr(server, "PORT", taken)

    async def start(port):
        started = server.start_server(SHOWN, "127.0.0.1", port)
        started.stop()
        return started.port

    assert asyncio.run(start(None)) not in (0, taken)
    with pytest.raises(OSError, match=f"can't listen on 127.0.0.1, port {taken}"):
        asyncio.run(start(taken))
    gc.collect()  # sockets


def test_an_error_of_the_web_server_is_one_line_that_shows_every_sign():
    record = logging.LogRecord("bokeh", logging.ERROR, "", 1, "wrong\n message: %r", ("x" * 900,),
                               (ValueError, ValueError("a\nb\x1b[31m"), None))  # fmt: skip
    line = server.LineFormatter().format(record)
    assert line.startswith("fascicle explorer: wrong: ValueError: a b") and "\x1b" not in line
    assert "\n" not in line and "x" * 9 not in line
