"""Checks of each request before the server handles it.

Bokeh checks the `Origin` of a websocket and nothing else. But a browser sends requests for any
page, also to a server that listens on its own machine alone, and pages of strangers can't forge
three headers: `Host`, the name in the address, which stays the stranger's if that name is made to
point at this machine (DNS rebinding); `Origin`, of the page that opens a websocket; and
`Sec-Fetch-…`, the source and the purpose of a request. Links that no explorer made are rejected,
too: Panel would fail on them, or read them as its own.
"""

import ipaddress
import re
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl

from tornado.routing import Matcher, Rule
from tornado.web import OutputTransform, RequestHandler

from ..io.sanitize import sanitize_line
from ..report.page import render
from .link import LONGEST


LOOPBACK = ("127.0.0.1", "localhost", "::1")  # only this machine reaches them
ANY_ADDRESS = ("0.0.0.0", "::")  # noqa: S104 compared, not bound
_MOST_KEYS, _LONGEST_VALUE = 64, 1000  # of a link; only a packed file is longer
_FILES = ("file", "scenario_file")  # keys of packed files
_MOST_DIGITS = 15  # Panel converts digits to numbers, and fails where Python does
_HOST = re.compile(r"(?P<name>\[[0-9a-f:.%]+\]|[^\s@/#?\[\]:]+)(?::\d{1,5})?")
_FRAMES = ("iframe", "frame", "embed", "object")  # elements that show a page inside another
# of Panel, to embed the page elsewhere and to serve files of modules: the explorer needs none
_CLOSED = ("/autoload.js", "/components/", "/metadata")
Reason = tuple[int, str]  # status and sentence of a rejected request


@dataclass(frozen=True)
class AllowedHosts:
    """Names that a server answers to: its `own`, and `allowed` ones.

    `addresses`: also to any IP address, which no stranger can make to point elsewhere.
    """

    own: frozenset[str]
    allowed: frozenset[str] = frozenset()
    addresses: bool = False

    @classmethod
    def of(cls, host: str, allowed: Iterable[str] = ()) -> "AllowedHosts":
        """Names of a server that listens on `host`, and `allowed` ones."""
        own_names, local = {"localhost", "127.0.0.1", "::1"}, host in LOOPBACK
        if not local:
            own_names |= {host.lower(), socket.gethostname().lower(), socket.getfqdn().lower()}
        return cls(frozenset(own_names), frozenset(map(_host_name, allowed)), addresses=not local)

    def matches(self, host: str) -> bool:
        """True for a `Host` header with a name of this server, and any port, as one forwarded."""
        name = _host_name(host)
        return name in self.own | self.allowed or (self.addresses and _is_ip_address(name))


def reject_reason(request: Any, hosts: AllowedHosts) -> Reason | None:
    """Reason to reject a tornado `request` (host, page, path or link), or `None`."""
    if not hosts.matches(request.host):
        sent_host = sanitize_line(request.host, 80)
        return 403, (
            f"This explorer isn't called `{sent_host}`: this request may come from the page of a"
            " stranger. If the name is yours, start it with"
            f" `--allow-host {_host_name(sent_host)}`."
        )
    if reason := _reject_other_page(request.host, request.headers, hosts):
        return reason
    if request.path.startswith(_CLOSED):
        return 404, "This page doesn't exist."
    return _link_reject_reason(request.path, request.query)


def guard(app: Any, hosts: AllowedHosts) -> None:
    """Let a tornado `app` reject requests before any of its own rules, and protect its answers."""
    app.default_router.rules.insert(0, Rule(_RejectedRequests(hosts), _RejectPage))
    app.add_transform(_ProtectedAnswer)


class _RejectedRequests(Matcher):
    """Matches requests with a `reject_reason`; in others, renames an IPv6 host for Panel."""

    def __init__(self, hosts: AllowedHosts):
        self._hosts = hosts

    def match(self, request: Any) -> dict[str, Any] | None:
        reason = reject_reason(request, self._hosts)
        if reason is not None:
            return {"target_kwargs": {"reason": reason}}
        if request.host.startswith("["):
            # Panel splits it at the colon: an IPv6 address would end in a page of status 500
            request.host = "localhost" + request.host.partition("]")[2]
        return None


class _ProtectedAnswer(OutputTransform):
    """Headers of every answer: no other site shows it in a frame, no browser guesses its type."""

    def transform_first_chunk(
        self, status_code: int, headers: Any, chunk: bytes, finishing: bool
    ) -> tuple[int, Any, bytes]:
        del finishing  # all chunks have the headers of the first
        headers["Content-Security-Policy"] = "frame-ancestors 'self'"
        headers["X-Content-Type-Options"] = "nosniff"
        return status_code, headers, chunk


class _RejectPage(RequestHandler):
    """Answers a rejected request by a page with the reason, and its status."""

    def initialize(self, reason: Reason) -> None:
        self._reason = reason

    def prepare(self) -> None:
        status, text = self._reason
        self.set_status(status)
        self.set_header("Cache-Control", "no-store")
        title = "This explorer can't be opened like that"
        self.finish(render("rejected.html", title=title, reason=text, footer="fascicle"))


def _reject_other_page(host: str, headers: Mapping[str, str], hosts: AllowedHosts) -> Reason | None:
    """Reason to reject a request by another site's page, or `None`."""
    origin = headers.get("Origin")
    if origin is not None:
        # same name and port; a name that was allowed may stand before another server's port
        origin_host = origin.lower().partition("://")[2]
        if origin_host != host.lower() and _host_name(origin_host) not in hosts.allowed:
            return 403, "Only the explorer's own page may talk to it."
    site, mode = headers.get("Sec-Fetch-Site"), headers.get("Sec-Fetch-Mode")
    if site in ("cross-site", "same-site") and mode != "navigate":
        return 403, "Only the explorer's own page may ask for parts of it."
    if site == "cross-site" and headers.get("Sec-Fetch-Dest") in _FRAMES:
        return 403, "The explorer doesn't open inside another site's page."
    return None


def _link_reject_reason(path: str, query: str) -> Reason | None:
    """Reason to reject a link with too many, too long or malformed parts, or `None`."""
    try:
        pairs = parse_qsl(query, keep_blank_values=True, max_num_fields=_MOST_KEYS)
    except ValueError:
        return 400, f"The link may have at most {_MOST_KEYS} parts."
    for key, value in pairs:
        name, longest = sanitize_line(key, 40), LONGEST if key in _FILES else _LONGEST_VALUE
        if len(key) + len(value) > longest + len("file"):
            text = f"In the link, `{name}` must be at most {longest} characters, got {len(value)}."
            return 400, text
        short = value.isascii() and len(value) <= _MOST_DIGITS
        if value[:1] in ("[", "{") or (value.isdigit() and not short):
            return 400, f"In the link, `{name}` has an invalid value."
        if path == "/" and key.startswith("bokeh-"):
            return 400, f"In the link, `{name}` is unknown."
    return None


def _host_name(host: str) -> str:
    """Name in a `Host` header, without its port; empty where there is none."""
    match = _HOST.fullmatch(host.lower())
    return match["name"].strip("[]").rstrip(".") if match else ""


def _is_ip_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
