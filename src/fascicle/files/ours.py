"""What fascicle wrote and nobody changed since: all that it replaces or removes unasked.

Anything else may be a measurement, or a file that someone has edited. A folder of results lists
its files, with digests of their content, in `.fascicle.json`. A single file leaves nothing beside
it: a digest of its path and content is added to a list in the user's own state folder, which may
be lost at any time and then only costs a `--force`.
"""

import contextlib
import hashlib
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ..io.atomic import check_writable, open_draft, replace_whole, write_text
from ..io.input_file import is_input


MANIFEST = ".fascicle.json"
_ABOUT = (
    "Files that fascicle wrote here. A next run replaces or removes them only while they are as"
    " they were written."
)
_LARGEST = 10_000_000  # bytes of a list that is read
_MOST = 20_000  # files that are remembered, the latest
_LITTER = {"Thumbs.db", "desktop.ini"}  # left by those who look at a folder, as dotfiles are


@contextlib.contextmanager
def replacing(
    path: str | os.PathLike[str], force: bool = False, flag: str = "--force", folder: bool = False
) -> Iterator[Path]:
    """Write a file, or a zarr store, inside; it goes to `path` whole, and is ours from then on.

    **Arguments:**

    - `path`, `force`, `flag`: those of `check_file` [-].
    - `folder`: whether it is a folder [-].

    **Returns:** where to write it [-].

    **Raises:** as `check_file`; `OSError`, one line, where nothing can be written there.
    """
    check_file(path, force, flag)
    target = Path(path).resolve()
    with replace_whole(path, folder) as draft:
        yield draft
        _remember(target, digest(draft))  # first: killed in between, the file is still ours


def check_file(path: str | os.PathLike[str], force: bool = False, flag: str = "--force") -> None:
    """Refuse a place where something stands that isn't ours, or that was read before.

    **Arguments:**

    - `path`: where a file will go [-].
    - `force`: whether whatever is there is replaced [-].
    - `flag`: the option that says so [-].

    **Raises:** `FileExistsError`, one line.
    """
    there = Path(path)
    if force or not there.exists():
        return
    if not _remembered(there):
        raise FileExistsError(
            f"{os.fspath(path)}: is there already, not as fascicle wrote it; {flag} replaces it."
        )
    if is_input(there):
        raise FileExistsError(replaces_input(path, flag))


def replaces_input(path: str | os.PathLike[str], flag: str) -> str:
    """What to say of an output at `path` [-] that is an input, too [-]; `flag`: the option that
    replaces it [-].
    """
    return f"{os.fspath(path)}: is read by this command: name another file, or {flag} replaces it."


def check_folder(
    folder: str | os.PathLike[str], command: str, force: bool = False, flag: str = "--force"
) -> Path:
    """Refuse a folder that holds what isn't ours, before the work that would go there is done.

    **Arguments:**

    - `folder`: where results will go [-].
    - `command`: that writes them [-].
    - `force`: whether to go ahead: replace files of the same name, keep all others [-].
    - `flag`: the option that says so [-].

    **Returns:** the folder, links followed [-].

    **Raises:** `FileExistsError`, one line with the file's name; `OSError` where nothing can be
    written.
    """
    target = check_writable(folder, folder=True)
    if force or not target.is_dir():
        return target
    told = _listed(target)
    held = ""
    if told and told["command"] != command:
        held = f"what `fascicle {told['command']}` wrote"
    for name in sorted(entry.name for entry in target.iterdir()):
        if held or name.startswith(".") or name in _LITTER:
            continue
        if not _unchanged(target / name, told):
            known = told and name in _names(told)
            since = "was changed since fascicle wrote it" if known else "fascicle didn't write"
            held = f"{name}, which {since}"
    if held:
        raise FileExistsError(
            f"{os.fspath(folder)}: holds {held}: name a new folder, or {flag}, which replaces files"
            " of the same name and keeps all others."
        )
    return target


def write_folder(
    folder: str | os.PathLike[str],
    command: str,
    fill: Callable[[Path], object],
    force: bool = False,
    flag: str = "--force",
) -> None:
    """Let `fill` write the files of a folder, and put them there once all are complete.

    A folder that is there stays, with all in it that isn't ours. Its own files are replaced one by
    one, each in one step, and removed where they are no longer written. The list comes first, with
    what was and what will be: wherever this is stopped, what is there is still known as ours.

    **Arguments:**

    - `folder`, `command`, `force`, `flag`: as of `check_folder` [-].
    - `fill`: writes into the empty folder that it is given [-].

    **Raises:** as `check_folder`.
    """
    target = check_folder(folder, command, force, flag)
    draft = target
    try:
        with open_draft(target) as draft:
            draft.mkdir()
            fill(draft)
            made = {entry.name: digest(entry) for entry in sorted(draft.iterdir())}
            if target.is_dir():
                check_folder(folder, command, force, flag)  # again: the work may have taken an hour
                inputs = [name for name in made if is_input(target / name)]
                if inputs and not force:
                    raise FileExistsError(replaces_input(Path(folder, inputs[0]), flag))
                _put(draft, target, command, made)
            else:
                _list(draft, command, made)
                draft.replace(target)
    except OSError as error:
        if error.errno is None:  # says it all, save where the draft would have gone
            raise type(error)(str(error).replace(str(draft), os.fspath(folder))) from None
        raise OSError(f"{os.fspath(folder)}: can't be written: {error.strerror}.") from None


def digest(path: Path) -> str:
    """A digest [-] of a file, or of all files of a folder and their names; `path`: its [-]."""
    told = hashlib.sha256()
    if path.is_dir():
        for entry in sorted(one for one in path.rglob("*") if one.is_file()):
            told.update(f"{entry.relative_to(path).as_posix()}\0{digest(entry)}\n".encode())
        return told.hexdigest()
    if not path.is_file():
        raise OSError(f"{path}: no regular file.")
    with path.open("rb") as file:
        while block := file.read(2**20):
            told.update(block)
    return told.hexdigest()


def _put(draft: Path, target: Path, command: str, made: dict[str, str]) -> None:
    """Move what was `made` from `draft` into `target`, and remove what it no longer has."""
    told = _listed(target)
    names = _names(told) if told and told["command"] == command else ()
    before = {n: digest(target / n) for n in names if _unchanged(target / n, told)}
    stale = [name for name in before if name not in made]
    _list(target, command, made, before)
    for name in made:
        there = target / name
        if there.is_dir() and not there.is_symlink():
            if not _unchanged(there, told):
                raise IsADirectoryError(f"{there}: is a folder, where a file would go.")
            _remove(there)
        (draft / name).replace(there)
    for name in stale:
        _remove(target / name)
    _list(target, command, made)


def _list(folder: Path, command: str, files: dict[str, str], before: Any = None) -> None:
    """Write the list of a folder's `files`; `before`: of those that may still be there."""
    from .. import __version__

    told = {
        "about": _ABOUT, "format": 1, "command": command, "fascicle": __version__, "files": files,
    }  # fmt: skip
    if before:
        told["before"] = before
    write_text(folder / MANIFEST, json.dumps(told, indent=1) + "\n")


def _listed(folder: Path) -> dict[str, Any]:
    """What a folder's list says; empty where there is none that can be read."""
    try:
        with (folder / MANIFEST).open("rb") as file:
            told = json.loads(file.read(_LARGEST))
        found = {
            "command": told["command"],
            "files": told["files"],
            "before": told.get("before", {}),
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}
    good = isinstance(found["command"], str)
    good &= all(isinstance(found[key], dict) for key in ("files", "before"))
    return found if good else {}


def _names(told: dict[str, Any]) -> list[str]:
    """Plain names [-] that a folder's list has, whoever wrote it."""
    every = [*told["files"], *told["before"]]
    return sorted({name for name in every if Path(name).name == name})


def _unchanged(path: Path, told: dict[str, Any]) -> bool:
    """Whether a folder's list `told` of the file at `path`, and it is as it was written."""
    known = [told[key].get(path.name) for key in ("files", "before")] if told else []
    try:
        return any(known) and not path.is_symlink() and digest(path) in known
    except OSError:
        return False


def _remembered(path: Path) -> bool:
    try:
        known = _list_of_files().read_text(encoding="ascii", errors="replace")
        return _mark(path, digest(path)) in known
    except (OSError, RuntimeError):
        return False


def _remember(path: Path, content: str) -> None:
    """Note that a file at `path` with that digest of its `content` is ours; where nothing can be
    kept, it is forgotten.
    """
    with contextlib.suppress(OSError, RuntimeError):
        kept, mark = _list_of_files(), f"{_mark(path, content)}\n"
        kept.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with kept.open("a", encoding="ascii") as file:
            file.write(mark)
        if kept.stat().st_size > 2 * _MOST * len(mark):
            lines = kept.read_text(encoding="ascii", errors="ignore").splitlines(keepends=True)
            write_text(kept, "".join(lines[-_MOST:]))


def _mark(path: Path, content: str) -> str:
    """A digest of where a file is and of what it holds: of no use to anyone who reads it."""
    where = os.fsencode(path.resolve())
    return hashlib.sha256(where + b"\0" + content.encode()).hexdigest()


def _list_of_files() -> Path:
    """Where the list of single files is kept; `RuntimeError` where there is no such place."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", "")
    else:
        base = os.environ.get("XDG_STATE_HOME", "") or "~/.local/state"
    folder = Path(base, "fascicle").expanduser()
    if not folder.is_absolute():
        raise RuntimeError("no folder for state")
    return folder / "written"


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
