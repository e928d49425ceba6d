"""TOML text from a user: every error is one line that names the file.

The parser makes a table for each part of a key, in time and memory that grow with the square of
the depth: `a.a.a. … = 1` in 64 kB took 40 s and 4 GB. So the depth is checked before parsing;
files of this format go five levels deep.
"""

import re
import tomllib
from collections.abc import Iterator
from typing import Any


DEEPEST = 16  # of a key's parts, or of brackets in brackets: three times what any file needs
# strings and comments hold any character; the rest is keys, numbers, dots and brackets
_TOKEN = re.compile(
    r"""(?P<string> \"{3} (?: [^"\\]++ | \\. | "(?!"") )*+ \"{3}  |  '{3} .*? '{3}
                  | " (?: [^"\\\n]++ | \\. )*+ "  |  ' [^'\n]*+ ')
      | (?P<comment> \#[^\n]*+) | (?P<bare> [A-Za-z0-9_+\-]++) | (?P<dot> \.)
      | (?P<open> [\[{]) | (?P<close> [\]}]) | (?P<space> [ \t]++) | (?P<other> .)""",
    re.VERBOSE | re.DOTALL,
)


def check_nesting_depth(text: str, source: str) -> None:
    """Raise `ValueError`, one line with the name `source` and the line's number, for a TOML text
    with deeper tables than any file of fascicle.
    """
    parts, after_dot, brackets = 0, False, 0
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        if kind in ("string", "bare"):
            parts = parts + 1 if after_dot else 1
            after_dot = False
        elif kind == "dot":
            after_dot = True
        elif kind != "space":
            parts, after_dot = 0, False
            brackets = max(brackets + (kind == "open") - (kind == "close"), 0)
        if parts > DEEPEST or brackets > DEEPEST:
            number = text.count("\n", 0, token.start()) + 1
            nested = "a key's parts" if parts > DEEPEST else "brackets in brackets"
            rule = f"nested too deep on line {number}, more than {DEEPEST} {nested}."
            raise ValueError(f"{source}: not TOML: {rule}")


_INTEGER_LIMIT = 2**63  # integers of TOML have 64 bits


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Tables of a TOML text; `ValueError`, one line with the name `source` and the position, for a
    text that is no TOML, is nested too deep, or holds a whole number beyond 64 bits.
    """
    check_nesting_depth(text, source)
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
