"""Files that appear whole or not at all.

The content is written into a hidden draft folder beside the target, flushed to the disk, and moved
to the target in one step; an error before that leaves an existing file untouched. A file that
appears at the target meanwhile stays, unless it may be overwritten. Drafts of killed runs are
found by their name and age, and removed by later ones.
"""

import contextlib
import os
import secrets
import shutil
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path


_DRAFT, _DRAFT_END = ".fascicle-", ".draft"  # of a hidden folder's name
_ABANDONED = 24 * 3600.0  # s after the last change to a draft: no writer pauses for so long
_BROWSER_FILES = {"Thumbs.db", "desktop.ini"}  # that file browsers add, as hidden files


def write(path: str | os.PathLike[str], fill: Callable[[Path], object]) -> None:
    """Let `fill` write a draft and move it to `path` when it is complete; an existing file is
    replaced. Raises as `open_replacement`.
    """
    with open_replacement(path) as draft:
        fill(draft)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text as UTF-8 to a file `path`, completely or not at all; as `write`."""
    write(path, lambda draft: draft.write_text(text, encoding="utf-8", newline="\n"))


@contextlib.contextmanager
def open_replacement(path: str | os.PathLike[str], overwrite: bool = True) -> Iterator[Path]:
    """Context of the path of a draft, to be written as a file; at the end it becomes `path`.

    Raises `OSError`, one line, if the draft can't be written, and `FileExistsError` if `path`
    exists by the end, unless it may be overwritten.
    """
    target = draft = check_writable(path)
    try:
        with open_draft(target) as draft:
            yield draft
            _flush(draft)
            if not overwrite:
                _move_to_free_name(draft, target)
            else:
                if target.is_file():
                    shutil.copymode(target, draft)
                draft.replace(target)
    except OSError as error:
        raise _readable_error(error, {draft, target}, path) from None


@contextlib.contextmanager
def open_draft(target: Path) -> Iterator[Path]:
    """Context of a path of the target's name in a hidden folder beside the `target`, which is
    removed at the end.
    """
    for former in target.parent.glob(f"{_DRAFT}*{_DRAFT_END}"):
        with contextlib.suppress(OSError):
            if time.time() - former.stat().st_mtime > _ABANDONED:
                shutil.rmtree(former, ignore_errors=True)
    folder = target.parent / f"{_DRAFT}{secrets.token_hex(4)}{_DRAFT_END}"
    folder.mkdir()
    try:
        yield folder / target.name
    finally:
        shutil.rmtree(folder, ignore_errors=True)


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


def check_overwrite(path: str | os.PathLike[str], overwrite: bool = False) -> None:
    """Raise `FileExistsError`, one line, for an existing file, unless `overwrite` is true."""
    if not overwrite and Path(path).exists():
        name = os.fspath(path)
        raise FileExistsError(f"{name}: already exists; use --overwrite to overwrite it.")


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
    """Let `fill` write the files of a folder into an empty one, move them to `path` once all are
    complete, and return their names, sorted. A new folder appears in one step; into an existing
    one files go one by one, and those of other names stay. Raises as `check_folder`.
    """
    target = draft = check_folder(path, overwrite)
    try:
        with open_draft(target) as draft:
            draft.mkdir()
            fill(draft)
            _flush(draft)
            entries = sorted(draft.iterdir())
            names = [entry.name for entry in entries]
            if not target.is_dir():
                _move_to_free_name(draft, target)
                return names
            check_folder(path, overwrite)  # again: the work may have taken an hour
            for existing in (target / name for name in names):
                if existing.is_dir() and not existing.is_symlink():
                    raise IsADirectoryError(f"{existing}: is a folder, where a file would go.")
            for entry in entries:
                move = Path.replace if overwrite else _move_to_free_name
                move(entry, target / entry.name)
            return names
    except OSError as error:
        raise _readable_error(error, {draft, target}, path) from None


def _move_to_free_name(draft: Path, target: Path) -> None:
    """Move a draft to a name that nothing has; `FileExistsError` if something appeared there."""
    try:
        if draft.is_dir():
            draft.rename(target)  # fails for a file, and a folder that isn't empty
        else:
            target.hardlink_to(draft)  # fails for anything
    except OSError:
        check_overwrite(target)
        draft.replace(target)  # a file system without links


def _flush(path: Path) -> None:
    """Write what the system still holds of a file, or of a folder's files, to the disk."""
    for file in path.rglob("*") if path.is_dir() else [path]:
        if file.is_file():
            with file.open("rb+") as handle:
                os.fsync(handle.fileno())


def _obstacle(target: Path, folder: bool) -> str:
    """Reason why `target` can't be written, else an empty text."""
    if target.is_symlink():  # links were followed: this one leads to itself
        return "it is a link that leads nowhere"
    if target.is_dir():
        return "" if folder else "it is a folder"
    if target.exists() and (folder or not target.is_file()):
        return "it is a file, not a folder" if target.is_file() else "it is no regular file"
    return "" if target.parent.is_dir() else "no such folder"


def _readable_error(error: OSError, names: Iterable[Path], path: str | os.PathLike[str]) -> OSError:
    """Error in one line that says `path` for other `names` of it."""
    if error.errno is None:  # raised here
        text = str(error)
        for name in names:
            text = text.replace(str(name), os.fspath(path))
        return type(error)(text)
    return OSError(_error_line(path, error.strerror or str(error)))


def _error_line(path: str | os.PathLike[str], reason: str) -> str:
    name = os.fspath(path)
    name = name if name.isprintable() and len(name) < 200 else repr(name)[:200]
    return f"{name}: can't be written: {reason}."
