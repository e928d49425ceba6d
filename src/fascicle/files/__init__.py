"""Muscles, bundles and scenarios as TOML files, the named examples, and results in and out.

Names are looked up when they are asked for, so that listing the examples (as the shell's
completion does) loads neither pydantic nor JAX.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .named import example, example_text, examples, scenarios
    from .opening import load
    from .reading import loads, provenance
    from .scenario import Scenario, load_scenario, loads_scenario
    from .writing import dumps, save

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
    "Scenario", "load_scenario", "loads_scenario", "scenarios",
]  # fmt: skip

_HOMES = {
    "dumps": "writing",
    "example": "named",
    "example_text": "named",
    "examples": "named",
    "load": "opening",
    "load_scenario": "scenario",
    "loads": "reading",
    "loads_scenario": "scenario",
    "provenance": "reading",
    "save": "writing",
    "Scenario": "scenario",
    "scenarios": "named",
}

__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
