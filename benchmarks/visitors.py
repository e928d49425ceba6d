"""Visitors of the explorer without a browser: they speak its websocket, and draw nothing.

Times are the server's own: from a move of the slider sent until the curve's new data are back.
Twenty pages of a browser on the same machine would mostly time one another.
"""

import asyncio
import json
import re
import time
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlencode

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect


READY = {
    "kind": "MessageSent",
    "msg_type": "bokeh_event",
    "msg_data": {"type": "event", "name": "document_ready", "values": {"type": "map"}},
}
MAX_MESSAGE = 2**27  # bytes
# of each tab, the source that has the data of its first picture
FIRST_SOURCE = {"muscle": "curve", "bundle": "regions", "data": "untuned"}


class Visitor:
    """An open page, with its slider and the source of its curve."""

    def __init__(self, connection: WebSocketClientConnection):
        self._connection, self._number = connection, 0
        self.slider = self.curve = ""
        self.position, self.step = 0.0, 1.0

    @classmethod
    async def open(cls, url: str, tab: str = "muscle") -> "Visitor":
        """A visitor whose `tab` shows its first picture."""
        page = await AsyncHTTPClient().fetch(
            HTTPRequest(f"{url}?{urlencode({'tab': tab})}", request_timeout=120)
        )
        token = re.search(r'"token":\s*"([^"]+)"', page.body.decode())
        assert token is not None
        connection = await websocket_connect(
            HTTPRequest(url.replace("http", "ws") + "ws", request_timeout=120),
            subprotocols=["bokeh", token[1]], max_message_size=MAX_MESSAGE,
        )  # fmt: skip
        visitor = cls(connection)
        await visitor._receive()  # ACK
        await visitor._send("PULL-DOC-REQ", {})
        await visitor._receive()
        await visitor._send("PATCH-DOC", {"events": [READY]})
        await visitor._wait_for_data(FIRST_SOURCE[tab])
        return visitor

    async def move_slider(self) -> float:
        """Seconds from a move of the slider to the curve's new data."""
        self.position += self.step
        begin = time.perf_counter()
        change = {"kind": "ModelChanged", "model": {"id": self.slider}, "attr": "value",
                  "new": self.position}  # fmt: skip
        await self._send("PATCH-DOC", {"events": [change]})
        while True:
            kind, content = await self._receive()
            if kind == "PATCH-DOC" and any(
                event.get("model", {}).get("id") == self.curve for event in content["events"]
            ):
                return time.perf_counter() - begin

    def close(self) -> None:
        """Close the page."""
        self._connection.close()

    async def _wait_for_data(self, name: str) -> None:
        """Wait until the source of a name has data."""
        sources: set[str] = set()
        while True:
            kind, content = await self._receive()
            if kind != "PATCH-DOC":
                continue
            for model in _models(content):
                self._note_model(model)
                attributes = model.get("attributes", {})
                if attributes.get("name") == name:
                    sources.add(model["id"])
                    if _has_data(attributes.get("data", {})):
                        return
            for event in content["events"]:
                changes = event.get("model", {}).get("id") in sources and "data" in event
                if changes and _has_data(event["data"]):
                    return

    def _note_model(self, model: dict[str, Any]) -> None:
        """Note the first slider of a pressure, and the source of the curve."""
        attributes = model.get("attributes", {})
        is_pressure = str(attributes.get("title", "")).startswith("Pressure P")
        if model["name"] == "Slider" and is_pressure and self.slider in ("", model["id"]):
            self.slider = model["id"]
            self.position = float(attributes.get("value", 0))
            self.step = float(attributes.get("step", 1))
        if attributes.get("name") == "curve":
            self.curve = model["id"]

    async def _send(self, kind: str, content: dict[str, Any]) -> None:
        self._number += 1
        header = {"msgid": str(self._number), "msgtype": kind}
        for fragment in (header, {}, content):
            await self._connection.write_message(json.dumps(fragment))

    async def _receive(self) -> tuple[str, dict[str, Any]]:
        header = await self._receive_fragment()
        await self._receive_fragment()  # metadata
        content = await self._receive_fragment()
        for _ in range(header.get("num_buffers", 0)):
            await self._connection.read_message()
            await self._connection.read_message()
        return header["msgtype"], content

    async def _receive_fragment(self) -> dict[str, Any]:
        text = await self._connection.read_message()
        if text is None:
            raise ConnectionError("the server has closed the connection")
        return json.loads(text)


def _models(content: Any) -> Iterator[dict[str, Any]]:
    """Models of a message, at any depth."""
    if isinstance(content, dict):
        if content.get("type") == "object" and "id" in content:
            yield content
        for value in content.values():
            yield from _models(value)
    elif isinstance(content, list):
        for value in content:
            yield from _models(value)


def _has_data(data: Any) -> bool:
    entries = data.get("entries", []) if isinstance(data, dict) else []
    return any(not isinstance(value, list) or value for _, value in entries)


def move_sliders(
    url: str, clients: int, moves: int, cpu: Callable[[], float]
) -> tuple[list[float], float]:
    """Seconds of each move of a slider by clients at once, each as soon as it is answered, and the
    server's CPU seconds meanwhile, of a clock `cpu`.
    """

    async def move_all() -> tuple[list[float], float]:
        visitors = [await Visitor.open(url) for _ in range(clients)]

        async def move(visitor: Visitor) -> list[float]:
            return [await visitor.move_slider() for _ in range(moves)]

        begin = cpu()
        seconds = await asyncio.gather(*map(move, visitors))
        spent = cpu() - begin
        for visitor in visitors:
            visitor.close()
        return [x for times in seconds for x in times], spent

    return asyncio.run(move_all())


def open_sessions(url: str, sessions: int) -> list[float]:
    """Seconds to the first picture of sessions in succession, of every tab in turn."""

    async def open_all() -> list[float]:
        seconds, tabs = [], list(FIRST_SOURCE)
        for number in range(sessions):
            begin = time.perf_counter()
            visitor = await Visitor.open(url, tabs[number % len(tabs)])
            seconds.append(time.perf_counter() - begin)
            visitor.close()
        return seconds

    return asyncio.run(open_all())
