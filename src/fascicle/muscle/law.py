"""What every law tells about itself, and how the laws of a folder are found.

A law is a final class in a module of its own, in the folder of its kind, with a `name` by which
files, options and results know it. Its constants are declared at its fields. Nothing else lists
it: the folder is looked through once, when it is imported.
"""

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.parameters import Constant, Switch


class Declared(Module):
    """What declares its constants at its fields."""

    @classmethod
    def constants(cls) -> tuple[Constant, ...]:
        """Its own numbers [-], in the order of its arguments."""
        return _told(cls, "constant")

    @classmethod
    def switches(cls) -> tuple[Switch, ...]:
        """What of it is chosen by name [-]."""
        return _told(cls, "switch")


class AbstractLaw(Declared):
    """A law with alternatives.

    `name`: by which it is chosen. `title`: as tables write it, if not so. `source`: author and
    year, where it was published.
    """

    name: ClassVar[str]
    title: ClassVar[str] = ""
    source: ClassVar[str] = ""


Law = TypeVar("Law", bound=AbstractLaw)


def found(
    package: str, path: Iterable[str], kind: type[Law], first: str
) -> Mapping[str, type[Law]]:
    """The laws of a folder.

    **Arguments:**

    - `package`, `path`: its name and place, as the folder's own module knows them [-].
    - `kind`: of law [-].
    - `first`: name of the one that is taken where none is chosen [-].

    **Returns:** the classes by name, the first one ahead, the others by the alphabet [-].

    **Raises:** `ValueError` where two have one name.
    """
    laws: dict[str, type[Law]] = {}
    for module in sorted(one.name for one in pkgutil.iter_modules(path)):
        for law in vars(importlib.import_module(f"{package}.{module}")).values():
            if not _is_one(law, kind, f"{package}.{module}"):
                continue
            if law.name in laws:
                raise InvalidInputError(
                    law.name, f"names two laws of {package}", None, "rename one"
                )
            laws[law.name] = law
    return MappingProxyType(
        {name: laws[name] for name in sorted(laws, key=lambda n: (n != first, n))}
    )


def by_class(package: str, laws: Mapping[str, type[Law]], name: str) -> type[Law]:
    """The class of a folder's `laws` [-] that is called `name` [-] in Python; `AttributeError` of
    the `package` [-] for none.
    """
    for law in laws.values():
        if law.__name__ == name:
            return law
    raise AttributeError(f"module {package!r} has no attribute {name!r}")


def _is_one(thing: Any, kind: type, module: str) -> bool:
    """Whether it is a final law of a kind, written in this module."""
    ours = isinstance(thing, type) and issubclass(thing, kind) and thing.__module__ == module
    return ours and isinstance(getattr(thing, "name", None), str)


def _told(law: Any, key: str) -> tuple:
    return tuple(one.metadata[key] for one in fields(law) if key in one.metadata)
