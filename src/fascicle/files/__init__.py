"""Muscles and bundles as TOML files, the named examples, and results in and out.

Names are looked up when they are asked for, so that listing the examples (as the shell's
completion does) loads neither pydantic nor JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import lazily


if TYPE_CHECKING:
    from .named import example, example_text, examples
    from .reading import load, loads, provenance
    from .writing import dumps, save

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
]  # fmt: skip

_HOMES = {
    "dumps": "writing",
    "example": "named",
    "example_text": "named",
    "examples": "named",
    "load": "reading",
    "loads": "reading",
    "provenance": "reading",
    "save": "writing",
}

__getattr__, __dir__ = lazily(__name__, _HOMES)
