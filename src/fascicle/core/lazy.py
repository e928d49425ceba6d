"""Imports: packages that load their names when they are first used, names that moved, and hooks.

The command line's help needs no JAX, laws need no pint: a package says in which module each of its
names is, and imports nothing for it. A module that moved is found under its old name, by `import`
and as an attribute, and warns with the new one until a later version drops it. `call_on_import`
acts when a library is imported, by whomever.
"""

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib.machinery import ModuleSpec
from types import MappingProxyType, ModuleType
from typing import Any, cast


def attach_lazy(
    package: str,
    homes: Mapping[str, str],
    moved: Mapping[str, str] | None = None,
    renamed: Mapping[str, str] = MappingProxyType({}),
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    **Arguments:**

    - `package`: its name.
    - `homes`: its names, and in which of its modules each is; "" for a module.
    - `moved`: modules that it had, and where they are now in fascicle.
    - `renamed`: present name of each name of the last release, which warns.

    **Returns:** the two functions.

    **Raises:** `ValueError` for a name that its own module bears: importing that module would
    replace the object.
    """
    if twins := [name for name, home in homes.items() if name == home]:
        raise ValueError(f"{package}: {', '.join(twins)} can't be in a module of the same name.")
    old = {f"{package}.{name}": f"fascicle.{new}" for name, new in (moved or {}).items()}
    _MOVED.aliases.update(old)
    _BORROWED.aliases.update(
        {f"{package}.{n}": f"{package}.{h}.{n}" for n, h in homes.items() if h}
    )

    def get_attribute(name: str) -> Any:
        if name in renamed:
            message = f"`{package}.{name}` is now `{package}.{renamed[name]}`."
            warnings.warn(message, DeprecationWarning, stacklevel=2)
            return getattr(sys.modules[package], renamed[name])
        if homes.get(name):
            return getattr(_import(f".{homes[name]}", package), name)
        if name in homes or f"{package}.{name}" in old:
            return _import(f".{name}", package)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get_attribute, lambda: sorted({*vars(sys.modules[package]), *homes})


def import_late(name: str) -> Any:
    """Import an object of a higher layer, such as "plot.objects.of_muscle", for a method that
    calls it.
    """
    module, _, attribute = name.rpartition(".")
    return getattr(_import(f".{module}", "fascicle"), attribute)


def _import(name: str, package: str) -> ModuleType:
    """A module; an error in one line where it needs an extra that is not installed."""
    try:
        return importlib.import_module(name, package)
    except ModuleNotFoundError as error:
        from .errors import missing_extra

        raise missing_extra(error) or error from None


class _AliasFinder:
    """Finds modules by other names: `fascicle.recruitment` is `fascicle.bundle.recruitment`."""

    def __init__(self, moved: bool):
        self.aliases: dict[str, str] = {}
        self.moved = moved

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Spec of an alias, or of a module inside of one; `None` for other names."""
        target, loader = self._target(name), cast(Any, self)
        if self.moved:  # a package without a path, whose modules nobody else finds
            return ModuleSpec(name, loader, is_package=True) if target else None
        spec = importlib.util.find_spec(target) if target else None
        if spec is None or spec.loader is None:  # a function, or a folder of data
            return None
        return ModuleSpec(name, loader, is_package=spec.submodule_search_locations is not None)

    def create_module(self, spec: ModuleSpec) -> None:
        """Python's default, an empty module, which is replaced."""
        del spec

    def exec_module(self, module: ModuleType) -> None:
        """Replace the empty `module`, or let one that moved hand on to its successor and warn."""
        name, target = module.__name__, self._target(module.__name__)
        if self.moved:  # the import system's own frames are skipped: the caller's line is shown
            module.__getattr__ = lambda name: getattr(importlib.import_module(target), name)
            warnings.warn(f"`{name}` has moved to `{target}`.", DeprecationWarning, stacklevel=2)
        else:
            sys.modules[name] = importlib.import_module(target)

    def _target(self, name: str) -> str:
        for alias, target in self.aliases.items():
            if name == alias or (not self.moved and name.startswith(f"{alias}.")):
                return target + name.removeprefix(alias)
        return ""


_BORROWED, _MOVED = _AliasFinder(moved=False), _AliasFinder(moved=True)
sys.meta_path.insert(0, _BORROWED)  # first: others would load a borrowed module twice
sys.meta_path.append(_MOVED)  # last: a module that exists under an old name is another one


# wrapt has such hooks, too, and takes as long to import as all laws of a muscle


def call_on_import(name: str, action: Callable[[ModuleType], None]) -> None:
    """Call an `action` with the module of a `name` when it is imported, or now if it has been."""
    if name in sys.modules:
        action(sys.modules[name])
    else:
        _HOOKS.actions.setdefault(name, []).append(action)


class _HookFinder:
    def __init__(self) -> None:
        self.actions: dict[str, list[Callable[[ModuleType], None]]] = {}

    def find_spec(self, name: str, *arguments: Any) -> ModuleSpec | None:
        if name not in self.actions:
            return None
        for finder in sys.meta_path:
            spec = None if finder is self else finder.find_spec(name, *arguments)
            if spec is not None and spec.loader is not None:
                spec.loader = _HookLoader(spec.loader, self.actions)  # type: ignore[assignment]
                return spec
        return None


class _HookLoader:
    def __init__(self, loader: Any, actions: dict[str, list[Callable]]):
        self._loader, self._actions = loader, actions

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)

    def exec_module(self, module: ModuleType) -> None:
        if module.__spec__ is not None:
            module.__spec__.loader = module.__loader__ = self._loader
        self._loader.exec_module(module)
        for action in self._actions.pop(module.__name__, []):
            action(module)


_HOOKS = _HookFinder()
sys.meta_path.insert(0, _HOOKS)
