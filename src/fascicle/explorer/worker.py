"""Jobs in worker processes: they stop nobody's page, report their stage, and can be canceled.

A process keeps what the job before it compiled, so that one is kept for the next job.
"""

import contextlib
import multiprocessing
import signal
import time
import traceback
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

from ..core.errors import InvalidInputError


MOST = 2  # jobs at once; others wait
WAITING = ThreadPoolExecutor(MOST, thread_name_prefix="fascicle-job")  # a thread for each
_LONGEST = 600.0  # s of a job: the command line has no limit
_POLLING = 1.0  # s between looks at the clock
_IDLE: list["_Worker"] = []  # for the next job
_MOST_IDLE = 1  # each holds some hundred megabytes


class CanceledError(ValueError):
    """A job that was canceled."""


class Job:
    """A call of `function(progress, *arguments)` that runs in a worker process when the job is
    called, and can be canceled.

    `progress` takes the stage, in words. Function, arguments and result are pickled.
    """

    def __init__(self, function: Callable[..., Any], *arguments: Any):
        self._call = function, arguments
        self.stage = "waiting for another computation"
        self._lock, self._worker, self._canceled = Lock(), None, False

    def __call__(self) -> Any:
        """Run it and return its result; raises its errors, and `CanceledError`."""
        with self._lock:
            if self._canceled:
                raise CanceledError("Canceled.")
            worker = self._worker = _IDLE.pop() if _IDLE else _Worker()
        self.stage = "starting"
        try:
            result, error = worker.run(self._call, self._show_stage)
        except TimeoutError:  # an OSError, too
            worker.stop()
            rule = f"takes more than {_LONGEST:g} s, the most that the page allows"
            raise InvalidInputError("run", rule, None, "use `fascicle simulate`") from None
        except (EOFError, OSError):  # the process has ended
            worker.stop()
            if self._canceled:
                raise CanceledError("Canceled.") from None
            raise ValueError("The computation ended early: too little memory?") from None
        finally:
            with self._lock:
                self._worker = None
        if self._canceled:  # while the result came
            worker.stop()
            raise CanceledError("Canceled.")
        if len(_IDLE) < _MOST_IDLE:
            _IDLE.append(worker)
        else:
            worker.stop()
        if error is not None:
            raise error
        return result

    def cancel(self) -> None:
        """Stop it, now or before it begins."""
        with self._lock:
            self._canceled = True
            if self._worker is not None:
                self._worker.stop()

    def _show_stage(self, stage: str) -> None:
        self.stage = stage


class _Worker:
    """A process that runs one call after the other."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")  # a fork would copy the server's sockets
        self._connection, child_end = context.Pipe()
        self._process = context.Process(target=_run_calls, args=(child_end,), daemon=True)
        self._process.start()
        child_end.close()

    def run(self, call: tuple[Any, ...], show: Callable[[str], None]) -> tuple[Any, Any]:
        """Result and error of a `call`; `show` takes its stages. `EOFError` or `OSError` if the
        process ends, `TimeoutError` after the longest time.
        """
        self._connection.send(call)
        end = time.monotonic() + _LONGEST
        while True:
            while not self._connection.poll(_POLLING):
                if time.monotonic() > end:
                    raise TimeoutError
            kind, *values = self._connection.recv()
            if kind == "result":
                return values[0], values[1]
            show(values[0])

    def stop(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def _run_calls(connection: Connection) -> None:
    """Run the calls that come through a `connection` until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's
    warnings.simplefilter("ignore")  # a function collects its own

    def show_stage(stage: str) -> None:
        connection.send(("stage", stage))

    with contextlib.suppress(EOFError, OSError):
        while True:
            function, arguments = connection.recv()
            call = partial(function, show_stage, *arguments)
            connection.send(("result", *result_and_error(call)))


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
