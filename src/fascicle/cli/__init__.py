"""The command line: parse, call, print."""

import atexit
import contextlib
import io
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any


_INTERRUPTED = 128 + signal.SIGINT  # as shells have it
_MAX_LINE = 600  # characters of a message

# a Ctrl-C while Python shuts down has nothing left to stop: all is done and printed by then
atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit.

    With 0 if it did what was asked; 1 if a claim failed, or something from outside ended it; 2 for
    a user's mistake; 3 if not all of what was asked for can be reached; 70 for a bug; 130 for
    Ctrl-C.

    **Arguments:** `arguments`: those of the command line; default: the process's own.
    """
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    _open_streams()
    warnings.showwarning = _warning_printer()
    with _quiet_interrupts():
        try:
            code, message = _run(words)
        except KeyboardInterrupt:
            code, message = _INTERRUPTED, ""
    if message:
        _print_error(f"error: {message}")
    sys.exit(code)


def _run(words: list[str]) -> tuple[int, str]:
    """Exit code of a command, and an error message."""
    try:
        # by name, since commands import this package
        commands = import_module("fascicle.cli.commands")
        result = commands.app(words, prog_name="fascicle", standalone_mode=False)
        sys.stdout.flush()
    except Exception as error:  # noqa: BLE001 a bug of whatever kind is one line
        if isinstance(error, OSError):  # of standard output: commands turn all others into theirs
            _discard_output()
        from .errors import exit_code_and_message

        return exit_code_and_message(error)
    return result if isinstance(result, int) else 0, ""


def _open_streams() -> None:
    """Replace closed streams, whose numbers the next files would get; let any terminal print."""
    # standard output opens for reading: what is printed there is lost, and that is an error
    for name, mode in (("stdin", "r"), ("stdout", "r"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: PTH123, SIM115 open until the process ends
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # an ASCII terminal still gets its numbers


@contextlib.contextmanager
def _quiet_interrupts() -> Iterator[None]:
    """Exit at a Ctrl-C that falls into a callback, where Python would print and go on."""
    before = sys.unraisablehook

    def hook(unraisable: Any) -> None:
        if unraisable.exc_type is KeyboardInterrupt:
            os._exit(_INTERRUPTED)
        before(unraisable)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _warning_printer() -> Any:
    """Print each of a command's warnings once, in one line."""
    printed: set[str] = set()

    def print_warning(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in printed:
            printed.add(str(message))
            _print_error(f"warning: {message}")

    return print_warning


def _print_error(line: str) -> None:
    from ..io.sanitize import sanitize_line

    with contextlib.suppress(OSError):
        print(sanitize_line(line, _MAX_LINE), file=sys.stderr)


def _discard_output() -> None:
    """Let the interpreter's own last flush go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
