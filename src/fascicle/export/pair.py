"""What is written as a header and its source: of what, by which name, and where."""

import re
from pathlib import Path

from ..bundle import Bundle, MotorUnit
from ..core.checks import concrete
from ..core.refused import Refused
from ..core.types import Values
from ..muscle import Muscle


def checked_name(name: str) -> str:
    """A `name` [-] as it is [-], refused where C can't have it."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", name):
        rule, remedy = "must be a name in C", "up to 31 letters, digits and _, a letter first"
        raise Refused("name", rule, None, f"{remedy}, got {name[:40]!r}")
    return name


def checked_bundle(target: Muscle | Bundle, kinds: str = "a Muscle or a Bundle") -> Bundle:
    """A `target` [-] as a bundle [-]; arrays, and what isn't of these `kinds` [-], are refused."""
    if not isinstance(target, Muscle | Bundle):
        raise Refused("target", f"must be {kinds}", target)
    bundle = target if isinstance(target, Bundle) else Bundle([MotorUnit(target)])
    if not concrete(target) or any(not unit.muscle._is_single for unit in bundle.motor_units):
        raise Refused("target", "must hold numbers, one for each size", None, shown="arrays")
    return bundle


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
