"""Files that appear completely or not at all.

The content is written into a hidden draft folder beside the target, and moved there in one step; an
error before that leaves an existing file untouched. A draft folder is locked while its writer
lives: the next writer in the same folder removes the drafts of killed ones.
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

_DRAFT, _DRAFT_END = ".fascicle-", ".draft"  # of a hidden folder's name
_BROWSER_FILES = {"Thumbs.db", "desktop.ini"}  # that file browsers add, as hidden files
_FORMER = "former"  # inside a draft folder: the folder that is being replaced
_AT_FDCWD, _RENAME_EXCHANGE, _RENAME_SWAP = -100, 2, 2  # Linux's <fcntl.h>, <stdio.h>, and macOS's


def write(
    path: str | os.PathLike[str], fill: Callable[[Path], object], folder: bool = False
) -> None:
    """Let `fill` write a draft of a file, or of a `folder`, and move it to `path` when it is
    complete; an existing one is replaced. `OSError`, one line, if it can't be written.
    """
    with open_replacement(path, folder) as draft:
        fill(draft)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text as UTF-8 to a file `path`, completely or not at all; as `write`."""
    write(path, lambda draft: draft.write_text(text, encoding="utf-8", newline="\n"))


@contextlib.contextmanager
def open_replacement(path: str | os.PathLike[str], folder: bool = False) -> Iterator[Path]:
    """Context of the path of a draft, to be written as a file or a `folder`; at the end it replaces
    `path`. `OSError` as of `write`.
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
        if str(draft) in str(error) and error.errno is None:  # raised here, about the draft
            raise type(error)(str(error).replace(str(draft), os.fspath(path))) from None
        raise OSError(_error_line(path, error.strerror or str(error))) from None


@contextlib.contextmanager
def open_draft(target: Path) -> Iterator[Path]:
    """Context of a path of the target's name in a hidden folder beside the `target`, which is
    removed at the end.
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
    """Path of a file, or of a `folder`, with links followed; `OSError`, one line, if it can't be
    written: before the work begins.
    """
    target = Path(path)
    try:
        target = target.resolve()
        reason = _obstacle(target, folder)
        if not reason:
            # only a trial is reliable for root, on read-only disks and on full ones
            with open_draft(target) as draft:
                draft.touch(exist_ok=False)
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links; a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
    if reason:
        raise OSError(_error_line(path, reason))
    return target


def check_overwrite(
    path: str | os.PathLike[str], overwrite: bool = False, flag: str = "--overwrite"
) -> None:
    """Raise `FileExistsError`, one line with the option `flag`, for an existing file, unless
    `overwrite` is true.
    """
    if not overwrite and Path(path).exists():
        raise FileExistsError(f"{os.fspath(path)}: already exists; use {flag} to overwrite it.")


def check_folder(path: str | os.PathLike[str], overwrite: bool = False) -> Path:
    """Path of a folder, with links followed; `FileExistsError`, one line with a file's name, if it
    holds files, unless `overwrite` is true.
    """
    target = check_writable(path, folder=True)
    if overwrite or not target.is_dir():
        return target
    names = sorted(entry.name for entry in target.iterdir())
    names = [name for name in names if not name.startswith(".") and name not in _BROWSER_FILES]
    if names:
        count = f" and {len(names) - 1} more" if len(names) > 1 else ""
        raise FileExistsError(
            f"{os.fspath(path)}: already holds {names[0]}{count}; name a new folder, or use"
            " --overwrite to replace files of the same name and keep all others."
        )
    return target


def write_folder(
    path: str | os.PathLike[str], fill: Callable[[Path], object], overwrite: bool = False
) -> list[str]:
    """Let `fill` write the files of a folder into an empty one, and move them to `path` once all
    are complete. A new folder appears in one step. In an existing one each file is replaced in one
    step, and files of other names stay. Returns the names of the files, sorted. Raises as
    `check_folder`.
    """
    target = draft = check_folder(path, overwrite)
    try:
        with open_draft(target) as draft:
            draft.mkdir()
            fill(draft)
            entries = sorted(draft.iterdir())
            names = [entry.name for entry in entries]
            if not target.is_dir():
                draft.replace(target)
                return names
            check_folder(path, overwrite)  # again: the work may have taken an hour
            for existing in (target / entry.name for entry in entries):
                if existing.is_dir() and not existing.is_symlink():
                    raise IsADirectoryError(f"{existing}: is a folder, where a file would go.")
            for entry in entries:
                entry.replace(target / entry.name)
            return names
    except OSError as error:
        if error.errno is None:  # raised here, perhaps about the draft
            raise type(error)(str(error).replace(str(draft), os.fspath(path))) from None
        raise OSError(_error_line(path, error.strerror or str(error))) from None


def remove_abandoned(parent: Path) -> None:
    """Remove the draft folders of killed writers in a folder: their lock is free."""
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
    """True for a folder that holds at most drafts of killed writers."""
    names = [entry.name for entry in folder.iterdir()]
    return all(name.startswith(_DRAFT) and name.endswith(_DRAFT_END) for name in names)


def _obstacle(target: Path, folder: bool) -> str:
    """Reason why `target` can't be written, else an empty text."""
    if target.is_symlink():  # links were followed: this one leads to itself
        return "it is a link that leads nowhere"
    if target.is_dir():
        return "" if folder else "it is a folder"
    if target.exists() and not target.is_file():
        return "it is no regular file"
    return "" if target.parent.is_dir() else "no such folder"


def _error_line(path: str | os.PathLike[str], reason: str) -> str:
    name = os.fspath(path)
    name = name if name.isprintable() and len(name) < 200 else repr(name)[:200]
    return f"{name}: can't be written: {reason}."


def _replace_folder(draft: Path, target: Path) -> None:
    """Replace the folder `target` by the folder `draft`."""
    if _exchange(draft, target):
        return
    # on systems that can't exchange folders the existing one is moved first; `remove_abandoned`
    # moves it back if this process is killed here
    former = draft.parent / _FORMER
    former.mkdir()
    target.replace(former / target.name)
    draft.replace(target)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two folders in one step; false on systems that can't."""
    if sys.platform == "win32":
        return False
    libc, names = ctypes.CDLL(None), (os.fsencode(first), os.fsencode(second))
    if hasattr(libc, "renameat2"):
        arguments = (_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE)
        return libc.renameat2(*arguments) == 0
    if hasattr(libc, "renamex_np"):
        return libc.renamex_np(*names, _RENAME_SWAP) == 0
    return False


def _locked_folder(parent: Path) -> tuple[Path, int | None]:
    """A new draft folder, and the handle of its lock."""
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
    """Handle of a folder's lock; `None` on systems without locks, and if it is locked."""
    if fcntl is None:
        return None
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:  # held, or a file system without locks
        os.close(handle)
        return None
    return handle
