"""Outputs that would replace an input of the same command, or one another."""

import itertools
from collections.abc import Iterable, Mapping
from pathlib import Path

from .problems import UserError


FOLDERS = ("FOLDER", "DIR")
OUTPUTS = ("PATH", *FOLDERS)  # what options that name an output call their value in the help


def check_collisions(
    inputs: Iterable[str],
    outputs: Mapping[str, str],
    filled: Iterable[str] = (),
    overwrite: bool = False,
    flag: str = "",
) -> None:
    """Refuse outputs that share a place, and those that stand where an input does.

    **Arguments:**

    - `inputs`: paths and other words that a command was given to read [-].
    - `outputs`: where its outputs go, by option [-].
    - `filled`: options whose folder holds this command's output alone [-].
    - `overwrite`: whether an output may replace an input [-].
    - `flag`: the option that says so [-]; empty where there is none.

    **Raises:** `UserError`, one line.
    """
    places = {option: _resolved(path) for option, path in outputs.items()}
    for (one, here), (other, there) in itertools.combinations(places.items(), 2):
        if here is not None and here == there:
            raise UserError(f"{one} and {other}: both would write {outputs[one]}: name two places.")
    for folder in {*filled} & {*places}:
        for option, place in places.items():
            if place is not None and places[folder] in place.parents:
                raise UserError(
                    f"{option} {outputs[option]}: lies in the folder of {folder}, which holds only"
                    " its own files: name another place."
                )
    if overwrite:
        return
    read = {_resolved(text) for text in inputs} - {None}
    for option, place in places.items():
        if place in read:
            more = f", or {flag} replaces it" if flag else ""
            raise UserError(
                f"{option} {outputs[option]}: is read by this command: name another file{more}."
            )


def _resolved(text: str) -> Path | None:
    """Where a path leads, links followed; `None` for words that are none."""
    try:
        return Path(text).resolve()
    except (OSError, RuntimeError, ValueError):  # too long, a loop of links, a NUL
        return None
