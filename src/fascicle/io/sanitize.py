"""Text from outside, made visible: no hidden characters, no changed direction, limited length."""

import json
import re
from typing import Any


_MAX_LENGTH = 400  # characters of a message: some lines of a terminal
# control characters but line breaks and tabs; characters of direction and of no width, which make a
# name look like another one; byte order marks, tags, and halves of characters
_HIDDEN = re.compile(
    r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    r"\ufeff\ufff9-\ufffb\U000e0000-\U000e007f\ud800-\udfff]"
)


def escape_invisible(text: str) -> str:
    """A text with its hidden characters written as their numbers; line breaks stay."""
    return _HIDDEN.sub(lambda match: _escape(match.group()), text)


def sanitize_line(text: str, limit: int = _MAX_LENGTH) -> str:
    """A text as one line of at most `limit` visible characters; an ellipsis replaces the middle."""
    if len(text) > limit:
        text = f"{text[: limit // 2]} … {text[-(limit // 3) :]}"
    line = " ".join(escape_invisible(text).split())
    return "".join(sign if sign.isprintable() else _escape(sign) for sign in line)


def dump_json(value: Any) -> str:
    """JSON of a value, with letters of all languages; hidden characters are escaped."""
    text = json.dumps(value, ensure_ascii=False)
    return _HIDDEN.sub(lambda match: json.dumps(match.group())[1:-1], text)


def _escape(sign: str) -> str:
    return sign.encode("unicode_escape", "surrogatepass").decode("ascii")
