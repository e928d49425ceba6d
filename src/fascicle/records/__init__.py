"""Measured data: from a dynamometer's CSV to a record, its runs, and back to a file.

Names are looked up when they are asked for, so that a record's shape can be had without
pandas, and a file can be read without JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .averaging import Averaged as Averaged
    from .averaging import averaged as averaged
    from .dynamometer import Sweeps as Sweeps
    from .dynamometer import VirtualDynamometer as VirtualDynamometer
    from .fabrication import Scatter as Scatter
    from .loops import Loop as Loop
    from .loops import loop_of as loop_of
    from .pairs import Pairs as Pairs
    from .pairs import agreements as agreements
    from .pairs import fabricated_pairs as fabricated_pairs
    from .reading import load as load
    from .reading import loads as loads
    from .record import Record as Record
    from .record import Source as Source
    from .record import join as join
    from .splitting import Run as Run
    from .splitting import runs as runs
    from .writing import dumps as dumps
    from .writing import write as write

__all__ = [
    "Averaged",
    "Loop",
    "Pairs",
    "Record",
    "Run",
    "Scatter",
    "Source",
    "Sweeps",
    "VirtualDynamometer",
    "agreements",
    "averaged",
    "dumps",
    "fabricated_pairs",
    "join",
    "load",
    "loads",
    "loop_of",
    "runs",
    "write",
]

_HOMES = {
    "Averaged": "averaging",
    "Loop": "loops",
    "Pairs": "pairs",
    "Record": "record",
    "Run": "splitting",
    "Scatter": "fabrication",
    "Source": "record",
    "Sweeps": "dynamometer",
    "VirtualDynamometer": "dynamometer",
    "agreements": "pairs",
    "averaged": "averaging",
    "dumps": "writing",
    "fabricated_pairs": "pairs",
    "join": "record",
    "load": "reading",
    "loads": "reading",
    "loop_of": "loops",
    "runs": "splitting",
    "write": "writing",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
