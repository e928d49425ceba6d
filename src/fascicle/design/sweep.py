"""A search cut into blocks that Dask's workers compute; a stopped one computes the missing blocks.

The folder of a sweep holds `designs.zarr`: one array, designs by objectives, in chunks of a block.
A worker writes its block as one file, which appears whole: a block is missing if its file is. Any
worker can compute any block, again if need be, to the same bits.
"""

import asyncio
import contextlib
import copy
import itertools
import logging
import re
import signal
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.errors import InvalidInputError
from ..io.input_file import read_bytes
from ..version import __version__
from .evaluation import Values, evaluate
from .objectives import OBJECTIVES
from .space import Space
from .task import Task


if TYPE_CHECKING:
    from distributed import Client

DATA = "designs.zarr"
_MAX_SIZE = 1_000_000  # bytes of its description; it takes two thousand
_CONNECTION_TIME = 20.0  # s until a scheduler counts as absent
_QUEUE_TIME = 600.0  # s that a scheduler's workers may take to come; clusters have queues
_LOCAL = {"threads_per_worker": 1, "memory_limit": 0, "silence_logs": logging.CRITICAL}
_NO_DASHBOARD = {"dashboard_address": "127.0.0.1:0", "scheduler_kwargs": {"dashboard": False}}
_NO_PAGES = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}


@dataclass(frozen=True, eq=False)
class Study:
    """Designs of a `space` for a `task`, `names` of objectives, and designs in a `block`."""

    space: Space
    task: Task
    names: tuple[str, ...]
    block: int = 4096

    @property
    def blocks(self) -> int:
        """Number of blocks [-]; the last may be shorter."""
        return -(-len(self.space) // self.block)


def open_folder(folder: Path, study: Study, resume: bool = False) -> Path:
    """Make a `folder` for a study's results, or check one to `resume`, and return its array's path;
    `InvalidInputError` for one that holds something else, `OSError` if its file is no regular one.
    """
    import zarr
    from dask.base import tokenize

    path, rule, remedy = folder / DATA, "", "name another folder"
    digest = tokenize(__version__, study.space, study.task, study.names, study.block)
    if exists := (path / "zarr.json").exists():
        read_bytes(path / "zarr.json", _MAX_SIZE, "sweep's array")  # zarr waits for ever at a pipe
        former = None
        with contextlib.suppress(Exception):  # there is no end to what a damaged file can provoke
            former = zarr.open_array(path, mode="r").attrs.get("study")
        if former != digest:
            rule = "must not hold another study's results"
        elif not resume:
            rule, remedy = "must not hold a sweep already", "resume it, or name another folder"
    elif folder.is_dir() and any(file.name != DATA for file in folder.iterdir()):
        rule = "must be new, or a sweep's"
    elif resume and not folder.is_dir():
        rule, remedy = "must hold the sweep to resume", "begin it without resume"
    if rule:
        raise InvalidInputError("folder", rule, str(folder), remedy)
    if not exists:
        units = [OBJECTIVES[name].unit for name in study.names]
        shape, chunks = (len(study.space), len(study.names)), (study.block, len(study.names))
        attributes = {"study": digest, "objectives": list(study.names), "units": units}
        layout: Any = {"compressors": None, "fill_value": np.nan, "attributes": attributes}
        zarr.create_array(path, shape=shape, chunks=chunks, dtype="float64", **layout)
    return path


def missing_blocks(path: Path, study: Study) -> list[int]:
    """Blocks without a whole file in the array at a `path`, counted from 0."""
    size = study.block * len(study.names) * np.dtype(float).itemsize  # the last is padded
    whole = {file.parent.name for file in path.glob("c/*/0") if file.stat().st_size == size}
    return [block for block in range(study.blocks) if str(block) not in whole]


def compute_block(block: int, study: Study, path: str) -> int:
    """Compute and write a `block`, counted from 0, and return its number."""
    import zarr

    index = np.arange(block * study.block, min((block + 1) * study.block, len(study.space)))
    values = evaluate(study.space.at(index), study.task, study.names)
    array: Any = zarr.open_array(path, mode="r+")
    array[index[0] : index[-1] + 1] = np.stack([values[name] for name in study.names], axis=1)
    return block


def sweep(
    study: Study,
    path: Path,
    client: "Client | None" = None,
    watch: Callable[[int, int], None] = lambda *_: None,
) -> Values:
    """Evaluate the missing blocks of a study; returns the values of all designs by objective [SI].

    `path`: of the array, the same for all workers; `client`: Dask's; default: this process computes
    all; `watch`: called with the numbers of finished blocks and of all [-]. Raises `OSError` where
    a block can't be written, `ConnectionError` where the scheduler or all workers are lost.
    """
    import zarr

    path, missing = path.resolve(), missing_blocks(path, study)
    results: Iterable[int] = (compute_block(block, study, str(path)) for block in missing)
    if client is not None:
        results = _distribute(client, study, str(path), missing)
    for count, _ in enumerate(itertools.chain([None], results)):
        watch(study.blocks - len(missing) + count, study.blocks)
    for draft in path.rglob("*.partial"):  # of killed writers
        draft.unlink(missing_ok=True)
    array: Any = zarr.open_array(path, mode="r")
    return dict(zip(study.names, array[:].T, strict=True))


def _distribute(client: "Client", study: Study, path: str, blocks: list[int]) -> Iterator[int]:
    """Numbers of `blocks` as workers finish them; those of workers that died run again."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    try:
        # a task's result, which is made again if its worker dies; each worker then has one copy
        shared = client.submit(copy.copy, study, pure=False)
        futures = client.map(compute_block, blocks, study=shared, path=path, pure=False)
        for future in as_completed(futures, loop=client.loop):
            yield future.result()
    except KilledWorker as error:
        raise ConnectionError(f"a block lost its worker again and again ({error})") from None
    except (CancelledError, CommClosedError, TimeoutError) as error:
        raise ConnectionError(f"the scheduler is lost ({type(error).__name__})") from None


@contextlib.contextmanager
def open_client(scheduler: str | None, workers: int | None) -> Iterator["Client | None"]:
    """Context of a Dask client of a `scheduler` at an address, "tcp://…", or of `workers` on this
    machine, by default one for each core, which end with it; of none for no `workers`.

    Clients of a scheduler can run anything on its workers: the local one asks for a certificate
    that only its own workers have. Raises `ConnectionError` if there are no workers.
    """
    if workers == 0:
        yield None
        return
    from dask import config
    from distributed import Client, LocalCluster

    cluster = scheduler
    with contextlib.ExitStack() as stack, config.set(_NO_PAGES if scheduler is None else {}):
        try:
            if scheduler is None:
                options: Any = _LOCAL | _NO_DASHBOARD
                with _without_interrupts():
                    cluster = LocalCluster(n_workers=workers, security=True, **options)
                stack.enter_context(cluster)
            client = Client(cluster, timeout=_CONNECTION_TIME, set_as_default=False)
            stack.enter_context(client)
            client.wait_for_workers(1, timeout=_QUEUE_TIME)
        except (RuntimeError, OSError, TypeError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise ConnectionError(f"{scheduler or 'this machine'}: {reason}") from None
        yield client


def check_scheduler(address: str) -> None:
    """Refuse an `address` at which no scheduler of Dask answers: a client would wait for ever."""
    from distributed.comm.core import connect

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # it logs until this process ends
    match = re.fullmatch(r"(tcp://)?([\w.-]+|\[[\da-f:.]+\]):(\d{1,5})", address, re.ASCII)
    if match is None or not 0 < int(match[3]) < 1 << 16:
        rule = "must be an address such as tcp://127.0.0.1:8786"
        raise InvalidInputError("scheduler", rule, address)

    async def ask() -> None:
        await (await asyncio.wait_for(connect(address), _CONNECTION_TIME)).close()

    try:
        asyncio.run(ask())
    except (RuntimeError, OSError, TypeError, ValueError, TimeoutError):
        rule = f"must be of a Dask scheduler that answers within {_CONNECTION_TIME:g} s"
        raise InvalidInputError("scheduler", rule, address) from None


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
