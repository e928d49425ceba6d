"""Visitors of the explorer without a browser: they speak its websocket, and draw nothing.

What is timed is the server's own: from a slider's move sent until the curve's new data is back.
Twenty pages of a browser on the same machine would mostly time one another.
"""

import asyncio
import json
import re
import time
from collections.abc import Callable
from typing import Any
from urllib.parse import urlencode

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect


READY = {
    "kind": "MessageSent",
    "msg_type": "bokeh_event",
    "msg_data": {"type": "event", "name": "document_ready", "values": {"type": "map"}},
}
_LARGEST = 2**27  # bytes of a message
# of each tab, the source that holds its first picture
SHOWN = {"muscle": "curve", "bundle": "regions", "reversal": "reversal_resisted",
         "efficiency": "efficiency", "data": "untuned"}  # fmt: skip


class Visitor:
    """One page that was opened, and the models in it by what they are called."""

    def __init__(self, connection: WebSocketClientConnection):
        self._connection, self._number = connection, 0
        self.slider = self.curve = ""
        self.at, self.step = 0.0, 1.0
        self.replaced = 0

    @classmethod
    async def opened(cls, url: str, tab: str = "muscle") -> "Visitor":
        """A visitor whose `tab` shows its first picture."""
        page = await AsyncHTTPClient().fetch(
            HTTPRequest(f"{url}?{urlencode({'tab': tab})}", request_timeout=120)
        )
        token = re.search(r'"token":\s*"([^"]+)"', page.body.decode())
        assert token is not None
        socket = url.replace("http", "ws") + "ws"
        connection = await websocket_connect(
            HTTPRequest(socket, request_timeout=120), subprotocols=["bokeh", token[1]],
            max_message_size=_LARGEST,
        )  # fmt: skip
        visitor = cls(connection)
        await visitor._message()  # ACK
        await visitor._send("PULL-DOC-REQ", {})
        await visitor._message()
        await visitor._send("PATCH-DOC", {"events": [READY]})
        await visitor.until(SHOWN[tab])
        return visitor

    async def until(self, name: str) -> None:
        """Wait until the source called `name` is there, and filled."""
        known: set[str] = set()
        while True:
            kind, content = await self._message()
            if kind == "PATCH-DOC":
                for model in _models(content):
                    self._note(model)
                    if _called(model, name):
                        known.add(model["id"])
                        if _filled(model["attributes"].get("data", {})):
                            return
                for event in content["events"]:
                    changes = event.get("model", {}).get("id") in known and "data" in event
                    if changes and _filled(event["data"]):
                        return

    async def moved(self) -> float:
        """Seconds from a move of the slider to the curve's new data."""
        self.at += self.step
        begun = time.perf_counter()
        change = {"kind": "ModelChanged", "model": {"id": self.slider}, "attr": "value",
                  "new": self.at}  # fmt: skip
        await self._send("PATCH-DOC", {"events": [change]})
        while True:
            kind, content = await self._message()
            if kind == "PATCH-DOC" and any(
                event.get("model", {}).get("id") == self.curve for event in content["events"]
            ):
                return time.perf_counter() - begun

    def close(self) -> None:
        """Leave."""
        self._connection.close()

    def _note(self, model: dict[str, Any]) -> None:
        given = model.get("attributes", {})
        if model["name"] == "Slider" and str(given.get("title", "")).startswith("Pressure P"):
            self.slider = self.slider or model["id"]
            if self.slider == model["id"]:
                self.at, self.step = float(given.get("value", 0)), float(given.get("step", 1))
        if _called(model, "curve"):
            self.curve = model["id"]

    async def _send(self, kind: str, content: dict[str, Any]) -> None:
        self._number += 1
        header = {"msgid": str(self._number), "msgtype": kind}
        for fragment in (header, {}, content):
            await self._connection.write_message(json.dumps(fragment))

    async def _message(self) -> tuple[str, dict[str, Any]]:
        header = await self._fragment()
        await self._fragment()  # metadata
        content = await self._fragment()
        for _ in range(header.get("num_buffers", 0)):
            await self._connection.read_message()
            await self._connection.read_message()
        return header["msgtype"], content

    async def _fragment(self) -> dict[str, Any]:
        text = await self._connection.read_message()
        if text is None:
            raise ConnectionError("the server has closed the connection")
        return json.loads(text)


def _models(content: Any) -> Any:
    """All models that a message brings, however deep."""
    if isinstance(content, dict):
        if content.get("type") == "object" and "id" in content:
            yield content
        for value in content.values():
            yield from _models(value)
    elif isinstance(content, list):
        for value in content:
            yield from _models(value)


def _called(model: dict[str, Any], name: str) -> bool:
    return model.get("attributes", {}).get("name") == name


def _filled(data: Any) -> bool:
    entries = data.get("entries", []) if isinstance(data, dict) else []
    return any(not isinstance(value, list) or value for _, value in entries)


async def _together(
    url: str, clients: int, moves: int, worked: Callable[[], float]
) -> tuple[list[float], float]:
    visitors = [await Visitor.opened(url) for _ in range(clients)]

    async def drive(visitor: Visitor) -> list[float]:
        return [await visitor.moved() for _ in range(moves)]

    spent = worked()
    several = await asyncio.gather(*(drive(visitor) for visitor in visitors))
    spent = worked() - spent
    for visitor in visitors:
        visitor.close()
    return [one for times in several for one in times], spent


def together(
    url: str, clients: int, moves: int, worked: Callable[[], float]
) -> tuple[list[float], float]:
    """Seconds of each of `moves` of a slider by `clients` at once, each as soon as answered; and
    the processor time that the server has `worked` meanwhile.
    """
    return asyncio.run(_together(url, clients, moves, worked))


async def _opened(url: str, sessions: int) -> list[float]:
    times, tabs = [], list(SHOWN)
    for number in range(sessions):
        begun = time.perf_counter()
        visitor = await Visitor.opened(url, tabs[number % len(tabs)])
        times.append(time.perf_counter() - begun)
        visitor.close()
    return times


def opened(url: str, sessions: int) -> list[float]:
    """Seconds to the first picture of each of `sessions`, one after another, tab by tab."""
    return asyncio.run(_opened(url, sessions))
