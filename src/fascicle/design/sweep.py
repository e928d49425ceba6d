"""A search cut into blocks, computed by many workers, stopped and resumed at any time.

Blocks are ranges of the space's index, so any worker can compute any block, again if need be, to
the same bits. A study's digest distinguishes its results from those of any other study.

The folder of a sweep holds

- `designs.zarr`: an array for each objective, cut into chunks that are the study's blocks;
- `manifest.json`: the study's digest; the first file of all;
- `finished.jsonl`: a line for each finished block, with a digest of its bits.

A worker writes its block before it reports; the sweep's own process then adds the line. A block
without a line, or one that doesn't read back to the bits of its line, is computed again.
"""

import hashlib
import json
import os
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property, partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import tree_leaves, tree_structure
from ..io.atomic import holds_drafts_only, remove_abandoned, write, write_text
from ..version import __version__
from .cluster import restart_dead_workers, short_reason
from .evaluation import Values, evaluate
from .objectives import OBJECTIVES, Limit, check_search, recorded_objectives, with_reach_limits
from .space import Space
from .task import Task


MAX_DESIGNS = 4_000_000_000  # designs; an index is a 64-bit number, a journal has a line a block
MAX_BLOCK = 2**20  # designs; their tables fit into a worker's memory
DATA, MANIFEST, JOURNAL = "designs.zarr", "manifest.json", "finished.jsonl"
_META = "zarr.json"  # describes a group, or an array
_VERSION = __version__
_BLOCKS_PER_WORKER = 3  # so that none waits for the next block
_CENSUS = 2.0  # s between counts of the workers
_POLL = 0.02  # s between looks for a result, far less than a block takes
_WORKER_TIMEOUT = 60.0  # s; a worker that died is up again after a few


@dataclass(frozen=True, eq=False)
class Study:
    """Study: designs of a `space` to evaluate for a `task` in blocks; `names` of the recorded
    objectives, `senses` and `limits`, which make the front in the end; `block`: number of designs
    computed together.
    """

    space: Space
    task: Task
    names: tuple[str, ...]
    senses: dict[str, str]
    limits: dict[str, Limit]
    block: int

    @classmethod
    def of(
        cls,
        space: Space,
        task: Task,
        senses: dict[str, str],
        limits: dict[str, Limit] | None = None,
        extra: tuple[str, ...] = (),
        block: int = 4096,
    ) -> "Study":
        """Study of a space's designs for a task.

        **Arguments:**

        - `space`: the designs.
        - `task`: what is demanded.
        - `senses`: "min" or "max" by objective.
        - `limits`: on objectives, by name.
        - `extra`: objectives to record that don't make the front.
        - `block`: designs computed together.

        **Returns:** the study.

        **Raises:** `ValueError` for unknown objectives, and blocks and spaces out of range.
        """
        limits = with_reach_limits(limits)
        names = recorded_objectives(senses, limits, extra)
        check_search(senses, limits)
        if not 1 <= block <= MAX_BLOCK:
            raise InvalidInputError("block", f"must lie in [1, {MAX_BLOCK}]", block)
        if len(space) > MAX_DESIGNS:
            raise ValueError(f"the space holds {len(space)} designs, more than {MAX_DESIGNS}.")
        return cls(space, task, names, dict(senses), limits, block)

    @property
    def blocks(self) -> int:
        """Number of blocks [-]; the last may be shorter."""
        return -(-len(self.space) // self.block)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the task, the space, the objectives' names, the block's size and the version
        of fascicle, in hexadecimal digits: equal for studies with equal results.
        """
        sha = hashlib.sha256(json.dumps([_VERSION, self.names, self.block]).encode())
        for owner in (self.task, self.space):
            for field in fields(owner):
                sha.update(field.name.encode())
                value = getattr(owner, field.name)
                if isinstance(value, np.ndarray):
                    sha.update(np.ascontiguousarray(value).tobytes())
                elif isinstance(value, dict):  # muscles by name
                    for name, muscle in value.items():
                        sha.update(name.encode() + str(tree_structure(muscle)).encode())
                        for leaf in tree_leaves(muscle):
                            sha.update(np.asarray(leaf, float).tobytes())
                else:
                    sha.update(repr(value).encode())
        return sha.hexdigest()

    def index(self, block: int) -> np.ndarray:
        """Indices of a block's designs; `block` counts from 0 [-]."""
        start = block * self.block
        return np.arange(start, min(start + self.block, len(self.space)))

    def values(self, block: int) -> Values:
        """Objectives [SI] of a block's designs by name; `block` counts from 0 [-]."""
        return evaluate(self.space.at(self.index(block)), self.task, self.names)


@dataclass(eq=False)
class Store:
    """Store of a `study`'s results in a `folder`, which a stopped sweep resumes from."""

    folder: Path
    study: Study

    @classmethod
    def check(cls, folder: Path, study: Study, resume: bool) -> None:
        """Refuse a `folder` that a `study`'s results can't go into: it has none to `resume`,
        another study's, or other files; `ValueError`.

        A run that was killed before its manifest was written leaves an empty folder, or hidden
        drafts in it: then the sweep begins.
        """
        for path in (folder, *folder.parents):
            if not path.is_dir() and (path.exists() or path.is_symlink()):
                raise ValueError(f"{folder}: {path} is no folder: name a new one.")
        # the attributes of the data name the study, too
        contents = (
            _read_json(folder / MANIFEST),
            _read_json(folder / DATA / _META).get("attributes"),
        )
        manifests = (x for x in contents if isinstance(x, dict) and isinstance(x.get("study"), str))
        manifest, fault = next(manifests, {}), ""
        same_study, former = manifest.get("study") == study.digest, manifest.get("fascicle")
        if manifest and not resume:
            remedy = "another study's: name a new folder"
            remedy = "continue with --resume" if same_study else remedy
            fault = f"holds a sweep already; {remedy}."
        elif manifest and not same_study:
            remedy = "sweep with the file that began it"
            if former not in (None, _VERSION):
                remedy = f"go on with fascicle {former}, which began it (this is {_VERSION})"
            fault = "holds another study's results; nothing was changed."
            fault = f"{fault} Name another folder, or {remedy}."
        elif not manifest and ((folder / MANIFEST).exists() or (folder / DATA / _META).exists()):
            fault = (
                f"can't read the study of these results from {MANIFEST} or {DATA}/{_META};"
                " nothing was changed. Name a new folder."
            )
        elif not manifest and not (folder.is_dir() and holds_drafts_only(folder)):
            if resume:
                fault = "holds no sweep to resume: leave --resume out."
            elif folder.exists():
                fault = "exists and is no sweep: name a new folder."
        if fault:
            raise ValueError(f"{folder}: {fault}")

    @classmethod
    def begin(cls, folder: Path, study: Study, resume: bool = False) -> "Store":
        """Begin the store of a study, new or to resume; arguments and errors as of `check`."""
        cls.check(folder, study, resume)
        folder.mkdir(parents=True, exist_ok=True)
        store, journal = cls(folder, study), folder / JOURNAL
        # the manifest first, and whole or not at all: it identifies the folder
        if _read_json(folder / MANIFEST).get("study") != study.digest:
            manifest = {
                "format": 1, "study": study.digest, "fascicle": _VERSION,
                "objectives": {name: OBJECTIVES[name].unit for name in study.names},
                "task": study.task.name, "designs": len(study.space), "block": study.block,
                "blocks": study.blocks,
            }  # fmt: skip
            write_text(folder / MANIFEST, json.dumps(manifest, indent=1) + "\n")
        store._write_descriptions()
        # a torn last line must not run into the next one
        if journal.exists() and not journal.read_bytes().endswith(b"\n"):
            with journal.open("a", encoding="utf-8") as file:
                file.write("\n")
        return store

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        """Arrays by objective; opening them takes as long as writing several blocks."""
        import zarr

        group = zarr.open_group(str(self.folder / DATA), mode="r+")
        return {name: group[name] for name in self.study.names}

    def write(self, block: int, values: Values) -> str:
        """Write the `values` [SI] of a block, whole chunks; returns their digest."""
        index = self.study.index(block)
        for name, column in values.items():
            self._arrays[name][index[0] : index[-1] + 1] = column
        return digest_values(values)

    def all(self) -> Values:
        """Read the values [SI] of every design by objective; NaN where no block is written."""
        return {name: np.asarray(array[:]) for name, array in self._arrays.items()}

    def finish(self, block: int, digest: str) -> None:
        """Record that a `block` is written and has this `digest`."""
        with (self.folder / JOURNAL).open("a", encoding="utf-8") as file:
            file.write(json.dumps({"block": block, "bits": digest}) + "\n")

    def finished(self) -> set[int]:
        """Blocks in the journal whose data have the digest of their line."""
        journal = self.folder / JOURNAL
        text = journal.read_text(encoding="utf-8", errors="replace") if journal.exists() else ""
        # other lines were torn by a kill
        lines = re.findall(r'^\{"block": (\d{1,10}), "bits": "(\w+)"\}$', text, re.MULTILINE)
        digests = {int(block): digest for block, digest in lines}
        return {
            block
            for block, digest in digests.items()
            if block < self.study.blocks and self._has_digest(block, digest)
        }

    def _has_digest(self, block: int, digest: str) -> bool:
        """True if the data of a block on the disk have a `digest`."""
        try:
            index = self.study.index(block)
            cut = slice(index[0], index[-1] + 1)
            values = {name: np.asarray(array[cut]) for name, array in self._arrays.items()}
        except Exception:  # noqa: BLE001 zarr's errors for whatever a crash has left: not finished
            return False
        return digest_values(values) == digest

    def remove_drafts(self) -> None:
        """Remove drafts of killed writers: files are written beside their targets, then moved."""
        for draft in (self.folder / DATA).rglob("*.partial"):
            draft.unlink(missing_ok=True)
        for folder in (self.folder, self.folder / DATA, *(self.folder / DATA).iterdir()):
            remove_abandoned(folder)

    def _write_descriptions(self) -> None:
        """Write Zarr's description of the arrays, except where it is on the disk."""
        import zarr
        from zarr.storage import MemoryStore

        descriptions: dict[str, Any] = {}
        group = zarr.open_group(MemoryStore(descriptions), mode="w")
        size = len(self.study.space)
        group.attrs["study"] = self.study.digest
        for name in self.study.names:
            array = group.create_array(
                name, shape=(size,), chunks=(min(self.study.block, size),), dtype="float64",
                fill_value=np.nan, compressors=None, dimension_names=("design",),
            )  # fmt: skip
            unit = OBJECTIVES[name].unit
            array.attrs["units"] = "1" if unit == "-" else unit
            array.attrs["long_name"] = OBJECTIVES[name].about
        for name, content in descriptions.items():
            path, raw = self.folder / DATA / name, content.to_bytes()
            if not path.exists() or path.read_bytes() != raw:
                path.parent.mkdir(parents=True, exist_ok=True)
                write(path, partial(Path.write_bytes, data=raw))


def digest_values(values: Values) -> str:
    """Digest of objectives' `values` [SI]: equal if, and only if, all bits are."""
    sha = hashlib.sha256()
    for name, column in values.items():
        sha.update(name.encode())
        sha.update(np.ascontiguousarray(column, dtype="<f8").tobytes())
    return sha.hexdigest()


def _read_json(path: Path) -> dict[str, Any]:
    """The JSON object of the file at a `path`; empty where there is none that can be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


class BlockResult(NamedTuple):
    """Result of a written block: its digest, the time to compute and to write it [s], the largest
    memory so far [B] of the worker and its process number.
    """

    block: int
    digest: str
    computing: float
    writing: float
    memory: int
    process: int


class Progress(NamedTuple):
    """Progress of a sweep: blocks `done` and in `all`; `designs` computed in this run in `seconds`
    [s]; `last` block.
    """

    done: int
    all: int
    designs: int
    seconds: float
    last: BlockResult | None

    @property
    def rate(self) -> float:
        """Designs per second [1/s] in this run."""
        return self.designs / self.seconds if self.seconds > 0 else 0.0


Watch = Callable[[Progress], None]


def sweep(
    study: Study,
    folder: Path,
    client: Any = None,
    resume: bool = False,
    watch: Watch | None = None,
    worker_timeout: float = _WORKER_TIMEOUT,
) -> Store:
    """Evaluate a study block by block, on workers if there are any, resuming where it stopped.

    **Arguments:**

    - `study`: what to compute.
    - `folder`: of the results.
    - `client`: Dask's, of any deployment; default: this process computes all.
    - `resume`: true to go on with results in the folder.
    - `watch`: called with the progress.
    - `worker_timeout`: time without any worker after which the sweep ends [s].

    **Returns:** the store, complete.

    **Raises:** `ValueError` for a folder that holds something else; `OSError` where a block
    can't be written; `ConnectionError` where the scheduler or all workers are lost.
    """
    store = Store.begin(folder, study, resume)
    finished = store.finished() if resume else set()
    blocks = [block for block in range(study.blocks) if block not in finished]
    start, designs, done = time.perf_counter(), 0, len(finished)
    if watch is not None:
        watch(Progress(done, study.blocks, 0, 0.0, None))
    if client is None:
        results = (_compute_and_write(store, block) for block in blocks)
    else:
        results = _distribute(client, store, blocks, worker_timeout)
    for result in results:
        store.finish(result.block, result.digest)
        designs, done = designs + len(study.index(result.block)), done + 1
        if watch is not None:
            seconds = time.perf_counter() - start
            watch(Progress(done, study.blocks, designs, seconds, result))
    store.remove_drafts()
    return store


_STORES: dict[tuple[str, str], Store] = {}  # a worker's last, with open arrays and its space


def run_block(study: Study, folder: str, block: int) -> BlockResult:
    """Compute and write a block, counted from 0: the task of a worker; `folder`: of the results."""
    key = (folder, study.digest)
    if key not in _STORES:
        _STORES.clear()
    return _compute_and_write(_STORES.setdefault(key, Store(Path(folder), study)), block)


def _compute_and_write(store: Store, block: int) -> BlockResult:
    """Compute and write a block, with timings; the caller records it as finished."""
    start = time.perf_counter()
    values = store.study.values(block)
    computed = time.perf_counter()
    digest = store.write(block, values)
    written = time.perf_counter()
    return BlockResult(block, digest, computed - start, written - computed, _memory(), os.getpid())


def _memory() -> int:
    """Largest memory of this process so far [B]; 0 on systems that don't report it."""
    # not `getrusage`: across a fork that begins with the parent's
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM")), 0)


def _distribute(
    client: Any, store: Store, blocks: list[int], worker_timeout: float
) -> Iterator[BlockResult]:
    """Results of `blocks` as Dask's workers finish them; those of workers that died run again."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    compute = partial(run_block, store.study, str(store.folder.resolve()))
    queue, results = iter(blocks), as_completed(loop=client.loop, with_results=True)
    pending, idle, census, workers = 0, 0.0, -_CENSUS, 1
    try:
        while True:
            if (since := time.monotonic() - census) >= _CENSUS:  # workers may come and go
                restart_dead_workers(client)
                workers, census = len(client.nthreads()), time.monotonic()
                idle += 0.0 if workers else min(since, 2 * _CENSUS)
            if idle >= worker_timeout:
                raise ConnectionError(f"no worker for {worker_timeout:g} s")
            for block in islice(queue, max(0, _BLOCKS_PER_WORKER * max(1, workers) - pending)):
                results.add(client.submit(compute, block, pure=False))
                pending += 1
            if not pending:
                return
            if not results.has_ready():
                time.sleep(_POLL)
                continue
            _, result = next(results)
            if not isinstance(result, BlockResult):
                raise CancelledError
            pending, idle = pending - 1, 0.0
            yield result
    except KilledWorker as error:
        raise ConnectionError(f"a block lost its worker again and again ({error})") from None
    except (CancelledError, CommClosedError, TimeoutError) as error:
        raise ConnectionError(f"the scheduler is lost ({short_reason(error)})") from None
