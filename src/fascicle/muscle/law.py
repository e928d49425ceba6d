"""Laws: the constants that a law declares, and a registry for each kind of law.

A law is a final class with a `name` by which files, options and results know it. Its constants are
declared at its fields. Nothing else lists it: a module in the folder of its kind is all it takes.
"""

import importlib
import pkgutil
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields
from types import ModuleType
from typing import Any, ClassVar, TypeVar

from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.parameters import Constant, Switch
from ..core.validation import check_choice


class Declared(Module):
    """A module that declares its constants at its fields."""

    @classmethod
    def constants(cls) -> tuple[Constant, ...]:
        """Numbers of the law, in the order of its arguments."""
        return tuple(x.metadata["constant"] for x in fields(cls) if "constant" in x.metadata)

    @classmethod
    def switches(cls) -> tuple[Switch, ...]:
        """Options of the law that are chosen by name."""
        return tuple(x.metadata["switch"] for x in fields(cls) if "switch" in x.metadata)


class AbstractLaw(Declared):
    """A law with alternatives.

    `name`: of the law in files and options. `title`: name in tables, default: `name`. `source`:
    author and year of its publication.
    """

    name: ClassVar[str]
    title: ClassVar[str] = ""
    source: ClassVar[str] = ""


Law = TypeVar("Law", bound=AbstractLaw)


class LawRegistry(Mapping[str, type[Law]]):
    """Laws of one kind by name: the default law, then the others in alphabetical order.

    A law's module is imported at its first use: the module of its name, else all of the folder.
    """

    def __init__(self, package: str, path: Iterable[str], kind: type[Law], default: str) -> None:
        """`package`, `path`: name and path of the folder. `kind`: base class of the laws, whose
        module may have laws, too. `default`: name of a new muscle's law.
        """
        self._package, self._path, self._kind, self._default = package, path, kind, default
        self._laws: dict[str, type[Law]] = {}
        self._add(importlib.import_module(kind.__module__))
        self._complete = False

    def __getitem__(self, name: str) -> type[Law]:
        if name not in self._laws:
            if isinstance(name, str) and name in self._modules():
                self._add(importlib.import_module(f"{self._package}.{name}"))
            if name not in self._laws:
                self._load_all()
        return self._laws[name]

    def __iter__(self) -> Iterator[str]:
        self._load_all()
        return iter(sorted(self._laws, key=lambda name: (name != self._default, name)))

    def __len__(self) -> int:
        self._load_all()
        return len(self._laws)

    @property
    def default(self) -> type[Law]:
        """Law of a muscle for which none is chosen."""
        return self[self._default]

    def package_attributes(self) -> tuple[Callable[[str], type[Law]], Callable[[], list[str]]]:
        """The package's `__getattr__`, for its laws' classes, and `__dir__`, which lists them."""

        def get_class(class_name: str) -> type[Law]:
            if not class_name.startswith("_"):
                # laws that are loaded first: others need their modules
                for law in [*self._laws.values(), *self.values()]:
                    if law.__name__ == class_name:
                        return law
            raise AttributeError(f"module {self._package!r} has no attribute {class_name!r}")

        def list_attributes() -> list[str]:
            """The package's own names and the classes of all laws."""
            classes = {law.__name__ for law in self.values()}
            return sorted({*vars(sys.modules[self._package]), *classes})

        return get_class, list_attributes

    def choose(self, value: Any, argument: str) -> Law:
        """Law from an object or a name; `InvalidInputError` of the `argument` for other values."""
        if isinstance(value, self._kind):
            return value
        if isinstance(value, str):
            if value not in self:
                check_choice(value, self, argument)
            return self[value]()
        rule = f"must be one of {', '.join(sorted(self))} or an object of {self._kind.__name__}"
        raise InvalidInputError(argument, rule, value)

    def _modules(self) -> list[str]:
        return sorted(module.name for module in pkgutil.iter_modules(self._path))

    def _load_all(self) -> None:
        if not self._complete:
            for name in self._modules():
                self._add(importlib.import_module(f"{self._package}.{name}"))
            self._complete = True

    def _add(self, module: ModuleType) -> None:
        """Add the final laws that are written in a module."""
        for law in vars(module).values():
            if not (isinstance(law, type) and issubclass(law, self._kind)):
                continue
            name = getattr(law, "name", None)
            if law.__module__ != module.__name__ or not isinstance(name, str):
                continue
            if self._laws.setdefault(name, law) is not law:
                rule = f"names two laws of {self._package}"
                raise InvalidInputError(name, rule, None, "rename one of them")
