"""JAX in float64, which roots and collapse need, whenever JAX is imported and by whomever."""

import os
import warnings
from types import ModuleType

import wrapt


def enable_float64() -> None:
    """Switch JAX to float64, now or on its import; warn where the environment forbids it."""
    if os.environ.get("JAX_ENABLE_X64", "1").lower() in {"0", "false"}:
        warnings.warn(
            "JAX_ENABLE_X64 is off: fascicle computes in float32 under JAX, roots lose digits.",
            stacklevel=3,
        )
    else:
        # runs at once where JAX has been imported already
        wrapt.register_post_import_hook(_enable, "jax")


def _enable(jax: ModuleType) -> None:
    jax.config.update("jax_enable_x64", True)
