"""Words of strangers as they are shown: nothing in them hides, turns around or runs on."""

_LONGEST = 400  # characters of a message: what is longer is no message


def visible(text: str, longest: int = _LONGEST) -> str:
    """A text of which every sign can be seen.

    Control and direction signs, which can make a name look like another one, are written as their
    number; line breaks and tabs are spaces.

    **Arguments:**

    - `text`: it [-].
    - `longest`: how many characters may be left [-]; what is cut out of the middle is an ellipsis.

    **Returns:** the text [-].
    """
    head = text if len(text) <= longest else f"{text[: longest // 2]} … {text[-(longest // 3) :]}"
    return "".join(
        sign if sign.isprintable() else " " if sign in "\n\r\t" else _number(sign) for sign in head
    )


def _number(sign: str) -> str:
    return sign.encode("unicode_escape", "surrogatepass").decode("ascii")
