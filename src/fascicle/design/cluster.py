"""Workers for a sweep: processes on this machine, or a scheduler's anywhere.

Each local worker computes on one thread: as many workers as cores then share a machine without
waiting for one another. XLA reads that when a worker first computes, so it is in its environment.
Whoever can talk to a scheduler can have its workers run anything: the local one asks for a
certificate that only its own workers have, and serves no page.
"""

import contextlib
import logging
import os
import signal
from collections.abc import Iterator
from multiprocessing import active_children, resource_tracker
from typing import Any


_ONE_THREAD = {"PJRT_NPROC": "1", "OMP_NUM_THREADS": "1"}
_PARTS = ("client", "comm", "core", "nanny", "scheduler", "worker", "deploy")
_LOGS = ("distributed", *(f"distributed.{part}" for part in _PARTS), "tornado.application",
         "asyncio")  # fmt: skip
_STARTS = 3  # of the workers; one may be killed as it starts
_CLOSING = 3.0  # s that workers may take to end, what they write is whole or not there
_SETTINGS = {
    "distributed.scheduler.http.routes": [],  # no pages
    "distributed.worker.http.routes": [],
    # a worker that is killed isn't its block's fault
    "distributed.scheduler.allowed-failures": 20,
}


@contextlib.contextmanager
def local(workers: int | None = None) -> Iterator[Any]:
    """A client of workers on this machine, which end with it.

    **Arguments:** `workers`: how many [-]; left out, one a core.

    **Returns:** Dask's client, inside a `with`.

    **Raises:** `ConnectionError` where workers can't be started.
    """
    import distributed  # noqa: F401 first: its own settings are what these are put over
    from dask import config

    with quiet(), config.set(_SETTINGS):
        cluster, client = _started(cores() if workers is None else workers)
        try:
            yield client
        finally:
            # in vain where all of it is dead already
            with contextlib.suppress(Exception):
                client.close(timeout=_CLOSING)
            with contextlib.suppress(Exception):
                cluster.close(timeout=_CLOSING)
            for worker in active_children():  # one that compiles hears nothing else
                worker.kill()


def _started(workers: int) -> tuple[Any, Any]:
    """A cluster of so many `workers`, and a client."""
    from distributed import Client, LocalCluster, Security

    make: Any = LocalCluster
    options = {
        "n_workers": workers,
        "threads_per_worker": 1,
        "processes": True,
        "dashboard_address": "127.0.0.1:0",  # a port of its own; `None` would be 8787
        "scheduler_kwargs": {"dashboard": False},
        "memory_limit": 0,
        "host": "127.0.0.1",
        "env": _surroundings(),
        "silence_logs": logging.CRITICAL,
        "security": Security.temporary(),
    }
    for last in (False,) * (_STARTS - 1) + (True,):
        with contextlib.ExitStack() as stack:
            try:
                with _uninterrupted():
                    cluster = stack.enter_context(make(**options))
                client = stack.enter_context(Client(cluster, timeout=20, set_as_default=False))
            except (RuntimeError, OSError, TimeoutError) as error:
                if last:
                    reason = " ".join(str(error).split())[:120] or type(error).__name__
                    raise ConnectionError(f"no worker can be started ({reason})") from None
            else:
                stack.pop_all()
                return cluster, client
    raise AssertionError  # the last start returns or raises


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Threads and processes started inside don't see Ctrl-C: it is this process's to end them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # else each start of a process would begin it, and let the signal through again
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def revive(client: Any) -> None:
    """Start local workers again that died as they started; `client`: Dask's.

    Dask itself starts a dead worker again, once: one that is killed before it is up stays dead.
    """
    from distributed import LocalCluster, Status

    cluster: Any = client.cluster
    if not isinstance(cluster, LocalCluster):
        return

    def forget() -> None:
        for name, one in list(cluster.workers.items()):
            if one.status in (Status.closed, Status.failed):
                del cluster.workers[name]

    loop: Any = cluster.loop
    loop.add_callback(forget)
    cluster.scale(len(cluster.worker_spec))


@contextlib.contextmanager
def remote(address: str) -> Iterator[Any]:
    """A client of a scheduler.

    **Arguments:** `address`: its address, `tcp://…`.

    **Returns:** Dask's client, inside a `with`.

    **Raises:** `ConnectionError` where there is none.
    """
    from distributed import Client

    with quiet():
        try:
            client = Client(address, timeout=20, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise ConnectionError(reason) from None
        with client:
            yield client


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep Dask's own log off the screen: what follows reports a killed worker."""
    before = {name: logging.getLogger(name).level for name in _LOGS}
    for name in _LOGS:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def _surroundings() -> dict[str, str]:
    """What workers' environment adds: one thread, and JAX as this process has set it up."""
    import jax

    config: Any = jax.config
    environment = dict(_ONE_THREAD)
    if config.jax_platforms:
        environment["JAX_PLATFORMS"] = str(config.jax_platforms)
    if config.jax_compilation_cache_dir:
        environment["JAX_COMPILATION_CACHE_DIR"] = str(config.jax_compilation_cache_dir)
        least = config.jax_persistent_cache_min_compile_time_secs
        environment["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = str(least)
    return environment


def cores() -> int:
    """How many cores this process may use [-]."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
