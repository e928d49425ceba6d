"""What one visitor waited for is there for the next: computed curves, shared by all sessions.

Results are kept by what they were computed from, in every digit, and only the latest of them;
whoever asks for what is just being computed waits for it instead of computing it again.
"""

import pickle
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future
from threading import Lock
from typing import Any, TypeVar


T = TypeVar("T")
MOST = 64  # results; the largest, two maps of efficiency, take 0.25 MB
_KEPT: "OrderedDict[bytes, Future[Any]]" = OrderedDict()
_LOCK = Lock()


def shared(compute: Callable[..., T], *arguments: Any) -> T:
    """What `compute` [-] gives for its `arguments` [-]: as it was kept, or computed now.

    Nobody may change what is returned. What raises isn't kept.
    """
    key = pickle.dumps((compute.__module__, compute.__qualname__, arguments))
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
