"""Where a muscle comes from, as the `[calibration]` of its file.

What stands there is a report for readers and programs, not part of the muscle: loading passes
over it. It may hold anything that TOML can, one table deep, so it is written here by type.
"""

import json
from collections.abc import Mapping
from typing import Any


_TABLE = "calibration"


def calibration_lines(calibration: Mapping[str, Any]) -> list[str]:
    """The lines of a `[calibration]` that read back to the same values.

    **Arguments:** `calibration`: text, numbers, booleans and lists of them by key, and one
    level of tables or lists of tables [-].

    **Returns:** the lines [-], its tables last.

    **Raises:** `ValueError` for what TOML has no value for, and for deeper tables.
    """
    plain, tables = [], []
    for key, value in calibration.items():
        name = f"{_TABLE}.{_text(key)}"
        if isinstance(value, Mapping):
            tables += ["", f"[{name}]", *_entries(value)]
        elif _is_tables(value):
            for table in value:
                tables += ["", f"[[{name}]]", *_entries(table)]
        else:
            plain += _entries({key: value})
    return [f"[{_TABLE}]", *plain, *tables]


def _is_tables(value: Any) -> bool:
    entries = value if isinstance(value, list | tuple) else ()
    return len(entries) > 0 and all(isinstance(entry, Mapping) for entry in entries)


def _entries(table: Mapping[str, Any]) -> list[str]:
    return [f"{_text(key)} = {_value(value, key)}" for key, value in table.items()]


def _value(value: Any, key: str) -> str:
    if hasattr(value, "tolist"):  # NumPy's and JAX's scalars and arrays
        value = value.tolist()
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(entry, key) for entry in value)}]"
    raise ValueError(
        f"`{_TABLE}` takes text, numbers, booleans, lists and one level of tables,"
        f" got a {type(value).__name__} for {key!r}."
    )


def _text(key: str) -> str:
    """A key, bare where TOML lets it be."""
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else _quoted(key)


def _quoted(text: str) -> str:
    # TOML's strings are JSON's, but for DEL
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
