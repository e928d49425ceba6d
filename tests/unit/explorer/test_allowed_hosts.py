"""What a stranger's page can make a browser ask for is refused before anything is made of it."""

from types import SimpleNamespace

import pytest
from tornado.httputil import HTTPHeaders

from fascicle.explorer.allowed_hosts import AllowedHosts, reject_reason
from fascicle.explorer.link import LONGEST, to_query
from fascicle.explorer.state import view_of


OWN = "127.0.0.1:5006"


def status(host=OWN, path="/", query="", listens="127.0.0.1", allowed=(), **headers):
    """The status of a refusal; 0 where there is none."""
    given = HTTPHeaders({name.replace("_", "-"): value for name, value in headers.items()})
    request = SimpleNamespace(host=host, path=path, query=query, headers=given)
    found = reject_reason(request, AllowedHosts.of(listens, allowed))
    if found is None:
        return 0
    assert "\n" not in found[1]
    assert len(found[1]) < 400
    return found[0]


@pytest.mark.parametrize(
    "host", [OWN, "127.0.0.1", "localhost:5006", "LOCALHOST:8080", "localhost.", "[::1]:5006"]
)
def test_its_own_names_are_answered(host):
    assert status(host) == 0


@pytest.mark.parametrize(
    "host",
    ["evil.example:5006", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example:5006",
     "10.0.0.1:5006", "127.0.0.1@evil.example", "evil.example@127.0.0.1", "evil.example#127.0.0.1",
     "", ":5006", "[bad",
     "0.0.0.0:5006", "xn--localhost-abc", "a" * 60_000, "evil\u202e.example"],
)  # fmt: skip
def test_a_name_that_was_made_to_point_here_is_refused(host):
    assert status(host) == 403
    # page, script and websocket alike
    assert status(host, "/ws", Origin=f"http://{host}") == 403
    assert status(host, "/static/js/bokeh.min.js") == 403


def test_a_name_can_be_allowed_and_an_address_where_it_listens_to_all():
    assert status("lab.example:5006", allowed=["lab.example"]) == 0
    assert status("lab.example", listens="192.0.2.7", allowed=["other.example"]) == 403
    assert status("192.0.2.7:5006", listens="192.0.2.7") == 0
    assert status("203.0.113.9:5006", listens="0.0.0.0") == 0  # noqa: S104 what is tested
    assert status("evil.example", listens="0.0.0.0") == 403  # noqa: S104 what is tested


@pytest.mark.parametrize(
    ("origin", "found"),
    [(f"http://{OWN}", 0), ("http://evil.example", 403), ("http://localhost:3000", 403),
     ("http://127.0.0.1:3000", 403), ("null", 403), ("http://evil.example/127.0.0.1:5006", 403),
     ("http://[bad", 403)],
)  # fmt: skip
def test_a_websocket_is_opened_by_the_page_itself(origin, found):
    assert status(path="/ws", Origin=origin) == found


def test_a_page_behind_another_port_or_an_allowed_proxy_may():
    assert status("localhost:8080", "/ws", Origin="http://localhost:8080") == 0
    assert status(path="/ws", allowed=["lab.example"], Origin="https://lab.example") == 0
    assert status(path="/ws", Origin="https://lab.example") == 403


@pytest.mark.parametrize(
    ("site", "mode", "dest", "found"),
    [("cross-site", "no-cors", "image", 403), ("same-site", "cors", "empty", 403),
     ("cross-site", "websocket", "websocket", 403), ("cross-site", "navigate", "iframe", 403),
     ("cross-site", "navigate", "document", 0), ("none", "navigate", "document", 0),
     ("same-origin", "cors", "script", 0)],
)  # fmt: skip
def test_another_sites_page_may_link_to_it_and_no_more(site, mode, dest, found):
    given = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode, "Sec_Fetch_Dest": dest}
    assert status(**given) == found


@pytest.mark.parametrize("path", ["/autoload.js", "/components/this/x/css/y", "/metadata"])
def test_doors_that_nothing_uses_are_closed(path):
    assert status(path=path) == 404


@pytest.mark.parametrize(
    "query",
    ["units=" + "9" * 5000, "pressures=" + "9" * 5000, "utm=" + "9" * 16, "x=%C2%B2",
     "file=" + "9" * 5000, "file=" + "A" * (LONGEST + 10), "name=" + "x" * 2000, "x=[[1]]",
     "x=%7B1%7D", "&".join(f"a{i}=1" for i in range(100)), "bokeh-session-id=mine",
     "bokeh-token=eJx", "k" * 5000 + "=1"],
)  # fmt: skip
def test_a_link_that_no_explorer_made_is_said_to_be_bad(query):
    assert status(query=query) == 400


def test_links_that_the_explorer_makes_and_what_sites_add_pass():
    from urllib.parse import urlencode

    import fascicle as fs

    for name in ("kim2021_figure_6", "kim2021_bundle_1_4"):
        view = view_of(fs.example(name), "own")
        assert status(query=urlencode(to_query(view)) + "&theme=dark&fbclid=Iw2x3&page=12") == 0
    assert status(query="strain=0.1&units=60,1&name=2024") == 0
