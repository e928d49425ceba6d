"""How deep a TOML text goes, found before it is parsed.

The parser makes a table for each part of a key, in time and memory that grow with the square of
the depth: `a.a.a. … = 1` in 64 kB took 40 s and 4 GB. Files of this format go five levels deep.
"""

import re


DEEPEST = 16  # of a key's parts, or of brackets in brackets: three times what any file needs
# strings and comments hold any sign; what is left are keys, numbers, dots and brackets
_TOKEN = re.compile(
    r"""(?P<string> \"{3} (?: [^"\\]++ | \\. | "(?!"") )*+ \"{3}  |  '{3} .*? '{3}
                  | " (?: [^"\\\n]++ | \\. )*+ "  |  ' [^'\n]*+ ')
      | (?P<comment> \#[^\n]*+) | (?P<bare> [A-Za-z0-9_+\-]++) | (?P<dot> \.)
      | (?P<open> [\[{]) | (?P<close> [\]}]) | (?P<space> [ \t]++) | (?P<other> .)""",
    re.VERBOSE | re.DOTALL,
)


def check_depth(text: str, source: str) -> None:
    """Refuse a TOML text whose tables lie too deep in one another to be a file of ours.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: what to call it in an error [-].

    **Raises:** `ValueError`, in one line with the line's number.
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
            what = "a key's parts" if parts > DEEPEST else "brackets in brackets"
            raise ValueError(
                f"{source}: not TOML: nested too deep on line {number}, more than {DEEPEST} {what}."
            )
