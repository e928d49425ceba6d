"""A search cut into blocks, computed by many workers, stopped and resumed at any time.

Blocks are ranges of the space's index, so any worker can compute any block, again if need be, to
the same bits. A study's digest tells its results from those of any other.

The folder of a sweep holds

- `designs.zarr`: an array for each objective, cut into chunks that are the study's blocks;
- `manifest.json`: the study's digest; the first file of all;
- `finished.jsonl`: a line for each finished block, with a digest of its bits.

A worker writes its block, and has it on the disk before it reports; the sweep's own process then
adds the line. Every other file is moved to its place whole. A block without a line, or one that
doesn't read back to the bits of its line, is computed again.
"""

import contextlib
import hashlib
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache, partial
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from ..core.errors import InvalidInputError
from ..io.atomic import holds_drafts_only, remove_abandoned, write
from .cluster import revive
from .evaluation import Values, evaluate
from .objectives import OBJECTIVES, Limit, check_search, recorded_objectives, with_reach_limits
from .space import Space
from .task import Task


LARGEST = 4_000_000_000  # designs; an index is a 64-bit number, a journal has a line a block


@dataclass(frozen=True, eq=False)
class Study:
    """Designs of a `space` for a `task`, `names` of the objectives to record, their `senses`
    and `limits`, which make the front in the end; `block`: designs worked on at once.
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
        """A study.

        **Arguments:**

        - `space`: the designs.
        - `task`: what is demanded.
        - `senses`: "min" or "max" by objective.
        - `limits`: on objectives, by name.
        - `extra`: objectives to record that don't make the front.
        - `block`: designs worked on at once.

        **Returns:** the study.

        **Raises:** `ValueError` for unknown objectives, and blocks and spaces out of range.
        """
        limits = with_reach_limits(limits)
        names = recorded_objectives(senses, limits, extra)
        check_search(senses, limits)
        if not 1 <= block <= 2**20:
            raise InvalidInputError("block", "must lie in [1, 1048576]", block)
        if len(space) > LARGEST:
            raise ValueError(f"the space holds {len(space)} designs, more than {LARGEST}.")
        return cls(space, task, names, dict(senses), limits, block)

    @property
    def blocks(self) -> int:
        """How many blocks there are [-]; the last may be shorter."""
        return -(-len(self.space) // self.block)

    @cached_property
    def digest(self) -> str:
        """What tells this study from any other whose numbers could differ [-]."""
        sha = hashlib.sha256()
        sha.update(json.dumps([version("fascicle"), self.names, self.block]).encode())
        for part in (self.task, self.space):
            for field in fields(part):
                sha.update(field.name.encode())
                _feed(sha, getattr(part, field.name))
        return sha.hexdigest()

    def index(self, block: int) -> np.ndarray:
        """Indices of a block's designs; `block` counts from 0 [-]."""
        start = block * self.block
        return np.arange(start, min(start + self.block, len(self.space)))

    def values(self, block: int) -> Values:
        """Objectives [SI] of a block's designs by name; `block` counts from 0 [-]."""
        return evaluate(self.space.at(self.index(block)), self.task, self.names)


def bits(values: Values) -> str:
    """A digest of objectives' `values` [SI]: the same if, and only if, all bits are."""
    sha = hashlib.sha256()
    for name, one in values.items():
        sha.update(name.encode())
        sha.update(np.ascontiguousarray(one, dtype="<f8").tobytes())
    return sha.hexdigest()


def _feed(sha: Any, value: Any) -> None:
    """Muscles by their laws and numbers, arrays by their bits, all else by its text."""
    if isinstance(value, np.ndarray):
        sha.update(np.ascontiguousarray(value).tobytes())
        return
    if isinstance(value, dict):
        for name, one in value.items():
            sha.update(str(name).encode())
            leaves, structure = jax.tree.flatten(one)
            sha.update(str(structure).encode())
            for leaf in leaves:
                sha.update(np.asarray(leaf, float).tobytes())
        return
    sha.update(repr(value).encode())


DATA, MANIFEST, JOURNAL = "designs.zarr", "manifest.json", "finished.jsonl"
_META = "zarr.json"  # describes a group, or an array
_VERSION = version("fascicle")


class Store:
    """Results of a study in a folder."""

    def __init__(self, folder: Path, study: Study):
        """**Arguments:**

        - `folder`: where they are; `begin` has seen to it.
        - `study`: whose they are.
        """
        self.folder, self.study = folder, study

    @classmethod
    def check(cls, folder: Path, study: Study, resume: bool) -> None:
        """Refuse a folder that a study can't go into.

        A run that was killed before its manifest was there leaves an empty folder, or hidden drafts
        in it: then there is nothing to lose, and the sweep begins.

        **Arguments:**

        - `folder`: where results would go.
        - `study`: whose.
        - `resume`: whether some are there already.

        **Raises:** `ValueError` where there are none to resume, another study's, or any other.
        """
        for place in (folder, *folder.parents):
            if place.is_symlink() and not place.exists():
                raise ValueError(f"{folder}: {place} leads nowhere: name a new folder.")
            if place != folder and place.exists() and not place.is_dir():
                raise ValueError(f"{folder}: {place} is no folder: name a new one.")
        about = _read_about(folder)
        if about.get("study") == study.digest:
            if not resume:
                raise ValueError(f"{folder}: holds a sweep already; --resume goes on with it.")
        elif about:
            if not resume:
                raise ValueError(
                    f"{folder}: holds a sweep already; another study's: name a new folder."
                )
            began = about.get("fascicle", _VERSION)
            goes_on = "sweep with the file that began it"
            if began != _VERSION:
                goes_on = f"go on with fascicle {began}, which began it (this is {_VERSION})"
            raise ValueError(
                f"{folder}: holds another study's results; nothing was changed. Name another"
                f" folder, or {goes_on}."
            )
        elif (folder / MANIFEST).exists() or (folder / DATA / _META).exists():
            raise ValueError(
                f"{folder}: {MANIFEST} can't be read, nor {DATA}/{_META}, so nothing tells whose"
                " results these are; nothing was changed. Name a new folder."
            )
        elif resume and not (folder.is_dir() and holds_drafts_only(folder)):
            raise ValueError(f"{folder}: holds no sweep to resume: leave --resume out.")
        elif folder.exists() and not (folder.is_dir() and holds_drafts_only(folder)):
            raise ValueError(f"{folder}: is there and no sweep of ours: name a new folder.")

    @classmethod
    def begin(cls, folder: Path, study: Study, resume: bool = False) -> "Store":
        """A store for a study, with what may be there from a run that was stopped.

        **Arguments:**

        - `folder`: where it is.
        - `study`: whose results it has.
        - `resume`: whether some are there already.

        **Returns:** the store.

        **Raises:** `ValueError` as `check`.
        """
        cls.check(folder, study, resume)
        folder.mkdir(parents=True, exist_ok=True)
        store = cls(folder, study)
        # first, and whole or not at all: from then on the folder says whose it is
        if _read(folder / MANIFEST).get("study") != study.digest:
            store._sign()
        store._lay_out()
        return store

    def write(self, block: int, values: Values) -> str:
        """Write a block of `values` [SI], whole chunks, onto the disk; a digest of it."""
        arrays, index = self._arrays("r+"), self.study.index(block)
        for name, one in values.items():
            arrays[name][index[0] : index[-1] + 1] = one
        for name in values:
            chunk = self.folder / DATA / name / "c" / str(block)
            for path in (chunk, chunk.parent):
                _settle(path)
        return bits(values)

    def read(self, block: int) -> Values:
        """What stands in a `block`: values by objective [SI]."""
        index = self.study.index(block)
        return {
            name: np.asarray(array[index[0] : index[-1] + 1])
            for name, array in self._arrays("r").items()
        }

    def all(self) -> Values:
        """Values [SI] of every design by objective, in memory."""
        return {name: np.asarray(array[:]) for name, array in self._arrays("r").items()}

    def finish(self, block: int, digest: str) -> None:
        """Note that a `block` is written and has this `digest`; on disk on return."""
        line = json.dumps({"block": block, "bits": digest}) + "\n"
        with (self.folder / JOURNAL).open("a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())

    def finished(self) -> set[int]:
        """Blocks that are done: noted, and with the bits that were noted."""
        return {block for block, digest in dict(self._noted()).items() if self._is(block, digest)}

    def _is(self, block: int, digest: str) -> bool:
        try:
            return bits(self.read(block)) == digest
        except Exception:  # noqa: BLE001 zarr's own for whatever a crash has left: not done
            return False

    def tidy(self) -> None:
        """Remove what killed writers left: files are written beside their place, then moved."""
        for left in (self.folder / DATA).rglob("*.partial"):
            left.unlink(missing_ok=True)
        for folder in (self.folder, self.folder / DATA, *(self.folder / DATA).iterdir()):
            remove_abandoned(folder)

    def _noted(self) -> Iterator[tuple[int, str]]:
        journal = self.folder / JOURNAL
        if not journal.exists():
            return
        for line in journal.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                entry = json.loads(line)
                block, digest = entry["block"], entry["bits"]
            except (ValueError, TypeError, KeyError, RecursionError):
                continue  # torn by a kill
            if type(block) is int and 0 <= block < self.study.blocks and isinstance(digest, str):
                yield block, digest
        # a torn last line must not run into the next one
        if not journal.read_bytes().endswith(b"\n"):
            with journal.open("a", encoding="utf-8") as file:
                file.write("\n")

    def _sign(self) -> None:
        """Write the manifest."""
        manifest = {
            "format": 1,
            "study": self.study.digest,
            "fascicle": _VERSION,
            "objectives": {name: OBJECTIVES[name].unit for name in self.study.names},
            "task": self.study.task.name,
            "designs": len(self.study.space),
            "block": self.study.block,
            "blocks": self.study.blocks,
        }
        _put(self.folder / MANIFEST, (json.dumps(manifest, indent=1) + "\n").encode())

    def _lay_out(self) -> None:
        """Write what describes the arrays, where it isn't there or is broken."""
        with tempfile.TemporaryDirectory() as scratch:
            self._describe(Path(scratch))
            for made in Path(scratch, DATA).rglob(_META):
                there = self.folder / made.relative_to(scratch)
                if _read(there) != _read(made):
                    there.parent.mkdir(parents=True, exist_ok=True)
                    _put(there, made.read_bytes())

    def _describe(self, folder: Path) -> None:
        """Make empty arrays in `folder`."""
        import zarr

        group = zarr.open_group(str(folder / DATA), mode="w")
        size, block = len(self.study.space), min(self.study.block, len(self.study.space))
        group.attrs["study"] = self.study.digest
        for name in self.study.names:
            array = group.create_array(
                name, shape=(size,), chunks=(block,), dtype="float64", fill_value=np.nan,
                compressors=None, dimension_names=("design",),
            )  # fmt: skip
            unit = OBJECTIVES[name].unit
            array.attrs["units"] = "1" if unit == "-" else unit
            array.attrs["long_name"] = OBJECTIVES[name].about

    def _arrays(self, mode: str) -> dict[str, Any]:
        return _opened(str(self.folder / DATA), mode, self.study.names, self.study.digest)


@lru_cache(maxsize=8)
def _opened(path: str, mode: Any, names: tuple[str, ...], digest: str) -> dict[str, Any]:  # noqa: ARG001 another study's arrays may stand at this path later
    """The arrays of a store; to open them takes as long as to write several blocks."""
    import zarr

    group = zarr.open_group(path, mode=mode)
    return {name: group[name] for name in names}


def _read_about(folder: Path) -> dict[str, Any]:
    """What a folder says of the study in it: its manifest, or else the data themselves."""
    manifest = _read(folder / MANIFEST)
    if isinstance(manifest.get("study"), str):
        return manifest
    attributes = _read(folder / DATA / _META).get("attributes")
    return (
        attributes
        if isinstance(attributes, dict) and isinstance(attributes.get("study"), str)
        else {}
    )


def _read(path: Path) -> dict[str, Any]:
    """A JSON object; empty where there is none that can be read."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _put(path: Path, raw: bytes) -> None:
    write(path, lambda draft: draft.write_bytes(raw))
    _settle(path)


def _settle(path: Path) -> None:
    """Have the system bring a file, or a folder's entries, onto the disk, if it is there."""
    # a chunk of nothing but NaN isn't written; not every system opens folders
    with contextlib.suppress(FileNotFoundError, PermissionError, IsADirectoryError):
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


_AHEAD = 3  # blocks handed to each worker, so that none waits for the next
_ASK = 2.0  # s between questions how many workers there are
_LOOK = 0.02  # s between looks whether a block is done
_ALONE = 60.0  # s without any worker, since a block was last done, after which there are none
_KNOWN: dict[str, Study] = {}  # the last study of a worker, by its digest


class BlockResult(NamedTuple):
    """A block that is written: its digest, the time to compute and to write it [s], the
    worker's largest memory so far [B] and its process.
    """

    block: int
    digest: str
    computing: float
    writing: float
    memory: int
    process: int


class Progress(NamedTuple):
    """Blocks `done` and in `all`, `designs` computed in this run in `seconds` [s]."""

    done: int
    all: int
    designs: int
    seconds: float
    last: BlockResult | None

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

    - `study`: what to compute.
    - `folder`: where results are kept.
    - `client`: Dask's, of any deployment; left out, this process does all.
    - `resume`: whether results are there to go on from.
    - `watch`: called with the progress.
    - `alone`: how long without any worker until it is given up [s].

    **Returns:** the store, complete.

    **Raises:** `ValueError` for a folder that holds something else; `OSError` where a block
    can't be written; `ConnectionError` where the scheduler or all workers are lost.
    """
    store = Store.begin(folder, study, resume)
    finished = store.finished() if resume else set()
    left = [block for block in range(study.blocks) if block not in finished]
    start, designs, done = time.perf_counter(), 0, len(finished)
    if watch is not None:
        watch(Progress(done, study.blocks, 0, 0.0, None))
    if client is None:
        work = (run_block(study, str(folder), block) for block in left)
    else:
        work = _distribute(client, study, folder, left, alone)
    for one in work:
        store.finish(one.block, one.digest)
        designs, done = designs + len(study.index(one.block)), done + 1
        if watch is not None:
            seconds = time.perf_counter() - start
            watch(Progress(done, study.blocks, designs, seconds, one))
    store.tidy()
    return store


def run_block(study: Study, folder: str, block: int) -> BlockResult:
    """Compute and write a block: what a worker does.

    **Arguments:**

    - `study`: whose.
    - `folder`: where results are kept, as the worker sees it.
    - `block`: which, counted from 0 [-].

    **Returns:** what was written.
    """
    if study.digest not in _KNOWN:
        _KNOWN.clear()
    study = _KNOWN.setdefault(study.digest, study)  # whose tables are made already
    start = time.perf_counter()
    values = study.values(block)
    computed = time.perf_counter()
    digest = Store(Path(folder), study).write(block, values)
    written = time.perf_counter()
    return BlockResult(block, digest, computed - start, written - computed, _memory(), os.getpid())


def _memory() -> int:
    """Largest memory that this process has held [B]; 0 where the system doesn't tell."""
    # not `getrusage`: across a fork that begins with the parent's
    status = Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM")), 0)


def _distribute(
    client: Any, study: Study, folder: Path, blocks: list[int], patience: float
) -> Iterator[BlockResult]:
    """Blocks as workers finish them; Dask computes those again that a worker died at."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    compute = partial(run_block, study, str(folder.resolve()))
    waiting, results = iter(blocks), as_completed(loop=client.loop, with_results=True)
    pending, idle, asked, workers = 0, 0.0, -_ASK, 1
    try:
        while True:
            if (since := time.monotonic() - asked) >= _ASK:  # workers may come and go
                revive(client)
                workers, asked = len(client.nthreads()), time.monotonic()
                idle += 0.0 if workers else min(since, 2 * _ASK)
            if idle >= patience:
                raise ConnectionError(f"no worker has been there for {patience:g} s")
            for block in islice(waiting, max(0, _AHEAD * max(1, workers) - pending)):
                results.add(client.submit(compute, block, pure=False))
                pending += 1
            if not pending:
                return
            if not results.has_ready():
                time.sleep(_LOOK)
                continue
            _, result = next(results)
            if not isinstance(result, BlockResult):
                raise CancelledError
            pending, idle = pending - 1, 0.0
            yield result
    except KilledWorker as error:
        raise ConnectionError(f"a block lost its worker again and again ({error})") from None
    except (CancelledError, CommClosedError, TimeoutError) as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise ConnectionError(f"the scheduler is lost ({reason})") from None
