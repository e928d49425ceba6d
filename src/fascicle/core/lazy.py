"""Imports: packages that load their names at first use, former names, and settings of JAX.

The command line's help needs no JAX, laws need no pint: a package says in which module each of its
names is, and imports nothing for it. A module that moved can be imported by its old name, and warns
with the new one until a later version drops it. `call_on_import` acts when a library is imported,
by whomever: JAX is then switched to float64, without which roots lose digits.
"""

import importlib
import importlib.util
import os
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib.machinery import ModuleSpec
from types import MethodType, ModuleType
from typing import Any, TypeVar, cast

from ..former_names import ATTRIBUTES, MODULES, NAMES, REMOVAL


_Class = TypeVar("_Class", bound=type)


def warn_renamed(old: str, new: str, verb: str = "is now") -> None:
    """Warn, at the line that uses it, that a name is another one now."""
    message = f"`{old}` {verb} `{new}`. The former name goes with fascicle {REMOVAL}."
    warnings.warn(message, DeprecationWarning, stacklevel=3)


def with_former_names(owner: _Class) -> _Class:
    """Class decorator: former names of attributes and methods, from `ATTRIBUTES`."""

    def alias(old: str, new: str) -> property:
        def get_present(self: Any) -> Any:
            warn_renamed(f"{type(self).__name__}.{old}", new)
            return getattr(self, new)

        get_present.__doc__ = f"Former name of `{new}`."
        return property(get_present)

    for old, new in ATTRIBUTES[owner.__name__].items():
        setattr(owner, old, alias(old, new))
    return owner


def attach_lazy(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a `package`. `homes`: module of each of its names; "" for a
    name that is a module. Former names, of `former_names`, warn. `ValueError` for a name that
    is its module's, too: importing that module would replace the object.
    """
    if twins := [name for name, home in homes.items() if name == home]:
        raise ValueError(f"{package}: {', '.join(twins)} can't be in a module of the same name.")
    renamed, modules = NAMES.get(package, {}), MODULES.get(package, {})
    former = {f"{package}.{name}": f"fascicle.{new}" for name, new in modules.items()}
    _FORMER_NAMES.aliases.update(former)
    _ALIASES.aliases.update(
        {f"{package}.{name}": f"{package}.{home}.{name}" for name, home in homes.items() if home}
    )

    def get_attribute(name: str) -> Any:
        if name in renamed:
            warn_renamed(f"{package}.{name}", f"{package}.{renamed[name]}")
            return getattr(sys.modules[package], renamed[name])
        if homes.get(name):
            return getattr(_import(f".{homes[name]}", package), name)
        if name in homes or f"{package}.{name}" in former:
            return _import(f".{name}", package)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get_attribute, lambda: sorted({*vars(sys.modules[package]), *homes})


def import_late(name: str) -> Any:
    """Import an object of a higher layer, such as "plot.curves.force_strain", when it is needed."""
    module, _, attribute = name.rpartition(".")
    return getattr(_import(f".{module}", "fascicle"), attribute)


class late_method:  # noqa: N801 as `property`
    """Method that is a function of a higher layer by its `name`, imported when it is needed."""

    def __init__(self, name: str):
        self.name = name

    def __get__(self, instance: object, owner: type | None = None) -> Callable[..., Any]:
        function = import_late(self.name)
        return function if instance is None else MethodType(function, instance)


def _import(name: str, package: str) -> ModuleType:
    """A module; `MissingExtraError` where it needs an extra that is not installed."""
    try:
        return importlib.import_module(name, package)
    except ModuleNotFoundError as error:
        from .errors import missing_extra

        raise missing_extra(error) or error from None


class _AliasFinder:
    """Finder of modules by other names: `fascicle.recruitment` is `fascicle.bundle.recruitment`."""

    def __init__(self, warns: bool):
        self.aliases: dict[str, str] = {}
        self.warns = warns

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Spec of an alias, or of a module inside of one; `None` for other names."""
        target, loader = self._target(name), cast(Any, self)
        if self.warns:  # a package without a path, whose modules no other finder knows
            return ModuleSpec(name, loader, is_package=True) if target else None
        spec = importlib.util.find_spec(target) if target else None
        if spec is None or spec.loader is None:  # a function, or a folder of data
            return None
        return ModuleSpec(name, loader, is_package=spec.submodule_search_locations is not None)

    def create_module(self, spec: ModuleSpec) -> None:
        """Python's default, an empty module, which is replaced."""
        del spec

    def exec_module(self, module: ModuleType) -> None:
        """Replace the empty `module`, or forward it to its successor and warn."""
        name, target = module.__name__, self._target(module.__name__)
        if self.warns:  # the import system's own frames are skipped: the caller's line is shown
            module.__getattr__ = lambda name: getattr(importlib.import_module(target), name)
            warn_renamed(name, target, "has moved to")
        else:
            sys.modules[name] = importlib.import_module(target)

    def _target(self, name: str) -> str:
        """Present name of an alias, and of a module in one unless it warns; empty for others."""
        for alias, target in self.aliases.items():
            if name == alias or (not self.warns and name.startswith(f"{alias}.")):
                return target + name.removeprefix(alias)
        return ""


class _HookFinder:
    """Finder that calls actions with a module after other finders have imported it."""

    def __init__(self) -> None:
        self.actions: dict[str, list[Callable[[ModuleType], Any]]] = {}

    def find_spec(self, name: str, *arguments: Any) -> ModuleSpec | None:
        if name not in self.actions:
            return None
        specs = (f.find_spec(name, *arguments) for f in sys.meta_path if f is not self)
        spec = next((spec for spec in specs if spec is not None), None)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def exec_module(module: ModuleType) -> None:
                execute(module)
                for action in self.actions.pop(name, []):
                    action(module)

            cast(Any, spec.loader).exec_module = exec_module
        return spec


# wrapt has such hooks, too, and takes as long to import as all laws of a muscle
_ALIASES, _FORMER_NAMES, _HOOKS = _AliasFinder(warns=False), _AliasFinder(warns=True), _HookFinder()
sys.meta_path[:0] = [_HOOKS, _ALIASES]  # first: others would load a borrowed module twice
sys.meta_path.append(_FORMER_NAMES)  # last: a module that exists under an old name is another one


def call_on_import(name: str, action: Callable[[ModuleType], Any]) -> None:
    """Call an `action` with the module of a `name` when it is imported, or now if it has been."""
    if name in sys.modules:
        action(sys.modules[name])
    else:
        _HOOKS.actions.setdefault(name, []).append(action)


def enable_float64() -> None:
    """Switch JAX to float64, now or on its import; warn where the environment forbids it."""
    if os.environ.get("JAX_ENABLE_X64", "1").lower() in {"0", "false"}:
        message = "JAX_ENABLE_X64 is off: JAX computes in float32, and roots lose digits."
        warnings.warn(message, stacklevel=3)
    else:
        call_on_import("jax", lambda jax: cast(Any, jax).config.update("jax_enable_x64", True))


# XLA compiles a small loop as one function of machine code, and runs a larger one as a task for
# each of its operations: 10 s of a bundle take 1 s instead of 0.06. This says what is small [byte]
_LOOP_SIZE = "xla_cpu_small_while_loop_byte_threshold"
_XLA_OPTION = "--xla_backend_extra_options"


def enable_whole_loops() -> None:
    """Have XLA compile each loop of a run as one kernel, which is faster: add the option to
    `XLA_FLAGS`, which it reads when it first compiles, unless one of its kind is there.
    """
    flags = os.environ.get("XLA_FLAGS", "")
    if _LOOP_SIZE not in flags and _XLA_OPTION not in flags:  # a second one would replace the first
        os.environ["XLA_FLAGS"] = f"{flags} {_XLA_OPTION}={_LOOP_SIZE}=100000000".strip()
