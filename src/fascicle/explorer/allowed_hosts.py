"""Who may ask the server, and for what: decided before anything is made of a request.

A browser asks for whatever the page of a stranger tells it to, also of a server that listens on
its own machine alone. What such a page can't forge are three headers: `Host`, the name in the
address, which stays the stranger's where their name is made to point at this machine (DNS
rebinding); `Origin`, whose page opens a websocket; and `Sec-Fetch-…`, from where and what for.
"""

import contextlib
import ipaddress
import re
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qsl

from tornado.routing import Matcher, Rule
from tornado.web import RequestHandler

from ..io.sanitize import sanitize_line
from ..reports.page import Page
from .link import LONGEST


LOOPBACK = ("127.0.0.1", "localhost", "::1")
EVERYWHERE = ("0.0.0.0", "::")  # noqa: S104 compared, not bound
_MOST_KEYS, _LONGEST_VALUE = 64, 1000  # of a link; the packed file alone is longer
_WHOLE_NUMBER = 15  # digits: Panel makes numbers of such values, and fails where Python does
_HOST = re.compile(r"(?P<name>\[[0-9a-f:.%]+\]|[^\s@/#?\[\]:]+)(?::\d{1,5})?")
_FRAMES = ("iframe", "frame", "embed", "object")
# for other sites to embed the page, and for modules to bring files: nothing here uses either
_CLOSED = ("/autoload.js", "/components/", "/metadata")


@dataclass(frozen=True)
class Names:
    """The names that a server answers to, `own` and `allowed` besides; `addresses` where any
    address may be in the browser's bar: no stranger's name is an address.
    """

    own: frozenset[str]
    allowed: frozenset[str] = field(default_factory=frozenset)
    addresses: bool = False

    def have(self, host: str) -> bool:
        """Whether a `Host` header [-] names this server, whatever port it was forwarded from."""
        name = _name(host)
        return name in self.own or name in self.allowed or (self.addresses and _is_address(name))


def names_of(host: str, allowed: Iterable[str] = ()) -> Names:
    """What a server that listens on `host` [-] is called, `allowed` names [-] besides."""
    own = {host.lower(), "localhost", "127.0.0.1", "::1"}
    if host not in LOOPBACK:
        own |= {socket.gethostname().lower(), socket.getfqdn().lower()} | _own_addresses()
    also = frozenset(_name(one) for one in allowed)
    return Names(frozenset(own - set(EVERYWHERE)), also, addresses=host in EVERYWHERE)


def refusal(request: Any, names: Names) -> tuple[int, str] | None:
    """Why a request is refused.

    **Arguments:**

    - `request`: tornado's: `host`, `path`, `query` and `headers` [-].
    - `names`: what the server is called [-].

    **Returns:** the status and a sentence [-], or `None` where it isn't.
    """
    if not names.have(request.host):
        shown = sanitize_line(request.host, 80)
        return 403, (
            f"This explorer isn't called `{shown}`, so a page of somebody else may be behind this "
            f"request. If the name is yours, start it with `--allow-host {_name(shown)}`."
        )
    return (
        _other_page(request.host, request.headers, names)
        or _closed(request.path)
        or _bad_link(request.path, request.query)
    )


def guard(app: Any, names: Names) -> None:
    """Let a tornado `app` [-] refuse what `refusal` does, before any of its own rules."""
    app.default_router.rules.insert(0, Rule(_Refusing(names), _Refused))


class _Refusing(Matcher):
    """Matches what is refused."""

    def __init__(self, names: Names):
        self._names = names

    def match(self, request: Any) -> dict[str, Any] | None:
        found = refusal(request, self._names)
        if found is not None:
            return {"target_kwargs": {"refused": found}}
        if request.host.startswith("["):
            # Panel splits it at the colon: an IPv6 address would end in a page of status 500
            request.host = "localhost" + request.host.partition("]")[2]
        return None


class _Refused(RequestHandler):
    """A page that says why."""

    def initialize(self, refused: tuple[int, str]) -> None:
        self._status, self._text = refused

    def prepare(self) -> None:
        page = Page("This explorer can't be opened like that")
        page.paragraph(self._text)
        page.html('<p><a href="/" target="_blank">Open the explorer</a></p>')
        self.set_status(self._status)
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(page.text("fascicle"))


def _other_page(host: str, headers: Mapping[str, str], names: Names) -> tuple[int, str] | None:
    origin = headers.get("Origin")
    if origin is not None:
        # same name and port; a name that was allowed may stand before another server's port
        there = origin.lower().partition("://")[2]
        if there != host.lower() and _name(there) not in names.allowed:
            return 403, "Only the explorer's own page may talk to it."
    where, what = headers.get("Sec-Fetch-Site"), headers.get("Sec-Fetch-Mode")
    if where in ("cross-site", "same-site") and what != "navigate":
        return 403, "Only the explorer's own page may ask for parts of it."
    if where == "cross-site" and headers.get("Sec-Fetch-Dest") in _FRAMES:
        return 403, "The explorer doesn't open inside another site's page."
    return None


def _closed(path: str) -> tuple[int, str] | None:
    if path.startswith(_CLOSED):
        return 404, "There is nothing here."
    return None


def _bad_link(path: str, query: str) -> tuple[int, str] | None:
    try:
        given = parse_qsl(query, keep_blank_values=True, max_num_fields=_MOST_KEYS)
    except ValueError:
        return 400, f"The link may have at most {_MOST_KEYS} parts."
    for key, value in given:
        name, most = sanitize_line(key, 40), LONGEST if key == "file" else _LONGEST_VALUE
        if len(key) + len(value) > most + len("file"):
            return (
                400,
                f"In the link, `{name}` must be at most {most} characters, got {len(value)}.",
            )
        if value[:1] in ("[", "{") or (value.isdigit() and not _is_short(value)):
            return 400, f"In the link, `{name}` has a value that no part of it has."
        if path == "/" and key.startswith("bokeh-"):
            return 400, f"In the link, `{name}` is none of its parts."
    return None


def _is_short(digits: str) -> bool:
    return digits.isascii() and len(digits) <= _WHOLE_NUMBER


def _name(host: str) -> str:
    """The name in a `Host` header, without its port; empty where it is none."""
    found = _HOST.fullmatch(host.lower())
    return found["name"].strip("[]").rstrip(".") if found else ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _own_addresses() -> set[str]:
    found = set()
    with contextlib.suppress(OSError):
        found |= {str(entry[4][0]) for entry in socket.getaddrinfo(socket.gethostname(), None)}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, contextlib.suppress(OSError):
        probe.connect(("192.0.2.1", 9))  # reserved for documentation: nothing is sent
        found.add(str(probe.getsockname()[0]))
    return found
