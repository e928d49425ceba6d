"""Ctrl-C for a server: at once while it starts, in order once it runs.

Nothing heavy is imported here, so that it can be asked for before anything else is.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any


CODE = 130  # as shells have it: 128 and the signal's number


class Stop:
    """Inside, an interrupt or SIGTERM ends the process then and there, or the loop once there
    is one. An exception instead would be dropped where JAX compiles.
    """

    def __init__(self, say: Callable[[str], None]):
        """**Arguments:** `say`: takes the last line [-]."""
        self._say, self._loop, self._before = say, None, {}

    def __enter__(self) -> "Stop":  # noqa: PYI034 tests check types, and know no Self outside
        self.listen()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def listen(self) -> None:
        """Take the signals [-], also from whoever has taken them meanwhile."""
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                before = signal.signal(number, self._wish)
                self._before.setdefault(number, before)

    def runs(self, loop: Any) -> None:
        """From now on, end this `loop` [-] first."""
        self._loop = loop
        self.listen()

    def _wish(self, *_: object) -> None:
        if self._loop is not None:
            loop, self._loop = self._loop, None  # the second one doesn't wait for the first
            loop.add_callback_from_signal(loop.stop)
            return
        self._say("stopped.")
        sys.stdout.flush()
        os._exit(CODE)
