"""Where a sweep's results are kept: a folder that a sweep can be stopped in at any time.

- `designs.zarr`: an array for each objective, cut into chunks that are the study's blocks;
- `manifest.json`: which study this is;
- `finished.jsonl`: a line for each block that is wholly written, with a digest of its bits.

Blocks are written by whoever computed them, lines by the one who handed them out. A block
without a line counts as not done: whatever a killed writer left there is written over.
"""

import json
import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from .judging import Values
from .objectives import OBJECTIVES
from .study import Study, bits


DATA, MANIFEST, JOURNAL = "designs.zarr", "manifest.json", "finished.jsonl"
OURS = {DATA, MANIFEST, JOURNAL, "front.nc"}


class Store:
    """Results of a study in a folder."""

    def __init__(self, folder: Path, study: Study):
        """**Arguments:**

        - `folder`: where they are [-]; `created` or `opened` has seen to it.
        - `study`: whose they are [-].
        """
        self.folder, self.study = folder, study

    @classmethod
    def check(cls, folder: Path, study: Study, resume: bool) -> None:
        """Refuse a folder that a study can't go into.

        **Arguments:**

        - `folder`: where results would go [-].
        - `study`: whose [-].
        - `resume`: whether some are there already [-].

        **Raises:** `ValueError` where there are none to resume, another study's, or any other.
        """
        there = (folder / MANIFEST).exists()
        same = there and _manifest(folder).get("study") == study.digest
        if resume and not there:
            raise ValueError(f"{folder}: holds no sweep to resume: leave --resume out.")
        if resume and not same:
            raise ValueError(
                f"{folder}: holds another study's results; nothing was changed. Name another"
                " folder, or sweep with the file that began it."
            )
        if there and not resume:
            hint = "--resume goes on with it" if same else "another study's: name a new folder"
            raise ValueError(f"{folder}: holds a sweep already; {hint}.")
        if not there and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ValueError(f"{folder}: is there and no sweep of ours: name a new folder.")

    @classmethod
    def created(cls, folder: Path, study: Study) -> "Store":
        """A new, empty one.

        **Arguments:**

        - `folder`: where [-]; it must not be there, or be empty.
        - `study`: whose results will go there [-].

        **Returns:** the store [-].

        **Raises:** `ValueError` for a folder that holds anything.
        """
        cls.check(folder, study, resume=False)
        folder.mkdir(parents=True, exist_ok=True)
        store = cls(folder, study)
        store._lay_out()
        manifest = {
            "format": 1,
            "study": study.digest,
            "objectives": {name: OBJECTIVES[name].unit for name in study.names},
            "task": study.task.name,
            "designs": len(study.space),
            "block": study.block,
            "blocks": study.blocks,
        }
        # last: a folder with a manifest is complete
        draft = folder / f".{MANIFEST}"
        draft.write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
        draft.replace(folder / MANIFEST)
        return store

    @classmethod
    def opened(cls, folder: Path, study: Study) -> "Store":
        """One that a sweep was stopped in.

        **Arguments:**

        - `folder`: where it is [-].
        - `study`: which must be the same [-].

        **Returns:** the store [-].

        **Raises:** `ValueError` where there is none, or another study's.
        """
        cls.check(folder, study, resume=True)
        return cls(folder, study)

    def write(self, block: int, values: Values) -> str:
        """Write a block [-] of `values` [SI], whole chunks; gives a digest of its bits [-]."""
        arrays, index = self._arrays("r+"), self.study.index(block)
        for name, one in values.items():
            arrays[name][index[0] : index[-1] + 1] = one
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
        noted = dict(self._noted())
        return {block for block, digest in noted.items() if bits(self.read(block)) == digest}

    def tidy(self) -> None:
        """Remove what killed writers left: chunks are written beside their place, then moved."""
        for left in (self.folder / DATA).rglob("*.partial"):
            left.unlink(missing_ok=True)

    def _noted(self) -> Iterator[tuple[int, str]]:
        journal = self.folder / JOURNAL
        if not journal.exists():
            return
        for line in journal.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                entry = json.loads(line)
                block, digest = int(entry["block"]), str(entry["bits"])
            except (ValueError, TypeError, KeyError):
                continue  # torn by a kill
            if 0 <= block < self.study.blocks:
                yield block, digest
        # a torn last line must not run into the next one
        if not journal.read_bytes().endswith(b"\n"):
            with journal.open("a", encoding="utf-8") as file:
                file.write("\n")

    def _lay_out(self) -> None:
        import zarr

        group = zarr.open_group(str(self.folder / DATA), mode="w")
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


def _manifest(folder: Path) -> dict[str, Any]:
    try:
        found = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ValueError(f"{folder / MANIFEST}: can't be read: {error}.") from None
    return found if isinstance(found, dict) else {}
