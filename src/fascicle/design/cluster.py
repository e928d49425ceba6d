"""Workers for a sweep: processes on this machine, or a scheduler's anywhere.

Each local worker computes on one thread, as Dask has it by default: as many workers as cores then
share a machine without waiting for one another.
A scheduler's clients can run anything on its workers: the local one asks for a certificate that
only its own workers have, and serves no page.
"""

import contextlib
import logging
import os
import signal
from collections.abc import Iterator
from multiprocessing import active_children, resource_tracker
from typing import Any


_CLOSING_TIME = 3.0  # s that workers may take to end; what they write is whole or absent
_CONNECTION_TIME = 20.0  # s until a scheduler counts as absent
_REASON_LENGTH = 120  # characters of Dask's errors, some of which run over many lines
_SETTINGS = {
    "distributed.scheduler.http.routes": [],  # no pages
    "distributed.worker.http.routes": [],
    # a worker that is killed isn't its block's fault
    "distributed.scheduler.allowed-failures": 20,
}


@contextlib.contextmanager
def local_client(workers: int | None = None) -> Iterator[Any]:
    """Context of a Dask client whose workers run on this machine, and end with it.

    `workers`: their number [-]; default: one for each core. Raises `ConnectionError` if workers
    can't be started.
    """
    from dask import config
    from distributed import Client, LocalCluster, Security  # before `config.set`: its defaults

    make: Any = LocalCluster
    with silence_dask(), config.set(_SETTINGS), contextlib.ExitStack() as stack:
        # a worker that compiles ignores all other signals
        stack.callback(lambda: [worker.kill() for worker in active_children()])
        try:
            with _without_interrupts():
                cluster = make(
                    n_workers=cores() if workers is None else workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address="127.0.0.1:0",  # any free port; `None` would be 8787
                    scheduler_kwargs={"dashboard": False},
                    memory_limit=0,
                    host="127.0.0.1",
                    silence_logs=logging.CRITICAL,
                    security=Security.temporary(),
                )
            stack.callback(_close_resource, cluster)
            client = Client(cluster, timeout=_CONNECTION_TIME, set_as_default=False)
        except (RuntimeError, OSError, TimeoutError) as error:
            raise ConnectionError(f"no worker can be started ({short_reason(error)})") from None
        stack.callback(_close_resource, client)
        yield client


def _close_resource(resource: Any) -> None:
    """Close a client or a cluster; errors are ignored: its processes may be dead already."""
    with contextlib.suppress(Exception):
        resource.close(timeout=_CLOSING_TIME)


@contextlib.contextmanager
def scheduler_client(address: str) -> Iterator[Any]:
    """Context of a Dask client of the scheduler at an `address`, `tcp://…`.

    Raises `ConnectionError` if no scheduler answers.
    """
    from distributed import Client

    with silence_dask():
        try:
            client = Client(address, timeout=_CONNECTION_TIME, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise ConnectionError(short_reason(error)) from None
        with client:
            yield client


def restart_dead_workers(client: Any) -> None:
    """Restart local workers that died as they started; a scheduler's `client` is left alone.

    Dask itself restarts a dead worker, but one that is killed before it is up stays dead.
    """
    from distributed import LocalCluster, Status

    cluster: Any = client.cluster
    if not isinstance(cluster, LocalCluster):
        return

    def forget_dead_workers() -> None:
        for name, worker in list(cluster.workers.items()):
            if worker.status in (Status.closed, Status.failed):
                del cluster.workers[name]

    loop: Any = cluster.loop
    loop.add_callback(forget_dead_workers)
    cluster.scale(len(cluster.worker_spec))


def cores() -> int:
    """Number of cores that this process may use [-]."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def silence_dask() -> Iterator[None]:
    """Context without logs of Dask, tornado and asyncio: the sweep reports lost workers."""
    loggers = [
        logging.getLogger(name)
        for name in logging.root.manager.loggerDict
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio")
    ]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Context in which new threads and processes ignore Ctrl-C: this process ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # else each start of a process would begin it, and let the signal through again
    resource_tracker.ensure_running()
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def short_reason(error: BaseException) -> str:
    """Message of an `error` on one line, cut after 120 characters; its type where it has none."""
    return " ".join(str(error).split())[:_REASON_LENGTH] or type(error).__name__
