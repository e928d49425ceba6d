"""Libraries that an optional extra brings, asked for where they are needed."""

from importlib.util import find_spec


class MissingExtraError(ImportError):
    """A library that isn't installed, and the command that installs it."""


def require(library: str, extra: str, purpose: str) -> None:
    """Refuse, in one line, where a library is not installed.

    **Arguments:**

    - `library`: what it is imported as [-].
    - `extra`: the extra of fascicle that brings it [-].
    - `purpose`: what needs it, such as "a figure" [-].

    **Raises:** `MissingExtraError` with the command that installs it.
    """
    if find_spec(library) is None:
        raise MissingExtraError(
            f"{purpose} needs {library}, which is not installed: pip install 'fascicle[{extra}]'",
            name=library,
        )
