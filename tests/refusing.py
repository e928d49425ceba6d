"""Refusals: what was refused is compared, not how the error says it."""

import contextlib

import pytest


@contextlib.contextmanager
def refuses(argument):
    """Context that must raise an error in one line about this `argument`, or key of a file."""
    with pytest.raises(ValueError) as error:  # noqa: PT011 by its field
        yield error
    assert (error.value.argument, "\n" in str(error.value)) == (argument, False)


@contextlib.contextmanager
def refuses_at(place):
    """Context that must raise an error in one line about this `place`: a file, or a line of it."""
    with pytest.raises((ValueError, OSError)) as error:
        yield error
    message = str(error.value)
    assert (message[: len(place)], message.count("\n")) == (place, 0)


@contextlib.contextmanager
def warns(*facts):
    """Context that must warn in a line with these `facts`: names, numbers, values with units."""
    with pytest.warns(UserWarning) as caught:  # noqa: PT030 by its facts
        yield caught
    assert any(all(fact in str(x.message) for fact in facts) for x in caught)
