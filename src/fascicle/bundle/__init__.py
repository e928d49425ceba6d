"""Motor units, bundles, their recruitment and the reversal of their free strain.

Names are looked up when they are asked for, so that the command line's help loads no JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from . import recruitment as recruitment
    from . import reversal as reversal
    from . import scheme as schemes
    from .bundle import Bundle as Bundle
    from .bundle import Equilibria as Equilibria
    from .bundle import MotorUnit as MotorUnit

_HOMES = {"Bundle": "bundle", "Equilibria": "bundle", "MotorUnit": "bundle"}
_MODULES = {"recruitment": "recruitment", "reversal": "reversal", "schemes": "scheme"}

__all__ = ["Bundle", "Equilibria", "MotorUnit", "recruitment", "reversal", "schemes"]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f".{_MODULES[name]}", __name__)
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
