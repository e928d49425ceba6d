"""A user's mistake, as the command line says it."""

import contextlib
import re
import sys
from collections.abc import Iterator, Mapping
from typing import NoReturn

import typer

from ..core.errors import InvalidInputError
from ..io.sanitize import sanitize_line


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
    sys.stderr.write(f"{sanitize_line(told, 2000)}\n")
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


def as_typed(error: Exception, options: Mapping[str, str]) -> str:
    """A refusal in the words that were typed: options rather than Python's arguments.

    **Arguments:**

    - `error`: what a command ended with [-].
    - `options`: of the command, by the argument's name [-].

    **Returns:** the line [-].
    """
    text, cause = str(error), error.__cause__
    if not isinstance(cause, InvalidInputError):
        return text
    options = {**options, **{more: options[one] for more, one in _SAME.items() if one in options}}
    if cause.argument == "supply_pressure" and cause.value is None and "supply" in options:
        return f"{options['supply']}: missing, {cause.remedy}: give one, such as --supply 400kPa."

    def option(found: re.Match[str]) -> str:
        return options.get(found[1], found[0])

    # what is told in both tongues, in this one
    text = re.sub(r"\w+=\S+ \((--[^)]+)\)", r"\1", text)
    return re.sub(r"`(\w+)`", option, text)


# what typer asks of a number, as it is called there
_RULES = {
    "less_than_equal": "must be at most {le}",
    "greater_than_equal": "must be at least {ge}",
    "int_parsing": "must be a whole number",
    "float_parsing": "must be a number",
}


def wrong_usage(error: Exception) -> str:
    """What to say where typer can't read a command [-]: a wrong option, a missing one; empty for
    any other `error` [-].
    """
    # by what it can do: its class has moved between typer's versions
    told = getattr(error, "format_message", None)
    if told is None:
        return ""
    command = getattr(getattr(error, "ctx", None), "command_path", None) or "fascicle"
    text, names = told(), getattr(getattr(error, "param", None), "opts", [])
    found = next(iter(getattr(error.__cause__, "errors", list)()), {})
    if found.get("type") in _RULES and names:
        rule = _RULES[found["type"]].format(**found.get("ctx", {}))
        text = f"{max(names, key=len)} {rule}, got {found['input']}."
    return f"{text} Try '{command} --help'."


# arguments of the library, and those of commands that fill them
_SAME = {
    "supply_pressure": "supply",
    "pressures": "pressure",
    "states": "pressure",
    "strains": "strain",
    "forces": "force",
    "names": "fit",
    "units": "unit",
    "columns": "column",
}


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
