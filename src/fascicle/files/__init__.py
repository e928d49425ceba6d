"""Muscles, bundles, scenarios and tasks as TOML files, and the shipped ones.

Shipped are muscles and bundles of the literature, scenarios that drive them, and catalogs; each
file begins with a line that describes it, and names its source. Names are imported at their first
use: the shell's completion, which lists the examples, needs neither pydantic nor JAX.
"""

import difflib
import os
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .muscle_files import dumps, loads, provenance, save
    from .scenario import Scenario, load_scenario, loads_scenario

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
    "Scenario", "load_scenario", "loads_scenario", "scenarios",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("dumps", "loads", "provenance", "save"), "muscle_files"),
    **dict.fromkeys(("Scenario", "load_scenario", "loads_scenario"), "scenario"),
}
_MOVED = {"calibrated": "files.calibration_files"}
_SIMILARITY = 0.4  # of a name to suggest: "lift" is near "lift_gas"

__getattr__, __dir__ = attach_lazy(__name__, _HOMES, _MOVED)


def load(path: str | os.PathLike[str]) -> Any:
    """Read a muscle, bundle or scenario file.

    **Arguments:** `path`: the TOML file.

    **Returns:** a `Scenario` if the file has a `[load]` or a `[run]`, a `Bundle` if it has a
    `[bundle]` alone, else its `Muscle`.

    **Raises:** `OSError` if it can't be read; `ValueError`, in one line with path and key, for
    values that aren't valid.
    """
    from .muscle_files import from_dict, parse_file, read_text

    path = Path(path)
    data = parse_file(read_text(path), str(path))
    if {"load", "run", "schedule"} & data.keys():
        from .scenario import scenario_from_dict

        return scenario_from_dict(data, str(path), path.parent, path.stem)
    return from_dict(data, str(path))


def example(name: str) -> Any:
    """Build a named muscle, bundle or scenario.

    **Arguments:** `name`: one of `examples()` or `scenarios()`.

    **Returns:** the `Muscle`, `Bundle` or `Scenario`.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    content = example_text(name)
    if name in scenarios():
        from .scenario import loads_scenario

        return loads_scenario(content, source=name)
    from .muscle_files import loads

    return loads(content, source=name)


def shipped_names(kind: str) -> list[str]:
    """Names of the shipped files of a kind, "examples", "scenarios" or "catalogs", sorted."""
    names = [file.name for file in (files("fascicle.files") / kind).iterdir()]
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def shipped_text(kind: str, name: str) -> str:
    """Text of a shipped file."""
    return (files("fascicle.files") / kind / f"{name}.toml").read_text(encoding="utf-8")


def descriptions(kind: str) -> dict[str, str]:
    """First line of each shipped file of a kind, by name."""
    texts = {name: shipped_text(kind, name) for name in shipped_names(kind)}
    return {name: text.partition("\n")[0].lstrip("# ") for name, text in texts.items()}


def examples() -> dict[str, str]:
    """Descriptions of the named muscles and bundles, by name."""
    return descriptions("examples")


def scenarios() -> dict[str, str]:
    """Descriptions of the named scenarios, by name."""
    return descriptions("scenarios")


def example_text(name: str) -> str:
    """Read the file of a named example.

    **Arguments:** `name`: one of `examples()` or `scenarios()`.

    **Returns:** the TOML with its comments.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    kinds = {key: kind for kind in ("scenarios", "examples") for key in shipped_names(kind)}
    if name not in kinds:
        similar = difflib.get_close_matches(str(name), kinds, n=1, cutoff=_SIMILARITY)
        hint = f"choose one of {', '.join(sorted(kinds))}."
        hint = f"did you mean {similar[0]}?" if similar else hint
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return shipped_text(kinds[name], name)
