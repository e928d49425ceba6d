"""Laws: the constants that a law declares, and a registry for each kind of law.

A law is a final class with a `name` by which files, options and results know it. Its constants are
declared at its fields. Nothing else lists it: a module in the folder of its kind is all it takes,
or an entry point of the group `fascicle.laws` in another installed package.
"""

import importlib
import pkgutil
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, TypeVar

import attrs

from ..core.errors import InvalidInputError
from ..core.module import Module
from ..core.parameters import Constant, Switch
from ..core.validation import check_choice


if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

ENTRY_POINTS = "fascicle.laws"  # group of other packages' laws: name of the law = its class


class Declared(Module):
    """A module that declares its constants and switches at its fields."""

    @classmethod
    def constants(cls) -> tuple[Constant, ...]:
        """Numbers of the law, in the order of its arguments."""
        return tuple(x.metadata["constant"] for x in attrs.fields(cls) if "constant" in x.metadata)

    @classmethod
    def switches(cls) -> tuple[Switch, ...]:
        """Options of the law that are chosen by name."""
        return tuple(x.metadata["switch"] for x in attrs.fields(cls) if "switch" in x.metadata)


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

    Modules of the kind's folder are imported at the first use of a law, other packages when their
    law is asked for by name. Listing imports all, and warns of packages that fail.
    """

    def __init__(self, kind: type[Law], default: str) -> None:
        """Laws of the package of a `kind`, their base class; `default`: name of a new muscle's."""
        self._kind, self._default, self._package = kind, default, kind.__module__
        self._argument = self._package.rpartition(".")[2]  # the folder has the kind's name

    @cached_property
    def shipped(self) -> Mapping[str, type[Law]]:
        """Laws of fascicle itself, in the same order: no other package is imported."""
        package = sys.modules[self._package]
        files = pkgutil.iter_modules(package.__path__, f"{self._package}.")
        modules = [package, *(importlib.import_module(file.name) for file in files)]
        classes = [value for module in modules for value in vars(module).values()]
        laws = {law.name: law for law in classes if _is_law(law, self._kind)}
        return MappingProxyType({name: laws[name] for name in self._in_order(laws)})

    @cached_property
    def _installed(self) -> Mapping[str, type[Law]]:
        """Laws of this kind of other packages; a warning for each that can't be used."""
        laws = {}
        for point in _entry_points():
            try:
                law = _load(point)
                if point.name in self.shipped and issubclass(law, self._kind):
                    rule = f"of the package {_package_of(point)} is a law of fascicle"
                    raise InvalidInputError(point.name, rule, None, "rename it")
            except InvalidInputError as error:
                warnings.warn(f"law left out: {error}", stacklevel=4)
                continue
            if issubclass(law, self._kind):
                laws[point.name] = law
        return laws

    def __getitem__(self, name: str) -> type[Law]:
        if name in self.shipped:
            return self.shipped[name]
        for law in map(_load, _entry_points(name=name)):
            if issubclass(law, self._kind):
                return law
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._in_order({*self.shipped, *self._installed}))

    def __len__(self) -> int:
        return len({*self.shipped, *self._installed})

    @property
    def default(self) -> type[Law]:
        """Law of a muscle for which none is chosen."""
        return self[self._default]

    def package_attributes(self) -> tuple[Callable[[str], type[Law]], Callable[[], list[str]]]:
        """The package's `__getattr__`, for its laws' classes, and `__dir__`, which lists them."""

        def get_class(class_name: str) -> type[Law]:
            """Class of a shipped law by its Python name: the package's `__getattr__`."""
            if not class_name.startswith("_"):
                for law in self.shipped.values():
                    if law.__name__ == class_name:
                        return law
            raise AttributeError(f"module {self._package!r} has no attribute {class_name!r}")

        def list_attributes() -> list[str]:
            classes = {law.__name__ for law in self.shipped.values()}
            return sorted({*vars(sys.modules[self._package]), *classes})

        return get_class, list_attributes

    def choose(self, value: Law | str) -> Law:
        """Law from an object or a name; `InvalidInputError` for other values."""
        if isinstance(value, self._kind):
            return value
        if isinstance(value, str):
            if value not in self:
                check_choice(value, self, self._argument)
            return self[value]()
        rule = f"must be one of {', '.join(sorted(self))} or an object of {self._kind.__name__}"
        raise InvalidInputError(self._argument, rule, value)

    def _in_order(self, names: Iterable[str]) -> list[str]:
        return sorted(names, key=lambda name: (name != self._default, name))


def package_of(law: type[AbstractLaw]) -> str:
    """Name of the installed package whose entry point has a `law`; "fascicle" for its own."""
    if law.__module__.startswith("fascicle."):
        return "fascicle"
    points = _entry_points(name=law.name)
    return _package_of(points[0]) if points else law.__module__.partition(".")[0]


def _is_law(value: object, kind: type[AbstractLaw]) -> bool:
    return isinstance(value, type) and issubclass(value, kind) and hasattr(value, "name")


def _load(point: "EntryPoint") -> type[AbstractLaw]:
    """Law of another package; `InvalidInputError` if it can't be imported or is something else."""
    label, remedy = f"{point.name!r} of the package {_package_of(point)}", "repair or uninstall it"
    try:
        law = point.load()
    except Exception as error:  # another package's module may raise anything
        cause = f"{type(error).__name__}: {error}".rstrip(".")
        raise InvalidInputError(label, f"can't be imported ({cause})", None, remedy) from error
    if not _is_law(law, AbstractLaw) or law.name != point.name:
        rule = "must be a subclass of an abstract law, with the name of its entry point"
        raise InvalidInputError(label, rule, None, remedy)
    return law


def _entry_points(name: str | None = None) -> list["EntryPoint"]:
    from importlib import metadata  # takes longer to import than a law

    points = metadata.entry_points(group=ENTRY_POINTS)
    return list(points if name is None else points.select(name=name))


def _package_of(point: "EntryPoint") -> str:
    return point.dist.name if point.dist is not None else point.module
