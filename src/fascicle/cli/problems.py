"""A user's mistake, as the command line says it."""

import contextlib
import re
import sys
from collections.abc import Iterator
from typing import NoReturn

import typer


class UserError(Exception):
    """What a command can't do, in one line for whoever typed it."""

    code = 2  # that the command ends with


class StoppedError(UserError):
    """What a command couldn't end, through no fault of whoever typed it."""

    code = 1


INCOMPLETE = 3  # what a command ends with that gave what it could, and that wasn't all


def fall_short(told: str) -> NoReturn:
    """End a command that gave what it could, and say what it couldn't; `told`: one line [-]."""
    sys.stdout.flush()  # in this order, also where both go to one place
    sys.stderr.write(f"{told}\n")
    raise typer.Exit(INCOMPLETE)


@contextlib.contextmanager
def refusing(prefix: str = "") -> Iterator[None]:
    """Turn the library's refusals into the command line's.

    **Arguments:** `prefix`: what the value belongs to [-], such as an option's name.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except (ValueError, OSError) as error:
        raise UserError(f"{prefix}{error}") from error


def too_large(error: Exception) -> str:
    """What to say where memory didn't suffice; empty for any other `error` [-]."""
    text = str(error)
    if not isinstance(error, MemoryError) and "RESOURCE_EXHAUSTED" not in text:
        return ""
    # NumPy's words, and XLA's
    asked = re.search(r"allocat\w+ ([\d.]+ ?[KMGTPE]?i?B|\d+)", text)
    need = ""
    if asked:
        size = asked[1] if asked[1][-1] == "B" else f"{int(asked[1]) / 1e9:.3g} GB"
        need = f", {size} at once"
    return f"this needs more memory than there is{need}: take fewer motor units, muscles or points."
