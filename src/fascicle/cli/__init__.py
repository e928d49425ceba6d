"""The command line: parse, call, print. A module for each family of commands."""

import atexit
import contextlib
import io
import os
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    import typer

_FAMILIES = ("muscle", "bundle", "simulate", "record", "explore", "export", "design")
_INTERRUPTED = 128 + signal.SIGINT  # exit code of an interrupted process, as in shells
_MAX_MESSAGE = 600  # characters: some eight lines of a terminal

# when Python shuts down everything is printed: a Ctrl-C has nothing to stop
atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command by the words of its command line, by default those of the process, and exit.

    Exit codes: 0 success; 1 a failed claim or balance, or an end from outside; 2 a user's mistake;
    3 an incomplete result; 70 a bug; 130 Ctrl-C.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # an ASCII terminal still gets its numbers
    warnings.showwarning = _warning_printer()
    try:
        code, message = _run_command(arguments)
    except KeyboardInterrupt:
        code, message = _INTERRUPTED, ""
    if message:
        _print_error(f"error: {message}")
    sys.exit(code)


def make_app() -> "typer.Typer":
    """Application with all commands, which import the laws only when they run: `--help` and the
    shell's completion answer at once.
    """
    import typer

    from .options import Command

    app = typer.Typer(
        name="fascicle",
        help="Model, calibrate and design fluidic artificial (McKibben) muscles and their bundles.",
        rich_markup_mode=None,  # plain help: rich would take longer to import than everything else
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    version = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Version number."
    )

    @app.callback()
    def _(_: bool = version) -> None:
        pass

    for family in _FAMILIES:
        module = import_module(f".{family}", __name__)  # by name: families import this package
        classes = getattr(module, "COMMAND_CLASSES", {})
        for name, run in module.COMMANDS.items():
            app.command(name, cls=classes.get(name, Command))(run)
    return app


def _print_version(value: bool) -> None:
    if value:
        import typer

        from fascicle import __version__

        typer.echo(f"fascicle {__version__}")
        raise typer.Exit


def _run_command(arguments: list[str]) -> tuple[int, str]:
    """Run the command line `arguments`; exit code, and one line for any error."""
    try:
        code = make_app()(arguments, prog_name="fascicle", standalone_mode=False)
        sys.stdout.flush()
    except Exception as error:  # noqa: BLE001 any bug is reported in one line
        from .errors import exit_code_and_message

        if isinstance(error, OSError):  # standard output is lost: Python's last flush must not fail
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return exit_code_and_message(error)
    return code if isinstance(code, int) else 0, ""


def _warning_printer() -> Callable[..., None]:
    """Printer of each warning once, in one line."""
    printed: set[str] = set()

    def print_warning(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in printed:
            printed.add(str(message))
            _print_error(f"warning: {message}")

    return print_warning


def _print_error(line: str) -> None:
    from ..io.sanitize import sanitize_line

    with contextlib.suppress(OSError):
        print(sanitize_line(line, _MAX_MESSAGE), file=sys.stderr)
