"""Warnings of former public names, which `fascicle.former_names` lists."""

import warnings
from typing import Any, TypeVar

from ..former_names import ATTRIBUTES, REMOVAL


_Class = TypeVar("_Class", bound=type)


def warn_renamed(old: str, new: str, verb: str = "is now") -> None:
    """Warn, at the line that uses it, that a name is another one now."""
    message = f"`{old}` {verb} `{new}`. The former name goes with fascicle {REMOVAL}."
    warnings.warn(message, DeprecationWarning, stacklevel=3)


def with_former_names(owner: _Class) -> _Class:
    """Class decorator: former names of attributes and methods, from `ATTRIBUTES`."""
    for old, new in ATTRIBUTES[owner.__name__].items():
        setattr(owner, old, _alias(old, new))
    return owner


def _alias(old: str, new: str) -> property:
    def get_present(self: Any) -> Any:
        warn_renamed(f"{type(self).__name__}.{old}", new)
        return getattr(self, new)

    get_present.__doc__ = f"Former name of `{new}`."
    return property(get_present)
