"""fascicle: the open toolkit for fluidic artificial muscles (FAMs, McKibben muscles).

Laws are pure functions of JAX arrays in SI units: they broadcast, compile, differentiate
and run on a GPU from one source. Importing fascicle switches JAX to float64, which roots
and collapse need; set `JAX_ENABLE_X64=0` to forgo it, and be warned once.
"""

import importlib
import os
import warnings
from typing import TYPE_CHECKING, Any

import jax


if os.environ.get("JAX_ENABLE_X64", "1").lower() in {"0", "false"}:
    warnings.warn(
        "fascicle runs in float32 since JAX_ENABLE_X64 is off: roots lose their precision.",
        stacklevel=2,
    )
else:
    jax.config.update("jax_enable_x64", True)

# after the switch: constants of the materials are arrays already
from . import energetics as energetics
from .bundle import Bundle as Bundle
from .bundle import MotorUnit as MotorUnit
from .bundle import recruitment as recruitment
from .bundle import reversal as reversal
from .muscle import Muscle as Muscle
from .muscle import Tuning as Tuning
from .muscle import materials as materials
from .muscle.materials import MooneyRivlin as MooneyRivlin


if TYPE_CHECKING:
    from .describe import example as example
    from .describe import examples as examples
    from .describe import load as load
    from .describe import save as save

__version__ = "0.1.0"

# pint, pydantic and the rest load only where files are asked for
_LAZY = {"load": "describe", "save": "describe", "example": "describe", "examples": "describe"}

__all__ = [
    "Bundle",
    "MooneyRivlin",
    "MotorUnit",
    "Muscle",
    "Tuning",
    "energetics",
    "example",
    "examples",
    "load",
    "materials",
    "recruitment",
    "reversal",
    "save",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f".{_LAZY[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
