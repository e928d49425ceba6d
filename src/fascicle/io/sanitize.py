"""Words of strangers as they are shown: nothing in them hides, turns around or runs on."""

import json
import re
from typing import Any


_LONGEST = 400  # characters of a message: what is longer is no message
# control signs save line breaks and tabs; signs of direction and of no width, which make a name
# look like another one; byte order marks, tags, and halves of signs that no file can hold
_HIDDEN = re.compile(
    r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    r"\ufeff\ufff9-\ufffb\U000e0000-\U000e007f\ud800-\udfff]"
)


def escape_invisible(text: str) -> str:
    """A `text` [-] with its hidden signs written as their numbers [-]; line breaks stay."""
    return _HIDDEN.sub(lambda found: _number(found.group()), text)


def sanitize_line(text: str, longest: int = _LONGEST) -> str:
    """A text as one line of which every sign can be seen.

    **Arguments:**

    - `text`: it [-].
    - `longest`: how many of its characters may be left [-]; an ellipsis stands for the middle.

    **Returns:** the line [-].
    """
    if len(text) > longest:
        text = f"{text[: longest // 2]} … {text[-(longest // 3) :]}"
    line = " ".join(escape_invisible(text).split())
    return "".join(sign if sign.isprintable() else _number(sign) for sign in line)


def dump_json(value: Any) -> str:
    """A `value` [any unit] as JSON, in its own letters; hidden signs are escaped [-]."""
    text = json.dumps(value, ensure_ascii=False)
    return _HIDDEN.sub(lambda found: json.dumps(found.group())[1:-1], text)


def _number(sign: str) -> str:
    return sign.encode("unicode_escape", "surrogatepass").decode("ascii")
