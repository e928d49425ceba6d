"""A study on many workers: blocks handed out, written where they are made, noted when done.

A worker gets a number and the study; it computes the block, writes its chunks, and reports
what they were. Nothing else travels, and nothing is kept in a worker between blocks but
compiled functions. A block that a killed worker was at is handed out again, and writes the
same bits over whatever was left.
"""

import os
import pickle
import secrets
import time
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from .store import Store
from .study import Study


_AHEAD = 3  # blocks handed to each worker, so that none waits for the next
_PATIENCE = 5.0  # s between questions how many workers there are
_TRIES = 20  # of one block; a worker that is killed at it isn't the block's fault


class Done(NamedTuple):
    """A block that is written: its digest [-], the time to compute and to write it [s], the
    worker's largest memory so far [B] and its process [-].
    """

    block: int
    digest: str
    computing: float
    writing: float
    memory: int
    process: int


class Progress(NamedTuple):
    """Blocks `done` and in `all` [-], `designs` computed in this run [-] in `seconds` [s]."""

    done: int
    all: int
    designs: int
    seconds: float
    last: Done | None

    @property
    def rate(self) -> float:
        """Designs a second [1/s] in this run."""
        return self.designs / self.seconds if self.seconds > 0 else 0.0


Watch = Callable[[Progress], None]


def sweep(
    study: Study,
    folder: Path,
    client: Any = None,
    resume: bool = False,
    watch: Watch | None = None,
) -> Store:
    """Compute what is missing of a study.

    **Arguments:**

    - `study`: what to compute [-].
    - `folder`: where results are kept [-].
    - `client`: Dask's, of any deployment [-]; left out, this process does all.
    - `resume`: whether results are there to go on from [-].
    - `watch`: told about progress [-].

    **Returns:** the store, complete [-].

    **Raises:** `ValueError` for a folder that holds something else; `OSError` where a block
    can't be written; `ConnectionError` where the scheduler is lost.
    """
    store = (Store.opened if resume else Store.created)(folder, study)
    finished = store.finished() if resume else set()
    left = [block for block in range(study.blocks) if block not in finished]
    payload = pickle.dumps(study)
    begun, designs, done = time.perf_counter(), 0, len(finished)
    if watch is not None:
        watch(Progress(done, study.blocks, 0, 0.0, None))
    work = _here(payload, folder, left) if client is None else _there(client, payload, folder, left)
    for one in work:
        store.finish(one.block, one.digest)
        designs, done = designs + len(study.index(one.block)), done + 1
        if watch is not None:
            seconds = time.perf_counter() - begun
            watch(Progress(done, study.blocks, designs, seconds, one))
    store.tidy()
    return store


def run_block(payload: bytes, folder: str, block: int) -> Done:
    """Compute and write a block: what a worker does.

    **Arguments:**

    - `payload`: the study, pickled [-].
    - `folder`: where results are kept, as the worker sees it [-].
    - `block`: which, counted from 0 [-].

    **Returns:** what was written [-].
    """
    study = _study(payload)
    begun = time.perf_counter()
    values = study.values(block)
    computed = time.perf_counter()
    digest = Store(Path(folder), study).write(block, values)
    written = time.perf_counter()
    return Done(block, digest, computed - begun, written - computed, _memory(), os.getpid())


def _memory() -> int:
    """Largest memory that this process has held [B]; 0 where the system doesn't tell."""
    # not `getrusage`: across a fork that begins with the parent's
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM")), 0)


@lru_cache(maxsize=2)
def _study(payload: bytes) -> Study:
    return pickle.loads(payload)  # noqa: S301 sent by the one who hands out the work


def _here(payload: bytes, folder: Path, blocks: list[int]) -> Iterable[Done]:
    return (run_block(payload, str(folder), block) for block in blocks)


def _there(client: Any, payload: bytes, folder: Path, blocks: list[int]) -> Iterable[Done]:
    """Blocks as workers finish them; one that failed with its worker is handed out again."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    where = str(folder.resolve())
    waiting = blocks[::-1]
    tries: dict[int, int] = {}
    owner: dict[str, int] = {}
    futures = as_completed()
    # keys are the scheduler's, which may serve others, and remembers what it has given up
    sweep_key, asked, workers = secrets.token_hex(4), -_PATIENCE, 1

    def hand_out() -> None:
        nonlocal asked, workers
        # workers may come and go
        if time.monotonic() - asked >= _PATIENCE:
            workers, asked = max(1, len(client.nthreads())), time.monotonic()
        while waiting and len(owner) < _AHEAD * workers:
            block = waiting.pop()
            tries[block] = tries.get(block, 0) + 1
            key = f"block-{sweep_key}-{block}-{tries[block]}"
            future = client.submit(run_block, payload, where, block, key=key, pure=False)
            owner[key] = block
            futures.add(future)

    try:
        hand_out()
        for future in futures:
            block = owner.pop(future.key)
            try:
                done = future.result()
            except KilledWorker:
                if tries[block] >= _TRIES:
                    raise OSError(f"block {block} lost its worker {_TRIES} times.") from None
                waiting.append(block)
            else:
                yield done
            hand_out()
    except (CancelledError, CommClosedError, TimeoutError) as error:
        told = " ".join(str(error).split())[:120] or type(error).__name__
        raise ConnectionError(f"the scheduler is lost ({told})") from None
