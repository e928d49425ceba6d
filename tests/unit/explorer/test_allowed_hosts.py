"""Requests that a stranger's page makes a browser send are rejected before they are read."""

from types import SimpleNamespace
from urllib.parse import urlencode

import pytest
from tornado.httputil import HTTPHeaders

import fascicle as fs
from fascicle.explorer.allowed_hosts import AllowedHosts, reject_reason
from fascicle.explorer.link import LONGEST, to_query
from fascicle.explorer.state import view_of


OWN = "127.0.0.1:5006"


def status(host=OWN, path="/", query="", listens="127.0.0.1", allowed=(), **headers):
    """Status of a rejection; 0 without one."""
    fields = HTTPHeaders({name.replace("_", "-"): value for name, value in headers.items()})
    request = SimpleNamespace(host=host, path=path, query=query, headers=fields)
    reason = reject_reason(request, AllowedHosts.of(listens, allowed))
    if reason is None:
        return 0
    assert "\n" not in reason[1] and len(reason[1]) < 400
    return reason[0]


@pytest.mark.parametrize(
    "host", [OWN, "127.0.0.1", "localhost:5006", "LOCALHOST:8080", "localhost.", "[::1]:5006"]
)
def test_own_names_are_answered(host):
    assert status(host) == 0


@pytest.mark.parametrize(
    "host",
    ["evil.example:5006", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example:5006",
     "10.0.0.1:5006", "127.0.0.1@evil.example", "evil.example@127.0.0.1", "evil.example#127.0.0.1",
     "", ":5006", "[bad", "0.0.0.0:5006", "xn--localhost-abc", "a" * 60_000,
     "evil\u202e.example"],
)  # fmt: skip
def test_a_name_that_points_here_by_rebinding_is_rejected(host):
    # page, websocket and script alike
    assert status(host) == status(host, "/ws", Origin=f"http://{host}") == 403
    assert status(host, "/static/js/bokeh.min.js") == 403


def test_allowed_names_and_addresses():
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


@pytest.mark.parametrize(
    ("site", "mode", "dest", "expected"),
    [("cross-site", "no-cors", "image", 403), ("same-site", "cors", "empty", 403),
     ("cross-site", "websocket", "websocket", 403), ("cross-site", "navigate", "iframe", 403),
     ("cross-site", "navigate", "document", 0), ("none", "navigate", "document", 0),
     ("same-origin", "cors", "script", 0)],
)  # fmt: skip
def test_other_sites_may_link_here_and_no_more(site, mode, dest, expected):
    headers = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode, "Sec_Fetch_Dest": dest}
    assert status(**headers) == expected


@pytest.mark.parametrize(
    "query",
    ["units=" + "9" * 5000, "pressures=" + "9" * 5000, "utm=" + "9" * 16, "x=%C2%B2",
     "file=" + "9" * 5000, "file=" + "A" * (LONGEST + 10), "name=" + "x" * 2000, "x=[[1]]",
     "x=%7B1%7D", "&".join(f"a{i}=1" for i in range(100)), "bokeh-session-id=mine",
     "bokeh-token=eJx", "k" * 5000 + "=1"],
)  # fmt: skip
def test_a_link_that_no_explorer_made_is_rejected(query):
    assert status(query=query) == 400


def test_links_of_the_explorer_pass_with_the_keys_that_sites_add():
    for name in ("kim2021_figure_6", "kim2021_bundle_1_4"):
        view = view_of(fs.example(name), "own")
        assert status(query=urlencode(to_query(view)) + "&theme=dark&fbclid=Iw2x3&page=12") == 0
    assert status(query="strain=0.1&units=60,1&name=2024") == 0
