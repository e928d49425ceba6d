"""Measured data: a dynamometer's CSV as a record, its runs, and back to a file.

Names are imported at their first use: a record needs no pandas, a file no model.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .dynamometer import Scatter, VirtualDynamometer
    from .headers import MissingMetadataError
    from .hysteresis import Averaged, Loop, averaged, loop_of
    from .published import json_schema, write
    from .reading import load, loads
    from .record import Record, Source, dumps, join
    from .segmentation import Run, runs

__all__ = [
    "Averaged", "Loop", "MissingMetadataError", "Record", "Run", "Scatter", "Source",
    "VirtualDynamometer", "averaged", "dumps", "join", "json_schema", "load", "loads", "loop_of",
    "runs", "write",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("Averaged", "Loop", "averaged", "loop_of"), "hysteresis"),
    **dict.fromkeys(("Record", "Source", "dumps", "join"), "record"),
    **dict.fromkeys(("load", "loads"), "reading"),
    **dict.fromkeys(("Run", "runs"), "segmentation"),
    **dict.fromkeys(("Scatter", "VirtualDynamometer"), "dynamometer"),
    **dict.fromkeys(("json_schema", "write"), "published"),
    "MissingMetadataError": "headers",
}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
