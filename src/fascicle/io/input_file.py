"""Reading of regular files of a limited size.

Reading another kind, such as a named pipe or a device, may never end.
"""

import stat
from pathlib import Path


# what paths that are no regular files are, besides folders and devices
_KINDS = {stat.S_IFIFO: "named pipe", stat.S_IFSOCK: "socket"}


def read_bytes(path: Path, limit: int, kind: str, remedy: str = "") -> bytes:
    """Content of a regular file of at most `limit` bytes; `OSError`, one line, for another one,
    `ValueError` for a larger one. `kind`: of the expected file, such as "muscle file"; `remedy`:
    for a larger file, default: it is no such file.
    """
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(f"{path}: a folder, not a {kind}.")
        if not stat.S_ISREG(mode):
            name = _KINDS.get(stat.S_IFMT(mode), "device")
            raise OSError(f"{path}: a {name}, not a regular file.")
        with path.open("rb") as file:
            raw = file.read(limit + 1)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file.") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        if isinstance(error, OSError) and error.errno is None:
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise OSError(f"{str(path)!r}: can't be read: {reason}.") from None
    if len(raw) > limit:
        size = f"{limit / 1e9:g} GB" if limit >= 1e9 else f"{limit} bytes"
        raise ValueError(f"{path}: larger than {size}{remedy or f', not a {kind}.'}")
    return raw
