"""Settings of JAX and XLA that must be made before JAX is used; loads neither.

- *float64*: roots and collapse need it. JAX gets it on its import, by whomever.
- *whole loops*: XLA compiles a small loop as one function of machine code, and runs a larger one as
  a task for each of its operations, which takes longer than to add a few numbers: 10 s of a bundle
  take 1 s instead of 0.06. XLA's option says up to how many bytes a loop is small.
"""

import os
import warnings
from types import ModuleType

from .lazy import call_on_import


_NAME = "xla_cpu_small_while_loop_byte_threshold"
_OPTION = "--xla_backend_extra_options"


def enable_float64() -> None:
    """Switch JAX to float64, now or on its import; warn where the environment forbids it."""
    if os.environ.get("JAX_ENABLE_X64", "1").lower() in {"0", "false"}:
        warnings.warn(
            "JAX_ENABLE_X64 is off: fascicle computes in float32 under JAX, roots lose digits.",
            stacklevel=3,
        )
    else:
        # runs at once where JAX has been imported already
        call_on_import("jax", _enable)


def _enable(jax: ModuleType) -> None:
    jax.config.update("jax_enable_x64", True)


def enable_whole_loops() -> None:
    """Add the option to `XLA_FLAGS`, unless they have one of its kind.

    XLA reads `XLA_FLAGS` when it first compiles: later it changes nothing.
    """
    flags = os.environ.get("XLA_FLAGS", "")
    if _NAME not in flags and _OPTION not in flags:  # a second one would replace the user's
        os.environ["XLA_FLAGS"] = f"{flags} {_OPTION}={_NAME}=100000000".strip()
