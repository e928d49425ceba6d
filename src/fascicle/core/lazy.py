"""Packages whose names load what they need when they are first used; and names that moved.

The command line's help needs no JAX, laws need no pint: a package says where each of its names
is at home, and imports nothing for it. A module that went elsewhere is found under its old name,
by `import` and as an attribute, and warns with the new one until a later version drops it.
"""

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any


_WENT: dict[str, str] = {}
_LENT: dict[str, str] = {}  # names that a package has from one of its modules


def attach_lazy(
    package: str, homes: Mapping[str, str], went: Mapping[str, str] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    **Arguments:**

    - `package`: its name [-].
    - `homes`: its names, and in which of its modules each is; for a module itself "" [-].
    - `went`: modules that it had, and where they are now in fascicle [-].

    **Returns:** the two functions [-].
    """
    old = {f"{package}.{name}": f"fascicle.{new}" for name, new in (went or {}).items()}
    _WENT.update(old)
    _LENT.update({f"{package}.{n}": f"{package}.{homes[n]}.{n}" for n in homes if homes[n]})
    if not any(isinstance(finder, _Lent) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Lent())  # first: others would load a lent package's modules twice
    if old and not any(isinstance(finder, _Successors) for finder in sys.meta_path):
        sys.meta_path.append(_Successors())

    def found(name: str) -> Any:
        if homes.get(name):
            return getattr(_imported(f".{homes[name]}", package), name)
        if name in homes or f"{package}.{name}" in old:
            return _imported(f".{name}", package)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return found, lambda: sorted({*vars(sys.modules[package]), *homes})


def deprecated_names(package: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """`__getattr__` of a package for names of the last release.

    **Arguments:**

    - `package`: name of the package.
    - `names`: present name of each former one.

    **Returns:** the function, which warns and returns the present object.
    """

    def attribute(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        message = f"`{package}.{name}` is now `{package}.{names[name]}`."
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return getattr(sys.modules[package], names[name])

    return attribute


def import_late(name: str) -> Any:
    """What is called `name` [-], as "plot.objects.of_muscle", in a layer above the caller's: a
    method hands on to it, and only then is it loaded.
    """
    module, _, inside = name.rpartition(".")
    return getattr(_imported(f".{module}", "fascicle"), inside)


class _Lent:
    """Finds modules by the shorter names that packages have for them, as the modules themselves:
    `import fascicle.recruitment` is `import fascicle.bundle.recruitment`.
    """

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Where a module of that `name` [-] is to be found; `None` for all others."""
        home = _home(name)
        spec = importlib.util.find_spec(home) if home else None
        if spec is None or spec.loader is None:  # a function, or a folder of data
            return None
        loader: Any = self
        return ModuleSpec(name, loader, is_package=spec.submodule_search_locations is not None)

    def create_module(self, spec: ModuleSpec) -> None:
        """Python's own empty module, which is replaced."""
        del spec

    def exec_module(self, module: ModuleType) -> None:
        """Put the module itself in the place of the empty `module` [-]."""
        sys.modules[module.__name__] = importlib.import_module(_home(module.__name__))


def _home(name: str) -> str:
    """The full name of a module that a package lends, or of one inside of it; else empty."""
    for lent, home in _LENT.items():
        if name == lent or name.startswith(f"{lent}."):
            return home + name.removeprefix(lent)
    return ""


def _imported(name: str, package: str) -> ModuleType:
    """A module, or in one line which extra it needs."""
    try:
        return importlib.import_module(name, package)
    except ModuleNotFoundError as error:
        from .errors import missing_extra

        raise missing_extra(error) or error from None


class _Successors:
    """Finds modules that moved, after all other finders, as what hands on to their successors."""

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Where a module of that `name` [-] is to be found; `None` for those that never moved."""
        loader: Any = self
        return ModuleSpec(name, loader, is_package=True) if name in _WENT else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """An empty module [-] of an old name."""
        return ModuleType(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Let the `module` [-] hand out what its successor has, and say where that is."""
        successor = _WENT[module.__name__]
        module.__getattr__ = lambda name: getattr(importlib.import_module(successor), name)
        # the import system's own frames are skipped, so that the caller's line is shown
        warnings.warn(
            f"`{module.__name__}` has moved to `{successor}`.", DeprecationWarning, stacklevel=2
        )
