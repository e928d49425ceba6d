"""Shipped files: muscles and bundles of the literature, measured muscles, scenarios, catalogs.

Each file begins with a line that describes it, and names its source.
"""

import difflib
from importlib.resources import files


_SIMILARITY = 0.4  # of a name to suggest: "lift" is near "lift_gas"


def shipped_names(kind: str) -> list[str]:
    """Names of the shipped files of a kind, sorted: "examples", "measured", "scenarios" or
    "catalogs".
    """
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


def named_muscles() -> list[str]:
    """Names of the examples, then of the measured muscles."""
    return [*shipped_names("examples"), *shipped_names("measured")]


def scenarios() -> dict[str, str]:
    """Descriptions of the named scenarios, by name."""
    return descriptions("scenarios")


def example_text(name: str) -> str:
    """Read the file of a named example.

    **Arguments:** `name`: one of `examples()`, `scenarios()` or the catalog of measured muscles.

    **Returns:** the TOML with its comments.

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    kinds = {
        key: kind for kind in ("scenarios", "measured", "examples") for key in shipped_names(kind)
    }
    if name not in kinds:
        similar = difflib.get_close_matches(str(name), kinds, n=1, cutoff=_SIMILARITY)
        hint = f"choose one of {', '.join(sorted(kinds))}."
        hint = f"did you mean {similar[0]}?" if similar else hint
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return shipped_text(kinds[name], name)
