"""Where a sweep's results are kept: a folder that a sweep can be stopped in at any time.

- `designs.zarr`: an array for each objective, cut into chunks that are the study's blocks;
- `manifest.json`: which study this is; the first file of all;
- `finished.jsonl`: a line for each block that is wholly written, with a digest of its bits.

Blocks are written by whoever computed them, and are on the disk before they are reported; lines
are written by the one who handed them out. Every other file is moved to its place whole. A block
without a line, or one that doesn't read back to the bits of its line, counts as not done: whatever
is left there is written over. What describes the arrays follows from the study, and is written anew
where it is broken.
"""

import contextlib
import json
import os
import tempfile
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ...io.atomic import holds_drafts_only, remove_abandoned, write
from ..judge.judging import Values
from ..judge.objectives import OBJECTIVES
from ..searches.study import Study, bits


DATA, MANIFEST, JOURNAL = "designs.zarr", "manifest.json", "finished.jsonl"
_META = "zarr.json"  # describes a group, or an array
_VERSION = version("fascicle")


class Store:
    """Results of a study in a folder."""

    def __init__(self, folder: Path, study: Study):
        """**Arguments:**

        - `folder`: where they are [-]; `begin` has seen to it.
        - `study`: whose they are [-].
        """
        self.folder, self.study = folder, study

    @classmethod
    def check(cls, folder: Path, study: Study, resume: bool) -> None:
        """Refuse a folder that a study can't go into.

        A run that was killed before its manifest was there leaves an empty folder, or hidden drafts
        in it: then there is nothing to lose, and the sweep begins.

        **Arguments:**

        - `folder`: where results would go [-].
        - `study`: whose [-].
        - `resume`: whether some are there already [-].

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

        - `folder`: where it is [-].
        - `study`: whose results it has [-].
        - `resume`: whether some are there already [-].

        **Returns:** the store [-].

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
        """Write a block [-] of `values` [SI], whole chunks, onto the disk; a digest of it [-]."""
        arrays, index = self._arrays("r+"), self.study.index(block)
        for name, one in values.items():
            arrays[name][index[0] : index[-1] + 1] = one
        for name in values:
            chunk = self.folder / DATA / name / "c" / str(block)
            for path in (chunk, chunk.parent):
                _settle(path)
        return bits(values)

    def read(self, block: int) -> Values:
        """What stands in a `block` [-]: values by objective [SI]."""
        index = self.study.index(block)
        return {
            name: np.asarray(array[index[0] : index[-1] + 1])
            for name, array in self._arrays("r").items()
        }

    def all(self) -> Values:
        """Values [SI] of every design by objective, in memory."""
        return {name: np.asarray(array[:]) for name, array in self._arrays("r").items()}

    def finish(self, block: int, digest: str) -> None:
        """Note that a `block` [-] is written and has this `digest` [-]; on disk on return."""
        line = json.dumps({"block": block, "bits": digest}) + "\n"
        with (self.folder / JOURNAL).open("a", encoding="utf-8") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())

    def finished(self) -> set[int]:
        """Blocks [-] that are done: noted, and with the bits that were noted."""
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
        """Make empty arrays in `folder` [-]."""
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
    told = _read(folder / DATA / _META).get("attributes")
    return told if isinstance(told, dict) and isinstance(told.get("study"), str) else {}


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
