"""fascicle: the open toolkit for fluidic artificial muscles (FAMs, McKibben muscles).

Laws are pure functions in SI units, written once: NumPy's numbers and arrays are answered at
once, JAX's compile, differentiate and run on a GPU, and C comes from the same source. Importing
fascicle switches JAX to float64, which roots and collapse need; set `JAX_ENABLE_X64=0` to forgo
it, and be warned once.
"""

import importlib

from ._float64 import switch_on


switch_on()

TYPE_CHECKING = False  # as `typing` has it, which takes longer to import than all of this
if TYPE_CHECKING:
    from . import calibrate as calibrate
    from . import design as design
    from . import energetics as energetics
    from . import records as records
    from .bundle import Bundle as Bundle
    from .bundle import MotorUnit as MotorUnit
    from .bundle import recruitment as recruitment
    from .bundle import reversal as reversal
    from .bundle import schemes as schemes
    from .describe import example as example
    from .describe import examples as examples
    from .describe import load as load
    from .describe import save as save
    from .muscle import MooneyRivlin as MooneyRivlin
    from .muscle import Muscle as Muscle
    from .muscle import Tuning as Tuning
    from .muscle import materials as materials

__version__ = "0.1.0"

# each name loads what it needs when it is first used: the command line's help needs no JAX,
# laws need no pint
_HOMES = {
    "Bundle": "bundle",
    "MooneyRivlin": "muscle",
    "MotorUnit": "bundle",
    "Muscle": "muscle",
    "Tuning": "muscle",
    "calibrate": "",
    "design": "",
    "energetics": "",
    "example": "describe",
    "examples": "describe",
    "load": "describe",
    "materials": "muscle",
    "records": "",
    "recruitment": "bundle",
    "reversal": "bundle",
    "save": "describe",
    "schemes": "bundle",
}

__all__ = [
    "Bundle",
    "MooneyRivlin",
    "MotorUnit",
    "Muscle",
    "Tuning",
    "calibrate",
    "design",
    "energetics",
    "example",
    "examples",
    "load",
    "materials",
    "records",
    "recruitment",
    "reversal",
    "save",
    "schemes",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = _HOMES[name]
    if not home:
        return importlib.import_module(f".{name}", __name__)
    value = getattr(importlib.import_module(f".{home}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
