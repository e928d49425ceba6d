"""Measured data: from a dynamometer's CSV to a record, its runs, and back to a file.

Names are looked up when they are asked for, so that a record's shape can be had without
pandas, and a file can be read without JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .averaging import Averaged as Averaged
    from .averaging import averaged as averaged
    from .dynamometer import VirtualDynamometer as VirtualDynamometer
    from .loops import Loop as Loop
    from .loops import loop_of as loop_of
    from .reading import load as load
    from .reading import loads as loads
    from .record import Record as Record
    from .record import Source as Source
    from .record import join as join
    from .splitting import Run as Run
    from .splitting import runs as runs
    from .writing import dumps as dumps
    from .writing import write as write

_HOMES = {
    "Averaged": "averaging",
    "Loop": "loops",
    "Record": "record",
    "Run": "splitting",
    "Source": "record",
    "VirtualDynamometer": "dynamometer",
    "averaged": "averaging",
    "dumps": "writing",
    "join": "record",
    "load": "reading",
    "loads": "reading",
    "loop_of": "loops",
    "runs": "splitting",
    "write": "writing",
}

__all__ = [
    "Averaged",
    "Loop",
    "Record",
    "Run",
    "Source",
    "VirtualDynamometer",
    "averaged",
    "dumps",
    "join",
    "load",
    "loads",
    "loop_of",
    "runs",
    "write",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
