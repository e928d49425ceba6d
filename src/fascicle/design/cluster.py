"""Workers for a sweep: processes on this machine, or a scheduler's anywhere.

Each local worker computes on one thread: as many workers as cores then share a machine without
waiting for one another. XLA reads that when a worker first computes, so it is in its environment.
"""

import contextlib
import logging
import os
from collections.abc import Iterator
from typing import Any


_ONE_THREAD = {"PJRT_NPROC": "1", "OMP_NUM_THREADS": "1"}
_PARTS = ("client", "comm", "core", "nanny", "scheduler", "worker")
_LOGS = ("distributed", *(f"distributed.{part}" for part in _PARTS))


@contextlib.contextmanager
def local(workers: int | None = None) -> Iterator[Any]:
    """A client of workers on this machine, which end with it.

    **Arguments:** `workers`: how many [-]; left out, one a core.

    **Returns:** Dask's client [-], inside a `with`.
    """
    from distributed import Client, LocalCluster

    cluster: Any = LocalCluster
    options = {
        "n_workers": cores() if workers is None else workers,
        "threads_per_worker": 1,
        "processes": True,
        "dashboard_address": None,
        "memory_limit": 0,
        "host": "127.0.0.1",
        "env": _surroundings(),
    }
    with quiet(), cluster(**options) as made, Client(made) as client:
        yield client


@contextlib.contextmanager
def remote(address: str) -> Iterator[Any]:
    """A client of a scheduler.

    **Arguments:** `address`: its address, `tcp://…` [-].

    **Returns:** Dask's client [-], inside a `with`.

    **Raises:** `ConnectionError` where there is none.
    """
    from distributed import Client

    with quiet():
        try:
            client = Client(address, timeout=20)
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:200] or type(error).__name__
            raise ConnectionError(reason) from None
        with client:
            yield client


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep Dask's own log off the screen: a killed worker is told by what follows."""
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
    told = dict(_ONE_THREAD)
    if config.jax_platforms:
        told["JAX_PLATFORMS"] = str(config.jax_platforms)
    if config.jax_compilation_cache_dir:
        told["JAX_COMPILATION_CACHE_DIR"] = str(config.jax_compilation_cache_dir)
        least = config.jax_persistent_cache_min_compile_time_secs
        told["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = str(least)
    return told


def cores() -> int:
    """How many cores this process may use [-]."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
