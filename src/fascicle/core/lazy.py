"""Packages that load their names at first use.

The command line's help needs no laws, laws need no pint: a package says in which module each of its
names is, and imports nothing for it.
"""

import importlib
import sys
from collections.abc import Callable, Mapping
from types import ModuleType


def attach_lazy(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a `package`. `homes`: module of each of its names; "" for a
    name that is a module. `ValueError` for a name that is its module's, too: importing that module
    would replace the object.
    """
    if twins := [name for name, home in homes.items() if name == home]:
        raise ValueError(f"{package}: {', '.join(twins)} can't be in a module of the same name.")

    def get_attribute(name: str) -> object:
        if homes.get(name):
            return getattr(_import(f".{homes[name]}", package), name)
        if name in homes:
            return _import(f".{name}", package)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get_attribute, lambda: sorted({*vars(sys.modules[package]), *homes})


def _import(name: str, package: str) -> ModuleType:
    """A module; `MissingExtraError` where it needs an extra that is not installed."""
    try:
        return importlib.import_module(name, package)
    except ModuleNotFoundError as error:
        from .errors import missing_extra

        raise missing_extra(error) or error from None
