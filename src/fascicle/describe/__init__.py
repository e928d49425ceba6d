"""Muscles and bundles as TOML files, the named examples, and results in and out.

Names are looked up when they are asked for, so that listing the examples (as the shell's
completion does) loads neither pydantic nor JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .named import example, example_text, examples
    from .reading import load, loads, provenance
    from .writing import dumps, save

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
]  # fmt: skip

_HOMES = {
    "load": "reading", "loads": "reading", "provenance": "reading",
    "save": "writing", "dumps": "writing",
    "example": "named", "example_text": "named", "examples": "named",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
