"""Ports that others have, or take at the last moment."""

import socket

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
