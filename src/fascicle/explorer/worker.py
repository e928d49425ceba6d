"""Jobs in worker processes, which stop nobody's page, and errors that a page can show."""

import multiprocessing
import signal
import traceback
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from typing import Any


_MOST = 2  # jobs at once; others wait
WAITING = ThreadPoolExecutor(_MOST, thread_name_prefix="fascicle-job")  # a thread for each


@lru_cache(maxsize=1)
def _processes() -> ProcessPoolExecutor:
    """Worker processes, started by the first job; each keeps what it has compiled."""
    context = multiprocessing.get_context("spawn")  # a fork would copy the server's sockets
    return ProcessPoolExecutor(_MOST, context, initializer=_prepare_process)


def _prepare_process() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's
    warnings.simplefilter("ignore")  # a job collects its own


def run_job(function: Callable[..., Any], *arguments: Any) -> Any:
    """Result of `function(*arguments)` in a worker process; all of them are pickled.

    **Raises:** the function's errors; `ValueError` if the process ends.
    """
    try:
        return _processes().submit(function, *arguments).result()
    except BrokenProcessPool:
        _processes.cache_clear()  # the next job has new processes
        raise ValueError("The computation ended early: too little memory?") from None


def stop_jobs() -> None:
    """End all worker processes, whose jobs nobody waits for any more."""
    if _processes.cache_info().currsize:
        _processes().shutdown(wait=False, cancel_futures=True)
        _processes.cache_clear()
    for process in multiprocessing.active_children():
        process.kill()


def result_and_error(compute: Callable[[], Any]) -> tuple[Any, ValueError | None]:
    """Result of `compute` and no error, or no result and its `ValueError`; in place of an error
    that isn't a visitor's, a sentence: the log has that error.
    """
    try:
        return compute(), None
    except (ValueError, ImportError) as error:  # a visitor's mistake, or an extra that is missing
        return None, error if isinstance(error, ValueError) else ValueError(str(error))
    except Exception:  # noqa: BLE001 whatever it is, the server goes on
        traceback.print_exc()
        return None, ValueError("This could not be computed; see the server's log.")
