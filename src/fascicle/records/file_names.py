"""Constants in the names of files, such as `run_150kPa.csv`, and patterns that read them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..core.errors import InvalidInputError
from ..units import parse
from .headers import CONSTANTS, MissingMetadataError, dimension_of
from .units import SPELLINGS, weight_unit


_PATTERN_NAMES = (*CONSTANTS, "rest_length")
_UNITS = {"pressure": "kPa|mbar|bar|psi|MPa", "length": "mm|cm|in", "force": "kgf|gf|N|kg|g"}


def read_name(path: Path, pattern: str, table: str = "") -> dict[str, float]:
    """Constants [SI] that the name of a `table` in a file, or the file's name and it, holds where
    the `pattern` has their names in braces.

    The unit stands after the braces, or in them: `{length}cm`, `{pressure:kPa}`; grams and the
    like of a force are weights.
    """
    # text, and after each piece of it a name, its unit in the braces, and the unit behind them
    *pieces, end = re.split(r"\{(\w+)(?::([^}]*))?\}(?=([^\W\d_]*%?))", pattern)
    expression, fields = "", []
    for text, name, inside, behind in zip(*(pieces[i::4] for i in range(4)), strict=True):
        expression += _wildcard_expression(text) + r"([+-]?\d+(?:[.,]\d+)?)"
        fields.append((name, inside or behind))
        if name not in _PATTERN_NAMES:
            hint, rule = f"choose of {', '.join(_PATTERN_NAMES)}", f"has the unknown name {name!r}"
            raise InvalidInputError("name_pattern", rule, name, f"{hint}; * is other text", "")
    if not fields:
        hint = 'write such as "{length}cm_{pressure}kPa"'
        raise InvalidInputError("name_pattern", "has no name in braces", pattern, hint)
    expression += _wildcard_expression(end)
    match = re.search(expression, table) or re.search(expression, f"{path.stem} {table}".rstrip())
    if match is None:
        what = (
            f"neither table `{table}` nor its name with the file's fits"
            if table
            else ("the file's name doesn't fit")
        )
        raise ValueError(f"{path}: {what} the pattern {pattern!r}.")
    values = {}
    for (name, unit), text in zip(fields, match.groups(), strict=True):
        dimension = dimension_of(name)
        number = f"{text.replace(',', '.')} {weight_unit(unit, dimension) or unit}"
        values[name] = parse(number, dimension, name)
    return values


def _wildcard_expression(text: str) -> str:
    return re.escape(text).replace(r"\*", ".*").replace(r"\?", ".")


def suggest_pattern(name: str, role: str) -> str:
    """Pattern that reads a quantity with a unit in a file's `name`; empty without one."""
    # 1_0bar may be 1.0 bar
    number = r"(-?)(?<![\d.,])(?:\d+[.,]\d+|\d{2,}|(?<!\d_)\d)"
    match = re.search(rf"{number}(\s*)({_UNITS[role]})(?![a-z])", name, re.IGNORECASE)
    if match is None:
        return ""
    minus, blank, unit = match.groups()
    usual = weight_unit(unit, role) or SPELLINGS[role][unit.lower()]
    is_clear = (unit == usual or usual in ("gf", "kgf")) and not blank
    return f"{minus}{{{role}{'' if is_clear else f':{usual}'}}}{blank}{unit}"


def pressure_in_name(path: Path, table: str = "") -> float | None:
    """Pressure [Pa] that the name of a file, or of a `table` in it, states; `None` without one."""
    pattern = suggest_pattern(table or path.stem, "pressure")
    return read_name(path, pattern, table)["pressure"] if pattern else None


def check_pressures_in_names(
    files: Sequence[Path], constants: Mapping[str, Any] | None, tables: Sequence[str] = ("",)
) -> None:
    """Refuse one pressure of all readings of `files`, or of the `tables` in a file, whose names
    state several.
    """
    if "pressure" not in (constants or {}):
        return
    names = [(path, table) for path in files for table in tables]
    if len({pressure_in_name(*name) for name in names} - {None}) > 1:
        patterns = (suggest_pattern(table or path.stem, "pressure") for path, table in names)
        before = f"{files[0]}: one pressure was given, the names state several: give "
        choice = ("name_pattern", "", next(filter(None, patterns)), " instead")
        raise MissingMetadataError(before, choice)
