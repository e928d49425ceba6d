"""Fitting a muscle to a record, and how sure that is.

Names are looked up when they are asked for, so that the command line's help loads no JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .beginning import Prior as Prior
    from .calibration import Calibration as Calibration
    from .calibration import Estimate as Estimate
    from .choosing import Candidate as Candidate
    from .comparing import compare as compare
    from .comparing import compare_tension as compare_tension
    from .finding import Choice as Choice
    from .finding import find as find
    from .fitting import fit as fit
    from .posterior import sample as sample
    from .profiling import profiles as profiles

_HOMES = {
    "Calibration": "calibration",
    "Candidate": "choosing",
    "Choice": "finding",
    "Estimate": "calibration",
    "Prior": "beginning",
    "compare": "comparing",
    "compare_tension": "comparing",
    "find": "finding",
    "fit": "fitting",
    "profiles": "profiling",
    "sample": "posterior",
}

__all__ = [
    "Calibration",
    "Candidate",
    "Choice",
    "Estimate",
    "Prior",
    "compare",
    "compare_tension",
    "find",
    "fit",
    "profiles",
    "sample",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
