"""Ctrl-C: ends a command at any time, without a word from Python."""

import _thread
import atexit
import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from functools import cache


CODE = 130  # as shells have it: 128 and the signal's number


@contextlib.contextmanager
def at_once() -> Iterator[None]:
    """Inside, Ctrl-C ends the process then and there.

    For the imports, where nothing has been begun that would have to be undone, and where an
    exception can come up anywhere: out of a half-made module, or inside a callback that drops it.
    """
    try:
        before = signal.getsignal(signal.SIGINT)
        if before is not signal.default_int_handler:  # ignored, or somebody else's
            raise ValueError
        signal.signal(signal.SIGINT, lambda *_: _leave())
    except ValueError:  # or not in the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave() -> None:
    with contextlib.suppress(OSError, ValueError):
        if sys.stderr.isatty():  # a spinner hides the cursor
            os.write(sys.stderr.fileno(), b"\r\x1b[K\x1b[?25h")
    os._exit(CODE)


@contextlib.contextmanager
def not_dropped() -> Iterator[None]:
    """Inside, Ctrl-C that falls into a callback, which can't be ended by it, comes again."""
    before = sys.unraisablehook

    def hook(dropped: "sys.UnraisableHookArgs") -> None:
        if dropped.exc_type is KeyboardInterrupt:
            _thread.interrupt_main()
        else:
            before(dropped)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


@cache
def unheard_at_exit() -> None:
    """Let Python go down undisturbed: what a Ctrl-C could still stop then is done and printed."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # Python puts back the system's own handler, which kills, unless it finds it ignored
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
