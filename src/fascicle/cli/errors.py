"""Errors of the command line: a user's mistakes, and message and exit code of any error."""

import contextlib
import os
import re
import signal
import sys
from collections.abc import Iterator
from typing import NoReturn

import typer

from ..core.errors import MissingExtraError, missing_extra
from ..io.sanitize import sanitize_line


INCOMPLETE = 3  # exit code of a command that could give only part of its result
_BUG = 70  # EX_SOFTWARE of sysexits.h
_MAX_MESSAGE = 2000  # characters: lists of rows are long


class UserError(Exception):
    """A user's mistake, in one line."""

    def __init__(self, message: str, code: int = 2):
        super().__init__(message)
        self.code = code  # exit code of the command


def exit_incomplete(message: str) -> NoReturn:
    """End a command whose result is incomplete; `message`: what is missing, in one line."""
    sys.stdout.flush()  # keeps the order if both streams go to one file
    sys.stderr.write(f"{sanitize_line(message, _MAX_MESSAGE)}\n")
    raise typer.Exit(INCOMPLETE)


@contextlib.contextmanager
def user_errors(prefix: str = "") -> Iterator[None]:
    """Turn the library's errors into those of the command line; `prefix`: such as an option."""
    try:
        yield
    except BrokenPipeError:
        raise
    except (ValueError, OSError) as error:
        raise UserError(f"{prefix}{error}") from error


def exit_code_and_message(error: Exception) -> tuple[int, str]:
    """Exit code of a command that ended with `error`, and its message in one line, empty for Ctrl-C
    and a closed pipe; raises the error if it is a bug and `FASCICLE_TRACEBACK` is set.
    """
    if isinstance(error, UserError):
        return error.code, _resource_message(error) or str(error)
    if isinstance(error, typer.Abort):
        return 128 + signal.SIGINT, ""
    if isinstance(error, BrokenPipeError):
        return 1, ""
    if isinstance(error, OSError):  # commands turn all others into UserError
        return 1, f"standard output: can't be written: {error.strerror or error}."
    missing = error if isinstance(error, MissingExtraError) else missing_extra(error)
    if message := str(missing or "") or _usage_message(error) or _resource_message(error):
        return 2, message
    if os.environ.get("FASCICLE_TRACEBACK", "") not in ("", "0"):
        raise error
    return _BUG, (
        f"{type(error).__name__}: {error}. This is a bug in fascicle, please report it; set"
        " FASCICLE_TRACEBACK=1 to see the traceback."
    )


def _usage_message(error: Exception) -> str:
    """Message of typer's error, such as an unknown option; empty for any other."""
    # by its method: the class has moved between typer's versions
    format_message = getattr(error, "format_message", None)
    if format_message is None:
        return ""
    command = getattr(getattr(error, "ctx", None), "command_path", None) or "fascicle"
    causes = getattr(error.__cause__, "errors", list)()  # pydantic's, of a value out of range
    value = f", got {causes[0]['input']}" if causes else ""
    return f"{format_message().rstrip('.?')}{value}. Try '{command} --help'."


def _resource_message(error: Exception) -> str:
    """Message if memory, matplotlib's or JAX's device is missing; empty for any other error."""
    text, platforms = str(error), os.environ.get("JAX_PLATFORMS", "")
    if (figures := os.environ.get("MPLBACKEND", "")) and f"{figures!r} is not a valid" in text:
        return f"MPLBACKEND={figures}: matplotlib has no such backend; unset it, or write agg."
    # JAX's words on a platform that it doesn't find, or none
    if platforms and ("backend" in text or (isinstance(error, AssertionError) and not text)):
        return f"JAX_PLATFORMS={platforms}: JAX finds no such device; unset it, or write cpu."
    if not isinstance(error, MemoryError) and "RESOURCE_EXHAUSTED" not in text:  # XLA's status
        return ""
    size = re.search(r"allocat\w+ ([\d.]+ ?\w+)", text)
    need = f", {size[1]} at once" if size else ""
    return f"this needs more memory than there is{need}: take fewer motor units, muscles or points."
