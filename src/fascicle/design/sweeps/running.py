"""A study on many workers: blocks handed out, written where they are made, noted when done.

A worker gets a number and the study; it computes the block, writes its chunks, and reports
what they were. Nothing else travels, and nothing is kept in a worker between blocks but
compiled functions and the study. A block that a killed worker was at is handed out again, and
writes the same bits over whatever was left.
"""

import os
import secrets
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from ..searches.study import Study
from .cluster import revive
from .store import Store


_AHEAD = 3  # blocks handed to each worker, so that none waits for the next
_ASK = 2.0  # s between questions how many workers there are
_LOOK = 0.02  # s between looks whether a block is done
_ALONE = 60.0  # s without any worker, since a block was last done, after which there are none
_TRIES = 20  # of one block; a worker that is killed at it isn't the block's fault
_KNOWN: dict[str, Study] = {}  # the last study of a worker, by its digest


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
    alone: float = _ALONE,
) -> Store:
    """Compute what is missing of a study.

    **Arguments:**

    - `study`: what to compute [-].
    - `folder`: where results are kept [-].
    - `client`: Dask's, of any deployment [-]; left out, this process does all.
    - `resume`: whether results are there to go on from [-].
    - `watch`: told about progress [-].
    - `alone`: how long without any worker until it is given up [s].

    **Returns:** the store, complete [-].

    **Raises:** `ValueError` for a folder that holds something else; `OSError` where a block
    can't be written; `ConnectionError` where the scheduler or all workers are lost.
    """
    store = Store.begin(folder, study, resume)
    finished = store.finished() if resume else set()
    left = [block for block in range(study.blocks) if block not in finished]
    begun, designs, done = time.perf_counter(), 0, len(finished)
    if watch is not None:
        watch(Progress(done, study.blocks, 0, 0.0, None))
    if client is None:
        work = (run_block(study, str(folder), block) for block in left)
    else:
        work = _there(client, study, folder, left, alone)
    for one in work:
        store.finish(one.block, one.digest)
        designs, done = designs + len(study.index(one.block)), done + 1
        if watch is not None:
            seconds = time.perf_counter() - begun
            watch(Progress(done, study.blocks, designs, seconds, one))
    store.tidy()
    return store


def run_block(study: Study, folder: str, block: int) -> Done:
    """Compute and write a block: what a worker does.

    **Arguments:**

    - `study`: whose [-].
    - `folder`: where results are kept, as the worker sees it [-].
    - `block`: which, counted from 0 [-].

    **Returns:** what was written [-].
    """
    if study.digest not in _KNOWN:
        _KNOWN.clear()
    study = _KNOWN.setdefault(study.digest, study)  # whose tables are made already
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


def _there(
    client: Any, study: Study, folder: Path, blocks: list[int], alone: float
) -> Iterator[Done]:
    """Blocks as workers finish them; one that failed with its worker is handed out again."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    where, crew = str(folder.resolve()), _Crew(client, alone)
    waiting = blocks[::-1]
    tries: dict[int, int] = {}
    owner: dict[str, int] = {}
    futures = as_completed(loop=client.loop)
    # keys are the scheduler's, which may serve others, and remembers what it has given up
    sweep_key = secrets.token_hex(4)
    try:
        while waiting or owner:
            while waiting and len(owner) < _AHEAD * max(1, crew.count()):
                block = waiting.pop()
                tries[block] = tries.get(block, 0) + 1
                key = f"block-{sweep_key}-{block}-{tries[block]}"
                future = client.submit(run_block, study, where, block, key=key, pure=False)
                owner[key] = block
                futures.add(future)
            while not futures.has_ready():
                time.sleep(_LOOK)
                crew.count()
            future = next(futures)
            block = owner.pop(future.key)
            try:
                done = future.result(timeout=_ASK)
            except TimeoutError:  # its worker died between doing and telling: it is done again
                owner[future.key] = block
                futures.add(future)
            except KilledWorker:
                if tries[block] >= _TRIES:
                    raise ConnectionError(f"block {block} lost its worker {_TRIES} times") from None
                waiting.append(block)
            else:
                crew.worked()
                yield done
    except (CancelledError, CommClosedError, TimeoutError) as error:
        told = " ".join(str(error).split())[:120] or type(error).__name__
        raise ConnectionError(f"the scheduler is lost ({told})") from None


class _Crew:
    """How many workers there are, asked now and then: they may come and go, or all be gone."""

    def __init__(self, client: Any, alone: float):
        self._client, self._most = client, alone
        self._asked, self._count, self._alone = -_ASK, 1, 0.0

    def count(self) -> int:
        """Workers [-] when last asked; `ConnectionError` if there have long been none."""
        since = time.monotonic() - self._asked
        if since >= _ASK:
            revive(self._client)
            self._count, self._asked = len(self._client.nthreads()), time.monotonic()
            if not self._count:
                self._alone += min(since, 2 * _ASK)
            if self._alone >= self._most:
                raise ConnectionError(f"no worker has been there for {self._most:g} s")
        return self._count

    def worked(self) -> None:
        """A block is done: there is hope."""
        self._alone = 0.0
