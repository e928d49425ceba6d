"""Files from a user: regular files of a limited size, and TOML, with errors in one line.

Reading another kind, such as a named pipe or a device, may never end.
"""

import re
import stat
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any


# what paths that are no regular files are, besides folders and devices
_KINDS = {stat.S_IFIFO: "named pipe", stat.S_IFSOCK: "socket"}

_PARTS = 64  # parts of a key; files of this format have five
# tomllib takes time and memory that grow with the square of a key's parts: 64 kB took 40 s and 4 GB
_DEEP_KEY = re.compile(
    rf"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{_PARTS}}}""", re.ASCII
)
_INTEGER_LIMIT = 2**63  # integers of TOML have 64 bits


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


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Tables of a TOML text; `ValueError`, one line with the name `source` and the position, for a
    text that is no TOML, is nested too deep, or holds a whole number beyond 64 bits.
    """
    if deep := _DEEP_KEY.search(text):
        line = text.count("\n", 0, deep.start()) + 1
        raise ValueError(f"{source}: not TOML: nested too deep on line {line}: shorten its key.")
    try:
        data = tomllib.loads(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{source}: not TOML: {' '.join(str(error).split())}.") from None
    except RecursionError:
        raise ValueError(f"{source}: not TOML: nested too deep.") from None
    except ValueError:  # Python's own, for a number of more digits than it reads
        long = re.search(r"[\d_]{1000,}", text)
        line = f" on line {text.count(chr(10), 0, long.start()) + 1}" if long else ""
        raise ValueError(f"{source}: not TOML: a number of thousands of digits{line}.") from None
    for keys in _too_large(data):
        raise ValueError(f"{source}: {'.'.join(keys)}: a whole number beyond 64 bits: check it.")
    return data


def _too_large(data: Any) -> Iterator[list[str]]:
    """Keys that lead to numbers beyond the range of TOML's integers."""
    if isinstance(data, int) and not -_INTEGER_LIMIT <= data < _INTEGER_LIMIT:
        yield []
    entries = data.items() if isinstance(data, dict) else ()
    entries = enumerate(data) if isinstance(data, list) else entries
    for key, value in entries:
        for keys in _too_large(value):
            yield [str(key), *keys]
