"""Shipped files: muscles and bundles of the literature, scenarios that drive them, catalogs.

Each file begins with a line about itself, and names its source.
"""

import difflib
from importlib.resources import files


_SCENARIOS = "scenarios"


def shipped_names(kind: str) -> list[str]:
    """Names of the shipped files of a kind, "examples", "scenarios" or "catalogs", sorted."""
    folder = files("fascicle.files") / kind
    names = [file.name for file in folder.iterdir()]
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def shipped_text(kind: str, name: str) -> str:
    """Text of a shipped file."""
    path = files("fascicle.files") / kind / f"{name}.toml"
    return path.read_text(encoding="utf-8")


def descriptions(kind: str) -> dict[str, str]:
    """First line of each shipped file of a kind, by name."""
    return {
        name: shipped_text(kind, name).partition("\n")[0].lstrip("# ")
        for name in shipped_names(kind)
    }


def examples() -> dict[str, str]:
    """The named muscles and bundles: a line about each, by name."""
    return descriptions("examples")


def scenarios() -> dict[str, str]:
    """The named scenarios: a line about each, by name."""
    return descriptions(_SCENARIOS)


def catalogs() -> dict[str, str]:
    """The shipped catalogs: a line about each, by name."""
    return descriptions("catalogs")


def example_text(name: str) -> str:
    """Read the file of a named example.

    **Arguments:** `name`: one of `examples()` or `scenarios()` [-].

    **Returns:** the TOML with its comments.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    kinds = {known: kind for kind in (_SCENARIOS, "examples") for known in shipped_names(kind)}
    if name not in kinds:
        near = difflib.get_close_matches(str(name), kinds, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(sorted(kinds))}."
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return shipped_text(kinds[name], name)
