"""Computations in threads, and how their results reach the page."""

import asyncio
import threading
from types import SimpleNamespace

import panel as pn

from fascicle.explorer.tab import LatestResult


def test_only_the_loops_thread_touches_the_document(monkeypatch):
    """A thread that adds a callback while the document sends its changes can lose it for good."""
    threads, results, release = [], [], threading.Event()

    class Document:
        session_context = SimpleNamespace(destroyed=False)

        def add_next_tick_callback(self, callback):
            threads.append(threading.current_thread())
            callback()

    async def visit():
        shown = asyncio.Event()

        def show(result):
            results.append(result)
            loop.call_soon_threadsafe(shown.set)

        def compute():
            release.wait(60)
            return threading.current_thread()

        loop = asyncio.get_running_loop()
        LatestResult(show, results.append).request(compute)
        release.set()
        await asyncio.wait_for(shown.wait(), 60)

    monkeypatch.setattr(type(pn.state), "curdoc", Document())
    asyncio.run(visit())
    assert results[0] is not threading.main_thread()
    assert threads == [threading.main_thread()]
