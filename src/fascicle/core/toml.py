"""TOML of a stranger, parsed: whatever is wrong with it is one line, with the file's name."""

import re
import tomllib
from collections.abc import Iterator
from typing import Any

from .nesting import check_depth


_LARGEST = 2**63  # TOML's own integers have 64 bits


def tables(text: str, source: str) -> dict[str, Any]:
    """The tables of a TOML text.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: what to call it in an error [-].

    **Returns:** nested tables and lists [-].

    **Raises:** `ValueError`, one line with the place, for what is no TOML, lies too deep, or holds
    a whole number that has no 64 bits.
    """
    check_depth(text, source)
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
    """Keys that lead to numbers beyond TOML's range, which Python's don't have."""
    if isinstance(data, int) and not -_LARGEST <= data < _LARGEST:
        yield []
    entries = data.items() if isinstance(data, dict) else ()
    entries = enumerate(data) if isinstance(data, list) else entries
    for key, value in entries:
        for keys in _too_large(value):
            yield [str(key), *keys]
