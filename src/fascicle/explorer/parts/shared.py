"""What one visitor waited for is there for the next: computed curves, shared by all sessions.

Results are kept by what they were computed from, in every digit, and only the latest of them;
whoever asks for what is just being computed waits for it instead of computing it again.
"""

from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future
from threading import Lock
from typing import Any, TypeVar

import jax
import numpy as np


T = TypeVar("T")
MOST = 64  # results; the largest, two maps of efficiency, take 0.25 MB
_KEPT: "OrderedDict[Any, Future[Any]]" = OrderedDict()
_LOCK = Lock()


def shared(compute: Callable[..., T], *arguments: Any) -> T:
    """What `compute` [-] gives for its `arguments` [-]: as it was kept, or computed now.

    Nobody may change what is returned. What raises isn't kept.
    """
    key = (compute, *_told(arguments))
    with _LOCK:
        found = _KEPT.get(key)
        first = found is None
        if found is None:
            found = _KEPT[key] = Future()
        _KEPT.move_to_end(key)
        while len(_KEPT) > MOST:
            _KEPT.popitem(last=False)
    if first:
        try:
            found.set_result(compute(*arguments))
        except BaseException as error:  # noqa: BLE001 whoever waits for it is told, too
            with _LOCK:
                _KEPT.pop(key, None)
            found.set_exception(error)
    return found.result()


def _told(arguments: Any) -> tuple[Any, Any]:
    """What `arguments` [-] are made of, to be compared: their kind, and each number's bits."""
    leaves, kind = jax.tree.flatten(arguments)
    exact = (one if isinstance(one, str) else np.asarray(one) for one in leaves)
    return kind, tuple(
        one if isinstance(one, str) else (one.dtype.str, one.shape, one.tobytes()) for one in exact
    )
