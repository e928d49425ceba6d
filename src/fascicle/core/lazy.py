"""Imports: packages that load their names at first use, and settings of JAX.

The command line's help needs no JAX, laws need no pint: a package says in which module each of its
names is, and imports nothing for it. `call_on_import` acts when a library is imported, by whomever:
JAX is then switched to float64, without which roots lose digits.
"""

import importlib
import os
import sys
import warnings
from collections.abc import Callable, Mapping
from importlib.machinery import ModuleSpec
from types import MethodType, ModuleType
from typing import Any, cast


def attach_lazy(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a `package`. `homes`: module of each of its names; "" for a
    name that is a module. `ValueError` for a name that is its module's, too: importing that module
    would replace the object.
    """
    if twins := [name for name, home in homes.items() if name == home]:
        raise ValueError(f"{package}: {', '.join(twins)} can't be in a module of the same name.")

    def get_attribute(name: str) -> Any:
        if homes.get(name):
            return getattr(_import(f".{homes[name]}", package), name)
        if name in homes:
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
_HOOKS = _HookFinder()
sys.meta_path.insert(0, _HOOKS)


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
