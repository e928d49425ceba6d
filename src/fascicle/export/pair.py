"""A header and its source: the name that both begin with, and where they are written."""

import re
from pathlib import Path

from ..core.refused import Refused
from ..core.types import Values


def checked_name(name: str) -> str:
    """A `name` [-] as it is [-], refused where C can't have it."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", name):
        rule, remedy = "must be a name in C", "up to 31 letters, digits and _, a letter first"
        raise Refused("name", rule, None, f"{remedy}, got {name[:40]!r}")
    return name


def write_pair(texts: tuple[str, str], folder: Values, name: str) -> tuple[Path, Path]:
    """Write the `texts` [-] of header and source as `name` [-] into a `folder` [-], made where it
    isn't; their paths [-].
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / f"{name}.h", folder / f"{name}.c"
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    return paths
