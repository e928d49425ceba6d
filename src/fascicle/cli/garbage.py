"""Imports are no garbage: the collector neither searches them as they come, nor afterwards.

What JAX and the laws make while they are imported stays until the process ends, some 200 000
objects. Searched again and again as they grow, and once more at the end, they take a quarter of
a short command's time. Only a command does this, in a process of its own: a library leaves the
collector as its user has it.
"""

import contextlib
import gc
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """Inside, what is imported is kept for good, unlooked at."""
    if not gc.isenabled() or "jax" in sys.modules:  # a process that is somebody else's
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
