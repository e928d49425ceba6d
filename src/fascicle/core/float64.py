"""JAX's float64, switched on as soon as JAX is there: roots and collapse need it.

JAX is imported late, by what needs it or by the user, and reads its environment then. That is the
user's own, so that nothing is written there: an import of JAX that is still to come is awaited.
"""

import importlib.util
import os
import sys
import warnings
from importlib.machinery import ModuleSpec
from types import ModuleType


def switch_on() -> None:
    """Switch JAX to float64, now or when it is imported; warn where the user has forbidden it."""
    if os.environ.get("JAX_ENABLE_X64", "1").lower() in {"0", "false"}:
        warnings.warn(
            "fascicle runs in float32 since JAX_ENABLE_X64 is off: roots lose their precision.",
            stacklevel=3,
        )
    elif "jax" in sys.modules:
        _switch(sys.modules["jax"])
    else:
        sys.meta_path.insert(0, _Awaiting())


class _Awaiting:
    """Finds JAX as all others would, and switches it once it is imported."""

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        """Where JAX is to be found; of other modules nothing is known here."""
        if name != "jax":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            imported = spec.loader.exec_module

            def switched(module: ModuleType) -> None:
                imported(module)
                _switch(module)

            spec.loader.exec_module = switched
        return spec


def _switch(jax: ModuleType) -> None:
    jax.config.update("jax_enable_x64", True)
