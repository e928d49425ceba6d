"""What a long command is at and for how long, on a terminal's standard error."""

import contextlib
import sys
from collections.abc import Callable, Iterator

from ..io.sanitize import sanitize_line


_told: list[Callable[[str], None]] = []  # what is shown now, if anything


@contextlib.contextmanager
def telling(first: str) -> Iterator[Callable[[str], None]]:
    """Show what is being done, and for how long, while the work inside is done, where somebody
    watches; nothing where the stream goes elsewhere.

    **Arguments:** `first`: what that is to begin with [-].

    **Returns:** what is to be told the next [-].
    """
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    if _told:  # inside of another one: one line tells of both
        _told[-1](first)
        yield _told[-1]
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    console = Console(file=sys.stderr, markup=False)
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(sanitize_line(first), total=None)
        _told.append(lambda what: bar.update(task, description=sanitize_line(what)))
        try:
            yield _told[-1]
        finally:
            _told.pop()
