"""What a long command is at, on a terminal's standard error."""

import contextlib
import sys
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def telling(first: str) -> Iterator[Callable[[str], None]]:
    """Show what is being done while the work inside is done, where somebody watches.

    **Arguments:** `first`: what that is to begin with [-].

    **Returns:** what is to be told the next [-].
    """
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console

    with Console(file=sys.stderr).status(first) as status:
        yield status.update
