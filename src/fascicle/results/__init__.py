"""Results as labelled tables for Python, the command line and the explorer, and as files."""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from . import tables
    from .labelled import Table, Variable

__all__ = ["Table", "Variable", "tables"]

_HOMES = {"Table": "labelled", "Variable": "labelled", "tables": ""}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
