"""The named examples: muscles and bundles of the literature, each a file with its source."""

import difflib
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from ..bundle import Bundle
    from ..muscle import Muscle


def examples() -> dict[str, str]:
    """The named muscles and bundles.

    **Returns:** a line about each, by name [-].
    """
    # the first line of each is its description
    return {name: example_text(name).partition("\n")[0].lstrip("# ") for name in _names()}


def example_text(name: str) -> str:
    """The file of a named example.

    **Arguments:** `name`: one of `examples()` [-].

    **Returns:** the TOML with its comments [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    known = _names()
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(known)}."
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return (_folder() / f"{name}.toml").read_text(encoding="utf-8")


def example(name: str) -> "Muscle | Bundle":
    """A named muscle or bundle.

    **Arguments:** `name`: one of `examples()` [-].

    **Returns:** the muscle or bundle [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    from .reading import loads

    return loads(example_text(name), source=name)


def _folder() -> Traversable:
    return files("fascicle.describe") / "examples"


def _names() -> list[str]:
    return sorted(
        file.name.removesuffix(".toml")
        for file in _folder().iterdir()
        if file.name.endswith(".toml")
    )
