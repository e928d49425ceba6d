"""TOML files that are shipped: examples, and catalogs of products. Each begins with a line about
itself.
"""

from importlib.resources import files


def names(kind: str) -> list[str]:
    """What is shipped of a `kind` [-], "examples" or "catalogs": names [-], sorted."""
    folder = files("fascicle.files") / kind
    every = [file.name for file in folder.iterdir()]
    return sorted(name.removesuffix(".toml") for name in every if name.endswith(".toml"))


def text(kind: str, name: str) -> str:
    """The file of a `kind` [-] that has a `name` [-], with its comments [-]."""
    path = files("fascicle.files") / kind / f"{name}.toml"
    return path.read_text(encoding="utf-8")


def abouts(kind: str) -> dict[str, str]:
    """A line about each of a `kind` [-], by name [-]."""
    return {name: text(kind, name).partition("\n")[0].lstrip("# ") for name in names(kind)}
