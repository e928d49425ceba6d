"""The command line: parse, call, print."""

from collections.abc import Sequence

from .interrupts import at_once


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit, as `app.main` does; here, so that Ctrl-C is heard before that.

    **Arguments:** `arguments`: those of the command line [-]; left out, the process's own.
    """
    with at_once():
        from .app import main as run

    run(arguments)
