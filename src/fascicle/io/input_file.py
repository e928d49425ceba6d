"""Reading of regular files of a limited size.

Anything else, such as a named pipe or a device, may never end, or never begin.
"""

import stat
from pathlib import Path


def read_bytes(path: Path, largest: int, kind: str, remedy: str = "") -> bytes:
    """Read a regular file.

    **Arguments:**

    - `path`: the file [-].
    - `largest`: how many bytes it may have [-].
    - `kind`: what it should be, as "muscle file" [-].
    - `remedy`: what to do about one that is larger [-]; left out, it isn't of that kind.

    **Returns:** its content [-].

    **Raises:** `OSError`, one line, where it can't be read or is no regular file; `ValueError`
    where it is larger.
    """
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(f"{path}: a folder, not a {kind}.")
        if not stat.S_ISREG(mode):
            other = _OTHERS.get(stat.S_IFMT(mode), "device")
            raise OSError(f"{path}: a {other}, not a regular file.")
        with path.open("rb") as file:
            raw = file.read(largest + 1)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file.") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        if isinstance(error, OSError) and error.errno is None:
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise OSError(f"{str(path)!r}: can't be read: {reason}.") from None
    if len(raw) > largest:
        size = f"{largest / 1e9:g} GB" if largest >= 1e9 else f"{largest} bytes"
        raise ValueError(f"{path}: larger than {size}{remedy or f', not a {kind}.'}")
    return raw


_OTHERS = {stat.S_IFIFO: "named pipe", stat.S_IFSOCK: "socket"}
