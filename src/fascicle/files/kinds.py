"""What kind of file one is, where another kind was due, and which command takes it."""

from collections.abc import Mapping
from typing import Any

from .faults import line


# keys that only such a file has, save a scenario's muscle and bundle
_MARKS = {
    "scenario": ("load", "supply", "run", "schedule"),
    "task": ("task", "design"),
    "muscle or bundle": ("muscle", "bundle"),
}
_TAKEN = {
    "scenario": "`fascicle simulate` runs it",
    "task": "`fascicle design` takes it",
    "muscle or bundle": "`fascicle force` and `fascicle bundle` take it",
}


def check_kind(data: Mapping[str, Any], wanted: str, source: str) -> None:
    """Refuse a file of another kind.

    **Arguments:**

    - `data`: the file's tables [-].
    - `wanted`: "muscle or bundle", "scenario" or "task" [-].
    - `source`: what to call the file in an error [-].

    **Raises:** `ValueError`, one line, where its tables are those of another kind alone.
    """
    # a scenario has muscles as well: these don't tell it from their own file
    if wanted != "muscle or bundle" and any(key in data for key in _MARKS[wanted]):
        return
    for kind, keys in _MARKS.items():
        found = next((key for key in keys if key in data), None)
        if kind != wanted and found is not None:
            raise ValueError(line(source, [found], f"a {kind}, not a {wanted}: {_TAKEN[kind]}."))
