"""Files that appear whole or not at all.

The content is written into a hidden draft folder beside its place, and moved there in one step;
whatever goes wrong before leaves what was there untouched. A draft folder is locked as long as its
writer lives: the next writer in the same folder removes the drafts of those that were killed.
"""

import contextlib
import ctypes
import os
import secrets
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path


if sys.platform == "win32":
    fcntl = None
else:
    import fcntl

_DRAFT, _DRAFT_END = ".fascicle-", ".draft"
_LITTER = {"Thumbs.db", "desktop.ini"}  # of file browsers, as hidden files are
_FORMER = "former"  # inside a draft folder: the folder that is being replaced
_AT_FDCWD, _RENAME_EXCHANGE, _RENAME_SWAP = -100, 2, 2  # Linux's <fcntl.h>, <stdio.h>, and macOS's


def write(
    path: str | os.PathLike[str], fill: Callable[[Path], object], folder: bool = False
) -> None:
    """Let `fill` write a file, and put it at `path` once it is complete.

    **Arguments:**

    - `path`: where it goes [-]; a file that is there is replaced.
    - `fill`: writes the content at the path it is given [-].
    - `folder`: whether that is a folder [-]; one that is there is replaced too.

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    with replace_whole(path, folder) as draft:
        fill(draft)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Put `text` at `path`, whole or not at all.

    **Arguments:**

    - `path`: where it goes [-]; a file that is there is replaced.
    - `text`: what it will hold [-], as UTF-8.

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    write(path, lambda draft: draft.write_text(text, encoding="utf-8", newline="\n"))


@contextlib.contextmanager
def replace_whole(path: str | os.PathLike[str], folder: bool = False) -> Iterator[Path]:
    """Give a place to write to, and move what was written there to `path` at the end.

    **Arguments:**

    - `path`: where it goes [-]; a file that is there is replaced.
    - `folder`: whether that is a folder [-]; one that is there is replaced too.

    **Returns:** the draft's path [-], of the same name.

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    target = draft = check_writable(path, folder)
    try:
        with open_draft(target) as draft:
            yield draft
            if target.is_file():
                shutil.copymode(target, draft)
            if target.is_dir():
                _replace_folder(draft, target)
            else:
                draft.replace(target)
    except OSError as error:
        if str(draft) in str(error) and error.errno is None:  # a line of this kind, of the draft
            raise type(error)(str(error).replace(str(draft), os.fspath(path))) from None
        raise OSError(_line(path, error.strerror or str(error))) from None


@contextlib.contextmanager
def open_draft(target: Path) -> Iterator[Path]:
    """Give a path to write to, in a hidden folder that is removed at the end.

    **Arguments:** `target`: beside which the folder is made [-].

    **Returns:** the path in it, of the target's name [-].
    """
    remove_abandoned(target.parent)
    folder, lock = _locked_folder(target.parent)
    try:
        yield folder / target.name
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def check_writable(path: str | os.PathLike[str], folder: bool = False) -> Path:
    """Refuse a path that can't be written, before the work that would go there is done.

    **Arguments:**

    - `path`: where a file will go [-].
    - `folder`: whether a folder may stand there, to be replaced [-].

    **Returns:** the path, links followed, so that a link stays one [-].

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    target = Path(path)
    try:
        target = target.resolve()
        reason = _reason(target, folder)
        if not reason:
            # trying is the one test that holds for root, read-only disks and full ones alike
            with open_draft(target) as draft:
                draft.touch(exist_ok=False)
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links; a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
    if reason:
        raise OSError(_line(path, reason))
    return target


def check_overwrite(
    path: str | os.PathLike[str], overwrite: bool = False, flag: str = "--overwrite"
) -> None:
    """Refuse to replace an existing file, unless `overwrite` is true.

    **Arguments:**

    - `path`: where a file will go.
    - `overwrite`: true to accept an existing file.
    - `flag`: the option that says so, for the message.

    **Raises:** `FileExistsError`, one line.
    """
    if not overwrite and Path(path).exists():
        raise FileExistsError(f"{os.fspath(path)}: already exists; use {flag} to overwrite it.")


def check_folder(
    path: str | os.PathLike[str], overwrite: bool = False, flag: str = "--overwrite"
) -> Path:
    """Refuse a folder that holds files, unless `overwrite` is true.

    **Arguments:** as for `check_overwrite`.

    **Returns:** the folder, links followed.

    **Raises:** `FileExistsError`, one line with a file's name; `OSError` if nothing can be written.
    """
    target = check_writable(path, folder=True)
    if overwrite or not target.is_dir():
        return target
    names = sorted(entry.name for entry in target.iterdir())
    names = [name for name in names if not name.startswith(".") and name not in _LITTER]
    if names:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        raise FileExistsError(
            f"{os.fspath(path)}: already holds {names[0]}{more}; name a new folder, or use {flag}"
            " to replace files of the same name and keep all others."
        )
    return target


def write_folder(
    path: str | os.PathLike[str],
    fill: Callable[[Path], object],
    overwrite: bool = False,
    flag: str = "--overwrite",
) -> None:
    """Let `fill` write the files of a folder, and move them there once all are complete.

    A new folder appears in one step. In an existing one, each file is replaced in one step, and
    files of other names stay.

    **Arguments:**

    - `path`, `overwrite`, `flag`: as for `check_folder`.
    - `fill`: writes into the empty folder that it is given.

    **Raises:** as `check_folder`.
    """
    target = draft = check_folder(path, overwrite, flag)
    try:
        with open_draft(target) as draft:
            draft.mkdir()
            fill(draft)
            if not target.is_dir():
                draft.replace(target)
                return
            check_folder(path, overwrite, flag)  # again: the work may have taken an hour
            entries = sorted(draft.iterdir())
            for there in (target / entry.name for entry in entries):
                if there.is_dir() and not there.is_symlink():
                    raise IsADirectoryError(f"{there}: is a folder, where a file would go.")
            for entry in entries:
                entry.replace(target / entry.name)
    except OSError as error:
        if error.errno is None:  # one of these lines, perhaps with the draft's path
            raise type(error)(str(error).replace(str(draft), os.fspath(path))) from None
        raise OSError(_line(path, error.strerror or str(error))) from None


def remove_abandoned(parent: Path) -> None:
    """Remove the draft folders of writers that were killed: nobody holds their lock.

    **Arguments:** `parent`: the folder that they are in [-].
    """
    with contextlib.suppress(OSError):
        for folder in list(parent.glob(f"{_DRAFT}*{_DRAFT_END}")):
            with contextlib.suppress(OSError):
                lock = _lock(folder, wait=False)
                if lock is None:
                    continue
                try:
                    for former in (folder / _FORMER).glob("*"):
                        if not (parent / former.name).exists():
                            former.replace(parent / former.name)
                    shutil.rmtree(folder, ignore_errors=True)
                finally:
                    os.close(lock)


def holds_drafts_only(folder: Path) -> bool:
    """Whether a folder is empty but for what killed writers may have left.

    **Arguments:** `folder`: it [-].

    **Returns:** whether it is [-].
    """
    names = [entry.name for entry in folder.iterdir()]
    return all(name.startswith(_DRAFT) and name.endswith(_DRAFT_END) for name in names)


def _reason(target: Path, folder: bool) -> str:
    """Why nothing can be written at `target`; empty if it may be."""
    if target.is_symlink():  # links were followed: this one leads to itself
        return "it is a link that leads nowhere"
    if target.is_dir():
        return "" if folder else "it is a folder"
    if target.exists() and not target.is_file():
        return "it is no regular file"
    return "" if target.parent.is_dir() else "no such folder"


def _line(path: str | os.PathLike[str], reason: str) -> str:
    name = os.fspath(path)
    shown = name if name.isprintable() and len(name) < 200 else repr(name)[:200]
    return f"{shown}: can't be written: {reason}."


def _replace_folder(draft: Path, target: Path) -> None:
    """Put the folder `draft` in the place of the folder `target`."""
    if _exchange(draft, target):
        return
    # where folders can't be exchanged in one step, the former one steps aside first; of a run that
    # is killed here, `remove_abandoned` puts it back
    former = draft.parent / _FORMER
    former.mkdir()
    target.replace(former / target.name)
    draft.replace(target)


def _exchange(one: Path, other: Path) -> bool:
    """Whether two folders could be exchanged in one step, and were."""
    if sys.platform == "win32":
        return False
    libc, names = ctypes.CDLL(None), (os.fsencode(one), os.fsencode(other))
    if hasattr(libc, "renameat2"):
        places = (_AT_FDCWD, names[0], _AT_FDCWD, names[1])
        return libc.renameat2(*places, _RENAME_EXCHANGE) == 0
    if hasattr(libc, "renamex_np"):
        return libc.renamex_np(*names, _RENAME_SWAP) == 0
    return False


def _locked_folder(parent: Path) -> tuple[Path, int | None]:
    """A new draft folder, and the handle that holds its lock."""
    while True:
        folder = parent / f"{_DRAFT}{secrets.token_hex(4)}{_DRAFT_END}"
        folder.mkdir()
        # another writer may have removed it before it was locked
        with contextlib.suppress(FileNotFoundError):
            lock = _lock(folder, wait=True)
            if folder.exists():
                return folder, lock
            if lock is not None:
                os.close(lock)


def _lock(folder: Path, wait: bool) -> int | None:
    """A handle that holds a folder's lock; `None` where there are no locks, or another has it."""
    if fcntl is None:
        return None
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:  # held, or a file system without locks
        os.close(handle)
        return None
    return handle
