"""Muscles, bundles, scenarios and tasks as TOML files, and the shipped ones.

Names are imported at their first use: the shell's completion, which lists the examples, needs
neither pydantic nor JAX.
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .measured_muscles import catalog
    from .muscle_files import dumps, loads, provenance, save
    from .scenario import Scenario, load_scenario, loads_scenario
    from .shipped_files import example_text, examples, scenarios

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
    "catalog", "Scenario", "load_scenario", "loads_scenario", "scenarios",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("dumps", "loads", "provenance", "save"), "muscle_files"),
    "catalog": "measured_muscles",
    **dict.fromkeys(("example_text", "examples", "scenarios"), "shipped_files"),
    **dict.fromkeys(("Scenario", "load_scenario", "loads_scenario"), "scenario"),
}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)


def load(path: str | os.PathLike[str]) -> Any:
    """Read a muscle, bundle or scenario file.

    **Arguments:** `path`: the TOML file.

    **Returns:** a `Scenario` if the file has a `[load]` or a `[run]`, a `Bundle` if it has a
    `[bundle]` alone, else its `Muscle`.

    **Raises:** `OSError` if it can't be read; `ValueError`, in one line with path and key, for
    values that aren't valid.
    """
    from .muscle_files import from_dict, read_file

    path = Path(path)
    data = read_file(path)
    if {"load", "run", "schedule"} & data.keys():
        from .scenario import scenario_from_dict

        return scenario_from_dict(data, str(path), path.parent, path.stem)
    return from_dict(data, str(path), path.parent)


def example(name: str) -> Any:
    """Build a named muscle, bundle or scenario.

    **Arguments:** `name`: one of `examples()`, `scenarios()` or `catalog`.

    **Returns:** the `Muscle`, `Bundle` or `Scenario`.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    from .shipped_files import example_text, scenarios

    content = example_text(name)
    if name in scenarios():
        from .scenario import loads_scenario

        return loads_scenario(content, source=name)
    from .muscle_files import loads

    return loads(content, source=name)
