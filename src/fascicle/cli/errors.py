"""Errors of the command line: a user's mistakes, and the message and exit code of any other."""

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


INCOMPLETE = 3  # exit code of a command that gave what it could, and that was not all
_BUG = 70  # as sysexits has it


class UserError(Exception):
    """A user's mistake, in one line."""

    code = 2  # exit code of the command


class StoppedError(UserError):
    """A command that was stopped from outside, in one line."""

    code = 1


def exit_incomplete(message: str) -> NoReturn:
    """End a command that gave what it could; `message`: what it could not, in one line."""
    sys.stdout.flush()  # in this order, also where both go to one place
    sys.stderr.write(f"{sanitize_line(message, 2000)}\n")
    raise typer.Exit(INCOMPLETE)


@contextlib.contextmanager
def user_errors(prefix: str = "") -> Iterator[None]:
    """Turn the library's errors into the command line's.

    **Arguments:** `prefix`: what the value belongs to, such as an option's name.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except (ValueError, OSError) as error:
        raise UserError(f"{prefix}{error}") from error


def exit_code_and_message(error: Exception) -> tuple[int, str]:
    """Exit code of a command that ended with `error`, and its message in one line.

    **Returns:** no message for Ctrl-C and a closed pipe, such as that of `| head`.

    **Raises:** `error`, where `FASCICLE_TRACEBACK` asks for a bug's traceback.
    """
    code, message = 2, ""
    if isinstance(error, UserError):
        code, message = error.code, str(error)
    elif isinstance(error, typer.Abort):
        code = 128 + signal.SIGINT
    elif isinstance(error, BrokenPipeError):
        code = 1
    elif isinstance(error, OSError):
        message = f"standard output: can't be written: {error.strerror or error}."
    elif isinstance(error, MissingExtraError):
        message = str(error)
    else:
        message = str(missing_extra(error) or "")
        message = message or _usage_message(error) or _resource_message(error)
        if not message:
            if os.environ.get("FASCICLE_TRACEBACK", "") not in ("", "0"):
                raise error
            code = _BUG
            message = (
                f"{type(error).__name__}: {error}. That is a bug in fascicle, please report it; set"
                " FASCICLE_TRACEBACK=1 to see where."
            )
    return code, message


def _usage_message(error: Exception) -> str:
    """Message of an error of typer's, such as an unknown option; empty for any other."""
    # by its method: the class has moved between typer's versions
    format_message = getattr(error, "format_message", None)
    if format_message is None:
        return ""
    command = getattr(getattr(error, "ctx", None), "command_path", None) or "fascicle"
    causes = getattr(error.__cause__, "errors", list)()  # pydantic's, of a value out of range
    got = f", got {causes[0]['input']}" if causes else ""
    return f"{format_message().rstrip('.?')}{got}. Try '{command} --help'."


def _resource_message(error: Exception) -> str:
    """Message where memory or a device is missing; empty for any other error."""
    platforms = os.environ.get("JAX_PLATFORMS", "")
    if platforms not in ("", "cpu") and (jax := sys.modules.get("jax")):
        try:
            jax.devices()
        except Exception:  # noqa: BLE001 of another kind for each platform
            return f"JAX_PLATFORMS={platforms}: JAX finds no such device; unset it, or write cpu."
    text = str(error)
    if not isinstance(error, MemoryError) and "RESOURCE_EXHAUSTED" not in text:  # XLA's word
        return ""
    size = re.search(r"allocat\w+ ([\d.]+ ?\w+)", text)
    need = f", {size[1]} at once" if size else ""
    return f"this needs more memory than there is{need}: take fewer motor units, muscles or points."
