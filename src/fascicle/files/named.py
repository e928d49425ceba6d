"""The named examples: muscles and bundles of the literature, each a file with its source."""

import difflib
from typing import TYPE_CHECKING

from .shipped import abouts, names, text


if TYPE_CHECKING:
    from ..bundle import Bundle
    from ..muscle import Muscle

_KIND = "examples"


def examples() -> dict[str, str]:
    """The named muscles and bundles.

    **Returns:** a line about each, by name [-].
    """
    return abouts(_KIND)


def example_text(name: str) -> str:
    """The file of a named example.

    **Arguments:** `name`: one of `examples()` [-].

    **Returns:** the TOML with its comments [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    known = names(_KIND)
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(known)}."
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return text(_KIND, name)


def example(name: str) -> "Muscle | Bundle":
    """A named muscle or bundle.

    **Arguments:** `name`: one of `examples()` [-].

    **Returns:** the muscle or bundle [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    from .reading import loads

    return loads(example_text(name), source=name)
