"""Files that appear whole or not at all.

The content is written beside its place, under a name of its own, and moved there in one
step; whatever goes wrong before leaves what was there untouched.
"""

import contextlib
import os
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path


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
    target = check_writable(path, folder)
    draft = target.with_name(f".{secrets.token_hex(4)}-{target.name}")
    try:
        fill(draft)
        if target.is_file():
            shutil.copymode(target, draft)
        if folder and target.is_dir():
            # folders can't be exchanged in one step: the old one steps aside first
            aside = target.with_name(f".{secrets.token_hex(4)}-{target.name}")
            target.replace(aside)
            draft.replace(target)
            _remove(aside)
        else:
            draft.replace(target)
    except OSError as error:
        raise OSError(_line(path, error.strerror or str(error))) from None
    finally:
        _remove(draft)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Put `text` at `path`, whole or not at all.

    **Arguments:**

    - `path`: where it goes [-]; a file that is there is replaced.
    - `text`: what it will hold [-], as UTF-8.

    **Raises:** `OSError`, one line, where nothing can be written there.
    """
    write(path, lambda draft: draft.write_text(text, encoding="utf-8", newline="\n"))


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
            probe = target.with_name(f".{secrets.token_hex(4)}-{target.name}")
            probe.touch(exist_ok=False)
            probe.unlink()
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links; a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
    if reason:
        raise OSError(_line(path, reason))
    return target


def _reason(target: Path, folder: bool) -> str:
    """Why nothing can be written at `target`; empty if it may be."""
    if target.is_dir():
        return "" if folder else "it is a folder"
    if target.exists() and not target.is_file():
        return "it is no regular file"
    return "" if target.parent.is_dir() else "no such folder"


def _line(path: str | os.PathLike[str], reason: str) -> str:
    name = os.fspath(path)
    shown = name if name.isprintable() and len(name) < 200 else repr(name)[:200]
    return f"{shown}: can't be written: {reason}."


def _remove(draft: Path) -> None:
    with contextlib.suppress(OSError):
        if draft.is_dir():
            shutil.rmtree(draft)
        else:
            draft.unlink(missing_ok=True)
