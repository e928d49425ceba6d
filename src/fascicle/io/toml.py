"""TOML text from a user: every error is one line that names the file."""

import re
import tomllib
from collections.abc import Iterator
from typing import Any


DEEPEST = 64  # parts of a key; files of this format have five
# tomllib takes time and memory that grow with the square of a key's parts: 64 kB took 40 s and 4 GB
_DEEP_KEY = re.compile(
    rf"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{DEEPEST}}}""", re.ASCII
)
_INTEGER_LIMIT = 2**63  # integers of TOML have 64 bits


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
