"""Refusals: what was refused is compared, not how the error says it."""

import contextlib

import pytest


@contextlib.contextmanager
def refuses(argument):
    """Context that must raise an error in one line about this `argument`, or key of a file."""
    with pytest.raises(ValueError) as error:  # noqa: PT011 by its field
        yield error
    assert (error.value.argument, "\n" in str(error.value)) == (argument, False)
