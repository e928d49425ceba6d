"""Labelled values for Python, command line and explorer alike, and their way out."""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from . import tables as tables
    from .labelled import Table as Table
    from .labelled import Variable as Variable

__all__ = ["Table", "Variable", "tables"]

_HOMES = {"Table": "labelled", "Variable": "labelled", "tables": ""}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
