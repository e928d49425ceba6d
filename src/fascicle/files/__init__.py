"""Muscles, bundles, scenarios and tasks as TOML files, and the shipped ones.

Names are imported at their first use: the shell's completion, which lists the examples, needs
neither pydantic nor JAX. Each shipped file begins with a line that describes it.
"""

import difflib
import os
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .measured_muscles import catalog
    from .muscle_files import dumps, loads, provenance, save
    from .scenario import Scenario, lift_scenario, load_scenario, loads_scenario

__all__ = [
    "load", "loads", "provenance", "save", "dumps", "example", "example_text", "examples",
    "catalog", "Scenario", "lift_scenario", "load_scenario", "loads_scenario", "scenarios",
]  # fmt: skip

_HOMES = {
    **dict.fromkeys(("dumps", "loads", "provenance", "save"), "muscle_files"),
    "catalog": "measured_muscles",
    **dict.fromkeys(("Scenario", "lift_scenario", "load_scenario", "loads_scenario"), "scenario"),
}
__getattr__, __dir__ = attach_lazy(__name__, _HOMES)
_SIMILARITY = 0.4  # of a name to suggest: "lift" is near "lift_gas"


def load(path: str | os.PathLike[str]) -> Any:
    """Read a TOML file: a `Scenario` if it has a `[load]` or a `[run]`, a `Bundle` if it has a
    `[bundle]` alone, else a `Muscle`.

    Raises `OSError` if it can't be read; `ValueError`, in one line with path and key, for values
    that aren't valid.
    """
    from .muscle_files import from_dict, read_file

    path = Path(path)
    data = read_file(path)
    if {"load", "run", "schedule"} & data.keys():
        from .scenario import scenario_from_dict

        return scenario_from_dict(data, str(path), path.parent, path.stem)
    return from_dict(data, str(path), path.parent)


def example(name: str) -> Any:
    """The named `Muscle`, `Bundle` or `Scenario`, one of `examples()`, `scenarios()` or `catalog`;
    `ValueError`, with the nearest name, for another.
    """
    content = example_text(name)
    if name in scenarios():
        from .scenario import loads_scenario

        return loads_scenario(content, source=name)
    from .muscle_files import loads

    return loads(content, source=name)


def example_text(name: str) -> str:
    """TOML of a named example, with its comments; names and errors as of `example`."""
    kinds = {
        key: kind for kind in ("scenarios", "measured", "examples") for key in shipped_names(kind)
    }
    if name not in kinds:
        similar = difflib.get_close_matches(str(name), kinds, n=1, cutoff=_SIMILARITY)
        hint = f"choose one of {', '.join(sorted(kinds))}."
        hint = f"did you mean {similar[0]}?" if similar else hint
        raise ValueError(f"{str(name)[:60]!r} is neither a file nor a named example: {hint}")
    return shipped_text(kinds[name], name)


def examples() -> dict[str, str]:
    """Descriptions of the named muscles and bundles, by name."""
    return descriptions("examples")


def scenarios() -> dict[str, str]:
    """Descriptions of the named scenarios, by name."""
    return descriptions("scenarios")


def named_muscles() -> list[str]:
    """Names of the examples, then of the measured muscles."""
    return [*shipped_names("examples"), *shipped_names("measured")]


def shipped_names(kind: str) -> list[str]:
    """Names of the shipped "examples", "measured", "scenarios" or "catalogs", without .toml."""
    names = [file.name for file in (files(__name__) / kind).iterdir()]
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def shipped_text(kind: str, name: str) -> str:
    """Text of a shipped file."""
    return (files(__name__) / kind / f"{name}.toml").read_text(encoding="utf-8")


def descriptions(kind: str) -> dict[str, str]:
    """First line of each shipped file of a kind, by name."""
    texts = {name: shipped_text(kind, name) for name in shipped_names(kind)}
    return {name: text.partition("\n")[0].lstrip("# ") for name, text in texts.items()}
