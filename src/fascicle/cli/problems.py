"""A user's mistake, as the command line says it."""

import contextlib
from collections.abc import Iterator


class UserError(Exception):
    """What a command can't do, in one line for whoever typed it."""

    code = 2  # that the command ends with


class StoppedError(UserError):
    """What a command couldn't end, through no fault of whoever typed it."""

    code = 1


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
