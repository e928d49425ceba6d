"""Ports in use, and lines of the log."""

import asyncio
import gc
import logging
import socket

import pytest

import fascicle as fs
from fascicle.explorer import server
from fascicle.explorer.state import View


VIEW = View("kim2021_figure_6", fs.example("kim2021_figure_6"))


# tornado leaves the socket open that it couldn't bind
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_next_free_port_is_used_unless_one_is_given(monkeypatch):
    async def start(port):
        started = server.start_server(VIEW, "127.0.0.1", port)
        number = started.port
        started.stop()
        return number

    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        used = other.getsockname()[1]
        monkeypatch.setattr(server, "PORT", used)
        assert asyncio.run(start(None)) not in (0, used)
        with pytest.raises(OSError, match=f"can't listen on 127.0.0.1, port {used}"):
            asyncio.run(start(used))
    gc.collect()  # sockets


def test_an_error_of_the_web_server_is_one_line_without_hidden_characters():
    record = logging.LogRecord("bokeh", logging.ERROR, "", 1, "wrong\n message: %r", ("x" * 900,),
                               (ValueError, ValueError("a\nb\x1b[31m"), None))  # fmt: skip
    line = server.LineFormatter().format(record)
    assert line.startswith("fascicle explorer: wrong: ValueError: a b") and "\x1b" not in line
    assert "\n" not in line and "x" * 9 not in line
