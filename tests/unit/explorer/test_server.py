"""Requests that a stranger's page makes a browser send; ports in use, and lines of the log."""

import asyncio
import gc
import logging
import socket

import pytest

import fascicle as fs
from fascicle.explorer import server
from fascicle.explorer.server import reject_reason
from fascicle.explorer.state import View


VIEW = View("kim2021_figure_6", fs.example("kim2021_figure_6"))
OWN = "127.0.0.1:5006"


def status(host=OWN, path="/", listens="127.0.0.1", allowed=(), **headers):
    """Status of a rejection; 0 without one."""
    reason = reject_reason(path, {"Host": host} | headers, listens, allowed)
    if reason is None:
        return 0
    assert "\n" not in reason[1] and len(reason[1]) < 400
    return reason[0]


@pytest.mark.parametrize(
    "host",
    ["evil.example:5006", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example:5006",
     "10.0.0.1:5006", "127.0.0.1@evil.example", "evil.example@127.0.0.1", "evil.example#127.0.0.1",
     "", ":5006", "[bad", "0.0.0.0:5006", "a" * 60_000, "evil\u202e.example"],
)  # fmt: skip
def test_a_name_that_points_here_by_rebinding_is_rejected(host):
    # page, websocket and script alike
    assert status(host) == status(host, "/ws", Origin=f"http://{host}") == 403
    assert status(host, "/static/js/bokeh.min.js") == 403


def test_own_and_allowed_names_and_addresses_are_answered():
    for host in (OWN, "127.0.0.1", "localhost:5006", "LOCALHOST:8080", "localhost.", "[::1]:5006"):
        assert status(host) == 0
    assert status("lab.example:5006", allowed=["lab.example"]) == 0
    assert status("lab.example", listens="192.0.2.7", allowed=["other.example"]) == 403
    assert status("192.0.2.7:5006", listens="192.0.2.7") == 0
    assert status("203.0.113.9:5006", listens="0.0.0.0") == 0  # noqa: S104 what is tested
    assert status("evil.example", listens="0.0.0.0") == 403  # noqa: S104 what is tested


@pytest.mark.parametrize(
    ("origin", "expected"),
    [(f"http://{OWN}", 0), ("http://evil.example", 403), ("http://localhost:3000", 403),
     ("http://127.0.0.1:3000", 403), ("null", 403), ("http://evil.example/127.0.0.1:5006", 403),
     ("http://[bad", 403), ("https://lab.example", 403)],
)  # fmt: skip
def test_a_websocket_is_opened_by_the_page_itself(origin, expected):
    assert status(path="/ws", Origin=origin) == expected


def test_a_page_behind_another_port_or_an_allowed_proxy_opens_a_websocket():
    assert status("localhost:8080", "/ws", Origin="http://localhost:8080") == 0
    assert status(path="/ws", allowed=["lab.example"], Origin="https://lab.example") == 0


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
        with pytest.raises(OSError, match=str(used)):
            asyncio.run(start(used))
    gc.collect()  # sockets


def test_an_error_of_the_web_server_is_one_line_without_hidden_characters():
    record = logging.LogRecord("bokeh", logging.ERROR, "", 1, "wrong\n message: %r", ("x" * 900,),
                               (ValueError, ValueError("a\nb\x1b[31m"), None))  # fmt: skip
    line = server.LineFormatter().format(record)
    assert line.startswith("fascicle explorer: wrong: ValueError: a b") and "\x1b" not in line
    assert "\n" not in line and "x" * 9 not in line
